//! Teeth: geometry, mesh stiffness and deviations against references, closed forms and invariants.

use crate::api::*;
use crate::data::read;
use gear_dynamics::ParameterError as P;
use proptest::prelude::*;
use serde_json::Value;
use std::f64::consts::{PI, TAU};

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(number).collect()
}

/// |found/expected - 1| <= tolerance.
#[track_caller]
fn close(found: f64, expected: f64, tolerance: f64) {
    let error = (found - expected).abs() / expected.abs();
    assert!(error <= tolerance, "{found} for {expected}: {error:.2e} above {tolerance:.0e}");
}

/// |found - expected| <= half of the last digit printed.
#[track_caller]
fn printed(found: f64, expected: f64, digit: f64) {
    assert!((found - expected).abs() <= 0.5001 * digit, "{found} for {expected}");
}

pub(crate) fn external(teeth: u32, shift: f64, module: f64) -> InvoluteGear {
    InvoluteGear::external(teeth, module).unwrap().with_profile_shift(shift).unwrap()
}

// --- ISO 6336-1, method B ---------------------------------------------------------------------------------------

/// Sun, planet and ring of stage 1 of the NREL 5 MW gearbox.
fn stage_1() -> [InvoluteGear; 3] {
    let data = &read("teeth.json")["iso6336_method_b"];
    let (sun, ring) = (&data["meshes"][0], &data["meshes"][1]);
    let module = 1e-3 * number(&sun["mn"]);
    let alteration = numbers(&data["geometry_mm"]["stage1"]["tip_alteration"]);
    let gear = |gear: InvoluteGear, x: &Value, k: f64| {
        let gear =
            gear.with_profile_shift(number(x)).unwrap().with_face_width(1e-3 * number(&sun["b"])).unwrap();
        gear.with_tip_alteration(1e-3 * k).unwrap()
    };
    [
        gear(InvoluteGear::external(19, module).unwrap(), &sun["x"][0], alteration[0]),
        gear(InvoluteGear::external(17, module).unwrap(), &sun["x"][1], alteration[1]),
        gear(InvoluteGear::internal(56, module).unwrap(), &ring["x"][1], alteration[2]),
    ]
}

#[test]
fn stage_1_of_the_nrel_gearbox_has_the_printed_geometry() {
    let data = &read("teeth.json")["iso6336_method_b"];
    let geometry = &data["geometry_mm"]["stage1"];
    let diameters = |name: &str, of: fn(&InvoluteGear) -> f64, digit: f64| {
        for (gear, expected) in stage_1().iter().zip(numbers(&geometry[name])) {
            printed(2e3 * of(gear), expected, digit);
        }
    };
    diameters("d", InvoluteGear::reference_radius, 1e-3);
    diameters("db", InvoluteGear::base_radius, 1e-3);
    let [sun, planet, ring] = stage_1();
    for (pair, mesh) in [([sun, planet], &data["meshes"][0]), ([planet, ring], &data["meshes"][1])] {
        for order in [[0, 1], [1, 0]] {
            let [a, b] = order.map(|i| pair[i]);
            let pair = GearPair::at_centre_distance(&a, &b, 1e-3 * number(&mesh["a"])).unwrap();
            assert!(pair.backlash() > 0.0 && pair.backlash() < 2e-6); // rounding of the printed shifts
            printed(pair.working_pressure_angle().to_degrees(), number(&mesh["alfwt_deg"]), 1e-3);
            printed(pair.contact_ratio(), number(&mesh["eps_a"]), 1e-3);
        }
    }
    diameters("da", InvoluteGear::tip_radius, 1e-2);
    diameters("df", InvoluteGear::root_radius, 1e-2);
    let working = |a: &InvoluteGear, b: &InvoluteGear| {
        GearPair::at_centre_distance(a, b, 0.863).unwrap().working_radii().map(|radius| 2e3 * radius)
    };
    let (outer, inner) = (working(&sun, &planet), working(&planet, &ring));
    let expected = &geometry["dw"];
    printed(outer[0], number(&expected[0]), 1e-3);
    printed(outer[1], number(&expected[1][0]), 1e-3);
    printed(inner[0], number(&expected[1][1]), 1e-3);
    printed(inner[1], number(&expected[2]), 1e-3);
}

