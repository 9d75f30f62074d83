//! Directions along which a periodic motion may drift.

use crate::model::Model;
use crate::model::structure::rigid::{Rigid, rigid_modes, unresisted};
use crate::numeric::norms::{dot, remove};
use nalgebra::{DMatrix, DVector};

/// Directions along which a periodic motion may drift: orthonormal directions of the coordinates.
///
/// No force depends on the place along a direction of `places`: ∂a/∂q r = 0 at all times, in all states and
/// on both flanks, and no rigid stop feels it. Along a direction of `speeds` no force depends on the velocity
/// either: it is a rigid motion. A rotor that only a drag holds, and a state of first order that is the
/// velocity of a coordinate, have places and no speeds.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Drifts {
    pub(crate) places: Vec<Vec<f64>>,
    pub(crate) speeds: Vec<Vec<f64>>,
    /// A resistance to a place that differences cannot distinguish from zero, relative to those of the
    /// coordinates.
    pub(crate) doubtful: Option<f64>,
}

impl Drifts {
    /// The directions of a model that repeats after `span`.
    pub(crate) fn of(model: &dyn Model, span: f64) -> Self {
        let Rigid { modes: mut places, doubtful } = unresisted(model, span, &[false]);
        let speeds = if places.is_empty() { Vec::new() } else { rigid_modes(model, span) };
        if places.len() == speeds.len() {
            places.clone_from(&speeds);
        }
        Drifts { places, speeds, doubtful }
    }
    /// The directions of places that are orthogonal to the speeds, orthonormal: those with a mean speed of
    /// their own.
    pub(crate) fn held(&self) -> Vec<Vec<f64>> {
        let mut basis = self.speeds.clone();
        if self.has_own_speeds() {
            for place in &self.places {
                let mut r = place.clone();
                basis.iter().for_each(|other| remove(other, &mut r));
                let length = dot(&r, &r).sqrt();
                if length > OWN {
                    r.iter_mut().for_each(|r| *r /= length);
                    basis.push(r);
                }
            }
        }
        basis.split_off(self.speeds.len())
    }
    /// The directions of coordinates, then of velocities.
    pub(crate) fn halves(&self) -> [&[Vec<f64>]; 2] {
        [&self.places, &self.speeds]
    }
    /// Whether a mean speed belongs to the orbit: there is a direction of places that is not one of speeds.
    pub(crate) fn has_own_speeds(&self) -> bool {
        self.places.len() > self.speeds.len()
    }
    /// The ranges of coordinates and velocities on an orbit. If a mean speed belongs to it, they are raised
    /// to its drift Δq in a period and to Δq/T.
    pub(crate) fn widened(&self, ranges: &[f64], drift: &[f64], period: f64) -> Vec<f64> {
        let (mut widths, n) = (ranges.to_vec(), drift.len());
        if self.has_own_speeds() {
            for (i, drift) in drift.iter().enumerate() {
                widths[i] = widths[i].max(drift.abs());
                widths[n + i] = widths[n + i].max(drift.abs() / period);
            }
        }
        widths
    }
    /// Orthonormal drifts along the coordinates, then along the velocities, with each component in its unit.
    pub(crate) fn basis(&self, unit: &[f64]) -> DMatrix<f64> {
        let (m, n) = (unit.len(), unit.len() / 2);
        let mut basis: Vec<DVector<f64>> = Vec::new();
        for (half, directions) in self.halves().into_iter().enumerate() {
            for direction in directions {
                let part = |i: usize| if i / n == half { direction[i % n] / unit[i] } else { 0.0 };
                let mut r = DVector::from_fn(m, |i, _| part(i));
                basis.iter().for_each(|other| remove(other.as_slice(), r.as_mut_slice()));
                basis.push(r.normalize());
            }
        }
        if basis.is_empty() { DMatrix::zeros(m, 0) } else { DMatrix::from_columns(&basis) }
    }
    /// Number of directions of places and of speeds.
    pub(crate) fn count(&self) -> usize {
        self.places.len() + self.speeds.len()
    }
}

/// A square of a component of an orthonormal motion that is rounding.
const ROUNDING: f64 = 1e-16;

/// Least length of a direction that is not one of others `[1]`.
const OWN: f64 = 1e-6;

/// Largest cosine between the shares of two coordinates that do not belong together.
const APART: f64 = 1e-6;

/// The coordinates i that nothing connects: a change of q_i alone is a rigid motion. `modes`: orthonormal
/// rigid motions r.
///
/// The sum P of r rᵀ projects onto all rigid motions. The coordinate is one of them if P_ii = 1 and all other
/// P_ij = 0. P_ij is compared with √(P_ii P_jj), since coordinates may be angles and lengths.
pub(crate) fn unconnected(modes: &[Vec<f64>]) -> Vec<usize> {
    let n = modes.first().map_or(0, Vec::len);
    let shared = |i: usize, j: usize| modes.iter().map(|r| r[i] * r[j]).sum::<f64>();
    let own: Vec<f64> = (0..n).map(|i| shared(i, i)).collect();
    let apart =
        |i: usize, j: usize| own[j] < ROUNDING || shared(i, j).abs() <= APART * (own[i] * own[j]).sqrt();
    let alone = |i: &usize| own[*i] > 0.5 && (0..n).all(|j| j == *i || apart(*i, j));
    (0..n).filter(alone).collect()
}

/// The text of the errors of an unconnected coordinate that accelerates.
pub(crate) fn accelerates(coordinate: &usize, gain: &f64) -> String {
    format!(
        "nothing connects coordinate {coordinate}, which gains the velocity {gain:?} in every period of the orbit: \
         there is no periodic orbit; balance the forces on it, or leave it out"
    )
}

#[cfg(test)]
mod tests {
    use super::unconnected;

    /// A body alone beside a pair that turns together, also when their motions are mixed, and in other units.
    #[test]
    fn a_pair_is_connected_and_a_single_body_is_not() {
        let half = 0.5f64.sqrt();
        assert_eq!(unconnected(&[vec![1.0, 0.0, 0.0], vec![0.0, half, half]]), [0]);
        assert_eq!(unconnected(&[vec![half, 0.5, 0.5], vec![half, -0.5, -0.5]]), [0]);
        assert_eq!(unconnected(&[vec![1.0, 1e-6]]), [0usize; 0]);
        assert_eq!(unconnected(&[vec![1.0, 0.0], vec![0.0, 1.0]]), [0, 1]);
        assert_eq!(unconnected(&[]), [0usize; 0]);
    }
}
