//! The first of several edges.

/// The smallest of several angles or instants, any of which may be missing; `None` if all are missing. A
/// model with several waves computes its next edge in this way.
///
/// ```
/// assert_eq!(gear_dynamics::excitation::earliest([None, Some(2.0), Some(1.5)]), Some(1.5));
/// ```
pub fn earliest(edges: impl IntoIterator<Item = Option<f64>>) -> Option<f64> {
    edges.into_iter().fold(None, earlier)
}

/// The earlier of two instants, either of which may be missing.
pub(crate) fn earlier(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.min(b)),
        (a, b) => a.or(b),
    }
}
