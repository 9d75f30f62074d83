//! The line along which the deflection of a contact varies.

use crate::check::point::CheckPoint;
use crate::contact::Contact;
use crate::contact::edge::Edge;
use crate::model::State;

/// A straight line in the coordinates along which the deflection d of one contact varies.
pub(crate) struct Line {
    q: Vec<f64>,
    /// g/(g·g) with g = ∂d/∂q: change of the coordinates per change of the deflection.
    pub(crate) per_deflection: Vec<f64>,
    /// The contact at `q`.
    contact: Contact,
    /// The deflection that corresponds to the size of the coordinates.
    size: f64,
}

impl Line {
    /// q + (d - d(q)) g/(g·g): the coordinates at which the linearised deflection is `d`.
    pub(crate) fn to(&self, d: f64) -> Vec<f64> {
        let moved = d - self.contact.deflection;
        self.q.iter().zip(&self.per_deflection).map(|(q, g)| q + moved * g).collect()
    }

    /// The finite edges; none if the gap has no width.
    pub(crate) fn edges(&self) -> impl Iterator<Item = Edge> {
        let has_width = self.contact.upper > self.contact.lower;
        Edge::BOTH.into_iter().filter(move |edge| has_width && self.place(*edge).is_finite())
    }
    /// The deflection at an edge.
    pub(crate) fn place(&self, edge: Edge) -> f64 {
        edge.position(&self.contact)
    }

    /// The unit of distances from an edge: the width of the gap. If the gap is open to one side, it is
    /// max(|edge|, |d - edge|), or `size` if both are zero.
    pub(crate) fn length(&self, edge: Edge) -> f64 {
        let gap = self.contact.upper - self.contact.lower;
        if gap.is_finite() {
            return gap;
        }
        let length = self.place(edge).abs().max(edge.distance(&self.contact).abs());
        if length > 0.0 { length } else { self.size }
    }
}

impl CheckPoint<'_> {
    /// The line of a contact; `None` if its deflection does not depend on the coordinates.
    pub(crate) fn line(&self, contact: usize) -> Option<Line> {
        let State { q, v, .. } = &self.state;
        let base = self.contacts(q, v)[contact];
        let h = 1e-4 * self.size[0];
        let gradient: Vec<f64> = (0..q.len())
            .map(|j| {
                let mut q = q.clone();
                q[j] += h;
                (self.contacts(&q, v)[contact].deflection - base.deflection) / h
            })
            .collect();
        let square: f64 = gradient.iter().map(|g| g * g).sum();
        if square == 0.0 || !square.is_finite() {
            return None;
        }
        let per_deflection = gradient.iter().map(|g| g / square).collect();
        Some(Line { q: q.clone(), per_deflection, contact: base, size: self.size[0] * square.sqrt() })
    }
}
