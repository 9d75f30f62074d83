//! Jumps of a function.

/// Number of halvings: as many as a difference of two states has digits.
const HALVINGS: usize = 60;

/// Share of a change that remains at a jump `[1]`. A sign has a third value, at 0, and keeps half of its
/// change.
const KEPT: f64 = 0.25;

/// The place past a jump between 0 and 1, and the values on both sides of it. The stretch is halved towards
/// the larger part of the change. `None` if the change falls with the length: the function is continuous.
/// `ends`: the values at 0 and at 1.
pub(crate) fn jump(
    [mut before, mut after]: [f64; 2],
    mut at: impl FnMut(f64) -> f64,
) -> Option<(f64, [f64; 2])> {
    let (mut low, mut high, change) = (0.0, 1.0, (after - before).abs());
    for _ in 0..HALVINGS {
        if (after - before).abs() <= KEPT * change {
            return None;
        }
        let middle = 0.5 * (low + high);
        let value = at(middle);
        if (value - before).abs() > (after - value).abs() {
            (high, after) = (middle, value);
        } else {
            (low, before) = (middle, value);
        }
    }
    Some((high, [before, after]))
}

#[cfg(test)]
mod tests {
    use super::jump;

    #[test]
    fn jumps_are_found_and_slopes_are_none() {
        let sign = |x: f64| if x < 0.3 { x } else { 2.0 + x };
        let (place, [before, after]) = jump([0.0, 3.0], sign).unwrap_or_default();
        assert!((place - 0.3).abs() < 1e-15 && (before - 0.3).abs() < 1e-15 && (after - 2.3).abs() < 1e-15);
        let steep = |x: f64| ((x - 0.3) / 1e-6).tanh();
        assert_eq!(jump([steep(0.0), steep(1.0)], steep), None);
        assert_eq!(jump([1.0; 2], |_| 1.0), None);
    }
}
