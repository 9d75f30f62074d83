//! One oscillator with constants for every term of the classics.

use gear_dynamics::models::Oscillator;

/// The oscillator with these constants; speed 1 and half backlash 1 unless given. It always has its contact.
pub fn oscillator(given: &[(&str, f64)]) -> Oscillator {
    let rest = [("speed", 1.0), ("half backlash", 1.0), ("mesh stiffness", 0.0)];
    let rest = rest.into_iter().filter(|(name, _)| given.iter().all(|(other, _)| other != name));
    Oscillator::new(&given.iter().copied().chain(rest).collect::<Vec<_>>()).unwrap()
}
