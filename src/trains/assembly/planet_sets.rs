//! The planetary sets of a train.

use crate::contact::Nonlinearity;
use crate::trains::assembly::rows::Layout;
use crate::trains::shape::elements::{PlanetPlace, PlanetSet};
use std::collections::BTreeSet;

/// The sets of all carriers, in the order of the carriers.
pub(crate) fn planet_sets<N: Nonlinearity>(layout: &Layout<N>) -> Vec<PlanetSet> {
    let (topology, planets) = (&layout.plan.topology, &layout.plan.planets);
    let carriers: BTreeSet<usize> = topology.carriers.iter().flatten().copied().collect();
    let set = |carrier: usize| {
        let planet = |body: usize| planets[body].as_ref().filter(|planet| planet.carrier == carrier);
        let place = |body: usize| {
            let centre = match layout.centre[body] {
                [Some(x), Some(_)] => Some(x),
                _ => None,
            };
            Some(PlanetPlace { at: layout.angle[body], centre, angle: planet(body)?.angle })
        };
        // The carrier, and the gears that mesh with a planet and are none.
        let central = topology.meshes.iter().filter_map(|mesh| match mesh.ends.map(planet) {
            [Some(_), None] => Some(mesh.ends[1]),
            [None, Some(_)] => Some(mesh.ends[0]),
            _ => None,
        });
        let central: BTreeSet<usize> = std::iter::once(carrier).chain(central).collect();
        let angle = |body: usize| layout.angle[body].map(|at| (at, false));
        let shifts = |body: usize| layout.centre[body].into_iter().flatten().map(|at| (at, true));
        PlanetSet {
            planets: (0..planets.len()).filter_map(place).collect(),
            central: central
                .into_iter()
                .flat_map(|body| angle(body).into_iter().chain(shifts(body)))
                .collect(),
        }
    };
    carriers.into_iter().map(set).collect()
}
