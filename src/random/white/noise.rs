//! Sources of white noise.

use crate::contact::{Contact, Piece};
use crate::error::{ParameterError, check};
use crate::excitation::Side;
use crate::model::Model;
use crate::model::equations::check_slot;
use crate::model::structure::slopes::accelerate;
use crate::numeric::spread::weyl;

/// White noise ξ of intensity D on a model: ⟨ξ(t) ξ(t + τ)⟩ = δ(τ), so that the power density of √D ξ is D
/// on both sides of frequency 0 and 2 D one-sided, in unit²/Hz.
///
/// ```
/// use gear_dynamics::random::WhiteNoise;
/// let bath = WhiteNoise::bath(0, 0.1, 0.02)?; // q0'' = ... - 0.1 q0' + √0.02 ξ
/// assert_eq!(bath.intensity(), 0.02);
/// assert!(WhiteNoise::bath(0, -0.1, 0.02).is_err());
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct WhiteNoise {
    pub(crate) target: Target,
    pub(crate) intensity: f64,
}

/// What a white noise acts on.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Target {
    Bath {
        coordinate: usize,
        damping: f64,
    },
    /// Slots with their gains.
    Drives(Vec<(usize, f64)>),
}

impl WhiteNoise {
    /// A bath on one coordinate: viscous damping c and noise, beside the acceleration a of the model,
    ///
    /// q'' = a(u, q, q') - c q' + √D ξ(t)
    ///
    /// The damping of the bath is that of this equation alone; set to 0 a damping constant of the model that
    /// means the same. Damping in the bath is advanced exactly, so that the stationary density of a model
    /// without other damping has no error of the splitting. c = 0: noise alone, for models whose damping is
    /// in their algebra.
    ///
    /// Units: c in 1/time, D in acceleration² × time.
    ///
    /// # Errors
    /// A damping or an intensity that is negative or above 1e50.
    pub fn bath(coordinate: usize, damping: f64, intensity: f64) -> Result<Self, ParameterError> {
        let damping = check::not_negative("damping of the bath", damping)?;
        let intensity = check::not_negative("intensity of the noise", intensity)?;
        Ok(WhiteNoise { target: Target::Bath { coordinate, damping }, intensity })
    }

    /// Noise on drives, with the same ξ for all of them: for each `(slot, gain)`
    ///
    /// u_slot ← u_slot + gain √D ξ(t)
    ///
    /// Slots are those of [`Machine::slot`](crate::model::Machine::slot). The acceleration must be affine in
    /// them. Where it multiplies them by the state, the equation is meant in the sense of **Stratonovich**:
    /// the limit of noise whose correlation time tends to 0. With g = Σ gain ∂a/∂u_slot the equation of Ito
    /// has the additional acceleration (D/2) (∂g/∂q') g. It is 0 unless a noisy constant is a factor of a
    /// velocity: random damping c + √D ξ acts in the mean as damping c - D/2.
    ///
    /// # Errors
    /// An intensity that is negative or above 1e50; no slot; a gain beyond ±1e50.
    pub fn drives(slots: &[(usize, f64)], intensity: f64) -> Result<Self, ParameterError> {
        if slots.is_empty() {
            return Err(ParameterError::Empty { name: "slots of the noise".into(), min: 1 });
        }
        slots.iter().try_for_each(|(_, gain)| check::quantity("gain of the noise", *gain).map(drop))?;
        let intensity = check::not_negative("intensity of the noise", intensity)?;
        Ok(WhiteNoise { target: Target::Drives(slots.to_vec()), intensity })
    }

    /// Intensity D.
    pub fn intensity(&self) -> f64 {
        self.intensity
    }

    /// Checks that a model has the coordinate or the slots, and that white noise on them has a meaning.
    /// Returns whether the acceleration that the noise adds depends on the velocities.
    pub(crate) fn check(&self, model: &dyn Model) -> Result<bool, ParameterError> {
        match &self.target {
            Target::Bath { coordinate, .. } if *coordinate < model.dof() => Ok(false),
            Target::Bath { coordinate, .. } => Err(ParameterError::Wrong {
                name: "coordinate of the bath".into(),
                value: *coordinate as f64,
                must: format!("be below {}, the number of coordinates of the model", model.dof()),
            }),
            Target::Drives(slots) => {
                slots.iter().try_for_each(|(slot, _)| check_slot(model, *slot))?;
                self.check_drives(model, slots)
            }
        }
    }

