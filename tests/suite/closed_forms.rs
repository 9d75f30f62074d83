//! Closed forms of the literature: backbones and describing function of a dead zone, stability boundaries of
//! stiffness waves. Source of the values: tests/data/closed_forms.json.

use crate::api::*;
use crate::common::FreeDeadZone;
use crate::data::read;
use nalgebra::DMatrix;
use serde_json::Value;
use std::f64::consts::TAU;

/// The entry of a value that is a number.
fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap()
}

/// The values of a block of the data.
fn values(block: &str) -> Vec<Value> {
    read("closed_forms.json")[block]["values"].as_array().unwrap().clone()
}

/// x'' + g(x) = F + P cos Ωt, g the dead zone of half width 1.
struct Loaded {
    force: f64,
    amplitude: f64,
    omega: f64,
}

const GAP: FreeDeadZone = FreeDeadZone { b: 1.0 };

impl Model for Loaded {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        GAP.accel(u, q, v, a);
        a[0] += self.force + self.amplitude * (self.omega * u[0]).cos();
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: true, jacobian: true, ..Offers::default() }
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        GAP.contact(u, q, v, out);
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        GAP.accel_on_pieces(pieces, u, q, v, a);
        a[0] += self.force + self.amplitude * (self.omega * u[0]).cos();
    }
    fn jacobian(&self, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64], out: &mut Jacobian) {
        let mut contact = [Contact::default()];
        self.contact(u, q, v, &mut contact);
        let piece = pieces.map_or(contact[0].piece(), |pieces| pieces[0]);
        out.q[(0, 0)] = if piece == Piece::Gap { 0.0 } else { -1.0 };
    }
}

impl Periodic for Loaded {
    fn period(&self) -> f64 {
        TAU / self.omega
    }
}

/// Period between two maxima of a free motion that starts at its maximum, and the minimum.
fn free_period<M: Model>(model: &M, maximum: f64, period: f64) -> (f64, f64) {
    let start = State::new(0.0, &[maximum], &[0.0]);
    let mut section = Section::new(model, "v0", 0.0, Direction::Falling).unwrap();
    let mut statistics = Statistics::new(model, &["q0"]).unwrap();
    let mut both = (&mut statistics, &mut section);
    Dop853::new().rtol(1e-13).atol(1e-15).run(model, &start, 2.2 * period, &mut both).unwrap();
    let times: Vec<f64> = section.states().iter().map(|s| s.t).collect();
    assert!(times.len() >= 2, "{times:?}");
    let last = times.len() - 1;
    (times[last] - times[last - 1], statistics.summary("q0").unwrap().min)
}

/// T = 2π + 4 b/(A - b).   Source: Den Hartog, Mechanical Vibrations, 1956, Sect. 8.
#[test]
fn backbone_of_the_dead_zone() {
    let mut worst: f64 = 0.0;
    for value in values("dead_zone_free_vibration") {
        let (a, omega) = (number(&value, "A"), number(&value, "omega"));
        let (period, minimum) = free_period(&GAP, a, TAU / omega);
        worst = worst.max((period * omega / TAU - 1.0).abs());
        assert!((minimum + a).abs() < 1e-11 * a, "A = {a}: {minimum}");
    }
    println!("relative error of the period {worst:.1e}");
    assert!(worst < 1e-13);
}

/// T = 2 (π - arccos(F/A)) + 2 √(A² - F²)/F with the amplitude A of the arc in contact.
#[test]
fn backbone_with_preload_and_loss_of_contact() {
    let mut worst: f64 = 0.0;
    for value in values("preloaded_contact_loss_backbone") {
        assert_eq!(value["valid"], true);
        let model = Loaded { force: number(&value, "Fm"), amplitude: 0.0, omega: 1.0 };
        let omega = number(&value, "omega");
        let (period, minimum) = free_period(&model, number(&value, "xmax"), TAU / omega);
        worst = worst.max((period * omega / TAU - 1.0).abs());
        assert!((minimum - number(&value, "xmin")).abs() < 1e-11);
    }
    println!("relative error of the period {worst:.1e}");
    assert!(worst < 1e-13);
}

