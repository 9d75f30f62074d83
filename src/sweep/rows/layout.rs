//! Where the figures of a row stand.

/// Where the figures of a row stand.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Layout {
    pub(crate) dof: usize,
    pub(crate) channels: usize,
    pub(crate) contacts: usize,
    /// Periods of which the strobed state and the extremes of the channels are kept.
    pub(crate) strobes: usize,
    /// The largest Lyapunov exponent and its standard error: 2 figures, or 0.
    pub(crate) exponents: usize,
}

impl Layout {
    /// Period multiple, change, periods settled, margin to grazing, scatter.
    pub(crate) const HEAD: usize = 5;
    /// Of a channel: mean, RMS, least and largest value, deviation from the mean.
    const FIGURES: usize = 5;
    pub(crate) fn channel(&self, i: usize) -> usize {
        Layout::HEAD + Layout::FIGURES * i
    }
    pub(crate) fn contact(&self, i: usize) -> usize {
        self.channel(self.channels) + 5 * i
    }
    /// Least and largest value of each channel, then the state.
    pub(crate) fn strobe_width(&self) -> usize {
        2 * self.channels + 2 * self.dof
    }
    pub(crate) fn exponent(&self) -> usize {
        self.contact(self.contacts)
    }
    pub(crate) fn strobe(&self, i: usize) -> usize {
        self.exponent() + self.exponents + self.strobe_width() * i
    }
    /// The stride, if it can be counted.
    pub(crate) fn stride_checked(&self) -> Option<usize> {
        let strobes = self.channels.checked_add(self.dof)?.checked_mul(2)?.checked_mul(self.strobes)?;
        let rest = self.channels.checked_mul(Layout::FIGURES)?.checked_add(self.contacts.checked_mul(5)?)?;
        strobes.checked_add(rest)?.checked_add(Layout::HEAD + self.exponents)
    }
    pub(crate) fn stride(&self) -> usize {
        self.strobe(self.strobes)
    }
}
