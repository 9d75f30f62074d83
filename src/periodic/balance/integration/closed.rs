//! Exact switching in closed form: accelerations that are linear on every piece, with drives of few harmonics.
//!
//! q'' = α + A q + B q' + Σ_c Σ_flank χ (α_c + A_c q + B_c q'), where χ(t) is 1 while contact c is on that flank. With switches at θ_s the
//! coefficients of χ close in the angles,
//!
//! χ_m = Σ_s ± e^{-i m θ_s}/(2π i m),   + where the contact enters, - where it leaves,
//!
//! and everything else is a product of short series.

use crate::contact::piece::Piece;
use crate::model::couplings::{Couplings, Slope, is_linear_on_pieces};
use crate::model::equations::Periodic;
use crate::model::slopes::Slopes;
use crate::numeric::spread::weyl;
use crate::periodic::balance::integrals::Integrals;
use crate::periodic::balance::integration::interface::{Check, Integration, Motion};
use crate::periodic::balance::integration::jumps::BothSides;
use crate::periodic::balance::quadrature::at_rest::{Look, Part, Series, value_at};
use crate::periodic::balance::series::harmonics::Harmonics;
use crate::periodic::balance::series::spectra::Spectra;
use crate::periodic::balance::series::transform::write;
use crate::periodic::balance::switching::instants::Switching;
use crate::periodic::balance::switching::stencil::Phasors;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Instants at which a model is looked at beside the samples.
const LOOKS: usize = 5;

/// How closely the series have to give it there.
const AGREE: f64 = 1e-11;

/// A model in closed form.
pub(crate) struct Closed {
    base: Part,
    /// Per contact: lower and upper flank.
    flanks: Vec<[Part; 2]>,
    /// χ_m of the flank at hand.
    indicator: Vec<Complex64>,
    /// Of its switches: angle and sign, phasors, and what turns these from order to order.
    switches: Vec<(f64, f64)>,
    phasors: Vec<Complex64>,
    turns: Vec<Complex64>,
    slopes: Vec<Vec<Complex64>>,
    accelerations: Vec<Vec<Complex64>>,
    sides: BothSides,
}

/// Samples of the drives tried at most.
const MAX: usize = 16_384;

impl Closed {
    /// `None` if the model is not linear on its pieces, its contacts do not add up, or its drives have too many harmonics.
    pub(crate) fn find<'m, M: Periodic + ?Sized>(
        model: &'m M,
        harmonics: &Harmonics,
        couplings: &Couplings,
        slopes: &mut Slopes<'m, M>,
    ) -> Option<Self> {
        if !is_linear_on_pieces(model, slopes) {
            return None;
        }
        let mut samples = 64;
        while samples <= MAX {
            if let Some(closed) = Closed::sampled(model, couplings, slopes, samples) {
                let longest = closed.longest();
                let reach = 2 * harmonics.highest() + harmonics.periods() * longest;
                return Some(Closed {
                    indicator: vec![Complex64::ZERO; reach + 1],
                    slopes: vec![vec![Complex64::ZERO; 2 * harmonics.highest() + 1]; couplings.varying.len()],
                    accelerations: vec![vec![Complex64::ZERO; harmonics.orders().len()]; model.dof()],
                    ..closed
                });
            }
            samples *= 2;
        }
        None
    }

    fn sampled<'m, M: Periodic + ?Sized>(
        model: &'m M,
        couplings: &Couplings,
        slopes: &mut Slopes<'m, M>,
        samples: usize,
    ) -> Option<Self> {
        let contacts = model.contacts();
        let mut look = Look::new(model, couplings, slopes, samples);
        let gap = look.at(&vec![Piece::Gap; contacts], samples);
        let reach = |contact: usize, look: &mut Look<'_, '_, M>| {
            let mut pieces = vec![Piece::Gap; contacts];
            pieces[contact] = Piece::Lower;
            look.at(&pieces, LOOKS).touched(&gap)
        };
        let base = gap.series(None, None)?;
        let reaches: Vec<Vec<bool>> = (0..contacts).map(|c| reach(c, &mut look)).collect();
        let mut flanks: Vec<Option<[Part; 2]>> = (0..contacts).map(|_| None).collect();
        // Contacts that reach nothing in common are looked at together.
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
                look.at(&pieces, samples)
            };
            let (lower, upper) = (on(Piece::Lower), on(Piece::Upper));
            for &c in &group {
                flanks[c] = Some([
                    lower.series(Some(&gap), Some(&reaches[c]))?,
                    upper.series(Some(&gap), Some(&reaches[c]))?,
                ]);
            }
        }
        let flanks = flanks.into_iter().flatten().collect();
        let closed = Closed {
            base,
            flanks,
            indicator: Vec::new(),
            switches: Vec::new(),
            phasors: Vec::new(),
            turns: Vec::new(),
            slopes: Vec::new(),
            accelerations: Vec::new(),
            sides: BothSides::new(model.dof(), contacts),
        };
        // Orders that the samples fold onto lower ones show between the samples.
        [Piece::Gap, Piece::Lower, Piece::Upper]
            .into_iter()
            .all(|piece| closed.agrees(&mut look, piece))
            .then_some(closed)
    }

    /// Whether the series give what the model gives between samples, all contacts on one piece.
    fn agrees<M: Periodic + ?Sized>(&self, look: &mut Look<'_, '_, M>, piece: Piece) -> bool {
        let parts = || {
            let flank = |on: &'_ [Part; 2]| match piece {
                Piece::Lower => 0,
                _ => on.len() - 1,
            };
            let flanks = self.flanks.iter().filter(|_| piece != Piece::Gap).map(move |on| &on[flank(on)]);
            std::iter::once(&self.base).chain(flanks)
        };
        (0..LOOKS).all(|k| {
            let share = weyl(k, 0);
            let seen = look.between(piece, share);
            let agree = |seen: &[Vec<f64>], series: &dyn Fn(&Part) -> &[Series]| {
                seen.iter().enumerate().all(|(i, seen)| {
                    let (sum, size) = parts().fold((0.0, seen[0].abs()), |(sum, size), part| {
                        let value = value_at(&series(part)[i], share);
                        (sum + value, size + value.abs())
                    });
                    (sum - seen[0]).abs() <= AGREE * size
                })
            };
            agree(&seen.force, &|part| &part.force) && agree(&seen.slopes, &|part| &part.slopes)
        })
    }

    fn longest(&self) -> usize {
        let parts = std::iter::once(&self.base).chain(self.flanks.iter().flatten());
        parts.flat_map(|p| p.force.iter().chain(&p.slopes)).map(Vec::len).max().unwrap_or(0)
    }
}

