//! Merging of the chunks of a sweep.

use crate::sweep::rows::collection::Rows;
use crate::sweep::sweep_error::SweepError;
use thiserror::Error;

impl Rows {
    /// Merges all chunks of one sweep, in any order. The result equals the rows of the whole sweep bit by
    /// bit. Points that a cancelled chunk did not reach stay without row or error:
    /// [`is_complete`](Rows::is_complete) returns `false`, and
    /// [`Runner::resume`](crate::sweep::Runner::resume) runs them.
    ///
    /// # Errors
    /// [`SweepError::Parts`] if a chunk is missing, present twice or of another sweep; [`RowsError::rows`]
    /// contains the parts.
    pub fn merge(mut parts: Vec<Rows>) -> Result<Rows, RowsError> {
        // An empty chunk sorts before the chunk that starts at the same point.
        parts.sort_by_key(|part| (part.range.start, part.range.end));
        if let Some(row) = Rows::misfit(&parts) {
            return Err(RowsError { error: SweepError::Parts { row }, rows: parts });
        }
        let rows: usize = parts.iter().map(|part| part.done.len()).sum();
        let mut whole = parts.remove(0);
        // One exact allocation: each part is freed as soon as its values are copied.
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

    /// The first row at which sorted parts are not a whole sweep; `None` if they are.
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
        Some(last.range.end).filter(|end| *end != first.points().len())
    }
}

/// Error of [`Rows::merge`] and [`Runner::resume`](crate::sweep::Runner::resume), with the rows that were
/// given. The operator `?` converts it to a [`SweepError`].
///
/// ```
/// use gear_dynamics::sweep::{Rows, SweepError};
/// let refused = Rows::merge(Vec::new()).unwrap_err();
/// assert_eq!((refused.error, refused.rows.len()), (SweepError::Parts { row: 0 }, 0));
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{error}")]
#[non_exhaustive]
pub struct RowsError {
    /// The error.
    pub error: SweepError,
    /// The rows that were given. Parts are sorted by their points.
    pub rows: Vec<Rows>,
}

impl From<RowsError> for SweepError {
    fn from(refused: RowsError) -> SweepError {
        refused.error
    }
}
