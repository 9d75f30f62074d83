//! Methods that find roots.

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
    /// # Errors
    /// [`RootError`]; [`RootError::last`] returns the last iterate.
    fn solve(&self, equations: &mut dyn Residual, guess: &[f64]) -> Result<Root, RootError>;

    /// Returns the same method for another number of equations, or `None` if this one fits any number.
    /// Default: `None`.
    fn resized(&self) -> Option<Arc<dyn RootFinder>> {
        None
    }
}
