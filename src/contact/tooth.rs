//! Tooth contacts at one instant.

use crate::contact::piece::Piece;
use crate::scalar::Scalar;

/// A tooth contact at one instant: deflection, edges and force. An edge that the law does not have is
/// infinite.
///
/// The deflection and the edges may depend on drives, coordinates and velocities. If the deflection depends
/// on the coordinates and drives alone, as between teeth, its rate is linear in the velocities. If it
/// depends on the velocities, for example as a sliding speed at which friction changes its sign, its rate
/// contains the accelerations.
///
/// A force that depends on the piece must not push the contact back to the edge from both sides. Sliding
/// along an edge is not modelled and ends in
/// [`IntegrateError::EdgeStall`](crate::ode::IntegrateError::EdgeStall).
///
/// ```
/// use gear_dynamics::contact::Contact;
/// let contact = Contact { deflection: 2e-5, lower: -1e-5, upper: 1e-5, force: 300.0, ..Contact::default() };
/// assert_eq!(contact.penetration(), 1e-5);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact<S = f64> {
    /// Deflection d, in the unit of the edges.
    pub deflection: S,
    /// Rate of the deflection, d'.
    pub rate: S,
    /// Lower edge of the gap: -b for the half backlash b.
    pub lower: S,
    /// Upper edge of the gap: b for the half backlash b.
    pub upper: S,
    /// Rate of the lower edge.
    pub lower_rate: S,
    /// Rate of the upper edge.
    pub upper_rate: S,
    /// Mesh force, damping included, in the force unit of the model.
    pub force: S,
}

impl<S: Scalar> Default for Contact<S> {
    /// A contact without edges and without force, at the deflection 0.
    #[inline(always)]
    fn default() -> Self {
        let (zero, most) = (S::from(0.0), S::from(f64::INFINITY));
        Contact {
            deflection: zero,
            rate: zero,
            lower: -most,
            upper: most,
            lower_rate: zero,
            upper_rate: zero,
            force: zero,
        }
    }
}

impl Contact {
    /// The piece on which the deflection lies. A deflection exactly on an edge counts as gap.
    #[inline]
    pub fn piece(&self) -> Piece {
        if self.deflection < self.lower {
            Piece::Lower
        } else if self.deflection > self.upper {
            Piece::Upper
        } else {
            Piece::Gap
        }
    }

    /// Penetration max(d - upper, lower - d): the depth past an edge, negative in the gap.
    #[inline]
    pub fn penetration(&self) -> f64 {
        (self.deflection - self.upper).max(self.lower - self.deflection)
    }
}
