//! Exact switching in closed form: accelerations that are linear on every piece, with drives of few harmonics.
//!
//! q'' = α + A q + B q' + Σ_c Σ_flank χ (α_c + A_c q + B_c q'), where χ(t) is 1 while contact c is on that flank. With switches at θ_s the
//! coefficients of χ close in the angles,
//!
//! χ_m = Σ_s ± e^{-i m θ_s}/(2π i m),   + where the contact enters, - where it leaves,
//!
//! and everything else is a product of short series.

use super::Harmonics;
use super::couplings::{Couplings, Slope, Slopes};
use super::grid::Grid;
use super::spectra::Spectra;
use super::stencil::Phasors;
use super::switching::Switching;
use super::transform::{Transform, unpack};
use crate::model::{Periodic, Piece, Side};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Coefficients of a real periodic function, k = 0, 1, ... in the model's period.
type Series = Vec<Complex64>;

/// What one piece adds: forces at rest per coordinate, and periodic slopes by number. Empty series are zero.
struct Part {
    force: Vec<Series>,
    slopes: Vec<Series>,
}

/// A model in closed form.
pub(super) struct Closed {
    base: Part,
    /// Per contact: lower and upper flank.
    flanks: Vec<[Part; 2]>,
    /// χ_m of the flank at hand.
    indicator: Vec<Complex64>,
}

/// Samples of the drives tried at most.
const MOST: usize = 16_384;
/// Coefficients below this share of the largest are rounding.
const ROUNDING: f64 = 4e-16;
/// The highest quarter of the samples' orders must fall below this share.
const SETTLED: f64 = 1e-13;

impl Closed {
    /// `None` if the model is not linear on its pieces, its contacts do not add up, or its drives have too many harmonics.
    pub(super) fn find<M: Periodic + ?Sized>(
        model: &M,
        harmonics: &Harmonics,
        couplings: &Couplings,
        slopes: &mut Slopes<'_, M>,
    ) -> Option<Self> {
        if !is_linear_on_pieces(model, slopes) {
            return None;
        }
        let mut samples = 256;
        while samples <= MOST {
            if let Some(closed) = Closed::sampled(model, couplings, slopes, samples) {
                let longest = closed.longest();
                let reach = 2 * harmonics.highest() + harmonics.periods() * longest;
                return Some(Closed { indicator: vec![Complex64::ZERO; reach + 1], ..closed });
            }
            samples *= 2;
        }
        None
    }

    fn sampled<M: Periodic + ?Sized>(model: &M, couplings: &Couplings, slopes: &mut Slopes<'_, M>, samples: usize) -> Option<Self> {
        let (n, contacts) = (model.dof(), model.contacts());
        let rest = vec![0.0; n];
        let mut transform = Transform::new(samples);
        let mut drives = vec![vec![0.0; model.drives()]; samples];
        for (s, u) in drives.iter_mut().enumerate() {
            model.drive(model.period() * s as f64 / samples as f64, Side::After, u);
        }
        let mut look = |pieces: &[Piece]| {
            let (mut force, mut slope) = (vec![vec![0.0; samples]; n], vec![vec![0.0; samples]; couplings.varying.len()]);
            let mut a = vec![0.0; n];
            for (s, u) in drives.iter().enumerate() {
                model.accel_on_pieces(pieces, u, &rest, &rest, &mut a);
                force.iter_mut().zip(&a).for_each(|(f, a)| f[s] = *a);
                slopes.at(Some(pieces), u, &rest, &rest);
                for (values, &(i, j, velocity)) in slope.iter_mut().zip(&couplings.varying) {
                    values[s] = if velocity { slopes.jacobian.v[(i, j)] } else { slopes.jacobian.q[(i, j)] };
                }
            }
            (force, slope)
        };
        let mut series = |values: &[f64]| -> Option<Series> {
            let mut buffer: Vec<Complex64> = values.iter().map(|&x| x.into()).collect();
            transform.analyse(&mut buffer);
            let mut series: Series = (0..samples / 2).map(|k| unpack(&buffer, k).0).collect();
            let largest = series.iter().fold(0.0, |m: f64, c| m.max(c.norm()));
            if series[3 * samples / 8..].iter().any(|c| c.norm() > SETTLED * largest) {
                return None;
            }
            let length = series.iter().rposition(|c| c.norm() > ROUNDING * largest).map_or(0, |last| last + 1);
            series.truncate(length);
            Some(series)
        };
        let mut pieces = vec![Piece::Gap; contacts];
        let gap = look(&pieces);
        let mut part = |(force, slope): &(Vec<Vec<f64>>, Vec<Vec<f64>>), less: Option<&(Vec<Vec<f64>>, Vec<Vec<f64>>)>| -> Option<Part> {
            let mut list = |values: &[Vec<f64>], less: Option<&[Vec<f64>]>| -> Option<Vec<Series>> {
                let difference = |i: usize| match less {
                    None => values[i].clone(),
                    Some(less) => values[i].iter().zip(&less[i]).map(|(x, y)| x - y).collect(),
                };
                (0..values.len()).map(|i| series(&difference(i))).collect()
            };
            Some(Part { force: list(force, less.map(|l| &l.0[..]))?, slopes: list(slope, less.map(|l| &l.1[..]))? })
        };
        let base = part(&gap, None)?;
        let mut flanks = Vec::with_capacity(contacts);
        for c in 0..contacts {
            let mut flank = |piece: Piece| {
                pieces[c] = piece;
                let on = part(&look(&pieces), Some(&gap));
                pieces[c] = Piece::Gap;
                on
            };
            flanks.push([flank(Piece::Lower)?, flank(Piece::Upper)?]);
        }
        Some(Closed { base, flanks, indicator: Vec::new() })
    }

