//! Trains at varying speed against an independent integration of their absolute angles.

use crate::api::*;
use gear_dynamics::models::Oscillator;
use gear_dynamics::trains::*;
use gear_dynamics::{Ring, Wave};
use std::f64::consts::TAU;

/// A mesh of the reference: bodies, base radii, teeth of the first gear, mean stiffness, damping, half backlash.
struct AbsoluteMesh {
    ends: [usize; 2],
    radii: [f64; 2],
    teeth: f64,
    stiffness: f64,
    damping: f64,
    half: f64,
}

/// A torsional train in absolute angles θ, each along the rotation of its body.
///
/// J θ'' = T - Σ ± r W - shafts. The reference body is prescribed, or the torque Σ J R² α acts on it.
struct Absolute {
    inertias: Vec<f64>,
    torques: Vec<f64>,
    /// Ideal speeds over that of the reference body.
    ratios: Vec<f64>,
    reference: usize,
    meshes: Vec<AbsoluteMesh>,
    shafts: Vec<([usize; 2], f64, f64)>,
    prescribed: bool,
}

/// Share of the mean by which the mesh stiffness varies over its teeth.
const RIPPLE: f64 = 0.2;

impl Absolute {
    /// θ'' from θ and θ', at the ideal angle, speed and acceleration of the reference body.
    fn accel(&self, ideal: [f64; 3], y: &[f64]) -> Vec<f64> {
        let n = self.inertias.len();
        let (q, v) = y.split_at(n);
        let (mut q, mut v, mut sums) = (q.to_vec(), v.to_vec(), self.torques.clone());
        if self.prescribed {
            (q[self.reference], v[self.reference]) = (ideal[0], ideal[1]);
        } else {
            let inertia: f64 = self.inertias.iter().zip(&self.ratios).map(|(j, r)| j * r * r).sum();
            sums[self.reference] += inertia * ideal[2];
        }
        for mesh in &self.meshes {
            let ([i, j], [r, s]) = (mesh.ends, mesh.radii);
            let (d, rate) = (r * q[i] - s * q[j], r * v[i] - s * v[j]);
            let gap = if d > mesh.half {
                d - mesh.half
            } else if d < -mesh.half {
                d + mesh.half
            } else {
                0.0
            };
            let angle = mesh.teeth * self.ratios[i] * ideal[0];
            let w = mesh.stiffness * (1.0 + RIPPLE * angle.cos()) * gap + mesh.damping * rate;
            sums[i] -= r * w;
            sums[j] += s * w;
        }
        for &([i, j], stiffness, damping) in &self.shafts {
            let torque = stiffness * (q[i] - q[j]) + damping * (v[i] - v[j]);
            sums[i] -= torque;
            sums[j] += torque;
        }
        sums.iter().zip(&self.inertias).map(|(sum, j)| sum / j).collect()
    }

    /// Deviations of the angles from the ideal rotation at the given times, by RK4 with steps of about `h`.
    fn run(&self, ideal: &dyn Fn(f64) -> [f64; 3], start: &[f64], times: &[f64], h: f64) -> Vec<Vec<f64>> {
        self.run_seen(ideal, start, times, h, &mut |_, _| ())
    }

    /// Impacts on the lower and on the upper flank of every mesh between two times.
    fn rattle(
        &self,
        ideal: &dyn Fn(f64) -> [f64; 3],
        start: &[f64],
        [from, to]: [f64; 2],
        h: f64,
    ) -> Vec<[u64; 2]> {
        let mut found = vec![[0; 2]; self.meshes.len()];
        let mut sides = vec![0; self.meshes.len()];
        self.run_seen(ideal, start, &[from, to], h, &mut |t, y| {
            for (mesh, (count, side)) in self.meshes.iter().zip(found.iter_mut().zip(&mut sides)) {
                let held = |i: usize| if self.prescribed && i == self.reference { ideal(t)[0] } else { y[i] };
                let d = mesh.radii[0] * held(mesh.ends[0]) - mesh.radii[1] * held(mesh.ends[1]);
                let now = i32::from(d > mesh.half) - i32::from(d < -mesh.half);
                if now != *side && now != 0 && t > from {
                    count[usize::from(now > 0)] += 1;
                }
                *side = now;
            }
        });
        found
    }

