//! Runs have the same bits with any number of further coordinates. `Model::redrive` gives
//! the drives of `Model::drive`.

use crate::api::*;
use std::f64::consts::TAU;

/// Uncoupled oscillators that share one drive, time. Their constants repeat after three oscillators.
struct Apart(usize);

impl Model for Apart {
    fn dof(&self) -> usize {
        self.0
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        for (i, a) in a.iter_mut().enumerate() {
            *a = -(1.0 + (i % 3) as f64) * q[i] - 0.1 * v[i] + (u[0] * q[i]).sin();
        }
    }
}

fn start(n: usize) -> State {
    let at = |i: usize| 1.0 + 0.25 * (i % 3) as f64;
    State { t: 0.0, q: (0..n).map(at).collect(), v: (0..n).map(|i| -at(i)).collect() }
}

#[test]
fn a_motion_has_the_same_bits_in_every_company() {
    let few = Rk4::new(0.01).end(&Apart(2), &start(2), 2.0).unwrap();
    for n in [3, 4, 7, 8, 9, 16, 17, 33] {
        let many = Rk4::new(0.01).end(&Apart(n), &start(n), 2.0).unwrap();
        for i in 0..n {
            let like = if i % 3 < 2 { few.q[i % 3] } else { many.q[2] };
            assert_eq!(many.q[i].to_bits(), like.to_bits(), "{i} of {n}");
        }
        let end = Dop853::new().rtol(1e-12).atol(1e-14).end(&Apart(n), &start(n), 2.0).unwrap();
        let alone = Dop853::new().rtol(1e-12).atol(1e-14).end(&Apart(1), &start(1), 2.0).unwrap();
        assert!((end.q[0] - alone.q[0]).abs() < 1e-11, "{n}");
    }
}

#[test]
fn dense_output_of_many_coordinates_is_that_of_few() {
    let times: Vec<f64> = (0..40).map(|i| 0.05 * f64::from(i)).collect();
    let few = Rk4::new(0.03).sample(&Apart(1), &start(1), &times).unwrap();
    for n in [3, 9, 20] {
        let many = Rk4::new(0.03).sample(&Apart(n), &start(n), &times).unwrap();
        for (k, t) in times.iter().enumerate() {
            assert_eq!(few.q(k)[0].to_bits(), many.q(k)[0].to_bits(), "{n} at {t}");
        }
    }
}

#[test]
fn what_further_drives_leave_out_stands_there_already() {
    let set = RingSet { phases: vec![0.0, 0.5, 0.0, 1.0], ..RingSet::set_a(4, 1000.0) };
    let params = set.params().unwrap();
    let law = VaryingBacklash::new(Wave::new(Fourier::new(2e-5, &[[1e-6, 0.0]]).unwrap()));
    let mesh = Mesh::new(Wave::constant(2e8).unwrap(), Wave::constant(0.0).unwrap(), law);
    let RingParams { motor, gears, mesh_damping, omega, teeth, .. } = params.clone();
    let moving = RingParams { motor, gears, meshes: vec![mesh; 4], mesh_damping, omega, teeth };
    let same = |model: &dyn Model| {
        let (mut again, mut fresh) = (vec![f64::NAN; model.drives()], vec![f64::NAN; model.drives()]);
        model.drive(0.0, Side::After, &mut again);
        for i in 1..20 {
            let t = f64::from(i) * 0.13 * TAU / params.omega;
            model.redrive(&[t], Side::After, &mut again);
            model.drive(t, Side::After, &mut fresh);
            assert_eq!(again, fresh);
        }
        // The rows of nodes have the same bits, for any number of them and far from 0.
        for (nodes, from) in (1..12).flat_map(|nodes| [(nodes, 0.0), (nodes, 1e7)]) {
            let times: Vec<f64> = (0..nodes).map(|i| from + f64::from(i) * 0.13 / params.omega).collect();
            let mut rows = fresh.repeat(times.len());
            model.redrive(&times, Side::Before, &mut rows);
            for (t, row) in times.iter().zip(rows.chunks_exact(fresh.len())) {
                model.drive(*t, Side::After, &mut fresh);
                assert_eq!(row, fresh);
            }
        }
    };
    same(&Ring::as_printed(&params).unwrap());
    same(&Ring::as_printed(&RingSet::set_a(3, 1000.0).params().unwrap()).unwrap());
    same(&Ring::as_printed_of_laws(&moving, Frame::Inertial).unwrap());
}

/// Three oscillators that note the latest instant at which their drive is evaluated.
struct Noted(std::sync::Mutex<f64>);

impl Model for Noted {
    fn dof(&self) -> usize {
        3
    }
    fn drive(&self, t: f64, _: Side, u: &mut [f64]) {
        let mut latest = self.0.lock().unwrap();
        *latest = latest.max(t);
        u[0] = t;
    }
    fn accel(&self, u: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) {
        for (a, q) in a.iter_mut().zip(q) {
            *a = u[0].sin() - q;
        }
    }
}

#[test]
fn no_drive_is_evaluated_after_the_end_of_a_run() {
    for end in [0.1, 0.4, 0.45, 1.0, 1.2] {
        let model = Noted(std::sync::Mutex::new(0.0));
        Rk4::new(0.1).end(&model, &State::at_rest(3), end).unwrap();
        assert_eq!(*model.0.lock().unwrap(), end);
    }
}