    fn longest(&self) -> usize {
        let parts = std::iter::once(&self.base).chain(self.flanks.iter().flatten());
        parts.flat_map(|p| p.force.iter().chain(&p.slopes)).map(Vec::len).max().unwrap_or(0)
    }

    /// Forces and slopes along the motion whose switches are located.
    pub(super) fn evaluate<M: Periodic + ?Sized>(
        &mut self,
        grid: &Grid<'_, M>,
        switching: &Switching,
        couplings: &Couplings,
        coefficients: &[f64],
        out: &mut Spectra,
    ) {
        let harmonics = grid.harmonics();
        let (width, periods) = (harmonics.unknowns(), harmonics.periods());
        let reach = 2 * harmonics.highest();
        let mut slopes = vec![vec![Complex64::ZERO; reach + 1]; out.slopes.len()];
        let mut forces = vec![vec![Complex64::ZERO; harmonics.orders().len()]; out.force.len()];
        for (sum, series) in slopes.iter_mut().zip(&self.base.slopes) {
            for (k, c) in series.iter().enumerate().take_while(|(k, _)| k * periods <= reach) {
                sum[k * periods] += c;
            }
        }
        for (sum, series) in forces.iter_mut().zip(&self.base.force) {
            for (sum, &order) in sum.iter_mut().zip(harmonics.orders()) {
                if order % periods == 0 {
                    *sum += series.get(order / periods).copied().unwrap_or_default();
                }
            }
        }
        for (c, flanks) in self.flanks.iter().enumerate() {
            for (part, piece) in flanks.iter().zip([Piece::Lower, Piece::Upper]) {
                if !indicate(switching, c, piece, &mut self.indicator) {
                    continue;
                }
                let chi = Indicator(&self.indicator);
                for (sum, series) in slopes.iter_mut().zip(&part.slopes).filter(|(_, series)| !series.is_empty()) {
                    for (k, sum) in sum.iter_mut().enumerate() {
                        *sum += chi.times(series, periods, k);
                    }
                }
                for (sum, series) in forces.iter_mut().zip(&part.force).filter(|(_, series)| !series.is_empty()) {
                    for (sum, &order) in sum.iter_mut().zip(harmonics.orders()) {
                        *sum += chi.times(series, periods, order);
                    }
                }
            }
        }
        for (table, values) in out.slopes.iter_mut().zip(&slopes) {
            values.iter().enumerate().for_each(|(k, d)| table.set(k, *d));
        }
        for (force, values) in out.force.iter_mut().zip(&forces) {
            for ((i, &order), value) in harmonics.orders().iter().enumerate().zip(values) {
                super::orbit::write(&mut force[harmonics.place(i)..], order, *value);
            }
        }
        // What is linear in the motion: the same products that fill the Jacobian.
        for c in &couplings.list {
            let part = &coefficients[c.j * width..(c.j + 1) * width];
            let force = &mut out.force[c.i];
            for (i, &order) in harmonics.orders().iter().enumerate() {
                let (at, rate) = (harmonics.place(i), order as f64 * grid.omega());
                let (cos, sin) = (part[at], if order == 0 { 0.0 } else { part[at + 1] });
                for (slope, cos, sin) in [(c.q, cos, sin), (c.v, rate * sin, -rate * cos)] {
                    match slope {
                        Slope::Constant(a) => {
                            force[at] += a * cos;
                            if order > 0 {
                                force[at + 1] += a * sin;
                            }
                        }
                        Slope::Varying(number) => {
                            out.slopes[number].add(force, harmonics, order, false, cos);
                            if order > 0 {
                                out.slopes[number].add(force, harmonics, order, true, sin);
                            }
                        }
                    }
                }
            }
        }
    }
}

