//! The sums of terms in the equations of a model: the measure of its rounding errors.

use crate::contact::Piece;
use crate::rounded::Rounded;

/// A model that knows the terms of its accelerations. A [`Machine`](crate::Machine) does.
///
/// ```
/// use gear_dynamics::{Model, State, trains::SpurPair};
/// let pair = SpurPair::of_numbers(0.05, 0.1, &[-0.2], &[])?.parts()?.build("driver", 0.6)?;
/// let (mut u, mut terms) = (vec![0.0; pair.drives()], [0.0]);
/// pair.drive(0.0, gear_dynamics::excitation::Side::After, &mut u);
/// // q'' = 0.1 - 0.1 q' - 0.8 (q - 1) at q = 1.5 and q' = 0: terms 0.1, 0.8 * 1.5 and 0.8.
/// let model: &dyn Model = &pair;
/// let mut scratch = gear_dynamics::model::recording::TermsScratch::default();
/// model.offers().terms.ok_or("terms")?.terms(None, &u, &[1.5], &[0.0], &[1.5, 0.0], &mut scratch, &mut terms);
/// assert!((terms[0] - 2.1).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Terms {
    /// Writes for each acceleration the sum of the absolute values of its terms, in the unit of the
    /// acceleration: its rounding error over ε = 2.2e-16, before anything cancels. By deflection for `None`,
    /// or with every contact on a given piece.
    ///
    /// `sizes`: for each coordinate, then for each velocity, the sum of the terms that it is made of, at
    /// least its absolute value. `scratch`: memory that is kept from call to call.
    #[allow(clippy::too_many_arguments, reason = "a state, its sizes and memory for the result")]
    fn terms(
        &self,
        pieces: Option<&[Piece]>,
        u: &[f64],
        q: &[f64],
        v: &[f64],
        sizes: &[f64],
        scratch: &mut TermsScratch,
        out: &mut [f64],
    );
}

/// Memory of [`Terms`], kept from call to call: a call with used scratch does not allocate.
///
/// ```
/// use gear_dynamics::{Model, model::recording::TermsScratch, trains::SpurPair};
/// let pair = SpurPair::of_numbers(0.05, 0.1, &[], &[])?.parts()?.build("driver", 0.6)?;
/// let (mut u, mut scratch, mut terms) = (vec![0.0; pair.drives()], TermsScratch::default(), [0.0]);
/// pair.drive(0.0, gear_dynamics::excitation::Side::After, &mut u);
/// let model: &dyn Model = &pair;
/// for (q, expected) in [(1.5, 2.6), (2.0, 3.1)] {
///     let known = model.offers().terms.ok_or("terms")?;
///     known.terms(None, &u, &[q], &[0.0], &[q, 0.0], &mut scratch, &mut terms);
///     assert!((terms[0] - expected).abs() < 1e-12); // 0.1 + q + 1 of q'' = 0.1 - (q - 1)
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Default)]
pub struct TermsScratch {
    pub(super) u: Vec<Rounded>,
    pub(super) y: Vec<Rounded>,
    pub(super) a: Vec<Rounded>,
}

impl std::fmt::Debug for TermsScratch {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("TermsScratch").finish_non_exhaustive()
    }
}
