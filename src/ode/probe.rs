//! Named output channels of a model.

use crate::contact::Contact;
use crate::error::{ParameterError, check};
use crate::excitation::Side;
use crate::model::{Channel, Model};
use crate::ode::step::Step;
use std::fmt;

/// First and last distance from an edge at which a channel is sampled for its limit there, as shares of the
/// step.
const LIMIT: [f64; 2] = [4e-15, 1e-3];

/// A channel that the motion and one contact determine, with the index of its coordinate or contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ChannelKind {
    Coordinate(usize),
    Velocity(usize),
    Deflection(usize),
    Force(usize),
}

/// Evaluates all channels of a model at one instant.
///
/// The channels of a model, in order:
/// - the coordinates `q0`, `q1`, ... and the velocities `v0`, `v1`, ...;
/// - `deflection`, `mesh force` and `contact` (1 touching, 0 in the gap), with its index, as
///   `deflection 0`, if there are several contacts;
/// - the model's [own channels](Model::channels).
///
/// Coordinates, velocities, deflections and forces have the units of the model; their unit text is empty.
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, ode::Probe, excitation::Side};
/// let pair = NfgPair::new(&NfgParams::table1())?;
/// let start = pair.on_drive_flank()?;
/// let mut probe = Probe::new(&pair);
/// let force = probe.index("mesh force")?;
/// let values = probe.read(start.t, Side::After, &start.q, &start.v);
/// assert!((values[force] + 270.27).abs() < 0.01); // T2/r_b2(0) = 30 N m/0.111 m
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Probe<'m> {
    model: &'m dyn Model,
    channels: Vec<Channel>,
    /// The drives of the last evaluation.
    pub(crate) drives: Vec<f64>,
    contacts: Vec<Contact>,
    /// Number of contacts at which teeth may touch.
    touching: usize,
    values: Vec<f64>,
    /// Values at the farther of two points inside a step.
    inside: Vec<f64>,
}

impl fmt::Debug for Probe<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Probe")
            .field("channels", &self.channels)
            .field("values", &self.values)
            .finish_non_exhaustive()
    }
}

/// Some rounding errors of a coordinate, as a share of it `[1]`.
const ROUNDINGS: f64 = 1e-14;

/// Their largest effect on a channel whose changes are resolved, as a share of these `[1]`.
const RESOLVED: f64 = 0.03;

impl<'m> Probe<'m> {
    /// A probe for all channels of a model.
    pub fn new(model: &'m dyn Model) -> Self {
        let n = model.dof();
        let contacts = model.offers().touching(model.contacts());
        let mut channels: Vec<Channel> = (0..n).map(|i| Channel::new(format!("q{i}"), "")).collect();
        channels.extend((0..n).map(|i| Channel::new(format!("v{i}"), "")));
        for i in 0..contacts {
            for (name, unit) in [("deflection", ""), ("mesh force", ""), ("contact", "1")] {
                channels.push(Channel::new(
                    if contacts == 1 { name.to_owned() } else { format!("{name} {i}") },
                    unit,
                ));
            }
        }
        channels.extend(model.channels());
        Probe {
            model,
            drives: vec![0.0; model.drives()],
            contacts: vec![Contact::default(); model.contacts()],
            touching: contacts,
            values: vec![0.0; channels.len()],
            inside: vec![0.0; channels.len()],
            channels,
        }
    }

    /// The channels, in the order of the values.
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// Index of a channel in the values.
    ///
    /// # Errors
    /// [`ParameterError::NoSuchChannel`], which lists the channels of the model.
    pub fn index(&self, name: &str) -> Result<usize, ParameterError> {
        let names: Vec<&str> = self.channels.iter().map(|channel| channel.name.as_str()).collect();
        check::channel_index(&names, name)
    }

    /// Indices of channels in the values.
    ///
    /// # Errors
    /// As [`index`](Probe::index).
    pub(crate) fn indices<N: AsRef<str>>(
        &self,
        names: impl IntoIterator<Item = N>,
    ) -> Result<Vec<usize>, ParameterError> {
        names.into_iter().map(|name| self.index(name.as_ref())).collect()
    }

    /// Whether the probe reads a model with `dof` coordinates and `contacts` contacts.
    ///
    /// # Errors
    /// [`ParameterError::OtherModel`].
    pub(crate) fn fits(&self, dof: usize, contacts: usize) -> Result<(), ParameterError> {
        let (own, other) = ([self.model.dof(), self.contacts.len()], [dof, contacts]);
        if own == other { Ok(()) } else { Err(ParameterError::OtherModel { own, other }) }
    }

    /// The kind of channel `index`; `None` for the state of a contact and for the model's own channels.
    pub(crate) fn kind(&self, index: usize) -> Option<ChannelKind> {
        let n = self.model.dof();
        let Some(of_contact) = index.checked_sub(2 * n) else {
            return Some(match index.checked_sub(n) {
                None => ChannelKind::Coordinate(index),
                Some(velocity) => ChannelKind::Velocity(velocity),
            });
        };
        let contact = Some(of_contact / 3).filter(|contact| *contact < self.touching)?;
        [Some(ChannelKind::Deflection(contact)), Some(ChannelKind::Force(contact)), None][of_contact % 3]
    }

