//! The values of the contact laws apart from the accelerations.

use crate::contact::Piece;
use crate::dual::Dual;

/// A model whose accelerations can be computed with given values in place of those of its contact laws. A
/// [`Machine`](crate::Machine) is one.
///
/// The value of a law is its force per unit stiffness. Laws are evaluated by deflection if `pieces` is
/// `None`, or with every contact on a given piece. `laws` and `given` have one entry for each contact; those
/// of inner kinks are neither written nor read.
///
/// ```
/// use gear_dynamics::{Model, excitation::Side, trains::SpurPair};
/// let pair = SpurPair::of_numbers(0.05, 0.1, &[-0.2], &[])?.parts()?.build("driver", 0.6)?;
/// let (mut u, mut a, mut laws) = (vec![0.0; pair.drives()], [0.0], [0.0]);
/// pair.drive(0.0, Side::After, &mut u);
/// let model = pair.offers().laws.ok_or("laws")?;
/// model.accel_by_laws(None, None, &u, &[1.5], &[0.0], &mut a, &mut laws);
/// assert_eq!(laws, [0.5]); // q - 1
/// model.accel_by_laws(Some(&[0.25]), None, &u, &[1.5], &[0.0], &mut a, &mut laws);
/// assert!((a[0] + 0.1).abs() < 1e-12); // 0.1 - 0.8 f with f = 0.25
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Laws {
    /// Writes the accelerations with the values `given`, or with those of the laws if `given` is `None`. The
    /// values of the laws are written to `laws`.
    #[allow(
        clippy::too_many_arguments,
        reason = "the arguments of an acceleration and the values of the laws"
    )]
    fn accel_by_laws(
        &self,
        given: Option<&[f64]>,
        pieces: Option<&[Piece]>,
        u: &[f64],
        q: &[f64],
        v: &[f64],
        a: &mut [f64],
        laws: &mut [f64],
    );
    /// The same in dual numbers with four directions: accelerations with the values `given`, and the laws.
    #[allow(
        clippy::too_many_arguments,
        reason = "the arguments of an acceleration and the values of the laws"
    )]
    fn slopes_by_laws(
        &self,
        given: &[Dual<4>],
        pieces: Option<&[Piece]>,
        u: &[Dual<4>],
        q: &[Dual<4>],
        v: &[Dual<4>],
        a: &mut [Dual<4>],
        laws: &mut [Dual<4>],
    );
}
