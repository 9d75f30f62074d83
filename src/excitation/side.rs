//! The side from which an instant is seen.

/// The side from which an instant is seen. Drives may jump at an edge (a hold of a random process, a step of the stiffness).
///
/// ```
/// use gear_dynamics::{excitation::{RectangularWave, Side}, Wave};
/// use std::f64::consts::FRAC_PI_2;
/// let wave = Wave::new(RectangularWave::new(1.0, 3.0, 0.5)?); // high for the quarter turn on either side of φ = 0
/// assert_eq!(wave.value(FRAC_PI_2, Side::Before), 3.0);
/// assert_eq!(wave.value(FRAC_PI_2, Side::After), 1.0);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The limit from earlier times: the end of a step.
    Before,
    /// The limit from later times: the start of a step.
    After,
}
