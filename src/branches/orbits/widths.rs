//! The units of coordinates and velocities on a line: their ranges of motion, with a memory.

/// Least unit of a component whose motion vanishes while others stay: this share of its widest range.
const SHARE: f64 = 0.1;

/// The units of coordinates and velocities on a line of orbits.
///
/// The unit of a component is its range of motion. Where the range of one component vanishes and others
/// stay, as the difference of two equal members does towards an orbit with equal motions, a unit that
/// vanishes with it would put that orbit at an infinite arclength: the unit of component k is at least
/// 0.1 w_k max_j r_j/w_j, with the ranges r and the widest ranges w so far.
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
