//! Waves in plain numbers, from one sine and cosine of their angle.

use crate::model::expansion::fourier_angle::fourier_waves;
use crate::model::shape::Shape;
use crate::numeric::sine::sin_cos_each;
use pulp::{Arch, Simd, WithSimd};
use std::collections::BTreeMap;

/// Maximum number of orders that are computed by rotation one after the other. Each rotation adds its
/// rounding errors; the order after them has a sine and a cosine of its own.
const ROTATIONS: usize = 8;

/// Maximum number of groups of neighbouring orders, if there are fewer waves that vary. With more groups
/// products are evaluated faster by their factors.
const GROUPS: usize = 4;

/// The waves of a shape that are finite Fourier series: u_k = mean_k + Σ_n a_kn cos nφ + b_kn sin nφ.
pub(crate) struct TurningWaves {
    /// The mean of each wave.
    means: Vec<f64>,
    /// The waves that vary, each function once.
    moving: Vec<Moving>,
    /// The lowest order.
    first: f64,
    /// All other orders, increasing.
    others: Vec<Order>,
}

/// A wave that varies.
struct Moving {
    wave: usize,
    mean: f64,
    /// a and b of the lowest order.
    first: [f64; 2],
    /// Waves that are the same function.
    copies: Vec<usize>,
}

struct Order {
    n: f64,
    /// Whether it is the order before it, turned by the lowest order.
    rotated: bool,
    /// Index of the wave, a and b of each term.
    terms: Vec<(usize, [f64; 2])>,
}

impl TurningWaves {
    /// `None` if the shape has edges, waves that are no finite Fourier series or too many groups of orders
    /// ([`GROUPS`]).
    pub(crate) fn of<G: Shape>(shape: &G) -> Option<Self> {
        let waves = fourier_waves(shape)?;
        let first = waves.iter().filter_map(|(_, terms)| Some(terms.first()?.0)).min().unwrap_or(0);
        let mut known: BTreeMap<Vec<(usize, [u64; 2])>, usize> = BTreeMap::new();
        let mut by_order: BTreeMap<usize, Vec<(usize, [f64; 2])>> = BTreeMap::new();
        let mut moving: Vec<Moving> = Vec::new();
        for (wave, (mean, terms)) in waves.iter().enumerate().filter(|(_, (_, terms))| !terms.is_empty()) {
            let numbers = terms.iter().copied().chain([(0, [*mean, 0.0])]);
            let of = *known
                .entry(numbers.map(|(n, x)| (n, x.map(f64::to_bits))).collect())
                .or_insert(moving.len());
            if let Some(same) = moving.get_mut(of) {
                same.copies.push(wave);
                continue;
            }
            let mut own = Moving { wave, mean: *mean, first: [0.0; 2], copies: Vec::new() };
            for &(n, pair) in terms {
                match n == first {
                    true => own.first = pair,
                    false => by_order.entry(n).or_default().push((wave, pair)),
                }
            }
            moving.push(own);
        }
        let (mut last, mut rotations, mut groups) = (first, 0, 1);
        let others = by_order.into_iter().map(|(n, terms)| {
            let next = n == last + first;
            let rotated = next && rotations < ROTATIONS;
            groups += usize::from(!next);
            (last, rotations) = (n, if rotated { rotations + 1 } else { 0 });
            Order { n: n as f64, rotated, terms }
        });
        let others = others.collect();
        let means = waves.iter().map(|(mean, _)| *mean).collect();
        (groups <= GROUPS.max(moving.len())).then_some(TurningWaves {
            means,
            moving,
            first: first as f64,
            others,
        })
    }

    /// Writes all waves at an angle.
    pub(crate) fn write(&self, angle: f64, u: &mut [f64]) {
        u.copy_from_slice(&self.means);
        self.write_again(angle, u);
    }

    /// Writes the waves that vary.
    #[inline]
    pub(crate) fn write_again(&self, angle: f64, u: &mut [f64]) {
        if !self.moving.is_empty() {
            self.write_rows([angle], [u]);
        }
    }

    /// Writes the waves that vary at the angles φ' t of several instants t, row by row of length `drives`.
    #[inline]
    pub(crate) fn write_nodes(&self, speed: f64, times: &[f64], u: &mut [f64], drives: usize) {
        if self.moving.is_empty() {
            return;
        }
        let rows = Rows { waves: self, speed, times, u, drives };
        // The call of the code for the instructions of the processor takes longer than two instants.
        if times.len() <= 2 { rows.run() } else { Arch::new().dispatch(rows) }
    }

    /// Writes the waves that vary at several angles.
    #[inline(always)]
    fn write_rows<const W: usize>(&self, angles: [f64; W], u: [&mut [f64]; W]) {
        let first = turned(&angles, self.first);
        let [mut s, mut c] = first;
        for Moving { wave, mean, first: [a, b], .. } in &self.moving {
            for i in 0..W {
                u[i][*wave] = mean + (a * c[i] + b * s[i]);
            }
        }
        for Order { n, rotated, terms } in &self.others {
            if *rotated {
                for i in 0..W {
                    let [sine, cosine] = [first[0][i], first[1][i]];
                    (s[i], c[i]) = (s[i] * cosine + c[i] * sine, c[i] * cosine - s[i] * sine);
                }
            } else {
                [s, c] = turned(&angles, *n);
            }
            for &(wave, [a, b]) in terms {
                for i in 0..W {
                    u[i][wave] += a * c[i] + b * s[i];
                }
            }
        }
        for Moving { wave, copies, .. } in &self.moving {
            let mut values = [0.0; W];
            for i in 0..W {
                values[i] = u[i][*wave];
            }
            for &copy in copies {
                for i in 0..W {
                    u[i][copy] = values[i];
                }
            }
        }
    }
}

/// Rows of drives at several instants.
struct Rows<'a> {
    waves: &'a TurningWaves,
    speed: f64,
    times: &'a [f64],
    u: &'a mut [f64],
    drives: usize,
}

impl WithSimd for Rows<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.run();
    }
}

impl Rows<'_> {
    #[inline(always)]
    fn run(mut self) {
        while self.times.len() >= 4 {
            self.next::<4>();
        }
        if self.times.len() >= 2 {
            self.next::<2>();
        }
        if !self.times.is_empty() {
            self.next::<1>();
        }
    }

    /// Writes the next W rows.
    #[inline(always)]
    fn next<const W: usize>(&mut self) {
        let (times, later) = self.times.split_at(W);
        let (rows, rest) = std::mem::take(&mut self.u).split_at_mut(W * self.drives);
        (self.times, self.u) = (later, rest);
        let mut angles = [0.0; W];
        for i in 0..W {
            angles[i] = self.speed * times[i];
        }
        let mut rows = rows.chunks_exact_mut(self.drives);
        self.waves.write_rows(angles, std::array::from_fn(|_| rows.next().unwrap_or_default()));
    }
}

/// Sines and cosines of `order` times the angles.
#[inline(always)]
fn turned<const W: usize>(angles: &[f64; W], order: f64) -> [[f64; W]; 2] {
    let mut turned = [0.0; W];
    for i in 0..W {
        turned[i] = order * angles[i];
    }
    sin_cos_each(turned)
}
