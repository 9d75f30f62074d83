//! A crate that uses public names only: a spur pair, a contact law, an excitation, a number type, an
//! integrator, steps, a root finder and a sweep engine of its own.

mod engine;
mod marquardt;
mod rosenbrock;

pub use engine::Straightforward;
pub use marquardt::Marquardt;
pub use rosenbrock::{HeunStep, Ros2};

use gear_dynamics::contact::{Contact, Deflection, Edges, Nonlinearity, Piece, PieceChoice};
use gear_dynamics::excitation::{Angle, Excitation, Jet, Side};
use gear_dynamics::model::{Channel, Drives, Scalar, Size};
use gear_dynamics::ode::{Finish, IntegrateError, Observer, Stats, Step, StepView};
use gear_dynamics::{Integrator, Mesh, Model, Shape, State, Wave};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// m q'' + c x' + k(φ) f(x) = F with x = q - e(φ) along the line of action: a spur pair over its mesh angle,
/// with any contact law.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshedPair<N>(pub Mesh<N>);

impl<N: Nonlinearity> Shape for MeshedPair<N> {
    #[inline(always)]
    fn size(&self) -> Size {
        Size { dof: 1, waves: Mesh::<N>::WAVES, contacts: 1, constants: 4, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        [("mesh frequency", "rad/s"), ("load", "N"), ("damping", "N s/m"), ("mass", "kg")]
            .map(|(name, unit)| Channel::new(name, unit))
            .into()
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        self.0.waves(angle, side, u);
    }
    fn next_edge(&self, angle: f64) -> Option<f64> {
        self.0.next_edge(angle)
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
        let [_, damping] = u.constants();
        self.0.contact(law, i, &u.waves(), u.speed(), damping, q[0], v[0])
    }
    #[inline(always)]
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let [load, _, mass] = u.constants();
        a[0] = (load - self.contact(law, 0, u, q, v).force) / mass;
    }
    fn channels(&self) -> Vec<Channel> {
        vec![Channel::new("dynamic factor", "1")]
    }
    fn write_channels(
        &self,
        u: Drives<'_, f64>,
        _: &[f64],
        _: &[f64],
        contacts: &[Contact],
        out: &mut [f64],
    ) {
        let [load] = u.constants();
        out[0] = contacts[0].force / load;
    }
}

/// A stop above with a soft layer: stiffness 1 beyond `touch`, and a damping that grows with the depth (Hunt
/// & Crossley).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoftStop {
    /// Upper edge, at which the layer begins.
    pub touch: f64,
    /// Loss factor of the layer [s/m].
    pub loss: f64,
}

impl Nonlinearity for SoftStop {
    #[inline(always)]
    fn force<S: Scalar>(&self, at: Deflection<S>) -> S {
        let depth = (at.d - at.upper).max(S::from(0.0));
        depth + depth * at.rate * self.loss
    }
    #[inline(always)]
    fn force_on<S: Scalar>(&self, piece: Piece, _: &[Piece], at: Deflection<S>) -> S {
        let depth = at.d - at.upper;
        if piece == Piece::Upper { depth + depth * at.rate * self.loss } else { S::from(0.0) }
    }
    fn edges<A: Angle>(&self, _: A, _: Side) -> Edges<A::Number> {
        Edges::at_rest(f64::NEG_INFINITY, self.touch)
    }
}

/// A torque that jumps up once a turn, falls as half a cosine, and announces its edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kick;

impl Excitation for Kick {
    fn jet<A: Angle>(&self, angle: A) -> Jet<A::Number> {
        (Jet::variable(angle.number()) * 0.5).cos()
    }
    fn edges(&self) -> Vec<f64> {
        vec![0.0]
    }
}

/// x1'' = kick - 0.1 x1' - k x1 - f(x1 - x2), x2'' = f(x1 - x2) - k x2 - 0.1 x2': a wheel that hits its
/// housing.
#[derive(Clone, Debug, PartialEq)]
pub struct Knock {
    /// Contact law.
    pub stop: SoftStop,
    /// Excitation.
    pub kick: Wave,
}

impl Shape for Knock {
    #[inline(always)]
    fn size(&self) -> Size {
        Size { dof: 2, waves: 1, contacts: 1, constants: 2, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        vec![Channel::new("speed", "1"), Channel::new("stiffness", "1")]
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        u[0] = self.kick.value(angle, side);
    }
    fn next_edge(&self, angle: f64) -> Option<f64> {
        self.kick.next_edge(angle)
    }
    #[inline(always)]
    fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        i: usize,
        _: Drives<'_, S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let (deflection, rate, touch) = (q[0] - q[1], v[0] - v[1], S::from(self.stop.touch));
        let force = law.force(
            i,
            &self.stop,
            Deflection { d: deflection, rate, lower: S::from(f64::NEG_INFINITY), upper: touch },
        );
        Contact { deflection, rate, upper: touch, force, ..Contact::default() }
    }
    #[inline(always)]
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let ([kick], [stiffness], f) = (u.waves(), u.constants(), self.contact(law, 0, u, q, v).force);
        a[0] = kick - v[0] * 0.1 - q[0] * stiffness - f;
        a[1] = f - q[1] * stiffness - v[1] * 0.1;
    }
    fn channels(&self) -> Vec<Channel> {
        vec![Channel::new("power of the kick", "W")]
    }
    fn write_channels(&self, u: Drives<'_, f64>, _: &[f64], v: &[f64], _: &[Contact], out: &mut [f64]) {
        let [kick] = u.waves();
        out[0] = kick * v[0];
    }
}

/// Four numbers, one for each of four runs: a [`Scalar`] of this crate.
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

/// Heun's method of order 2 with a fixed step `[s]`: an [`Integrator`] of this crate, which all analyses
/// accept.
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
    fn run(
        &self,
        model: &dyn Model,
        start: &State,
        t_end: f64,
        observer: &mut dyn Observer,
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
