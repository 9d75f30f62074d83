//! Wave vectors of a Fourier series in several angles.

use crate::error::{ParameterError, check};

/// Wave vectors k of a real Fourier series Σ_k c_k exp(i k·θ) in D angles.
///
/// Of each pair k and -k the vector whose first entry other than 0 is positive is listed. The list is in
/// lexicographic order and begins with 0.
///
/// The coefficients of a smooth torus decay as exp(-Σ σ_d |k_d|). The set [`within`](WaveVectors::within)
/// follows this decay. The box contains about D! times as many vectors for the same highest orders; its
/// additional vectors are combinations of high orders of several angles. Choose the box if sidebands of high
/// orders are large, as those of a mesh whose stiffness varies strongly with another shaft.
///
/// ```
/// use gear_dynamics::tori::WaveVectors;
/// let diamond = WaveVectors::within(&[2, 1])?; // |k_1|/2 + |k_2|/1 <= 1
/// assert_eq!(diamond.vectors().collect::<Vec<_>>(), [[0, 0], [0, 1], [1, 0], [2, 0]]);
/// assert_eq!(WaveVectors::in_box(&[2, 1])?.len(), 8); // (5·3 + 1)/2
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WaveVectors {
    highest: Vec<usize>,
    /// One vector after the other.
    all: Vec<i32>,
}

/// Maximum number of points of the box around the set.
const MAX_BOX: usize = 1 << 22;

/// Σ |k_d|/H_d exceeds 1 by at most this rounding error on the boundary `[1]`.
const ROUNDING: f64 = 1e-12;

impl WaveVectors {
    /// All k with |k_1|/H_1 + ... + |k_D|/H_D <= 1.
    ///
    /// # Errors
    /// No highest order H_d, one of 0, or more than 2²² points in the box around the set.
    pub fn within(highest: &[usize]) -> Result<Self, ParameterError> {
        let weight = |k: &[i32]| -> f64 {
            k.iter().zip(highest).map(|(k, h)| f64::from(k.unsigned_abs()) / *h as f64).sum()
        };
        WaveVectors::accepted(highest, |k| weight(k) <= 1.0 + ROUNDING)
    }

    /// All k with |k_d| <= H_d for every d.
    ///
    /// # Errors
    /// As [`within`](WaveVectors::within).
    pub fn in_box(highest: &[usize]) -> Result<Self, ParameterError> {
        WaveVectors::accepted(highest, |_| true)
    }

    fn accepted(highest: &[usize], accepts: impl Fn(&[i32]) -> bool) -> Result<Self, ParameterError> {
        if highest.is_empty() {
            return Err(ParameterError::Empty { name: "highest orders".into(), min: 1 });
        }
        if let Some(d) = highest.iter().position(|h| *h == 0) {
            let name = format!("highest order {d}");
            return Err(ParameterError::TooFew { name, value: 0, min: 1 });
        }
        let widths: Vec<usize> = highest.iter().map(|h| h.saturating_mul(2).saturating_add(1)).collect();
        let points = check::count("wave vectors", &widths, MAX_BOX)?;
        let (mut all, mut k) = (Vec::new(), vec![0i32; highest.len()]);
        for point in 0..points {
            let mut rest = point;
            for d in (0..k.len()).rev() {
                k[d] = (rest % widths[d]) as i32 - highest[d] as i32;
                rest /= widths[d];
            }
            let first = k.iter().find(|k| **k != 0);
            if first.is_none_or(|k| *k > 0) && accepts(&k) {
                all.extend(&k);
            }
        }
        Ok(WaveVectors { highest: highest.to_vec(), all })
    }

    /// Number of angles D.
    pub fn angles(&self) -> usize {
        self.highest.len()
    }
    /// The highest order of each angle.
    pub fn highest(&self) -> &[usize] {
        &self.highest
    }
    /// Number of listed vectors, 0 included.
    pub fn len(&self) -> usize {
        self.all.len() / self.angles()
    }
    /// Whether no vector is listed: never.
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }
    /// The listed vectors.
    pub fn vectors(&self) -> impl Iterator<Item = &[i32]> {
        self.all.chunks_exact(self.angles())
    }
    /// The vector with the given index.
    pub(crate) fn vector(&self, index: usize) -> &[i32] {
        &self.all[index * self.angles()..(index + 1) * self.angles()]
    }

    /// Index of k or of -k in the list, and whether it is -k; `None` if neither is listed.
    pub(crate) fn place(&self, k: &[i32]) -> Option<(usize, bool)> {
        if k.len() != self.angles() {
            return None;
        }
        let mirrored = k.iter().find(|k| **k != 0).is_some_and(|k| *k < 0);
        let sign = if mirrored { -1 } else { 1 };
        let compare = |index: usize| self.vector(index).iter().copied().cmp(k.iter().map(|k| sign * k));
        let (mut low, mut high) = (0, self.len());
        while low < high {
            let middle = (low + high) / 2;
            match compare(middle) {
                std::cmp::Ordering::Less => low = middle + 1,
                std::cmp::Ordering::Greater => high = middle,
                std::cmp::Ordering::Equal => return Some((middle, mirrored)),
            }
        }
        None
    }

    /// Unknowns of one coordinate: the mean, and a cosine and a sine for every other vector.
    pub(crate) fn unknowns(&self) -> usize {
        2 * self.len() - 1
    }

    /// Whether a neighbour of the vector, one order higher or lower in one angle, is not in the set.
    pub(crate) fn is_outermost(&self, index: usize) -> bool {
        let mut k = self.vector(index).to_vec();
        (0..k.len()).any(|d| {
            [1, -1].into_iter().any(|by| {
                k[d] += by;
                let outside = self.place(&k).is_none();
                k[d] -= by;
                outside
            })
        })
    }
}