/// Mean and first cosine of g(xm + A cos t). A balance with the orders 0 and 1 has them as its integrals: with
/// the load F = mean and P = f1 - Ω² A its solution is x = xm + A cos Ωt.   Source of the form: Comparin & Singh
/// (1989), Kahraman & Singh (1990).
#[test]
fn describing_function_of_a_backlash() {
    let (omega, harmonics) = (2.0, Harmonics::up_to(1));
    let mut worst: f64 = 0.0;
    for value in values("describing_function_backlash") {
        let [mean, a, force, first] =
            ["x_mean", "A", "mean_force", "fundamental_force"].map(|key| number(&value, key));
        assert!((first / a - number(&value, "N_eff")).abs() < 1e-15);
        let model = Loaded { force, amplitude: first - omega * omega * a, omega };
        let guess =
            FourierOrbit::new(&harmonics, model.period(), &[vec![1.01 * mean + 0.001, 0.99 * a, 0.01 * a]])
                .unwrap();
        for integrals in [Integrals::Closed, Integrals::Kinks, Integrals::Panels] {
            let newton = Newton::new().tolerance(1e-14);
            let balance = Balance::new(harmonics.clone()).integrals(integrals).root_finder(newton);
            let orbit = balance.solve(&model, &guess).unwrap();
            let found = orbit.coefficients(0);
            let error =
                [found[0] - mean, found[1] - a, found[2]].iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            println!("xm = {mean}, A = {a}, {integrals:?}: {error:.1e}");
            worst = worst.max(error);
        }
    }
    println!("largest error {worst:.1e}");
    assert!(worst < 1e-13);
}

/// x'' + c x' + k(φ) x = 0 with the angle φ = W t.
#[derive(Clone, Debug, PartialEq)]
struct Stiffness(Wave);

impl Stiffness {
    fn machine(wave: Wave, w: f64, c: f64) -> Machine<Stiffness> {
        Machine::of_constants(Stiffness(wave), &[("speed", w), ("damping", c)]).unwrap()
    }
    /// k = mean + amplitude cos φ.
    fn cosine(mean: f64, amplitude: f64, w: f64, c: f64) -> Machine<Stiffness> {
        Stiffness::machine(Wave::new(Fourier::new(mean, &[[amplitude, 0.0]]).unwrap()), w, c)
    }
    /// k = 1 + 2 ε (1 - duty) for the share `duty` of a period, 1 - 2 ε duty otherwise.
    fn rectangle(value: &Value, w: f64) -> Machine<Stiffness> {
        let [epsilon, duty, zeta] = ["eps", "duty", "zeta"].map(|key| number(value, key));
        let (low, high) = (1.0 - 2.0 * epsilon * duty, 1.0 + 2.0 * epsilon * (1.0 - duty));
        Stiffness::machine(Wave::new(RectangularWave::new(low, high, duty).unwrap()), w, 2.0 * zeta)
    }
}

