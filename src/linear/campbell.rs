//! Campbell diagrams.

use crate::error::ParameterError;
use crate::linear::modes::{LinearError, Modes};
use crate::model::Model;

/// A speed at which a harmonic of an order meets a natural frequency.
///
/// ```
/// # use gear_dynamics::linear::Campbell;
/// # use gear_dynamics::trains::{MeshPart, idler};
/// # use gear_dynamics::Wave;
/// let mesh = |teeth, radii| Ok::<_, gear_dynamics::ParameterError>(MeshPart::external(teeth, radii, Wave::constant(2e8)?));
/// let meshes = [mesh([20, 30], [0.02, 0.03])?, mesh([30, 40], [0.03, 0.04])?];
/// let train = idler([1e-3, 3e-3, 8e-3], meshes).build("driver", 100.0)?;
/// let diagram = Campbell::of(&train, &[100.0, 1000.0], &[20.0])?; // the mesh frequency
/// let meeting = diagram.resonances()[0];
/// assert!((20.0 * meeting.speed - meeting.frequency).abs() < 1e-9 * meeting.frequency);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Resonance {
    /// Value of the constant `speed`.
    pub speed: f64,
    /// Natural frequency [rad per time unit].
    pub frequency: f64,
    /// Order of the excitation over the constant `speed`.
    pub order: f64,
    /// Index of the natural frequency among those of its speed.
    pub mode: usize,
}

/// Natural frequencies over the speed, with the lines of excitation orders.
///
/// The frequencies are |λ| of the damped, gyroscopic model with all teeth in contact
/// ([`Modes::eigenvalues`]) and the mean stiffness ([`Modes::mean_in_contact`]), matched from speed to
/// speed by their rank. A resonance on the last speed is not listed.
///
/// ```
/// use gear_dynamics::linear::Campbell;
/// use gear_dynamics::{NfgPair, NfgParams};
/// let pair = NfgPair::new(&NfgParams::table1())?;
/// let diagram = Campbell::of(&pair, &[100.0, 200.0, 300.0], &[18.0])?;
/// assert_eq!(diagram.frequencies().len(), 3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Campbell {
    speeds: Vec<f64>,
    frequencies: Vec<Vec<f64>>,
    resonances: Vec<Resonance>,
}

impl Campbell {
    /// The diagram of a model whose first [constant](crate::model::Offers::constants) is its speed, for
    /// increasing speeds, and excitation orders as multiples of that speed.
    ///
    /// # Errors
    /// A model without constants; speeds out of range or not increasing; errors of
    /// [`Modes::mean_in_contact`].
    pub fn of(model: &dyn Model, speeds: &[f64], orders: &[f64]) -> Result<Self, LinearError> {
        let constants = model.offers().named()?;
        crate::error::check::quantities("orders", orders)?;
        let mut frequencies: Vec<Vec<f64>> = Vec::new();
        for (i, &speed) in speeds.iter().enumerate() {
            if i > 0 && speed <= speeds[i - 1] {
                let must = format!("be above {:?}, the speed before it", speeds[i - 1]);
                return Err(ParameterError::Wrong { name: format!("speeds[{i}]"), value: speed, must }.into());
            }
            let modes = Modes::mean_in_contact(&*constants.with_values(&[(0, speed)])?)?;
            frequencies.push(modes.eigenvalues().iter().map(|value| value.norm()).collect());
        }
        let mut resonances = Vec::new();
        for (speed, found) in speeds.windows(2).zip(frequencies.windows(2)) {
            // Modes are matched by rank, which fails if one of them stops to oscillate.
            if found[0].len() != found[1].len() {
                continue;
            }
            for (mode, (first, last)) in found[0].iter().zip(&found[1]).enumerate() {
                for &order in orders {
                    let [a, b] = [first - order * speed[0], last - order * speed[1]];
                    if a >= 0.0 && b < 0.0 || a <= 0.0 && b > 0.0 {
                        // The frequency is linear between two speeds.
                        let share = a / (a - b);
                        let at = speed[0] + share * (speed[1] - speed[0]);
                        let frequency = first + share * (last - first);
                        resonances.push(Resonance { speed: at, frequency, order, mode });
                    }
                }
            }
        }
        Ok(Campbell { speeds: speeds.to_vec(), frequencies, resonances })
    }
    /// The speeds.
    pub fn speeds(&self) -> &[f64] {
        &self.speeds
    }
    /// Natural frequencies [rad per time unit] at each speed, increasing.
    pub fn frequencies(&self) -> &[Vec<f64>] {
        &self.frequencies
    }
    /// Speeds at which an order meets a natural frequency, by linear interpolation between the given speeds.
    pub fn resonances(&self) -> &[Resonance] {
        &self.resonances
    }
}
