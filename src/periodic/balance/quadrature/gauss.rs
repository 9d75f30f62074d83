//! Gauss quadrature between drive edges.

use crate::error::ParameterError;
use crate::model::equations::Periodic;
use std::f64::consts::TAU;

/// Nodes and weights of ten points on -1 .. 1, both signs.   Abramowitz & Stegun, Table 25.4.
#[rustfmt::skip]
const GAUSS: [[f64; 2]; 5] = [
    [0.148_874_338_981_631_2, 0.295_524_224_714_752_9],
    [0.433_395_394_129_247_2, 0.269_266_719_309_996_4],
    [0.679_409_568_299_024_4, 0.219_086_362_515_982_04],
    [0.865_063_366_688_984_5, 0.149_451_349_150_580_6],
    [0.973_906_528_517_171_7, 0.066_671_344_308_688_14],
];

/// All ten nodes on -1 .. 1, with their weights.
pub(crate) fn nodes() -> [(f64, f64); 10] {
    std::array::from_fn(|k| {
        let [node, weight] = GAUSS[k / 2];
        (if k % 2 == 0 { -node } else { node }, weight)
    })
}

/// The panels between the breaks, as (middle, half width). Orders of up to twice `order` appear in the Jacobian:
/// in half a panel they turn by at most 3 rad.
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
        for (node, weight) in nodes() {
            at(middle + half * node, weight * half / span);
        }
    }
}

/// Maximum number of drive edges in one span of a balance.
pub(crate) const MAX_EDGES: usize = 100_000;

/// Drive edges in (0, span], at most `MAX_EDGES` + 1. An edge at time 0 appears at the end of the span, since the
/// drives repeat.
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

/// Whether a span contains drive edges. More than `MAX_EDGES` are an error.
pub(crate) fn any_edges<M: Periodic + ?Sized>(model: &M, span: f64) -> Result<bool, ParameterError> {
    let edges = drive_edges(model, span).len();
    if edges > MAX_EDGES {
        let (name, allowed) = ("number of drive edges in the span of an orbit".into(), "[0, 100000]");
        return Err(ParameterError::OutOfRange { name, value: edges as f64, allowed });
    }
    Ok(edges > 0)
}