#[test]
fn stage_1_of_the_nrel_gearbox_has_the_printed_stiffness() {
    let data = &read("teeth.json")["iso6336_method_b"];
    let [sun, planet, ring] = stage_1();
    for (pair, mesh) in [([sun, planet], &data["meshes"][0]), ([planet, ring], &data["meshes"][1])] {
        for order in [[0, 1], [1, 0]] {
            let [a, b] = order.map(|i| pair[i]);
            let pair = GearPair::at_centre_distance(&a, &b, 1e-3 * number(&mesh["a"])).unwrap();
            let method = MethodB::new().web(number(&mesh["bs_b"]), number(&mesh["sR_mn"])).unwrap();
            let found = method.stiffness(&pair).unwrap();
            assert_eq!(pair.gears()[found.pinion].teeth(), 17);
            close(found.single, 1e9 * number(&mesh["c_prime"]), 5e-5);
            close(found.mesh, 1e9 * number(&mesh["c_ga"]), 5e-5);
            close(found.width_distribution, 1e9 * number(&mesh["c_gb"]), 5e-5);
            printed(found.blank, number(&mesh["C_R"]), 1e-3);
            close(found.mean_stiffness, found.mesh * 0.491, 1e-15);
            // The report counts turns of the sun in the first mesh and of the planet in the second.
            let teeth = if mesh["name"] == "stage1 sun-planet" { 19 } else { 17 };
            let speed = found.resonance_speed(teeth, 1e3 * number(&mesh["m_red_kg_mm"])).unwrap();
            printed(60.0 * speed, number(&mesh["n_E1"]), 1.0);
        }
    }
}

#[test]
fn the_pair_of_yao_2020() {
    let data = &read("teeth.json")["yao2020_pair"];
    let (params, geometry, iso) = (&data["params"], &data["geometry"], &data["iso6336_methodB"]);
    let gear = external(30, number(&params["x"][0]), 0.004).with_face_width(0.01).unwrap();
    let (pair, short) = (GearPair::new(&gear, &gear).unwrap(), GearPair::shortened(&gear, &gear).unwrap());
    close(pair.contact_ratio(), number(&geometry["eps_alpha"]), 1e-12);
    close(short.contact_ratio(), number(&geometry["eps_alpha_shortened"]), 1e-12);
    close(1e3 * gear.tip_radius(), number(&geometry["ra_mm"][0]), 1e-12);
    close(1e3 * short.gears()[1].tip_radius(), number(&geometry["ra_mm_shortened"][1]), 1e-12);
    close(pair.working_pressure_angle().to_degrees(), number(&geometry["alpha_w_deg"]), 1e-12);
    close(1e3 * pair.centre_distance(), number(&geometry["centre_distance_mm"]), 1e-12);
    close(1e3 * gear.base_radius(), number(&geometry["rb_mm"][0]), 1e-12);
    close(1e3 * pair.base_pitch(), number(&geometry["base_pitch_mm"]), 1e-12);
    let found = MethodB::new().stiffness(&short).unwrap(); // the stiffness is that of the shortened teeth
    close(1e9 / found.theoretical, number(&iso["q_prime"]), 1e-12);
    close(found.theoretical, 1e9 * number(&iso["c_th"]), 1e-12);
    close(found.single, 1e9 * number(&iso["c_prime"]), 1e-12);
    close(found.mesh, 1e9 * number(&iso["c_gamma_alpha"]), 1e-12);
    close(found.mean_stiffness, number(&iso["k_mean_N_per_m_b10"]), 1e-12);
    assert!(found.notes.is_empty());
    // The rectangular wave of one and two pairs has the mean of the standard.
    let wave = found.rectangular().unwrap();
    close(wave.mean(), found.mean_stiffness, 1e-15);
    close(wave.value(PI), number(&iso["k_prime_N_per_m_b10"]), 1e-12);
    close(wave.value(0.0), 1.75 * found.single * 0.01, 1e-15);
}

#[test]
fn notes_and_limits_of_method_b() {
    let pair = GearPair::new(&external(20, 0.0, 0.004), &external(40, 0.3, 0.004)).unwrap();
    let found = MethodB::new().web(0.1, 0.5).unwrap().stiffness(&pair).unwrap();
    assert_eq!(found.notes, [MethodBNote::RimLimited, MethodBNote::ShiftOrder]);
    close(found.blank, 1.0 + 0.2f64.ln() / (5.0 * 0.2f64.exp()), 1e-15);
    let low = MethodB::new().line_load(5e4).unwrap().stiffness(&pair).unwrap();
    let full = MethodB::new().stiffness(&pair).unwrap();
    close(low.single, 0.5 * full.single, 1e-15);
    // Steel and cast iron: E = 2 E_1 E_2/(E_1 + E_2).
    let cast = MethodB::new().young([206e9, 103e9]).unwrap().stiffness(&pair).unwrap();
    close(cast.single, full.single * 2.0 / 3.0, 1e-15);
    let [_, planet, ring] = stage_1();
    let short = GearPair::at_centre_distance(&stage_1()[0], &planet, 0.863).unwrap();
    assert_eq!(MethodB::new().stiffness(&short).unwrap().notes, [MethodBNote::LowContactRatio]);
    assert!(GearPair::at_centre_distance(&planet, &ring, 0.863).is_ok());
}

// --- potential energy -------------------------------------------------------------------------------------------

