//! Shifts of the nodes of an orbit along its period.

/// Distance of a node from an impact, in periods, below which the nodes are moved `[1]`.
const NEAR_IMPACT: f64 = 0.01;

/// The same as a share of a segment.
const NEAR_IN_SEGMENT: f64 = 0.2;

/// Factor by which a shift must increase the distance.
const WORTH: f64 = 2.0;

/// Number of shifts that are compared.
const SHIFTS: usize = 64;

/// Distance on a circle of length 1.
fn apart(a: f64, b: f64) -> f64 {
    let d = (a - b).rem_euclid(1.0);
    d.min(1.0 - d)
}

/// The shift of nodes at `phases` that keeps them farthest from the instants `impacts`, all in periods;
/// `None` if no node is near an impact.
pub(crate) fn clear(phases: &[f64], impacts: &[f64]) -> Option<f64> {
    let least = |shift: f64| {
        let all = phases.iter().flat_map(|node| impacts.iter().map(move |at| apart(node + shift, *at)));
        all.fold(1.0, f64::min)
    };
    // A node moves within its own segment.
    let gaps = phases.windows(2).map(|two| two[1] - two[0]);
    let gap = gaps.chain([1.0 - phases[phases.len() - 1]]).fold(1.0, f64::min);
    let nearest = least(0.0);
    if nearest >= NEAR_IMPACT.min(NEAR_IN_SEGMENT * gap) {
        return None;
    }
    let shifts = (1..SHIFTS).map(|k| gap * k as f64 / SHIFTS as f64);
    shifts.max_by(|a, b| least(*a).total_cmp(&least(*b))).filter(|shift| least(*shift) > WORTH * nearest)
}

#[cfg(test)]
mod tests {
    use crate::branches::orbits::by_shooting::nodes::clear;

    #[test]
    fn nodes_move_to_the_middle_between_impacts() {
        assert_eq!(clear(&[0.0], &[0.3]), None);
        assert_eq!(clear(&[0.0], &[0.999]), Some(0.5));
        // Two segments and an impact at the second node: both nodes move by half a segment.
        assert_eq!(clear(&[0.0, 0.5], &[0.5]), Some(0.25));
        let many: Vec<f64> = (0..64).map(|i| f64::from(i) / 64.0).collect();
        assert_eq!(clear(&many, &[0.25]), Some(0.5 / 64.0));
    }
}
