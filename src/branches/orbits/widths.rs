//! The units of coordinates and velocities on a line: their ranges of motion, with a memory.

/// Least unit of a component whose motion vanishes while others stay: this share of its widest range.
const SHARE: f64 = 0.1;

/// The units of coordinates and velocities on a line of orbits.
///
/// The unit of component k is its range of motion r_k, but at least 0.1 w_k max_j r_j/w_j. w_k is the widest
/// range of the component so far.
///
/// The least unit serves branches that meet an orbit with equal motions of equal members. The range of the
/// difference of two members tends to 0 there. A unit that also tends to 0 would put this orbit at an
/// infinite arclength.
#[derive(Clone, Debug)]
pub(crate) struct Widths {
    units: Vec<f64>,
    widest: Vec<f64>,
}

impl Widths {
    /// The ranges of the first orbit.
    pub(crate) fn new(ranges: &[f64]) -> Self {
        Widths { units: ranges.to_vec(), widest: ranges.to_vec() }
    }

    /// Takes the ranges of the next orbit.
    pub(crate) fn accept(&mut self, ranges: &[f64]) {
        self.widest.iter_mut().zip(ranges).for_each(|(widest, range)| *widest = widest.max(*range));
        let shares = self.widest.iter().zip(ranges).filter(|(widest, _)| **widest > 0.0);
        let most = shares.map(|(widest, range)| range / widest).fold(0.0, f64::max);
        let least = self.widest.iter().map(|widest| SHARE * widest * most);
        self.units.clear();
        self.units.extend(least.zip(ranges).map(|(least, range)| range.max(least)));
    }

    /// The units of the coordinates, then of the velocities.
    pub(crate) fn units(&self) -> &[f64] {
        &self.units
    }
}
