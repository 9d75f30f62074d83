//! The benchmark problems, written as a user would write them. Workload A is the rattling pair, B3 and B16
//! are rings of 3 and 16 gears, C is an ensemble of runs of A.
#![allow(dead_code, reason = "each bench uses some of these")]

use gear_dynamics::contact::{Contact, Deflection, Piece, PieceChoice};
use gear_dynamics::excitation::{Angle, Fourier, Product, Side, Sum};
use gear_dynamics::model::{Channel, Drives, Offers, Scalar, Size};
use gear_dynamics::{Backlash, Machine, Model, Periodic, Shape, State, Wave};
use std::f64::consts::{PI, TAU};

/// Workload A, the rattling pair: q'' + 0.02 q' + F(t) f(q) = -B0 - B1 sin ω_c t - B2 sin 2 ω_c t + B3 sin
/// ω_e t, f the dead zone. A `Model` in plain numbers; [`machine`](Pair::machine) returns the same equations
/// as a shape.
pub struct Pair {
    pub we: f64,
    pub wc: f64,
}

impl Pair {
    /// Half width of the dead zone.
    pub const HALF_BACKLASH: f64 = 6.2e-4;

    pub fn new() -> Self {
        Pair::at(0.2329)
    }
    /// With the mesh frequency ω_e = 63 ω_c [1].
    pub fn at(we: f64) -> Self {
        Pair { we, wc: we / 63.0 }
    }
    /// The same equations as a machine.
    pub fn machine(&self) -> Machine<Rattling> {
        Machine::of_constants(Rattling::new(None), &[("wc", self.wc)]).expect("the frequency is positive")
    }
    /// The same machine with its drives given as waves, which have Taylor series.
    pub fn machine_of_waves(&self) -> Machine<Rattling> {
        Machine::of_constants(Rattling::new(Some(Pair::waves())), &[("wc", self.wc)])
            .expect("the frequency is positive")
    }
    /// F and the right-hand side as waves of the slow angle.
    fn waves() -> [Wave; 2] {
        let wave = |mean: f64, pairs: &[[f64; 2]]| {
            Wave::new(Fourier::new(mean, pairs).expect("the coefficients are finite"))
        };
        let teeth = |wave: Wave| wave.per_turn(63).expect("63 teeth");
        let norm = 1.0 / (1.0 + 0.3846 * 0.3846 / 2.0);
        let radius = wave(1.0, &[[0.3846, 0.0]]);
        let stiffness = vec![teeth(wave(norm, &[[0.29 * norm, 0.0]])), radius.clone(), radius];
        let forcing =
            vec![wave(-1.4e-5, &[[0.0, -5.5e-6], [0.0, 2.2e-6]]), teeth(wave(0.0, &[[0.0, 6.8e-6]]))];
        [Wave::new(Product::new(stiffness)), Wave::new(Sum::new(forcing))]
    }
    pub fn start() -> State {
        State::new(0.0, &[-6.4e-4], &[0.0])
    }
    /// End of the run: 20 turns.
    pub fn end(&self) -> f64 {
        20.0 * TAU / self.wc
    }
    /// A step of 1/64 of the mesh period.
    pub fn step(&self) -> f64 {
        TAU / self.we / 64.0
    }
    /// F(t) and the right-hand side.
    #[inline(always)]
    pub fn drives(&self, t: f64) -> [f64; 2] {
        Pair::shapes(libm::sincos(self.we * t), libm::sincos(self.wc * t))
    }
    #[inline(always)]
    fn shapes<S: Scalar>((se, ce): (S, S), (s, c): (S, S)) -> [S; 2] {
        let one = S::from(1.0);
        let r = one + c * 0.3846;
        let stiffness = (one + ce * 0.29) * r * r / S::from(1.0 + 0.3846 * 0.3846 / 2.0);
        [stiffness, S::from(-1.4e-5) - s * 5.5e-6 + s * 2.0 * c * 2.2e-6 + se * 6.8e-6]
    }
}

impl Model for Pair {
    fn dof(&self) -> usize {
        1
    }
    #[inline(always)]
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let b = Pair::HALF_BACKLASH;
        let f = if q[0] > b { q[0] - b } else { 0.0 } - if q[0] < -b { -q[0] - b } else { 0.0 };
        a[0] = u[1] - 0.02 * v[0] - u[0] * f;
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: true, ..Offers::default() }
    }
    fn drives(&self) -> usize {
        2
    }
    #[inline(always)]
    fn drive(&self, t: f64, _: Side, u: &mut [f64]) {
        u[..2].copy_from_slice(&self.drives(t));
    }
    fn contacts(&self) -> usize {
        1
    }
    #[inline(always)]
    fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        let b = Pair::HALF_BACKLASH;
        out[0] = Contact { deflection: q[0], rate: v[0], lower: -b, upper: b, ..Contact::default() };
    }
    #[inline(always)]
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let f = match pieces[0] {
            Piece::Lower => q[0] + Pair::HALF_BACKLASH,
            Piece::Gap => 0.0,
            Piece::Upper => q[0] - Pair::HALF_BACKLASH,
        };
        a[0] = u[1] - 0.02 * v[0] - u[0] * f;
    }
}

impl Periodic for Pair {
    fn period(&self) -> f64 {
        TAU / self.wc
    }
}

/// Workload A as a shape, for lanes and for Taylor series.
#[derive(Clone, Debug, PartialEq)]
pub struct Rattling {
    law: Backlash,
    /// The drives as waves; `None`: by their formulas.
    waves: Option<[Wave; 2]>,
}

