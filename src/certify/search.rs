//! The search for boxes around an orbit that prove it.

use crate::certify::certificate::Certificate;
use crate::certify::chain::proposal::Proposal;
use crate::certify::contraction::Defect;
use crate::certify::flow::field::Field;
use crate::certify::images::{Images, field};
use crate::certify::unproved::Unproved;
use crate::error::check;
use crate::interval::number::Interval;
use crate::model::{Periodic, State};
use crate::ode::budget::Meter;
use crate::periodic::ShootingOrbit;

/// Half widths of the first boxes, and the largest ones that are tried, as shares of the size of the motion
/// `[1]`.
const FIRST_RADIUS: f64 = 1e-13;
const LARGEST_RADIUS: f64 = 1.0;

/// Number of times that the boxes are enclosed, and of those after which the nodes may still move.
const ATTEMPTS: usize = 10;
const MOVES: usize = 4;

/// Shares of the steps that are tried, one after the other, if a motion has no enclosure over a step.
const STEPS: [f64; 3] = [1.0, 0.5, 0.25];

/// Newton corrections above this share of the size of the motion lead to another orbit `[1]`.
const FARTHEST: f64 = 0.1;

/// Newton corrections below this share of the half widths leave the nodes where they are `[1]`.
const NEGLIGIBLE: f64 = 0.1;

/// Least size of the motion, as a share of the coordinates `[1]`: boxes narrower than the rounding of the
/// coordinates cannot be proved.
const AT_REST: f64 = 1e-3;

impl ShootingOrbit {
    /// Proves that the orbit exists: in small boxes around it there is exactly one periodic orbit of the
    /// model, it makes exactly these crossings, and its multipliers lie in these discs.
    ///
    /// The [budget](ShootingOrbit::budget) of the orbit limits the number of steps that are enclosed and the
    /// time of the call.
    ///
    /// # Errors
    /// [`Unproved`]: what could not be shown.
    pub fn certify(&self, model: &dyn Periodic) -> Result<Certificate, Unproved> {
        self.certify_with(model, &[])
    }

    /// [`certify`](ShootingOrbit::certify) for all values of some constants within intervals: for each of
    /// them there is exactly one orbit in the boxes.
    ///
    /// # Errors
    /// As there; a name that the model does not have.
    pub fn certify_with(
        &self,
        model: &dyn Periodic,
        constants: &[(&str, Interval)],
    ) -> Result<Certificate, Unproved> {
        check::length("coordinates of the orbit", self.states()[0].q.len(), model.dof())?;
        let meter = self.budget.begin();
        let field = field(model, constants, self.multipliers().values().len() < 2 * model.dof())?;
        let mut failure = Unproved::NotContracting { t: self.states()[0].t, needed: f64::INFINITY };
        for shorter in STEPS {
            match self.search(model, &field, constants, shorter, &meter) {
                Err(error @ Unproved::Wrapping { .. }) => failure = error,
                other => return other,
            }
        }
        Err(failure)
    }

    /// Boxes that grow until they are proved, around nodes with a share of the full steps between them.
    fn search(
        &self,
        model: &dyn Periodic,
        field: &Field<'_>,
        constants: &[(&str, Interval)],
        shorter: f64,
        meter: &Meter<'_>,
    ) -> Result<Certificate, Unproved> {
        let size = self.size(field);
        let mut proposal = Proposal::along(self, model, field, &size, shorter, meter)?;
        let mut radii =
            vec![size.iter().map(|r| FIRST_RADIUS * r).collect::<Vec<f64>>(); proposal.legs.len()];
        let mut failure = Unproved::NotContracting { t: self.states()[0].t, needed: f64::INFINITY };
        for attempt in 0..ATTEMPTS {
            let images = Images::new(model, field, &proposal, &radii, meter, &mut |_| {})?;
            // The nodes move as long as the boxes are too narrow for their errors.
            let corrections = images.newton().corrections().filter(|corrections| {
                let pairs = corrections.iter().flatten().zip(radii.iter().flatten());
                attempt < MOVES && pairs.into_iter().any(|(dx, radius)| dx.abs() > NEGLIGIBLE * radius)
            });
            let bounds = match corrections {
                None => {
                    let bounds = images.bounds(Defect::Whole)?;
                    match images.inclusion(&bounds) {
                        Ok(()) => {
                            let (crossings, multipliers) = (images.crossings.clone(), images.multipliers());
                            let constants =
                                constants.iter().map(|(name, value)| (name.to_string(), *value)).collect();
                            let period = field.drives.period() * self.period_multiple() as f64;
                            return Ok(Certificate {
                                proposal,
                                radii,
                                constants,
                                period,
                                crossings,
                                multipliers,
                            });
                        }
                        Err(error) => failure = error,
                    }
                    bounds
                }
                Some(corrections) => {
                    let bounds = images.bounds(Defect::Width)?;
                    let shares = corrections.iter().flat_map(|dx| dx.iter().zip(&size));
                    let share = shares.map(|(dx, size)| dx.abs() / size).fold(0.0, f64::max);
                    if share > FARTHEST {
                        break;
                    }
                    let moved = proposal.nodes.iter_mut().flatten().zip(corrections.iter().flatten());
                    moved.for_each(|(x, dx)| *x += dx);
                    bounds
                }
            };
            let mut share = 0.0f64;
            for (radii, bounds) in radii.iter_mut().zip(&bounds) {
                for ((radius, bound), size) in radii.iter_mut().zip(bounds).zip(&size) {
                    *radius = (2.0 * bound).max(*radius);
                    share = share.max(*radius / size);
                }
            }
            if share.is_nan() || share > LARGEST_RADIUS {
                break;
            }
        }
        Err(failure)
    }

    /// Size of the motion: the ranges of coordinates and velocities, at least those of rounding if the orbit
    /// is almost at rest.
    fn size(&self, field: &Field<'_>) -> Vec<f64> {
        let (n, all) = (field.n, self.range().len() / 2);
        let range: Vec<f64> = match &field.relative {
            None => self.range().to_vec(),
            Some(relative) => self.range().chunks(all).flat_map(|range| relative.ranges(range)).collect(),
        };
        let halves = |state: &State| match &field.relative {
            None => [state.q.clone(), state.v.clone()],
            Some(relative) => [&state.q, &state.v].map(|x| relative.coordinates(x)),
        };
        let states: Vec<[Vec<f64>; 2]> = self.states().iter().map(halves).collect();
        let least = |half: usize, i: usize| {
            AT_REST * states.iter().map(|state| state[half][i].abs()).fold(0.0, f64::max)
        };
        let coordinates: Vec<f64> =
            (0..n).map(|i| range[i].max(least(0, i)).max(f64::MIN_POSITIVE)).collect();
        let velocities = (0..n).map(|i| {
            range[n + i].max(least(1, i)).max(coordinates[i] / self.period()).max(f64::MIN_POSITIVE)
        });
        coordinates.iter().copied().chain(velocities).collect()
    }
}
