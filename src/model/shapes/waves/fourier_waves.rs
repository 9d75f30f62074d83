//! The waves of a shape as finite Fourier series: their values, from one sine and cosine of the angle.

use crate::excitation::wave_weights::{Sizes, WaveWeights};
use crate::model::shapes::shape::Shape;
use crate::model::shapes::waves::fourier_angle::{Harmonics, fourier_waves};
use crate::numeric::sine::{rotate, sin_cos_of_multiples};
use pulp::{Arch, Simd, WithSimd};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// Maximum number of orders that are computed by rotation one after the other. Each rotation adds its
/// rounding errors; the order after them has a sine and a cosine of its own.
const ROTATIONS: usize = 8;

/// Maximum number of groups of neighbouring orders, if there are fewer waves that vary. With more groups
/// products are evaluated faster by their factors.
const GROUPS: usize = 4;

/// Maximum number of terms of a wave that is expanded, and of different orders of all waves.
const TERMS: usize = 128;
pub(super) const ORDERS: usize = 512;

/// Numbers of orders up to which the array of their sines and cosines is small: a large one would be
/// cleared at each instant.
pub(super) const FEW: usize = 16;
const SOME: usize = 64;

/// Waves u_k = mean_k + Σ_n a_kn cos nφ + b_kn sin nφ.
pub struct FourierWaves {
    /// The mean of each wave.
    pub(super) means: Vec<f64>,
    /// All orders n, increasing.
    pub(super) orders: Vec<Order>,
    /// Index of the order, a and b of each term of each wave.
    pub(super) terms: Vec<Vec<Term>>,
    /// Waves that vary, each function once.
    varying: Vec<Varying>,
    /// Waves that stand for others, with those, which are the same function.
    copies: Vec<(usize, Vec<usize>)>,
    /// Whether the values are computed faster from the series than by the excitations.
    pub(crate) is_fast: bool,
    /// ±n^k/k! of each order; `None` if there are too many terms for an expansion.
    pub(crate) weights: Option<Vec<WaveWeights>>,
    /// What the sums of each wave may hide.
    pub(super) sizes: Vec<Option<Sizes>>,
    pub(super) arch: Arch,
}

impl fmt::Debug for FourierWaves {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("FourierWaves").field("means", &self.means).finish_non_exhaustive()
    }
}

/// Index of an order, a and b.
pub(super) type Term = (usize, [f64; 2]);

/// Sines and cosines of an order at several angles.
pub(super) type Turn<const W: usize> = [[f64; W]; 2];

/// A wave that varies.
struct Varying {
    wave: usize,
    mean: f64,
    /// a and b of the lowest order.
    lowest: [f64; 2],
    /// Index of the first term of another order.
    others: usize,
}

pub(super) struct Order {
    n: f64,
    /// Whether it is the order before it, turned by the lowest order.
    rotated: bool,
}

impl FourierWaves {
    /// The waves of a shape; `None` if it has edges, or waves that are no finite Fourier series.
    pub(crate) fn of<G: Shape>(shape: &G) -> Option<Self> {
        Some(FourierWaves::new(&fourier_waves(shape)?, 1))
    }

    /// Waves whose orders are counted in `repeats`.
    pub(super) fn new(waves: &[Harmonics], repeats: u32) -> Self {
        let known: BTreeSet<usize> = waves.iter().flat_map(|(_, terms)| terms).map(|(n, _)| *n).collect();
        let lowest = known.first().copied().unwrap_or(0);
        let mut functions: BTreeMap<Vec<(usize, [u64; 2])>, usize> = BTreeMap::new();
        let (mut copies, mut varying): (BTreeMap<usize, Vec<usize>>, _) = (BTreeMap::new(), Vec::new());
        for (wave, (mean, terms)) in waves.iter().enumerate().filter(|(_, (_, terms))| !terms.is_empty()) {
            let numbers = terms.iter().copied().chain([(0, [*mean, 0.0])]);
            let numbers = numbers.map(|(n, x)| (n, x.map(f64::to_bits))).collect();
            match *functions.entry(numbers).or_insert(wave) {
                first if first != wave => copies.entry(first).or_default().push(wave),
                _ => varying.push((wave, *mean, terms)),
            }
        }
        let (mut last, mut rotations, mut groups) = (0, 0, 0);
        let orders = known.iter().map(|&n| {
            let next = last > 0 && n == last + lowest;
            let rotated = next && rotations < ROTATIONS;
            groups += usize::from(!next);
            (last, rotations) = (n, if rotated { rotations + 1 } else { 0 });
            Order { n: n as f64 * f64::from(repeats), rotated }
        });
        let orders: Vec<Order> = orders.collect();
        let few = orders.len() <= ORDERS && waves.iter().all(|(_, terms)| terms.len() <= TERMS);
        let places: BTreeMap<usize, usize> = known.iter().enumerate().map(|(place, n)| (*n, place)).collect();
        let placed = |(n, pair): &Term| (places[n], *pair);
        let varying = varying.iter().map(|(wave, mean, terms)| {
            let split = usize::from(terms[0].0 == lowest);
            let lowest = terms[..split].first().map_or([0.0; 2], |(_, pair)| *pair);
            Varying { wave: *wave, mean: *mean, lowest, others: split }
        });
        let varying: Vec<Varying> = varying.collect();
        let terms: Vec<Vec<Term>> =
            waves.iter().map(|(_, terms)| terms.iter().map(placed).collect()).collect();
        let weights = few.then(|| orders.iter().map(|order| WaveWeights::new(order.n)).collect::<Vec<_>>());
        let sizes = terms.iter().map(|terms| {
            let weights = weights.as_ref()?;
            Sizes::of(terms.iter().map(|&(i, [a, b])| (orders[i].n, a.hypot(b), &weights[i])))
        });
        FourierWaves {
            means: waves.iter().map(|(mean, _)| *mean).collect(),
            sizes: sizes.collect(),
            terms,
            copies: copies.into_iter().collect(),
            is_fast: groups <= GROUPS.max(varying.len()) && orders.len() <= ORDERS,
            varying,
            weights,
            orders,
            arch: Arch::new(),
        }
    }