fn pair_62(data: &Value) -> GearPair {
    let params = &data["params"];
    let gear = InvoluteGear::external(62, number(&params["module_m"])).unwrap();
    let gear = gear.with_face_width(number(&params["width_m"])).unwrap();
    let gear = gear.with_pressure_angle(number(&params["alpha_deg"]).to_radians()).unwrap();
    let dedendum = number(&params["addendum"]) + number(&params["clearance"]);
    let gear = gear.with_dedendum(dedendum).unwrap();
    GearPair::new(&gear, &gear).unwrap()
}

#[test]
fn closed_forms_of_the_pair_62_62() {
    let data = &read("teeth.json")["potential_energy_62_62"];
    let (pair, published) = (pair_62(data), &data["published"]);
    let gear = pair.gears()[0];
    close(gear.base_radius(), number(&published["base_radius"]), 1e-14);
    close(gear.root_radius(), number(&published["root_radius"]), 1e-14);
    close(gear.module() * gear.fillet_radius(), number(&published["cutter_tip_radius"]), 1e-14);
    let angle = |radius: f64| (gear.base_radius() / radius).acos();
    close(angle(gear.tip_radius()), number(&published["alpha_addendum"]), 1e-13);
    close(angle(gear.form_radius()), number(&published["alpha_start"]), 1e-13);
    let base = gear.tooth_thickness(gear.base_radius()).unwrap() / (2.0 * gear.base_radius());
    close(base, number(&published["base_angle"]), 1e-14);
    close(pair.contact_ratio(), number(&published["contact_ratio"]), 1e-13);
    let blank =
        gear.blank(number(&data["params"]["bore_diameter_m"]), number(&data["params"]["rho"])).unwrap();
    close(blank.mass, number(&published["mass"]), 1e-14);
    close(blank.polar_inertia, number(&published["Ip"]), 1e-14);
    let method = PotentialEnergy::ma_2014([0.035; 2]).unwrap();
    let one = method.pair(&pair, 0.5).unwrap();
    close(one.hertz, number(&published["hertz_stiffness"]), 1e-14);
    // Root angle, and the centre of the rack tip, as ROSS and as the exact geometry have them.
    for (reading, expected) in [
        (Reading::Ross, number(&published["root_angle"])),
        (Reading::Exact, number(&published["b"]) / gear.reference_radius()),
    ] {
        let curve = method.reading(reading).root_curve(&gear).unwrap();
        close(curve.half_root_angle, expected, 1e-14);
        close(curve.depth, number(&published["a"]), 1e-13);
        close(curve.distance, number(&published["b"]), 1e-14);
    }
}

#[test]
fn quadratures_of_the_pair_62_62() {
    let data = &read("teeth.json")["potential_energy_62_62"];
    let (pair, published, computed) = (pair_62(data), &data["published"], &data["computed"]);
    let method = PotentialEnergy::ma_2014([0.035; 2]).unwrap().reading(Reading::Ross);
    let tooth = method.tooth(&pair.gears()[0], 20f64.to_radians()).unwrap();
    let expected = &computed["tooth_at_pitch"];
    close(tooth.total(), number(&expected["k"]), 3e-12); // digits printed
    close(tooth.foundation, number(&expected["k_foundation"]), 3e-12);
    close(tooth.axial, number(&expected["k_axial"]), 1e-12);
    close(tooth.bending, number(&expected["k_bending"]), 1e-12);
    close(tooth.shear, number(&expected["k_shear"]), 1e-12);
    assert!(tooth.error < 1e-12, "{}", tooth.error);
    let wave = method.wave(&pair).unwrap();
    assert!(wave.error() < 1e-11, "{}", wave.error());
    let wave = Wave::new(wave);
    let samples: Vec<f64> = (0..1000)
        .map(|k| wave.value(TAU * f64::from(k) / 999.0, if k == 999 { Side::Before } else { Side::After }))
        .collect();
    for (found, expected) in samples.iter().zip(numbers(&published["k_mesh_first5_of_1000"])) {
        close(*found, expected, 1e-10);
    }
    close(samples.iter().sum::<f64>() / 1000.0, number(&computed["k_mesh_mean_1000"]), 1e-10);
    close(samples.iter().fold(f64::INFINITY, |m, k| m.min(*k)), number(&computed["min"]), 1e-10);
    close(samples.iter().fold(0.0, |m, k| k.max(m)), number(&computed["max"]), 1e-10);
}

