//! Members of planetary sets.

use gear_dynamics::trains::{Bearing, Body, Members};

/// Teeth of sun, planets and ring, and moments of inertia, the last of which is that of the carrier. All turn.
pub fn turning([sun, planet, ring]: [u32; 3], inertias: [f64; 4]) -> Members {
    let [of_sun, of_planet, of_ring, carrier] = inertias.map(Body::new);
    Members { sun: (sun, of_sun), planet: (planet, of_planet), ring: (ring, of_ring), carrier }
}

/// The same members with a locked ring.
pub fn ring_locked(teeth: [u32; 3], inertias: [f64; 4]) -> Members {
    let members = turning(teeth, inertias);
    Members { ring: (members.ring.0, members.ring.1.locked()), ..members }
}

/// The same members with a ring that a spring holds.
pub fn ring_held(teeth: [u32; 3], inertias: [f64; 4], stiffness: f64) -> Members {
    let members = turning(teeth, inertias);
    Members { ring: (members.ring.0, members.ring.1.grounded(stiffness, 0.0)), ..members }
}

/// The members on bearings.
pub fn on_bearings(members: Members, [sun, planet, ring, carrier]: [Bearing; 4]) -> Members {
    let on = |(teeth, body): (u32, Body), bearing| (teeth, body.bearing(bearing));
    Members {
        sun: on(members.sun, sun),
        planet: on(members.planet, planet),
        ring: on(members.ring, ring),
        carrier: members.carrier.bearing(carrier),
    }
}