    /// The drives with one unit of noise added to the slots, and that unit: the size of the drives over that
    /// of the gains.
    pub(crate) fn unit_on(slots: &[(usize, f64)], drives: &[f64]) -> (Vec<f64>, f64) {
        let scale = slots.iter().map(|(slot, _)| drives[*slot].abs()).fold(0.0, f64::max);
        let gain = slots.iter().map(|(_, gain)| gain.abs()).fold(f64::MIN_POSITIVE, f64::max);
        let unit = if scale > 0.0 { scale / gain } else { 1.0 / gain };
        let mut u = drives.to_vec();
        slots.iter().for_each(|(slot, gain)| u[*slot] += gain * unit);
        (u, unit)
    }

    /// Compares accelerations and edges at some states with 0, 1 and 2 units added to the slots.
    fn check_drives(&self, model: &dyn Model, slots: &[(usize, f64)]) -> Result<bool, ParameterError> {
        let (dof, contacts) = (model.dof(), model.contacts());
        let mut drives = vec![0.0; model.drives()];
        model.drive(0.0, Side::After, &mut drives);
        let (one, unit) = WhiteNoise::unit_on(slots, &drives);
        let mut two = one.clone();
        slots.iter().for_each(|(slot, gain)| two[*slot] += gain * unit);
        let drives = [drives, one, two];
        let apart = |x: f64, y: f64, size: f64| (x - y).abs() > 1e-9 * size;
        let mut added: Vec<Vec<f64>> = Vec::new();
        for state in 0..4 {
            // The second state of each pair has the same coordinates and other velocities.
            let q: Vec<f64> = (0..dof).map(|i| weyl(state / 2, 2 * i) - 0.5).collect();
            let v: Vec<f64> = (0..dof).map(|i| weyl(state, 2 * i + 1) - 0.5).collect();
            let seen = drives.each_ref().map(|u| {
                let mut contact = vec![Contact::default(); contacts];
                model.contact(u, &q, &v, &mut contact);
                contact.iter().flat_map(|c| [c.deflection, c.lower, c.upper]).collect::<Vec<f64>>()
            });
            if let Some(i) = (0..3 * contacts).find(|&i| seen[0][i] != seen[1][i]) {
                let why = format!("it moves the edges or the deflection of contact {}", i / 3);
                return Err(ParameterError::NoWhiteNoise { slot: slots[0].0, why });
            }
            for piece in [Piece::Lower, Piece::Gap, Piece::Upper] {
                let pieces = vec![piece; contacts];
                let a = drives.each_ref().map(|u| {
                    let mut a = vec![0.0; dof];
                    accelerate(model, Some(&pieces), u, &q, &v, &mut a);
                    a
                });
                for i in 0..dof {
                    let size = a.iter().map(|a| a[i].abs()).fold(0.0, f64::max);
                    if size.is_finite() && apart(a[2][i] - a[1][i], a[1][i] - a[0][i], size) {
                        let why = format!("acceleration {i} is not affine in it");
                        return Err(ParameterError::NoWhiteNoise { slot: slots[0].0, why });
                    }
                }
                added.push((0..dof).map(|i| a[1][i] - a[0][i]).collect());
            }
        }
        // Rows 0, 1, 2 belong to the first state, 3, 4, 5 to the one with other velocities, and so on.
        let differs = |k: usize| {
            (0..dof).any(|i| {
                let [x, y] = [added[k][i], added[k + 3][i]];
                x.is_finite() && apart(x, y, x.abs().max(y.abs()))
            })
        };
        Ok([0, 1, 2, 6, 7, 8].into_iter().any(differs))
    }
}

/// A source of noise with its numbers for half a step.
#[derive(Clone, Debug)]
pub(super) enum Source {
    /// v ← e^{-c h/2} v + √(D (1 - e^{-c h})/(2 c)) Z
    Bath { coordinate: usize, decay: f64, spread: f64 },
    /// Gains times √(D h/2) for each slot, and whether the flow must follow the velocities.
    Drives { slots: Vec<(usize, f64)>, follows_velocity: bool },
}

impl Source {
    pub(super) fn new(noise: &WhiteNoise, h: f64, follows_velocity: bool) -> Self {
        match &noise.target {
            Target::Bath { coordinate, damping } => {
                let lost = -libm::expm1(-damping * h);
                let per_time = if *damping * h > 0.0 { lost / (2.0 * damping) } else { 0.5 * h };
                Source::Bath {
                    coordinate: *coordinate,
                    decay: libm::exp(-0.5 * damping * h),
                    spread: (noise.intensity * per_time).sqrt(),
                }
            }
            Target::Drives(slots) => {
                let spread = (0.5 * h * noise.intensity).sqrt();
                let slots = slots.iter().map(|(slot, gain)| (*slot, gain * spread)).collect();
                Source::Drives { slots, follows_velocity }
            }
        }
    }
}
