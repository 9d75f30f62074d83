//! Lyapunov exponents: the mean growth of small differences along a motion.

use super::rigid::rigid_modes;
use super::size::Sizes;
use super::tangent::Tangent;
use super::variation::coarse;
use crate::error::{ParameterError, check};
use crate::model::{Model, Periodic, State};
use crate::ode::{IntegrateError, Integrator};
use crate::root::dot;
use thiserror::Error;

/// λ_i = lim 1/t ln(growth of the i-th direction), by QR: small differences follow the variational equations, tooth edges handled, and are
/// made orthonormal again and again; the logarithms of what is divided out are summed.   Source: Benettin et al., Meccanica 15, 9 (1980).
///
/// A rigid mode adds two exponents of zero.
///
/// ```
/// use gear_dynamics::{Lyapunov, Model, Periodic, State};
/// struct Swing; // q'' + 3 q' + 2 q = cos 2t: exponents -1 and -2
/// impl Model for Swing {
///     fn dof(&self) -> usize { 1 }
///     fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) { a[0] = (2.0 * u[0]).cos() - 3.0 * v[0] - 2.0 * q[0]; }
/// }
/// impl Periodic for Swing {
///     fn period(&self) -> f64 { std::f64::consts::PI }
/// }
/// let exponents = Lyapunov::new().periods(20).run(&Swing, &State::at_rest(1))?;
/// assert!((exponents.values()[0] + 1.0).abs() < 1e-7);
/// assert!((exponents.values().iter().sum::<f64>() + 3.0).abs() < 1e-7); // the mean divergence
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lyapunov {
    count: Option<usize>,
    settle: usize,
    align: usize,
    periods: usize,
    renormalisations: usize,
    tolerance: f64,
}

impl Default for Lyapunov {
    fn default() -> Self {
        Lyapunov::new()
    }
}

impl Lyapunov {
    /// The full spectrum over 200 periods, after 100 to settle and 10 more for the directions to align, made orthonormal 16 times a
    /// period, the flow held to 1e-9.
    pub fn new() -> Self {
        Lyapunov { count: None, settle: 100, align: 10, periods: 200, renormalisations: 16, tolerance: 1e-9 }
    }
    /// Only the largest `count`: 1 costs least.
    pub fn count(self, count: usize) -> Self {
        Lyapunov { count: Some(count), ..self }
    }
    /// Periods to settle before anything is measured.
    pub fn settle(self, settle: usize) -> Self {
        Lyapunov { settle, ..self }
    }
    /// Periods for the directions to align.
    pub fn align(self, align: usize) -> Self {
        Lyapunov { align, ..self }
    }
    /// Periods to measure.
    pub fn periods(self, periods: usize) -> Self {
        Lyapunov { periods, ..self }
    }
    /// How often the directions are made orthonormal in a period.
    pub fn renormalisations(self, renormalisations: usize) -> Self {
        Lyapunov { renormalisations, ..self }
    }
    /// Local error of the flow, as a share of the range of each coordinate and velocity.
    pub fn tolerance(self, tolerance: f64) -> Self {
        Lyapunov { tolerance, ..self }
    }

    /// Along the motion from `start`.
    ///
    /// # Errors
    /// [`LyapunovError`], with the exponents over the periods that succeeded.
    pub fn run<M: Periodic + ?Sized>(&self, model: &M, start: &State) -> Result<Exponents, LyapunovError> {
        self.run_over(model, start, model.period())
    }

    /// The same for a model that does not repeat: `span` takes the place of the period.
    ///
    /// # Errors
    /// [`LyapunovError`], with the exponents over the spans that succeeded.
    pub fn run_over<M: Model + ?Sized>(&self, model: &M, start: &State, span: f64) -> Result<Exponents, LyapunovError> {
        self.run_while(model, start, span, &|| true)
    }

    /// The same as long as `go_on` says so; afterwards the exponents are those of the spans that are done.
    pub(crate) fn run_while<M: Model + ?Sized>(
        &self,
        model: &M,
        start: &State,
        span: f64,
        go_on: &dyn Fn() -> bool,
    ) -> Result<Exponents, LyapunovError> {
        self.run_any(&model, start, span, go_on)
    }