/// What the departures of ROSS change (docs/errata.md).
#[test]
fn the_exact_reading_of_the_pair_62_62() {
    let pair = pair_62(&read("teeth.json")["potential_energy_62_62"]);
    let exact = PotentialEnergy::ma_2014([0.035; 2]).unwrap();
    let ross = exact.reading(Reading::Ross);
    let change = |of: &dyn Fn(&PotentialEnergy) -> f64| of(&exact) / of(&ross) - 1.0;
    let foundation = |m: &PotentialEnergy| m.tooth(&pair.gears()[0], 20f64.to_radians()).unwrap().foundation;
    let total = |m: &PotentialEnergy| m.tooth(&pair.gears()[0], 20f64.to_radians()).unwrap().total();
    let mean = |m: &PotentialEnergy| m.wave(&pair).unwrap().mean();
    let body = |m: &PotentialEnergy| {
        m.foundation(Foundation::PerBody([0.035; 2])).unwrap().wave(&pair).unwrap().mean()
    };
    for (found, expected) in [
        (change(&foundation), 0.132_103),
        (change(&total), 0.094_649),
        (change(&mean), 0.044_905),
        (change(&body), 0.061_926),
        (body(&exact) / mean(&exact), 0.667_006),
    ] {
        printed(found, expected, 1e-6);
    }
}

pub(crate) fn pair_19_48() -> GearPair {
    let gear = |z| external(z, 0.0, 0.003175).with_face_width(0.016).unwrap();
    GearPair::new(&gear(19), &gear(48)).unwrap()
}

#[test]
fn the_pair_19_48() {
    let data = &read("teeth.json")["potential_energy_19_48"]["result"];
    let (pair, method) = (pair_19_48(), PotentialEnergy::tian_2004());
    close(pair.contact_ratio(), number(&data["contact_ratio"]), 1e-12);
    let mut worst = 0.0f64;
    let wave = method.wave(&pair).unwrap();
    assert!(wave.error() < 1e-11, "{}", wave.error());
    let mean = wave.mean();
    let wave = Wave::new(wave);
    for row in data["rows"].as_array().unwrap() {
        let phase = number(&row["phase"]);
        let of_pair = |s: f64| method.pair(&pair, s).unwrap().total();
        let mut error = |found: f64, expected: &Value| {
            worst = worst.max((found / number(expected) - 1.0).abs());
        };
        error(of_pair(phase), &row["k_pair1"]);
        if phase + 1.0 <= pair.contact_ratio() {
            error(of_pair(phase + 1.0), &row["k_pair2"]);
        } else {
            assert_eq!(number(&row["k_pair2"]), 0.0);
        }
        let side = if phase == 1.0 { Side::Before } else { Side::After };
        error(wave.value(TAU * phase, side), &row["k_total"]);
    }
    assert!(worst < 1e-11, "{worst:e}");
    let pitch = method.mesh(&pair, pair.pitch_point()).unwrap();
    close(pitch, number(&data["k_at_pitch_point"]), 1e-12);
    // The mean of the reference is that of 400 midpoints. Those miss the place of the jump by up to half of
    // their distance, so that the exact mean differs from it by 3e-4.
    let midpoints = (0..400).map(|k| wave.value(TAU * (f64::from(k) + 0.5) / 400.0, Side::After));
    close(midpoints.sum::<f64>() / 400.0, number(&data["mean"]), 1e-12);
    let end = pair.end_of_double_contact();
    let exact: f64 = [(0.0, end), (end, TAU)]
        .iter()
        .map(|(from, to)| {
            let width = (to - from) / 2000.0;
            (0..2000)
                .map(|k| width * wave.value(from + width * (f64::from(k) + 0.5), Side::After))
                .sum::<f64>()
        })
        .sum();
    close(mean, exact / TAU, 1e-7);
}

// --- geometry ---------------------------------------------------------------------------------------------------

/// Helical gears: ISO 21771 in closed form, and tooth numbers of which the phases of contact are known.
#[test]
fn helical_geometry() {
    let beta = 15f64.to_radians();
    let gear = |z, x| external(z, x, 0.004).with_helix_angle(beta).unwrap().with_face_width(0.05).unwrap();
    let pair = GearPair::new(&gear(23, 0.2), &gear(67, -0.2)).unwrap();
    let [a, b] = pair.gears();
    close(a.transverse_module(), 0.004 / beta.cos(), 1e-15);
    close(a.transverse_pressure_angle().tan(), 20f64.to_radians().tan() / beta.cos(), 1e-15);
    // Opposite shifts leave the reference circles as working circles.
    close(pair.centre_distance(), a.reference_radius() + b.reference_radius(), 1e-14);
    close(pair.working_pressure_angle(), a.transverse_pressure_angle(), 1e-13);
    close(pair.overlap_ratio(), 0.05 * beta.sin() / (PI * 0.004), 1e-15);
    close(pair.total_contact_ratio(), pair.contact_ratio() + pair.overlap_ratio(), 1e-15);
    close(a.base_helix_angle().tan(), beta.tan() * a.transverse_pressure_angle().cos(), 1e-14);
    close(a.virtual_teeth(), 23.0 / (a.base_helix_angle().cos().powi(2) * beta.cos()), 1e-15);
    close(pair.length_of_contact(), pair.contact_ratio() * pair.base_pitch(), 1e-15);
    assert_eq!(pair.turns_until_repeat(), [67, 23]);
}

