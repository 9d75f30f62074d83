//! Branches that come back from infinity.

use crate::branches::branch::Branch;
use crate::branches::branch_end::BranchEnd;
use crate::branches::branch_error::BranchError;
use crate::branches::continuation::Continuation;
use crate::branches::family::Family;
use crate::branches::following::Following;
use crate::branches::points::branch_point::BranchPoint;
use crate::branches::starts::start::Start;
use crate::model::State;
use crate::numeric::norms::dot;

/// Distances from the border at which the motion is looked for, as shares of that of the last point `[1]`.
const DISTANCES: [f64; 3] = [1.0, 0.25, 4.0];

/// Least size of an orbit that comes back from infinity, as a share of the last orbit `[1]`.
const LARGE: f64 = 0.02;

/// The branch that comes back from infinity where this branch ends at a border of parametric instability
/// ([`BranchEnd::Unbounded`]), as a [`Start`].
///
/// Near the border the motion is A u(t) with a homogeneous solution u of the system without gaps and A ~ (f +
/// g)/(p - p*): f is the projection of load and excitation, g that of the gap forces, which change their sign
/// with A. The branch passes through infinity to the motions -A u(t). Where |f| > |g| they lie on the other
/// side of the border, otherwise on the same side. Both sides are tried, at the distance of the last point
/// from the border, at a quarter of it and at four times it. The continuation leads away from the border; its
/// bounds must contain the start.
///
/// ```
/// use gear_dynamics::branches::{Beyond, Continuation, Family};
/// use gear_dynamics::{Dop853, Model, Settle, State, trains::SpurPair};
/// let parts = SpurPair::of_numbers(0.025, 0.52, &[-0.18, 0.24], &[0.0, -0.075])?.parts()?;
/// let pair = parts.build("driver", 0.5)?;
/// let family = Family::over(&pair, ["speed"])?;
/// let settled = Settle::new().run(&Dop853::new(), &pair, &State::at_rest(pair.dof()))?;
/// let range = Continuation::new(0.5, 2.4);
/// let branch = range.run(&family, &settled.state)?;
/// let first = range.begin(&family, Beyond(&branch))?.next().ok_or("a point")?;
/// assert!(first.peak_to_peak() > 5000.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`BranchError::NoBorder`] for a branch with another end; [`BranchError::NoReturn`] if no large orbit of
/// the opposite sign is found within the bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beyond<'b>(pub &'b Branch);

impl Start for Beyond<'_> {
    type Point = BranchPoint;

    fn begin<'f>(
        self,
        settings: &'f Continuation,
        family: &'f Family<'f>,
    ) -> Result<Following<'f>, BranchError> {
        let Beyond(branch) = self;
        let BranchEnd::Unbounded { border: Some(border), .. } = branch.end else {
            return Err(BranchError::NoBorder { end: Box::new(branch.end.clone()) });
        };
        let last = branch.points.last().ok_or(BranchError::NoPoints)?;
        let opposite = |state: &State, size: f64| State {
            t: state.t,
            q: state.q.iter().map(|q| -size * q).collect(),
            v: state.v.iter().map(|v| -size * v).collect(),
        };
        let shooting = settings
            .shooting_of_branch()?
            .budget(settings.budget.clone())
            .period_multiple(last.orbit.period_multiple());
        let mut failure = None;
        for share in DISTANCES.iter().flat_map(|share| [-share, *share]) {
            let p = border + share * (last.parameter - border);
            // There may be no model beyond the border, or none within the bounds.
            let (Ok(model), Ok(())) = (family.at([p]), settings.check_start(p)) else { continue };
            // On another branch the phases of the nodes are the same, their times are not.
            let times = model.period() * last.orbit.period_multiple() as f64 / last.orbit.period();
            let guess: Vec<State> = last
                .orbit
                .states()
                .iter()
                .map(|s| State { t: s.t * times, ..opposite(s, 1.0 / share.abs()) })
                .collect();
            match shooting.solve(&*model, &guess) {
                Ok(orbit) => {
                    let (found, wanted) = (&orbit.states()[0], &guess[0]);
                    let places = |state: &State| -> Vec<f64> {
                        let parts = state.q.iter().chain(&state.v).zip(last.orbit.range());
                        parts.map(|(x, range)| if *range > 0.0 { x / range } else { 0.0 }).collect()
                    };
                    let [found, wanted] = [found, wanted].map(places);
                    if dot(&found, &wanted) > LARGE * dot(&wanted, &wanted) {
                        let mut line = settings.track(family, p, &orbit, p - border)?;
                        line.starts_anywhere()?;
                        return Ok(Following::new(line));
                    }
                }
                Err(error) => failure = Some(error),
            }
        }
        Err(BranchError::NoReturn { border, error: failure.map(Box::new) })
    }
    fn goes_both_ways(&self) -> bool {
        false
    }
}
