//! The least figure of an orbit over constants of its model.

use crate::branches::design::objective::DesignError;
use crate::branches::design::orbit_finder::OrbitFinder;
use crate::branches::design::search::{Search, Space};
use crate::branches::sensitivity::figure::Figure;
use crate::branches::sensitivity::sensitivity_of_orbit::Sensitivity;
use crate::model::{Periodic, State};
use crate::periodic::ShootingOrbit;
use std::cell::RefCell;
use std::rc::Rc;

/// Minimises a figure of a periodic orbit over named constants within bounds.
///
/// Gradients are those of [`Sensitivity`], exact along the orbit. The optimiser is SLSQP. A local minimum is
/// found; at a change of the contact sequence the figure has a kink.   Source: Kraft (1988), as in NLopt.
///
/// ```
/// use gear_dynamics::{State, branches::{Figure, Least}, trains::SpurPair};
/// let pair = SpurPair::of_numbers(0.05, 0.1, &[], &[0.02])?.parts()?.build("driver", 0.7)?;
/// let least = Least::new("deflection", Figure::PeakToPeak).over("mesh damping", 0.02, 0.3);
/// let best = least.run(&pair, &State::new(0.0, &[1.1], &[0.0]))?;
/// assert!((best.constants[0].1 - 0.3).abs() < 1e-9); // the largest damping moves the teeth least
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type Least = Search<Minimised>;

/// What a [`Least`] minimises.
#[derive(Clone, Debug, PartialEq)]
pub struct Minimised {
    channel: String,
    figure: Figure,
}

/// The result of [`Least`] or [`Fit`](crate::branches::Fit).
///
/// ```
/// # use gear_dynamics::{State, branches::{Figure, Least}, trains::SpurPair};
/// # let pair = SpurPair::of_numbers(0.05, 0.1, &[], &[0.02])?.parts()?.build("driver", 0.7)?;
/// # let least = Least::new("deflection", Figure::Max).over("mesh damping", 0.02, 0.3);
/// let best = least.run(&pair, &State::new(0.0, &[1.1], &[0.0]))?;
/// assert!(best.value > 0.0 && best.evaluations < 20);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Optimum {
    /// Names and values of the constants.
    pub constants: Vec<(String, f64)>,
    /// The figure; for a fit the sum of the squares of the relative deviations.
    pub value: f64,
    /// Number of orbits that were measured with their derivatives.
    pub evaluations: usize,
    /// The orbit of the optimum; for a fit that of the last measured point.
    pub orbit: ShootingOrbit,
}

impl Least {
    /// The least `figure` of a channel (see [`Probe`](crate::ode::Probe)).
    ///
    /// Defaults: a tolerance of 1e-8, 200 evaluations, default [`Shooting`](crate::Shooting) and
    /// [`Budget`](crate::Budget).
    pub fn new(channel: &str, figure: Figure) -> Self {
        Search::of(Minimised { channel: channel.into(), figure }, 0.0)
    }
    /// Searches from the constants of `model` and the orbit near a guess (see
    /// [`Shooting::solve`](crate::Shooting::solve)).
    ///
    /// # Errors
    /// [`DesignError`]; if the optimiser does not converge, the error holds the best constants.
    pub fn run<'g>(
        &self,
        model: &dyn Periodic,
        guess: impl IntoIterator<Item = &'g State>,
    ) -> Result<Optimum, DesignError> {
        let constants = model.offers().named()?;
        let (space, start) = Space::new(constants, &self.over)?;
        let meter = Rc::new(self.budget.begin());
        let of = OrbitFinder { shooting: &self.shooting, meter: &meter };
        let orbit = of.first(model, guess)?;
        let last = RefCell::new((space.values(&start), orbit));
        let best: RefCell<Option<(f64, ShootingOrbit)>> = RefCell::new(None);
        let evaluate = |x: &[f64]| -> Result<(f64, Vec<f64>), DesignError> {
            let values = space.values(x);
            let mut last = last.borrow_mut();
            let orbit = of.reach(constants, &last.1, &last.0, &values)?;
            let model = constants.with_values(&values)?;
            let value = self.objective.figure.value(&*model, &orbit, &self.objective.channel)?;
            let sensitivity =
                Sensitivity::within(&*model, &orbit, &[&self.objective.channel], meter.clone())?;
            let all = sensitivity.slopes(self.objective.figure, &self.objective.channel)?;
            let mut best = best.borrow_mut();
            if best.as_ref().is_none_or(|(least, _)| value < *least) {
                *best = Some((value, orbit.clone()));
            }
            *last = (values, orbit);
            Ok((value, space.gradient(all)))
        };
        let found = self.minimise(&space, &start, &evaluate)?;
        let orbit = best.into_inner().map_or_else(|| last.into_inner().1, |(_, orbit)| orbit);
        let constants = space.named(&found.x);
        Ok(Optimum { constants, value: found.value, evaluations: found.evaluations, orbit })
    }
}