/// Root, tip and active profile of an internal pair; either gear may drive.
#[test]
fn an_internal_pair_may_be_driven_from_both_sides() {
    let [_, planet, ring] = stage_1();
    let forth = GearPair::at_centre_distance(&planet, &ring, 0.863).unwrap();
    let back = GearPair::at_centre_distance(&ring, &planet, 0.863).unwrap();
    close(forth.contact_ratio(), back.contact_ratio(), 1e-14);
    for i in 0..2 {
        let (one, other) = (forth.active_profile(i), back.active_profile(1 - i));
        close(one[0], other[0], 1e-14);
        close(one[1], other[1], 1e-14);
        let (one, other) = (forth.line_of_contact(i), back.line_of_contact(1 - i));
        close(one[0], other[1], 1e-14);
        close(one[1], other[0], 1e-14);
    }
    let wanted = (TAU * forth.contact_ratio() - forth.pitch_point()).rem_euclid(TAU);
    close(back.pitch_point(), wanted, 1e-12);
    // The ring touches further outside than its tip.
    let [far, tip] = forth.active_profile(1);
    assert!(far > tip && far < ring.root_radius());
}

/// The blank of a ring is the annulus outside its reference circle.
#[test]
fn the_blank_of_an_internal_gear() {
    let ring = InvoluteGear::internal(60, 0.002).unwrap().with_face_width(0.02).unwrap();
    let blank = ring.blank(0.16, 7800.0).unwrap();
    close(blank.mass, 7800.0 * PI * 0.02 * (0.16f64.powi(2) - 0.12f64.powi(2)) / 4.0, 1e-14);
    close(blank.polar_inertia, blank.mass * (0.16f64.powi(2) + 0.12f64.powi(2)) / 8.0, 1e-14);
    let thin = 0.5 * blank.polar_inertia + blank.mass * 0.02f64.powi(2) / 12.0;
    close(blank.transverse_inertia, thin, 1e-15);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Path of contact and contact ratio from the tip circles, the same from both ends; c' from either order.
    #[test]
    fn contact_from_the_tip_circles(
        z in prop::array::uniform2(18u32..150),
        x in prop::array::uniform2(-0.1f64..0.6),
        beta in 0.0f64..0.5,
        internal in any::<bool>(),
    ) {
        let gear = |z: u32, x: f64| external(z, x, 0.003).with_helix_angle(beta).unwrap();
        let (a, b) = (gear(z[0], x[0]), gear(z[1], x[1]));
        let b = if internal {
            let ring = InvoluteGear::internal(z[0] + z[1] + 20, 0.003).unwrap().with_helix_angle(beta).unwrap();
            ring.with_profile_shift(-x[0]).unwrap().with_addendum(0.8).unwrap()
        } else {
            b
        };
        let Ok(pair) = GearPair::new(&a, &b) else { return Ok(()) };
        let sign = if internal { -1.0 } else { 1.0 };
        let tangent = |gear: &InvoluteGear| (gear.tip_radius().powi(2) - gear.base_radius().powi(2)).sqrt();
        let between = pair.centre_distance() * pair.working_pressure_angle().sin();
        let length = tangent(&a) + sign * tangent(&b) - sign * between;
        prop_assert!((length / (pair.contact_ratio() * pair.base_pitch()) - 1.0).abs() < 1e-9);
        prop_assert!(pair.backlash().abs() < 1e-12);
        let [r0, r1] = pair.working_radii();
        let sum = if internal { r1 - r0 } else { r0 + r1 };
        prop_assert!((sum / pair.centre_distance() - 1.0).abs() < 1e-12);
        // Both gears see the same path: its ends are the tips.
        prop_assert!((pair.line_of_contact(0)[1] / tangent(&a) - 1.0).abs() < 1e-12);
        prop_assert!((pair.line_of_contact(1)[0] / tangent(&b) - 1.0).abs() < 1e-12);
        let back = GearPair::new(&b, &a).unwrap();
        prop_assert!((back.contact_ratio() / pair.contact_ratio() - 1.0).abs() < 1e-12);
        if let Ok(found) = MethodB::new().stiffness(&pair) {
            let other = MethodB::new().stiffness(&back).unwrap();
            prop_assert!((other.mesh / found.mesh - 1.0).abs() < 1e-12);
            prop_assert!((other.single / found.single - 1.0).abs() < 1e-15);
        }
    }

    /// Equal gears: the stiffness of a pair of teeth is the same at equal distances from the pitch point, and
    /// the mesh stiffness of per-body foundations is below that of per-pair foundations in double contact only.
    #[test]
    fn equal_gears_are_symmetric(z in 26u32..90, share in 0.0f64..1.0) {
        let gear = external(z, 0.0, 0.002);
        let pair = GearPair::new(&gear, &gear).unwrap();
        let bore = 2.0 * gear.root_radius() / 3.0;
        let method = PotentialEnergy::ma_2014([bore; 2]).unwrap();
        let s = share * pair.contact_ratio();
        let one = method.pair(&pair, s).unwrap();
        let other = method.pair(&pair, pair.contact_ratio() - s).unwrap();
        prop_assert!((one.total() / other.total() - 1.0).abs() < 1e-11);
        prop_assert!((one.teeth[0].total() / other.teeth[1].total() - 1.0).abs() < 1e-11);
        let body = method.foundation(Foundation::PerBody([bore; 2])).unwrap();
        let rigid = method.foundation(Foundation::None).unwrap();
        let end = pair.end_of_double_contact();
        let (double, single) = (0.5 * end, 0.5 * (end + TAU));
        let at = |method: &PotentialEnergy, angle| method.mesh(&pair, angle).unwrap();
        prop_assert!(at(&body, double) < 0.95 * at(&method, double));
        prop_assert!((at(&body, single) / at(&method, single) - 1.0).abs() < 1e-12);
        prop_assert!(at(&method, double) < at(&rigid, double));
    }

    /// No value of any parameter makes a panic or a figure that is not a number.
    #[test]
    fn any_numbers_give_errors_or_finite_figures(
        z in prop::array::uniform2(0u32..300),
        bits in prop::array::uniform8(any::<u64>()),
        wild in any::<u8>(),
        internal in any::<bool>(),
    ) {
        let value = |i: usize, tame: [f64; 2]| {
            let share = bits[i] as f64 / u64::MAX as f64;
            if wild >> i & 1 == 1 { f64::from_bits(bits[i]) } else { tame[0] + share * (tame[1] - tame[0]) }
        };
        let gear = |k: usize, internal: bool| -> Result<InvoluteGear, TeethError> {
            let of = if internal { InvoluteGear::internal } else { InvoluteGear::external };
            Ok(of(z[k], 0.003)?
                .with_profile_shift(value(k, [-3.0, 3.0]))?
                .with_addendum(value(2, [0.1, 3.0]))?
                .with_dedendum(value(3, [0.1, 4.0]))?
                .with_pressure_angle(value(4, [0.1, 0.7]))?
                .with_tip_alteration(value(5, [-0.003, 0.003]))?
                .with_fillet_radius(value(6, [0.0, 0.5]))?
                .allow_undercut())
        };
        let pair = || -> Result<GearPair, TeethError> {
            let (a, b) = (gear(0, false)?, gear(1, internal)?);
            if wild & 128 == 128 {
                return GearPair::at_centre_distance(&a, &b, value(7, [0.05, 0.6]));
            }
            GearPair::new(&a, &b)
        };
        let Ok(pair) = pair() else { return Ok(()) };
        prop_assert!(pair.contact_ratio() >= 1.0 && pair.contact_ratio().is_finite());
        prop_assert!(pair.active_profile(0).iter().chain(&pair.active_profile(1)).all(|r| r.is_finite()));
        if let Ok(found) = MethodB::new().stiffness(&pair) {
            prop_assert!(found.mesh.is_finite());
        }
        for method in [PotentialEnergy::tian_2004(), PotentialEnergy::ma_2014([0.02; 2]).unwrap()] {
            if let Ok(wave) = method.wave(&pair) {
                prop_assert!(wave.mean().is_finite() && wave.mean() > 0.0);
            }
        }
    }
}

