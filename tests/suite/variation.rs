//! The derivative of the flow against differences of the flow and closed forms.

use crate::api::*;
use crate::common::{FreeDeadZone, Impact};
use std::f64::consts::PI;

/// Largest difference from central differences of the flow, over the largest entry of the same column.
/// Entries are in units of `size`.
fn against_differences<M: Model>(model: &M, start: &State, span: f64, size: &[f64]) -> f64 {
    let n = model.dof();
    let end = start.t + span;
    let solver = Dop853::new().rtol(1e-15).atol_each(&size.iter().map(|s| 1e-14 * s).collect::<Vec<_>>());
    let ours = Variation::new().flow_tolerance(1e-13).run(model, start, end).unwrap();
    let mut worst: f64 = 0.0;
    for j in 0..2 * n {
        let h = 2e-5 * size[j];
        let moved = |h: f64| {
            let mut from = start.clone();
            if j < n {
                from.q[j] += h
            } else {
                from.v[j - n] += h
            }
            let end = solver.end(model, &from, end).unwrap();
            [end.q, end.v].concat()
        };
        // Richardson extrapolation of two central differences.
        let (far, near) = ([moved(h), moved(-h)], [moved(0.5 * h), moved(-0.5 * h)]);
        let slope: Vec<f64> = (0..2 * n)
            .map(|i| {
                (4.0 * (near[0][i] - near[1][i]) / h - (far[0][i] - far[1][i]) / (2.0 * h)) / 3.0 * size[j]
                    / size[i]
            })
            .collect();
        let largest = slope.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        for i in 0..2 * n {
            worst = worst.max((ours.matrix[(i, j)] * size[j] / size[i] - slope[i]).abs() / largest);
        }
    }
    println!("{} crossings, {worst:.2e}", ours.crossings);
    worst
}

/// x'' = 0.3 + 0.5 cos 0.9 t - W with W = 4 (x ∓ b) + 0.6 x' in contact: the force jumps. The gap extends
/// from -b to b with b = 1 + `swing` sin 3t. With or without a Jacobian.
struct Jumping {
    swing: f64,
    jacobian: bool,
}

impl Jumping {
    fn width(&self, t: f64) -> (f64, f64) {
        (1.0 + self.swing * (3.0 * t).sin(), 3.0 * self.swing * (3.0 * t).cos())
    }
    fn piece(&self, u: &[f64], q: &[f64]) -> Piece {
        let b = self.width(u[0]).0;
        if q[0] > b {
            Piece::Upper
        } else if q[0] < -b {
            Piece::Lower
        } else {
            Piece::Gap
        }
    }
}

impl Model for Jumping {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.accel_on_pieces(&[self.piece(u, q)], u, q, v, a);
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: true, jacobian: self.jacobian, ..Offers::default() }
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        let (b, rate) = self.width(u[0]);
        out[0] = Contact {
            deflection: q[0],
            rate: v[0],
            lower: -b,
            upper: b,
            lower_rate: -rate,
            upper_rate: rate,
            force: 0.0,
        };
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let b = self.width(u[0]).0;
        let tooth = |edge: f64| 4.0 * (q[0] - edge) + 0.6 * v[0];
        a[0] = 0.3 + 0.5 * (0.9 * u[0]).cos()
            - match pieces[0] {
                Piece::Lower => tooth(-b),
                Piece::Gap => 0.0,
                Piece::Upper => tooth(b),
            };
    }
    fn jacobian(&self, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], _: &[f64], out: &mut Jacobian) {
        let piece = pieces.map_or_else(|| self.piece(u, q), |pieces| pieces[0]);
        let touching = if piece == Piece::Gap { 0.0 } else { 1.0 };
        (out.q[(0, 0)], out.v[(0, 0)]) = (-4.0 * touching, -0.6 * touching);
    }
}

#[test]
fn differences_of_small_models() {
    assert!(against_differences(&Impact, &Impact::start(), 60.0, &[1.0; 2]) < 1e-7);
    assert!(
        against_differences(&FreeDeadZone { b: 0.5 }, &State::new(0.0, &[1.2], &[0.1]), 25.0, &[1.0; 2])
            < 1e-7
    );
}

