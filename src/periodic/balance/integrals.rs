//! The ways to integrate the forces of a balance.

/// How the integrals of a balance are taken.
///
/// ```
/// use gear_dynamics::{Balance, Harmonics, NfgPair, NfgParams, periodic::Integrals, contact::Piece};
/// let pair = NfgPair::new(&NfgParams::table1())?;
/// let balance = Balance::new(Harmonics::up_to(70));
/// let start = balance.linearised(&pair, Piece::Lower)?;
/// assert_eq!(balance.equations(&pair, &start)?.integrals(), Integrals::Closed);
/// # Ok::<(), gear_dynamics::periodic::BalanceError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Integrals {
    /// Whichever of the exact ways suits the model: [`Closed`](Integrals::Closed) or [`Kinks`](Integrals::Kinks), panels where drives
    /// jump or pieces cannot be held. A model without contacts is sampled, six times the highest order and three times that of the drives. Drives of
    /// orders far above the kept ones are resolved by every exact way; a law of force that makes such orders itself is not, and
    /// [`BalanceNote::Coarse`](crate::periodic::BalanceNote::Coarse) says so.
    #[default]
    Exact,
    /// Sampled at M uniform instants, as Liu 2021 does: a dead zone then has a Jacobian that jumps, and folds that are not there.
    Sampled {
        /// M.
        samples: usize,
    },
    /// In closed form between switching angles: accelerations linear on their pieces, drives of few harmonics.
    Closed,
    /// Samples corrected around every kink: any smooth pieces.
    Kinks,
    /// Gauss panels between switches and jumps of the drives, as narrow as the kept orders and the drives ask for. A pulse between them that no
    /// edge announces is sought at 131 072 instants of a period, and gets panels of its own.
    Panels,
}
