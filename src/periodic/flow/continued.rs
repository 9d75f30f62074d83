//! Contacts fixed on their pieces, also for models without `accel_on_pieces`.

use crate::contact::edge::Edge;
use crate::contact::{Contact, Piece};
use crate::model::structure::slopes::{accelerate, offered};
use crate::model::{Jacobian, Model, Offers};
use std::cell::RefCell;

/// f(y) ≈ f(y_i) + (f(y_i) - f(y_i + φ Δ))/φ, Δ = y_i - y: a model whose contacts can be fixed on pieces.
///
/// A model with [`accel_on_pieces`](Model::accel_on_pieces) is used as it is. For other models the
/// acceleration just inside the piece is continued linearly past the edge by the formula above. y_i is the
/// state moved back inside the piece along the gradient of the deflection, and φ is a share of Δ. Linear
/// contact laws are continued exactly.
pub(crate) struct Continued<'m> {
    model: &'m dyn Model,
    /// Whether the model needs no continuation: it has `accel_on_pieces` or no contacts.
    own: bool,
    /// Edges that are rigid stops; past them the acceleration is not continued.
    rigid: Vec<[bool; 2]>,
    /// Sizes of coordinates and velocities.
    scale: &'m [f64],
    scratch: RefCell<Scratch>,
}

struct Scratch {
    contacts: Vec<Contact>,
    /// Gradients of the distance past the piece, one contact after the other.
    gradients: Vec<f64>,
    /// Contacts outside their piece, each with its distance from the edge after the move inside.
    left: Vec<(usize, f64)>,
    /// The states y_i and y_i + φ Δ.
    inside: Vec<f64>,
    further: Vec<f64>,
    a: Vec<f64>,
}

/// Distance from the edge after the move inside a piece, as a share of the gap: far above the rounding error
/// of a deflection.
const INSIDE: f64 = 1e-9;

/// Step of the differences of a deflection, as a share of the size of the component.
const DIFFERENCE_STEP: f64 = 1e-4;

/// Maximum number of projections onto all edges. One is enough unless contacts share coordinates.
const SWEEPS: usize = 8;

/// Distance of a contact past the edge of a piece; negative inside the piece.
pub(crate) fn past(piece: Piece, c: &Contact) -> f64 {
    Edge::of(piece).map_or_else(|| c.penetration(), |flank| -flank.depth(c))
}

/// ∂h/∂q, then ∂h/∂v, by central differences.
pub(crate) fn gradient(
    h: &mut dyn FnMut(&[f64], &[f64]) -> f64,
    y: &mut [f64],
    scale: &[f64],
    out: &mut [f64],
) {
    let n = y.len() / 2;
    for j in 0..y.len() {
        let here = y[j];
        let step = DIFFERENCE_STEP * scale[j].max(1e-3 * here.abs());
        let mut side = |at: f64| {
            y[j] = at;
            h(&y[..n], &y[n..])
        };
        let (above, below) = (side(here + step), side(here - step));
        out[j] = (above - below) / ((here + step) - (here - step));
        y[j] = here;
    }
}

impl<'m> Continued<'m> {
    pub(crate) fn new(model: &'m dyn Model, scale: &'m [f64]) -> Self {
        let (n, contacts) = (model.dof(), model.contacts());
        let own = contacts == 0 || model.offers().pieces;
        let (m, scratch) = if own { (0, 0) } else { (2 * n, contacts) };
        let scratch = Scratch {
            contacts: vec![Contact::default(); scratch],
            gradients: vec![0.0; scratch * m],
            left: Vec::with_capacity(scratch),
            inside: vec![0.0; m],
            further: vec![0.0; m],
            a: vec![0.0; m / 2],
        };
        Continued {
            model,
            own,
            rigid: model.offers().rigid_edges(contacts),
            scale,
            scratch: RefCell::new(scratch),
        }
    }