    /// Evaluates all channels at `t`. `side`: the drives before or after a jump at `t`.
    pub fn read(&mut self, t: f64, side: Side, q: &[f64], v: &[f64]) -> &[f64] {
        self.drive(t, side);
        self.evaluate(q, v)
    }

    /// Evaluates the drives only.
    pub(crate) fn drive(&mut self, t: f64, side: Side) {
        self.model.drive(t, side, &mut self.drives);
    }

    /// Evaluates all channels under the drives of the last evaluation.
    pub(crate) fn evaluate(&mut self, q: &[f64], v: &[f64]) -> &[f64] {
        self.evaluate_contacts(q, v);
        let n = q.len();
        let (coordinates, rest) = self.values.split_at_mut(2 * n);
        coordinates[..n].copy_from_slice(q);
        coordinates[n..].copy_from_slice(v);
        let (of_contacts, own) = rest.split_at_mut(3 * self.touching);
        for (out, c) in of_contacts.chunks_exact_mut(3).zip(&self.contacts) {
            out.copy_from_slice(&[c.deflection, c.force, if c.penetration() > 0.0 { 1.0 } else { 0.0 }]);
        }
        self.model.write_channels(&self.drives, q, v, &self.contacts, own);
        &self.values
    }

    /// The values of the last evaluation; zeros before the first.
    pub fn values(&self) -> &[f64] {
        &self.values
    }
    /// The contacts of the last evaluation.
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts
    }

    /// Evaluates the contacts only.
    pub fn read_contacts(&mut self, t: f64, side: Side, q: &[f64], v: &[f64]) -> &[Contact] {
        self.drive(t, side);
        self.evaluate_contacts(q, v)
    }

    /// Evaluates the contacts only, under the drives of the last evaluation.
    pub(crate) fn evaluate_contacts(&mut self, q: &[f64], v: &[f64]) -> &[Contact] {
        self.model.contact(&self.drives, q, v, &mut self.contacts);
        &self.contacts
    }

    /// The values at the time `t` of a step. At the ends of the step they are the limits from inside it.
    /// Coordinates and velocities at `t` are written to `y`.
    ///
    /// Rounding may put a contact on its edge beside the piece of the step; a force that jumps at the edge is
    /// then wrong. In this case the values are extrapolated from inside the step: c(t) ≈ 2 c(t + δ) - c(t +
    /// 2δ), with the smallest δ at which both samples lie on the pieces of the step.
    pub(crate) fn read_step(&mut self, step: &mut Step<'_>, t: f64, y: &mut [f64]) -> &[f64] {
        let side = if t == step.t1() { Side::Before } else { Side::After };
        self.read_at(step, t, side, y);
        if self.on_pieces(step) {
            return &self.values;
        }
        let length = step.t1() - step.t0();
        let inwards = if t - step.t0() > 0.5 * length { -length } else { length };
        let mut share = LIMIT[0];
        while share < LIMIT[1] {
            let (near, far) = (t + inwards * share, t + 2.0 * inwards * share);
            share *= 8.0;
            self.read_at(step, far, Side::After, y);
            if near == t || !self.on_pieces(step) {
                continue;
            }
            self.inside.copy_from_slice(&self.values);
            self.read_at(step, near, Side::After, y);
            if self.on_pieces(step) {
                for (near, far) in self.values.iter_mut().zip(&self.inside) {
                    *near += *near - far;
                }
                step.at(t, y);
                self.values[..y.len()].copy_from_slice(y);
                return &self.values;
            }
        }
        self.read_at(step, t, side, y);
        &self.values
    }

    /// Whether changes by `range` of channel `index` near the time `t` of a step are above the rounding
    /// errors of coordinates and velocities. `y`: scratch.
    pub(crate) fn resolves(
        &mut self,
        step: &mut Step<'_>,
        t: f64,
        (index, range): (usize, f64),
        y: &mut [f64],
    ) -> bool {
        let exact = self.read_step(step, t, y)[index];
        for (i, y) in y.iter_mut().enumerate() {
            *y *= 1.0 + if i % 2 == 0 { ROUNDINGS } else { -ROUNDINGS };
        }
        let (q, v) = y.split_at(y.len() / 2);
        let change = (self.read(t, Side::After, q, v)[index] - exact).abs();
        change.max(ROUNDINGS * exact.abs()) < RESOLVED * range
    }

    fn read_at(&mut self, step: &mut Step<'_>, t: f64, side: Side, y: &mut [f64]) {
        step.at(t, y);
        let (q, v) = y.split_at(y.len() / 2);
        self.read(t, side, q, v);
    }

    /// Whether the contacts of the last evaluation stand on the pieces of the step.
    fn on_pieces(&self, step: &Step<'_>) -> bool {
        step.pieces()
            .is_none_or(|pieces| pieces.iter().zip(&self.contacts).all(|(piece, c)| *piece == c.piece()))
    }
}