/// The force jumps at edges at rest and at moving edges. Without saltation matrices the error would be of
/// order one.
#[test]
fn differences_where_the_force_jumps() {
    for swing in [0.0, 0.2] {
        for jacobian in [true, false] {
            let start = State::new(0.0, &[1.4], &[0.3]);
            let worst = against_differences(&Jumping { swing, jacobian }, &start, 40.0, &[1.0; 2]);
            assert!(worst < 1e-7, "swing {swing}, jacobian {jacobian}: {worst}");
        }
    }
}

#[test]
fn differences_of_the_pair() {
    for reading in [NfgReading::exact(), NfgReading::published_on_base_radius()] {
        let pair = NfgPair::of_reading(&NfgParams { speed: 180.0, ..NfgParams::table1() }, reading).unwrap();
        let start = Dop853::new().end(&pair, &pair.on_drive_flank().unwrap(), 0.5 * pair.period()).unwrap();
        let worst = against_differences(&pair, &start, 0.06 * pair.period(), &[1e-4; 2]);
        assert!(worst < 1e-7, "{worst}");
    }
    let two = NfgPair2::new(&NfgParams { speed: 180.0, ..NfgParams::table1() }, 0.01).unwrap();
    let start = Dop853::new().end(&two, &two.on_drive_flank().unwrap(), 0.5 * two.period()).unwrap();
    let worst = against_differences(&two, &start, 0.06 * two.period(), &[1e-4, 1e-4, 1.0, 1.0]);
    assert!(worst < 1e-7, "{worst}");
}

#[test]
fn differences_of_the_ring() {
    for damping in [ContactDamping::Always, ContactDamping::InContact] {
        let set = RingSet { error: 1e-5, ..RingSet::set_a(3, 5000.0) };
        let mut params = set.params().unwrap();
        params.meshes = params.meshes.into_iter().map(|mesh| mesh.with_contact_damping(damping)).collect();
        let ring = Ring::as_printed(&params).unwrap().with_frame(Frame::Rigid);
        let mut size = vec![1e-4; 14];
        size[7..].fill(1.0);
        let start = Dop853::new().end(&ring, &State::at_rest(7), 20.3 * ring.period()).unwrap();
        let through = Variation::new().run(&ring, &start, start.t + 1.3 * ring.period()).unwrap();
        assert!(through.crossings > 0);
        let worst = against_differences(&ring, &start, 1.3 * ring.period(), &size);
        assert!(worst < 2e-6, "{damping:?}: {worst}");
    }
}

/// Liouville: det Φ = exp(∫ trace) for a constant damping.
#[test]
fn determinant() {
    let pair = NfgPair::of_reading(
        &NfgParams { speed: 180.0, ..NfgParams::table1() },
        NfgReading::published_on_base_radius(),
    )
    .unwrap();
    let start = pair.on_drive_flank().unwrap();
    let span = 0.3 * pair.period();
    let through = Variation::new().flow_tolerance(1e-13).run(&pair, &start, start.t + span).unwrap();
    let exact = (-2.0 * pair.constant("damping ratio").unwrap() * span).exp();
    assert!(
        (through.matrix.determinant() / exact - 1.0).abs() < 1e-10,
        "{}",
        through.matrix.determinant() / exact - 1.0
    );
}

/// q'' + 0.2 q' + q = 0 at rest, in closed form: only the differences determine the steps.
#[test]
fn damped_oscillator_at_rest() {
    struct Damped;
    impl Model for Damped {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, _: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
            a[0] = -0.2 * v[0] - q[0];
        }
    }
    let (delta, omega, t) = (0.1, 0.99f64.sqrt(), 3.0 * PI);
    let through = Variation::new().run(&Damped, &State::at_rest(1), t).unwrap();
    let (e, c, s) = ((-delta * t).exp(), (omega * t).cos(), (omega * t).sin());
    let exact = [[e * (c + delta / omega * s), e * s / omega], [-e * s / omega, e * (c - delta / omega * s)]];
    for (i, row) in exact.iter().enumerate() {
        for (j, exact) in row.iter().enumerate() {
            assert!((through.matrix[(i, j)] - exact).abs() < 1e-10, "{} {exact}", through.matrix[(i, j)]);
        }
    }
}