    /// Computes `inside` = y_i and `further` = y_i + φ Δ and returns φ; `None` if the state is inside all
    /// pieces.
    ///
    /// Each projection moves y by -(p + m)/|S g|² S² g, with p the distance past the edge, m the margin, g =
    /// ∂p/∂y and S = diag(scale).
    fn move_inside(
        &self,
        scratch: &mut Scratch,
        pieces: &[Piece],
        u: &[f64],
        q: &[f64],
        v: &[f64],
    ) -> Option<f64> {
        let (model, n) = (self.model, q.len());
        let Scratch { contacts, gradients, left, inside, further, .. } = scratch;
        model.contact(u, q, v, contacts);
        left.clear();
        let gap = |c: &Contact| Some(c.upper - c.lower).filter(|gap| gap.is_finite());
        for (i, (c, &piece)) in contacts.iter().zip(pieces).enumerate() {
            // If the gap is zero or infinite, the margin is a share of the size of the deflection; it is set
            // below.
            let margin = INSIDE * gap(c).filter(|gap| *gap > 0.0).unwrap_or(0.0);
            let past = past(piece, c);
            let nearer_to_upper = Edge::Upper.depth(c) >= Edge::Lower.depth(c);
            let near = if nearer_to_upper { Edge::Upper } else { Edge::Lower };
            if piece == Piece::Gap && near.is_stop(&self.rigid, i) {
                continue;
            }
            if past >= -margin && past.is_finite() {
                left.push((i, margin));
            }
        }
        let closed = |c: &Contact| c.upper <= c.lower;
        if left.is_empty() {
            return None;
        }
        inside[..n].copy_from_slice(q);
        inside[n..].copy_from_slice(v);
        let mut share = 1.0f64;
        for (i, _) in &*left {
            let (piece, c) = (pieces[*i], &contacts[*i]);
            if let (Piece::Gap, Some(gap)) = (piece, gap(c)) {
                share = share.min(0.25 * gap / past(piece, c).abs()).max(INSIDE);
            }
        }
        for (i, margin) in &mut *left {
            let slope = &mut gradients[*i * 2 * n..][..2 * n];
            let mut h = |q: &[f64], v: &[f64]| {
                model.contact(u, q, v, contacts);
                past(pieces[*i], &contacts[*i])
            };
            gradient(&mut h, inside, self.scale, slope);
            // A gap of width zero has no inside: its margin stays 0.
            if *margin == 0.0 && !(pieces[*i] == Piece::Gap && closed(&contacts[*i])) {
                *margin = INSIDE * slope.iter().zip(self.scale).map(|(g, s)| (g * s).abs()).sum::<f64>();
            }
        }
        for _ in 0..SWEEPS {
            let mut moved = false;
            for (i, margin) in &*left {
                let (q, v) = inside.split_at(n);
                model.contact(u, q, v, contacts);
                let miss = past(pieces[*i], &contacts[*i]) + margin;
                let slope = &gradients[*i * 2 * n..][..2 * n];
                let square: f64 = slope.iter().zip(self.scale).map(|(g, s)| (g * s) * (g * s)).sum();
                if miss > 1e-3 * margin && square > 0.0 {
                    moved = true;
                    inside
                        .iter_mut()
                        .zip(slope.iter().zip(self.scale))
                        .for_each(|(y, (g, s))| *y -= miss / square * g * s * s);
                }
            }
            if !moved {
                break;
            }
        }
        for (further, (inside, y)) in further.iter_mut().zip(inside.iter().zip(q.iter().chain(v))) {
            *further = inside + share * (inside - y);
        }
        Some(share)
    }
}

impl Model for Continued<'_> {
    fn dof(&self) -> usize {
        self.model.dof()
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.model.accel(u, q, v, a);
    }
    fn base(&self) -> Option<&dyn Model> {
        Some(self.model)
    }
    fn offers(&self) -> Offers<'_> {
        let base = self.model.offers();
        let Offers { jacobian, stops, kinks, .. } = base;
        let others = if self.own { base } else { Offers { jacobian, stops, kinks, ..Offers::default() } };
        Offers { pieces: true, ..others }
    }
    #[inline]
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        if self.own {
            return accelerate(self.model, Some(pieces), u, q, v, a);
        }
        let scratch = &mut *self.scratch.borrow_mut();
        let Some(share) = self.move_inside(scratch, pieces, u, q, v) else {
            return self.model.accel(u, q, v, a);
        };
        let n = q.len();
        self.model.accel(u, &scratch.inside[..n], &scratch.inside[n..], a);
        self.model.accel(u, &scratch.further[..n], &scratch.further[n..], &mut scratch.a);
        a.iter_mut().zip(&scratch.a).for_each(|(a, further)| *a += (*a - further) / share);
    }
    fn jacobian(&self, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64], out: &mut Jacobian) {
        let Some(fixed) = pieces.filter(|_| !self.own) else {
            return self.model.jacobian(offered(self.model, pieces), u, q, v, out);
        };
        let scratch = &mut *self.scratch.borrow_mut();
        match self.move_inside(scratch, fixed, u, q, v) {
            None => self.model.jacobian(None, u, q, v, out),
            Some(_) => {
                self.model.jacobian(None, u, &scratch.inside[..q.len()], &scratch.inside[q.len()..], out)
            }
        }
    }
}