impl<M: Periodic + ?Sized> Integration<M> for Closed {
    fn integrals(&self, _: usize) -> Integrals {
        Integrals::Closed
    }
    fn check(&self) -> Check {
        Check::Unnecessary
    }
    /// The accelerations are products of the slopes and the motion: both are found here.
    fn accelerations(&mut self, motion: &mut Motion<'_, '_, M>, out: &mut Spectra) {
        let Motion { grid, switching, couplings, coefficients } = motion;
        let harmonics = grid.harmonics();
        let (width, periods) = (harmonics.unknowns(), harmonics.periods());
        let reach = 2 * harmonics.highest();
        let Closed { base, flanks, indicator, switches, phasors, turns, slopes, accelerations, .. } = self;
        slopes.iter_mut().chain(&mut *accelerations).for_each(|sum| sum.fill(Complex64::ZERO));
        for (sum, series) in slopes.iter_mut().zip(&base.slopes) {
            for (k, c) in series.iter().enumerate().take_while(|(k, _)| k * periods <= reach) {
                sum[k * periods] += c;
            }
        }
        for (sum, series) in accelerations.iter_mut().zip(&base.force) {
            for (sum, &order) in sum.iter_mut().zip(harmonics.orders()) {
                if order % periods == 0 {
                    *sum += series.get(order / periods).copied().unwrap_or_default();
                }
            }
        }
        for (c, flanks) in flanks.iter().enumerate() {
            for (part, piece) in flanks.iter().zip([Piece::Lower, Piece::Upper]) {
                if !indicate(switching, c, piece, (&mut *switches, &mut *phasors, &mut *turns), indicator) {
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
                    accelerations.iter_mut().zip(&part.force).filter(|(_, series)| !series.is_empty())
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
        for (force, values) in out.accelerations.iter_mut().zip(&*accelerations) {
            for ((i, &order), value) in harmonics.orders().iter().enumerate().zip(values) {
                write(&mut force[harmonics.place(i)..], order, *value);
            }
        }
        // What is linear in the motion: the same products that fill the Jacobian.
        for c in &couplings.list {
            let part = &coefficients[c.j * width..(c.j + 1) * width];
            let force = &mut out.accelerations[c.i];
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
                        Slope::Periodic(number) => {
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
    fn slopes(&mut self, motion: &mut Motion<'_, '_, M>, _: &mut Slopes<'_, M>, out: &mut Spectra) {
        self.sides.jumps(motion.grid, motion.switching, out);
    }
}

/// χ_m of a contact on a flank; `false` if it is never there.
fn indicate(
    switching: &Switching,
    contact: usize,
    flank: Piece,
    (switches, phasors, turns): (&mut Vec<(f64, f64)>, &mut Vec<Complex64>, &mut Vec<Complex64>),
    chi: &mut [Complex64],
) -> bool {
    let per_turn = TAU / switching.samples() as f64;
    switches.clear();
    for event in
        switching.events().iter().filter(|e| e.contact == contact && (e.to == flank || e.from == flank))
    {
        switches.push((event.time(per_turn), if event.to == flank { 1.0 } else { -1.0 }));
    }
    let there_at_first = switching.piece(contact, 0) == flank;
    if switches.is_empty() && !there_at_first {
        return false;
    }
    let share: f64 = switches.iter().map(|(angle, sign)| -sign * angle).sum();
    chi[0] = (share / TAU + f64::from(u8::from(there_at_first))).into();
    // All switches side by side, order by order.
    phasors.clear();
    phasors.extend(switches.iter().map(|&(_, sign)| Complex64::new(sign, 0.0)));
    turns.clear();
    turns.extend(switches.iter().map(|&(angle, _)| Phasors::new(angle).nth(1).unwrap_or_default()));
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
