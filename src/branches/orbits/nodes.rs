//! Shifts of the nodes of an orbit along its period.

use crate::branches::curve::engine::CurvePoint;
use crate::branches::curve::equations::CurveError;
use crate::branches::orbits::orbit_curve::{OrbitCurve, Passage};
use crate::branches::orbits::orbit_method::OrbitMethod;
use nalgebra::DVector;

/// Distance of a node from an impact, in periods, below which the nodes are moved `[1]`.
const NEAR: f64 = 0.01;

/// Number of shifts that are compared.
const SHIFTS: usize = 64;

/// Distance on a circle of length 1.
fn apart(a: f64, b: f64) -> f64 {
    let d = (a - b).rem_euclid(1.0);
    d.min(1.0 - d)
}

/// The shift of nodes at `phases` that keeps them farthest from the instants `impacts`, all in periods; `None` if
/// no node is near an impact.
pub(crate) fn clear(phases: &[f64], impacts: &[f64]) -> Option<f64> {
    let least = |shift: f64| {
        let all = phases.iter().flat_map(|node| impacts.iter().map(move |at| apart(node + shift, *at)));
        all.fold(1.0, f64::min)
    };
    if least(0.0) >= NEAR {
        return None;
    }
    // A node moves within its own segment.
    let gaps = phases.windows(2).map(|two| two[1] - two[0]);
    let gap = gaps.chain([1.0 - phases[phases.len() - 1]]).fold(1.0, f64::min);
    let shifts = (1..SHIFTS).map(|k| gap * k as f64 / SHIFTS as f64);
    shifts.max_by(|a, b| least(*a).total_cmp(&least(*b))).filter(|shift| least(*shift) > NEAR)
}

impl OrbitCurve<'_> {
    /// The unknowns of the orbit of a point on nodes that lie later by `shift` periods.
    pub(crate) fn unknowns_later(
        &self,
        point: &CurvePoint<Passage>,
        shift: f64,
    ) -> Result<DVector<f64>, CurveError> {
        let (orbit, _) = self.orbit(point)?;
        let model = self.model(point.p)?;
        let mut later = orbit.clone();
        for state in &mut later.states {
            let at = orbit.at(&&*model, state.t + shift * orbit.period());
            *state = at.map_err(|error| CurveError::Flow { segment: 0, error })?;
        }
        later.end += shift * orbit.period();
        Ok(self.unknowns_of(&later))
    }
}

#[cfg(test)]
mod tests {
    use crate::branches::orbits::nodes::clear;

    #[test]
    fn nodes_move_to_the_middle_between_impacts() {
        assert_eq!(clear(&[0.0], &[0.3]), None);
        assert_eq!(clear(&[0.0], &[0.999]), Some(0.5));
        // Two segments and an impact at the second node: both nodes move by half a segment.
        assert_eq!(clear(&[0.0, 0.5], &[0.5]), Some(0.25));
    }
}
