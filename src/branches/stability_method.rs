//! How the stability of the points of a branch is computed.

/// How the stability of the points of a branch is computed.
///
/// ```
/// use gear_dynamics::branches::{Continuation, Family, PointKind, StabilityMethod};
/// use gear_dynamics::{Balance, Harmonics, contact::Piece, periodic::Stability, trains::SpurPair};
/// let pair = SpurPair::of_numbers(0.05, 0.1, &[-0.2], &[])?.parts()?.build("driver", 0.6)?;
/// let family = Family::over(&pair, ["speed"])?;
/// let balance = Balance::new(Harmonics::up_to(12));
/// let guess = balance.linearised(&pair, Piece::Upper)?;
/// let range = Continuation::new(0.6, 1.0).stability(StabilityMethod::Skipped);
/// let branch = range.balance(balance).run(&family, &guess)?;
/// assert_eq!(branch.of_kind(PointKind::Fold).len(), 2);
/// assert_eq!(branch.points()[0].stability(), Stability::Undecided);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum StabilityMethod {
    /// Floquet multipliers of every point: by shooting those of the monodromy matrix, with their error from a
    /// second run; by balance those of the equation along the series.
    #[default]
    Multipliers,
    /// None. Folds, branch points and grazings are located, period doublings and Neimark-Sacker points are
    /// not. A branch by balance takes about half the time. Points have no multipliers by balance, and
    /// multipliers of unknown error by shooting: their stability is undecided.
    Skipped,
}