    /// Writes all waves at an angle.
    pub(crate) fn write(&self, angle: f64, u: &mut [f64]) {
        u.copy_from_slice(&self.means);
        self.write_rows([angle], [u]);
    }

    /// Writes the waves that vary at the angles φ' t of several instants t, row by row of length `drives`.
    #[inline]
    pub(crate) fn write_again(&self, speed: f64, times: &[f64], u: &mut [f64], drives: usize) {
        if self.orders.is_empty() {
            return;
        }
        let rows = Rows { waves: self, speed, times, u, drives };
        // The call of the code for the instructions of the processor takes longer than two instants.
        if times.len() <= 2 { rows.run() } else { self.arch.dispatch(rows) }
    }

    /// Writes the waves that vary at several angles.
    #[inline(always)]
    fn write_rows<const W: usize>(&self, angles: [f64; W], u: [&mut [f64]; W]) {
        match self.orders.len() {
            0 => {}
            1 => self.write_sums(angles, u, &mut [[[0.0; W]; 2]; 1]),
            n if n <= FEW => self.write_sums(angles, u, &mut [[[0.0; W]; 2]; FEW]),
            n if n <= SOME => self.write_sums(angles, u, &mut [[[0.0; W]; 2]; SOME]),
            _ => self.write_sums(angles, u, &mut [[[0.0; W]; 2]; ORDERS]),
        }
    }

    /// Writes the waves that vary at several angles, with an array for the sines and cosines of all orders.
    #[inline(always)]
    fn write_sums<const W: usize>(&self, angles: [f64; W], u: [&mut [f64]; W], turns: &mut [Turn<W>]) {
        let lowest = self.turn(&angles, turns);
        for Varying { wave, mean, lowest: [a, b], others } in &self.varying {
            let mut sums = [0.0; W];
            for i in 0..W {
                sums[i] = mean + (a * lowest[1][i] + b * lowest[0][i]);
            }
            for &(order, [a, b]) in &self.terms[*wave][*others..] {
                let [s, c] = &turns[order];
                for i in 0..W {
                    sums[i] += a * c[i] + b * s[i];
                }
            }
            for i in 0..W {
                u[i][*wave] = sums[i];
            }
        }
        for (of, copies) in &self.copies {
            let values: [f64; W] = std::array::from_fn(|i| u[i][*of]);
            for &copy in copies {
                for i in 0..W {
                    u[i][copy] = values[i];
                }
            }
        }
    }

    /// Writes sines and cosines of the angles times each order, and returns those of the lowest order.
    #[inline(always)]
    pub(super) fn turn<const W: usize>(&self, angles: &[f64; W], turns: &mut [Turn<W>]) -> Turn<W> {
        // Apart from each other they stay in registers.
        let [mut s, mut c] = [[0.0; W]; 2];
        let mut lowest = [s, c];
        for (k, order) in self.orders.iter().enumerate() {
            if order.rotated {
                rotate(&mut s, &mut c, &lowest);
            } else {
                [s, c] = sin_cos_of_multiples(order.n, *angles);
            }
            if k == 0 {
                lowest = [s, c];
            }
            turns[k] = [s, c];
        }
        lowest
    }
}

/// Rows of drives at several instants.
struct Rows<'a> {
    waves: &'a FourierWaves,
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
