//! Lengths of the steps of all lanes, and how far distances move in them.
#![allow(
    clippy::needless_range_loop,
    reason = "index loops over arrays become vector instructions, iterators do not"
)]

use crate::ode::taylor::expansion::plan::EdgeColumn;
use crate::ode::taylor::pace::{FINEST, MAX_GROWTH, max, reach, size_of_distance};
use crate::sweep::lanes::number::Lanes;
use crate::sweep::taylor::columns::{Columns, W};

/// For each lane the length of the last step and the bound of the next one.
#[derive(Clone, Copy)]
pub(crate) struct Before {
    /// The length that the tolerances allowed for the last step; 0 before the first.
    pub(super) last: [f64; W],
    /// The longest step possible.
    pub(super) room: [f64; W],
}

/// The tolerances of all lanes.
pub(crate) struct Pace {
    rtol: f64,
    /// Absolute tolerance of each coordinate and velocity.
    atol: Vec<Lanes<W>>,
    /// For each edge the column of its distance, and the column of the distance to the other edge of the gap.
    edges: Vec<(usize, Option<usize>)>,
}

impl Pace {
    /// `components`: number of coordinates and velocities.
    pub(super) fn new(rtol: f64, components: usize, edges: &[EdgeColumn]) -> Self {
        let opposite = |edge: &EdgeColumn| {
            let other = edges.iter().find(|other| other.is_opposite(edge));
            (edge.column, other.map(|other| other.column))
        };
        let atol = vec![Lanes::from(0.0); components];
        Pace { rtol, atol, edges: edges.iter().map(opposite).collect() }
    }

    /// Sets the absolute tolerances of a lane.
    pub(super) fn set_lane(&mut self, lane: usize, atol: &[f64]) {
        self.atol.iter_mut().zip(atol).for_each(|(all, atol)| all.0[lane] = *atol);
    }

    /// The length at which each of the last two terms reaches its tolerance: the rule of
    /// [`Taylor`](crate::Taylor).
    #[inline(always)]
    pub(super) fn lengths(&self, c: &Columns, before: &Before) -> [f64; W] {
        let degree = c.degree;
        let (mut last, mut terms) = ([0.0; W], [[0.0; W]; 2]);
        for l in 0..W {
            last[l] = if before.last[l].is_finite() { before.last[l] } else { 0.0 };
        }
        for (column, atol) in self.atol.iter().enumerate() {
            let [value, rate, highest, below] = [0, 1, degree, degree - 1].map(|n| &c.at(column, n).0);
            for l in 0..W {
                let per = 1.0 / (atol.0[l] + self.rtol * (value[l].abs() + last[l] * rate[l].abs()));
                terms[0][l] = max(terms[0][l], (highest[l] * per).abs());
                terms[1][l] = max(terms[1][l], (below[l] * per).abs());
            }
        }
        let mut h = shorter(&terms, degree);
        let mut span = [0.0; W];
        for l in 0..W {
            let grown = MAX_GROWTH * last[l];
            h[l] = if last[l] > 0.0 && grown < h[l] { grown } else { h[l] };
            span[l] = if h[l] < before.room[l] { h[l] } else { before.room[l] };
        }
        // Moving edges and transmission errors act on the distances alone while teeth are apart.
        let share = self.rtol.max(FINEST);
        let (mut terms, mut extent) = ([[0.0; W]; 2], [0.0; W]);
        for column in 0..self.atol.len() / 2 {
            let value = &c.at(column, 0).0;
            for l in 0..W {
                extent[l] = max(extent[l], value[l].abs());
            }
        }
        for (edge, opposite) in &self.edges {
            let other = opposite.map(|other| c.at(other, 0));
            let [start, rate, highest, below] = [0, 1, degree, degree - 1].map(|n| &c.at(*edge, n).0);
            for l in 0..W {
                let gap = other.map_or(0.0, |other| start[l] + other.0[l]);
                let moves = start[l].abs() + span[l] * rate[l].abs();
                let size = share * size_of_distance(gap, moves, extent[l]);
                let per = if size > f64::MIN_POSITIVE { 1.0 / size } else { 0.0 };
                terms[0][l] = max(terms[0][l], (highest[l] * per).abs());
                terms[1][l] = max(terms[1][l], (below[l] * per).abs());
            }
        }
        let of_distances = shorter(&terms, degree);
        for l in 0..W {
            // NaN in either remains.
            let shorter = (of_distances[l] < h[l]) | of_distances[l].is_nan();
            h[l] = if shorter { of_distances[l] } else { h[l] };
        }
        h
    }

    /// Bounds of the moves of the distances in the step, at their columns.
    #[inline(always)]
    pub(super) fn moves(&self, c: &Columns, h: &Lanes<W>, out: &mut [[Lanes<W>; 2]]) {
        for (column, _) in &self.edges {
            out[*column] = c.bounds(*column, h);
        }
    }
}

/// The shorter of the lengths at which the terms of the two highest orders, in tolerances, reach 1; NaN if
/// one of them is not finite.
#[inline(always)]
fn shorter(terms: &[[f64; W]; 2], degree: usize) -> [f64; W] {
    let mut h = [0.0; W];
    for l in 0..W {
        let [a, b] = [reach(terms[0][l], degree), reach(terms[1][l], degree - 1)];
        let shorter = if a < b { a } else { b };
        let finite = terms[0][l].is_finite() & terms[1][l].is_finite();
        h[l] = if finite { shorter } else { f64::NAN };
    }
    h
}
