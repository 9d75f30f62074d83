//! Held processes: random processes that are constant on intervals of equal length.

use crate::error::{ParameterError, check};
use crate::excitation::Side;
use crate::numeric::split_mix::CounterRng;
use rand_distr::Distribution;
use std::fmt;
use std::sync::Arc;

type Draw = Arc<dyn Fn(&mut CounterRng) -> f64 + Send + Sync>;

/// A held process: x(t) = x_k for k h <= t < (k + 1) h, with random or given values x_k and the hold time h.
///
/// With numbers drawn at every evaluation of the acceleration the result depends on the step size. With held
/// values it converges as the step size decreases, and the hold time h is a physical parameter. Source:
/// docs/theory.md, "Random damping".
///
/// ```
/// use gear_dynamics::{drives::HeldProcess, excitation::Side};
/// use rand_distr::Uniform;
/// let process = HeldProcess::new(0.5, Uniform::new(0.0, 1.0)?)?.seed(7);
/// assert_eq!(process.at(0.1, Side::After, 0), process.at(0.4, Side::After, 0));
/// assert_ne!(process.at(0.5, Side::Before, 0), process.at(0.5, Side::After, 0));
/// let given = HeldProcess::from_values(0.5, &[3.0, 5.0])?;
/// assert_eq!(given.at(0.7, Side::After, 0), 5.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct HeldProcess {
    hold: f64,
    seed: u64,
    member: u64,
    source: ValueSource,
}

#[derive(Clone)]
enum ValueSource {
    /// A draw from a distribution.
    Drawn(Draw),
    /// A list of values.
    Given(Arc<[f64]>),
}

impl HeldProcess {
    /// A process with a new value of `distribution` after every hold time h > 0, in the time unit of the
    /// model. Defaults: seed 0, member 0.
    ///
    /// # Errors
    /// A hold time outside 1e-50 .. 1e50.
    pub fn new<D>(hold: f64, distribution: D) -> Result<Self, ParameterError>
    where
        D: Distribution<f64> + Send + Sync + 'static,
    {
        let draw = move |rng: &mut CounterRng| distribution.sample(rng);
        Ok(HeldProcess {
            hold: check::scale("hold time", hold)?,
            seed: 0,
            member: 0,
            source: ValueSource::Drawn(Arc::new(draw)),
        })
    }

    /// A process with given values, one for each hold time h. The last value applies after the end of the
    /// list. All streams have the same values.
    ///
    /// # Errors
    /// A hold time outside 1e-50 .. 1e50; an empty list; a value beyond ±1e50.
    pub fn from_values(hold: f64, values: &[f64]) -> Result<Self, ParameterError> {
        let hold = check::scale("hold time", hold)?;
        if values.is_empty() {
            return Err(ParameterError::Empty { name: "held values".into(), min: 1 });
        }
        check::quantities("held values", values)?;
        Ok(HeldProcess { hold, seed: 0, member: 0, source: ValueSource::Given(values.into()) })
    }

    /// The same process with another seed, for an independent experiment. Default: 0.
    pub fn seed(self, seed: u64) -> Self {
        HeldProcess { seed, ..self }
    }
    /// The same process for another member of an ensemble with the same seed. Default: 0.
    pub fn member(self, member: u64) -> Self {
        HeldProcess { member, ..self }
    }

    /// Value x_k of a stream. Different streams are independent: each mesh may have its own one, or all
    /// meshes share one.
    pub fn held(&self, stream: u64, k: u64) -> f64 {
        match &self.source {
            ValueSource::Drawn(draw) => draw(&mut CounterRng::new(self.seed, self.member, stream, k)),
            ValueSource::Given(values) => values[(k as usize).min(values.len() - 1)],
        }
    }

    /// The value x(t) of a stream; x_0 for t < 0. `side`: before or after a jump at `t`.
    pub fn at(&self, t: f64, side: Side, stream: u64) -> f64 {
        let k = self.index(t);
        let before = side == Side::Before && k > 0 && k as f64 * self.hold == t;
        self.held(stream, if before { k - 1 } else { k })
    }

    /// The k with k h <= t < (k + 1) h, in which k h is the rounded product. 0 for t < 0; at most 2^52.
    fn index(&self, t: f64) -> u64 {
        let guess = (t / self.hold).max(0.0);
        if guess >= LAST {
            return LAST as u64;
        }
        let mut k = guess as u64;
        while k > 0 && k as f64 * self.hold > t {
            k -= 1;
        }
        while (k + 1) as f64 * self.hold <= t {
            k += 1;
        }
        k
    }

    /// The first instant k h after `t`, with k >= 1.
    pub(crate) fn next_edge(&self, t: f64) -> Option<f64> {
        let edge = if t < 0.0 { self.hold } else { (self.index(t) + 1) as f64 * self.hold };
        (edge > t).then_some(edge)
    }
}

/// 2^52: largest index k. The numbers k and k + 1 are exact up to here.
const LAST: f64 = 4_503_599_627_370_496.0;

impl fmt::Debug for HeldProcess {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("HeldProcess")
            .field("hold", &self.hold)
            .field("seed", &self.seed)
            .finish_non_exhaustive()
    }
}
