//! Histories of the contacts along an orbit.

use crate::analysis::ContactStatistics;
use crate::contact::Piece;
use crate::contact::edge::Edge;
use crate::periodic::balance::crossings::instants::Crossings;

/// The pieces of one contact over one span of an orbit, with contact times and impacts.
///
/// ```
/// use gear_dynamics::{Balance, Harmonics, NfgPair, NfgParams, RattleState, contact::Piece};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let orbit = Balance::new(Harmonics::up_to(70)).linearised(&pair, Piece::Lower)?;
/// let contact = &orbit.contacts(&pair)?[0];
/// assert_eq!(contact.statistics.rattle_state(), RattleState::None);
/// assert_eq!(contact.intervals.len(), 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ContactHistory {
    /// Intervals in increasing time. The first interval begins at the first crossing; the last one may end
    /// after the span.
    pub intervals: Vec<ContactInterval>,
    /// Contact times and number of impacts.
    pub statistics: ContactStatistics,
}

/// An interval in which a contact stays on one piece of its law.
///
/// ```
/// use gear_dynamics::{Balance, Harmonics, NfgPair, NfgParams, Periodic, contact::Piece};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let orbit = Balance::new(Harmonics::up_to(70)).linearised(&pair, Piece::Lower)?;
/// let whole = orbit.contacts(&pair)?[0].intervals[0];
/// assert_eq!((whole.piece, whole.end - whole.start), (Piece::Lower, pair.period()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ContactInterval {
    /// Start, in the model's time unit.
    pub start: f64,
    /// End, in the model's time unit.
    pub end: f64,
    /// The piece of the law.
    pub piece: Piece,
}

impl ContactHistory {
    pub(crate) fn new(crossings: &Crossings, contact: usize, span: f64) -> Self {
        let entries: Vec<(f64, Piece)> = crossings
            .list()
            .iter()
            .filter(|e| e.contact == contact)
            .map(|e| (e.time(span / crossings.samples() as f64), e.to))
            .collect();
        let mut history = ContactHistory { intervals: Vec::new(), statistics: ContactStatistics::default() };
        if entries.is_empty() {
            let piece = crossings.piece(contact, 0);
            history.intervals.push(ContactInterval { start: 0.0, end: span, piece });
        }
        for (i, &(start, piece)) in entries.iter().enumerate() {
            let end = entries.get(i + 1).map_or(entries[0].0 + span, |e| e.0);
            // A gap without width takes no time and gets no interval.
            if piece != Piece::Gap || end > start {
                history.intervals.push(ContactInterval { start, end, piece });
            }
            // An impact is the entry to a flank after some time in the gap.
            let before = if i == 0 { entries[entries.len() - 1].0 - span } else { entries[i - 1].0 };
            if let Some(edge) = Edge::of(piece).filter(|_| start > before) {
                history.statistics.impacts[edge as usize] += 1;
            }
        }
        for &ContactInterval { start, end, piece } in &history.intervals {
            history.statistics.time[piece as usize] += end - start;
        }
        history
    }
}
