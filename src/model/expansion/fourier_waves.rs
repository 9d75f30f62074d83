//! The waves of a shape as finite Fourier series: their values, from one sine and cosine of the angle.

use crate::model::expansion::fourier_angle::{Harmonics, fourier_waves};
use crate::model::shapes::shape::Shape;
use crate::numeric::sine::{rotate, sin_cos_each};
use crate::series::WaveWeights;
use pulp::{Arch, Simd, WithSimd};
use std::collections::BTreeMap;

/// Maximum number of orders that are computed by rotation one after the other. Each rotation adds its
/// rounding errors; the order after them has a sine and a cosine of its own.
const ROTATIONS: usize = 8;

/// Maximum number of groups of neighbouring orders, if there are fewer waves that vary. With more groups
/// products are evaluated faster by their factors.
const GROUPS: usize = 4;

/// Maximum number of terms of a wave that is expanded, and of different orders of all waves.
const TERMS: usize = 128;
pub(super) const ORDERS: usize = 512;

/// Waves u_k = mean_k + Σ_n a_kn cos nφ + b_kn sin nφ.
pub(crate) struct FourierWaves {
    /// The mean of each wave.
    pub(super) means: Vec<f64>,
    /// All orders n, increasing.
    pub(super) orders: Vec<Order>,
    /// Index of the order, a and b of each term of each wave.
    pub(super) terms: Vec<Vec<Term>>,
    /// Waves that stand for others, with those, which are the same function.
    copies: Vec<(usize, Vec<usize>)>,
    /// Whether the values are computed faster from the series than by the excitations.
    pub(crate) is_fast: bool,
    /// ±n^k/k! of each order; `None` if there are too many terms for an expansion.
    pub(crate) weights: Option<Vec<WaveWeights>>,
    pub(super) arch: Arch,
}

/// Index of an order or a wave, a and b.
pub(super) type Term = (usize, [f64; 2]);

pub(super) struct Order {
    pub(super) n: f64,
    /// Whether it is the order before it, turned by the lowest order.
    rotated: bool,
    /// Index of the wave, a and b of each term, without copies. The lowest order has one of every wave that
    /// varies.
    terms: Vec<Term>,
}

impl FourierWaves {
    /// The waves of a shape; `None` if it has edges, or waves that are no finite Fourier series.
    pub(crate) fn of<G: Shape>(shape: &G) -> Option<Self> {
        Some(FourierWaves::new(&fourier_waves(shape)?, 1))
    }

    /// Waves whose orders are counted in `repeats`.
    pub(super) fn new(waves: &[Harmonics], repeats: u32) -> Self {
        let all = waves.iter().flat_map(|(_, terms)| terms);
        let mut by_order: BTreeMap<usize, Vec<Term>> = all.map(|(n, _)| (*n, Vec::new())).collect();
        let known: Vec<usize> = by_order.keys().copied().collect();
        let lowest = known.first().copied().unwrap_or(0);
        let mut functions: BTreeMap<Vec<(usize, [u64; 2])>, usize> = BTreeMap::new();
        let (mut copies, mut varying): (BTreeMap<usize, Vec<usize>>, _) = (BTreeMap::new(), 0);
        for (wave, (mean, terms)) in waves.iter().enumerate().filter(|(_, (_, terms))| !terms.is_empty()) {
            let numbers = terms.iter().copied().chain([(0, [*mean, 0.0])]);
            let numbers = numbers.map(|(n, x)| (n, x.map(f64::to_bits))).collect();
            let first = *functions.entry(numbers).or_insert(wave);
            if first != wave {
                copies.entry(first).or_default().push(wave);
                continue;
            }
            varying += 1;
            let absent = (terms[0].0 != lowest).then_some((lowest, [0.0; 2]));
            for (n, pair) in absent.into_iter().chain(terms.iter().copied()) {
                by_order.entry(n).or_default().push((wave, pair));
            }
        }
        let (mut last, mut rotations, mut groups) = (0, 0, 0);
        let orders = by_order.into_iter().map(|(n, terms)| {
            let next = last > 0 && n == last + lowest;
            let rotated = next && rotations < ROTATIONS;
            groups += usize::from(!next);
            (last, rotations) = (n, if rotated { rotations + 1 } else { 0 });
            Order { n: n as f64 * f64::from(repeats), rotated, terms }
        });
        let orders: Vec<Order> = orders.collect();
        let few = orders.len() <= ORDERS && waves.iter().all(|(_, terms)| terms.len() <= TERMS);
        let placed = |(n, pair): &Term| (known.partition_point(|order| order < n), *pair);
        FourierWaves {
            means: waves.iter().map(|(mean, _)| *mean).collect(),
            terms: waves.iter().map(|(_, terms)| terms.iter().map(placed).collect()).collect(),
            copies: copies.into_iter().collect(),
            is_fast: groups <= GROUPS.max(varying),
            weights: few.then(|| orders.iter().map(|order| WaveWeights::new(order.n)).collect()),
            orders,
            arch: Arch::new(),
        }
    }

    /// Writes all waves at an angle.
    pub(crate) fn write(&self, angle: f64, u: &mut [f64]) {
        u.copy_from_slice(&self.means);
        self.write_again(angle, u);
    }

    /// Writes the waves that vary.
    #[inline]
    pub(crate) fn write_again(&self, angle: f64, u: &mut [f64]) {
        self.write_rows([angle], [u]);
    }

    /// Writes the waves that vary at the angles φ' t of several instants t, row by row of length `drives`.
    #[inline]
    pub(crate) fn write_nodes(&self, speed: f64, times: &[f64], u: &mut [f64], drives: usize) {
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
        let Some((lowest, others)) = self.orders.split_first() else { return };
        let first = lowest.sin_cos(&angles);
        for &(wave, [a, b]) in &lowest.terms {
            for i in 0..W {
                u[i][wave] = self.means[wave] + (a * first[1][i] + b * first[0][i]);
            }
        }
        let mut last = first;
        for order in others {
            last = order.turned(&angles, last, &first);
            let [s, c] = &last;
            for &(wave, [a, b]) in &order.terms {
                for i in 0..W {
                    u[i][wave] += a * c[i] + b * s[i];
                }
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
}

impl Order {
    /// Sines and cosines of n times the angles, from those of the order before and of the lowest order.
    #[inline(always)]
    pub(super) fn turned<const W: usize>(
        &self,
        angles: &[f64; W],
        mut before: [[f64; W]; 2],
        lowest: &[[f64; W]; 2],
    ) -> [[f64; W]; 2] {
        if self.rotated {
            rotate(&mut before, lowest);
            return before;
        }
        self.sin_cos(angles)
    }

    /// Sines and cosines of n times the angles.
    #[inline(always)]
    pub(super) fn sin_cos<const W: usize>(&self, angles: &[f64; W]) -> [[f64; W]; 2] {
        let mut turned = [0.0; W];
        for i in 0..W {
            turned[i] = self.n * angles[i];
        }
        sin_cos_each(turned)
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
