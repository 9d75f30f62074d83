//! Branches of orbits by shooting.

use crate::branches::branch::Branch;
use crate::branches::branch_error::BranchError;
use crate::branches::continuation::Continuation;
use crate::branches::curve::engine::Engine;
use crate::branches::family::Family;
use crate::branches::following::Following;
use crate::branches::orbits::by_shooting::orbit_curve::OrbitCurve;
use crate::branches::orbits::orbit_method::OrbitMethod;
use crate::branches::points::branch_point::BranchPoint;
use crate::branches::starts::start::{Resume, Start};
use crate::branches::steps::stepper::Stepper;
use crate::model::State;
use crate::periodic::ShootingOrbit;
use std::rc::Rc;

/// From one state, several, or `None`, the static state.
impl<'g, G: IntoIterator<Item = &'g State>> Start for G {
    type Point = BranchPoint;

    fn begin<'f>(
        self,
        settings: &'f Continuation,
        family: &'f Family<'f>,
    ) -> Result<Following<'f>, BranchError> {
        settings.begin_near(family, &self.into_iter().collect::<Vec<_>>())
    }
}

impl Start for &ShootingOrbit {
    type Point = BranchPoint;

    fn begin<'f>(
        self,
        settings: &'f Continuation,
        family: &'f Family<'f>,
    ) -> Result<Following<'f>, BranchError> {
        let orbit = settings.shooting_of_branch()?.solve_from(&*family.at([settings.from])?, self)?;
        settings.track(family, settings.from, &orbit, settings.heading()).map(Following::new)
    }
}

impl Resume for BranchPoint {
    fn resume<'f>(
        &self,
        _: &Branch,
        heading: f64,
        settings: &'f Continuation,
        family: &'f Family<'f>,
    ) -> Result<Following<'f>, BranchError> {
        let mut line = settings.track(family, self.parameter, &self.orbit, heading)?;
        line.starts_anywhere()?;
        Ok(Following::new(line))
    }
}

impl Continuation {
    /// A branch from the orbit near these states.
    fn begin_near<'f>(
        &'f self,
        family: &'f Family<'f>,
        guess: &[&State],
    ) -> Result<Following<'f>, BranchError> {
        let orbit = self.shooting_of_branch()?.solve(&*family.at([self.from])?, guess.iter().copied())?;
        self.track(family, self.from, &orbit, self.heading()).map(Following::new)
    }

    /// A branch from an orbit. `heading`: sign of the first change of the parameter.
    pub(crate) fn track<'f>(
        &'f self,
        family: &'f Family<'f>,
        p: f64,
        orbit: &ShootingOrbit,
        heading: f64,
    ) -> Result<Stepper<'f, OrbitCurve<'f>>, BranchError> {
        let mut engine = self.shooting_engine(family, p, orbit)?;
        let x = engine.curve.unknowns(orbit);
        let point = engine.start_towards(x, p, heading)?;
        self.follow(engine, point)
    }

    pub(crate) fn shooting_engine<'f>(
        &'f self,
        family: &'f Family<'f>,
        p: f64,
        orbit: &ShootingOrbit,
    ) -> Result<Engine<OrbitCurve<'f>>, BranchError> {
        let (meter, shooting) = (Rc::new(self.budget.begin()), self.shooting_of_branch()?);
        let unit = self.unit();
        let curve = OrbitCurve::new(family.clone(), (p, unit), orbit, &shooting, meter)?;
        let curve = curve.with_stability(self.stability_or_default());
        let tolerance = shooting.tolerance;
        Ok(Engine { curve, unit, tolerance, max_corrections: 10, at_crossing: false })
    }
}
