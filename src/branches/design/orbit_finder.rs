//! OrbitFinder of a model whose constants have moved far, within the budget of a search.

use crate::branches::design::objective::DesignError;
use crate::model::equations::Constants;
use crate::model::{Periodic, State};
use crate::ode::budget::Meter;
use crate::periodic::{Shooting, ShootingError, ShootingOrbit};

/// Shortest part of the way between two models that is tried `[1]`.
const SHORTEST_PART: f64 = 1.0 / 256.0;

/// Solves the orbits of a search, each within the budget of its [`Shooting`] while that of the search lasts.
pub(crate) struct OrbitFinder<'s> {
    pub(crate) shooting: &'s Shooting,
    /// The budget of the search.
    pub(crate) meter: &'s Meter<'s>,
}

impl OrbitFinder<'_> {
    /// The orbit near a guess.
    pub(crate) fn first<'g>(
        &self,
        model: &dyn Periodic,
        guess: impl IntoIterator<Item = &'g State>,
    ) -> Result<ShootingOrbit, DesignError> {
        let guess: Vec<State> = guess.into_iter().cloned().collect();
        self.solve(&|meter| self.shooting.find(model, &guess, meter))
    }

    /// The orbit of the model with the constants `to`, followed from that of the model with the constants
    /// `from` along the straight line between them. Parts of the line are halved where an orbit is not
    /// found.
    pub(crate) fn reach(
        &self,
        constants: &dyn Constants,
        orbit: &ShootingOrbit,
        from: &[(usize, f64)],
        to: &[(usize, f64)],
    ) -> Result<ShootingOrbit, DesignError> {
        let (mut at, mut part, mut orbit) = (0.0, 1.0f64, orbit.clone());
        while at < 1.0 {
            let next = (at + part).min(1.0);
            let blend = |(a, b): (&(usize, f64), &(usize, f64))| (a.0, a.1 + next * (b.1 - a.1));
            let values: Vec<(usize, f64)> = from.iter().zip(to).map(blend).collect();
            let model = constants.with_values(&values)?;
            match self.solve(&|meter| self.shooting.find_near(&*model, &orbit, meter)) {
                Ok(found) => {
                    (at, orbit) = (next, found);
                    part = (2.0 * part).min(1.0);
                }
                Err(DesignError::Shooting(error)) => {
                    part *= 0.5;
                    if part < SHORTEST_PART {
                        return Err(error.into());
                    }
                }
                Err(error) => return Err(error),
            }
        }
        Ok(orbit)
    }

    fn solve(
        &self,
        solve: &dyn Fn(&Meter<'_>) -> Result<ShootingOrbit, ShootingError>,
    ) -> Result<ShootingOrbit, DesignError> {
        self.meter.check()?;
        let found = solve(&self.shooting.meter(&|| self.meter.check().is_ok()));
        // An orbit that was given up because the search may not go on did not fail by itself.
        self.meter.left()?;
        Ok(found?)
    }
}
