//! The piece of every contact, step after step.

use crate::contact::{Contact, Piece};
use crate::excitation::Side;
use crate::model::Model;
use crate::numeric::gauss::FIVE;
use crate::ode::Step;
use crate::ode::probe::Probe;

/// A time that a contact spends on a piece: a whole step if edges are located, otherwise the weight of one of
/// five Gauss points.
#[derive(Clone, Copy)]
pub(crate) struct Visit {
    pub(crate) contact: usize,
    pub(crate) piece: Piece,
    /// The piece of the visit before; `None` at the first visit.
    pub(crate) from: Option<Piece>,
    /// Whether the contact enters a flank from the gap or, between two samples, through the gap.
    pub(crate) is_impact: bool,
    /// Start of the step, or the time of the sample.
    pub(crate) t: f64,
    pub(crate) time: f64,
    /// The contact at `t`; `None` while a contact with located edges stays on its piece.
    pub(crate) at: Option<Contact>,
}

/// Follows the pieces of all contacts of a run.
///
/// A contact without edges is always on its upper flank. In a gap without width a contact stays on its last
/// flank, and a change of flank is no impact.
pub(crate) struct Pieces<'m> {
    pub(crate) probe: Probe<'m>,
    last: Vec<Option<Piece>>,
    edgeless: Vec<bool>,
    visits: Vec<Visit>,
    y: Vec<f64>,
}

impl<'m> Pieces<'m> {
    pub(crate) fn new(model: &'m dyn Model) -> Self {
        let contacts = model.offers().touching(model.contacts());
        let mut probe = Probe::new(model);
        let rest = vec![0.0; model.dof()];
        let at_rest = probe.read_contacts(0.0, Side::After, &rest, &rest);
        let edgeless = at_rest[..contacts]
            .iter()
            .map(|c| c.lower == f64::NEG_INFINITY && c.upper == f64::INFINITY)
            .collect();
        Pieces {
            probe,
            edgeless,
            last: vec![None; contacts],
            visits: Vec::with_capacity(FIVE.len() * contacts),
            y: vec![0.0; 2 * model.dof()],
        }
    }

    /// The visits of the last step: in order of time, those of one time in order of the contacts.
    pub(crate) fn visits(&self) -> &[Visit] {
        &self.visits
    }

    /// Forgets the last pieces: the next step belongs to another run.
    pub(crate) fn forget(&mut self) {
        self.last.fill(None);
    }

    /// Follows the contacts through a step.
    pub(crate) fn follow(&mut self, step: &mut Step<'_>) {
        self.visits.clear();
        let (t0, t1) = (step.t0(), step.t1());
        if let Some(pieces) = step.pieces() {
            for (i, &piece) in pieces[..self.last.len()].iter().enumerate() {
                // The contact matters only if the piece changes.
                let changed = self.last[i] != Some(piece);
                let at = changed.then(|| self.probe.read_contacts(t0, Side::After, step.q0(), step.v0())[i]);
                let closed = at.is_some_and(|start| self.is_closed(i, piece, start, step));
                self.enter(i, piece, closed, (t0, t1 - t0), at);
            }
        } else {
            for [x, w] in FIVE {
                let t = 0.5 * (t0 + t1) + 0.5 * (t1 - t0) * x;
                step.at(t, &mut self.y);
                let (q, v) = self.y.split_at(self.y.len() / 2);
                self.probe.read_contacts(t, Side::After, q, v);
                for i in 0..self.last.len() {
                    let c = self.probe.contacts()[i];
                    self.enter(i, c.piece(), c.upper <= c.lower, (t, 0.5 * w * (t1 - t0)), Some(c));
                }
            }
        }
    }

    /// Adds the visit of contact `i` to a piece. `closed`: the gap has no width.
    fn enter(&mut self, i: usize, piece: Piece, closed: bool, (t, time): (f64, f64), at: Option<Contact>) {
        let from = self.last[i];
        let piece = match piece {
            _ if self.edgeless[i] => Piece::Upper,
            Piece::Gap if closed => from.unwrap_or(Piece::Upper),
            _ => piece,
        };
        // A change from flank to flank is an impact if the gap has a width: it was passed between two
        // samples.
        let is_impact =
            piece != Piece::Gap && from.is_some_and(|last| last != piece && (last == Piece::Gap || !closed));
        self.visits.push(Visit { contact: i, piece, from, is_impact, t, time, at });
        self.last[i] = Some(piece);
    }

    /// Whether the gap of contact `i` has no width at the `start` of a step. While the contact stands in the
    /// gap, the gap must have no width at the end of the step either.
    fn is_closed(&mut self, i: usize, piece: Piece, start: Contact, step: &Step<'_>) -> bool {
        if start.upper > start.lower {
            return false;
        }
        let end = self.probe.read_contacts(step.t1(), Side::Before, step.q1(), step.v1())[i];
        piece != Piece::Gap || end.upper <= end.lower
    }
}
