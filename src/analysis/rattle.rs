//! Rattle: whether, how often and on which flanks teeth meet.

use crate::analysis::quadrature::GAUSS;
use crate::contact::piece::Piece;
use crate::excitation::side::Side;
use crate::model::equations::Model;
use crate::ode::probe::Probe;
use crate::ode::step::{Observer, Step};
use std::ops::ControlFlow;

/// The rattle state of a mesh, numbered as rsv in Liu 2021; a mesh that never touches is floating.
///
/// ```
/// use gear_dynamics::RattleState;
/// assert_eq!(RattleState::Bilateral as u8, 2);
/// assert_eq!(RattleState::Unilateral.to_string(), "unilateral");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RattleState {
    /// The teeth are never apart: one flank carries throughout or, without backlash, both in turn.
    None = 0,
    /// In the gap at times, one flank only.
    Unilateral = 1,
    /// Both flanks.
    Bilateral = 2,
    /// Never in contact.
    Floating = 3,
}

impl std::fmt::Display for RattleState {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            RattleState::None => "none",
            RattleState::Unilateral => "unilateral",
            RattleState::Bilateral => "bilateral",
            RattleState::Floating => "floating",
        })
    }
}

/// What one contact did over a run.
///
/// ```
/// use gear_dynamics::{analysis::ContactStatistics, RattleState};
/// let contact = ContactStatistics { time: [3.0, 1.0, 0.0], impacts: [5, 0] };
/// assert_eq!((contact.state(), contact.loss_fraction()), (RattleState::Unilateral, 0.25));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactStatistics {
    /// Time on the lower flank, in the gap, on the upper flank.
    pub time: [f64; 3],
    /// Impacts on the lower and on the upper flank: entries from the gap, if it has a width, and rebounds from rigid stops.
    pub impacts: [u64; 2],
}

impl ContactStatistics {
    /// The rattle state.
    pub fn state(&self) -> RattleState {
        let [lower, gap, upper] = self.time.map(|t| t > 0.0);
        // Rigid stops are met without a time on them.
        let [lower, upper] = [lower || self.impacts[0] > 0, upper || self.impacts[1] > 0];
        match (lower, upper, gap) {
            // From flank to flank without an impact: there is no backlash.
            (true, true, _) if self.impacts == [0, 0] => RattleState::None,
            (true, true, _) => RattleState::Bilateral,
            (false, false, _) => RattleState::Floating,
            (_, _, true) => RattleState::Unilateral,
            (_, _, false) => RattleState::None,
        }
    }
    /// Share of the time with the teeth apart.
    pub fn loss_fraction(&self) -> f64 {
        let total: f64 = self.time.iter().sum();
        if total > 0.0 { self.time[1] / total } else { 0.0 }
    }
    /// Impacts on both flanks.
    pub fn impact_count(&self) -> u64 {
        self.impacts.iter().sum()
    }
}

/// Observes a run and keeps the rattle of every contact. With located edges the pieces are known exactly; otherwise each step is sampled.
/// A mesh without backlash edges (a linear one) counts as in contact. Where a gap has no width, its flanks take over from one another without
/// an impact.
///
/// ```
/// use gear_dynamics::{Dop853, Integrator, NfgPair, NfgParams, Periodic, Rattle, RattleState};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let mut rattle = Rattle::new(&pair);
/// Dop853::new().run(&pair, &pair.static_start()?, 0.1 * pair.period(), &mut rattle)?;
/// assert_eq!(rattle.contact(0).state(), RattleState::None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Rattle<'m, M: ?Sized> {
    probe: Probe<'m, M>,
    contacts: Vec<ContactStatistics>,
    last: Vec<Option<Piece>>,
    edgeless: Vec<bool>,
    y: Vec<f64>,
}

impl<'m, M: Model + ?Sized> Rattle<'m, M> {
    /// Of all contacts of a model.
    pub fn new(model: &'m M) -> Self {
        let contacts = model.contacts();
        let mut probe = Probe::new(model);
        let rest = vec![0.0; model.dof()];
        let at_rest = probe.read_contacts(0.0, Side::After, &rest, &rest);
        let edgeless =
            at_rest.iter().map(|c| c.lower == f64::NEG_INFINITY && c.upper == f64::INFINITY).collect();
        Rattle {
            probe,
            edgeless,
            contacts: vec![ContactStatistics::default(); contacts],
            last: vec![None; contacts],
            y: vec![0.0; 2 * model.dof()],
        }
    }

    /// Contact `i`.
    ///
    /// # Panics
    /// If the model has no contact `i`.
    pub fn contact(&self, i: usize) -> ContactStatistics {
        self.contacts[i]
    }
    /// All contacts.
    pub fn contacts(&self) -> &[ContactStatistics] {
        &self.contacts
    }

    /// Adds time on a piece; `closed`: the gap has no width there.
    fn count(&mut self, i: usize, piece: Piece, time: f64, closed: bool) {
        let last = self.last[i];
        // A law without edges never separates, nor do teeth without backlash.
        let piece = match piece {
            _ if self.edgeless[i] => Piece::Upper,
            Piece::Gap if closed => last.unwrap_or(Piece::Upper),
            _ => piece,
        };
        let contact = &mut self.contacts[i];
        contact.time[piece as usize] += time;
        // From flank to flank there is an impact where a gap was passed unseen.
        if last.is_some_and(|last| last != piece && (last == Piece::Gap || !closed)) {
            match piece {
                Piece::Lower => contact.impacts[0] += 1,
                Piece::Gap => {}
                Piece::Upper => contact.impacts[1] += 1,
            }
        }
        self.last[i] = Some(piece);
    }

    /// Whether the gap of contact `i` has no width at the start of a step, and while the teeth are in it, at the end.
    fn is_closed(&mut self, i: usize, piece: Piece, step: &Step<'_>) -> bool {
        let start = self.probe.read_contacts(step.t0(), Side::After, step.q0(), step.v0())[i];
        if start.upper > start.lower {
            return false;
        }
        let end = self.probe.read_contacts(step.t1(), Side::Before, step.q1(), step.v1())[i];
        piece != Piece::Gap || end.upper <= end.lower
    }
}

impl<M: Model + ?Sized> Observer for Rattle<'_, M> {
    fn step(&mut self, step: &mut Step<'_>) -> ControlFlow<()> {
        let (t0, t1) = (step.t0(), step.t1());
        if let Some(pieces) = step.pieces() {
            for (i, &piece) in pieces.iter().enumerate() {
                // The width of the gap counts where the piece changes.
                let closed = self.last[i] != Some(piece) && self.is_closed(i, piece, step);
                self.count(i, piece, t1 - t0, closed);
            }
            for crossing in step.crossings().iter().filter(|c| c.rebounds) {
                self.contacts[crossing.contact].impacts[usize::from(crossing.to == Piece::Upper)] += 1;
            }
        } else {
            for [x, w] in GAUSS {
                let t = 0.5 * (t0 + t1) + 0.5 * (t1 - t0) * x;
                step.at(t, &mut self.y);
                let (q, v) = self.y.split_at(self.y.len() / 2);
                self.probe.read_contacts(t, Side::After, q, v);
                for i in 0..self.contacts.len() {
                    let contact = self.probe.contacts()[i];
                    self.count(i, contact.piece(), 0.5 * w * (t1 - t0), contact.upper <= contact.lower);
                }
            }
        }
        ControlFlow::Continue(())
    }
}