    /// [`run`](Absolute::run); `seen` receives the time and the state after every step.
    fn run_seen(
        &self,
        ideal: &dyn Fn(f64) -> [f64; 3],
        start: &[f64],
        times: &[f64],
        h: f64,
        seen: &mut dyn FnMut(f64, &[f64]),
    ) -> Vec<Vec<f64>> {
        let n = self.inertias.len();
        let [_, speed, _] = ideal(0.0);
        let mut y: Vec<f64> = start.to_vec();
        y.extend(self.ratios.iter().map(|r| r * speed));
        let rate = |t: f64, y: &[f64]| [&y[n..], &self.accel(ideal(t), y)[..]].concat();
        let plus = |y: &[f64], k: &[f64], h: f64| y.iter().zip(k).map(|(y, k)| y + h * k).collect::<Vec<_>>();
        let mut t = 0.0;
        let mut found = Vec::new();
        for &to in times {
            let steps = ((to - t) / h).ceil();
            let h = (to - t) / steps;
            for _ in 0..steps as usize {
                let k1 = rate(t, &y);
                let k2 = rate(t + 0.5 * h, &plus(&y, &k1, 0.5 * h));
                let k3 = rate(t + 0.5 * h, &plus(&y, &k2, 0.5 * h));
                let k4 = rate(t + h, &plus(&y, &k3, h));
                for (i, y) in y.iter_mut().enumerate() {
                    *y += h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
                }
                t += h;
                seen(t, &y);
            }
            t = to;
            let [angle, ..] = ideal(t);
            let held = |i: usize| self.prescribed && i == self.reference;
            let deviation = |i: usize| if held(i) { 0.0 } else { y[i] - self.ratios[i] * angle };
            found.push((0..n).map(deviation).collect());
        }
        found
    }
}

/// θ, θ' and θ'' of a speed ω (1 + a cos ft).
fn swinging(speed: f64, swing: f64, f: f64) -> impl Fn(f64) -> [f64; 3] {
    move |t| {
        let (sin, cos) = (f * t).sin_cos();
        [speed * (t + swing * sin / f), speed * (1.0 + swing * cos), -speed * swing * f * sin]
    }
}

/// θ, θ' and θ'' of a run-up.
fn running(from: f64, to: f64, duration: f64) -> impl Fn(f64) -> [f64; 3] {
    let slope = (to - from) / duration;
    move |t| {
        let ramp = t.min(duration);
        let angle = from * ramp + 0.5 * slope * ramp * ramp + to * (t - ramp);
        [angle, from + slope * ramp, if t < duration { slope } else { 0.0 }]
    }
}

/// The deviations of the angles by a solver of the crate at the given times.
fn of_crate<I: Integrator, M: Model>(solver: &I, model: &M, start: &[f64], times: &[f64]) -> Vec<Vec<f64>> {
    let mut state = State::new(0.0, start, &vec![0.0; start.len()]);
    let step = |&t: &f64| {
        state = solver.end(model, &state, t).unwrap();
        state.q.clone()
    };
    times.iter().map(step).collect()
}

const HALF: f64 = 2e-5;

fn mesh(teeth: [u32; 2], radii: [f64; 2], stiffness: f64, damping: f64) -> MeshPart {
    let wave = Fourier::new(stiffness, &[[RIPPLE * stiffness, 0.0]]).unwrap();
    MeshPart::external(teeth, radii, Wave::new(wave)).damping(damping).half_backlash(HALF).phase(0.0)
}

fn absolute_mesh(
    ends: [usize; 2],
    radii: [f64; 2],
    teeth: f64,
    stiffness: f64,
    damping: f64,
) -> AbsoluteMesh {
    AbsoluteMesh { ends, radii, teeth, stiffness, damping, half: HALF }
}

/// A pinion of 20 teeth and a wheel of 40 teeth, 1e-3 kg m², which 1 N m drags.
fn spur_pair(pinion: Body) -> Parts {
    let mut parts = Parts::new();
    parts.body("pinion", pinion).body("wheel", Body::new(1e-3));
    parts.mesh("mesh", "pinion", "wheel", mesh([20, 40], [0.03, 0.06], 2e7, 40.0));
    parts.torque("drag", "wheel", -1.0);
    parts
}

