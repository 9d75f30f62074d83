//! Fourier coefficients of a periodic slope, and its product with a harmonic.

use crate::periodic::balance::series::harmonics::Harmonics;
use num_complex::Complex64;

/// Coefficients D_k of D(t) = Σ_k D_k e^{i k ω t}, k = -2H ..= 2H, as real and imaginary parts.
pub(crate) struct SlopeTable {
    re: Vec<f64>,
    im: Vec<f64>,
    middle: usize,
}

impl SlopeTable {
    /// All coefficients zero; `highest` is H.
    pub(crate) fn new(highest: usize) -> Self {
        SlopeTable { re: vec![0.0; 4 * highest + 1], im: vec![0.0; 4 * highest + 1], middle: 2 * highest }
    }

    /// Highest k.
    pub(crate) fn reach(&self) -> usize {
        self.middle
    }

    /// Sets D_k, and D_{-k} to its conjugate.
    pub(crate) fn set(&mut self, k: usize, d: Complex64) {
        (self.re[self.middle + k], self.im[self.middle + k]) = (d.re, d.im);
        if k > 0 {
            (self.re[self.middle - k], self.im[self.middle - k]) = (d.re, -d.im);
        }
    }

    /// Adds `scale` times the coefficients of D(t) cos(lωt), or of D(t) sin(lωt).
    ///
    /// With D∓ = D_{k∓l}: cosine rows Re(D- + D+) or Im(D- - D+), sine rows -Im(D- + D+) or Re(D- - D+). The
    /// mean row is half the cosine row of k = 0.
    #[inline]
    pub(crate) fn add(&self, block: &mut [f64], harmonics: &Harmonics, l: usize, sine: bool, scale: f64) {
        let orders = harmonics.orders();
        let mut rows = block;
        let mut kept = orders;
        if orders[0] == 0 {
            let d = self.middle + l;
            let mean = if sine { -self.im[d] } else { self.re[d] };
            let (first, rest) = rows.split_at_mut(1);
            first[0] += scale * mean;
            (rows, kept) = (rest, &orders[1..]);
        }
        let Some(&lowest) = kept.first() else {
            return;
        };
        let contiguous = kept[kept.len() - 1] - lowest + 1 == kept.len();
        if contiguous {
            let (low, high) = (self.middle + lowest - l, self.middle + lowest + l);
            let n = kept.len();
            let (re0, im0) = (&self.re[low..low + n], &self.im[low..low + n]);
            let (re1, im1) = (&self.re[high..high + n], &self.im[high..high + n]);
            let rows = &mut rows[..2 * n];
            if sine {
                for i in 0..n {
                    rows[2 * i] += scale * (im0[i] - im1[i]);
                    rows[2 * i + 1] += scale * (re0[i] - re1[i]);
                }
            } else {
                for i in 0..n {
                    rows[2 * i] += scale * (re0[i] + re1[i]);
                    rows[2 * i + 1] -= scale * (im0[i] + im1[i]);
                }
            }
        } else {
            for (pair, &k) in rows.chunks_exact_mut(2).zip(kept) {
                let (low, high) = (self.middle + k - l, self.middle + k + l);
                if sine {
                    pair[0] += scale * (self.im[low] - self.im[high]);
                    pair[1] += scale * (self.re[low] - self.re[high]);
                } else {
                    pair[0] += scale * (self.re[low] + self.re[high]);
                    pair[1] -= scale * (self.im[low] + self.im[high]);
                }
            }
        }
    }
}
