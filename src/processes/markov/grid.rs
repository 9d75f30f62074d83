//! Grids of time.

/// The instants k h. Cell k is k h <= t < (k + 1) h, in which k h is the rounded product.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grid {
    pub(crate) spacing: f64,
}

impl Grid {
    /// The instant k h.
    #[inline]
    pub(crate) fn node(&self, k: i64) -> f64 {
        k as f64 * self.spacing
    }
    /// The cell of an instant, at most ±2^52.
    #[inline]
    pub(crate) fn cell(&self, t: f64) -> i64 {
        let guess = (t / self.spacing).floor();
        if guess.abs() >= LAST {
            return guess.clamp(-LAST, LAST) as i64;
        }
        let mut k = guess as i64;
        while self.node(k) > t {
            k -= 1;
        }
        while self.node(k + 1) <= t {
            k += 1;
        }
        k
    }
    /// The share of cell k that has passed at `t` `[1]`.
    #[inline]
    pub(crate) fn share(&self, k: i64, t: f64) -> f64 {
        ((t - self.node(k)) / self.spacing).min(1.0)
    }
    /// The first node after `t`; `None` beyond the last cell.
    pub(crate) fn next_node(&self, t: f64) -> Option<f64> {
        let node = self.node(self.cell(t) + 1);
        (node > t).then_some(node)
    }
}

/// 2^52: largest index of a cell. The numbers k and k + 1 are exact up to here.
const LAST: f64 = 4_503_599_627_370_496.0;
