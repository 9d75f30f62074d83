//! The ring as a model, in angles.

use super::algebra::{Columns, ERROR, ERROR_RATE, LOWER, LOWER_RATE, STIFFNESS, STRIDE, UPPER, UPPER_RATE};
use super::params::RingParams;
use crate::error::ParameterError;
use crate::excitation::{Repeats, Shared, earlier};
use crate::jacobian::dual_jacobian;
use crate::model::{AsIs, Channel, Contact, Generic, Jacobian, Law, Model, OnPieces, Periodic};
use crate::nonlinearity::{Backlash, Nonlinearity};
use crate::piece::{Piece, Side};
use crate::scalar::Scalar;
use std::f64::consts::TAU;
use std::ops::Range;
use std::sync::Arc;

/// The frame in which the angles are counted.
///
/// ```
/// assert_eq!(gear_dynamics::Frame::default(), gear_dynamics::Frame::Inertial);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Frame {
    /// At rest: with unbalanced torques the angles run away.
    #[default]
    Inertial,
    /// Moving with the rigid motion r_j (Ω0 t + α t²/2): exactly equivalent for all relative motion.
    Rigid,
}

/// The closed-loop ring of n gears over time `[s]`, in the angles [θ_M, θ_1, θ_L1, ..., θ_n, θ_Ln] `[rad]`.
///
/// d_i = R_i θ_i - R_{i+1} θ_{i+1} - e_i(t),   W_i = C_i d_i' + K_i(t) g(d_i),   indices cyclic
/// J_i θ_i'' + (motor shaft at i = 1) + R_i (W_i - W_{i-1}) + C_si (θ_i' - θ_Li') + K_si (θ_i - θ_Li) = 0
/// J_M θ_M'' + C_M (θ_M' - θ_1') + K_M (θ_M - θ_1) = T_M
/// J_Li θ_Li'' + C_si (θ_Li' - θ_i') + K_si (θ_Li - θ_i) = -T_Li
///
/// Contacts: mesh i, deflection d_i `[m]`, mesh force W_i `[N]`.   Source: Yao 2020, Eq. (1), corrected; errata in docs/errata.md.
///
/// ```
/// use gear_dynamics::{Frame, Integrator, Dop853, Model, Ring, RingSet, State};
/// let ring = Ring::as_printed(&RingSet::a(3, 1000.0).params()?)?.in_frame(Frame::Rigid);
/// let end = Dop853::new().end(&ring, &State::at_rest(ring.dof()), 1e-3)?;
/// assert!((end.q[0] - 3.746_261_04e-4).abs() < 1e-11); // θ_M [rad]
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Ring<N = Backlash> {
    pub(super) params: RingParams<N>,
    pub(super) frame: Frame,
    /// r_j: the rigid motion, per coordinate.
    pub(super) rigid: Vec<f64>,
    /// For each mesh the first one with the same stiffness and the same error: shared ones are evaluated once.
    same: Vec<[usize; 2]>,
    /// 1/Σ r_j² J_j.
    pub(super) per_inertia: f64,
    /// 1/ω.
    per_omega: f64,
    /// Whether an edge of a mesh moves.
    edges_move: bool,
    /// Whether all meshes share one stiffness and one error.
    alike: bool,
    pub(super) columns: Columns,
}

impl<N: Nonlinearity> Ring<N> {
    /// A ring of ordinary external meshes: an even number of gears.
    ///
    /// # Errors
    /// [`ParameterError::OddRing`] for an odd number, since such a ring locks; and every parameter out of its range.
    pub fn new(params: &RingParams<N>) -> Result<Self, ParameterError>
    where
        N: Clone,
    {
        let ring = Ring::as_printed(params)?;
        if ring.gears() % 2 == 1 {
            return Err(ParameterError::OddRing { gears: ring.gears() });
        }
        Ok(ring)
    }

    /// The equations as printed, for any n: with odd n they stand for a ring with one mesh that does not reverse. The paper's n = 3
    /// is such a ring.
    ///
    /// # Errors
    /// Every parameter out of its range, named with its place in the lists.
    pub fn as_printed(params: &RingParams<N>) -> Result<Self, ParameterError>
    where
        N: Clone,
    {
        params.check()?;
        let r1 = params.gears[0].base_radius;
        let mut rigid = vec![1.0];
        rigid.extend(params.gears.iter().flat_map(|gear| [r1 / gear.base_radius; 2]));
        let first = |i: usize, of: &dyn Fn(usize) -> Shared| (0..=i).find(|&j| Arc::ptr_eq(&of(i), &of(j))).unwrap_or(i);
        let meshes = &params.meshes;
        let same: Vec<[usize; 2]> =
            (0..meshes.len()).map(|i| [first(i, &|j| meshes[j].stiffness.clone()), first(i, &|j| meshes[j].error.clone())]).collect();
        let columns = Columns::of(&params.gears);
        let alike = same.iter().all(|same| *same == [0, 0]);
        let edges_move = meshes.iter().any(|mesh| mesh.law.repeats() != Repeats::Always);
        let mut ring = Ring {
            params: params.clone(),
            frame: Frame::Inertial,
            rigid,
            same,
            per_inertia: 0.0,
            per_omega: 1.0 / params.omega,
            edges_move,
            alike,
            columns,
        };
        ring.per_inertia = 1.0 / ring.rigid.iter().zip(ring.inertias()).map(|(r, j)| r * r * j).sum::<f64>();
        Ok(ring)
    }

