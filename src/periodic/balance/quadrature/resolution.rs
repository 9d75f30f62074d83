//! Number of samples and width of panels that a model requires. They follow from the highest orders of the
//! accelerations and of the distances from the tooth edges at a fixed state, which are those of the drives.

use crate::contact::{Contact, Piece};
use crate::excitation::Side;
use crate::model::Periodic;
use crate::model::structure::slopes::accelerate;
use crate::numeric::spread::weyl;
use crate::ode::budget::Meter;
use crate::periodic::balance::amplitudes::sizes;
use crate::periodic::balance::fourier_orbit::FourierOrbit;
use crate::periodic::balance::quadrature::at_rest::{Series, series, value_at};
use crate::periodic::balance::quadrature::panel_points::quadrature;
use crate::periodic::balance::series::grid::Grid;
use crate::periodic::balance::series::harmonics::Harmonics;
use crate::periodic::balance::series::transform::{Transform, samples_for};

/// Orders of the drives of a model, as multiples of 1/period.
pub(crate) struct Orders {
    /// Highest order k with |c_k| above rounding.
    pub(crate) highest: usize,
    /// max_k k (|c_k|/|c|)^(1/16), |c| the largest coefficient: the order that polynomials of degree 15 must
    /// resolve. Their error grows like k^16, so that weak orders weigh less.
    pub(crate) weighed: usize,
}

/// Signals whose orders are determined.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Signals {
    /// Distances of the contacts from their edges.
    Edges,
    /// Distances of the contacts from their edges, and accelerations.
    All,
}

/// Maximum number of samples of a period.
const MAX_SAMPLES_PER_PERIOD: usize = 16_384;

/// Number of instants between the samples at which the series are compared with the model.
const PROBES: usize = 4;

/// Largest deviation of the series from the model at these instants, as a share of the sum of all |c_k|
/// `[1]`. Also the largest change of the integrals by panels of half the width, as a share of the integral of
/// the absolute value `[1]`.
const INTEGRALS_AGREE: f64 = 1e-11;

/// Coefficients up to this share of the largest count as rounding `[1]`.
const COUNTS: f64 = 1e-13;

/// Factors on the coordinates at which the panels are tested.
const STATES: [f64; 3] = [1.0, -4.0, 4.0];

/// Sampler of a model at one fixed state, so that only the drives vary.
pub(crate) struct DriveSampler<'m> {
    model: &'m dyn Periodic,
    /// Fixed pieces on which the accelerations are evaluated, one entry for each evaluation; `None`:
    /// evaluation by deflection.
    ways: Vec<Option<Vec<Piece>>>,
    q: Vec<f64>,
    /// The coordinates times a factor of `STATES`.
    far: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    u: Vec<f64>,
    contacts: Vec<Contact>,
    /// Time limit and flag of the call. When it is exhausted, nothing is evaluated any more.
    meter: Option<&'m Meter<'m>>,
    reads: usize,
}