fn absolute_pair(pinion: f64, torque: f64, prescribed: bool) -> Absolute {
    Absolute {
        inertias: vec![pinion, 1e-3],
        torques: vec![torque, -1.0],
        ratios: vec![1.0, 0.5],
        reference: 0,
        meshes: vec![absolute_mesh([0, 1], [0.03, 0.06], 20.0, 2e7, 40.0)],
        shafts: Vec::new(),
        prescribed,
    }
}

/// Largest distance of the deflections d = rows · q `[m]` and their largest peak to peak value.
fn distance(one: &[Vec<f64>], row: &[f64], other: &[Vec<f64>], of: &[f64]) -> [f64; 2] {
    let along = |q: &[f64], row: &[f64]| q.iter().zip(row).map(|(q, r)| q * r).sum::<f64>();
    let (mut apart, mut low, mut high) = (0.0f64, f64::INFINITY, f64::NEG_INFINITY);
    for (one, other) in one.iter().zip(other) {
        let [d, e] = [along(one, row), along(other, of)];
        apart = apart.max((d - e).abs());
        (low, high) = (low.min(e), high.max(e));
    }
    [apart, high - low]
}

/// ± 5 % of order 6 at 100 rad/s on a pinion: 1.5 N m of inertia torque on the wheel against a drag of 1 N m. The
/// pair rattles between both flanks, with a prescribed pinion and with a free one.
#[test]
fn a_fluctuating_speed_rattles() {
    let law = SpeedLaw::fluctuation(100.0, 0.05, 600.0).unwrap();
    let ideal = swinging(100.0, 0.05, 600.0);
    let times: Vec<f64> = (1..=60).map(|k| 0.5e-3 * f64::from(k)).collect();
    // On the flank that the drag loads.
    let start = -(HALF + 1.0 / 0.06 / 2e7 / (1.0 + RIPPLE)) / 0.06;
    for prescribed in [true, false] {
        let (pinion, torque) = if prescribed { (1.0, 0.0) } else { (2e-3, 0.5) };
        let reference = absolute_pair(pinion, torque, prescribed);
        let fine = reference.run(&ideal, &[0.0, start], &times, 1e-6);
        let coarse = reference.run(&ideal, &[0.0, start], &times, 2e-6);
        let row = [0.03, -0.06];
        let body = if prescribed { Body::new(pinion).prescribed() } else { Body::new(pinion) };
        let mut parts = spur_pair(body);
        if !prescribed {
            parts.torque("drive", "pinion", torque);
        }
        let train = parts.build("pinion", 100.0).unwrap();
        assert_eq!(train.dof(), 1);
        // The coordinate is that of the wheel, or the angle of the pinion relative to it.
        let (own, start) = if prescribed { (-0.06, start) } else { (0.03, -2.0 * start) };
        let model = VaryingSpeed::new(train.clone(), law.clone());
        let by_dop = of_crate(&Dop853::new().rtol(1e-11).atol(1e-16), &model, &[start], &times);
        let by_taylor = of_crate(&Taylor::new().rtol(1e-12).atol(1e-17), &model, &[start], &times);
        let [error, _] = distance(&coarse, &row, &fine, &row);
        let [apart, ppv] = distance(&by_dop, &[own], &fine, &row);
        let [series, _] = distance(&by_taylor, &[own], &fine, &row);
        println!(
            "prescribed {prescribed}: ppv {ppv:.3e}, {apart:.1e}, {series:.1e}, steps of RK4 {error:.1e}"
        );
        // The steps of the reference cross the edges of the gap: its own error bounds the distance.
        assert!(apart < 3.0 * error.max(1e-6 * ppv) && series < 3.0 * error.max(1e-6 * ppv));
        assert!(error < 1e-2 * ppv && ppv > 2.0 * HALF, "{ppv}");
        // At constant speed it does not rattle.
        let still = VaryingSpeed::new(train, SpeedLaw::constant(100.0).unwrap());
        let rest = of_crate(&Dop853::new().rtol(1e-9).atol(1e-14), &still, &[start], &times);
        let low = rest.iter().fold(f64::INFINITY, |low, q| low.min(own * q[0]));
        assert!(low > HALF, "{low}");
    }
}

