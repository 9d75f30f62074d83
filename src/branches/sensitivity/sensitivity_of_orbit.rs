//! Derivatives of the figures of an orbit with respect to all constants of its model.

use crate::branches::branch_error::BranchError;
use crate::branches::sensitivity::along::along_direction;
use crate::branches::sensitivity::derivatives::{Neighbours, gather};
use crate::branches::sensitivity::figure::Figure;
use crate::branches::sensitivity::observed::Derivatives;
use crate::branches::sensitivity::quantity::Quantity;
use crate::branches::sensitivity::totals::Totals;
use crate::error::{ParameterError, check};
use crate::model::{Channel, Periodic};
use crate::ode::budget::Meter;
use crate::ode::probe::Probe;
use crate::periodic::ShootingOrbit;
use nalgebra::DMatrix;
use std::rc::Rc;

/// dJ/dc = ∂J/∂c - ∂J/∂x (∂G/∂x)⁻¹ ∂G/∂c: derivatives of the figures J of an orbit with respect to all
/// named constants c of its model at once. G are the equations of multiple shooting.
///
/// The derivatives of the flow are exact, with the jumps at tooth edges. A mean (1/T) ∫ f dt over a crossing
/// or an impact at τ changes also by (f⁻ - f⁺) dτ/dc/T, and an extreme there by f' dτ/dc. The change of a
/// channel along the change of the orbit is a central difference of fourth order, exact to rounding for
/// channels that are linear in coordinates and constants. At the grazing of an elastic contact the
/// derivatives of both sides are equal. An orbit that grazes a rigid stop has bounded derivatives on the side
/// without the impact only: rounding decides which side is computed.   Source: Leine & Nijmeijer, Sect. 7.4.
///
/// ```
/// use gear_dynamics::{Shooting, State, branches::{Figure, Sensitivity}, trains::SpurPair};
/// let pair = SpurPair::of_numbers(0.05, 0.1, &[], &[0.02])?.parts()?.build("driver", 0.7)?;
/// let orbit = Shooting::new().solve(&pair, &State::new(0.0, &[1.1], &[0.0]))?;
/// let sensitivity = Sensitivity::of(&pair, &orbit, &["deflection"])?;
/// let slopes = sensitivity.slopes(Figure::Mean, "deflection")?;
/// // Teeth stay in contact: the mean deflection is half the backlash plus a static deflection.
/// assert!((slopes[sensitivity.index("mesh half backlash")?] - 1.0).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Sensitivity {
    constants: Vec<Channel>,
    channels: Vec<String>,
    figures: Vec<Figures>,
    start: DMatrix<f64>,
}

/// Derivatives of the figures of one channel.
#[derive(Clone, Debug)]
struct Figures {
    mean: Vec<f64>,
    rms: Vec<f64>,
    max: Vec<f64>,
    min: Vec<f64>,
    peak_to_peak: Vec<f64>,
}

impl Sensitivity {
    /// The derivatives for an orbit of `model`, with the parameter of that orbit, and the channels of these
    /// names (see [`Probe`](crate::ode::Probe)). The [budget](ShootingOrbit::budget) of the orbit limits the
    /// call.
    ///
    /// # Errors
    /// A model without named constants; an unknown channel;
    /// [`CurveError::NoSolution`](crate::branches::CurveError::NoSolution) for the orbit of another model,
    /// for example with another speed; [`CurveError::Singular`](crate::branches::CurveError::Singular) if an
    /// orbit is not isolated. Near a fold the derivatives grow without bound.
    pub fn of(model: &dyn Periodic, orbit: &ShootingOrbit, channels: &[&str]) -> Result<Self, BranchError> {
        Self::within(model, orbit, channels, Rc::new(orbit.budget.begin()))
    }

