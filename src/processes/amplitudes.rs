//! Numbers drawn from a distribution of the user.

use crate::error::{ParameterError, check};
use crate::numeric::split_mix::CounterRng;
use rand_distr::Distribution;
use std::fmt;
use std::sync::Arc;

type Draw = Arc<dyn Fn(&mut CounterRng) -> f64 + Send + Sync>;

/// A distribution, and its moments if the user states them: a distribution of `rand_distr` does not tell
/// them.
#[derive(Clone)]
pub(crate) struct Amplitudes {
    draw: Draw,
    pub(crate) moments: Option<KnownMoments>,
}

/// Mean and standard deviation of a distribution.
#[derive(Clone, Copy, Debug)]
pub(crate) struct KnownMoments {
    pub(crate) mean: f64,
    pub(crate) deviation: f64,
}

impl Amplitudes {
    pub(crate) fn new<D: Distribution<f64> + Send + Sync + 'static>(distribution: D) -> Self {
        Amplitudes { draw: Arc::new(move |rng| distribution.sample(rng)), moments: None }
    }
    pub(crate) fn with_moments(self, mean: f64, deviation: f64) -> Result<Self, ParameterError> {
        let mean = check::quantity("mean", mean)?;
        let deviation = check::not_negative("standard deviation", deviation)?;
        Ok(Amplitudes { moments: Some(KnownMoments { mean, deviation }), ..self })
    }
    #[inline]
    pub(crate) fn draw(&self, rng: &mut CounterRng) -> f64 {
        (self.draw)(rng)
    }
}

impl fmt::Debug for Amplitudes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Amplitudes").field("moments", &self.moments).finish_non_exhaustive()
    }
}
