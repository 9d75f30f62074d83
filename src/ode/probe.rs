//! Named output channels, the same for every solver.

use crate::contact::tooth::Contact;
use crate::error::ParameterError;
use crate::excitation::side::Side;
use crate::model::equations::{Channel, Model};
use crate::ode::step::Step;

/// Where the limit of a channel at an edge is looked for first, as a share of the step; then ever further inside, up to the last share.
const LIMIT: [f64; 2] = [4e-15, 1e-3];

/// Reads every channel of a model at one instant.
///
/// Every model has its coordinates `q1`, `q2`, ... and velocities `v1`, ...; then `deflection`, `mesh force` and `contact` (1 touching, 0
/// in the gap), numbered from 1 when there are several contacts; then [channels of its own](Model::channels). Coordinates, deflections
/// and forces are in the units of the model and carry none of their own.
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, analysis::Probe, excitation::Side};
/// let pair = NfgPair::new(&NfgParams::table1())?;
/// let start = pair.static_start()?;
/// let mut probe = Probe::new(&pair);
/// let force = probe.index("mesh force")?;
/// let values = probe.read(start.t, Side::After, &start.q, &start.v);
/// assert!((values[force] + 270.27).abs() < 0.01); // T2/r_b2(0) = 30 N m/0.111 m
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Probe<'m, M: ?Sized> {
    model: &'m M,
    channels: Vec<Channel>,
    drives: Vec<f64>,
    contacts: Vec<Contact>,
    values: Vec<f64>,
    /// Values a little further inside a step.
    inside: Vec<f64>,
}

impl<'m, M: Model + ?Sized> Probe<'m, M> {
    /// All channels of a model.
    pub fn new(model: &'m M) -> Self {
        let (n, contacts) = (model.dof(), model.contacts());
        let mut channels: Vec<Channel> = (1..=n).map(|i| Channel::new(format!("q{i}"), "")).collect();
        channels.extend((1..=n).map(|i| Channel::new(format!("v{i}"), "")));
        for i in 1..=contacts {
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
            contacts: vec![Contact::default(); contacts],
            values: vec![0.0; channels.len()],
            inside: vec![0.0; channels.len()],
            channels,
        }
    }

    /// The channels, in the order of the values.
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// Where a channel stands.
    ///
    /// # Errors
    /// [`ParameterError::NoSuchChannel`], which lists the names there are.
    pub fn index(&self, name: &str) -> Result<usize, ParameterError> {
        self.channels.iter().position(|c| c.name == name).ok_or_else(|| ParameterError::NoSuchChannel {
            name: name.into(),
            known: self.channels.iter().map(|c| c.name.as_str()).collect::<Vec<_>>().join(", "),
        })
    }

    /// The values of all channels.
    pub fn read(&mut self, t: f64, side: Side, q: &[f64], v: &[f64]) -> &[f64] {
        self.read_contacts(t, side, q, v);
        let n = q.len();
        let (coordinates, rest) = self.values.split_at_mut(2 * n);
        coordinates[..n].copy_from_slice(q);
        coordinates[n..].copy_from_slice(v);
        let (of_contacts, own) = rest.split_at_mut(3 * self.contacts.len());
        for (out, c) in of_contacts.chunks_exact_mut(3).zip(&self.contacts) {
            out.copy_from_slice(&[c.deflection, c.force, if c.penetration() > 0.0 { 1.0 } else { 0.0 }]);
        }
        self.model.observe(&self.drives, q, v, &self.contacts, own);
        &self.values
    }

    /// The values last read.
    pub fn values(&self) -> &[f64] {
        &self.values
    }
    /// The contacts last read.
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts
    }

    /// The contacts alone.
    pub fn read_contacts(&mut self, t: f64, side: Side, q: &[f64], v: &[f64]) -> &[Contact] {
        self.model.drive(t, side, &mut self.drives);
        self.model.contact(&self.drives, q, v, &mut self.contacts);
        &self.contacts
    }

    /// The values at `t` of a step, its ends seen from inside; `y` takes coordinates and velocities.
    ///
    /// At its edge a contact may lie a rounding beside the piece on which the step was made, and a force that jumps there reads wrong: the
    /// values are then the limit from inside the step.
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

    fn read_at(&mut self, step: &mut Step<'_>, t: f64, side: Side, y: &mut [f64]) {
        step.at(t, y);
        let (q, v) = y.split_at(y.len() / 2);
        self.read(t, side, q, v);
    }

    /// Whether the contacts last read stand on the pieces of the step.
    fn on_pieces(&self, step: &Step<'_>) -> bool {
        step.pieces()
            .is_none_or(|pieces| pieces.iter().zip(&self.contacts).all(|(piece, c)| *piece == c.piece()))
    }
}
