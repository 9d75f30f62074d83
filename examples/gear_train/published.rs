//! Published planetary sets, by the inertias I/r² and torsional stiffnesses at the base circles that the papers give.
//! The tooth numbers 30, 30, 90 are any that assemble for 3, 4, 5 and 6 planets; frequencies do not depend on them.

use super::support::Outcome;
use gear_dynamics::Wave;
use gear_dynamics::trains::{Bearing, Body, Members, Planetary, Train, Warning};

/// Mass `[kg]`, I/r² `[kg]`, bearing stiffness [N/m] and torsional stiffness at the base circle [N/m] of a member.
struct Member {
    mass: f64,
    inertia: f64,
    bearing: f64,
    turn: f64,
}

/// Sun, planet, ring and carrier; stiffness of all meshes [N/m]; pressure angle in degrees.
struct Set {
    members: [Member; 4],
    mesh: f64,
    pressure_angle: f64,
}

fn member(mass: f64, inertia: f64, bearing: f64, turn: f64) -> Member {
    Member { mass, inertia, bearing, turn }
}

/// Lin and Parker 1999, J. Vib. Acoust. 121, 316, Table 1.
fn lin_parker() -> Set {
    let sun = member(0.4, 0.39, 1e8, 0.0);
    let planet = member(0.66, 0.61, 1e8, 0.0);
    let ring = member(2.35, 3.0, 1e8, 1e9);
    let carrier = member(5.43, 6.29, 1e8, 0.0);
    Set { members: [sun, planet, ring, carrier], mesh: 5e8, pressure_angle: 24.6 }
}

/// Cooley and Parker 2012, Table 1.
fn cooley_parker() -> Set {
    let sun = member(3.0, 1.75, 2e7, 2e7);
    let planet = member(1.86, 1.25, 1e7, 0.0);
    let ring = member(7.64, 8.09, 1e8, 1e8);
    let carrier = member(12.0, 6.8, 5e7, 1e8);
    Set { members: [sun, planet, ring, carrier], mesh: 1e8, pressure_angle: 20.0 }
}

impl Set {
    fn train(&self, planets: u32) -> Outcome<Train> {
        let angle = self.pressure_angle.to_radians();
        let radii = [0.03, 0.03, 0.09, 0.06 / angle.cos()];
        let of = |i: usize| &self.members[i];
        let body = |i: usize| {
            let square = radii[i] * radii[i];
            let body = Body::new(of(i).inertia * square).bearing(Bearing::new(of(i).mass, of(i).bearing));
            body.restrained(if i == 1 { 0.0 } else { of(i).turn * square }, 0.0)
        };
        let ring = (90, body(2).grounded(of(2).turn * radii[2] * radii[2], 0.0));
        let members = Members { sun: (30, body(0)), planet: (30, body(1)), ring, carrier: body(3) };
        let mesh = || Wave::constant(self.mesh);
        let set = Planetary::new(planets, radii[0], members, [mesh()?, mesh()?])?.pressure_angle(angle);
        Ok(set.parts().build("sun", 100.0)?)
    }
}

/// Kahraman 1994, J. Sound Vib. 173, 125: fixed ring, in the units of the paper.
fn kahraman() -> Outcome<Train> {
    let ring = (90, Body::new(1.0).locked());
    let members =
        Members { sun: (30, Body::new(0.5)), planet: (30, Body::new(0.75)), ring, carrier: Body::new(4.0) };
    let meshes = [Wave::constant(7.0)?, Wave::constant(11.0)?];
    let mut parts = Planetary::new(3, 0.5, members, meshes)?.parts();
    Ok(parts.accept(Warning::UnusualValue).build("sun", 1.0)?)
}

/// All sets by name.
pub fn sets() -> Outcome<Vec<(String, Train)>> {
    let mut sets = vec![("kahraman_1994_fixed_ring".to_owned(), kahraman()?)];
    for planets in [3, 4, 5] {
        sets.push((format!("lin_parker_{planets}"), lin_parker().train(planets)?));
        sets.push((format!("cooley_parker_{planets}"), cooley_parker().train(planets)?));
    }
    Ok(sets)
}
