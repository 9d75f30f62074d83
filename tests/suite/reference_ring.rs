//! The ring of Yao 2020 against independently integrated trajectories and frequencies (tests/data/ring.json).

use crate::api::*;
use crate::data::read;
use gear_dynamics::linear::Modes;
use serde_json::Value;

fn number(v: &Value) -> f64 {
    v.as_f64().unwrap()
}

fn list(v: &Value) -> Vec<f64> {
    v.as_array().unwrap().iter().map(number).collect()
}

fn ring(p: &Value) -> Ring {
    let column = |key: &str| list(&p[key]);
    let omega = number(&p["omega"]);
    let wave: Vec<[f64; 2]> = column("a_h").iter().map(|a| [*a, 0.0]).collect();
    let (j, jl, r, ks, cs, tl) =
        (column("J"), column("J_L"), column("R_b"), column("k_s"), column("c_s"), column("T_L"));
    let gear = |i: usize| Gear {
        inertia: j[i],
        base_radius: r[i],
        load: Load { inertia: jl[i], torque: tl[i], shaft: Shaft { stiffness: ks[i], damping: cs[i] } },
    };
    let (kg, cg, b, e, phase) = (column("k_g"), column("c_g"), column("b"), column("e"), column("phase"));
    let mesh = |i: usize| {
        let pairs: Vec<[f64; 2]> = wave.iter().map(|[a, _]| [a * kg[i], 0.0]).collect();
        let stiffness = Wave::new(Fourier::new(kg[i], &pairs).unwrap()).with_phase(phase[i]).unwrap();
        let error = Wave::new(Fourier::new(0.0, &[[0.0, e[i]]]).unwrap()).with_phase(phase[i]).unwrap();
        Mesh::new(stiffness, error, Backlash::new(b[i]).unwrap())
    };
    let params = RingParams {
        motor: Motor {
            inertia: number(&p["J_M"]),
            torque: number(&p["T_M"]),
            shaft: Shaft { stiffness: number(&p["k_M"]), damping: number(&p["c_M"]) },
        },
        gears: (0..j.len()).map(gear).collect(),
        meshes: (0..j.len()).map(mesh).collect(),
        mesh_damping: cg,
        omega,
        teeth: 30,
    };
    Ring::as_printed(&params).unwrap().with_frame(Frame::Rigid)
}

fn compare<M: Model>(model: &M, case: &Value, name: &str) {
    let n = model.dof();
    let atol = [vec![1e-17; n], vec![1e-13; n]].concat();
    compare_with(&Dop853::new().rtol(1e-12).atol_each(&atol), model, case, &format!("{name}, Dop853"));
    compare_with(&Taylor::new().rtol(1e-14), model, case, &format!("{name}, Taylor"));
}

/// Checks angles and rates over the largest value of each, and the mesh forces `[N]`. The bound is 1e-8, and
/// 1e-6 at the end of the rattling run at 5000 r/min.
fn compare_with<I: Integrator, M: Model>(solver: &I, model: &M, case: &Value, name: &str) {
    let n = model.dof();
    let y0 = list(&case["y0"]);
    let start = State::new(0.0, &y0[..n], &y0[n..]);
    let outputs = case["out"].as_array().unwrap();
    let times: Vec<f64> = outputs.iter().map(|o| number(&o["t"])).collect();
    let run = solver.sample(model, &start, &times).unwrap();
    let all: Vec<Vec<f64>> = outputs.iter().map(|o| list(&o["y"])).collect();
    let largest = |range: std::ops::Range<usize>| {
        all.iter().flat_map(|y| y[range.clone()].to_vec()).fold(0.0, |m: f64, x| m.max(x.abs()))
    };
    let (angle, rate) = (largest(0..n), largest(n..2 * n));
    for (i, y) in all.iter().enumerate() {
        let bound = if name.starts_with("n3_e10um_5000rpm_rattle") && times[i] == 0.05 { 1e-6 } else { 1e-8 };
        let worst = |ours: &[f64], theirs: &[f64]| {
            ours.iter().zip(theirs).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()))
        };
        let (dq, dv) = (worst(run.q(i), &y[..n]) / angle, worst(run.v(i), &y[n..]) / rate);
        println!("{name} t = {}: angles {dq:.1e}, rates {dv:.1e}", times[i]);
        assert!(dq < bound && dv < bound, "{name} t = {}: angles {dq:e}, rates {dv:e}", times[i]);
        for (mesh, w) in list(&outputs[i]["W"]).iter().enumerate() {
            let ours = run.channel(model, &format!("mesh force {mesh}")).unwrap()[i];
            assert!(
                (ours - w).abs() < bound * 1e4,
                "{name} t = {}: W{} {ours} against {w}",
                times[i],
                mesh + 1
            );
        }
    }
}