    /// The same ring in another frame.
    pub fn in_frame(self, frame: Frame) -> Self {
        Ring { frame, ..self }
    }

    /// The parameters.
    pub fn params(&self) -> &RingParams<N> {
        &self.params
    }
    /// Number of gears n.
    pub fn gears(&self) -> usize {
        self.params.gears.len()
    }
    /// The frame.
    pub fn frame(&self) -> Frame {
        self.frame
    }
    /// r_j: how the coordinates move when the ring turns rigidly, r_M = 1, r_i = r_Li = R_1/R_i.
    pub fn rigid_motion(&self) -> &[f64] {
        &self.rigid
    }
    /// Moments of inertia by coordinate [kg m²].
    pub(super) fn inertias(&self) -> Vec<f64> {
        let gears = self.params.gears.iter().flat_map(|gear| [gear.inertia, gear.load.inertia]);
        std::iter::once(self.params.motor.inertia).chain(gears).collect()
    }
    /// Σ r_j T_j [N m]: zero for steady running.
    pub fn torque_imbalance(&self) -> f64 {
        let loads: f64 = self.params.gears.iter().enumerate().map(|(i, gear)| self.rigid[2 + 2 * i] * gear.load.torque).sum();
        self.params.motor.torque - loads
    }
    /// α = Σ r_j T_j/Σ r_j² J_j [rad/s²]: what the imbalance does to the whole ring.
    pub fn rigid_acceleration(&self) -> f64 {
        self.torque_imbalance() * self.per_inertia
    }

    /// Drive slot of the damping of a mesh [N s/m], for [`Held`](crate::Held).
    ///
    /// # Panics
    /// If the ring has no such mesh; the first one is 0.
    pub fn damping_slot(&self, mesh: usize) -> usize {
        assert!(mesh < self.gears(), "mesh {mesh} of a ring of {}", self.gears());
        self.phases() + 2 + mesh
    }
    /// Drive slots of the lower and upper edge of a mesh `[m]`.
    ///
    /// # Panics
    /// If the ring has no such mesh; the first one is 0.
    pub fn clearance_slots(&self, mesh: usize) -> [usize; 2] {
        assert!(mesh < self.gears(), "mesh {mesh} of a ring of {}", self.gears());
        [STRIDE * mesh + LOWER, STRIDE * mesh + UPPER]
    }
    /// Drive slot of the motor torque [N m].
    pub fn motor_torque_slot(&self) -> usize {
        self.phases() + 1
    }
    /// Drive slot of the load torque of a gear [N m].
    ///
    /// # Panics
    /// If the ring has no such gear; the first one is 0.
    pub fn load_torque_slot(&self, gear: usize) -> usize {
        assert!(gear < self.gears(), "gear {gear} of a ring of {}", self.gears());
        self.phases() + 2 + self.gears() + gear
    }
}

impl<N: Nonlinearity> Generic for Ring<N> {
    #[inline(always)]
    fn accel_on<S: Scalar, L: Law<S>>(&self, law: &L, u: &[S], q: &[S], v: &[S], a: &mut [S]) {
        self.accelerate(self.params.gears.len(), law, u, q, v, a);
    }

    #[inline(always)]
    fn contact_on<S: Scalar>(&self, which: Range<usize>, u: &[S], q: &[S], v: &[S], out: &mut [Contact<S>]) -> bool {
        self.touch(which, u, q, v, out);
        true
    }

    fn phases(&self) -> usize {
        STRIDE * self.params.gears.len()
    }
    fn phase_drives(&self, phase: f64, side: Side, u: &mut [f64]) {
        self.shapes(phase / self.params.omega, side, true, u);
    }
    fn constants(&self, u: &mut [f64]) {
        let n = self.gears();
        let (speed_and_torque, rest) = u[STRIDE * n..].split_at_mut(2);
        speed_and_torque.copy_from_slice(&[self.params.omega, self.params.motor.torque]);
        let (dampings, torques) = rest.split_at_mut(n);
        for (u, mesh) in dampings.iter_mut().zip(&self.params.meshes) {
            *u = mesh.damping;
        }
        for (u, gear) in torques.iter_mut().zip(&self.params.gears) {
            *u = gear.load.torque;
        }
    }
    fn at_speed(&self, speed: f64, u: &mut [f64]) {
        u[STRIDE * self.gears()] = speed;
    }
    /// Rings that are copies of one another, their excitations shared, up to torques and damping.
    fn shares_lanes_with(&self, other: &Self) -> bool {
        let same_mesh = |(a, b): (&crate::mesh::Mesh<N>, &crate::mesh::Mesh<N>)| {
            Arc::ptr_eq(&a.stiffness, &b.stiffness)
                && Arc::ptr_eq(&a.error, &b.error)
                && a.contact_damping == b.contact_damping
                && a.law.same_as(&b.law)
        };
        self.frame == other.frame
            && self.rigid == other.rigid
            && self.inertias() == other.inertias()
            && self.params.omega == other.params.omega
            && self.params.motor.shaft == other.params.motor.shaft
            && self
                .params
                .gears
                .iter()
                .zip(&other.params.gears)
                .all(|(a, b)| a.load.shaft == b.load.shaft && a.base_radius == b.base_radius)
            && self.params.meshes.iter().zip(&other.params.meshes).all(same_mesh)
    }
}

