//! Small models with known solutions.
#![allow(dead_code, reason = "each test file uses some of these")]

pub mod bands;
pub mod family;
pub mod oscillators;
pub mod planets;
pub mod random;
pub mod source_files;
pub mod trains;
pub mod two_tones;

use crate::api::*;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// The value after it was stored and read, as text and as bytes.
pub fn stored<T: Serialize + DeserializeOwned>(value: &T) -> T {
    let text = serde_json::to_string(value).unwrap();
    let read: T = serde_json::from_str(&text).unwrap();
    assert_eq!(serde_json::to_string(&read).unwrap(), text);
    let bytes = postcard::to_stdvec(value).unwrap();
    let read: T = postcard::from_bytes(&bytes).unwrap();
    assert_eq!(postcard::to_stdvec(&read).unwrap(), bytes);
    read
}

/// q'' = -0.3 t q' - (1 + t²/10) q + r(t). The function r is chosen so that q = exp(-t/5) cos(t²/2 + t) is a
/// solution. All coefficients depend on time.
pub struct Forced;

impl Forced {
    fn jet(t: f64) -> Jet {
        let t = Jet::variable(t);
        (t * -0.2).exp() * (t * t * 0.5 + t).cos()
    }
    pub fn q(t: f64) -> f64 {
        Self::jet(t).value
    }
    pub fn start() -> State {
        let jet = Self::jet(0.0);
        State::new(0.0, &[jet.value], &[jet.rate])
    }
}

impl Model for Forced {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let t = u[0];
        let exact = Forced::jet(t);
        // Here r(t) = exact'' + c exact' + k exact.
        let (k, c) = (1.0 + 0.1 * t * t, 0.3 * t);
        a[0] = exact.second + k * (exact.value - q[0]) + c * (exact.rate - v[0]);
    }
}

/// Error of q at `end`.
pub fn fixed_error<I: Integrator>(solver: &I, end: f64) -> f64 {
    (solver.end(&Forced, &Forced::start(), end).unwrap().q[0] - Forced::q(end)).abs()
}

/// Order of convergence between the last two step counts, rounded. Prints the errors and the orders between
/// all neighbouring counts.
pub fn observed_order(error: &dyn Fn(f64) -> f64, counts: &[f64]) -> i64 {
    let errors: Vec<f64> = counts.iter().map(|n| error(*n)).collect();
    let orders: Vec<f64> = errors
        .windows(2)
        .zip(counts.windows(2))
        .map(|(e, n)| (e[0] / e[1]).log2() / (n[1] / n[0]).log2())
        .collect();
    println!("errors {errors:?} orders {orders:.2?}");
    orders[orders.len() - 1].round() as i64
}

/// x'' + g(x) = 0, g the dead zone of half backlash b: free motion without damping.
pub struct FreeDeadZone {
    pub b: f64,
}

impl Model for FreeDeadZone {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, _: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) {
        a[0] = -((q[0] - self.b).max(0.0) - (-self.b - q[0]).max(0.0));
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: true, ..Offers::default() }
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        let mut a = [0.0];
        self.accel(&[], q, v, &mut a);
        out[0] = Contact {
            deflection: q[0],
            rate: v[0],
            lower: -self.b,
            upper: self.b,
            force: -a[0],
            ..Contact::default()
        };
    }
    fn accel_on_pieces(&self, pieces: &[Piece], _: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) {
        a[0] = match pieces[0] {
            Piece::Lower => -(q[0] + self.b),
            Piece::Gap => 0.0,
            Piece::Upper => -(q[0] - self.b),
        };
    }
}

/// x'' + 0.1 x' + g(x) = 0.25 + 0.25 cos 0.7 t, g the dead zone of half width 1: bilateral rattle that
/// settles.
pub struct Impact;

impl Impact {
    pub fn start() -> State {
        State::new(0.0, &[1.3], &[0.4])
    }
}

impl Model for Impact {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        FreeDeadZone { b: 1.0 }.accel(u, q, v, a);
        a[0] += 0.25 + 0.25 * (0.7 * u[0]).cos() - 0.1 * v[0];
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: true, ..Offers::default() }
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        FreeDeadZone { b: 1.0 }.contact(u, q, v, out);
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        FreeDeadZone { b: 1.0 }.accel_on_pieces(pieces, u, q, v, a);
        a[0] += 0.25 + 0.25 * (0.7 * u[0]).cos() - 0.1 * v[0];
    }
}
