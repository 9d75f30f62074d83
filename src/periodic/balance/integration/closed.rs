//! Exact crossings in closed form, for accelerations that are linear on every piece and drives of few orders.
//!
//! q'' = α + A q + B q' + Σ_c Σ_f χ_cf (α_cf + A_cf q + B_cf q'),   c: contacts, f: lower and upper flank.
//!
//! χ_cf(t) is 1 while contact c stands on flank f and 0 otherwise. With crossings at the angles θ_s its
//! Fourier coefficients are
//!
//! χ_m = Σ_s ± e^{-i m θ_s}/(2π i m), m ≠ 0,   + where the contact enters the flank, - where it leaves it.
//!
//! χ_0 is the share of the period on the flank. α, A and B, with or without indices, are periodic and have
//! short Fourier series. The coefficients of q'' are products of these series with χ and with the motion.

use crate::contact::Piece;
use crate::model::Periodic;
use crate::model::structure::couplings::{Couplings, Slope, is_linear_on_pieces};
use crate::model::structure::slopes::Slopes;
use crate::numeric::spread::weyl;
use crate::periodic::balance::crossings::instants::Crossings;
use crate::periodic::balance::crossings::stencil::Phasors;
use crate::periodic::balance::integrals::Integrals;
use crate::periodic::balance::integration::integration_trait::{Check, Integration, Motion};
use crate::periodic::balance::integration::jumps::BothSides;
use crate::periodic::balance::quadrature::at_rest::{AtRest, Series, SeriesPart, value_at};
use crate::periodic::balance::series::grid::Grid;
use crate::periodic::balance::series::harmonics::Harmonics;
use crate::periodic::balance::series::spectra::{Spectra, add_mean};
use crate::periodic::balance::series::transform::write;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Number of instants between the samples at which the series are compared with the model. Also the number of
/// samples that show which accelerations and slopes a contact changes.
const COMPARED_INSTANTS: usize = 5;

/// Number of such instants for a model with another parameter.
const INSTANTS_AGAIN: usize = 2;

/// Largest deviation of the sum of the series from the model, as a share of the sum of all absolute values
/// `[1]`.
const SERIES_AGREE: f64 = 1e-11;

/// Integration in closed form: the series of a model, and scratch.
#[derive(Clone)]
pub(crate) struct Closed {
    /// α, A and B: all contacts in their gaps.
    base: SeriesPart,
    /// α_cf, A_cf and B_cf of every contact, on the lower and on the upper flank.
    flanks: Vec<[SeriesPart; 2]>,
    /// χ_m of one contact on one flank, m = 0, 1, ...
    indicator: Vec<Complex64>,
    /// The crossings at which this contact enters or leaves this flank: the angle θ_s, and the sign, which is
    /// 1 where it enters and -1 where it leaves.
    angles: Vec<(f64, f64)>,
    /// ± e^{-i m θ_s} of these crossings.
    phasors: Vec<Complex64>,
    /// e^{-i θ_s} of these crossings.
    turns: Vec<Complex64>,
    /// Coefficients of the periodic slopes A + Σ χ A_cf and B + Σ χ B_cf.
    slopes: Vec<Vec<Complex64>>,
    /// Coefficients of the accelerations at rest, α + Σ χ α_cf.
    accelerations: Vec<Vec<Complex64>>,
    sides: BothSides,
}

/// The base, and the flanks of every contact.
type Parts = (SeriesPart, Vec<[SeriesPart; 2]>);

/// First and maximum number of samples of the drives.
const FEWEST: usize = 64;
const MAX_ORDER_SAMPLES: usize = 16_384;

/// Number of instants at which linearity is tested: for the first model, and for a model with another
/// parameter.
const PROBE_STATES: usize = 8;
const PROBE_STATES_AGAIN: usize = 2;

