//! Phases of meshes that follow from teeth: idlers, several wheels on one gear, planets, loops.

use crate::api::*;
use crate::common::planets::ring_locked;
use gear_dynamics::Wave;
use gear_dynamics::teeth::{GearPair, InvoluteGear};
use gear_dynamics::trains::*;
use std::f64::consts::TAU;

const MODULE: f64 = 2e-3;

fn steel() -> Wave {
    Wave::constant(2e8).unwrap()
}

/// A mesh of gears of the module 2 mm and the pressure angle 20°; the second gear is internal if its number is negative.
fn mesh([z1, z2]: [i32; 2]) -> MeshPart {
    let teeth = [z1, z2].map(i32::unsigned_abs);
    let radii = teeth.map(|z| 0.5 * MODULE * f64::from(z) * 20f64.to_radians().cos());
    let new = if z2 < 0 { MeshPart::internal } else { MeshPart::external };
    new(teeth, radii, steel())
}

/// The phase that the builder computes for the one mesh that states an impossible one.
fn computed(parts: &mut Parts) -> f64 {
    match parts.accept(Warning::Unbalanced).build("input", 100.0) {
        Err(TrainError::PhaseContradicts { computed, .. }) => computed,
        other => panic!("{:?}", other.err()),
    }
}

/// A stated phase that no mesh here has.
const IMPOSSIBLE: f64 = 0.123_456_7;

/// The distance of a phase from another one modulo 1.
fn apart(phase: f64, other: f64) -> f64 {
    let gap = (phase - other).rem_euclid(1.0);
    gap.min(1.0 - gap)
}

/// A sun at the origin with the sense of rotation `sense`, planets on fixed axes at the given angles, and a ring. The
/// mesh `asked` states an impossible phase.
fn star(sense: f64, [zs, zp]: [i32; 2], angles: &[f64], asked: &str) -> Parts {
    let (zr, far) = (zs + 2 * zp, 0.5 * MODULE * f64::from(zs + zp));
    let mut parts = Parts::new();
    parts.body("input", Body::new(1e-2)).body("sun", Body::new(1e-3).centre([0.0; 2]));
    parts.body("ring", Body::new(1e-2).centre([0.0; 2]));
    // An external mesh reverses the rotation, an internal one does not.
    parts.mesh("input mesh", "input", "sun", if sense > 0.0 { mesh([30, -90]) } else { mesh([30, 90]) });
    for (p, angle) in (1..).zip(angles) {
        let planet = format!("planet {p}");
        parts.body(&planet, Body::new(1e-3).centre([far * angle.cos(), far * angle.sin()]));
        let mut add = |kind: &str, first: &str, second: &str, mesh: MeshPart, anchor: bool| {
            let name = format!("{kind} {p}");
            let mesh = if anchor { mesh } else { mesh.phase_from_teeth() };
            let mesh = if name == asked { mesh.stated_phase(IMPOSSIBLE) } else { mesh };
            parts.mesh(&name, first, second, mesh);
        };
        add("sun", "sun", &planet, mesh([zs, zp]), p == 1);
        add("ring", &planet, "ring", mesh([zp, -zr]), false);
    }
    parts
}

/// The sun mesh of a planet at the angle ψ is behind that of a planet at 0 by Z_s ψ/2π, in the sense of rotation.   Source:
/// Parker and Lin 2004, J. Mech. Des. 126, 365.
#[test]
fn wheels_round_a_sun() {
    for sense in [1.0, -1.0] {
        for teeth in [[19, 17], [20, 25], [31, 20]] {
            let z = f64::from(teeth[0]);
            // Any place fits as long as no ring closes a loop: the second planet alone is asked.
            for place in [0.3, 1.0, 2.5] {
                let mut parts = star(sense, teeth, &[0.0], "");
                let far = 0.5 * MODULE * f64::from(teeth[0] + teeth[1]);
                parts.body("other", Body::new(1e-3).centre([far * f64::cos(place), far * f64::sin(place)]));
                let asked = mesh(teeth).phase_from_teeth().stated_phase(IMPOSSIBLE);
                let phase = computed(parts.mesh("asked", "sun", "other", asked));
                assert!(apart(phase, -sense * z * place / TAU) < 1e-12, "{phase}");
            }
        }
    }
}