impl Shape for Stiffness {
    fn size(&self) -> Size {
        Size { dof: 1, waves: 1, constants: 2, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        vec![Channel::new("speed", "1"), Channel::new("damping", "1")]
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        u[0] = self.0.value(angle, side);
    }
    fn next_edge(&self, angle: f64) -> Option<f64> {
        self.0.next_edge(angle)
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let ([k], [c]) = (u.waves(), u.constants());
        a[0] = -(c * v[0]) - k * q[0];
    }
}

const METHODS: [FlowMethod; 2] = [FlowMethod::Taylor, FlowMethod::Dop853];

/// The monodromy matrix of rest over a period.
fn turn(model: &Machine<Stiffness>, method: FlowMethod) -> DMatrix<f64> {
    let flow = Variation::new().flow_tolerance(1e-15).flow_method(method);
    flow.run(model, &State::at_rest(1), model.period()).unwrap().matrix
}

/// Distance of the nearest multiplier from ±1.
fn nearest(matrix: &DMatrix<f64>, sign: f64) -> f64 {
    let multipliers = Multipliers::of_monodromy(matrix, 1e-9).unwrap();
    multipliers.values().iter().map(|m| (m - sign).norm()).fold(f64::INFINITY, f64::min)
}

/// y'' + (a - 2 q cos 2t) y = 0. At a characteristic value of even order both multipliers over π are 1, at one
/// of odd order -1: the trace of the monodromy matrix is 2 or -2. The eigenvalue is double and defective, so that its
/// own error is the root of that of the trace.
#[test]
fn characteristic_values_of_mathieu() {
    let data = read("closed_forms.json");
    let mut count = 0;
    for family in ["a", "b"] {
        for (name, value) in data["mathieu_characteristic_values"][family].as_object().unwrap() {
            // "a0(5)": order 0, q = 5.
            let order: u32 = name[1..2].parse().unwrap();
            let q: f64 = name[3..name.len() - 1].parse().unwrap();
            let sign = if order.is_multiple_of(2) { 1.0 } else { -1.0 };
            let a = value.as_f64().unwrap();
            for method in METHODS {
                let trace = |a: f64| turn(&Stiffness::cosine(a, -2.0 * q, 2.0, 0.0), method).trace();
                let error = trace(a) - 2.0 * sign;
                let slope = (trace(a + 1e-4) - trace(a - 1e-4)) / 2e-4;
                let matrix = turn(&Stiffness::cosine(a, -2.0 * q, 2.0, 0.0), method);
                let apart = nearest(&matrix, sign);
                println!(
                    "{name}, {method}: trace {error:.1e}, a {:.1e}, multipliers {apart:.1e}",
                    error / slope
                );
                assert!(error.abs() < 1e-10 && (error / slope).abs() < 1e-12 && apart < 1e-5);
                assert!((matrix.determinant() - 1.0).abs() < 1e-10);
            }
            count += 1;
        }
    }
    assert_eq!(count, 10);
}

/// On the boundary of the n-th tongue a multiplier is (-1)^n: det(Φ - (-1)^n) = 0 for the monodromy matrix Φ,
/// that is, 1 - (-1)^n tr Φ + det Φ = 0. With damping this multiplier is simple.   Source of the problem: Lin &
/// Parker (2002).
#[test]
fn tongues_of_a_rectangular_stiffness() {
    let (mut worst, mut worst_simple, mut boundaries): (f64, f64, usize) = (0.0, 0.0, 0);
    for value in values("meissner_boundaries") {
        let (n, zeta) = (value["tongue"].as_u64().unwrap(), number(&value, "zeta"));
        let sign = if n.is_multiple_of(2) { 1.0 } else { -1.0 };
        let list: Vec<f64> =
            value["W_boundaries"].as_array().unwrap().iter().map(|w| w.as_f64().unwrap()).collect();
        for &w in &list {
            for method in METHODS {
                let matrix = turn(&Stiffness::rectangle(&value, w), method);
                worst = worst.max((1.0 - sign * matrix.trace() + matrix.determinant()).abs());
                // Liouville: det Φ = exp(-2 ζ T).
                assert!((matrix.determinant() - (-2.0 * zeta * TAU / w).exp()).abs() < 1e-12);
                if zeta > 0.0 {
                    worst_simple = worst_simple.max(nearest(&matrix, sign));
                }
            }
            boundaries += 1;
        }
        // Between the boundaries the motion grows, beside them it does not. Without boundaries it decays
        // everywhere near 2/n.
        let largest = |w: f64| {
            let matrix = turn(&Stiffness::rectangle(&value, w), FlowMethod::Taylor);
            Multipliers::of_monodromy(&matrix, 1e-9).unwrap().largest()
        };
        match list[..] {
            [lower, upper] => {
                let width = upper - lower;
                assert!(largest(0.5 * (lower + upper)) > 1.0 + 1e-6);
                for outside in [lower - 0.1 * width, upper + 0.1 * width] {
                    assert!(largest(outside) < 1.0 + 1e-9);
                }
            }
            _ => {
                let middle = 2.0 / n as f64;
                for k in -20..=20 {
                    assert!(largest(middle * (1.0 + 0.002 * f64::from(k))) < 1.0);
                }
            }
        }
    }
    println!("{boundaries} boundaries: equation {worst:.1e}, simple multipliers {worst_simple:.1e}");
    assert_eq!(boundaries, 32);
    assert!(worst < 1e-12 && worst_simple < 1e-11);
}

/// The two boundaries of the principal tongue of x'' + 2 ζ x' + (1 + a cos W t) x = 0: a multiplier is -1.
#[test]
fn principal_tongue_of_the_damped_mathieu_equation() {
    for value in values("damped_mathieu_principal") {
        for w in value["W"].as_array().unwrap() {
            let (w, zeta) = (w.as_f64().unwrap(), number(&value, "zeta"));
            let model = Stiffness::cosine(1.0, number(&value, "a"), w, 2.0 * zeta);
            for method in METHODS {
                let error = nearest(&turn(&model, method), -1.0);
                println!("W = {w}, {method}: {error:.1e}");
                assert!(error < 1e-12);
            }
        }
    }
}
