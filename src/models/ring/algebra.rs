//! The algebra of the ring, gear by gear.

use super::params::Gear;
use super::system::{Frame, Ring};
use crate::mesh::{Mesh, MeshDrives};
use crate::model::{AsIs, Contact, Law};
use crate::nonlinearity::Nonlinearity;
use crate::scalar::{Scalar, one_by_one};

// Drives of a mesh: shapes of phase. After those of all meshes stand ω, T_M, C_1..n and T_L1..n.
pub(super) const STRIDE: usize = 7;
pub(super) const STIFFNESS: usize = 0; // K [N/m]
pub(super) const ERROR: usize = 1; // e [m]
pub(super) const ERROR_RATE: usize = 2; // de/d(ωt) [m]
pub(super) const LOWER: usize = 3;
pub(super) const UPPER: usize = 4;
pub(super) const LOWER_RATE: usize = 5;
pub(super) const UPPER_RATE: usize = 6;

/// What the algebra reads of a gear and its load: lanes multiply by one number at a time, and divide by none.
#[derive(Clone, Copy, Debug)]
pub(super) struct Numbers {
    /// R_i and R_{i+1}.
    radius: f64,
    next_radius: f64,
    /// K_si and C_si.
    stiffness: f64,
    damping: f64,
    /// 1/J_i and 1/J_Li.
    per_gear: f64,
    per_load: f64,
}

impl Numbers {
    pub(super) fn of(gears: &[Gear]) -> Vec<Self> {
        let numbers = |(gear, next): (&Gear, &Gear)| Numbers {
            radius: gear.base_radius,
            next_radius: next.base_radius,
            stiffness: gear.load.shaft.stiffness,
            damping: gear.load.shaft.damping,
            per_gear: 1.0 / gear.inertia,
            per_load: 1.0 / gear.load.inertia,
        };
        gears.iter().zip(gears.iter().cycle().skip(1)).map(numbers).collect()
    }
}

/// Everything that is known at one instant, by name and cut once to known lengths.
struct Instant<'a, S> {
    gears: &'a [Numbers],
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
    fn of(gears: &'a [Numbers], u: &'a [S], q: &'a [S], v: &'a [S]) -> Self {
        let n = gears.len();
        let (meshes, rest) = u.split_at(STRIDE * n);
        Instant {
            gears,
            meshes: &meshes.as_chunks().0[..n],
            omega: &rest[0],
            motor_torque: &rest[1],
            damping: &rest[2..][..n],
            load_torque: &rest[2 + n..][..n],
            q: &q[1..].as_chunks().0[..n],
            v: &v[1..].as_chunks().0[..n],
        }
    }

    /// d_i and d_i'.
    #[inline(always)]
    fn deflection(&self, i: usize) -> (S, S) {
        let j = if i + 1 == self.gears.len() { 0 } else { i + 1 };
        let (gear, mesh) = (&self.gears[i], &self.meshes[i]);
        let d = self.q[i][0] * gear.radius - self.q[j][0] * gear.next_radius - mesh[ERROR];
        let rate = self.v[i][0] * gear.radius - self.v[j][0] * gear.next_radius - *self.omega * mesh[ERROR_RATE];
        (d, rate)
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
    fn turn(&self, i: usize, torque: S, turns: &mut [[S; 2]]) {
        let (gear, [q, load_q], [v, load_v]) = (&self.gears[i], self.q[i], self.v[i]);
        let shaft = (q - load_q) * gear.stiffness + (v - load_v) * gear.damping;
        turns[i][0] = (torque - shaft) * gear.per_gear;
        turns[i][1] = (shaft - self.load_torque[i]) * gear.per_load;
    }
}

impl<N: Nonlinearity> Ring<N> {
    /// The equations of [`Ring`].
    #[inline(always)]
    pub(super) fn accelerate<S: Scalar, L: Law<S>>(&self, law: &L, u: &[S], q: &[S], v: &[S], a: &mut [S]) {
        let at = Instant::of(&self.numbers, u, q, v);
        let (gears, n) = (at.gears, at.gears.len());
        let meshes = &self.params.meshes[..n];
        let motor = &self.params.motor;
        let shaft = (q[0] - q[1]) * motor.shaft.stiffness + (v[0] - v[1]) * motor.shaft.damping;
        a[0] = (*at.motor_torque - shaft) * (1.0 / motor.inertia);
        // Round the ring, each mesh force handed on to the next gear; the last one closes it on the first.
        let turns = &mut a[1..].as_chunks_mut().0[..n];
        let first = at.force(law, meshes, 0, at.deflection(0));
        let mut w = first;
        for i in 1..n {
            let i = one_by_one(i);
            let before = w;
            w = at.force(law, meshes, i, at.deflection(i));
            at.turn(i, before * gears[i].radius - w * gears[i].radius, turns);
        }
        at.turn(0, shaft - first * gears[0].radius + w * gears[0].radius, turns);
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

    /// Every mesh.
    #[inline(always)]
    pub(super) fn touch<S: Scalar>(&self, u: &[S], q: &[S], v: &[S], out: &mut [Contact<S>]) {
        let at = Instant::of(&self.numbers, u, q, v);
        let n = at.gears.len();
        let (meshes, out) = (&self.params.meshes[..n], &mut out[..n]);
        for i in 0..n {
            let i = one_by_one(i);
            let (d, rate) = at.deflection(i);
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
