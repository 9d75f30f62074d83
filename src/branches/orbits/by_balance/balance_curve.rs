//! The equations of a harmonic balance over a parameter.

use crate::branches::curve::equations::{Curve, CurveError, Linear, PARAMETER_STEP};
use crate::branches::curve::point::CurvePoint;
use crate::branches::family::Family;
use crate::branches::orbits::by_balance::balance_slope::BalanceSlope;
use crate::branches::orbits::by_balance::equations_over::{Any, At, EquationsOver};
use crate::branches::orbits::widths::Widths;
use crate::branches::stability_method::StabilityMethod;
use crate::model::Channel;
use crate::model::structure::drifts::Drifts;
use crate::ode::budget::Meter;
use crate::ode::probe::Probe;
use crate::periodic::balance::admission::drifts;
use crate::periodic::balance::amplitudes::sizes;
use crate::periodic::balance::quadrature::panel_points::drive_edges;
use crate::periodic::balance::quality::multipliers_of_series::{CrossingTime, Smooth};
use crate::periodic::{Balance, BalanceEquations, FourierOrbit, Integrals, Multipliers};
use crate::roots::{Matrix, Residual};
use nalgebra::{DMatrix, DVector};
use std::cell::{OnceCell, RefCell};
use std::rc::Rc;

/// R(x; p) = 0: the coefficients of q'' - a(u(t), q, q') at the kept orders, at fixed phases of the period
/// T(p).
///
/// Unknowns: those of the [`BalanceEquations`], with the scales of the first orbit on the whole branch.
pub(crate) struct BalanceCurve<'f> {
    pub(super) family: &'f Family<'f>,
    pub(super) equations: RefCell<EquationsOver<'f>>,
    /// Equations at a neighbouring parameter, for differences.
    beside: EquationsOver<'f>,
    slope: BalanceSlope,
    matrix: Matrix,
    /// Scales of the coordinates, the number of unknowns of one, and the sizes of the unknowns of drifts.
    pub(super) scales: Vec<f64>,
    pub(super) width: usize,
    drift_sizes: Vec<f64>,
    drifts: Drifts,
    /// Ranges of motion of the coordinates.
    pub(super) ranges: Vec<f64>,
    pub(super) widths: Widths,
    /// Step of the differences with respect to a parameter without exact derivative.
    difference: f64,
    /// Whether the equations have a continuous derivative.
    is_smooth: bool,
    /// Whether the balance is one of the equation: its error is small with many orders.
    pub(super) is_of_equation: bool,
    channels: RefCell<(Vec<Channel>, Vec<usize>)>,
    pub(super) stability: StabilityMethod,
    pub(super) meter: Rc<Meter<'f>>,
}

/// What is known of a point besides its unknowns.
#[derive(Clone)]
pub(crate) struct Series {
    /// Whether an acceleration jumps at a crossing.
    jumps: bool,
    multipliers: Rc<OnceCell<Option<Multipliers>>>,
}

/// A correction after which the next one would be rounding, by quadratic convergence.
const LAST: f64 = 1e-8;

/// Ranges below this share of the size of a coordinate are rounding: the size is the unit then.
const AT_REST: f64 = 1e-9;

impl<'f> BalanceCurve<'f> {
    /// The curve through an orbit of the model with the parameter `p`. `unit`: unit of the parameter.
    pub(crate) fn new(
        family: &'f Family<'f>,
        balance: &Balance,
        (p, unit): (f64, f64),
        orbit: &FourierOrbit,
        meter: Rc<Meter<'f>>,
    ) -> Result<Self, CurveError> {
        let near = Rc::new(orbit.clone());
        let mut equations = EquationsOver::new(family, balance, near.clone());
        let beside = EquationsOver::new(family, balance, near);
        let (matrix, scales, drift_sizes, drifts, integrals, width) =
            equations.at(p, |equations, At { model, .. }| {
                let layout = &equations.work.layout;
                let width = layout.harmonics.unknowns();
                let unknowns = equations.unknowns(orbit);
                // A mean speed may be far above the vibration.
                let size = |(k, x): (usize, &f64)| if k < layout.rigid { 1.0 } else { x.abs().max(1.0) };
                let drift_sizes = unknowns[layout.dof * width..].iter().enumerate().map(size).collect();
                (
                    equations.matrix(),
                    layout.scales.clone(),
                    drift_sizes,
                    drifts(model),
                    equations.integrals(),
                    width,
                )
            })?;
        let n = scales.len();
        let sampled = matches!(integrals, Integrals::Sampled { .. });
        let has_contacts = equations.at(p, |_, at| at.model.contacts() > 0)?;
        let swing = |j: usize| orbit.peak_to_peak(j);
        let ranges: Vec<f64> = (0..n).map(swing).chain(sizes(orbit)).collect();
        Ok(BalanceCurve {
            family,
            equations: RefCell::new(equations),
            beside,
            slope: BalanceSlope::new(),
            matrix,
            width,
            drift_sizes,
            drifts,
            widths: Widths::new(&ranges),
            ranges,
            scales,
            difference: PARAMETER_STEP * unit.max(p.abs()),
            is_smooth: !(sampled && has_contacts),
            is_of_equation: !balance.truncated_forces,
            stability: StabilityMethod::Multipliers,
            channels: RefCell::default(),
            meter,
        })
    }

