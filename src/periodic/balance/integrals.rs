//! The ways of integration of a balance.

/// Way of integration for the Fourier coefficients of the accelerations in a balance.
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
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Integrals {
    /// Default: chooses an exact way for the model.
    ///
    /// This is [`Closed`](Integrals::Closed) where it is available, otherwise [`Kinks`](Integrals::Kinks).
    /// With drive edges, or contacts that cannot be evaluated on fixed pieces, it is
    /// [`Panels`](Integrals::Panels) without the search for pulses. A model without contacts is sampled; the
    /// number of samples is at least 6 times the highest kept order and 3 times the highest order of the
    /// drives.
    ///
    /// Drives with orders far above the kept ones are resolved. Contact laws that produce such orders are
    /// not; [`BalanceNote::Coarse`](crate::periodic::BalanceNote::Coarse) then warns.
    #[default]
    Exact,
    /// Alternating frequency-time scheme: samples at M uniform instants, as in Liu 2021. The Jacobian of a
    /// dead zone jumps whenever a sample passes an edge, which produces spurious folds.
    Sampled {
        /// Number M of samples in one period of the orbit.
        samples: usize,
    },
    /// Exact formulas for the integrals from crossing to crossing. Requires no drive edges, and accelerations
    /// on fixed pieces that are linear in coordinates and velocities, with contributions of the contacts that
    /// add up. The constant terms and slopes must be Fourier series of at most about 6000 orders per period
    /// of the drives. A model without an exact Jacobian may fail this by the noise of its differences.
    Closed,
    /// Uniform samples, corrected around every crossing, where the accelerations have a kink. Requires smooth
    /// fixed pieces and no drive edges.
    Kinks,
    /// Panels of Gauss quadrature between crossings and drive edges. Their width follows from the kept orders
    /// and the orders of the drives.
    ///
    /// The drives are also searched, at 131 072 instants of a period, for pulses between the nodes that are
    /// not drive edges of the model. Such a pulse gets panels of its own.
    Panels,
}