    fn run_any(&self, model: &dyn Model, start: &State, span: f64, go_on: &dyn Fn() -> bool) -> Result<Exponents, LyapunovError> {
        let components = 2 * model.dof();
        let count = self.count.unwrap_or(components);
        self.check(count, components, start, span)?;
        let mut exponents = Exponents { span, periods: vec![Vec::with_capacity(self.periods); count], state: start.clone() };
        let fail = |error: IntegrateError, so_far: &Exponents| LyapunovError::Flow { error, so_far: Box::new(so_far.clone()) };
        let mut sizes = Sizes::new(model.dof(), &rigid_modes(model, span));
        // Sizes of the motion once it has settled, or of one period if it need not.
        let settled = start.t + self.settle as f64 * span;
        let mut state = start.clone();
        if self.settle > 1 {
            state = coarse(start).end(model, start, settled - span).map_err(|e| fail(e, &exponents))?;
        }
        sizes.see(state.t, &state.q, &state.v);
        let ahead = coarse(&state).run(model, &state, state.t + span, &mut sizes).map_err(|e| fail(e, &exponents))?.state;
        if self.settle > 0 {
            state = ahead;
        }
        let scale = sizes.ranges();
        let tangent = Tangent::new(model, count, &scale, self.tolerance);
        let solver = tangent.solver(self.tolerance, &state);
        let mut directions = Directions { columns: vec![0.0; count * components], growth: vec![0.0; count], scale: &scale };
        let (from, mut all) = (state.t, tangent.start(&state));
        for period in 0..self.align + self.periods {
            directions.growth.fill(0.0);
            for part in 1..=self.renormalisations {
                if !go_on() {
                    return Ok(exponents);
                }
                let until = from + span * (period as f64 + part as f64 / self.renormalisations as f64);
                all = tangent.run(&solver, all, until).map_err(|e| fail(e, &exponents))?.0;
                directions.orthonormalise(&mut all);
            }
            if period >= self.align {
                exponents.periods.iter_mut().zip(&directions.growth).for_each(|(all, growth)| all.push(*growth));
            }
            exponents.state = tangent.motion(&all);
        }
        Ok(exponents)
    }

    /// What can be told without a model.
    pub(crate) fn check_settings(&self) -> Result<(), ParameterError> {
        let count = self.count.unwrap_or(1);
        for (name, value) in [("count", count), ("periods", self.periods), ("renormalisations", self.renormalisations)] {
            if value == 0 {
                return Err(ParameterError::TooFew { name: name.into(), value, least: 1 });
            }
        }
        check::positive("tolerance", self.tolerance).map(|_| ())
    }

    fn check(&self, count: usize, components: usize, start: &State, span: f64) -> Result<(), LyapunovError> {
        self.check_settings()?;
        if count > components {
            let allowed = "1 to the number of coordinates and velocities";
            return Err(ParameterError::OutOfRange { name: "count".into(), value: count as f64, allowed }.into());
        }
        check::scale("span", span)?;
        Ok(start.check(components / 2)?)
    }
}

/// The directions of one run.
struct Directions<'s> {
    columns: Vec<f64>,
    /// ln of what has been divided out.
    growth: Vec<f64>,
    scale: &'s [f64],
}

