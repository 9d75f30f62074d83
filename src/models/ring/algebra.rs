//! The algebra of the ring, gear by gear.

use crate::contact::law_places::LawPlaces;
use crate::contact::mesh::{ERROR, ERROR_RATE, LOWER, STIFFNESS, UPPER};
use crate::contact::{Contact, Deflection, Mesh, Nonlinearity, PieceChoice};
use crate::model::Drives;
use crate::models::ring::columns::{Parameters, STRIDE};
use crate::models::ring::ring_shape::{Frame, RingShape};
use crate::scalar::{Scalar, keep_rolled};

/// The motion of one gear: R, θ, θ', R θ and R θ'. Its two meshes use the same values.
#[derive(Clone, Copy)]
struct Turning<S> {
    radius: f64,
    q: S,
    v: S,
    path: S,
    speed: S,
}

/// Parameters, drives and state of the ring at one instant, as slices of known length.
struct Instant<'a, S> {
    gears: &'a [Parameters],
    lists: [&'a [f64]; 5],
    meshes: &'a [[S; STRIDE]],
    places: &'a LawPlaces,
    /// Whether all meshes have the waves of the first one.
    alike: bool,
    omega: S,
    motor_torque: &'a S,
    damping: &'a [S],
    load_torque: &'a [S],
    /// [θ_i, θ_Li] and their rates.
    q: &'a [[S; 2]],
    v: &'a [[S; 2]],
}

impl<'a, S: Scalar> Instant<'a, S> {
    #[inline(always)]
    fn of<N>(shape: &'a RingShape<N>, n: usize, u: Drives<'a, S>, q: &'a [S], v: &'a [S]) -> Self {
        // The lengths are checked here once; all slices below have known lengths.
        let (meshes, rest) = (&u.all_waves()[..STRIDE * n], &u.all_constants()[..2 * n + 1]);
        let (q, v) = (&q[..2 * n + 1], &v[..2 * n + 1]);
        let (gears, lists) = shape.columns.cut(n);
        Instant {
            gears,
            lists,
            meshes: &meshes.as_chunks().0[..n],
            places: &shape.places,
            alike: shape.alike,
            omega: u.speed(),
            motor_torque: &rest[0],
            damping: &rest[1..][..n],
            load_torque: &rest[1 + n..][..n],
            q: &q[1..].as_chunks().0[..n],
            v: &v[1..].as_chunks().0[..n],
        }
    }

    /// Parameter k of gear i.
    #[inline(always)]
    fn of_gear(&self, i: usize, k: usize) -> f64 {
        if const { size_of::<S>() == size_of::<f64>() } { self.gears[i][k] } else { self.lists[k][i] }
    }

    #[inline(always)]
    fn gear(&self, i: usize) -> Turning<S> {
        let (radius, q, v) = (self.of_gear(i, 0), self.q[i][0], self.v[i][0]);
        Turning { radius, q, v, path: q * radius, speed: v * radius }
    }

    /// Mesh force W_i `[N]` between gear i and the next gear.
    #[inline(always)]
    fn force<N: Nonlinearity, L: PieceChoice<S>>(
        &self,
        law: &L,
        meshes: &[Mesh<N>],
        i: usize,
        gear: &Turning<S>,
        next: &Turning<S>,
    ) -> S {
        let (moving, own) = (self.moving(i), &self.meshes[i]);
        let x = gear.path - next.path - moving[ERROR];
        let rate = gear.speed - next.speed - self.omega * moving[ERROR_RATE];
        let at = Deflection { d: x, rate, lower: own[LOWER], upper: own[UPPER] };
        meshes[i].force(law, self.places.of_law(i), at, rate, moving[STIFFNESS], self.damping[i])
    }

    /// The drives with stiffness and error of mesh i.
    #[inline(always)]
    fn moving(&self, i: usize) -> &[S; STRIDE] {
        &self.meshes[if self.alike { 0 } else { i }]
    }