impl Closed {
    /// Finds the series of a model.
    ///
    /// `None` if the accelerations are not linear on the pieces, the contributions of the contacts do not add
    /// up, or the drives have too many orders.
    pub(crate) fn find<'m>(
        model: &'m dyn Periodic,
        harmonics: &Harmonics,
        couplings: &Couplings,
        slopes: &mut Slopes<'m>,
    ) -> Option<Self> {
        if !is_linear_on_pieces(model, slopes, PROBE_STATES) {
            return None;
        }
        let (base, flanks) = Closed::settled(model, couplings, slopes, FEWEST, COMPARED_INSTANTS)?;
        let mut closed = Closed {
            base,
            flanks,
            indicator: Vec::new(),
            angles: Vec::new(),
            phasors: Vec::new(),
            turns: Vec::new(),
            slopes: vec![vec![Complex64::ZERO; 2 * harmonics.highest() + 1]; couplings.varying.len()],
            accelerations: vec![vec![Complex64::ZERO; harmonics.orders().len()]; model.dof()],
            sides: BothSides::new(model.dof(), model.contacts()),
        };
        closed.lengthen(harmonics);
        Some(closed)
    }

    /// Makes room for all orders of χ that the products need.
    fn lengthen(&mut self, harmonics: &Harmonics) {
        let reach = 2 * harmonics.highest() + harmonics.period_multiple() * self.longest();
        self.indicator.resize(reach + 1, Complex64::ZERO);
    }

    /// The series from the first sufficient number of samples: `samples`, then twice as many, and so on.
    fn settled<'m>(
        model: &'m dyn Periodic,
        couplings: &Couplings,
        slopes: &mut Slopes<'m>,
        mut samples: usize,
        instants: usize,
    ) -> Option<Parts> {
        while samples <= MAX_ORDER_SAMPLES {
            if let Some(parts) = Closed::sampled(model, couplings, slopes, samples, instants) {
                return Some(parts);
            }
            samples *= 2;
        }
        None
    }

    /// The series from this number of samples. `None` if the samples are too few for them, or if they do not
    /// agree with the model between the samples.
    fn sampled<'m>(
        model: &'m dyn Periodic,
        couplings: &Couplings,
        slopes: &mut Slopes<'m>,
        samples: usize,
        instants: usize,
    ) -> Option<Parts> {
        let contacts = model.contacts();
        let mut at_rest = AtRest::new(model, couplings, slopes, samples);
        let gap = at_rest.at(&vec![Piece::Gap; contacts], samples);
        let reach = |contact: usize, at_rest: &mut AtRest<'_, '_>| {
            let mut pieces = vec![Piece::Gap; contacts];
            pieces[contact] = Piece::Lower;
            at_rest.at(&pieces, COMPARED_INSTANTS).touched(&gap)
        };
        let base = gap.series(None, None)?;
        let reaches: Vec<Vec<bool>> = (0..contacts).map(|c| reach(c, &mut at_rest)).collect();
        let mut flanks: Vec<Option<[SeriesPart; 2]>> = (0..contacts).map(|_| None).collect();
        // Contacts that change no acceleration and no slope in common are evaluated together.
        while let Some(first) = flanks.iter().position(Option::is_none) {
            let mut group: Vec<usize> = Vec::new();
            let mut taken = vec![false; reaches[first].len()];
            for c in (first..contacts).filter(|&c| flanks[c].is_none()) {
                if reaches[c].iter().zip(&taken).all(|(reached, taken)| !(reached & taken)) {
                    taken.iter_mut().zip(&reaches[c]).for_each(|(taken, reached)| *taken |= reached);
                    group.push(c);
                }
            }
            let mut on = |piece: Piece| {
                let mut pieces = vec![Piece::Gap; contacts];
                group.iter().for_each(|&c| pieces[c] = piece);
                at_rest.at(&pieces, samples)
            };
            let (lower, upper) = (on(Piece::Lower), on(Piece::Upper));
            for &c in &group {
                flanks[c] = Some([
                    lower.series(Some(&gap), Some(&reaches[c]))?,
                    upper.series(Some(&gap), Some(&reaches[c]))?,
                ]);
            }
        }
        let parts = (base, flanks.into_iter().flatten().collect());
        // Aliased orders show as deviations between the samples.
        [Piece::Gap, Piece::Lower, Piece::Upper]
            .into_iter()
            .all(|piece| Closed::agrees(&parts, &mut at_rest, piece, instants))
            .then_some(parts)
    }

    /// Whether the series agree with the model between the samples, with all contacts on one piece.
    fn agrees((base, flanks): &Parts, at_rest: &mut AtRest<'_, '_>, piece: Piece, instants: usize) -> bool {
        let parts = || {
            let flank = |on: &'_ [SeriesPart; 2]| match piece {
                Piece::Lower => 0,
                _ => on.len() - 1,
            };
            let flanks = flanks.iter().filter(|_| piece != Piece::Gap).map(move |on| &on[flank(on)]);
            std::iter::once(base).chain(flanks)
        };
        (0..instants).all(|k| {
            let share = weyl(k, 0);
            let sampled = at_rest.between(piece, share);
            let agree = |sampled: &[Vec<f64>], series: &dyn Fn(&SeriesPart) -> &[Series]| {
                sampled.iter().enumerate().all(|(i, sampled)| {
                    let (sum, size) = parts().fold((0.0, sampled[0].abs()), |(sum, size), part| {
                        let value = value_at(&series(part)[i], share);
                        (sum + value, size + value.abs())
                    });
                    (sum - sampled[0]).abs() <= SERIES_AGREE * size
                })
            };
            agree(&sampled.accelerations, &|part| &part.accelerations)
                && agree(&sampled.slopes, &|part| &part.slopes)
        })
    }

    /// Length of the longest series.
    fn longest(&self) -> usize {
        let parts = std::iter::once(&self.base).chain(self.flanks.iter().flatten());
        parts.flat_map(|p| p.accelerations.iter().chain(&p.slopes)).map(Vec::len).max().unwrap_or(0)
    }
}

