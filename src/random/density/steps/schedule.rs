//! The steps of a repetition.

use crate::error::{ParameterError, check};
use crate::model::Model;

/// The steps of one repetition of the map: ends and lengths. All motions are the same in each step if the
/// drives are constant.
#[derive(Clone, Debug)]
pub(crate) struct Schedule {
    pub(crate) steps: Vec<f64>,
    pub(crate) constant: bool,
}

impl Schedule {
    /// Steps of at most `longest` over one period. They end where a drive jumps or has a kink.
    pub(crate) fn over_period(model: &dyn Model, period: f64, longest: f64) -> Result<Self, ParameterError> {
        let (mut steps, mut from) = (Vec::new(), 0.0);
        while from < period {
            let edge = model.next_edge(from).filter(|edge| *edge > from).unwrap_or(period);
            let to = if edge > period * (1.0 - 1e-9) { period } else { edge };
            let count = ((to - from) / longest - 1e-9).ceil().max(1.0);
            let count = check::count("steps per period", &[count as usize, 1], MOST)?;
            check::count("steps per period", &[steps.len() + count], MOST)?;
            steps.extend((0..count).map(|_| (to - from) / count as f64));
            from = to;
        }
        Ok(Schedule { steps, constant: false })
    }

    /// Equal steps of the length `step`, for constant drives: as many as cover `duration`.
    pub(crate) fn of_constant(duration: f64, step: f64) -> Result<Self, ParameterError> {
        let count =
            check::count("steps per repetition", &[(duration / step).ceil().max(1.0) as usize], MOST)?;
        Ok(Schedule { steps: vec![step; count], constant: true })
    }

    /// Each step halved.
    pub(crate) fn halved(&self) -> Self {
        Schedule { steps: self.steps.iter().flat_map(|h| [0.5 * h; 2]).collect(), ..self.clone() }
    }

    /// Length of the repetition.
    pub(crate) fn duration(&self) -> f64 {
        self.steps.iter().sum()
    }

    /// The times at which the steps end, in a period from 0.
    pub(crate) fn ends(&self) -> Vec<f64> {
        self.steps
            .iter()
            .scan(0.0, |t, h| {
                *t += h;
                Some(*t)
            })
            .collect()
    }
}

/// Maximum number of steps in a repetition.
const MOST: usize = 100_000;
