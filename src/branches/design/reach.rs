//! Orbits of a model whose constants have moved far.

use crate::model::equations::Constants;
use crate::periodic::{Shooting, ShootingError, ShootingOrbit};

/// Shortest part of the way between two models that is tried `[1]`.
const SHORTEST_PART: f64 = 1.0 / 256.0;

/// The orbit of the model with the constants `to`, followed from the orbit of the model with the constants
/// `from` along the straight line between them. Parts of the line are halved where an orbit is not found.
pub(crate) fn reach(
    constants: &dyn Constants,
    shooting: &Shooting,
    orbit: &ShootingOrbit,
    from: &[(usize, f64)],
    to: &[(usize, f64)],
) -> Result<ShootingOrbit, ShootingError> {
    let (mut at, mut part, mut orbit) = (0.0, 1.0f64, orbit.clone());
    while at < 1.0 {
        let next = (at + part).min(1.0);
        let blend = |(a, b): (&(usize, f64), &(usize, f64))| (a.0, a.1 + next * (b.1 - a.1));
        let values: Vec<(usize, f64)> = from.iter().zip(to).map(blend).collect();
        let model = constants.with_values(&values)?;
        match shooting.solve_from(&*model, &orbit) {
            Ok(found) => {
                (at, orbit) = (next, found);
                part = (2.0 * part).min(1.0);
            }
            Err(error) => {
                part *= 0.5;
                if part < SHORTEST_PART {
                    return Err(error);
                }
            }
        }
    }
    Ok(orbit)
}