impl Integration for Closed {
    fn integrals(&self, _: usize) -> Integrals {
        Integrals::Closed
    }
    fn check(&self) -> Check {
        Check::Unnecessary
    }
    fn adapt<'m>(&mut self, grid: &Grid<'m>, couplings: &Couplings, slopes: &mut Slopes<'m>) -> bool {
        let model = grid.model;
        if !is_linear_on_pieces(model, slopes, PROBE_STATES_AGAIN) {
            return false;
        }
        // Three eighths of the samples must exceed the number of orders.
        let samples = (8 * self.longest().max(1)).div_ceil(3).next_power_of_two().max(8);
        let Some((base, flanks)) = Closed::settled(model, couplings, slopes, samples, INSTANTS_AGAIN) else {
            return false;
        };
        (self.base, self.flanks) = (base, flanks);
        self.lengthen(grid.harmonics());
        true
    }
    fn twin(&self) -> Option<Box<dyn Integration>> {
        Some(Box::new(self.clone()))
    }
    /// Also writes the coefficients of the periodic slopes, because the accelerations are products of these
    /// slopes and the motion.
    fn accelerations(&mut self, motion: &mut Motion<'_, '_>, out: &mut Spectra) {
        let Motion { grid, crossings, couplings, coefficients, speeds } = motion;
        let harmonics = grid.harmonics();
        let (width, periods) = (harmonics.unknowns(), harmonics.period_multiple());
        let reach = 2 * harmonics.highest();
        let Closed { base, flanks, indicator, angles, phasors, turns, slopes, accelerations, .. } = self;
        slopes.iter_mut().chain(&mut *accelerations).for_each(|sum| sum.fill(Complex64::ZERO));
        for (sum, series) in slopes.iter_mut().zip(&base.slopes) {
            for (k, c) in series.iter().enumerate().take_while(|(k, _)| k * periods <= reach) {
                sum[k * periods] += c;
            }
        }
        for (sum, series) in accelerations.iter_mut().zip(&base.accelerations) {
            for (sum, &order) in sum.iter_mut().zip(harmonics.orders()) {
                if order % periods == 0 {
                    *sum += series.get(order / periods).copied().unwrap_or_default();
                }
            }
        }
        for (c, flanks) in flanks.iter().enumerate() {
            for (part, piece) in flanks.iter().zip([Piece::Lower, Piece::Upper]) {
                if !indicate(crossings, c, piece, (&mut *angles, &mut *phasors, &mut *turns), indicator) {
                    continue;
                }
                let chi = Indicator(indicator);
                for (sum, series) in
                    slopes.iter_mut().zip(&part.slopes).filter(|(_, series)| !series.is_empty())
                {
                    for (k, sum) in sum.iter_mut().enumerate() {
                        *sum += chi.times(series, periods, k);
                    }
                }
                for (sum, series) in
                    accelerations.iter_mut().zip(&part.accelerations).filter(|(_, series)| !series.is_empty())
                {
                    for (sum, &order) in sum.iter_mut().zip(harmonics.orders()) {
                        *sum += chi.times(series, periods, order);
                    }
                }
            }
        }
        for (table, values) in out.slopes.iter_mut().zip(&*slopes) {
            values.iter().enumerate().for_each(|(k, d)| table.set(k, *d));
        }
        for (accelerations, values) in out.accelerations.iter_mut().zip(&*accelerations) {
            for ((i, &order), value) in harmonics.orders().iter().enumerate().zip(values) {
                write(&mut accelerations[harmonics.place(i)..], order, *value);
            }
        }
        // Adds the terms that are linear in the motion, by the same products as in the Jacobian.
        for c in &couplings.list {
            let part = &coefficients[c.j * width..(c.j + 1) * width];
            let accelerations = &mut out.accelerations[c.i];
            if speeds[c.j] != 0.0 {
                add_mean(&out.slopes, c.v, harmonics, speeds[c.j], accelerations);
            }
            for (i, &order) in harmonics.orders().iter().enumerate() {
                let (at, rate) = (harmonics.place(i), order as f64 * grid.omega());
                let (cos, sin) = (part[at], if order == 0 { 0.0 } else { part[at + 1] });
                for (slope, cos, sin) in [(c.q, cos, sin), (c.v, rate * sin, -rate * cos)] {
                    match slope {
                        Slope::Constant(a) => {
                            accelerations[at] += a * cos;
                            if order > 0 {
                                accelerations[at + 1] += a * sin;
                            }
                        }
                        Slope::Periodic(number) => {
                            out.slopes[number].add(accelerations, harmonics, order, false, cos);
                            if order > 0 {
                                out.slopes[number].add(accelerations, harmonics, order, true, sin);
                            }
                        }
                    }
                }
            }
        }
    }
    fn slopes(&mut self, motion: &mut Motion<'_, '_>, _: &mut Slopes<'_>, out: &mut Spectra) {
        self.sides.jumps(motion.grid, motion.crossings, out);
    }
}

