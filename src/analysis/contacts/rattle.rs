//! Rattle: contact times, impacts and rattle state of every contact.

use crate::analysis::contacts::pieces::Pieces;
use crate::contact::Piece;
use crate::contact::edge::Edge;
use crate::error::ParameterError;
use crate::model::Model;
use crate::ode::{Observer, Step};
use std::fmt;
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
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ContactStatistics {
    /// Times on the lower flank, in the gap and on the upper flank, in the model's time unit. Those of a
    /// [`Row`](crate::sweep::Row) are shares of the measured time.
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
        self.impacts[0].saturating_add(self.impacts[1])
    }
}

/// Observer that keeps the [`ContactStatistics`] of every contact of a run.
/// [`Impacts`](crate::analysis::Impacts) lists the impacts themselves.
///
/// If the solver locates edges, the pieces are known exactly. Otherwise each step is sampled at five Gauss
/// points. A mesh without backlash edges (a linear mesh) counts as in contact on its upper flank. If the gap
/// has no width, a change of flank is not an impact.
///
/// ```
/// use gear_dynamics::{Dop853, Integrator, NfgPair, NfgParams, Periodic, Rattle, RattleState};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let mut rattle = Rattle::new(&pair);
/// Dop853::new().run(&pair, &pair.on_drive_flank()?, 0.1 * pair.period(), &mut rattle)?;
/// assert_eq!(rattle.contacts()[0].rattle_state(), RattleState::None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use = "an observer records during a run"]
pub struct Rattle<'m> {
    pieces: Pieces<'m>,
    contacts: Vec<ContactStatistics>,
}

impl fmt::Debug for Rattle<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Rattle").field("contacts", &self.contacts).finish_non_exhaustive()
    }
}

impl<'m> Rattle<'m> {
    /// Observes all contacts of a model.
    pub fn new(model: &'m dyn Model) -> Self {
        let touching = model.offers().touching(model.contacts());
        Rattle { pieces: Pieces::new(model), contacts: vec![ContactStatistics::default(); touching] }
    }

    /// Statistics of each contact.
    pub fn contacts(&self) -> &[ContactStatistics] {
        &self.contacts
    }
}

impl Observer for Rattle<'_> {
    fn fits(&self, dof: usize, contacts: usize) -> Result<(), ParameterError> {
        self.pieces.probe.fits(dof, contacts)
    }
    fn step(&mut self, step: &mut Step<'_>) -> ControlFlow<()> {
        self.pieces.follow(step);
        for visit in self.pieces.visits() {
            let contact = &mut self.contacts[visit.contact];
            contact.time[visit.piece as usize] += visit.time;
            if visit.is_impact {
                contact.impacts[Edge::between(Piece::Gap, visit.piece) as usize] += 1;
            }
        }
        for crossing in step.crossings().iter().filter(|c| c.rebounds) {
            self.contacts[crossing.contact].impacts[Edge::between(crossing.from, crossing.to) as usize] += 1;
        }
        ControlFlow::Continue(())
    }
}
