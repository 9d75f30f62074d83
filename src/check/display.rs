//! Findings as sentences: what was seen, and where to look.

use crate::check::inconsistency::Inconsistency;
use std::fmt;

impl fmt::Display for Inconsistency {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Inconsistency::NotFinite { what, index, t } => {
                write!(f, "{what} {index} is not a number, or infinite, at t = {t} and the typical state")
            }
            Inconsistency::Jacobian { row, column, given, differences } => {
                write!(
                    f,
                    "jacobian: row {row}, column {column} (coordinates, then velocities) is {given}, differences of accel say {differences}"
                )
            }
            Inconsistency::Pieces { component, held, free } => write!(
                f,
                "accel_on_pieces: on the pieces where the contacts stand, component {component} is {held}, but accel says {free}; both must agree"
            ),
            Inconsistency::PiecesIgnored { contact, edge } => write!(
                f,
                "accel_on_pieces: contact {contact} held on the piece beyond its edge {edge} changes nothing; each piece must go on past its \
                 edge, or the function return false"
            ),
            Inconsistency::ContactRate { contact, given, differences } => write!(
                f,
                "contact {contact}: its rate is {given}, but its deflection changes at {differences}; the rate is the time derivative of the \
                 deflection, drives included"
            ),
            Inconsistency::EdgeRate { contact, given, differences } => {
                write!(
                    f,
                    "contact {contact}: the rate of an edge is {given}, but the edge moves at {differences}"
                )
            }
            Inconsistency::Kink { contact, edge } => write!(
                f,
                "contact {contact}: it has an edge at the deflection {edge}, but accel neither bends nor jumps there; is it the edge that accel \
                 uses?"
            ),
            Inconsistency::Rebound { contact, edge, approach, leaves } => write!(
                f,
                "impact: contact {contact} meets its stop at the deflection {edge} with a speed of {approach} over it and leaves it with {leaves}; \
                 it must leave, and no faster than it came"
            ),
            Inconsistency::UntoldKink { component, q } => write!(
                f,
                "accel: component {component} bends or jumps at q = {q:?}, where no contact has an edge; tell it by contacts() and contact(), \
                 so that solvers can locate it"
            ),
            Inconsistency::NoForce { contact, edge } => {
                write!(
                    f,
                    "contact {contact}: accel bends at its edge {edge}, but its force does not; was the force left at its default 0?"
                )
            }
            Inconsistency::Force { contact, edge, given, expected } => write!(
                f,
                "contact {contact}: at its edge {edge} its force changes by {given} over the distance looked at, but accel by what {expected} \
                 would do; the force must be the one that acts in accel, on both flanks and with its damping"
            ),
            Inconsistency::NegativeGap { contact, lower, upper } => {
                write!(f, "contact {contact}: its lower edge {lower} lies above its upper edge {upper}")
            }
            Inconsistency::EdgeBehind { t, edge } => {
                write!(
                    f,
                    "next_edge: asked at t = {t} it says {edge}, which does not lie ahead; it must be later than t"
                )
            }
            Inconsistency::UnannouncedJump { drive, t } => {
                write!(
                    f,
                    "drive {drive} jumps at t = {t}, where next_edge announces nothing; solvers stop only at announced edges"
                )
            }
            Inconsistency::State { given, dof } => {
                write!(
                    f,
                    "the typical state has {} coordinates and {} velocities, the model {dof} degrees of freedom",
                    given[0], given[1]
                )
            }
            Inconsistency::BadPeriod { period } => write!(f, "period: {period} is not positive and finite"),
            Inconsistency::Period { what, index, t, first, second } => {
                write!(f, "period: {what} {index} is {first} at t = {t}, but {second} a period later")
            }
        }
    }
}
