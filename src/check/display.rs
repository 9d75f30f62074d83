//! Texts of the findings: the part of the model, the values found and the requirement.

use crate::check::inconsistency::Inconsistency;
use crate::excitation::Side;
use std::fmt;

impl std::error::Error for Inconsistency {}

impl fmt::Display for Inconsistency {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Inconsistency::NotFinite { what, index, t } => {
                write!(f, "{what} {index} is NaN or infinite at t = {t} and the typical state")
            }
            Inconsistency::Offers { method, declared: true } => {
                write!(f, "offers: it declares {method}, but the model does not implement {method}")
            }
            Inconsistency::Offers { method, declared: false } => write!(
                f,
                "offers: the model implements {method}, but does not declare it; solvers call only what is \
                 declared"
            ),
            Inconsistency::StopsOfNoContact { stops, contacts } => {
                write!(f, "offers: it declares stops of {stops} contacts, but the model has {contacts}")
            }
            Inconsistency::Jacobian { row, column, given, differences } => {
                write!(
                    f,
                    "jacobian: row {row}, column {column} (coordinates, then velocities) is {given}, but \
                     differences of accel give {differences}"
                )
            }
            Inconsistency::Pieces { component, on_pieces, accel } => write!(
                f,
                "accel_on_pieces: on the pieces on which the contacts stand, component {component} is \
                 {on_pieces}, but accel gives {accel}; both must agree"
            ),
            Inconsistency::PiecesIgnored { contact, edge } => write!(
                f,
                "accel_on_pieces: with contact {contact} on the piece beyond its edge {edge} the result is \
                 that of accel; each piece must be continued past its edge, or offers must \
                 not declare pieces"
            ),
            Inconsistency::ContactRate { contact, given, differences } => write!(
                f,
                "contact {contact}: its rate is {given}, but differences of its deflection give \
                 {differences}; the rate must be the time derivative of the deflection, including the rates \
                 of the drives"
            ),
            Inconsistency::EdgeRate { contact, given, differences } => {
                write!(
                    f,
                    "contact {contact}: the rate of an edge is {given}, but differences of the edge give \
                     {differences}"
                )
            }
            Inconsistency::Kink { contact, edge } => write!(
                f,
                "contact {contact}: it has an edge at the deflection {edge}, but accel has neither a kink \
                 nor a jump there; accel must use the same edge"
            ),
            Inconsistency::Rebound { contact, edge, approach, leaves } => write!(
                f,
                "impact: contact {contact} meets its stop at the deflection {edge} with a speed of \
                 {approach} relative to it and leaves it with {leaves}; the speed after the impact must lie \
                 between 0 and the speed before it"
            ),
            Inconsistency::UndeclaredKink { component, q } => write!(
                f,
                "accel: component {component} has a kink or a jump at q = {q:?}, where no contact has an \
                 edge; declare the edge by contacts() and contact(), so that solvers can locate it"
            ),
            Inconsistency::NoForce { contact, edge } => {
                write!(
                    f,
                    "contact {contact}: accel has a kink at its edge {edge}, but its force has none; \
                     contact() must set the force, which has the default 0"
                )
            }
            Inconsistency::Force { contact, edge, given, expected } => write!(
                f,
                "contact {contact}: its force changes by {given} near its edge {edge}, but the change of \
                 accel corresponds to {expected}; the force must be the one that acts in accel, on both \
                 flanks and with its damping"
            ),
            Inconsistency::NegativeGap { contact, lower, upper } => {
                write!(f, "contact {contact}: its lower edge {lower} lies above its upper edge {upper}")
            }
            Inconsistency::DriveEdgeBehind { t, edge } => {
                write!(f, "next_edge: at t = {t} it returns {edge}; the edge must be later than t")
            }
            Inconsistency::UnannouncedJump { drive, t } => {
                write!(
                    f,
                    "drive {drive} jumps at t = {t}, where next_edge returns no edge; solvers end their \
                     steps only at the edges that next_edge returns"
                )
            }
            Inconsistency::SideIgnored { drive, t, side } => {
                let side = if *side == Side::Before { "before" } else { "after" };
                write!(
                    f,
                    "drive {drive} jumps at t = {t}, but drive() does not return its value {side} the jump; it \
                     must return the value of the requested side"
                )
            }
            Inconsistency::Redrive { drive, t, found, expected } => {
                write!(f, "redrive: at t = {t} drive {drive} is {found}, by Model::drive it is {expected}")
            }
            Inconsistency::State { given, dof } => {
                write!(
                    f,
                    "the typical state has {} coordinates and {} velocities, the model {dof} degrees of \
                     freedom",
                    given[0], given[1]
                )
            }
            Inconsistency::BadPeriod { period } => {
                write!(f, "period: it is {period}; it must be positive and finite")
            }
            Inconsistency::Period { what, index, t, first, second } => {
                write!(f, "period: {what} {index} is {first} at t = {t}, but {second} one period later")
            }
        }
    }
}