// --- waves ------------------------------------------------------------------------------------------------------

#[test]
fn the_series_of_the_rectangular_wave() {
    let example = &read("teeth.json")["rect_fourier"]["example"];
    let (low, high) = (number(&example["kmin"]), number(&example["kmax"]));
    let wave = RectangularWave::of_contact_ratio(number(&example["eps"]), low, high).unwrap();
    let series = wave.series(5).unwrap();
    close(series.mean(), number(&example["a0"]), 1e-15);
    for (pair, a) in series.pairs().iter().zip(numbers(&example["a"])) {
        assert!((pair[0] - a).abs() < 1e-16 && pair[1] == 0.0);
    }
    // The same series by quadrature of pieces.
    let edges = wave.edges();
    let pieces = Piecewise::fit(&edges, 1e-12, |middle, _| Ok::<f64, P>(wave.value(middle % TAU))).unwrap();
    assert!(pieces.error() < 1e-14);
    let fitted = pieces.fourier_series(5).unwrap();
    for (found, expected) in fitted.pairs().iter().zip(series.pairs()) {
        assert!((found[0] - expected[0]).abs() < 1e-14 && (found[1] - expected[1]).abs() < 1e-14);
    }
    // The wave of a pair, turned so that its high part starts at φ = 0.
    let pair = pair_19_48();
    let wave = Wave::new(pair.rectangular(1.0, 2.0).unwrap());
    let wave = wave.with_phase(-PI * pair.contact_ratio().fract()).unwrap();
    let end = pair.end_of_double_contact();
    let at = |angle| wave.value(angle, Side::After);
    assert_eq!([at(1e-6), at(end - 1e-6), at(end + 1e-6), at(TAU - 1e-6)], [2.0, 2.0, 1.0, 1.0]);
}

