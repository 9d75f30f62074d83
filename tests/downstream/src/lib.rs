//! A crate of someone else's, on public names only: a bearing contact, a torque ripple, a gear pair on its housing, lanes, an integrator.

use gear_dynamics::{
    AsIs, Channel, Contact, Edges, Excitation, Finish, Generic, IntegrateError, Integrator, Jacobian, Jet, Law, Model, Nonlinearity,
    Observer, OnPieces, Periodic, Piece, Repeats, Scalar, Side, State, Stats, Step, StepView, dual_jacobian,
};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A stop with a soft layer: stiffness 1 past `touch`, 1 + `hard` past `touch + layer`, on the upper side only, with damping that grows
/// with depth (Hunt & Crossley).
#[derive(Clone, Copy, Debug)]
pub struct SoftStop {
    /// Where the layer begins.
    pub touch: f64,
    /// Loss factor of the layer [s/m].
    pub loss: f64,
}

impl Nonlinearity for SoftStop {
    #[inline(always)]
    fn force<S: Scalar>(&self, x: S, rate: S, _: S, upper: S) -> S {
        let depth = (x - upper).max(S::from(0.0));
        depth + depth * rate * self.loss
    }
    #[inline(always)]
    fn force_on<S: Scalar>(&self, piece: Piece, x: S, rate: S, _: S, upper: S) -> S {
        match piece {
            Piece::Upper => (x - upper) + (x - upper) * rate * self.loss,
            _ => S::from(0.0),
        }
    }
    fn edges(&self, _: f64, _: Side) -> Edges {
        Edges { upper: self.touch, ..Edges::NONE }
    }
}

/// A torque that steps up once per turn, falls as a half sine, and says so.
#[derive(Clone, Copy, Debug)]
pub struct Kick {
    /// Turns per second times 2π.
    pub omega: f64,
}

impl Excitation for Kick {
    fn jet(&self, t: f64, side: Side) -> Jet {
        let period = std::f64::consts::TAU / self.omega;
        let turn = (t / period).floor();
        let start = turn * period;
        // On the edge itself the side decides.
        let turn = if t == start && side == Side::Before { turn - 1.0 } else { turn };
        let phase = Jet::new(t - turn * period, 1.0, 0.0) * (0.5 * self.omega);
        phase.cos()
    }
    fn next_edge(&self, t: f64) -> Option<f64> {
        let period = std::f64::consts::TAU / self.omega;
        let mut k = (t / period).floor() + 1.0;
        if k * period <= t {
            k += 1.0;
        }
        Some(k * period)
    }
    fn repeats(&self) -> Repeats {
        Repeats::Every(std::f64::consts::TAU / self.omega)
    }
}

/// x1'' = kick - c x1' - k x1 - f(x1 - x2), x2'' = f(x1 - x2) - k x2: a wheel that knocks on its housing.
#[derive(Clone, Copy, Debug)]
pub struct Knock {
    /// Contact law.
    pub stop: SoftStop,
    /// Excitation.
    pub kick: Kick,
    /// Suspension stiffness of each body.
    pub stiffness: f64,
}

impl Generic for Knock {
    #[inline(always)]
    fn accel_on<S: Scalar, L: Law<S>>(&self, law: &L, u: &[S], q: &[S], v: &[S], a: &mut [S]) {
        let (x, rate) = (q[0] - q[1], v[0] - v[1]);
        let f = law.force(0, &self.stop, x, rate, S::from(f64::NEG_INFINITY), S::from(self.stop.touch));
        a[0] = u[0] - v[0] * 0.1 - q[0] * u[1] - f;
        a[1] = f - q[1] * u[1] - v[1] * 0.1;
    }
    fn phases(&self) -> usize {
        1
    }
    fn phase_drives(&self, phase: f64, side: Side, u: &mut [f64]) {
        u[0] = self.kick.value(phase / self.kick.omega, side);
    }
    fn constants(&self, u: &mut [f64]) {
        u[1] = self.stiffness;
    }
    fn shares_lanes_with(&self, other: &Self) -> bool {
        self.stop.touch == other.stop.touch && self.kick.omega == other.kick.omega
    }
}

impl Model for Knock {
    fn dof(&self) -> usize {
        2
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.accel_on(&AsIs, u, q, v, a);
    }
    fn drives(&self) -> usize {
        2
    }
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        u[0] = self.kick.value(t, side);
        self.constants(u);
    }
    fn next_edge(&self, t: f64) -> Option<f64> {
        self.kick.next_edge(t)
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        let (deflection, rate) = (q[0] - q[1], v[0] - v[1]);
        let force = self.stop.force(deflection, rate, f64::NEG_INFINITY, self.stop.touch);
        out[0] = Contact { deflection, rate, upper: self.stop.touch, force, ..Contact::default() };
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) -> bool {
        self.accel_on(&OnPieces(pieces), u, q, v, a);
        true
    }
    fn jacobian(&self, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64], out: &mut Jacobian) -> bool {
        dual_jacobian(self, pieces, u, q, v, out)
    }
    fn channels(&self) -> Vec<Channel> {
        vec![Channel::new("power of the kick", "W")]
    }
    fn observe(&self, u: &[f64], _: &[f64], v: &[f64], _: &[Contact], out: &mut [f64]) {
        out[0] = u[0] * v[0];
    }
}

