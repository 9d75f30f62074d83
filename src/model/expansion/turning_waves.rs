//! Waves in plain numbers, from one sine and cosine of their angle.

use crate::model::expansion::fourier_angle::fourier_waves;
use crate::model::shape::Shape;
use crate::numeric::sine::sin_cos;
use std::collections::BTreeMap;
use std::ops::Range;

/// Maximum number of orders that are computed by rotation one after the other. Each rotation adds its
/// rounding errors; the order after them has a sine and a cosine of its own.
const ROTATIONS: usize = 8;

/// Maximum number of groups of neighbouring orders. With more of them products are evaluated faster by their
/// factors.
const GROUPS: usize = 4;

/// The waves of a shape that are finite Fourier series: u_k = mean_k + Σ_n a_kn cos nφ + b_kn sin nφ.
pub(crate) struct TurningWaves {
    /// The mean of each wave.
    means: Vec<f64>,
    /// Index and mean of the waves that vary, without copies.
    moving: Vec<(usize, f64)>,
    /// The orders that occur, increasing.
    orders: Vec<Order>,
    /// Index of the wave, a and b of each term, order by order.
    terms: Vec<(usize, [f64; 2])>,
    copies: Vec<Copies>,
}

struct Order {
    n: f64,
    from: From,
    terms: Range<usize>,
}

/// How sine and cosine of an order are computed.
enum From {
    /// It is the first order.
    First,
    /// The order before it is turned by the first order.
    Before,
    /// From the angle.
    Angle,
}

/// Waves that vary like an earlier one, at equal distances.
struct Copies {
    of: usize,
    first: usize,
    stride: usize,
    count: usize,
}

impl TurningWaves {
    /// `None` if the shape has edges, waves that are no finite Fourier series or more than [`GROUPS`] groups
    /// of orders.
    pub(crate) fn of<G: Shape>(shape: &G) -> Option<Self> {
        let waves = fourier_waves(shape)?;
        let (mut moving, mut copies) = (Vec::new(), Vec::new());
        let mut first: BTreeMap<Vec<(u32, u64)>, usize> = BTreeMap::new();
        let mut by_order: BTreeMap<usize, Vec<(usize, [f64; 2])>> = BTreeMap::new();
        for (i, wave) in waves.iter().enumerate().filter(|(_, wave)| !wave.terms.is_empty()) {
            let numbers = wave.terms.iter().copied().chain([(u32::MAX, wave.constant)]);
            let of = *first.entry(numbers.map(|(slot, x)| (slot, x.to_bits())).collect()).or_insert(i);
            if of < i {
                add_copy(&mut copies, of, i);
                continue;
            }
            moving.push((i, wave.constant));
            for &(slot, weight) in &wave.terms {
                let (order, part) = (1 + slot as usize / 2, slot as usize % 2);
                let terms = by_order.entry(order).or_default();
                match terms.last_mut().filter(|(wave, _)| *wave == i) {
                    Some((_, pair)) => pair[part] = weight,
                    None => terms.push((i, if part == 0 { [weight, 0.0] } else { [0.0, weight] })),
                }
            }
        }
        let step = by_order.keys().next().copied().unwrap_or(1);
        let (mut orders, mut terms) = (Vec::<Order>::new(), Vec::new());
        let (mut last, mut rotations, mut groups) = (0, 0, 0);
        for (n, own) in by_order {
            let next = last > 0 && n == last + step;
            let rotated = next && rotations < ROTATIONS;
            groups += usize::from(!next);
            (last, rotations) = (n, if rotated { rotations + 1 } else { 0 });
            let from = match (orders.is_empty(), rotated) {
                (true, _) => From::First,
                (false, true) => From::Before,
                (false, false) => From::Angle,
            };
            orders.push(Order { n: n as f64, from, terms: terms.len()..terms.len() + own.len() });
            terms.extend(own);
        }
        let means = waves.iter().map(|wave| wave.constant).collect();
        (groups <= GROUPS).then_some(TurningWaves { means, moving, orders, terms, copies })
    }

    /// Writes all waves at an angle.
    pub(crate) fn write(&self, angle: f64, u: &mut [f64]) {
        u.copy_from_slice(&self.means);
        self.write_again(angle, u);
    }

    /// Writes the waves that vary.
    #[inline]
    pub(crate) fn write_again(&self, angle: f64, u: &mut [f64]) {
        let Some(first) = self.orders.first() else { return };
        for &(i, mean) in &self.moving {
            u[i] = mean;
        }
        let first = sin_cos(first.n * angle);
        let (mut s, mut c) = first;
        for order in &self.orders {
            match order.from {
                From::First => {}
                From::Before => (s, c) = (s * first.1 + c * first.0, c * first.1 - s * first.0),
                From::Angle => (s, c) = sin_cos(order.n * angle),
            }
            for &(i, [a, b]) in &self.terms[order.terms.clone()] {
                u[i] += a * c + b * s;
            }
        }
        for copies in &self.copies {
            let value = u[copies.of];
            u[copies.first..].iter_mut().step_by(copies.stride).take(copies.count).for_each(|u| *u = value);
        }
    }
}

/// Adds the copy `to` of wave `of` to the list.
fn add_copy(copies: &mut Vec<Copies>, of: usize, to: usize) {
    for last in copies.iter_mut().rev().filter(|copies| copies.of == of).take(1) {
        let stride = to - (last.first + (last.count - 1) * last.stride);
        if last.count == 1 || stride == last.stride {
            (last.stride, last.count) = (stride, last.count + 1);
            return;
        }
    }
    copies.push(Copies { of, first: to, stride: 1, count: 1 });
}