    /// Writes θ_i'' of gear i and θ_Li'' of its load to `turns[i]`. `torque`: the sum of all torques on the
    /// gear except that of its output shaft, which is subtracted here.
    #[inline(always)]
    fn turn(&self, i: usize, gear: &Turning<S>, torque: S, turns: &mut [[S; 2]]) {
        let shaft =
            (gear.q - self.q[i][1]) * self.of_gear(i, 1) + (gear.v - self.v[i][1]) * self.of_gear(i, 2);
        turns[i][0] = (torque - shaft) * self.of_gear(i, 3);
        turns[i][1] = (shaft - self.load_torque[i]) * self.of_gear(i, 4);
    }
}

/// The gear after gear i of n.
#[inline(always)]
fn after(i: usize, n: usize) -> usize {
    if i + 1 == n { 0 } else { i + 1 }
}

impl<N: Nonlinearity> RingShape<N> {
    /// Accelerations by the equations of [`Ring`](crate::Ring). For `f64` and three gears the loops are
    /// compiled with the constant length 3.
    #[inline(always)]
    pub(crate) fn accelerate<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        u: Drives<'_, S>,
        q: &[S],
        v: &[S],
        a: &mut [S],
    ) {
        let n = self.meshes.len();
        if const { size_of::<S>() == size_of::<f64>() } && n == 3 {
            return self.accelerate_gears(3, law, u, q, v, a);
        }
        self.accelerate_gears(n, law, u, q, v, a);
    }

    /// Accelerations of a ring of n gears.
    #[inline(always)]
    fn accelerate_gears<S: Scalar, L: PieceChoice<S>>(
        &self,
        n: usize,
        law: &L,
        u: Drives<'_, S>,
        q: &[S],
        v: &[S],
        a: &mut [S],
    ) {
        let at = Instant::of(self, n, u, q, v);
        let a = &mut a[..2 * n + 1];
        let meshes = &self.meshes[..n];
        let shaft = (q[0] - q[1]) * self.motor_shaft.stiffness + (v[0] - v[1]) * self.motor_shaft.damping;
        a[0] = (*at.motor_torque - shaft) * self.per_motor;
        // Each mesh force is computed once and used for both gears. The last mesh joins gear n and gear 1.
        let turns = &mut a[1..].as_chunks_mut().0[..n];
        let driver = at.gear(0);
        let mut next = at.gear(1);
        let first = at.force(law, meshes, 0, &driver, &next);
        let mut w = first;
        for i in 1..n - 1 {
            let i = keep_rolled(i);
            let (gear, before) = (next, w);
            next = at.gear(i + 1);
            w = at.force(law, meshes, i, &gear, &next);
            at.turn(i, &gear, before * gear.radius - w * gear.radius, turns);
        }
        // Gear 1 is read a second time, so that its values need not be kept during the loop.
        let (last, driver) = (next, at.gear(0));
        let closing = at.force(law, meshes, n - 1, &last, &driver);
        at.turn(n - 1, &last, w * last.radius - closing * last.radius, turns);
        at.turn(0, &driver, shaft - first * driver.radius + closing * driver.radius, turns);
        if self.frame == Frame::Rigid {
            let mut torque = *at.motor_torque;
            for i in 0..n {
                torque = torque - at.load_torque[i] * self.rigid[1 + 2 * i];
            }
            let alpha = torque * self.per_inertia;
            let (a, rigid) = (&mut a[..2 * n + 1], &self.rigid[..2 * n + 1]);
            for j in 0..2 * n + 1 {
                let j = keep_rolled(j);
                a[j] = a[j] - alpha * rigid[j];
            }
        }
    }

    /// Deflection, edges and force of mesh i.
    #[inline(always)]
    pub(crate) fn touch<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        i: usize,
        u: Drives<'_, S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let n = self.meshes.len();
        let at = Instant::of(self, n, u, q, v);
        let (gear, next) = (at.gear(i), at.gear(after(i, n)));
        let (x, rate) = (gear.path - next.path, gear.speed - next.speed);
        let mut waves = at.meshes[i];
        waves[..LOWER].copy_from_slice(&at.moving(i)[..LOWER]);
        self.meshes[i].contact(law, at.places.of_law(i), &waves, at.omega, at.damping[i], x, rate)
    }
}
