//! The derivatives of the accelerations.

use nalgebra::DMatrix;

/// The Jacobian of the accelerations: ∂a/∂q and ∂a/∂v, each `dof` x `dof`. Each row belongs to an
/// acceleration.
///
/// ```
/// use gear_dynamics::{Model, excitation::Side, model::Jacobian, trains::SpurPair};
/// let pair = SpurPair::of_numbers(0.05, 0.1, &[], &[])?.parts()?.build("driver", 0.6)?;
/// let (mut u, mut jacobian) = (vec![0.0; pair.drives()], Jacobian::new(1));
/// pair.drive(0.0, Side::After, &mut u);
/// pair.jacobian(None, &u, &[1.5], &[0.0], &mut jacobian); // q'' = 0.1 - 0.1 q' - (q - 1) for q > 1
/// assert!((jacobian.q[(0, 0)] + 1.0).abs() < 1e-12 && (jacobian.v[(0, 0)] + 0.1).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
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
