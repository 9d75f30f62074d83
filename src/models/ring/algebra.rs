//! The algebra of the ring, gear by gear.

use super::params::Gear;
use super::system::{Frame, Ring};
use crate::mesh::{Mesh, MeshDrives};
use crate::model::{AsIs, Contact, Law};
use crate::nonlinearity::Nonlinearity;
use crate::scalar::{Scalar, one_by_one};
use std::ops::Range;

// Drives of a mesh: shapes of phase. After those of all meshes stand ω, T_M, C_1..n and T_L1..n.
pub(super) const STRIDE: usize = 7;
pub(super) const STIFFNESS: usize = 0; // K [N/m]
pub(super) const ERROR: usize = 1; // e [m]
pub(super) const ERROR_RATE: usize = 2; // de/d(ωt) [m]
pub(super) const LOWER: usize = 3;
pub(super) const UPPER: usize = 4;
pub(super) const LOWER_RATE: usize = 5;
pub(super) const UPPER_RATE: usize = 6;

/// What the algebra reads of the gears and their loads, in lists: lanes then multiply by one number at a time, and divide by none. Side by
/// side, numbers of one gear would be bundled by the compiler where it should bundle lanes.
#[derive(Clone, Debug)]
pub(super) struct Columns(Vec<f64>);

impl Columns {
    pub(super) fn of(gears: &[Gear]) -> Self {
        let of: [fn(&Gear) -> f64; 5] = [
            |gear| gear.base_radius,
            |gear| gear.load.shaft.stiffness,
            |gear| gear.load.shaft.damping,
            |gear| 1.0 / gear.inertia,
            |gear| 1.0 / gear.load.inertia,
        ];
        Columns(of.iter().flat_map(|of| gears.iter().map(of)).collect())
    }

    /// R_i, K_si, C_si, 1/J_i and 1/J_Li.
    #[inline(always)]
    fn cut(&self, n: usize) -> [&[f64]; 5] {
        let all = &self.0[..5 * n];
        [&all[..n], &all[n..2 * n], &all[2 * n..3 * n], &all[3 * n..4 * n], &all[4 * n..5 * n]]
    }
}

/// A gear on its way round the ring: R, θ, θ', R θ and R θ', handed on from mesh to mesh.
#[derive(Clone, Copy)]
struct Turning<S> {
    radius: f64,
    q: S,
    v: S,
    path: S,
    speed: S,
}

/// Everything that is known at one instant, by name and cut once to known lengths.
struct Instant<'a, S> {
    radius: &'a [f64],
    stiffness: &'a [f64],
    shaft_damping: &'a [f64],
    per_gear: &'a [f64],
    per_load: &'a [f64],
    meshes: &'a [[S; STRIDE]],
    omega: &'a S,
    motor_torque: &'a S,
    damping: &'a [S],
    load_torque: &'a [S],
    /// [θ_i, θ_Li] and their rates.
    q: &'a [[S; 2]],
    v: &'a [[S; 2]],
}

impl<'a, S: Scalar> Instant<'a, S> {
    #[inline(always)]
    fn of(n: usize, columns: &'a Columns, u: &'a [S], q: &'a [S], v: &'a [S]) -> Self {
        // One look at each length; what follows is cut from it.
        let (u, q, v) = (&u[..(STRIDE + 2) * n + 2], &q[..2 * n + 1], &v[..2 * n + 1]);
        let (meshes, rest) = u.split_at(STRIDE * n);
        let [radius, stiffness, shaft_damping, per_gear, per_load] = columns.cut(n);
        Instant {
            radius,
            stiffness,
            shaft_damping,
            per_gear,
            per_load,
            meshes: &meshes.as_chunks().0[..n],
            omega: &rest[0],
            motor_torque: &rest[1],
            damping: &rest[2..][..n],
            load_torque: &rest[2 + n..][..n],
            q: &q[1..].as_chunks().0[..n],
            v: &v[1..].as_chunks().0[..n],
        }
    }

    #[inline(always)]
    fn gear(&self, i: usize) -> Turning<S> {
        let (radius, q, v) = (self.radius[i], self.q[i][0], self.v[i][0]);
        Turning { radius, q, v, path: q * radius, speed: v * radius }
    }

    /// d_i and d_i', from gear i and the next one.
    #[inline(always)]
    fn deflection(&self, i: usize, omega: S, gear: &Turning<S>, next: &Turning<S>) -> (S, S) {
        let mesh = &self.meshes[i];
        (gear.path - next.path - mesh[ERROR], gear.speed - next.speed - omega * mesh[ERROR_RATE])
    }