/// A gearbox at idle: the input turns at 800 r/min ± 3 % of order 2, a countershaft and a loose gear are dragged. Both
/// meshes rattle between both flanks, as often as the reference finds.
#[test]
fn a_gearbox_at_idle_rattles_on_both_flanks() {
    let speed = 800.0 * TAU / 60.0;
    let law = SpeedLaw::fluctuation(speed, 0.03, 2.0 * speed).unwrap();
    let ideal = swinging(speed, 0.03, 2.0 * speed);
    // Countershaft and loose gear: inertias and drags.
    let ([j1, j2], [m1, m2]) = ([1.5e-3, 2e-3], [-0.1, -0.3]);
    let ratios = [1.0, 25.0 / 35.0, 25.0 / 35.0 * 30.0 / 28.0];
    let reference = Absolute {
        inertias: vec![1.0, j1, j2],
        torques: vec![0.0, m1, m2],
        ratios: ratios.to_vec(),
        reference: 0,
        meshes: vec![
            absolute_mesh([0, 1], [0.03, 0.042], 25.0, 2e7, 600.0),
            absolute_mesh([1, 2], [0.036, 0.0336], 30.0, 2e7, 600.0),
        ],
        shafts: Vec::new(),
        prescribed: true,
    };
    let mut parts = Parts::new();
    parts.body("input", Body::new(1.0).prescribed());
    parts.body("countershaft", Body::new(j1)).body("loose gear", Body::new(j2));
    parts.mesh("constant mesh", "input", "countershaft", mesh([25, 35], [0.03, 0.042], 2e7, 600.0));
    parts.mesh("first gear", "countershaft", "loose gear", mesh([30, 28], [0.036, 0.0336], 2e7, 600.0));
    parts.torque("drag 1", "countershaft", m1).torque("drag 2", "loose gear", m2);
    let model = VaryingSpeed::new(parts.build("input", speed).unwrap(), law.clone());
    let start = State::new(0.0, &[-HALF / 0.042, -2.0 * HALF / 0.0336], &[0.0, 0.0]);
    let [from, to] = [0.2, 0.7];
    let mut rattle = Rattle::new(&model);
    let solver = Dop853::new().rtol(1e-9).atol(1e-14);
    let settled = solver.end(&model, &start, from).unwrap();
    solver.run(&model, &settled, to, &mut rattle).unwrap();
    let ours: Vec<[u64; 2]> = rattle.contacts().iter().map(|contact| contact.impacts).collect();
    let [fine, coarse] =
        [2e-6, 4e-6].map(|h| reference.rattle(&ideal, &[0.0, start.q[0], start.q[1]], [from, to], h));
    println!("{ours:?}, reference {fine:?}, at twice the step {coarse:?}");
    assert!(ours == fine && fine == coarse);
    // Whichever body is the reference, the prescribed one drives the others.
    for (body, ratio) in [("countershaft", ratios[1]), ("loose gear", ratios[2])] {
        let train = parts.build(body, ratio * speed).unwrap();
        let model = VaryingSpeed::of_body(train, "input", law.clone()).unwrap();
        let mut rattle = Rattle::new(&model);
        solver.run(&model, &solver.end(&model, &start, from).unwrap(), to, &mut rattle).unwrap();
        let found: Vec<[u64; 2]> = rattle.contacts().iter().map(|contact| contact.impacts).collect();
        assert_eq!(found, ours, "{body}");
    }
    assert!(ours.iter().flatten().all(|impacts| *impacts > 10));
}

