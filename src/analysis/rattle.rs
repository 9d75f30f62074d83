//! Rattle: contact times, impacts and rattle state of every contact.

use crate::contact::piece::Piece;
use crate::excitation::side::Side;
use crate::model::equations::Model;
use crate::numeric::gauss::FIVE;
use crate::ode::probe::Probe;
use crate::ode::step::{Observer, Step};
use std::ops::ControlFlow;

/// The rattle state of a mesh, numbered as rsv in Liu 2021.
///
/// A mesh whose teeth never touch is floating.
///
/// ```
/// use gear_dynamics::RattleState;
/// assert_eq!(RattleState::Bilateral.rsv(), 2);
/// assert_eq!(RattleState::Unilateral.to_string(), "unilateral");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum RattleState {
    /// The teeth never separate: one flank is in contact throughout or, without backlash, the flanks
    /// alternate.
    None,
    /// The teeth separate at times and touch on one flank only.
    Unilateral,
    /// The teeth touch on both flanks, with impacts.
    Bilateral,
    /// The teeth never touch.
    Floating,
}

impl RattleState {
    /// The number rsv of Liu 2021: 0 none, 1 unilateral, 2 bilateral. Floating is 3; Liu 2021 does not have
    /// this state.
    pub fn rsv(self) -> u8 {
        match self {
            RattleState::None => 0,
            RattleState::Unilateral => 1,
            RattleState::Bilateral => 2,
            RattleState::Floating => 3,
        }
    }
}

impl std::fmt::Display for RattleState {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(match self {
            RattleState::None => "none",
            RattleState::Unilateral => "unilateral",
            RattleState::Bilateral => "bilateral",
            RattleState::Floating => "floating",
        })
    }
}

/// Contact times and impacts of one contact over a run.
///
/// ```
/// use gear_dynamics::{analysis::ContactStatistics, RattleState};
/// let contact = ContactStatistics { time: [3.0, 1.0, 0.0], impacts: [5, 0] };
/// assert_eq!((contact.rattle_state(), contact.loss_fraction()), (RattleState::Unilateral, 0.25));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct ContactStatistics {
    /// Times on the lower flank, in the gap and on the upper flank, in the model's time unit.
    pub time: [f64; 3],
    /// Number of impacts on the lower and on the upper flank. An impact is an entry from the gap, if the gap
    /// has a width, or a rebound from a rigid stop.
    pub impacts: [u64; 2],
}

impl ContactStatistics {
    /// The rattle state that follows from the times and the impacts.
    pub fn rattle_state(&self) -> RattleState {
        let [lower, gap, upper] = self.time.map(|t| t > 0.0);
        // A contact spends no time on a rigid stop: an impact shows that it touched.
        let [lower, upper] = [lower || self.impacts[0] > 0, upper || self.impacts[1] > 0];
        match (lower, upper, gap) {
            // Both flanks without an impact: the mesh has no backlash.
            (true, true, _) if self.impacts == [0, 0] => RattleState::None,
            (true, true, _) => RattleState::Bilateral,
            (false, false, _) => RattleState::Floating,
            (_, _, true) => RattleState::Unilateral,
            (_, _, false) => RattleState::None,
        }
    }
    /// Time in the gap over the total time `[1]`; 0 if the total time is 0.
    pub fn loss_fraction(&self) -> f64 {
        let total: f64 = self.time.iter().sum();
        if total > 0.0 { self.time[1] / total } else { 0.0 }
    }
    /// Number of impacts on both flanks together.
    pub fn impact_count(&self) -> u64 {
        self.impacts.iter().sum()
    }
}

/// Observer that keeps the [`ContactStatistics`] of every contact of a run.
///
/// If the solver locates edges, the pieces are known exactly. Otherwise each step is sampled at five Gauss
/// points. A mesh without backlash edges (a linear mesh) counts as in contact on its upper flank. If the gap
/// has no width, a change of flank is not an impact.
///
/// ```
/// use gear_dynamics::{Dop853, Integrator, NfgPair, NfgParams, Periodic, Rattle, RattleState};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let mut rattle = Rattle::new(&pair);
/// Dop853::new().run(&pair, &pair.static_start()?, 0.1 * pair.period(), &mut rattle)?;
/// assert_eq!(rattle.contact(0).rattle_state(), RattleState::None);
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
    /// Observes all contacts of a model.
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

    /// Statistics of contact `i`; the first contact is 0.
    ///
    /// # Panics
    /// If the model has no contact `i`.
    pub fn contact(&self, i: usize) -> ContactStatistics {
        self.contacts[i]
    }
    /// Statistics of all contacts.
    pub fn contacts(&self) -> &[ContactStatistics] {
        &self.contacts
    }

    /// Adds a time on a piece to contact `i`, and an impact if the contact entered a flank.
    /// `closed`: the gap has no width.
    fn count(&mut self, i: usize, piece: Piece, time: f64, closed: bool) {
        let last = self.last[i];
        // A contact without edges never separates. In a gap without width a contact stays on its last flank.
        let piece = match piece {
            _ if self.edgeless[i] => Piece::Upper,
            Piece::Gap if closed => last.unwrap_or(Piece::Upper),
            _ => piece,
        };
        let contact = &mut self.contacts[i];
        contact.time[piece as usize] += time;
        // A change from flank to flank is an impact if the gap has a width: it was passed between two
        // samples.
        if last.is_some_and(|last| last != piece && (last == Piece::Gap || !closed)) {
            match piece {
                Piece::Lower => contact.impacts[0] += 1,
                Piece::Gap => {}
                Piece::Upper => contact.impacts[1] += 1,
            }
        }
        self.last[i] = Some(piece);
    }

    /// Whether the gap of contact `i` has no width at the start of a step. While the contact stands in the
    /// gap, the gap must have no width at the end of the step either.
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
                // The width of the gap matters only if the piece changes.
                let closed = self.last[i] != Some(piece) && self.is_closed(i, piece, step);
                self.count(i, piece, t1 - t0, closed);
            }
            for crossing in step.crossings().iter().filter(|c| c.rebounds) {
                self.contacts[crossing.contact].impacts[usize::from(crossing.to == Piece::Upper)] += 1;
            }
        } else {
            for [x, w] in FIVE {
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
