//! How finely a model has to be sampled: the highest orders that its drives hold, as accelerations and tooth edges show them.

use crate::contact::piece::Piece;
use crate::contact::tooth::Contact;
use crate::excitation::side::Side;
use crate::model::equations::Periodic;
use crate::model::slopes::accelerate;
use crate::numeric::spread::weyl;
use crate::periodic::balance::amplitudes::sizes;
use crate::periodic::balance::orbit::FourierOrbit;
use crate::periodic::balance::quadrature::at_rest::{Series, series, value_at};
use crate::periodic::balance::quadrature::panels::quadrature;
use crate::periodic::balance::series::grid::Grid;
use crate::periodic::balance::series::harmonics::Harmonics;
use crate::periodic::balance::series::transform::{Transform, samples_for};

/// Orders of the model's own frequency.
pub(crate) struct Orders {
    /// The highest that is more than rounding.
    pub(crate) highest: usize,
    /// The highest for polynomials of degree 15, whose error grows like k^16: weak orders weigh less, k (c_k/c)^(1/16).
    pub(crate) weighed: usize,
}

/// What is looked at.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Signals {
    /// How far contacts are from their edges.
    Edges,
    /// That, and accelerations.
    All,
}

/// Samples of a period tried at most.
const MAX: usize = 16_384;

/// Instants looked at between the samples.
const LOOKS: usize = 4;

/// How closely the series have to give the model there.
const AGREE: f64 = 1e-11;

/// Shares of the largest coefficient that count.
const COUNTS: f64 = 1e-13;

/// Multiples of the state at which panels are tried.
const STATES: [f64; 3] = [1.0, -4.0, 4.0];

/// A model at one state, seen through its drives.
pub(crate) struct DriveSampler<'m, M: ?Sized> {
    model: &'m M,
    /// How contacts stand when accelerations are asked for.
    ways: Vec<Option<Vec<Piece>>>,
    q: Vec<f64>,
    far: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    u: Vec<f64>,
    contacts: Vec<Contact>,
}

impl<'m, M: Periodic + ?Sized> DriveSampler<'m, M> {
    /// At a state of the size of coordinates and velocities.
    pub(crate) fn new(model: &'m M, size: [&[f64]; 2], ways: Vec<Option<Vec<Piece>>>) -> Self {
        let part = |half: usize| {
            size[half].iter().enumerate().map(|(j, s)| s * (2.0 * weyl(0, 1 + 2 * j + half) - 1.0)).collect()
        };
        DriveSampler {
            model,
            ways,
            q: part(0),
            far: part(0),
            v: part(1),
            a: vec![0.0; model.dof()],
            u: vec![0.0; model.drives()],
            contacts: vec![Contact::default(); model.contacts()],
        }
    }

    /// Numbers that one look gives: the distances to both edges of every contact, then the accelerations of every way.
    pub(crate) fn signals(&self) -> usize {
        2 * self.contacts.len() + self.ways.len() * self.a.len()
    }

    /// How far contacts are from their edges, then accelerations as far as `out` reaches, at an instant whose drives may be known.
    pub(crate) fn read(&mut self, t: f64, drives: Option<&[f64]>, out: &mut [f64]) {
        let u = match drives {
            Some(u) => u,
            None => {
                self.model.drive(t, Side::After, &mut self.u);
                &self.u
            }
        };
        let (edges, accelerations) = out.split_at_mut(2 * self.contacts.len());
        if !self.contacts.is_empty() {
            self.model.contact(u, &self.q, &self.v, &mut self.contacts);
        }
        for (out, contact) in edges.chunks_exact_mut(2).zip(&self.contacts) {
            for (out, edge) in out.iter_mut().zip([contact.lower, contact.upper]) {
                *out = if edge.is_finite() { contact.deflection - edge } else { 0.0 };
            }
        }
        for (out, pieces) in accelerations.chunks_exact_mut(self.a.len()).zip(&self.ways) {
            accelerate(self.model, pieces.as_deref(), u, &self.q, &self.v, out);
        }
    }

    /// The highest orders, found by sampling with growing powers of two until the spectra end; `None` if they do not. `known`: a grid whose
    /// drives may be taken.
    pub(crate) fn orders(&mut self, of: Signals, known: Option<&Grid<'_, M>>) -> Option<Orders> {
        let mut samples = 64;
        loop {
            let orders = self.settled(
                of,
                samples,
                known.filter(|g| g.samples().is_multiple_of(samples) && g.harmonics().periods() == 1),
            );
            if orders.is_some() || samples == MAX {
                return orders;
            }
            samples *= 2;
        }
    }

