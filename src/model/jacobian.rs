//! The derivatives of the accelerations.

use nalgebra::DMatrix;

/// The Jacobian of the accelerations: ∂a/∂q and ∂a/∂v, each `dof` x `dof`. Each row belongs to an
/// acceleration.
///
/// ```
/// use gear_dynamics::{contact::Piece, model::{Jacobian, Offers}, Model};
/// struct Oscillator; // q'' = -4 q - 0.5 q'
/// impl Model for Oscillator {
///     fn dof(&self) -> usize { 1 }
///     fn accel(&self, _: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) { a[0] = -4.0 * q[0] - 0.5 * v[0]; }
///     fn offers(&self) -> Offers<'_> { Offers { jacobian: true, ..Offers::default() } }
///     fn jacobian(&self, _: Option<&[Piece]>, _: &[f64], _: &[f64], _: &[f64], out: &mut Jacobian) {
///         out.q[(0, 0)] = -4.0;
///         out.v[(0, 0)] = -0.5;
///     }
/// }
/// let mut jacobian = Jacobian::new(1);
/// Oscillator.jacobian(None, &[0.0], &[1.0], &[0.0], &mut jacobian);
/// assert_eq!((-jacobian.q[(0, 0)]).sqrt(), 2.0); // undamped natural frequency
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Jacobian {
    /// ∂a_i/∂q_j.
    pub q: DMatrix<f64>,
    /// ∂a_i/∂v_j.
    pub v: DMatrix<f64>,
}

impl Jacobian {
    /// A Jacobian of zeros for `dof` degrees of freedom.
    pub fn new(dof: usize) -> Self {
        Jacobian { q: DMatrix::zeros(dof, dof), v: DMatrix::zeros(dof, dof) }
    }

    /// The first entry that is not finite: the index of the acceleration, the index of the coordinate, and
    /// `true` for an entry of ∂a/∂v.
    pub(crate) fn not_finite(&self) -> Option<(usize, usize, bool)> {
        let first = |half: &DMatrix<f64>| {
            half.iter().position(|x| !x.is_finite()).map(|k| (k % half.nrows(), k / half.nrows()))
        };
        let of_q = first(&self.q).map(|(i, j)| (i, j, false));
        of_q.or_else(|| first(&self.v).map(|(i, j)| (i, j, true)))
    }
}
