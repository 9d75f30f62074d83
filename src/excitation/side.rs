//! Sides of an instant.

/// The side of an instant: before or after a jump. Drives jump at drive edges, for example at a new value of
/// a held process or at a step of the stiffness.
///
/// ```
/// use gear_dynamics::{excitation::{RectangularWave, Side}, Wave};
/// use std::f64::consts::FRAC_PI_2;
/// let wave = Wave::new(RectangularWave::new(1.0, 3.0, 0.5)?); // high within a quarter turn of φ = 0
/// assert_eq!(wave.value(FRAC_PI_2, Side::Before), 3.0);
/// assert_eq!(wave.value(FRAC_PI_2, Side::After), 1.0);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The limit from earlier times, as at the end of a step.
    Before,
    /// The limit from later times, as at the start of a step.
    After,
}