    fn settled(&mut self, of: Signals, samples: usize, known: Option<&Grid<'_, M>>) -> Option<Orders> {
        let accelerations = if of == Signals::Edges { 0 } else { self.ways.len() * self.a.len() };
        let (period, mut now) = (self.model.period(), vec![0.0; 2 * self.contacts.len() + accelerations]);
        let mut values = vec![vec![Default::default(); samples]; now.len()];
        for s in 0..samples {
            let drives = known.map(|grid| grid.drives(s * (grid.samples() / samples)));
            self.read(period * s as f64 / samples as f64, drives, &mut now);
            values.iter_mut().zip(&now).for_each(|(values, now)| values[s] = (*now).into());
        }
        let mut transform = Transform::new(samples);
        let mut spectra: Vec<Series> =
            values.iter_mut().map(|values| series(&mut transform, values)).collect::<Option<_>>()?;
        let (mut highest, mut weighed) = (0, 0.0f64);
        for spectrum in &mut spectra {
            let largest = spectrum.iter().fold(0.0, |m: f64, c| m.max(c.norm()));
            spectrum.truncate(
                spectrum.iter().rposition(|c| c.norm() > COUNTS * largest).map_or(0, |last| last + 1),
            );
            highest = highest.max(spectrum.len().saturating_sub(1));
            for (k, c) in spectrum.iter().enumerate() {
                weighed = weighed.max(k as f64 * (c.norm() / largest).sqrt().sqrt().sqrt().sqrt());
            }
        }
        // Orders that the samples fold onto lower ones show between the samples.
        for look in 0..LOOKS {
            let share = weyl(look, 0);
            self.read(period * share, None, &mut now);
            let size = |spectrum: &Series| spectrum.iter().map(|c| c.norm()).sum::<f64>();
            if now
                .iter()
                .zip(&spectra)
                .any(|(now, spectrum)| (now - value_at(spectrum, share)).abs() > AGREE * size(spectrum))
            {
                return None;
            }
        }
        Some(Orders { highest, weighed: weighed.ceil() as usize })
    }

    /// The order whose panels integrate accelerations to rounding between jumps of the drives, `least` or more; `least` itself if none does.
    /// States well past the tooth edges show what a model that hides its pieces does on its flanks.
    pub(crate) fn panel_order(&mut self, breaks: &[f64], span: f64, least: usize) -> usize {
        let n = self.a.len();
        let mut integrals = |order: usize| {
            let mut sums = vec![[0.0; 4]; self.ways.len() * STATES.len() * n];
            quadrature(breaks, span, order, |t, share| {
                self.model.drive(t, Side::After, &mut self.u);
                let mut sums = sums.iter_mut();
                for (pieces, scale) in
                    self.ways.iter().flat_map(|way| STATES.iter().map(move |scale| (way.as_deref(), scale)))
                {
                    self.far.iter_mut().zip(&self.q).for_each(|(far, q)| *far = scale * q);
                    accelerate(self.model, pieces, &self.u, &self.far, &self.v, &mut self.a);
                    for (a, sums) in self.a.iter().zip(&mut sums) {
                        let x = t / span;
                        sums.iter_mut()
                            .zip([a.abs(), *a, a * x, a * x * x])
                            .for_each(|(sum, value)| *sum += share * value);
                    }
                }
            });
            sums
        };
        let (mut order, mut rough) = (least, integrals(least));
        while order <= (16 * least).max(512) {
            let fine = integrals(2 * order);
            let agree = |(rough, fine): (&[f64; 4], &[f64; 4])| {
                (1..4).all(|k| (rough[k] - fine[k]).abs() <= AGREE * fine[0])
            };
            if rough.iter().zip(&fine).all(agree) {
                return order;
            }
            (order, rough) = (2 * order, fine);
        }
        least
    }
}

/// Samples for located switches: fine enough for the kept orders and for those of the drives.
pub(crate) fn samples_following<M: Periodic + ?Sized>(
    drives: &mut DriveSampler<'_, M>,
    of: Signals,
    harmonics: &Harmonics,
) -> usize {
    let of_drives = drives.orders(of, None).map_or(0, |orders| orders.weighed * harmonics.periods());
    samples_for(harmonics.highest().max(of_drives))
}

/// Samples that show where an orbit meets the tooth edges.
pub(crate) fn samples_along<M: Periodic + ?Sized>(model: &M, orbit: &FourierOrbit) -> usize {
    let (size, fastest) = (sizes(orbit), orbit.frequency() * orbit.harmonics().highest().max(1) as f64);
    let rates: Vec<f64> = size.iter().map(|s| s * fastest).collect();
    samples_following(
        &mut DriveSampler::new(model, [&size, &rates], Vec::new()),
        Signals::Edges,
        orbit.harmonics(),
    )
}
