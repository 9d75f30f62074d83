//! What has to be known of a solution.

use crate::periodic::balance::integrals::Integrals;

/// What has to be known of an orbit before it is believed.
///
/// ```
/// use gear_dynamics::periodic::BalanceNote;
/// let note = BalanceNote::Unresolved { highest: 65, needed: 656.0 };
/// assert!(note.is_warning());
/// assert!(note.to_string().contains("656"));
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum BalanceNote {
    /// Warning: the fastest local natural frequency is not resolved; such orbits are off, and their branches carry folds that are not there.
    Unresolved {
        /// The highest order kept.
        highest: usize,
        /// 1.2 √(largest local stiffness)/ω.
        needed: f64,
    },
    /// Warning: sampling moves the orbit.
    Aliased {
        /// M.
        samples: usize,
        /// The correction that exact integrals ask for, as a share of the peak-to-peak.
        error: f64,
    },
    /// Warning: the integrals are too coarse for the drives or for the law of force.
    Coarse {
        /// How they were taken.
        integrals: Integrals,
        /// How much twice as fine ones change the forces along the orbit, as a share of the largest coefficient.
        share: f64,
    },
    /// Warning: order 0 is not kept, and the mean force is not zero: nothing balances it.
    MeanForce {
        /// The mean acceleration, as a share of the largest.
        share: f64,
    },
    /// The model offers no Jacobian: differences were used, and convergence is not quadratic to the end.
    Differences,
}

impl BalanceNote {
    /// Whether it casts doubt on the orbit.
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
                    "orders up to {highest} do not resolve the fastest local natural frequency: {needed:.0} are needed"
                )
            }
            BalanceNote::Aliased { samples, error } => {
                write!(f, "{samples} samples move the orbit by {error:.1e} of its peak-to-peak")
            }
            BalanceNote::Coarse { integrals, share } => {
                write!(
                    f,
                    "{integrals:?} integrals twice as fine change the forces by {share:.1e} of the largest"
                )
            }
            BalanceNote::MeanForce { share } => {
                write!(
                    f,
                    "order 0 is not kept, and nothing balances the mean force, {share:.1e} of the largest"
                )
            }
            BalanceNote::Differences => f.write_str("the model offers no Jacobian: differences were used"),
        }
    }
}
