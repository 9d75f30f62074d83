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

/// How often the interval in which a mode stops to oscillate is halved.
const HALVINGS: usize = 20;

/// Adds the resonances between two speeds with their frequencies. Modes are matched by rank. This fails where
/// one of them stops to oscillate: the interval is halved, so that little of it is left out.
fn between(
    at: &dyn Fn(f64) -> Result<Vec<f64>, LinearError>,
    first: (f64, Vec<f64>),
    last: (f64, Vec<f64>),
    orders: &[f64],
    halvings: usize,
    out: &mut Vec<Resonance>,
) -> Result<(), LinearError> {
    if first.1.len() != last.1.len() {
        if halvings == 0 {
            return Ok(());
        }
        let speed = 0.5 * (first.0 + last.0);
        let middle = (speed, at(speed)?);
        between(at, first, middle.clone(), orders, halvings - 1, out)?;
        return between(at, middle, last, orders, halvings - 1, out);
    }
    for (mode, (from, to)) in first.1.iter().zip(&last.1).enumerate() {
        for &order in orders {
            let [a, b] = [from - order * first.0, to - order * last.0];
            if a >= 0.0 && b < 0.0 || a <= 0.0 && b > 0.0 {
                // The frequency is linear between two speeds.
                let share = a / (a - b);
                let speed = first.0 + share * (last.0 - first.0);
                out.push(Resonance { speed, frequency: from + share * (to - from), order, mode });
            }
        }
    }
    Ok(())
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
        let at = |speed: f64| -> Result<Vec<f64>, LinearError> {
            let modes = Modes::mean_in_contact(&*constants.with_values(&[(0, speed)])?)?;
            Ok(modes.eigenvalues().iter().map(|value| value.norm()).collect())
        };
        let mut frequencies: Vec<Vec<f64>> = Vec::new();
        for (i, &speed) in speeds.iter().enumerate() {
            if i > 0 && speed <= speeds[i - 1] {
                let must = format!("be above {:?}, the speed before it", speeds[i - 1]);
                return Err(ParameterError::Wrong { name: format!("speeds[{i}]"), value: speed, must }.into());
            }
            frequencies.push(at(speed)?);
        }
        let mut resonances = Vec::new();
        for (speed, found) in speeds.windows(2).zip(frequencies.windows(2)) {
            let [first, last] = [0, 1].map(|end| (speed[end], found[end].clone()));
            between(&at, first, last, orders, HALVINGS, &mut resonances)?;
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
