//! Waves in plain numbers, from one sine and cosine of their angle.

use crate::model::expansion::fourier_angle::fourier_waves;
use crate::model::shape::Shape;
use crate::numeric::sine::{sin_cos, sin_cos_each};
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
    /// Pairs (copy, wave) of waves that are the same function.
    copies: Vec<(usize, usize)>,
}

/// A wave that varies.
struct Moving {
    wave: usize,
    mean: f64,
    /// a and b of the lowest order.
    first: [f64; 2],
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
        let (mut moving, mut copies): (Vec<Moving>, Vec<_>) = (Vec::new(), Vec::new());
        for (wave, (mean, terms)) in waves.iter().enumerate().filter(|(_, (_, terms))| !terms.is_empty()) {
            let numbers = terms.iter().copied().chain([(0, [*mean, 0.0])]);
            let of = *known
                .entry(numbers.map(|(n, x)| (n, x.map(f64::to_bits))).collect())
                .or_insert(moving.len());
            if let Some(same) = moving.get(of) {
                copies.push((wave, same.wave));
                continue;
            }
            let mut own = Moving { wave, mean: *mean, first: [0.0; 2] };
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
            copies,
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
        if self.moving.is_empty() {
            return;
        }
        let first = sin_cos(self.first * angle);
        let (mut s, mut c) = first;
        for Moving { wave, mean, first: [a, b] } in &self.moving {
            u[*wave] = mean + (a * c + b * s);
        }
        for Order { n, rotated, terms } in &self.others {
            (s, c) = match rotated {
                true => (s * first.1 + c * first.0, c * first.1 - s * first.0),
                false => sin_cos(n * angle),
            };
            for &(wave, [a, b]) in terms {
                u[wave] += a * c + b * s;
            }
        }
        for &(copy, wave) in &self.copies {
            u[copy] = u[wave];
        }
    }

    /// Writes the waves that vary at the angles φ' t of several instants t, row by row of length `drives`.
    #[inline]
    pub(crate) fn write_nodes(&self, speed: f64, times: &[f64], u: &mut [f64], drives: usize) {
        if self.moving.is_empty() {
            return;
        }
        let rows = Rows { waves: self, speed, times, u, drives };
        if times.len() <= 2 { rows.write::<2>() } else { Arch::new().dispatch(rows) }
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
        self.write::<4>();
    }
}

impl Rows<'_> {
    /// Writes the waves of W rows at a time, with the operations of [`TurningWaves::write_again`].
    #[inline(always)]
    fn write<const W: usize>(self) {
        let Rows { waves, speed, times, u, drives } = self;
        for (times, u) in times.chunks(W).zip(u.chunks_mut(W * drives)) {
            let mut angles = [0.0; W];
            for (angle, t) in angles.iter_mut().zip(times) {
                *angle = speed * t;
            }
            let n = times.len();
            let first = turned(&angles, waves.first);
            let [mut s, mut c] = first;
            for Moving { wave, mean, first: [a, b] } in &waves.moving {
                let mut values = [0.0; W];
                for i in 0..W {
                    values[i] = mean + (a * c[i] + b * s[i]);
                }
                for i in 0..n {
                    u[drives * i + wave] = values[i];
                }
            }
            for Order { n: order, rotated, terms } in &waves.others {
                if *rotated {
                    for i in 0..W {
                        (s[i], c[i]) = (
                            s[i] * first[1][i] + c[i] * first[0][i],
                            c[i] * first[1][i] - s[i] * first[0][i],
                        );
                    }
                } else {
                    [s, c] = turned(&angles, *order);
                }
                for &(wave, [a, b]) in terms {
                    for i in 0..n {
                        u[drives * i + wave] += a * c[i] + b * s[i];
                    }
                }
            }
            for u in u.chunks_exact_mut(drives) {
                for &(copy, wave) in &waves.copies {
                    u[copy] = u[wave];
                }
            }
        }
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