impl<'m> DriveSampler<'m> {
    /// A sampler at a state within the given sizes of coordinates and velocities. `ways`: fixed pieces for
    /// the accelerations, or `None` for evaluation by deflection.
    pub(crate) fn new(
        model: &'m dyn Periodic,
        size: [&[f64]; 2],
        ways: Vec<Option<Vec<Piece>>>,
        meter: Option<&'m Meter<'m>>,
    ) -> Self {
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
            meter,
            reads: 0,
        }
    }

    /// Whether the time limit or the flag ends the call; checked at every 64th evaluation.
    fn is_exhausted(&mut self) -> bool {
        self.reads += 1;
        self.meter.is_some_and(|meter| {
            if self.reads.is_multiple_of(64) { meter.check().is_err() } else { meter.exhausted().is_some() }
        })
    }

    /// Number of signals: the distances of every contact from its two edges, then the accelerations for every
    /// entry of `ways`.
    pub(crate) fn signals(&self) -> usize {
        2 * self.contacts.len() + self.ways.len() * self.a.len()
    }

    /// Writes the signals at time t to `out`: the distances of the contacts from their edges, then as many
    /// accelerations as `out` has entries for. `drives`: the drives at t, if they are known.
    pub(crate) fn read(&mut self, t: f64, drives: Option<&[f64]>, out: &mut [f64]) {
        if self.is_exhausted() {
            return;
        }
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

    /// The orders of the signals. The number of samples is doubled until the spectra have decayed; `None` if
    /// they have not decayed with [`MAX_SAMPLES_PER_PERIOD`] samples. `known`: a grid whose drives may be
    /// used.
    pub(crate) fn orders(&mut self, of: Signals, known: Option<&Grid<'_>>) -> Option<Orders> {
        let mut samples = 64;
        loop {
            let orders = self.settled(
                of,
                samples,
                known.filter(|g| g.samples().is_multiple_of(samples) && g.harmonics().period_multiple() == 1),
            );
            if orders.is_some() || samples == MAX_SAMPLES_PER_PERIOD {
                return orders;
            }
            samples *= 2;
        }
    }

    /// The orders from this number of samples; `None` if the samples are too few.
    fn settled(&mut self, of: Signals, samples: usize, known: Option<&Grid<'_>>) -> Option<Orders> {
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
        // Aliased orders show as deviations between the samples.
        for probe in 0..PROBES {
            let share = weyl(probe, 0);
            self.read(period * share, None, &mut now);
            let size = |spectrum: &Series| spectrum.iter().map(|c| c.norm()).sum::<f64>();
            if now.iter().zip(&spectra).any(|(now, spectrum)| {
                (now - value_at(spectrum, share)).abs() > INTEGRALS_AGREE * size(spectrum)
            }) {
                return None;
            }
        }
        Some(Orders { highest, weighed: weighed.ceil() as usize })
    }

    /// The order whose panels integrate the accelerations to [`INTEGRALS_AGREE`] between drive edges: the
    /// first of `least`, 2 `least`, 4 `least`, ... that does, or `least` if none up to max(16 `least`, 512)
    /// does.
    ///
    /// With factors of -4 and 4 the coordinates are well past the tooth edges. A model without fixed pieces
    /// is thus also evaluated on its flanks.
    pub(crate) fn panel_order(&mut self, breaks: &[f64], span: f64, least: usize) -> usize {
        let n = self.a.len();
        let mut integrals = |order: usize| {
            let mut sums = vec![[0.0; 4]; self.ways.len() * STATES.len() * n];
            quadrature(breaks, span, order, |t, share| {
                if self.is_exhausted() {
                    return;
                }
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
                (1..4).all(|k| (rough[k] - fine[k]).abs() <= INTEGRALS_AGREE * fine[0])
            };
            if rough.iter().zip(&fine).all(agree) {
                return order;
            }
            (order, rough) = (2 * order, fine);
        }
        least
    }
}

/// Number of samples for located crossings: it resolves the kept orders and the orders of the drives.
pub(crate) fn samples_following(drives: &mut DriveSampler<'_>, of: Signals, harmonics: &Harmonics) -> usize {
    let of_drives = drives.orders(of, None).map_or(0, |orders| orders.weighed * harmonics.period_multiple());
    samples_for(harmonics.highest().max(of_drives))
}

/// Number of samples that resolves the crossings of an orbit.
pub(crate) fn samples_along(model: &dyn Periodic, orbit: &FourierOrbit) -> usize {
    let (size, fastest) = (sizes(orbit), orbit.frequency() * orbit.harmonics().highest().max(1) as f64);
    let rates: Vec<f64> = size.iter().map(|s| s * fastest).collect();
    samples_following(
        &mut DriveSampler::new(model, [&size, &rates], Vec::new(), None),
        Signals::Edges,
        orbit.harmonics(),
    )
}