    /// [`of`](Sensitivity::of) within a budget.
    pub(crate) fn within(
        model: &dyn Periodic,
        orbit: &ShootingOrbit,
        channels: &[&str],
        meter: Rc<Meter<'_>>,
    ) -> Result<Self, BranchError> {
        let constants = model.offers().named()?;
        let wanted = Probe::new(model).indices(channels)?;
        let wanted: Vec<Quantity> = wanted.into_iter().map(Quantity::Channel).collect();
        let totals = Totals::new(model, constants, orbit, meter)?;
        let slopes = totals.solve()?;
        let neighbours = Neighbours::new(constants, &totals.units, model.period())?;
        let gathered = gather(&totals, model, &neighbours, &slopes, &wanted, None)?;
        let figures = gathered.iter().map(|one| Figures::of(one, &totals.units)).collect();
        let m = totals.curve.scale().len();
        let start = DMatrix::from_fn(m, totals.units.len(), |i, k| slopes[(i, k)] / totals.units[k]);
        let channels = channels.iter().map(|name| (*name).to_owned()).collect();
        Ok(Sensitivity { constants: constants.names().to_vec(), channels, figures, start })
    }

    /// Names and units of the constants, in the order of all derivatives.
    pub fn names(&self) -> &[Channel] {
        &self.constants
    }
    /// Index of a constant in the derivatives.
    ///
    /// # Errors
    /// [`ParameterError::NoSuchConstant`], which lists the names.
    pub fn index(&self, name: &str) -> Result<usize, ParameterError> {
        crate::model::channel::index_of(&self.constants, name)
    }
    /// Derivatives of a figure of a channel over a period.
    ///
    /// # Errors
    /// A channel that was not chosen.
    pub fn slopes(&self, figure: Figure, channel: &str) -> Result<&[f64], ParameterError> {
        let figures = &self.figures[check::channel_index(&self.channels, channel)?];
        Ok(match figure {
            Figure::Mean => &figures.mean,
            Figure::Rms => &figures.rms,
            Figure::PeakToPeak => &figures.peak_to_peak,
            Figure::Max => &figures.max,
            Figure::Min => &figures.min,
        })
    }
    /// Derivatives of the state at the first node, at a fixed phase: coordinates and velocities along the
    /// rows, constants along the columns.
    pub fn start(&self) -> &DMatrix<f64> {
        &self.start
    }

    /// Derivatives [d-, d+] of the largest |μ| of an orbit with respect to all constants: for a decreasing
    /// and for an increasing constant. They are central differences of fourth order of the monodromy matrix
    /// along the derivative of the orbit, with an error of about 1e-8.
    ///
    /// Both are equal unless the orbit grazes an edge, where the sequence of contacts changes. There one of
    /// them may be unbounded: the multipliers change with the root of the penetration. It is then ±∞. Where a
    /// constant is at the end of its range, the derivative towards values without a model is NaN.
    ///
    /// # Errors
    /// As [`of`](Sensitivity::of).
    pub fn of_largest_multiplier(
        model: &dyn Periodic,
        orbit: &ShootingOrbit,
    ) -> Result<Vec<[f64; 2]>, BranchError> {
        let constants = model.offers().named()?;
        let totals = Totals::new(model, constants, orbit, Rc::new(orbit.budget.begin()))?;
        let slopes = totals.solve()?;
        let mut all = Vec::with_capacity(totals.units.len());
        for (k, unit) in totals.units.iter().enumerate() {
            let along = slopes.column(k).into_owned();
            let model = |h: f64| constants.with_values(&[(k, constants.values()[k] + h * unit)]);
            let both = along_direction(&totals, &along, &model, &|m| Some(m.largest()))?;
            all.push(both.map(|slope| slope / unit));
        }
        Ok(all)
    }
}

impl Figures {
    fn of(from: &Derivatives, units: &[f64]) -> Self {
        let per = |values: &[f64], factor: f64| -> Vec<f64> {
            values.iter().zip(units).map(|(value, unit)| value * factor / unit).collect()
        };
        let rms = from.square.sqrt();
        let (max, min) = (per(&from.extremes[0].2, 1.0), per(&from.extremes[1].2, 1.0));
        Figures {
            mean: per(&from.by_mean, 1.0),
            rms: per(&from.by_square, if rms > 0.0 { 0.5 / rms } else { 0.0 }),
            peak_to_peak: max.iter().zip(&min).map(|(max, min)| max - min).collect(),
            max,
            min,
        }
    }
}
