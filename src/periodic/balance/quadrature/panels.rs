//! Gauss quadrature between the jumps of the drives.

use crate::error::ParameterError;
use crate::model::equations::Periodic;
use crate::numeric::gauss::ten;
use std::f64::consts::TAU;

/// The panels between the breaks, as middles and half widths. Half a panel turns twice `order`, as the Jacobian holds it, by 3 rad.
pub(crate) fn panels(breaks: &[f64], span: f64, order: usize) -> impl Iterator<Item = (f64, f64)> {
    breaks.windows(2).flat_map(move |stretch| {
        let (start, length) = (stretch[0], stretch[1] - stretch[0]);
        let pieces = (length / span * TAU * order as f64 / 3.0).ceil();
        let half = 0.5 * length / pieces;
        (0..pieces as usize).map(move |p| (start + half * (2 * p + 1) as f64, half))
    })
}

/// Ten Gauss points on every panel between the breaks, with their weights as shares of the span.
pub(crate) fn quadrature(breaks: &[f64], span: f64, order: usize, mut at: impl FnMut(f64, f64)) {
    for (middle, half) in panels(breaks, span, order) {
        for (node, weight) in ten() {
            at(middle + half * node, weight * half / span);
        }
    }
}

/// Jumps of the drives in one span that a balance takes.
pub(crate) const MAX_EDGES: usize = 100_000;

/// Instants of a span at which a drive jumps, one more than are taken at most; one at its beginning is met again at its end.
pub(crate) fn drive_edges<M: Periodic + ?Sized>(model: &M, span: f64) -> Vec<f64> {
    let mut edges = Vec::new();
    let mut t = 0.0;
    // An edge at the end of the span may be off by rounding.
    while edges.len() <= MAX_EDGES
        && let Some(edge) = model.next_edge(t).filter(|&edge| edge > t && edge <= span * (1.0 + 1e-12))
    {
        edges.push(edge.min(span));
        t = edge;
    }
    edges
}

/// Whether a drive jumps in a span at all; more jumps than are taken are refused.
pub(crate) fn any_edges<M: Periodic + ?Sized>(model: &M, span: f64) -> Result<bool, ParameterError> {
    let edges = drive_edges(model, span).len();
    if edges > MAX_EDGES {
        let (name, allowed) = ("number of jumps of the drives in the span of an orbit".into(), "0 to 100000");
        return Err(ParameterError::OutOfRange { name, value: edges as f64, allowed });
    }
    Ok(edges > 0)
}
