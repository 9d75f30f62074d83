//! Chunks of one sweep, put together.

use crate::sweep::error::SweepError;
use crate::sweep::rows::table::Rows;
use thiserror::Error;

impl Rows {
    /// Puts the chunks of one sweep together, in any order: bit-equal to the whole. Points that a cancelled chunk did not reach stay open:
    /// [`is_complete`](Rows::is_complete) tells, and [`Sweep::resume`](crate::Sweep::resume) runs them.
    ///
    /// # Errors
    /// [`SweepError::Parts`] when a chunk is missing, there twice, or of another sweep; the error holds the parts.
    pub fn merge(mut parts: Vec<Rows>) -> Result<Rows, RowsError> {
        // Empty chunks come before the one that starts where they do.
        parts.sort_by_key(|part| (part.range.start, part.range.end));
        if let Some(row) = Rows::misfit(&parts) {
            return Err(RowsError { error: SweepError::Parts { row }, rows: parts });
        }
        let rows: usize = parts.iter().map(|part| part.done.len()).sum();
        let mut whole = parts.remove(0);
        // Room once, for nothing more: parts are let go as they are taken over.
        whole.data.reserve_exact(rows.saturating_sub(whole.done.len()) * whole.layout.stride());
        for part in parts {
            whole.range.end = part.range.end;
            whole.data.extend(part.data);
            whole.done.extend(part.done);
            whole.errors.extend(part.errors);
            whole.checks.extend(part.checks);
            whole.exponent_errors.extend(part.exponent_errors);
            whole.alone += part.alone;
        }
        Ok(whole)
    }

    /// The first row at which sorted parts do not make a whole.
    fn misfit(parts: &[Rows]) -> Option<usize> {
        let (Some(first), Some(last)) = (parts.first(), parts.last()) else { return Some(0) };
        let fits = |pair: &&[Rows]| {
            pair[1].range.start == pair[0].range.end
                && pair[1].sweep == first.sweep
                && pair[1].layout == first.layout
        };
        if let Some(pair) = parts.windows(2).find(|pair| !fits(pair)) {
            return Some(pair[0].range.end);
        }
        if first.range.start > 0 {
            return Some(0);
        }
        Some(last.range.end).filter(|end| *end != first.points.len())
    }
}

/// Why rows were not merged or resumed, with the rows themselves: nothing that was computed is lost. `?` makes a [`SweepError`] of it.
///
/// ```
/// use gear_dynamics::sweep::{Rows, SweepError};
/// let refused = Rows::merge(Vec::new()).unwrap_err();
/// assert_eq!((refused.error, refused.rows.len()), (SweepError::Parts { row: 0 }, 0));
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{error}")]
pub struct RowsError {
    /// Why.
    pub error: SweepError,
    /// The rows that were given, parts in the order of their points.
    pub rows: Vec<Rows>,
}

impl From<RowsError> for SweepError {
    fn from(refused: RowsError) -> SweepError {
        refused.error
    }
}