/// Computes χ_m of a contact on a flank. `false` if the contact never stands on this flank.
fn indicate(
    crossings: &Crossings,
    contact: usize,
    flank: Piece,
    (angles, phasors, turns): (&mut Vec<(f64, f64)>, &mut Vec<Complex64>, &mut Vec<Complex64>),
    chi: &mut [Complex64],
) -> bool {
    let per_turn = TAU / crossings.samples() as f64;
    angles.clear();
    for crossing in
        crossings.list().iter().filter(|e| e.contact == contact && (e.to == flank || e.from == flank))
    {
        angles.push((crossing.time(per_turn), if crossing.to == flank { 1.0 } else { -1.0 }));
    }
    let there_at_first = crossings.piece(contact, 0) == flank;
    if angles.is_empty() && !there_at_first {
        return false;
    }
    let share: f64 = angles.iter().map(|(angle, sign)| -sign * angle).sum();
    chi[0] = (share / TAU + f64::from(u8::from(there_at_first))).into();
    // For each order, the phasors of all crossings are turned at once: they do not depend on each other.
    phasors.clear();
    phasors.extend(angles.iter().map(|&(_, sign)| Complex64::new(sign, 0.0)));
    turns.clear();
    turns.extend(angles.iter().map(|&(angle, _)| Phasors::new(angle).nth(1).unwrap_or_default()));
    for (m, chi) in chi.iter_mut().enumerate().skip(1) {
        let mut sum = Complex64::ZERO;
        for (z, turn) in phasors.iter_mut().zip(&*turns) {
            *z *= turn;
            sum += *z;
        }
        *chi = sum * Complex64::new(0.0, -1.0 / (TAU * m as f64));
    }
    true
}

/// χ_m at orders m of either sign; χ_{-m} is the conjugate of χ_m.
struct Indicator<'a>(&'a [Complex64]);

impl Indicator<'_> {
    #[inline]
    fn at(&self, m: isize) -> Complex64 {
        let value = self.0[m.unsigned_abs()];
        if m < 0 { value.conj() } else { value }
    }

    /// Coefficient of order k of the product of χ and a series. Order l of the series is order l p of the
    /// orbit, with the number p of `periods`.
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
