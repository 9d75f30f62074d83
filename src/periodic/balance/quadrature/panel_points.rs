//! Gauss quadrature between drive edges.

use crate::error::ParameterError;
use crate::model::Periodic;
use crate::numeric::gauss::ten;
use std::f64::consts::TAU;

/// The panels between the breaks, as (middle, half width). Orders of up to twice `order` appear in the
/// Jacobian: in half a panel they turn by at most 3 rad.
pub(crate) fn panels(breaks: &[f64], span: f64, order: usize) -> impl Iterator<Item = (f64, f64)> {
    breaks.windows(2).flat_map(move |stretch| {
        let (start, length) = (stretch[0], stretch[1] - stretch[0]);
        let pieces = (length / span * TAU * order as f64 / 3.0).ceil();
        let half = 0.5 * length / pieces;
        (0..pieces as usize).map(move |p| (start + half * (2 * p + 1) as f64, half))
    })
}

/// (1/span) ∫ f dt ≈ Σ_i w_i f(t_i): calls `at(t_i, w_i)` at ten Gauss points of every panel between the
/// breaks.
pub(crate) fn quadrature(breaks: &[f64], span: f64, order: usize, mut at: impl FnMut(f64, f64)) {
    for (middle, half) in panels(breaks, span, order) {
        for (node, weight) in ten() {
            at(middle + half * node, weight * half / span);
        }
    }
}

/// Maximum number of drive edges in one span of a balance.
pub(crate) const MAX_EDGES: usize = 100_000;

/// Drive edges in (0, span], at most `MAX_EDGES` + 1. An edge at time 0 appears at the end of the span, since
/// the drives repeat.
pub(crate) fn drive_edges(model: &dyn Periodic, span: f64) -> Vec<f64> {
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

/// Whether a span contains drive edges. More than `MAX_EDGES` are an error.
pub(crate) fn any_edges(model: &dyn Periodic, span: f64) -> Result<bool, ParameterError> {
    let edges = drive_edges(model, span).len();
    if edges > MAX_EDGES {
        let (name, allowed) = ("number of drive edges in the span of an orbit".into(), "[0, 100000]");
        return Err(ParameterError::OutOfRange { name, value: edges as f64, allowed });
    }
    Ok(edges > 0)
}