impl Directions<'_> {
    /// Gram-Schmidt in units of size: the columns of R on the diagonal are the growth.
    fn orthonormalise(&mut self, all: &mut State) {
        let (m, count) = (self.scale.len(), self.growth.len());
        let n = m / 2;
        let (of_q, of_v) = self.scale.split_at(n);
        for k in 0..count {
            let column = &mut self.columns[k * m..][..m];
            let (q, v) = (&all.q[n * (1 + k)..][..n], &all.v[n * (1 + k)..][..n]);
            for (x, (y, s)) in column.iter_mut().zip(q.iter().zip(of_q).chain(v.iter().zip(of_v))) {
                *x = y / s;
            }
        }
        for k in 0..count {
            let (before, rest) = self.columns.split_at_mut(k * m);
            let column = &mut rest[..m];
            before.chunks_exact(m).for_each(|other| super::size::remove(other, column));
            let length = dot(column, column).sqrt();
            self.growth[k] += length.ln();
            column.iter_mut().for_each(|x| *x /= length);
            let (q, v) = (&mut all.q[n * (1 + k)..][..n], &mut all.v[n * (1 + k)..][..n]);
            for (x, (y, s)) in column.iter().zip(q.iter_mut().zip(of_q).chain(v.iter_mut().zip(of_v))) {
                *y = x * s;
            }
        }
    }
}

/// Lyapunov exponents with their convergence.
///
/// ```
/// use gear_dynamics::{Lyapunov, NfgPair, NfgParams};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let exponents = Lyapunov::new().count(1).settle(2).align(1).periods(4).run(&pair, &pair.static_start()?)?;
/// assert!(exponents.per_period()[0] < -10.0);
/// assert_eq!(exponents.history(0).len(), 4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Exponents {
    span: f64,
    /// Growth of each direction in each period.
    periods: Vec<Vec<f64>>,
    state: State,
}

/// Batches whose scatter gives the standard error.
const BATCHES: usize = 16;

impl Exponents {
    /// λ per unit of time, the largest first.
    pub fn values(&self) -> Vec<f64> {
        self.per_period().iter().map(|l| l / self.span).collect()
    }
    /// λ per period (or span).
    pub fn per_period(&self) -> Vec<f64> {
        self.periods.iter().map(|all| mean(all)).collect()
    }
    /// Standard error of [`per_period`](Exponents::per_period), from the scatter of up to 16 batches; infinite with fewer than two.
    pub fn standard_error(&self) -> Vec<f64> {
        self.periods.iter().map(|all| scatter(all)).collect()
    }
    /// The estimate of exponent `i` per period after each period measured: how it converges.
    ///
    /// # Panics
    /// If there is no exponent `i`.
    pub fn history(&self, i: usize) -> Vec<f64> {
        let running = self.periods[i].iter().scan(0.0, |sum, growth| {
            *sum += growth;
            Some(*sum)
        });
        running.enumerate().map(|(k, sum)| sum / (k + 1) as f64).collect()
    }
    /// Where the motion has come to.
    pub fn state(&self) -> &State {
        &self.state
    }
}

fn mean(all: &[f64]) -> f64 {
    if all.is_empty() { f64::NAN } else { all.iter().sum::<f64>() / all.len() as f64 }
}

fn scatter(all: &[f64]) -> f64 {
    let batches = BATCHES.min(all.len());
    if batches < 2 {
        return f64::INFINITY;
    }
    let means: Vec<f64> = (0..batches).map(|b| mean(&all[b * all.len() / batches..(b + 1) * all.len() / batches])).collect();
    let middle = mean(&means);
    let square = means.iter().map(|x| (x - middle) * (x - middle)).sum::<f64>() / (batches - 1) as f64;
    (square / batches as f64).sqrt()
}

/// Why exponents are missing.
///
/// ```
/// use gear_dynamics::{Lyapunov, LyapunovError, NfgPair, NfgParams};
/// let pair = NfgPair::new(&NfgParams::table1())?;
/// let error = Lyapunov::new().count(3).run(&pair, &pair.static_start()?).unwrap_err();
/// assert!(matches!(error, LyapunovError::Parameter(_)) && error.to_string().contains("count is 3"));
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum LyapunovError {
    /// A setting or a start that cannot be used.
    #[error("Lyapunov exponents: {0}")]
    Parameter(#[from] ParameterError),
    /// The integration ended early.
    #[error("after {} periods: {error}", so_far.periods.first().map_or(0, Vec::len))]
    Flow {
        /// Why.
        error: IntegrateError,
        /// The exponents over the periods before.
        so_far: Box<Exponents>,
    },
}