#[test]
fn every_trajectory() {
    let data = read("ring.json");
    for (name, case) in data["trajectories"].as_object().unwrap() {
        let ring = ring(&case["params"]);
        assert!((ring.rigid_acceleration() - number(&case["alpha"])).abs() < 1e-9, "{name}");
        let held = &case["C_gDelta"];
        if held.is_null() {
            compare(&ring, case, name);
        } else {
            let process = HeldProcess::of_values(number(&held["hold_s"]), &list(&held["values"])).unwrap();
            let scale = number(&held["scale_Ns_per_m"]);
            let slot = |i: usize| (ring.slot(&format!("mesh damping {i}")).unwrap(), scale);
            let slots: Vec<(usize, f64)> = (0..ring.gears()).map(slot).collect();
            let noisy = Noisy::new(ring).add(&slots, &process).unwrap();
            compare(&noisy, case, name);
        }
    }
}

#[test]
fn the_presets_are_the_reference_parameters() {
    let data = read("ring.json");
    let cases = &data["trajectories"];
    for (name, set) in [
        ("n3_b2.65e-5_e1um_1000rpm", RingSet::set_a(3, 1000.0)),
        ("n3_e10um_5000rpm_rattle", RingSet { error: 1e-5, ..RingSet::set_a(3, 5000.0) }),
        ("E_n3_b2.65e-5_e0.2um_1000rpm", RingSet::set_e(3, 1000.0)),
    ] {
        let preset = Ring::as_printed(&set.params().unwrap()).unwrap().with_frame(Frame::Rigid);
        let given = ring(&cases[name]["params"]);
        let (mut u, mut w) = (vec![0.0; preset.drives()], vec![0.0; given.drives()]);
        for t in [0.0, 1.3e-3, 7.7e-3] {
            preset.drive(t, Side::After, &mut u);
            given.drive(t, Side::After, &mut w);
            for (slot, (a, b)) in u.iter().zip(&w).enumerate() {
                assert!((a - b).abs() <= 1e-12 * b.abs() + 1e-17, "{name}: drive {slot} is {a} against {b}");
            }
        }
        assert!((preset.mass_matrix() - given.mass_matrix()).amax() < 1e-15, "{name}");
        let mean = given.mean_mesh_stiffness();
        let k = given.stiffness_matrix(&mean).unwrap();
        assert!(
            (preset.stiffness_matrix(&preset.mean_mesh_stiffness()).unwrap() - &k).amax() < 1e-9 * k.amax(),
            "{name}"
        );
        assert!((preset.damping_matrix() - given.damping_matrix()).amax() < 1e-12, "{name}");
    }
}

#[test]
fn natural_frequencies() {
    for (n, linear) in read("ring.json")["linear"].as_object().unwrap() {
        let set = RingSet::set_a(n.parse().unwrap(), 1000.0);
        let ring = Ring::as_printed(&set.params().unwrap()).unwrap();
        let modes = Modes::mean_in_contact(&ring).unwrap();
        let expected = list(&linear["freq_hz"]);
        assert_eq!(modes.frequencies().len(), expected.len());
        assert!(modes.hertz()[0] < 1e-3);
        for (ours, theirs) in modes.hertz().iter().zip(&expected).skip(1) {
            assert!((ours / theirs - 1.0).abs() < 1e-8, "n = {n}: {ours} against {theirs}");
        }
        // K φ = ω² M φ.
        let (m, k) = (ring.mass_matrix(), ring.stiffness_matrix(&ring.mean_mesh_stiffness()).unwrap());
        for mode in modes.all() {
            let (phi, w) = (nalgebra::DVector::from_column_slice(mode.shape()), mode.frequency());
            assert!((&k * &phi - &m * &phi * (w * w)).amax() < 1e-10 * k.amax());
        }
        for (ours, theirs) in modes.eigenvalues().iter().zip(linear["damped"].as_array().unwrap()) {
            assert!(
                (ours.norm() / std::f64::consts::TAU / number(&theirs["f_hz"]) - 1.0).abs() < 1e-8,
                "n = {n}"
            );
            assert!((-ours.re / ours.norm() / number(&theirs["zeta"]) - 1.0).abs() < 1e-6, "n = {n}");
        }
    }
}
