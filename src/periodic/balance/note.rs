//! Notes on the reliability of an orbit.

use crate::periodic::balance::integrals::Integrals;

/// Note on the reliability of an orbit of a [`Balance`](crate::Balance).
///
/// ```
/// use gear_dynamics::periodic::BalanceNote;
/// let note = BalanceNote::Unresolved { highest: 65, needed: 656.0 };
/// assert!(note.is_warning());
/// assert!(note.to_string().contains("656"));
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum BalanceNote {
    /// Warning: the kept orders do not resolve the fastest local natural frequency. Such orbits are
    /// inaccurate, and their branches have spurious folds.
    Unresolved {
        /// Highest kept order.
        highest: usize,
        /// Required order, 1.2 √(largest local stiffness)/ω `[1]`.
        #[cfg_attr(feature = "serde", serde(with = "crate::numeric::not_finite::number"))]
        needed: f64,
    },
    /// Warning: sampling changes the orbit by more than 1e-3 of its peak-to-peak value.
    Aliased {
        /// Number M of samples.
        samples: usize,
        /// Correction of the orbit by exact integrals, as a share of the peak-to-peak value `[1]`.
        #[cfg_attr(feature = "serde", serde(with = "crate::numeric::not_finite::number"))]
        error: f64,
    },
    /// Warning: the integrals are too coarse for the drives or for a contact law.
    Coarse {
        /// Way of integration.
        integrals: Integrals,
        /// Change of the accelerations along the orbit by integrals twice as fine, as a share of the largest
        /// coefficient `[1]`.
        #[cfg_attr(feature = "serde", serde(with = "crate::numeric::not_finite::number"))]
        share: f64,
    },
    /// Warning: order 0 is not kept, but the mean acceleration is not zero. No equation balances it.
    MeanAcceleration {
        /// Mean acceleration, as a share of the largest acceleration of the coordinate `[1]`.
        #[cfg_attr(feature = "serde", serde(with = "crate::numeric::not_finite::number"))]
        share: f64,
    },
    /// The model has no Jacobian. Differences were used, so the last iterations do not converge
    /// quadratically. This is not a warning.
    Differences,
}

impl BalanceNote {
    /// Whether the note is a warning, so that the orbit may be inaccurate.
    pub fn is_warning(&self) -> bool {
        !matches!(self, BalanceNote::Differences)
    }
}

impl std::fmt::Display for BalanceNote {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            BalanceNote::Unresolved { highest, needed } => {
                write!(
                    f,
                    "orders up to {highest} do not resolve the fastest local natural frequency: {needed:.0} \
                     are needed"
                )
            }
            BalanceNote::Aliased { samples, error } => {
                write!(f, "the error by {samples} samples is {error:.1e} of the peak-to-peak value")
            }
            BalanceNote::Coarse { integrals, share } => {
                write!(
                    f,
                    "{integrals:?} integrals twice as fine change the accelerations by {share:.1e} of the \
                     largest"
                )
            }
            BalanceNote::MeanAcceleration { share } => {
                write!(
                    f,
                    "order 0 is not kept, but the mean acceleration is {share:.1e} of the largest \
                     acceleration"
                )
            }
            BalanceNote::Differences => f.write_str("the model has no Jacobian: differences were used"),
        }
    }
}
