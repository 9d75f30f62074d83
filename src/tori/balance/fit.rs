//! Tori fitted to states of a run.

use crate::error::{ParameterError, check};
use crate::model::State;
use crate::tori::balance::torus::{Torus, rate};
use crate::tori::balance::torus_error::TorusError;
use crate::tori::balance::wave_vectors::WaveVectors;
use crate::tori::least_squares;

impl Torus {
    /// The torus that passes closest to the coordinates of states at the angles ω t, in the sense of least
    /// squares: a guess from a settled run. Velocities are not used.
    ///
    /// The states should cover several periods of the lowest base frequency, at times without a common step
    /// with the periods; twice as many states as coefficients of a coordinate
    /// ([`2 len - 1`](WaveVectors::len)) suffice.
    ///
    /// # Errors
    /// [`TorusError::Unspread`], and [`TorusError::Parameter`] for frequencies and states that are not valid.
    pub fn fit(vectors: &WaveVectors, frequencies: &[f64], states: &[State]) -> Result<Self, TorusError> {
        let Some(first) = states.first() else {
            return Err(ParameterError::Empty { name: "states".into(), min: vectors.unknowns() }.into());
        };
        let (n, unknowns) = (first.q.len(), vectors.unknowns());
        states.iter().try_for_each(|state| state.check(n))?;
        let mut torus = Torus::constant(vectors, frequencies, &first.q)?;
        check::count("coefficients of the normal equations", &[unknowns, unknowns], check::NUMBERS)?;
        let rates: Vec<f64> = vectors.vectors().map(|k| rate(k, frequencies)).collect();
        let coefficients = least_squares::fit(states.len(), [unknowns, n], |k, row, q| {
            row[0] = 1.0;
            for (pair, omega) in row[1..].chunks_exact_mut(2).zip(&rates[1..]) {
                let (sin, cos) = (omega * states[k].t).sin_cos();
                pair.copy_from_slice(&[cos, sin]);
            }
            q.copy_from_slice(&states[k].q);
        });
        let Some(coefficients) = coefficients else {
            return Err(TorusError::Unspread { states: states.len(), unknowns });
        };
        // Column by column, that is, coordinate by coordinate.
        torus.set(coefficients.as_slice());
        Ok(torus)
    }
}