/// The motor of a two-stage train runs from 500 to 12 000 r/min, whatever angle the waves have, in inertial and in
/// relative coordinates.
#[test]
fn a_run_up_is_that_of_the_reference_body() {
    let rpm = TAU / 60.0;
    let (from, to, duration) = (500.0 * rpm, 12_000.0 * rpm, 0.1);
    let (first, second) = ([0.0115, 0.0335], [0.021, 0.075]);
    let inertias = [1e-3, 2e-3, 5e-4, 8e-3];
    let ratios = vec![1.0, 23.0 / 67.0, 23.0 / 67.0, 23.0 / 67.0 * 21.0 / 75.0];
    let load = 2.0 / ratios[3];
    let meshes = [mesh([23, 67], first, 2e7, 300.0), mesh([21, 75], second, 2e7, 300.0)];
    let mut parts = two_stage(inertias, ShaftPart::new(2e3).damping(0.2), meshes);
    parts.torque("drive", "pinion 1", 2.0).torque("load", "wheel 2", -load);
    let relative = parts.build("pinion 1", from).unwrap();
    let inertial = parts.clone().coordinates(Coordinates::Inertial).build("pinion 1", from).unwrap();
    let law = SpeedLaw::ramp(from, to, duration).unwrap();
    let times: Vec<f64> = (1..=24).map(|k| 5e-3 * f64::from(k)).collect();

    // The waves have the tooth frequencies of the motor, and a body that is named has its own law.
    let ratio = relative.shape().ratio();
    let by_motor = VaryingSpeed::new(relative.clone(), law.clone());
    let slow = SpeedLaw::ramp(from * ratios[3], to * ratios[3], duration).unwrap();
    let by_wheel = VaryingSpeed::of_body(relative.clone(), "wheel 2", slow).unwrap();
    let waves = relative.size().waves;
    let [mut u, mut w] = [vec![0.0; relative.drives()], vec![0.0; relative.drives()]];
    for &t in &times {
        by_motor.drive(t, Side::After, &mut u);
        by_wheel.drive(t, Side::After, &mut w);
        let [angle, speed, acceleration] = running(from, to, duration)(t);
        let stiffness = 2e7 * (1.0 + RIPPLE * (23.0 * angle).cos());
        assert!((u[0] / stiffness - 1.0).abs() < 1e-9, "{t}: {} {stiffness}", u[0]);
        assert!((u[waves] / (ratio * speed) - 1.0).abs() < 1e-12);
        assert!((u[waves + 1] - ratio * acceleration).abs() < 1e-9 * speed);
        assert!(u.iter().zip(&w).all(|(u, w)| (u - w).abs() <= 1e-9 * u.abs()), "{u:?} {w:?}");
    }
    let nobody = VaryingSpeed::of_body(relative.clone(), "axle", law.clone()).unwrap_err();
    assert_eq!(
        nobody.to_string(),
        "the machine names no body \"axle\" that turns evenly; there are: pinion 1, wheel 1, pinion 2, wheel 2"
    );

    let reference = Absolute {
        inertias: inertias.to_vec(),
        torques: vec![2.0, 0.0, 0.0, -load],
        ratios: ratios.clone(),
        reference: 0,
        meshes: vec![
            absolute_mesh([0, 1], first, 23.0, 2e7, 300.0),
            absolute_mesh([2, 3], second, 21.0, 2e7, 300.0),
        ],
        shafts: vec![([1, 2], 2e3, 0.2)],
        prescribed: false,
    };
    // The teeth begin on their drive flanks.
    let d = [2.0 / first[0], load / second[1]].map(|w| HALF + w / 2e7 / (1.0 + RIPPLE));
    let wheel = -d[0] / first[1];
    let pinion = wheel - load * second[0] / second[1] / 2e3;
    let start = [0.0, wheel, pinion, (second[0] * pinion - d[1]) / second[1]];
    let fine = reference.run(&running(from, to, duration), &start, &times, 1e-6);
    let coarse = reference.run(&running(from, to, duration), &start, &times, 2e-6);
    let solver = Dop853::new().rtol(1e-10).atol(1e-14);
    let run = of_crate(&solver, &VaryingSpeed::new(inertial, law.clone()), &start, &times);
    let of_last: Vec<f64> = (0..3).map(|j| start[j] - ratios[j] / ratios[3] * start[3]).collect();
    let without = of_crate(&solver, &by_motor, &of_last, &times);
    for (row, kept) in [
        ([first[0], -first[1], 0.0, 0.0], [first[0], -first[1], 0.0]),
        ([0.0, 0.0, second[0], -second[1]], [0.0, 0.0, second[0]]),
    ] {
        let [apart, ppv] = distance(&run, &row, &fine, &row);
        let [other, _] = distance(&without, &kept, &fine, &row);
        let [error, _] = distance(&coarse, &row, &fine, &row);
        println!("deflections over {ppv:.2e}: {apart:.1e}, relative {other:.1e}, steps of RK4 {error:.1e}");
        // The steps of the reference cross the edges of the gap: its own error bounds the distance.
        let bound = 3.0 * error.max(1e-6 * ppv);
        assert!(apart < bound && other < bound && error < 1e-2 * ppv);
    }
    // The motor stays at the law within the windup: 500 r/min without the torque that accelerates it.
    let windup = run.iter().fold(0.0f64, |most, q| most.max(q[0].abs()));
    assert!(windup < 1e-2, "{windup}");
}