/// The ring mesh of a planet is half a cycle from its sun mesh if the planet has an even number of teeth, otherwise in
/// phase.   Source: Parker and Lin 2004, J. Mech. Des. 126, 365.
#[test]
fn sun_and_ring_mesh_of_a_planet() {
    for sense in [1.0, -1.0] {
        for (teeth, expected) in [([19, 17], 0.0), ([20, 26], 0.5), ([31, 20], 0.5), ([30, 25], 0.0)] {
            let phase = computed(&mut star(sense, teeth, &[0.0], "ring 1"));
            assert!(apart(phase, expected) < 1e-12, "{teeth:?}: {phase}");
        }
    }
    // The same for planets on a carrier, whose places shift both meshes.
    for (teeth, expected) in [([21, 18], 0.5), ([24, 15], 0.0)] {
        let ring = -(teeth[0] + 2 * teeth[1]);
        let mut parts = Parts::new();
        parts
            .body("input", Body::new(1e-3))
            .body("carrier", Body::new(1e-2))
            .body("ring", Body::new(1.0).locked());
        for (p, angle) in [0.0, TAU / 3.0].into_iter().enumerate() {
            let (planet, outer) = (format!("planet {p}"), mesh([teeth[1], ring]).phase_from_teeth());
            parts.body(&planet, Body::new(1e-3).carried_by("carrier", angle));
            parts.mesh(&format!("sun {p}"), "input", &planet, mesh(teeth));
            let outer = if p == 1 { outer.stated_phase(IMPOSSIBLE) } else { outer };
            parts.mesh(&format!("ring {p}"), &planet, "ring", outer);
        }
        let phase = computed(&mut parts);
        assert!(apart(phase, expected - f64::from(teeth[0]) / 3.0) < 1e-12, "{teeth:?}: {phase}");
    }
}

/// A set on fixed axes assembles if (Z_s + Z_r) ψ/2π is whole; otherwise the teeth miss by the rest.
#[test]
fn loops_that_do_not_close() {
    let teeth = [19, 17]; // 72 for sun and ring together
    for turns in [6.0, 30.0, 71.0] {
        let mut parts = star(1.0, teeth, &[0.0, turns * TAU / 72.0], "");
        assert!(parts.accept(Warning::Unbalanced).build("input", 100.0).is_ok());
    }
    let mut parts = star(1.0, teeth, &[0.0, 6.2 * TAU / 72.0], "");
    match parts.accept(Warning::Unbalanced).build("input", 100.0).unwrap_err() {
        TrainError::TeethMiss { gap, mesh } => assert!((gap - 0.2).abs() < 1e-9, "{gap} {mesh}"),
        error => panic!("{error}"),
    }
}

/// The teeth of an idler with the profile shift x are π/2 + 2 x tan α modules thick on the reference circle, which is the
/// working pitch circle of both meshes for shifts x and -x.
#[test]
fn idlers_with_profile_shift() {
    let gear = |z, x| InvoluteGear::external(z, MODULE)?.with_profile_shift(x)?.with_face_width(0.02);
    for x in [-0.2, 0.0, 0.3] {
        let (outer, idler) = (gear(40, -x).unwrap(), gear(31, x).unwrap());
        let pairs = [GearPair::new(&outer, &idler).unwrap(), GearPair::new(&idler, &outer).unwrap()];
        let far = pairs[0].centre_distance();
        for (angle, quarter) in [(0.0, 2.0), (-0.25 * TAU, 3.0)] {
            let mut parts = Parts::new();
            parts
                .body("input", Body::new(1e-3).centre([-far, 0.0]))
                .body("idler", Body::new(1e-3).centre([0.0; 2]));
            parts.body("output", Body::new(1e-3).centre([far * angle.cos(), far * angle.sin()]));
            let [first, second] = pairs.each_ref().map(|pair| MeshPart::of_pair(pair, steel()));
            parts.mesh("first", "input", "idler", first);
            let second = second.phase_from_teeth().stated_phase(IMPOSSIBLE);
            let phase = computed(parts.mesh("second", "idler", "output", second));
            // The idler turns clockwise from 180° to `angle`.
            let thick = (0.5 * TAU / 4.0 + x * 20f64.to_radians().tan()) / (0.25 * TAU);
            let later = 31.0 * quarter / 4.0 - thick;
            let between = (pairs[1].pitch_point() - pairs[0].pitch_point()) / TAU;
            assert!(apart(phase, between - later) < 1e-12, "{x} {angle}: {phase} {}", between - later);
        }
    }
}

