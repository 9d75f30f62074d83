//! Histories of the contacts along an orbit.

use crate::analysis::ContactStatistics;
use crate::contact::Piece;
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
pub struct ContactHistory {
    /// Intervals as (start, end, piece), in increasing time. The first interval begins at the first crossing;
    /// the last one may end after the span.
    pub intervals: Vec<(f64, f64, Piece)>,
    /// Contact times and number of impacts.
    pub statistics: ContactStatistics,
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
            history.intervals.push((0.0, span, crossings.piece(contact, 0)));
        }
        for (i, &(start, piece)) in entries.iter().enumerate() {
            let end = entries.get(i + 1).map_or(entries[0].0 + span, |e| e.0);
            // A gap without width takes no time and gets no interval.
            if piece != Piece::Gap || end > start {
                history.intervals.push((start, end, piece));
            }
            // An impact is the entry to a flank after some time in the gap.
            let before = if i == 0 { entries[entries.len() - 1].0 - span } else { entries[i - 1].0 };
            match piece {
                Piece::Lower if start > before => history.statistics.impacts[0] += 1,
                Piece::Upper if start > before => history.statistics.impacts[1] += 1,
                _ => {}
            }
        }
        for &(start, end, piece) in &history.intervals {
            history.statistics.time[piece as usize] += end - start;
        }
        history
    }
}