/// Derivatives, Taylor series and Fourier series of the mesh stiffness are those of the same function.
#[test]
fn derivatives_and_series_of_the_mesh_stiffness() {
    let (pair, method) = (pair_19_48(), PotentialEnergy::tian_2004());
    let stiffness = method.wave(&pair).unwrap();
    assert_eq!(stiffness.edges(), [0.0, pair.end_of_double_contact()]);
    let mesh = |angle| method.mesh(&pair, angle).unwrap();
    let h = 1e-3;
    for angle in [0.5, 2.0, 3.9, 4.5, 6.0] {
        let jet = stiffness.jet(angle);
        close(jet.value, mesh(angle), 1e-11);
        // Differences of order four: error h⁴ f⁽⁵⁾/30.
        let rate = (8.0 * (mesh(angle + h) - mesh(angle - h)) - mesh(angle + 2.0 * h)
            + mesh(angle - 2.0 * h))
            / (12.0 * h);
        assert!((jet.rate - rate).abs() < 1e-9 * jet.value, "{} {rate}", jet.rate);
        let second = (mesh(angle + h) - 2.0 * mesh(angle) + mesh(angle - h)) / (h * h);
        assert!((jet.second - second).abs() < 1e-5 * jet.value, "{} {second}", jet.second);
        let t = 0.05;
        let series = stiffness.jet(gear_dynamics::model::Series::variable(angle, 2.0, 16));
        close(series.value.at(t), mesh(angle + 2.0 * t), 1e-10);
        close(series.rate.at(t), stiffness.jet(angle + 2.0 * t).rate, 1e-6);
    }
    // The coefficients of the series by an independent rule: midpoints, one piece at a time.
    let fitted = stiffness.fourier_series(12).unwrap();
    let end = pair.end_of_double_contact();
    for n in [1usize, 5, 12] {
        let mut sums = [0.0; 2];
        for (from, to) in [(0.0, end), (end, TAU)] {
            let (m, width) = (20_000, (to - from) / 20_000.0);
            for k in 0..m {
                let angle = from + width * (f64::from(k) + 0.5);
                let part = stiffness.value(angle) * width / PI;
                sums = [sums[0] + part * (n as f64 * angle).cos(), sums[1] + part * (n as f64 * angle).sin()];
            }
        }
        for (found, sum) in fitted.pairs()[n - 1].iter().zip(sums) {
            assert!((found - sum).abs() < 1e-7 * stiffness.mean());
        }
    }
}

/// The mesh stiffness in a ring of gears that rattle: Taylor series against DOP853, both with located jumps.
#[test]
fn solvers_run_on_the_mesh_stiffness() {
    let pair = GearPair::new(&external(30, 0.5047, 0.004), &external(30, 0.5047, 0.004)).unwrap();
    let wave = Wave::new(PotentialEnergy::tian_2004().wave(&pair).unwrap());
    let mut params = RingSet { error: 1e-5, ..RingSet::set_a(4, 5000.0) }.params().unwrap();
    for mesh in &mut params.meshes {
        *mesh = Mesh::new(wave.clone(), mesh.error().clone(), *mesh.law());
    }
    let ring = Ring::new(&params).unwrap();
    let start = State::at_rest(ring.dof());
    let end = 8.3 * ring.period();
    let taylor = Taylor::new().rtol(1e-14).end(&ring, &start, end).unwrap();
    let dop = Dop853::new().rtol(1e-13).atol(1e-16).end(&ring, &start, end).unwrap();
    let size = dop.v.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let apart = taylor.v.iter().zip(&dop.v).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
    assert!(apart < 1e-9 * size, "{apart:e} {size:e}");
}

#[test]
fn losses_of_single_teeth() {
    let mesh = Wave::constant(2.0).unwrap();
    let crack = ToothLoss::new(20, 19, 0.25).unwrap();
    let wave = Wave::new(crack.times(mesh.clone()));
    let from = 19.0 * TAU / 20.0;
    let at = |angle: f64, side| wave.value(angle, side);
    assert_eq!((at(from, Side::Before), at(from, Side::After)), (2.0, 1.5));
    assert_eq!((at(TAU, Side::Before), at(TAU, Side::After)), (1.5, 2.0));
    assert_eq!(wave.next_edge(1.0), Some(from));
    // A spall: value and slope are continuous, the mean loss is half the largest one.
    let spall = ToothLoss::new(20, 3, 0.25).unwrap().shape(LossShape::Cosine);
    let (start, end) = (3.0 * TAU / 20.0, 4.0 * TAU / 20.0);
    for edge in [start, end] {
        for angle in [edge - 1e-9, edge + 1e-9] {
            let jet = spall.jet(angle);
            assert!((jet.value - 1.0).abs() < 1e-15 && jet.rate.abs() < 1e-6);
        }
    }
    let n = 1000;
    let mean =
        (0..n).map(|k| spall.value(start + (end - start) * (f64::from(k) + 0.5) / f64::from(n))).sum::<f64>();
    close(mean / f64::from(n), 0.875, 1e-12);
    assert!(ToothLoss::new(20, 3, 0.0).unwrap().edges().is_empty());
}

