//! A tooth contact at one instant.

use crate::contact::piece::Piece;
use crate::scalar::Scalar;

/// What a tooth contact looks like at one instant. An edge is infinite where the law has none.
///
/// A deflection and its edges may depend on the drives, the coordinates and the velocities. One that depends on the coordinates alone has a
/// rate linear in the velocities, as teeth do. One that depends on the velocities, such as a sliding speed at which friction changes its
/// sign, has a rate that holds the accelerations as well. A force that depends on the piece must not push back towards the edge from both
/// sides: sliding along an edge is not modelled, and ends in [`IntegrateError::EdgeStall`](crate::ode::IntegrateError::EdgeStall).
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
    /// d'.
    pub rate: S,
    /// Lower edge of the gap: -b for a backlash of half width b.
    pub lower: S,
    /// Upper edge of the gap.
    pub upper: S,
    /// Rate of the lower edge.
    pub lower_rate: S,
    /// Rate of the upper edge.
    pub upper_rate: S,
    /// Mesh force, damping included.
    pub force: S,
}

impl<S: Scalar> Default for Contact<S> {
    /// Nothing touches: no edges, no force.
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
    /// The piece that the deflection alone says; an edge itself counts as gap.
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

    /// max(d - upper, lower - d): how deep the teeth press into each other, negative in the gap.
    #[inline]
    pub fn penetration(&self) -> f64 {
        (self.deflection - self.upper).max(self.lower - self.deflection)
    }
}
