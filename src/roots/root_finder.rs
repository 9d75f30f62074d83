//! Methods that find roots.

use crate::error::check;
use crate::numeric::norms::largest;
use crate::roots::residual::Residual;
use crate::roots::root::{Root, RootError};
use std::fmt::Debug;
use std::sync::Arc;

/// A method that finds a root of equations: [`Newton`](crate::roots::Newton),
/// [`Broyden`](crate::roots::Broyden), or one of one's own.
/// [`Balance::root_finder`](crate::Balance::root_finder) takes any.
///
/// ```
/// use gear_dynamics::roots::{Equations, Residual, Root, RootError, RootFinder};
/// // x ← x - r/2
/// #[derive(Debug)]
/// struct Halves;
/// impl RootFinder for Halves {
///     fn solve(&self, equations: &mut dyn Residual, guess: &[f64]) -> Result<Root, RootError> {
///         let mut r = vec![0.0; equations.size()];
///         let mut root = Root::start(equations, guess, &mut r)?;
///         while root.residual > 1e-12 {
///             if root.iterations == 100 || root.residual.is_nan() {
///                 return Err(RootError::NotConverged { last: Box::new(root) });
///             }
///             let x: Vec<f64> = root.x.iter().zip(&r).map(|(x, r)| x - 0.5 * r).collect();
///             root.step_to(equations, &x, &mut r);
///         }
///         Ok(root)
///     }
/// }
/// let root = Halves.solve(&mut Equations::new(1, |x, r| r[0] = x[0] - x[0].cos()), &[0.5])?;
/// assert!((root.x[0] - 0.739_085_133_215).abs() < 1e-10);
/// # Ok::<(), RootError>(())
/// ```
pub trait RootFinder: Debug + Send + Sync {
    /// Solves r(x) = 0 from a guess.
    ///
    /// A residual that is NaN must end the search: the equations of a balance return NaN once its
    /// [`Budget`](crate::Budget) is spent.
    ///
    /// The result of a method of one's own is checked: a balance refuses a root with another number of
    /// unknowns, with a residual that is not finite, and one that a Newton correction moves by more than 1e-6
    /// of the peak-to-peak value.
    ///
    /// # Errors
    /// [`RootError`]; [`RootError::last`] returns the last iterate.
    fn solve(&self, equations: &mut dyn Residual, guess: &[f64]) -> Result<Root, RootError>;

    #[doc(hidden)]
    /// Whether the method belongs to this crate. The roots of other methods are checked.
    fn is_of_crate(&self) -> bool {
        false
    }

    /// Returns the same method for another number of equations, or `None` if this one fits any number.
    /// Default: `None`.
    fn resized(&self) -> Option<Arc<dyn RootFinder>> {
        None
    }
}

/// Checks what the root finder of a user returns, and computes the residual of its root.
///
/// # Errors
/// The errors of the root finder. A root with another number of unknowns, or with a residual that is not
/// finite, is an error, too.
pub(crate) fn confirmed(
    equations: &mut dyn Residual,
    found: Result<Root, RootError>,
) -> Result<Root, RootError> {
    let fits = |root: &Root| check::length("unknowns of the root finder", root.x.len(), equations.size());
    let mut root = match found {
        Ok(root) => root,
        Err(error) => {
            error.last().map_or(Ok(()), fits)?;
            return Err(error);
        }
    };
    fits(&root)?;
    let mut r = vec![0.0; equations.size()];
    equations.residual(&root.x, &mut r);
    root.residual = largest(&r);
    match r.iter().position(|r| !r.is_finite()) {
        Some(equation) => Err(RootError::NotFinite { equation, last: Box::new(root) }),
        None => Ok(root),
    }
}
