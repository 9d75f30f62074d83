//! Distances between states a whole number of periods apart.

use crate::numeric::norms::remove;

/// Range (max - min) of every coordinate and velocity, without rigid motion: the unit of distances between
/// states.
///
/// A state is a slice of coordinates, then velocities.
pub(crate) struct Ranges {
    rigid: Vec<Vec<f64>>,
    y: Vec<f64>,
    low: Vec<f64>,
    high: Vec<f64>,
    /// Largest absolute value of each component, rigid motion included.
    largest: Vec<f64>,
}

/// Rounding of a value, relative to the value.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

impl Ranges {
    /// `rigid`: orthonormal directions of rigid motion in the coordinates. If they leave no relative motion,
    /// they are ignored.
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

    /// q ← q - Σ_r r (rᵀ q), v ← v - Σ_r r (rᵀ v): removes rigid motion from a state.
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

    /// Halves every range about its middle, and every largest value, so that transients lose their weight.
    pub(crate) fn fade(&mut self) {
        for ((low, high), largest) in self.low.iter_mut().zip(&mut self.high).zip(&mut self.largest) {
            let middle = 0.5 * (*low + *high);
            if middle.is_finite() {
                (*low, *high) = (middle - 0.25 * (*high - *low), middle + 0.25 * (*high - *low));
            }
            *largest *= 0.5;
        }
    }

    /// max_i |Δy_i|/max(range_i, rounding_i), with Δy = a - b without rigid motion.
    ///
    /// A component above the tolerance counts as 0 if |Δy_i| <= rounding_i.
    pub(crate) fn distance(&mut self, a: &[f64], b: &[f64], tolerance: f64) -> f64 {
        let n = a.len() / 2;
        self.y.iter_mut().zip(a.iter().zip(b)).for_each(|(y, (a, b))| *y = a - b);
        Ranges::relative(&self.rigid, &mut self.y);
        // Couplings and the removal of rigid motion spread rounding between coordinates, and between
        // velocities. Rounding therefore follows the largest coordinate and the largest velocity.
        let largest = |of: &[f64], now: &[f64]| of.iter().chain(now).fold(0.0, |m: f64, x| m.max(x.abs()));
        let (of_q, of_v) = (largest(&self.largest[..n], &a[..n]), largest(&self.largest[n..], &a[n..]));
        self.y.iter().enumerate().fold(0.0, |worst: f64, (i, apart)| {
            let rounding = ROUNDING * if i < n { of_q } else { of_v };
            let size = (self.high[i] - self.low[i]).max(rounding);
            // A NaN gives an infinite distance.
            let share = if *apart == 0.0 { 0.0 } else { apart.abs() / size };
            let share = if share > tolerance && apart.abs() <= rounding { 0.0 } else { share };
            if share.is_nan() { f64::INFINITY } else { worst.max(share) }
        })
    }
}

/// Largest ratio of the distance after p periods to the distance after a proper divisor of p, for an orbit of
/// p periods. A motion that spirals into a shorter orbit may also return closer after a multiple of its
/// period.
const CLOSER: f64 = 1e-3;

/// Whether d_p <= `CLOSER` d_k for every proper divisor k of p: the orbit is p periods long and no shorter.
///
/// `returns` holds the distances d_1, d_2, ..., d_p after 1, 2, ..., p periods.
pub(crate) fn is_own_multiple(returns: &[f64]) -> bool {
    let (p, last) = (returns.len(), returns[returns.len() - 1]);
    (1..p).filter(|d| p.is_multiple_of(*d)).all(|d| last <= CLOSER * returns[d - 1])
}