impl<N: Nonlinearity> Ring<N> {
    /// The drives that repeat, at time t; edges that stand still may be left out.
    #[inline]
    fn shapes(&self, t: f64, side: Side, edges_too: bool, u: &mut [f64]) {
        let waves = u.as_chunks_mut::<STRIDE>().0;
        if self.alike && !edges_too {
            let mesh = &self.params.meshes[0];
            let (stiffness, error) = (mesh.stiffness.value(t, side), mesh.error.jet(t, side));
            let rate = error.rate * self.per_omega;
            for wave in &mut waves[..self.params.meshes.len()] {
                (wave[STIFFNESS], wave[ERROR], wave[ERROR_RATE]) = (stiffness, error.value, rate);
            }
            return;
        }
        for (i, (mesh, &[k, e])) in self.params.meshes.iter().zip(&self.same).enumerate() {
            let stiffness = if k < i { waves[k][STIFFNESS] } else { mesh.stiffness.value(t, side) };
            let [error, rate] = if e < i {
                [waves[e][ERROR], waves[e][ERROR_RATE]]
            } else {
                let error = mesh.error.jet(t, side);
                [error.value, error.rate * self.per_omega]
            };
            let wave = &mut waves[i];
            (wave[STIFFNESS], wave[ERROR], wave[ERROR_RATE]) = (stiffness, error, rate);
            if edges_too {
                let edges = mesh.law.edges(t, side);
                (wave[LOWER], wave[UPPER]) = (edges.lower, edges.upper);
                (wave[LOWER_RATE], wave[UPPER_RATE]) = (edges.lower_rate * self.per_omega, edges.upper_rate * self.per_omega);
            }
        }
    }
}

impl<N: Nonlinearity> Model for Ring<N> {
    fn dof(&self) -> usize {
        2 * self.gears() + 1
    }
    #[inline]
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.accelerate_plain(&AsIs, u, q, v, a);
    }
    fn drives(&self) -> usize {
        (STRIDE + 2) * self.gears() + 2
    }
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        self.shapes(t, side, true, u);
        self.constants(u);
    }
    /// Torques, dampings and edges that stand still are left out.
    fn redrive(&self, t: f64, side: Side, u: &mut [f64]) {
        self.shapes(t, side, self.edges_move, u);
    }
    fn next_edge(&self, t: f64) -> Option<f64> {
        self.params.meshes.iter().fold(None, |first, mesh| earlier(first, mesh.next_edge(t)))
    }
    fn contacts(&self) -> usize {
        self.gears()
    }
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        self.contact_on(0..self.gears(), u, q, v, out);
    }
    #[inline]
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) -> bool {
        self.accelerate_plain(&OnPieces(pieces), u, q, v, a);
        true
    }
    fn jacobian(&self, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64], out: &mut Jacobian) -> bool {
        dual_jacobian(self, pieces, u, q, v, out)
    }
    /// Per mesh the transmission error R_i θ_i - R_{i+1} θ_{i+1} (the deflection with e_i), and K_i d_i without the dead zone, which is
    /// where the 5.9 and 5.5 kN of the paper come from.
    fn channels(&self) -> Vec<Channel> {
        let of_mesh =
            |i| [Channel::new(format!("transmission error {i}"), "m"), Channel::new(format!("stiffness times deflection {i}"), "N")];
        (1..=self.gears()).flat_map(of_mesh).collect()
    }
    fn observe(&self, u: &[f64], _: &[f64], _: &[f64], contacts: &[Contact], out: &mut [f64]) {
        for (i, out) in out.chunks_exact_mut(2).enumerate() {
            let mesh = &u[STRIDE * i..][..STRIDE];
            out[0] = contacts[i].deflection + mesh[ERROR];
            out[1] = mesh[STIFFNESS] * contacts[i].deflection;
        }
    }
}

impl<N: Nonlinearity> Periodic for Ring<N> {
    /// One mesh period 2π/ω `[s]`.
    fn period(&self) -> f64 {
        TAU / self.params.omega
    }
}