impl Periodic for Knock {
    fn period(&self) -> f64 {
        std::f64::consts::TAU / self.kick.omega
    }
}

/// Four numbers side by side: a [`Scalar`] of this crate's own.
#[derive(Clone, Copy, Debug)]
pub struct Four(pub [f64; 4]);

impl Four {
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Four(self.0.map(f))
    }
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Four(std::array::from_fn(|i| f(self.0[i], other.0[i])))
    }
}

impl From<f64> for Four {
    fn from(x: f64) -> Self {
        Four([x; 4])
    }
}
impl Add for Four {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        self.zip(o, |a, b| a + b)
    }
}
impl Sub for Four {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        self.zip(o, |a, b| a - b)
    }
}
impl Mul for Four {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        self.zip(o, |a, b| a * b)
    }
}
impl Mul<f64> for Four {
    type Output = Self;
    fn mul(self, o: f64) -> Self {
        self.map(|a| a * o)
    }
}
impl Div for Four {
    type Output = Self;
    fn div(self, o: Self) -> Self {
        self.zip(o, |a, b| a / b)
    }
}
impl Neg for Four {
    type Output = Self;
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}
impl Scalar for Four {
    fn sqrt(self) -> Self {
        self.map(f64::sqrt)
    }
    fn abs(self) -> Self {
        self.map(f64::abs)
    }
    fn min(self, other: Self) -> Self {
        self.zip(other, f64::min)
    }
    fn max(self, other: Self) -> Self {
        self.zip(other, f64::max)
    }
    fn step(self) -> Self {
        self.map(|a| if a > 0.0 { 1.0 } else { 0.0 })
    }
    fn powf(self, p: f64) -> Self {
        self.map(|a| Scalar::powf(a, p))
    }
    fn exp(self) -> Self {
        self.map(Scalar::exp)
    }
    fn ln(self) -> Self {
        self.map(Scalar::ln)
    }
    fn sin(self) -> Self {
        self.map(Scalar::sin)
    }
    fn cos(self) -> Self {
        self.map(Scalar::cos)
    }
}

/// Heun's method of order 2 with a fixed step: an [`Integrator`] of this crate's own, which all analysis accepts.
#[derive(Clone, Copy, Debug)]
pub struct Heun(pub f64);

struct Straight {
    times: (f64, f64),
    start: Vec<f64>,
    end: Vec<f64>,
}

impl StepView for Straight {
    fn times(&self) -> (f64, f64) {
        self.times
    }
    fn start(&self) -> &[f64] {
        &self.start
    }
    fn end(&self) -> &[f64] {
        &self.end
    }
    fn pieces(&self) -> Option<&[Piece]> {
        None
    }
    fn at(&mut self, t: f64, y: &mut [f64]) {
        let s = (t - self.times.0) / (self.times.1 - self.times.0);
        for (y, (a, b)) in y.iter_mut().zip(self.start.iter().zip(&self.end)) {
            *y = a + s * (b - a);
        }
    }
}

impl Integrator for Heun {
    fn run<M: Model + ?Sized, O: Observer>(
        &self,
        model: &M,
        start: &State,
        t_end: f64,
        observer: &mut O,
    ) -> Result<Finish, IntegrateError> {
        let n = model.dof();
        let mut u = vec![0.0; model.drives()];
        let mut rate = |t: f64, side: Side, y: &[f64]| {
            let mut f = y[n..].to_vec();
            f.resize(2 * n, 0.0);
            model.drive(t, side, &mut u);
            model.accel(&u, &y[..n], &y[n..], &mut f[n..]);
            f
        };
        let y: Vec<f64> = start.q.iter().chain(&start.v).copied().collect();
        let mut view = Straight { times: (start.t, start.t), end: y.clone(), start: y };
        let mut stats = Stats::default();
        let mut edge = model.next_edge(start.t);
        while view.times.1 < t_end {
            let t0 = view.times.1;
            let stop = edge.map_or(t_end, |edge| edge.min(t_end));
            let t1 = if t0 + 1.5 * self.0 > stop { stop } else { t0 + self.0 };
            let h = t1 - t0;
            view.start.clone_from(&view.end);
            let k1 = rate(t0, Side::After, &view.start);
            let middle: Vec<f64> = view.start.iter().zip(&k1).map(|(y, k)| y + h * k).collect();
            let k2 = rate(t1, Side::Before, &middle);
            for (j, y) in view.end.iter_mut().enumerate() {
                *y += 0.5 * h * (k1[j] + k2[j]);
            }
            view.times = (t0, t1);
            stats.steps += 1;
            stats.evaluations += 2;
            let at_edge = edge == Some(t1);
            if at_edge {
                edge = model.next_edge(t1);
            }
            if let Some(component) = view.end.iter().position(|y| !y.is_finite()) {
                return Err(IntegrateError::NotFinite { t: t0, component });
            }
            if observer.step(&mut Step::new(&mut view, at_edge, &[])).is_break() {
                let state = State::new(t1, &view.end[..n], &view.end[n..]);
                return Ok(Finish { state, stopped: true, stats });
            }
        }
        let state = State::new(t_end, &view.end[..n], &view.end[n..]);
        Ok(Finish { state, stopped: false, stats })
    }
}