/// A run-up of order 23 is a line at order 23 of the motor.
#[test]
fn orders_are_those_of_the_reference_body() {
    let meshes = [mesh([23, 67], [0.0115, 0.0335], 2e7, 300.0), mesh([21, 75], [0.021, 0.075], 2e7, 300.0)];
    let mut parts = two_stage([1e-3, 2e-3, 5e-4, 8e-3], ShaftPart::new(2e3).damping(0.2), meshes);
    let train = parts.torque("drive", "pinion 1", 2.0).load("wheel 2").build("pinion 1", 100.0).unwrap();
    let start = linear_start(&train);
    let run_up = VaryingSpeed::new(train, SpeedLaw::ramp(100.0, 130.0, 0.4).unwrap());
    let solver = Dop853::new().rtol(1e-7).atol(1e-12);
    let lines = Waterfall::new(1, 256).unwrap().run(&solver, &run_up, &start, 0.4, "mesh force 0").unwrap();
    assert_eq!(lines.len(), 7); // 46 rad
    for line in &lines {
        assert!((95.0..135.0).contains(&line.speed), "{}", line.speed);
        let most = (5..60).max_by(|&i, &j| line.amplitudes[i].total_cmp(&line.amplitudes[j])).unwrap();
        assert_eq!(most, 23);
    }
}

fn linear_start(train: &Train) -> State {
    gear_dynamics::linear::static_state(train, 0.0).unwrap().state
}

/// A ring and its parts, each with a law of its own angle, have the same accelerations.
#[test]
fn a_ring_and_its_parts_accelerate_alike() {
    let set = RingSet { motor_torque: 8.0, ..RingSet::set_a(4, 1000.0) };
    let params = set.params().unwrap();
    let ring = Ring::new(&params).unwrap();
    let teeth = f64::from(set.teeth);
    let mut parts = ring_parts(&params, set.teeth).unwrap();
    let train = parts.coordinates(Coordinates::Inertial).build("motor", params.omega / teeth).unwrap();
    let law = |scale: f64| SpeedLaw::fluctuation(params.omega * scale, 0.1, 40.0).unwrap();
    let (ring, train) = (VaryingSpeed::new(ring, law(1.0)), VaryingSpeed::new(train, law(1.0 / teeth)));
    // The same angles in the order of the parts: motor, then gears and loads.
    let q: Vec<f64> = (0..9).map(|i| 1e-3 * f64::from(i).sin()).collect();
    let v: Vec<f64> = (0..9).map(|i| f64::from(i).cos()).collect();
    for t in [0.0, 0.013, 0.4] {
        let [a, b] = [accelerations(&ring, t, &q, &v), accelerations(&train, t, &q, &v)];
        let size = a.iter().fold(0.0f64, |most, a| most.max(a.abs()));
        for (a, b) in a.iter().zip(&b) {
            assert!((a - b).abs() < 1e-9 * size, "{a} {b}");
        }
    }
    // At rest and without torques, a load lags behind by its inertia.
    let idle = Ring::new(&RingSet { motor_torque: 0.0, load_torque: 0.0, ..set.clone() }.params().unwrap());
    let bare = idle.unwrap();
    let idle = VaryingSpeed::new(bare.clone(), law(1.0));
    let t = 0.02;
    let a = accelerations(&idle, t, &[0.0; 9], &[0.0; 9]);
    let lag = -law(1.0 / teeth).acceleration(t, Side::After);
    assert!((a[2] - lag).abs() < 1e-12 * lag.abs(), "{} {lag}", a[2]);
}

fn accelerations<M: Model>(model: &M, t: f64, q: &[f64], v: &[f64]) -> Vec<f64> {
    let (mut u, mut a) = (vec![0.0; model.drives()], vec![0.0; model.dof()]);
    model.drive(t, Side::After, &mut u);
    model.accel(&u, q, v, &mut a);
    a
}