    pub(crate) fn with_stability(self, stability: StabilityMethod) -> Self {
        BalanceCurve { stability, ..self }
    }

    /// Calls `work` with the equations at a point, after an evaluation there.
    pub(super) fn evaluated<R>(
        &self,
        point: &CurvePoint<Series>,
        work: impl for<'m> FnOnce(&mut BalanceEquations<'m>, &'m Any<'f>) -> R,
    ) -> Result<R, CurveError> {
        self.equations.borrow_mut().at(point.p, |equations, at| {
            equations.evaluate(point.x.as_slice(), false);
            work(equations, at.model)
        })
    }

    /// ∂R/∂p by one-sided differences.
    fn differences(
        &mut self,
        x: &DVector<f64>,
        p: f64,
        here: &DVector<f64>,
    ) -> Result<DVector<f64>, CurveError> {
        let mut there = DVector::zeros(x.len());
        let mut at =
            |p: f64| self.beside.at(p, |equations, _| equations.residual(x.as_slice(), there.as_mut_slice()));
        let mut beside = p + self.difference;
        if at(beside).is_err() {
            beside = p - self.difference;
            at(beside)?;
        }
        Ok((there - here) / (beside - p))
    }

    /// Indices of channels in the order of [`Probe`].
    pub(super) fn places(&self, channels: &[Channel], p: f64) -> Result<Vec<usize>, CurveError> {
        let mut known = self.channels.borrow_mut();
        if known.0 != channels {
            let names = channels.iter().map(|channel| &channel.name);
            let places = self.equations.borrow_mut().at(p, |_, at| Probe::new(at.model).indices(names))?;
            let places = places.map_err(|error| CurveError::Model { parameter: p, error })?;
            *known = (channels.to_vec(), places);
        }
        Ok(known.1.clone())
    }

    /// The multipliers of the equation along the series, computed once.
    pub(super) fn multipliers_along(&self, point: &CurvePoint<Series>) -> Option<Multipliers> {
        point.solution.multipliers.get_or_init(|| self.along(point)).clone()
    }

    fn along(&self, point: &CurvePoint<Series>) -> Option<Multipliers> {
        let found = self.evaluated(point, |equations, model| {
            if !equations.work.integration.follows_crossings() && model.contacts() > 0 {
                equations.work.crossings.locate(&mut equations.grid);
            }
            let orbit = equations.orbit(point.x.as_slice());
            let step = equations.grid.step();
            let crossings = || {
                let of = |crossing: CrossingTime| CrossingTime { time: crossing.time * step, ..crossing };
                equations.work.crossings.list().iter().map(move |crossing| of(crossing.into()))
            };
            let ends = |crossings: Vec<f64>| {
                let mut ends = drive_edges(model, orbit.period());
                ends.extend(crossings.into_iter().chain([0.0, orbit.period()]));
                ends.sort_by(f64::total_cmp);
                ends
            };
            let smooth =
                Smooth { breaks: ends(crossings().map(|s| s.time).collect()), jumps: point.solution.jumps };
            let again = |fewer: &FourierOrbit| fewer.crossings_near(model, crossings()).map(ends);
            orbit.multipliers_between(model, &self.drifts, &smooth, &again, &self.meter)
        });
        found.ok()?.ok()
    }
}