    /// W_i.
    #[inline(always)]
    fn force<N: Nonlinearity, L: Law<S>>(&self, law: &L, meshes: &[Mesh<N>], i: usize, (d, rate): (S, S)) -> S {
        let mesh = &self.meshes[i];
        let at = MeshDrives { stiffness: mesh[STIFFNESS], damping: self.damping[i], lower: mesh[LOWER], upper: mesh[UPPER] };
        meshes[i].force(law, i, d, rate, at)
    }

    /// θ_i'' and θ_Li'', from what else turns the gear.
    #[inline(always)]
    fn turn(&self, i: usize, gear: &Turning<S>, torque: S, turns: &mut [[S; 2]]) {
        let shaft = (gear.q - self.q[i][1]) * self.stiffness[i] + (gear.v - self.v[i][1]) * self.shaft_damping[i];
        turns[i][0] = (torque - shaft) * self.per_gear[i];
        turns[i][1] = (shaft - self.load_torque[i]) * self.per_load[i];
    }
}

/// The gear after gear i of n.
#[inline(always)]
fn after(i: usize, n: usize) -> usize {
    if i + 1 == n { 0 } else { i + 1 }
}

impl<N: Nonlinearity> Ring<N> {
    /// The equations of [`Ring`], on plain numbers: three gears are compiled for their number.
    #[inline(always)]
    pub(super) fn accelerate_plain<L: Law<f64>>(&self, law: &L, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        match self.params.gears.len() {
            3 => self.accelerate(3, law, u, q, v, a),
            n => self.accelerate(n, law, u, q, v, a),
        }
    }

    /// The equations of [`Ring`], n gears.
    #[inline(always)]
    pub(super) fn accelerate<S: Scalar, L: Law<S>>(&self, n: usize, law: &L, u: &[S], q: &[S], v: &[S], a: &mut [S]) {
        let at = Instant::of(n, &self.columns, u, q, v);
        let a = &mut a[..2 * n + 1];
        let meshes = &self.params.meshes[..n];
        let motor = &self.params.motor;
        let shaft = (q[0] - q[1]) * motor.shaft.stiffness + (v[0] - v[1]) * motor.shaft.damping;
        a[0] = (*at.motor_torque - shaft) * (1.0 / motor.inertia);
        // Round the ring, each mesh force handed on to the next gear; the last one closes it on the first.
        let turns = &mut a[1..].as_chunks_mut().0[..n];
        let omega = *at.omega;
        let driver = at.gear(0);
        let mut next = at.gear(after(0, n));
        let first = at.force(law, meshes, 0, at.deflection(0, omega, &driver, &next));
        let mut w = first;
        for i in 1..n {
            let i = one_by_one(i);
            let (gear, before) = (next, w);
            next = at.gear(after(i, n));
            w = at.force(law, meshes, i, at.deflection(i, omega, &gear, &next));
            at.turn(i, &gear, before * gear.radius - w * gear.radius, turns);
        }
        // Read again, not held all the way round.
        let driver = at.gear(0);
        at.turn(0, &driver, shaft - first * driver.radius + w * driver.radius, turns);
        if self.frame == Frame::Rigid {
            let mut torque = *at.motor_torque;
            for i in 0..n {
                torque = torque - at.load_torque[i] * self.rigid[1 + 2 * i];
            }
            let alpha = torque * self.per_inertia;
            let (a, rigid) = (&mut a[..2 * n + 1], &self.rigid[..2 * n + 1]);
            for j in 0..2 * n + 1 {
                let j = one_by_one(j);
                a[j] = a[j] - alpha * rigid[j];
            }
        }
    }

    /// Some meshes.
    #[inline(always)]
    pub(super) fn touch<S: Scalar>(&self, which: Range<usize>, u: &[S], q: &[S], v: &[S], out: &mut [Contact<S>]) {
        let n = self.params.gears.len();
        let at = Instant::of(n, &self.columns, u, q, v);
        let (meshes, out) = (&self.params.meshes[..n], &mut out[..n]);
        for i in which {
            let i = one_by_one(i);
            let (d, rate) = at.deflection(i, *at.omega, &at.gear(i), &at.gear(after(i, n)));
            let mesh = &at.meshes[i];
            out[i] = Contact {
                deflection: d,
                rate,
                lower: mesh[LOWER],
                upper: mesh[UPPER],
                lower_rate: *at.omega * mesh[LOWER_RATE],
                upper_rate: *at.omega * mesh[UPPER_RATE],
                force: at.force(&AsIs, meshes, i, (d, rate)),
            };
        }
    }
}