/// χ_m of a contact on a flank; `false` if it is never there.
fn indicate(switching: &Switching, contact: usize, flank: Piece, chi: &mut [Complex64]) -> bool {
    let per_turn = TAU / switching.samples() as f64;
    let (mut angles, mut signs) = (Vec::new(), Vec::new());
    for event in switching.events().iter().filter(|e| e.contact == contact && (e.to == flank || e.from == flank)) {
        angles.push(event.time(per_turn));
        signs.push(if event.to == flank { 1.0 } else { -1.0 });
    }
    let there_at_first = switching.piece(contact, 0) == flank;
    if angles.is_empty() && !there_at_first {
        return false;
    }
    chi.fill(Complex64::ZERO);
    let share: f64 = angles.iter().zip(&signs).map(|(angle, sign)| -sign * angle).sum();
    // All switches side by side, order by order.
    let (mut z, turns): (Vec<Complex64>, Vec<Complex64>) = angles
        .iter()
        .zip(&signs)
        .map(|(&angle, &sign)| (Complex64::new(sign, 0.0), Phasors::new(angle).nth(1).unwrap_or_default()))
        .unzip();
    for (m, chi) in chi.iter_mut().enumerate().skip(1) {
        let mut sum = Complex64::ZERO;
        for (z, turn) in z.iter_mut().zip(&turns) {
            *z *= turn;
            sum += *z;
        }
        *chi = sum * Complex64::new(0.0, -1.0 / (TAU * m as f64));
    }
    chi[0] = (share / TAU + f64::from(u8::from(there_at_first))).into();
    true
}

/// χ at any order, of either sign.
struct Indicator<'a>(&'a [Complex64]);

impl Indicator<'_> {
    #[inline]
    fn at(&self, m: isize) -> Complex64 {
        let value = self.0[m.unsigned_abs()];
        if m < 0 { value.conj() } else { value }
    }

    /// Order k of χ times a series.
    #[inline]
    fn times(&self, series: &[Complex64], periods: usize, k: usize) -> Complex64 {
        let k = k as isize;
        let mut sum = series[0] * self.at(k);
        for (l, c) in series.iter().enumerate().skip(1) {
            let l = (l * periods) as isize;
            sum += c * self.at(k - l) + c.conj() * self.at(k + l);
        }
        sum
    }
}

/// Whether held accelerations are linear in the state, and contacts add up.
fn is_linear_on_pieces<M: Periodic + ?Sized>(model: &M, slopes: &mut Slopes<'_, M>) -> bool {
    let (n, contacts) = (model.dof(), model.contacts());
    let rest = vec![0.0; n];
    let mut u = vec![0.0; model.drives()];
    let mut seed = 0u32;
    let mut random = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(seed) / f64::from(u32::MAX)
    };
    let mut a = [vec![0.0; n], vec![0.0; n], vec![0.0; n]];
    for _ in 0..8 {
        model.drive(model.period() * random(), Side::After, &mut u);
        let pieces: Vec<Piece> = (0..contacts).map(|_| [Piece::Lower, Piece::Gap, Piece::Upper][(random() * 2.999) as usize]).collect();
        let q: Vec<f64> = slopes.reach(0).iter().map(|size| size * (4.0 * random() - 2.0)).collect();
        let v: Vec<f64> = slopes.reach(1).iter().map(|size| size * (4.0 * random() - 2.0)).collect();
        if !model.accel_on_pieces(&pieces, &u, &q, &v, &mut a[0]) {
            return false;
        }
        // The same from the pieces one by one, each linear.
        let mut held = vec![Piece::Gap; contacts];
        let mut linear = |held: &[Piece], out: &mut [f64], at_rest: &mut [f64]| {
            model.accel_on_pieces(held, &u, &rest, &rest, at_rest);
            slopes.at(Some(held), &u, &rest, &rest);
            for i in 0..n {
                out[i] = at_rest[i] + (0..n).map(|j| slopes.jacobian.q[(i, j)] * q[j] + slopes.jacobian.v[(i, j)] * v[j]).sum::<f64>();
            }
        };
        let mut at_rest = vec![0.0; n];
        let mut gap = vec![0.0; n];
        linear(&held, &mut gap, &mut at_rest);
        let mut sum = gap.clone();
        let mut size: Vec<f64> = gap.iter().map(|x| x.abs()).collect();
        for c in 0..contacts {
            held[c] = pieces[c];
            linear(&held, &mut a[1], &mut at_rest);
            held[c] = Piece::Gap;
            for i in 0..n {
                sum[i] += a[1][i] - gap[i];
                size[i] += a[1][i].abs();
            }
        }
        if (0..n).any(|i| (sum[i] - a[0][i]).abs() > 1e-9 * (size[i] + a[0][i].abs())) {
            return false;
        }
    }
    true
}
