//! The layout of a row.

#[cfg(feature = "serde")]
use crate::sweep::settings::sweep::Sweep;

/// Layout of a row, a list of numbers. It begins with groups of five numbers: the head, one for each channel,
/// one for each contact. Lyapunov exponent, multipliers and strobed periods follow.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Layout {
    pub(crate) dof: usize,
    pub(crate) channels: usize,
    pub(crate) contacts: usize,
    /// Number of periods whose strobed state and extremes of the channels are stored.
    pub(crate) strobes: usize,
    /// Number of values of the Lyapunov exponent: 2 (exponent, standard error) or 0.
    pub(crate) exponents: usize,
    /// Number of values of the multipliers: the parts of each, then their error, or 0.
    #[cfg_attr(feature = "serde", serde(default))]
    pub(crate) multipliers: usize,
}

impl Layout {
    /// Number of values in the head, of a channel and of a contact.
    pub(crate) const GROUP: usize = 5;
    /// Place among the groups: period multiple, change, settling periods, margin to grazing, scatter.
    pub(crate) const HEAD: usize = 0;
    /// Place of channel `i` among the groups: mean, RMS, minimum, maximum, deviation from the mean.
    pub(crate) fn channel(&self, i: usize) -> usize {
        1 + i
    }
    /// Place of contact `i` among the groups: times on the lower flank, in the gap and on the upper flank,
    /// impacts on the lower and on the upper flank.
    pub(crate) fn contact(&self, i: usize) -> usize {
        self.channel(self.channels) + i
    }
    /// A group of a row.
    pub(crate) fn group(row: &[f64], place: usize) -> &[f64; Layout::GROUP] {
        &row.as_chunks().0[place]
    }
    pub(crate) fn group_mut(row: &mut [f64], place: usize) -> &mut [f64; Layout::GROUP] {
        &mut row.as_chunks_mut().0[place]
    }
    /// Number of values of a strobed period: minimum and maximum of each channel, then the state at its end.
    pub(crate) fn strobe_width(&self) -> usize {
        2 * self.channels + 2 * self.dof
    }
    /// Position of the Lyapunov exponent.
    pub(crate) fn exponent(&self) -> usize {
        Layout::GROUP * self.contact(self.contacts)
    }
    /// Position of the multipliers.
    pub(crate) fn multiplier(&self) -> usize {
        self.exponent() + self.exponents
    }
    /// Position of strobed period `i`.
    pub(crate) fn strobe(&self, i: usize) -> usize {
        self.multiplier() + self.multipliers + self.strobe_width() * i
    }
    /// The [`stride`](Layout::stride); `None` if it exceeds `usize::MAX`.
    pub(crate) fn stride_checked(&self) -> Option<usize> {
        let strobes = self.channels.checked_add(self.dof)?.checked_mul(2)?.checked_mul(self.strobes)?;
        let groups = self.channels.checked_add(self.contacts)?.checked_add(1)?;
        strobes
            .checked_add(groups.checked_mul(Layout::GROUP)?)?
            .checked_add(self.exponents)?
            .checked_add(self.multipliers)
    }
    /// Whether this is the layout of some model in the sweep.
    #[cfg(feature = "serde")]
    pub(crate) fn fits(&self, sweep: &Sweep) -> bool {
        self.dof > 0
            && self.channels == sweep.names().len()
            && self.strobes == sweep.strobes.min(sweep.measure)
            && self.exponents == sweep.exponents()
            && self.multipliers == sweep.multipliers_of(self.dof)
            && (sweep.rattle || self.contacts == 0)
    }
    /// Number of values of a row.
    pub(crate) fn stride(&self) -> usize {
        self.strobe(self.strobes)
    }
}
