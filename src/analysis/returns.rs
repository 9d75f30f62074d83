//! How closely a motion comes back.

use crate::roots::norms::remove;

/// How far every coordinate and velocity moves, rigid motion left out: the unit in which returns are measured.
///
/// A state is coordinates, then velocities.
pub(crate) struct Ranges {
    rigid: Vec<Vec<f64>>,
    y: Vec<f64>,
    low: Vec<f64>,
    high: Vec<f64>,
    /// Largest value of each component as it stands.
    largest: Vec<f64>,
}

/// Rounding of a value, as a share of it.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

impl Ranges {
    /// `rigid`: orthonormal directions of the coordinates that do not count; directions that leave nothing are taken for none.
    pub(crate) fn new(dof: usize, mut rigid: Vec<Vec<f64>>) -> Self {
        if rigid.len() >= dof {
            rigid.clear();
        }
        let m = 2 * dof;
        Ranges {
            rigid,
            y: vec![0.0; m],
            low: vec![f64::INFINITY; m],
            high: vec![f64::NEG_INFINITY; m],
            largest: vec![0.0; m],
        }
    }

    /// Takes rigid motion out of a state.
    fn relative(rigid: &[Vec<f64>], y: &mut [f64]) {
        let (q, v) = y.split_at_mut(y.len() / 2);
        for r in rigid {
            remove(r, q);
            remove(r, v);
        }
    }

    pub(crate) fn see(&mut self, y: &[f64]) {
        self.y.copy_from_slice(y);
        self.largest.iter_mut().zip(y).for_each(|(largest, y)| *largest = largest.max(y.abs()));
        Ranges::relative(&self.rigid, &mut self.y);
        for ((y, low), high) in self.y.iter().zip(&mut self.low).zip(&mut self.high) {
            *low = low.min(*y);
            *high = high.max(*y);
        }
    }

    /// Halves the ranges about their middles, so that transients are forgotten.
    pub(crate) fn fade(&mut self) {
        for ((low, high), largest) in self.low.iter_mut().zip(&mut self.high).zip(&mut self.largest) {
            let middle = 0.5 * (*low + *high);
            if middle.is_finite() {
                (*low, *high) = (middle - 0.25 * (*high - *low), middle + 0.25 * (*high - *low));
            }
            *largest *= 0.5;
        }
    }

    /// The largest difference of two states, each component in units of its range. A difference above the tolerance counts as 0 if rounding
    /// explains it.
    pub(crate) fn distance(&mut self, a: &[f64], b: &[f64], tolerance: f64) -> f64 {
        let n = a.len() / 2;
        self.y.iter_mut().zip(a.iter().zip(b)).for_each(|(y, (a, b))| *y = a - b);
        Ranges::relative(&self.rigid, &mut self.y);
        // Couplings, and taking rigid motion out, bring in the rounding of all coordinates, or of all velocities.
        let largest = |of: &[f64], now: &[f64]| of.iter().chain(now).fold(0.0, |m: f64, x| m.max(x.abs()));
        let (of_q, of_v) = (largest(&self.largest[..n], &a[..n]), largest(&self.largest[n..], &a[n..]));
        self.y.iter().enumerate().fold(0.0, |worst: f64, (i, apart)| {
            let rounding = ROUNDING * if i < n { of_q } else { of_v };
            let size = (self.high[i] - self.low[i]).max(rounding);
            // Not a number is no return.
            let share = if *apart == 0.0 { 0.0 } else { apart.abs() / size };
            let share = if share > tolerance && apart.abs() <= rounding { 0.0 } else { share };
            if share.is_nan() { f64::INFINITY } else { worst.max(share) }
        })
    }
}

/// A motion that winds into an orbit comes back closer after some multiples of its period than after one; it is p periods long only if it comes
/// back this much closer than after any divisor of p.
const CLOSER: f64 = 1e-3;

/// Whether returns after 1, 2, ..., p periods, by their distances, tell of an orbit of p periods and none shorter.
pub(crate) fn is_own_multiple(returns: &[f64]) -> bool {
    let (p, last) = (returns.len(), returns[returns.len() - 1]);
    (1..p).filter(|d| p.is_multiple_of(*d)).all(|d| last <= CLOSER * returns[d - 1])
}