#[test]
fn phases_that_do_not_follow_are_refused() {
    let build = |places: bool, second: [i32; 2]| {
        let mut parts = Parts::new();
        for (i, name) in ["input", "idler", "output"].into_iter().enumerate() {
            let body = Body::new(1e-3);
            parts.body(name, if places { body.centre([0.1 * i as f64, 0.0]) } else { body });
        }
        parts.mesh("first", "input", "idler", mesh([30, 31]));
        parts.mesh("second", "idler", "output", mesh(second).phase_from_teeth()).build("input", 100.0)
    };
    assert!(build(true, [31, 40]).is_ok());
    let undetermined = Err(TrainError::PhaseUndetermined { mesh: "second".into() });
    assert_eq!(build(false, [31, 40]), undetermined);
    // Two gears on one shaft: how their teeth stand to each other is not stated.
    assert_eq!(build(true, [20, 40]), undetermined);
}

/// A phase that is stated contradicts the teeth: the message names its mesh, not the places.
#[test]
fn stated_phases_that_contradict_teeth() {
    let build = |phase: f64| {
        let mut parts = star(1.0, [19, 17], &[0.0, 6.0 * TAU / 72.0], "");
        let far = 0.5 * MODULE * 36.0;
        parts.body("other", Body::new(1e-3).centre([0.0, far]));
        parts.mesh("stated", "sun", "other", mesh([19, 17]).phase(phase));
        parts.accept(Warning::Unbalanced).build("input", 100.0)
    };
    assert!(build(-19.0 / 4.0).is_ok());
    match build(0.0).unwrap_err() {
        TrainError::PhaseContradicts { mesh, stated, computed } => {
            let names = ["stated", "sun 1"].contains(&&mesh[..]);
            assert!(names && (apart(stated - computed, 0.25)).abs() < 1e-9, "{mesh} {stated} {computed}");
        }
        error => panic!("{error}"),
    }
}

/// Two gears of 31 teeth on one body, of different modules, are no gear in common.
#[test]
fn equal_tooth_numbers_of_different_gears() {
    let mut parts = Parts::new();
    for (i, name) in ["input", "compound", "output"].into_iter().enumerate() {
        parts.body(name, Body::new(1e-3).centre([0.1 * i as f64, 0.0]));
    }
    let larger = MeshPart::external([31, 40], [0.0465, 0.06], steel()).phase_from_teeth();
    parts.mesh("first", "input", "compound", mesh([30, 31])).mesh("second", "compound", "output", larger);
    let error = parts.build("input", 100.0).unwrap_err();
    assert_eq!(error, TrainError::PhaseUndetermined { mesh: "second".into() });
}

#[test]
fn ring_phases_of_planetary_sets() {
    for (planet, stated) in [(25, 0.0), (26, 0.5)] {
        let teeth = [30, planet, 30 + 2 * planet];
        let members = || ring_locked(teeth, [1e-3; 4]);
        let set = || Planetary::new(1, 0.03, members(), [steel(), wave()]).unwrap();
        let [from_teeth, by_hand] = [set().ring_phase_from_teeth(), set().ring_phase(stated)]
            .map(|set| set.parts().build("sun", 100.0).unwrap());
        assert!(from_teeth.shares_lanes_with(&by_hand), "{planet}");
        assert!(!from_teeth.shares_lanes_with(&set().ring_phase(0.25).parts().build("sun", 100.0).unwrap()));
    }
}

fn wave() -> Wave {
    Wave::new(Fourier::new(2e8, &[[3e7, 1e7]]).unwrap())
}