impl Curve for BalanceCurve<'_> {
    type Solution = Series;

    fn linearise(&mut self, x: &DVector<f64>, p: f64) -> Result<Linear<Series>, CurveError> {
        self.meter.spend_slowly()?;
        let n = x.len();
        let (mut residual, mut by_x) = (DVector::zeros(n), DMatrix::zeros(n, n));
        let (matrix, slope) = (&mut self.matrix, &mut self.slope);
        let (exact, jumps, weights) = self.equations.get_mut().at(p, |equations, at| {
            equations.residual(x.as_slice(), residual.as_mut_slice());
            equations.jacobian(x.as_slice(), matrix);
            match matrix.single() {
                Some(entries) => by_x.as_mut_slice().copy_from_slice(entries),
                None => by_x = DMatrix::from(&*matrix),
            }
            let jumps = !equations.work.spectra.jumps.is_empty();
            let exact = at.slope.filter(|_| !jumps).and_then(|model| slope.at(equations, model));
            (exact, jumps, weights(equations))
        })?;
        let mut by_p = match exact {
            Some(by_p) => by_p,
            None => self.differences(x, p, &residual)?,
        };
        residual.component_mul_assign(&weights);
        by_p.component_mul_assign(&weights);
        by_x.column_iter_mut().for_each(|mut column| column.component_mul_assign(&weights));
        Ok(Linear { residual, by_x, by_p, solution: Series { jumps, multipliers: Rc::default() } })
    }

    fn units(&self) -> DVector<f64> {
        let n = self.scales.len();
        let share = (n as f64).sqrt();
        let unit = |j: usize| {
            let (range, scale) = (self.widths.units()[j], self.scales[j]);
            share * if range > AT_REST * scale { range / scale } else { 1.0 }
        };
        let of_series = n * self.width;
        DVector::from_fn(of_series + self.drift_sizes.len(), |i, _| {
            if i < of_series { unit(i / self.width) } else { share * self.drift_sizes[i - of_series] }
        })
    }

    fn last_correction(&self) -> f64 {
        if self.is_smooth { LAST } else { 0.0 }
    }
    fn has_corners(&self) -> bool {
        !self.is_smooth
    }
}

/// Weights of the equations: 1/max(s, (k ω)²) at order k, with the largest stiffness s.
fn weights(equations: &BalanceEquations<'_>) -> DVector<f64> {
    let (layout, stiffest) = (&equations.work.layout, equations.work.couplings.stiffest);
    let width = layout.harmonics.unknowns();
    let mut weights = DVector::from_element(layout.size(), 1.0);
    for (at, &order) in layout.harmonics.orders().iter().enumerate() {
        let (place, rate) = (layout.harmonics.place(at), order as f64 * layout.omega);
        let weight = 1.0 / stiffest.max(rate * rate).max(layout.omega * layout.omega);
        for j in 0..layout.dof {
            weights[j * width + place] = weight;
            if order > 0 {
                weights[j * width + place + 1] = weight;
            }
        }
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::branches::orbits::orbit_method::OrbitMethod;
    use crate::model::Periodic;
    use crate::models::nfg::{NfgPair, NfgParams};
    use crate::ode::budget::Budget;
    use crate::periodic::balance::series::harmonics::Harmonics;

    /// ∂R/∂c is that of differences, for every constant of the face gear pair and every way of integration,
    /// along a motion with rattle.
    #[test]
    fn exact_derivatives_with_respect_to_constants() -> Result<(), Box<dyn std::error::Error>> {
        let pair = NfgPair::new(&NfgParams { speed: 140.0, ..NfgParams::table1() })?;
        let b = pair.half_backlash_angle();
        let (harmonics, series) = (Harmonics::bands(63, 1, 2)?, [-0.9 * b, 0.3 * b, 0.1 * b]);
        let rest = vec![0.1 * b; harmonics.unknowns() - 3];
        let orbit = FourierOrbit::new(&harmonics, pair.period(), &[[&series[..], &rest].concat()])?;
        let budget = Budget::new();
        for constant in pair.names() {
            let family = Family::over(&pair, [&constant.name])?;
            for integrals in
                [Integrals::Closed, Integrals::Kinks, Integrals::Panels, Integrals::Sampled { samples: 4096 }]
            {
                let p = pair.constant(&constant.name)?;
                let balance = Balance::new(harmonics.clone()).integrals(integrals);
                let meter = Rc::new(budget.begin());
                let of = (p, p.abs());
                let mut curve = BalanceCurve::new(&family, &balance, of, &orbit, meter)?;
                let x = curve.unknowns(&orbit);
                let exact = curve.linearise(&x, p)?.by_p;
                assert!(curve.slope.has_served(), "{constant} {integrals:?}");
                let h = 1e-5 * p.abs();
                let (low, high) = (curve.linearise(&x, p - h)?, curve.linearise(&x, p + h)?);
                // The weights of the equations change with the speed.
                let mut at = |p: f64| curve.equations.get_mut().at(p, |equations, _| weights(equations));
                let [here, below, above] = [at(p)?, at(p - h)?, at(p + h)?];
                let plain = |linear: &Linear<Series>, weights: &DVector<f64>| {
                    linear.residual.component_div(weights).component_mul(&here)
                };
                let differences = (plain(&high, &above) - plain(&low, &below)) / (2.0 * h);
                let error = (&exact - &differences).amax() / exact.amax();
                let bound = if matches!(integrals, Integrals::Sampled { .. }) { 1e-2 } else { 1e-6 };
                assert!(error < bound, "{constant} {integrals:?}: {error:.1e}");
            }
        }
        Ok(())
    }
}
