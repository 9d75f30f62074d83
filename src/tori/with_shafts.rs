//! Periodic models with waves of other shafts added to their drives.

use crate::drives::wrapped::{DriveRule, Wrapped, own_series};
use crate::error::{ParameterError, check};
use crate::excitation::earliest::earlier;
use crate::excitation::{Side, Wave, earliest};
use crate::model::Periodic;
use crate::model::equations::check_slot;
use crate::series::Series;
use crate::tori::quasi_periodic::QuasiPeriodic;
use std::f64::consts::TAU;

/// u\[slot\] += w(ω_d t): a periodic model with waves of other shafts added to chosen drives, for example the
/// torque of a screw or an error of a shaft whose speed has no common measure with that of the model.
///
/// The first angle is 2π t/T with the period T of the model. Each further frequency adds an angle.
///
/// ```
/// use gear_dynamics::{Model, Periodic, Ring, Wave, excitation::{Fourier, Side}, models::ring::RingSet};
/// use gear_dynamics::tori::{QuasiPeriodic, WithShafts};
/// let ring = Ring::as_printed(&RingSet::set_a(3, 1000.0).params()?)?;
/// let (torque, period) = (ring.slot("motor torque")?, ring.period());
/// let ripple = Wave::new(Fourier::new(0.0, &[[5.0, 0.0]])?); // 5 N m cos θ
/// let model = WithShafts::new(ring).add(torque, 70.0, ripple)?;
/// assert_eq!(model.frequencies(), [std::f64::consts::TAU / period, 70.0]);
/// let mut u = vec![0.0; model.drives()];
/// model.drive_at(&[0.3, std::f64::consts::PI], Side::After, &mut u);
/// assert_eq!(u[torque], 44.0 - 5.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type WithShafts<M> = Wrapped<M, ShaftDrives>;

/// The rule of [`WithShafts`]: the base frequencies, the waves and the drives to which they are added.
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, Wave, tori::{QuasiPeriodic, WithShafts}};
/// let model = WithShafts::new(NfgPair::new(&NfgParams::table1())?);
/// let model = model.add(0, 0.01, Wave::constant(0.0)?)?.add(1, 0.01, Wave::constant(0.0)?)?;
/// assert_eq!(model.frequencies()[1..], [0.01]); // both waves are functions of one angle
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug)]
pub struct ShaftDrives {
    /// Base frequencies, that of the model first.
    frequencies: Vec<f64>,
    added: Vec<Added>,
}

/// A wave added to a drive.
#[derive(Clone, Debug)]
struct Added {
    slot: usize,
    /// Index of the angle.
    angle: usize,
    wave: Wave,
}

impl ShaftDrives {
    fn add(&self, angles: impl Fn(usize) -> f64, side: Side, u: &mut [f64]) {
        for Added { slot, angle, wave } in &self.added {
            u[*slot] += wave.value(angles(*angle), side);
        }
    }
    /// Time to the first edge of an added wave.
    fn edge_after(&self, angles: impl Fn(usize) -> f64) -> Option<f64> {
        let time = |Added { angle, wave, .. }: &Added| {
            let here = angles(*angle);
            wave.next_edge(here).map(|edge| (edge - here) / self.frequencies[*angle])
        };
        earliest(self.added.iter().map(time))
    }
}

impl<M: Periodic> WithShafts<M> {
    /// A model to which no wave is added yet.
    pub fn new(model: M) -> Self {
        let frequencies = vec![TAU / model.period()];
        Wrapped::by_rule(model, ShaftDrives { frequencies, added: Vec::new() })
    }

    /// Adds a wave of the angle ω t to the drive `slot`. `frequency`: ω in rad per time unit of the model;
    /// waves with the same frequency share an angle.
    ///
    /// # Errors
    /// A slot that the model does not have; a frequency outside 1e-50 .. 1e50.
    pub fn add(self, slot: usize, frequency: f64, wave: Wave) -> Result<Self, ParameterError> {
        self.map_rule(|model, mut rule| {
            check_slot(model, slot)?;
            check::scale("frequency", frequency)?;
            let known = rule.frequencies.iter().position(|omega| *omega == frequency);
            let angle = known.unwrap_or(rule.frequencies.len());
            if known.is_none() {
                rule.frequencies.push(frequency);
            }
            rule.added.push(Added { slot, angle, wave });
            Ok(rule)
        })
    }
}

impl<M: Periodic> DriveRule<M> for ShaftDrives {
    fn drive(&self, model: &M, t: f64, side: Side, u: &mut [f64]) {
        model.drive(t, side, u);
        self.add(|angle| self.frequencies[angle] * t, side, u);
    }
    fn changes(&self, _: &M, drive: usize) -> bool {
        self.added.iter().any(|added| added.slot == drive)
    }
    fn next_edge(&self, model: &M, t: f64) -> Option<f64> {
        let added = self.edge_after(|angle| self.frequencies[angle] * t);
        earlier(model.next_edge(t), added.map(|after| t + after))
    }
    fn next_knot(&self, model: &M, t: f64) -> Option<f64> {
        self.added.iter().fold(model.next_knot(t), |first, Added { angle, wave, .. }| {
            let omega = self.frequencies[*angle];
            earlier(first, wave.next_knot(omega * t).map(|knot| knot / omega))
        })
    }
    fn series(&self, model: &M, t: f64, coefficients: usize, u: &mut [Series]) {
        own_series(model, t, coefficients, u);
        for Added { slot, angle, wave } in &self.added {
            let omega = self.frequencies[*angle];
            u[*slot] = u[*slot] + wave.value(Series::variable(omega * t, omega, coefficients), Side::After);
        }
    }
}

impl<M: Periodic> QuasiPeriodic for WithShafts<M> {
    fn frequencies(&self) -> Vec<f64> {
        self.rule().frequencies.clone()
    }
    fn drive_at(&self, angles: &[f64], side: Side, u: &mut [f64]) {
        self.bare().drive(angles[0] / self.rule().frequencies[0], side, u);
        self.rule().add(|angle| angles[angle], side, u);
    }
    fn edge_after(&self, angles: &[f64]) -> Option<f64> {
        let t = angles[0] / self.rule().frequencies[0];
        let own = self.bare().next_edge(t).map(|edge| edge - t);
        earlier(own, self.rule().edge_after(|angle| angles[angle]))
    }
}