impl Rattling {
    fn new(waves: Option<[Wave; 2]>) -> Self {
        let law = Backlash::new(Pair::HALF_BACKLASH).expect("the half width is positive");
        Rattling { law, waves }
    }
}

impl Shape for Rattling {
    #[inline(always)]
    fn size(&self) -> Size {
        Size { dof: 1, waves: 2, contacts: 1, constants: 1, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        vec![Channel::new("wc", "1")]
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        let drives = match &self.waves {
            Some([stiffness, forcing]) => [stiffness.value(angle, side), forcing.value(angle, side)],
            None => Pair::shapes(angle.times(63.0).number().sin_cos(), angle.number().sin_cos()),
        };
        u.copy_from_slice(&drives);
    }
    #[inline(always)]
    fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        i: usize,
        u: Drives<'_, S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let ([stiffness, _], b) = (u.waves(), S::from(Pair::HALF_BACKLASH));
        let force =
            stiffness * law.force(i, &self.law, Deflection { d: q[0], rate: v[0], lower: -b, upper: b });
        Contact { deflection: q[0], rate: v[0], lower: -b, upper: b, force, ..Contact::default() }
    }
    #[inline(always)]
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let [_, forcing] = u.waves();
        a[0] = forcing - v[0] * 0.02 - self.contact(law, 0, u, q, v).force;
    }
}

/// The pair without fixed pieces: edges are found by stepping again.
pub struct Unheld(pub Pair);

impl Model for Unheld {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.0.accel(u, q, v, a);
    }
    fn drives(&self) -> usize {
        2
    }
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        self.0.drive(t, side, u);
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        self.0.contact(u, q, v, out);
    }
}

/// Mesh frequency of B3 and B16, 500 Hz, in rad/s.
pub const RING_OMEGA: f64 = 2.0 * PI * 500.0;
/// End of the runs of B3 and B16 in seconds.
pub const RING_END: f64 = 0.2;

/// The ring of workloads B3 and B16 with the load `torque` [N m] on every output. The motor torque balances
/// the loads.
pub fn ring(gears: usize, torque: f64) -> gear_dynamics::Ring {
    ring_with_load(gears, 1.5e-3, torque)
}

/// The same with another inertia of the loads [kg m²]: the workloads compared with other crates have 0.01 kg
/// m² and 20 N m.
pub fn ring_with_load(gears: usize, load_inertia: f64, torque: f64) -> gear_dynamics::Ring {
    gear_dynamics::Ring::as_printed(&ring_params(gears, load_inertia, torque))
        .expect("the parameters are in range")
}

/// The parameters of the ring.
pub fn ring_params(gears: usize, load_inertia: f64, torque: f64) -> gear_dynamics::models::ring::RingParams {
    use gear_dynamics::models::ring::{RingSet, Shaft};
    let set = RingSet {
        gear_inertia: 1.5e-3,
        load_inertia,
        base_radius: 0.0564,
        motor_shaft: Shaft { stiffness: 3e5, damping: 1.0 },
        output_shaft: Shaft { stiffness: 3e5, damping: 1.0 },
        mesh_stiffness: 1e8,
        stiffness_harmonics: vec![0.2],
        mesh_damping: 2000.0,
        error: 1e-5,
        motor_torque: torque * gears as f64,
        load_torque: torque,
        ..RingSet::set_a(gears, 1000.0)
    };
    set.params().expect("the parameters are in range")
}

pub mod hand_dop853;
pub mod hand_ring;

/// RK4 for workload A only, written by hand: drives are shared between stages and from step to step.
pub fn hand_rk4(pair: &Pair, q: f64, v: f64, h: f64, steps: usize) -> [f64; 2] {
    let b = Pair::HALF_BACKLASH;
    let f = |[stiffness, forcing]: [f64; 2], q: f64, v: f64| {
        let force = if q > b { q - b } else { 0.0 } - if q < -b { -q - b } else { 0.0 };
        forcing - 0.02 * v - stiffness * force
    };
    let (mut q, mut v) = (q, v);
    let mut u0 = pair.drives(0.0);
    for k in 0..steps {
        let t = k as f64 * h;
        let (um, u1) = (pair.drives(t + 0.5 * h), pair.drives(t + h));
        let a1 = f(u0, q, v);
        let (v2, a2) = (v + 0.5 * h * a1, f(um, q + 0.5 * h * v, v + 0.5 * h * a1));
        let (v3, a3) = (v + 0.5 * h * a2, f(um, q + 0.5 * h * v2, v + 0.5 * h * a2));
        let (v4, a4) = (v + h * a3, f(u1, q + h * v3, v + h * a3));
        q += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4);
        v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
        u0 = u1;
    }
    [q, v]
}

/// Median, minimum and maximum of the ratio A/B of the times of two runs that alternate.
pub fn ratio(rounds: usize, mut a: impl FnMut(), mut b: impl FnMut()) -> [f64; 3] {
    let time = |f: &mut dyn FnMut()| {
        let start = std::time::Instant::now();
        f();
        start.elapsed().as_secs_f64()
    };
    a();
    b();
    let mut ratios: Vec<f64> = (0..rounds).map(|_| time(&mut a) / time(&mut b)).collect();
    ratios.sort_by(f64::total_cmp);
    [ratios[rounds / 2], ratios[0], ratios[rounds - 1]]
}
