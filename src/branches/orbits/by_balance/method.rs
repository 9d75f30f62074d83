//! The harmonic balance as the method of a continuation.

use crate::branches::curve::equations::CurveError;
use crate::branches::curve::point::CurvePoint;
use crate::branches::family::Family;
use crate::branches::orbits::by_balance::balance_curve::{BalanceCurve, Series};
use crate::branches::orbits::by_balance::series_measure::measure_series;
use crate::branches::orbits::measured::Measured;
use crate::branches::orbits::orbit_method::{OrbitMethod, Orbits};
use crate::branches::stability_method::StabilityMethod;
use crate::model::{Channel, State};
use crate::periodic::{FourierOrbit, Multipliers};
use crate::roots::Residual;
use nalgebra::DVector;

/// Coefficients up to this share of the range of motion count as zero.
const ZERO_COEFFICIENT: f64 = 1e-6;

impl Orbits for BalanceCurve<'_> {
    type Orbit = FourierOrbit;

    fn multipliers(&self, point: &CurvePoint<Series>) -> Option<Multipliers> {
        // Those of the equation say nothing on the doublings of a balance with truncated forces.
        let wanted = self.is_of_equation && self.stability == StabilityMethod::Multipliers;
        wanted.then(|| self.multipliers_along(point)).flatten()
    }

    fn predicts_from_two_points(&self) -> bool {
        true
    }

    fn orbit(&self, point: &CurvePoint<Series>) -> Result<(FourierOrbit, Multipliers), CurveError> {
        let corrections = &point.corrections;
        let orbit = self.evaluated(point, |equations, _| {
            let mut residual = vec![0.0; point.x.len()];
            equations.residual(point.x.as_slice(), &mut residual);
            let mut orbit = equations.orbit(point.x.as_slice());
            orbit.residual = crate::numeric::norms::largest(&residual);
            (orbit.iterations, orbit.evaluations) = (corrections.len(), corrections.len());
            orbit.notes = equations.notes();
            orbit
        })?;
        self.meter.left()?;
        let none = || CurveError::NotConverged { corrections: corrections.clone() };
        let multipliers = match self.stability {
            StabilityMethod::Skipped => Multipliers::new(Vec::new(), f64::INFINITY),
            StabilityMethod::Multipliers => self.multipliers_along(point).ok_or_else(none)?,
        };
        Ok((orbit, multipliers))
    }

    fn first_state(&self, point: &CurvePoint<Series>) -> Option<(usize, State)> {
        let orbit = self.evaluated(point, |equations, _| equations.orbit(point.x.as_slice())).ok()?;
        Some((orbit.harmonics().period_multiple(), orbit.at(0.0)))
    }

    fn measure(&self, point: &CurvePoint<Series>, channels: &[Channel]) -> Result<Measured, CurveError> {
        let places = if channels.is_empty() { Vec::new() } else { self.places(channels, point.p)? };
        self.evaluated(point, |equations, _| {
            let orbit = equations.orbit(point.x.as_slice());
            measure_series(equations, &orbit, &places)
        })
    }

    fn accept(&mut self, _: &CurvePoint<Series>, measured: &Measured) {
        self.ranges.clone_from(&measured.ranges);
        self.widths.accept(&measured.ranges);
    }
}

impl OrbitMethod for BalanceCurve<'_> {
    fn family(&self) -> &Family<'_> {
        self.family
    }

    fn unknowns(&self, orbit: &FourierOrbit) -> DVector<f64> {
        let found = self.equations.borrow_mut().here(|equations| equations.unknowns(orbit));
        DVector::from_vec(found.unwrap_or_default()) // the equations have the model of the first orbit
    }

    /// The multipliers are those of the equation along a truncated series: 1 is passed near a fold of the
    /// balance and not at it.
    fn multipliers_pass_at_folds(&self) -> bool {
        false
    }

    /// Whether the even orders vanish.
    fn is_symmetric(&self, point: &CurvePoint<Series>) -> bool {
        let vanish = self.equations.borrow_mut().here(|equations| {
            let harmonics = &equations.work.layout.harmonics;
            point.x.as_slice().chunks_exact(self.width).zip(&self.scales).zip(&self.ranges).all(
                |((part, scale), range)| {
                    harmonics.orders().iter().enumerate().filter(|(_, order)| *order % 2 == 0).all(
                        |(at, order)| {
                            let place = harmonics.place(at);
                            let both = &part[place..=place + usize::from(*order > 0)];
                            both.iter().all(|c| (c * scale).abs() <= ZERO_COEFFICIENT * range)
                        },
                    )
                },
            )
        });
        vanish.unwrap_or(false)
    }
}