/// The face gear pair of parts against `NfgPair2` with a constant torque, at a varying speed: θ'' = R φ'' + R' φ'² of
/// the gear. The parts have the torque on the pinion that accelerates both, I1 + I2 (R/i)² times its acceleration.
#[test]
fn noncircular_gears_are_accelerated_along_their_uneven_rotation() {
    let (params, i) = (NfgParams::table1(), NfgParams::table1().ratio);
    let torque = params.load_torque / i;
    let pair = NfgPair2::new(&params, 0.01).unwrap().with_torque(torque).unwrap();
    let mut parts = nfg_parts(&params, 0.01).unwrap();
    let train = parts.accept(Warning::Drifts).build("pinion", params.speed).unwrap();
    let law = |scale: f64| SpeedLaw::ramp(40.0 * scale, 60.0 * scale, 4.0).unwrap();
    let (pair, train) = (VaryingSpeed::new(pair, law(1.0)), VaryingSpeed::new(train, law(i)));
    let beta = InstantCentre::new(params.eccentric_ratio).unwrap().radius(1.0).unwrap();
    let beta = Wave::new(beta).value(0.0, Side::After) - 1.0;
    for k in 0..50 {
        let t = 0.07 * f64::from(k);
        let (q, v) = ([2e-3 * (1.3 * t).sin(), 1e-3], [0.3, 0.2 * t.cos()]);
        let [ours, theirs] = [accelerations(&train, t, &q, &v), accelerations(&pair, t, &q, &v)];
        let x = law(1.0).angle(t);
        let r = (1.0 - beta * beta).sqrt() / (1.0 + beta * x.cos());
        let driven = 5.0 * i * (0.01 + params.inertia * (r / i).powi(2)) / 0.01;
        let size = 1.0 + theirs.iter().fold(driven, |most, a| most.max(a.abs()));
        assert!((ours[0] - driven - theirs[0]).abs() < 1e-9 * size, "{t}: {ours:?} {theirs:?} {driven}");
        assert!((ours[1] - theirs[1]).abs() < 1e-9 * size, "{t}: {ours:?} {theirs:?}");
    }
}

/// A torque, a drag or a support of a prescribed body is refused; its inertia has no effect. Names of bodies that a law
/// cannot find are listed.
#[test]
fn a_prescribed_body_takes_no_torque() {
    for (held, part) in [(Body::new(1.0).drag(1.0), "drag"), (Body::new(1.0).restrained(1e3, 0.0), "support")]
    {
        let error = spur_pair(held.prescribed()).build("pinion", 100.0).unwrap_err().to_string();
        assert!(error.contains(part) && error.contains("prescribed"), "{error}");
    }
    let massless = spur_pair(Body::new(0.0).prescribed()).build("pinion", 100.0).unwrap();
    assert_eq!(massless, spur_pair(Body::new(1.0).prescribed()).build("pinion", 100.0).unwrap());
    let law = SpeedLaw::constant(100.0).unwrap();
    let error = VaryingSpeed::of_body(massless, "motor", law).unwrap_err().to_string();
    assert!(error.contains("\"motor\"") && error.ends_with("there are: pinion, wheel"), "{error}");
    let mut parts = spur_pair(Body::new(1.0).prescribed());
    let error = parts.torque("drive", "pinion", 0.5).build("pinion", 100.0).unwrap_err();
    assert!(matches!(&error, TrainError::Prescribed { part, body } if part == "drive" && body == "pinion"));
}

