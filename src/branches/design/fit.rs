//! Fits of constants to a measured response.

use crate::branches::design::least::Optimum;
use crate::branches::design::objective::DesignError;
use crate::branches::design::orbit_finder::OrbitFinder;
use crate::branches::design::search::{Search, Space};
use crate::branches::sensitivity::figure::Figure;
use crate::branches::sensitivity::sensitivity_of_orbit::Sensitivity;
use crate::error::{ParameterError, check};
use crate::model::{Periodic, State};
use crate::ode::budget::Meter;
use crate::periodic::ShootingOrbit;
use std::cell::RefCell;
use std::rc::Rc;

/// Fits named constants to a response measured over a parameter: minimises Σ_j (J(p_j) - m_j)²/Σ_j m_j².
///
/// J is a figure of a channel on the orbit with the parameter p_j, and m_j its measured value. Gradients are
/// exact, the optimiser is SLSQP, as for [`Least`](crate::branches::Least). The points should lie on one
/// branch, in order along it: each orbit is found from its neighbour.
///
/// ```
/// use gear_dynamics::{State, branches::{Figure, Fit}, trains::SpurPair};
/// let pair = SpurPair::of_numbers(0.05, 0.1, &[], &[0.02])?.parts()?.build("driver", 0.6)?;
/// let fit = Fit::new("speed", "deflection", Figure::PeakToPeak).over("mesh damping", 0.02, 0.5);
/// // The damping of a pair from its response at two speeds. The search starts at a damping of 0.1.
/// let guess = [State::new(0.0, &[1.1], &[0.0])];
/// let measured = fit.response(&pair.with("mesh damping", 0.16)?, &[0.6, 0.7], &guess)?;
/// let found = fit.run(&pair, &[(0.6, measured[0]), (0.7, measured[1])], &guess)?;
/// assert!((found.constants[0].1 - 0.16).abs() < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type Fit = Search<Fitted>;

/// What a [`Fit`] minimises.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitted {
    parameter: String,
    channel: String,
    figure: Figure,
}

/// Sum of the squares of relative deviations that counts as none `[1]`.
const EXACT: f64 = 1e-16;

impl Fit {
    /// A fit to a figure of a channel, measured over the constant `parameter`.
    ///
    /// Defaults: a tolerance of 1e-8, 200 evaluations, default [`Shooting`](crate::Shooting) and
    /// [`Budget`](crate::Budget).
    pub fn new(parameter: &str, channel: &str, figure: Figure) -> Self {
        Search::of(Fitted { parameter: parameter.into(), channel: channel.into(), figure }, EXACT)
    }

    /// The figure of the model at each parameter. The first orbit is found from the guess, each further one
    /// from its neighbour.
    ///
    /// # Errors
    /// [`DesignError`].
    pub fn response<'g>(
        &self,
        model: &dyn Periodic,
        parameters: &[f64],
        guess: impl IntoIterator<Item = &'g State>,
    ) -> Result<Vec<f64>, DesignError> {
        let constants = model.offers().named()?;
        let index = constants.index(&self.objective.parameter)?;
        let meter = self.budget.begin();
        let orbits = self.orbits(model, parameters, guess, &meter)?;
        let figure = |(p, orbit): (&f64, &ShootingOrbit)| {
            let model = constants.with_values(&[(index, *p)])?;
            self.objective.figure.value(&*model, orbit, &self.objective.channel)
        };
        parameters.iter().zip(&orbits).map(figure).collect()
    }

    /// The orbits of a model at all parameters.
    fn orbits<'g>(
        &self,
        model: &dyn Periodic,
        parameters: &[f64],
        guess: impl IntoIterator<Item = &'g State>,
        meter: &Meter<'_>,
    ) -> Result<Vec<ShootingOrbit>, DesignError> {
        let constants = model.offers().named()?;
        let index = constants.index(&self.objective.parameter)?;
        let Some(&first) = parameters.first() else {
            return Err(ParameterError::Empty { name: "measured points".into(), min: 1 }.into());
        };
        check::all_finite("measured parameters", parameters)?;
        let start = constants.with_values(&[(index, first)])?;
        let of = OrbitFinder { shooting: &self.shooting, meter };
        let mut orbits = vec![of.first(&*start, guess)?];
        for two in parameters.windows(2) {
            let last = &orbits[orbits.len() - 1];
            orbits.push(of.reach(constants, last, &[(index, two[0])], &[(index, two[1])])?);
        }
        Ok(orbits)
    }

    /// Fits the constants to measured pairs (p_j, m_j). The search starts from the constants of `model`; the
    /// guess is one for its orbit at the first parameter.
    ///
    /// # Errors
    /// [`DesignError`]; if the optimiser does not converge, the error holds the best constants.
    pub fn run<'g>(
        &self,
        model: &dyn Periodic,
        measured: &[(f64, f64)],
        guess: impl IntoIterator<Item = &'g State>,
    ) -> Result<Optimum, DesignError> {
        let constants = model.offers().named()?;
        let index = constants.index(&self.objective.parameter)?;
        let (space, start) = Space::new(constants, &self.over)?;
        if self.over.iter().any(|(name, _)| *name == self.objective.parameter) {
            return Err(ParameterError::Twice { name: self.objective.parameter.clone() }.into());
        }
        let (parameters, values): (Vec<f64>, Vec<f64>) = measured.iter().copied().unzip();
        check::all_finite("measured values", &values)?;
        let size: f64 = values.iter().map(|m| m * m).sum();
        check::positive("sum of the squares of the measured values", size)?;
        let meter = Rc::new(self.budget.begin());
        let of = OrbitFinder { shooting: &self.shooting, meter: &meter };
        let orbits = RefCell::new((space.values(&start), self.orbits(model, &parameters, guess, &meter)?));
        let best: RefCell<Option<(f64, ShootingOrbit)>> = RefCell::new(None);
        let evaluate = |x: &[f64]| -> Result<(f64, Vec<f64>), DesignError> {
            let values = space.values(x);
            let mut last = orbits.borrow_mut();
            let (mut sum, mut slope, mut found) = (0.0, vec![0.0; values.len()], Vec::new());
            for ((p, m), orbit) in measured.iter().zip(&last.1) {
                let [from, to] = [&last.0, &values].map(|values| [&values[..], &[(index, *p)]].concat());
                let orbit = of.reach(constants, orbit, &from, &to)?;
                let model = constants.with_values(&to)?;
                let off = self.objective.figure.value(&*model, &orbit, &self.objective.channel)? - m;
                let sensitivity =
                    Sensitivity::within(&*model, &orbit, &[&self.objective.channel], meter.clone())?;
                let all = space.gradient(sensitivity.slopes(self.objective.figure, &self.objective.channel)?);
                sum += off * off / size;
                slope.iter_mut().zip(all).for_each(|(slope, by)| *slope += 2.0 * off * by / size);
                found.push(orbit);
            }
            let mut best = best.borrow_mut();
            if best.as_ref().is_none_or(|(least, _)| sum < *least) {
                *best = found.last().map(|orbit| (sum, orbit.clone()));
            }
            *last = (values, found);
            Ok((sum, slope))
        };
        let found = self.minimise(&space, &start, &evaluate)?;
        let none = ParameterError::Empty { name: "measured points".into(), min: 1 };
        let (_, orbit) = best.into_inner().ok_or(none)?;
        let constants = space.named(&found.x);
        let evaluations = found.evaluations * measured.len();
        Ok(Optimum { constants, value: found.value, evaluations, orbit })
    }
}