/// The error without load against a search over all pairs in contact; short reliefs leave none.
#[test]
fn tip_relief_without_load() {
    for (gears, lengths) in [
        ((40, 40), [1.2, 1.4]), // lengths in base pitches
        ((24, 70), [0.9, 0.3]),
        ((24, 70), [0.2, 0.3]),
    ] {
        let gear = |z| external(z, 0.0, 0.003);
        let pair = GearPair::new(&gear(gears.0), &gear(gears.1)).unwrap();
        for parabolic in [false, true] {
            let relief = TipRelief::new([20e-6, 30e-6], lengths.map(|l| l * pair.base_pitch())).unwrap();
            let relief = if parabolic { relief.parabolic() } else { relief };
            let wave = relief.unloaded_error(&pair).unwrap();
            assert!(wave.error() < 1e-12);
            for k in 0..500 {
                let s = (f64::from(k) + 0.37) / 500.0;
                let places = (0..3).map(|i| s + f64::from(i)).filter(|s| *s <= pair.contact_ratio());
                let least = places.map(|s| relief.at(&pair, s).unwrap()).fold(f64::INFINITY, f64::min);
                assert!((wave.value(TAU * s) - least).abs() < 1e-17, "{s} {lengths:?}");
            }
            let lone = 2.0 - pair.contact_ratio();
            assert!(lone > 0.0);
            let largest = (0..100).map(|k| wave.value(0.0628 * f64::from(k))).fold(0.0, f64::max);
            assert_eq!(largest == 0.0, lengths == [0.2, 0.3], "{largest}");
        }
    }
}

/// Tolerances of class 5 of the standard's formulas, and their ratio √2 from class to class.
#[test]
fn tolerances_of_quality_grades() {
    let gear = external(100, 0.0, 0.004); // d = 400 mm
    let five = QualityGrade::new(5).unwrap().tolerances(&gear).unwrap();
    let micro = |length: f64| 1e6 * length;
    close(micro(five.single_pitch), 0.4 + 1.6 + 5.0, 1e-14);
    close(micro(five.cumulative_pitch), 0.8 + 11.0 + 2.8 + 12.0, 1e-14);
    close(micro(five.profile_form), 2.2 + 5.0, 1e-14);
    close(micro(five.profile_slope), 1.6 + 0.4 + 4.0, 1e-14);
    close(micro(five.total_profile), 7.2f64.hypot(6.0), 1e-14);
    close(micro(five.runout), 0.9 * 26.6, 1e-14);
    for grade in 1..=11 {
        let found = QualityGrade::new(grade).unwrap();
        assert_eq!(found.grade(), grade);
        let scale = 2f64.powf((f64::from(grade) - 5.0) / 2.0);
        close(found.tolerances(&gear).unwrap().single_pitch, scale * five.single_pitch, 1e-14);
    }
    for (value, rounded) in
        [(23.94e-6, 24e-6), (7.24e-6, 7e-6), (7.26e-6, 7.5e-6), (4.96e-6, 5e-6), (4.94e-6, 4.9e-6)]
    {
        close(Tolerances::rounded(value), rounded, 1e-14);
    }
}

#[test]
fn transmission_errors_over_the_common_period() {
    let pair = GearPair::new(&external(20, 0.0, 0.004), &external(50, 0.0, 0.004)).unwrap();
    assert_eq!(pair.turns_until_repeat(), [5, 2]);
    let error = TransmissionError::of_harmonics(&[[5e-6, 0.3], [1e-6, 0.0]]).unwrap();
    let error = error.with_eccentricity([10e-6, 20e-6], [0.0, 1.0]).unwrap();
    let sum = error.over_common_period(&pair).unwrap();
    for angle in [0.0, 0.4, 3.0] {
        let (first, second) = (5.0 * angle, 2.0 * angle);
        let tooth = 20.0 * first;
        let expected = 5e-6 * (tooth + 0.3).cos()
            + 1e-6 * (2.0 * tooth).cos()
            + 10e-6 * first.sin()
            + 20e-6 * (second + 1.0).sin();
        assert!((sum.value(angle) - expected).abs() < 1e-18);
    }
    let grade = QualityGrade::new(7).unwrap();
    let error = TransmissionError::of_grade(&pair, [grade; 2]).unwrap();
    let profile = |i: usize| grade.tolerances(&pair.gears()[i]).unwrap().total_profile;
    close(2.0 * error.tooth().pairs()[0][1], profile(0).hypot(profile(1)), 1e-15);
}