/// Chains of up to three stages with random teeth, inertias, shafts and reference bodies: the accelerations are those of
/// the absolute angles, in 600 states.
#[test]
fn random_trains_accelerate_as_their_absolute_angles() {
    let mut seed = 0x5EED_u64;
    let mut next = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut worst = 0.0f64;
    for case in 0..200 {
        let stages = 1 + case % 3;
        let n = 2 * stages;
        let inertias: Vec<f64> = (0..n).map(|_| 1e-3 * (1.0 + 9.0 * next())).collect();
        let (mut meshes, mut shafts) = (Vec::new(), Vec::new());
        let mut speeds = vec![1.0; n];
        let mut parts = Parts::new();
        let reference = (next() * n as f64) as usize;
        let prescribed = next() < 0.3;
        for (i, inertia) in inertias.iter().enumerate() {
            let body = Body::new(*inertia);
            let held = prescribed && i == reference;
            parts.body(&format!("body {i}"), if held { body.prescribed() } else { body });
        }
        for stage in 0..stages {
            let (i, j) = (2 * stage, 2 * stage + 1);
            let teeth = [(); 2].map(|()| 17 + (40.0 * next()) as u32);
            let radii = teeth.map(|teeth| 1e-3 * f64::from(teeth));
            let part = mesh(teeth, radii, 2e7, 300.0);
            parts.mesh(&format!("mesh {stage}"), &format!("body {i}"), &format!("body {j}"), part);
            speeds[j] = speeds[i] * f64::from(teeth[0]) / f64::from(teeth[1]);
            meshes.push(absolute_mesh([i, j], radii, f64::from(teeth[0]), 2e7, 300.0));
            if stage + 1 < stages {
                speeds[j + 1] = speeds[j];
                let shaft = ShaftPart::new(3e3).damping(0.5);
                parts.shaft(
                    &format!("shaft {stage}"),
                    &format!("body {j}"),
                    &format!("body {}", j + 1),
                    shaft,
                );
                shafts.push(([j, j + 1], 3e3, 0.5));
            }
        }
        let ratios: Vec<f64> = speeds.iter().map(|speed| speed / speeds[reference]).collect();
        let absolute = Absolute {
            inertias,
            torques: vec![0.0; n],
            ratios: ratios.clone(),
            reference,
            meshes,
            shafts,
            prescribed,
        };
        parts.coordinates(Coordinates::Inertial);
        let train = parts.build(&format!("body {reference}"), 50.0).unwrap();
        let (speed, swing, f) = (20.0 + 50.0 * next(), 0.3 * next(), 200.0 * next() + 10.0);
        let model = VaryingSpeed::new(train, SpeedLaw::fluctuation(speed, swing, f).unwrap());
        let kept = |all: &[f64]| {
            let kept = all.iter().enumerate().filter(|(i, _)| !(prescribed && *i == reference));
            kept.map(|(_, x)| *x).collect::<Vec<f64>>()
        };
        for _ in 0..3 {
            let t = 0.05 * next();
            let q: Vec<f64> = (0..n).map(|_| 4e-3 * (next() - 0.5)).collect();
            let v: Vec<f64> = (0..n).map(|_| next() - 0.5).collect();
            let ideal = swinging(speed, swing, f)(t);
            let mut y: Vec<f64> = q.iter().zip(&ratios).map(|(q, r)| r * ideal[0] + q).collect();
            y.extend(v.iter().zip(&ratios).map(|(v, r)| r * ideal[1] + v));
            // The reference body that is prescribed has no deviation.
            let [mut q, mut v] = [q, v];
            if prescribed {
                (q[reference], v[reference]) = (0.0, 0.0);
            }
            let expected = absolute.accel(ideal, &y);
            let expected: Vec<f64> = expected.iter().zip(&ratios).map(|(a, r)| a - r * ideal[2]).collect();
            let found = accelerations(&model, t, &kept(&q), &kept(&v));
            let size = expected.iter().fold(1.0f64, |most, a| most.max(a.abs()));
            for (found, expected) in found.iter().zip(kept(&expected)) {
                worst = worst.max((found - expected).abs() / size);
            }
        }
    }
    println!("largest difference {worst:.1e}");
    // Rounding of absolute angles of some 10 rad against deflections of 1e-4 m.
    assert!(worst < 1e-9, "{worst:e}");
}

/// A run over a whole number of turns has all its lines, also where the angle at its end is rounded down.
#[test]
fn a_waterfall_over_whole_turns_has_its_last_line() {
    let swing =
        Oscillator::new(&[("speed", 1.0), ("damping", 0.1), ("linear stiffness", 1.0), ("force", 1.0)]);
    let swing = swing.unwrap();
    for k in 0..60 {
        let speed = 0.3 + 0.028_311 * f64::from(k);
        let turns = 1 + k as usize % 3;
        let run = VaryingSpeed::new(swing.clone(), SpeedLaw::constant(speed).unwrap());
        let end = turns as f64 * TAU / speed;
        let waterfall = Waterfall::new(1, 16).unwrap();
        let lines = waterfall.run(&Dop853::new(), &run, &State::at_rest(1), end, "q0").unwrap();
        assert_eq!(lines.len(), turns, "{speed}");
    }
}
