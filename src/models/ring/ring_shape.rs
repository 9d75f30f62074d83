//! The closed-loop ring of gears as a shape, with the angles as coordinates.

use crate::contact::law_places::LawPlaces;
use crate::contact::mesh::{ERROR, ERROR_RATE, LOWER, STIFFNESS, UPPER};
use crate::contact::{Backlash, Contact, Mesh, Nonlinearity, PieceChoice};
use crate::error::{ParameterError, check};
use crate::excitation::{Angle, Side, earliest};
use crate::model::{Channel, Drives, Machine, Shape, Size};
use crate::models::ring::columns::{Columns, STRIDE};
use crate::models::ring::ring_params::{Gear, RingParams, Shaft};
use crate::scalar::Scalar;

/// The frame of reference of the angles. Default: inertial.
///
/// ```
/// use gear_dynamics::{Model, Ring, excitation::Side, models::ring::{Frame, RingSet}};
/// let ring = Ring::as_printed(&RingSet::set_a(3, 1000.0).params()?)?;
/// let motor = |ring: &Ring| {
///     let rest = vec![0.0; ring.dof()];
///     let mut u = vec![0.0; ring.drives()];
///     let mut a = vec![0.0; ring.dof()];
///     ring.drive(0.0, Side::After, &mut u);
///     ring.accel(&u, &rest, &rest, &mut a);
///     a[0]
/// };
/// let difference = motor(&ring) - motor(&ring.clone().with_frame(Frame::Rigid));
/// assert!((difference - 712.736_411_9).abs() < 1e-6); // rigid acceleration α [rad/s²]
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Frame {
    /// At rest. If the torques do not balance, the angles grow without bound.
    #[default]
    Inertial,
    /// Moving with the rigid motion r_j (Ω0 t + α t²/2). All relative motions are exactly the same.
    Rigid,
}

/// The closed-loop ring of n gears.
///
/// Time in seconds; the coordinates are the angles [θ_M, θ_1, θ_L1, ..., θ_n, θ_Ln] `[rad]`. Source: Yao
/// 2020, Eq. (1), corrected; see [errata](crate::guide::errata).
///
/// d_i = R_i θ_i - R_{i+1} θ_{i+1} - e_i(φ),   W_i = C_i d_i' + K_i(φ) g(d_i),   φ = ω t,   indices cyclic
/// J_i θ_i'' + (motor shaft at i = 1) + R_i (W_i - W_{i-1}) + C_si (θ_i' - θ_Li') + K_si (θ_i - θ_Li) = 0
/// J_M θ_M'' + C_M (θ_M' - θ_1') + K_M (θ_M - θ_1) = T_M
/// J_Li θ_Li'' + C_si (θ_Li' - θ_i') + K_si (θ_Li - θ_i) = -T_Li
///
/// The equations count from 1 as the paper does; contacts, constants and channels count from j = 0 to n - 1:
/// number j belongs to mesh i = j + 1 and gear i = j + 1.
///
/// At a varying speed, a law of the mesh angle φ ([`VaryingSpeed`](crate::drives::VaryingSpeed)), the angles
/// are deviations from the ideal rotation r_j φ/z with the teeth z of gear 1: each body has the torque -J r
/// φ''/z, and the motor has the torque Σ r² J φ''/z, which accelerates them all.
///
/// Contact j is mesh i, with the deflection d_i `[m]` and the mesh force W_i `[N]`; g is its contact law,
/// whose inner kinks are further contacts.
///
/// Constants: `mesh frequency` ω [rad/s], `motor torque` T_M [N m], `mesh damping j` C_i [N s/m],
/// `load torque j` T_Li [N m].
///
/// Own channels of a mesh, in `[m]` and `[N]`: `transmission error j`, R_i θ_i - R_{i+1} θ_{i+1}, and
/// `stiffness times deflection j`, K_i d_i without the dead zone. The latter gives the 5.9 kN and 5.5 kN of
/// Yao 2020.
///
/// ```
/// use gear_dynamics::{models::ring::{Frame, RingSet}, Dop853, Integrator, Model, Ring, State};
/// let ring = Ring::as_printed(&RingSet::set_a(3, 1000.0).params()?)?.with_frame(Frame::Rigid);
/// let end = Dop853::new().end(&ring, &State::at_rest(ring.dof()), 1e-3)?;
/// assert!((end.q[0] - 3.746_261_04e-4).abs() < 1e-11); // θ_M [rad]
/// assert_eq!((&ring.names()[2].name[..], &ring.names()[7].name[..]), ("mesh damping 0", "load torque 2"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type Ring<N = Backlash> = Machine<RingShape<N>>;

/// The shape of [`Ring`]: all parameters except mesh frequency, torques and mesh dampings. Rings of equal
/// shape share lanes.
///
/// ```
/// use gear_dynamics::{Ring, models::ring::RingSet};
/// let ring = Ring::as_printed(&RingSet::set_a(3, 1000.0).params()?)?;
/// assert_eq!(ring.shape().meshes().len(), 3);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct RingShape<N = Backlash> {
    pub(crate) gears: Vec<Gear>,
    pub(crate) motor_inertia: f64,
    /// 1/J_M.
    pub(crate) per_motor: f64,
    pub(crate) motor_shaft: Shaft,
    pub(crate) meshes: Vec<Mesh<N>>,
    pub(crate) places: LawPlaces,
    pub(crate) frame: Frame,
    /// Rigid motion r_j: rate of each coordinate over the rate of θ_M.
    pub(crate) rigid: Vec<f64>,
    /// Accelerations by φ'' = 1: the bodies lag behind r_j φ/z by their inertia, and the torque Σ r_j² J_j
    /// φ''/z on the motor accelerates them.
    inertia: Vec<f64>,
    /// For each mesh, the index of the first mesh with an equal stiffness and of the first with an equal
    /// error. Equal waves are evaluated once.
    same: Vec<[usize; 2]>,
    /// Whether all meshes have the stiffness and the error of the first one. The drives contain them once.
    pub(crate) alike: bool,
    /// Whether the edges of any mesh move.
    edges_move: bool,
    /// 1/Σ r_j² J_j.
    pub(crate) per_inertia: f64,
    pub(crate) columns: Columns,
}

impl Ring {
    /// A ring of external meshes. The number of gears is even.
    ///
    /// # Errors
    /// [`ParameterError::OddRing`] for an odd number of gears, because such a ring locks. Errors of
    /// [`as_printed`](Ring::as_printed).
    pub fn new(params: &RingParams) -> Result<Self, ParameterError> {
        even(Ring::as_printed(params)?)
    }
    /// A ring of even or odd n by the equations of [`Ring`]. With odd n, for example n = 3 in Yao 2020, they
    /// describe a ring with one mesh that does not reverse the rotation.
    ///
    /// # Errors
    /// Fewer than 3 or more than 4095 gears; lists of meshes or dampings of another length than the gears; a
    /// value outside its range, named with its index; more than 10 000 jumps of a mesh stiffness in a mesh
    /// period, or a mean that is not positive.
    pub fn as_printed(params: &RingParams) -> Result<Self, ParameterError> {
        ring_of(params, Frame::Inertial)
    }
    /// The same ring in another frame.
    pub fn with_frame(self, frame: Frame) -> Self {
        let shape = RingShape { frame, ..self.shape().clone() };
        self.reshaped(shape)
    }
}

fn even<N: Nonlinearity>(ring: Ring<N>) -> Result<Ring<N>, ParameterError> {
    let gears = ring.gears();
    if gears % 2 == 1 { Err(ParameterError::OddRing { gears }) } else { Ok(ring) }
}

fn ring_of<N: Nonlinearity + Clone>(params: &RingParams<N>, frame: Frame) -> Result<Ring<N>, ParameterError> {
    params.check()?;
    let shape = RingShape::new(params, frame);
    let names = shape.names();
    let loads = params.gears.iter().map(|gear| gear.load.torque);
    let values = [params.omega, params.motor.torque]
        .into_iter()
        .chain(params.mesh_damping.iter().copied())
        .chain(loads);
    let constants: Vec<(&str, f64)> = names.iter().map(|channel| &channel.name[..]).zip(values).collect();
    Machine::of_constants(shape, &constants)
}

impl<N: Nonlinearity> Ring<N> {
    /// A ring of external meshes with other laws than [`Backlash`]. The number of gears is even. The code of
    /// such a ring is compiled in the program that calls it.
    ///
    /// # Errors
    /// As [`new`](Ring::new).
    pub fn of_laws(params: &RingParams<N>, frame: Frame) -> Result<Self, ParameterError>
    where
        N: Clone,
    {
        even(ring_of(params, frame)?)
    }
    /// [`as_printed`](Ring::as_printed) with other laws than [`Backlash`].
    ///
    /// # Errors
    /// As there.
    pub fn as_printed_of_laws(params: &RingParams<N>, frame: Frame) -> Result<Self, ParameterError>
    where
        N: Clone,
    {
        ring_of(params, frame)
    }

    /// Number of gears n.
    pub fn gears(&self) -> usize {
        self.shape().gears.len()
    }
    /// Rigid motion r_j: the rate of each coordinate over that of θ_M in a rigid motion. r_M = 1,
    /// r_i = r_Li = R_1/R_i.
    pub fn rigid_motion(&self) -> &[f64] {
        &self.shape().rigid
    }
    /// Mesh dampings C_i [N s/m].
    pub(crate) fn mesh_dampings(&self) -> &[f64] {
        &self.values()[2..2 + self.gears()]
    }
    /// Torque imbalance Σ r_j T_j = T_M - Σ r_Li T_Li [N m]. It is zero if the ring runs at constant mean
    /// speed.
    pub fn torque_imbalance(&self) -> f64 {
        let (motor, loads) = (self.values()[1], &self.values()[2 + self.gears()..]);
        motor - loads.iter().enumerate().map(|(i, load)| self.shape().rigid[2 + 2 * i] * load).sum::<f64>()
    }
    /// Rigid acceleration α = Σ r_j T_j/Σ r_j² J_j [rad/s²], by the torque imbalance.
    pub fn rigid_acceleration(&self) -> f64 {
        self.torque_imbalance() * self.shape().per_inertia
    }

    /// Drive slots of the lower and the upper edge `[m]` of a mesh. [`Noisy::add`](crate::drives::Noisy::add)
    /// varies the half backlash with the gains -g and g. The first mesh is 0.
    ///
    /// # Errors
    /// A mesh index of n or more.
    pub fn clearance_slots(&self, mesh: usize) -> Result<[usize; 2], ParameterError> {
        check::count("mesh", &[mesh], self.gears() - 1)?;
        Ok([STRIDE * mesh + LOWER, STRIDE * mesh + UPPER])
    }
}

impl<N: Nonlinearity> RingShape<N> {
    fn new(params: &RingParams<N>, frame: Frame) -> Self
    where
        N: Clone,
    {
        let r1 = params.gears[0].base_radius;
        let mut rigid = vec![1.0];
        rigid.extend(params.gears.iter().flat_map(|gear| [r1 / gear.base_radius; 2]));
        let meshes = params.meshes.clone();
        let first = |i: usize, is: &dyn Fn(&Mesh<N>, &Mesh<N>) -> bool| {
            (0..=i).find(|&j| is(&meshes[i], &meshes[j])).unwrap_or(i)
        };
        let same: Vec<[usize; 2]> = (0..meshes.len())
            .map(|i| {
                [first(i, &|a, b| a.stiffness() == b.stiffness()), first(i, &|a, b| a.error() == b.error())]
            })
            .collect();
        let alike = same.iter().all(|same| *same == [0, 0]);
        let edges_move = meshes.iter().any(|mesh| mesh.law().moves());
        // Torques are constants. With 0 in the shape, rings of different torques have equal shapes.
        let mut gears = params.gears.clone();
        gears.iter_mut().for_each(|gear| gear.load.torque = 0.0);
        let (motor_inertia, motor_shaft, columns) =
            (params.motor.inertia, params.motor.shaft, Columns::of(&gears));
        let mut shape = RingShape {
            gears,
            motor_inertia,
            per_motor: 1.0 / motor_inertia,
            motor_shaft,
            places: LawPlaces::of(meshes.iter().map(Mesh::law), meshes.len()),
            meshes,
            frame,
            rigid,
            inertia: Vec::new(),
            same,
            alike,
            edges_move,
            per_inertia: 0.0,
            columns,
        };
        let inertia = shape.rigid.iter().zip(shape.inertias()).map(|(r, j)| r * r * j).sum::<f64>();
        shape.per_inertia = 1.0 / inertia;
        let teeth = f64::from(params.teeth);
        shape.inertia = shape.rigid.iter().map(|r| -r / teeth).collect();
        shape.inertia[0] += inertia / (shape.motor_inertia * teeth);
        shape
    }

    /// Writes stiffness, error and rate of the error of each mesh, not its edges.
    #[inline]
    fn moving_waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        let waves = u.as_chunks_mut::<STRIDE>().0;
        let count = if self.alike { 1 } else { self.meshes.len() };
        for (i, (mesh, &[k, e])) in self.meshes.iter().zip(&self.same).enumerate().take(count) {
            waves[i][STIFFNESS] =
                if k < i { waves[k][STIFFNESS] } else { mesh.stiffness().value(angle, side) };
            [waves[i][ERROR], waves[i][ERROR_RATE]] = if e < i {
                [waves[e][ERROR], waves[e][ERROR_RATE]]
            } else {
                let error = mesh.error().jet(angle, side);
                [error.value, error.rate]
            };
        }
    }

    /// The meshes in order.
    pub fn meshes(&self) -> &[Mesh<N>] {
        &self.meshes
    }
    /// Moments of inertia by coordinate [kg m²].
    pub(crate) fn inertias(&self) -> Vec<f64> {
        let gears = self.gears.iter().flat_map(|gear| [gear.inertia, gear.load.inertia]);
        std::iter::once(self.motor_inertia).chain(gears).collect()
    }
}

impl<N: Nonlinearity> Shape for RingShape<N> {
    #[inline(always)]
    fn size(&self) -> Size {
        let (n, kinks) = (self.meshes.len(), self.places.kinks());
        Size { dof: 2 * n + 1, waves: STRIDE * n, contacts: n + kinks, kinks, constants: 2 + 2 * n }
    }
    fn names(&self) -> Vec<Channel> {
        let each = |name: &'static str, unit: &'static str| {
            (0..self.meshes.len()).map(move |i| Channel::new(format!("{name} {i}"), unit))
        };
        let shared = [Channel::new("mesh frequency", "rad/s"), Channel::new("motor torque", "N m")];
        shared.into_iter().chain(each("mesh damping", "N s/m")).chain(each("load torque", "N m")).collect()
    }
    fn check(&self, constants: &[f64]) -> Result<(), ParameterError> {
        let n = self.meshes.len();
        check::scale("mesh frequency", constants[0])?;
        constants[2..2 + n]
            .iter()
            .enumerate()
            .try_for_each(|(i, c)| check::not_negative(format!("mesh damping {i}"), *c).map(drop))
    }

    #[inline(always)]
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        self.accelerate(law, u, q, v, a);
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
        let (i, kink) = self.places.place(i);
        let touch = self.touch(law, i, u, q, v);
        kink.map_or(touch, |[of, k]| LawPlaces::kink(self.meshes[of].law(), k, touch))
    }

    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        u.fill(A::Number::from(0.0));
        self.moving_waves(angle, side, u);
        for (mesh, u) in self.meshes.iter().zip(u.chunks_exact_mut(STRIDE)) {
            mesh.edges(angle, side, u);
        }
    }
    /// Edges at rest are not written again.
    fn waves_again<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        if self.edges_move { self.waves(angle, side, u) } else { self.moving_waves(angle, side, u) }
    }
    #[inline(always)]
    fn inertia(&self) -> &[f64] {
        &self.inertia
    }
    fn repeats(&self) -> u32 {
        Mesh::common_order(&self.meshes)
    }
    fn next_edge(&self, angle: f64) -> Option<f64> {
        earliest(self.meshes.iter().map(|mesh| mesh.next_edge(angle)))
    }
    fn next_knot(&self, angle: f64) -> Option<f64> {
        earliest(self.meshes.iter().map(|mesh| mesh.next_knot(angle)))
    }

    /// Per mesh the dynamic transmission error R_i θ_i - R_{i+1} θ_{i+1} = d_i + e_i, and K_i d_i without the
    /// dead zone.
    fn channels(&self) -> Vec<Channel> {
        let of_mesh = |i| {
            [
                Channel::new(format!("transmission error {i}"), "m"),
                Channel::new(format!("stiffness times deflection {i}"), "N"),
            ]
        };
        (0..self.meshes.len()).flat_map(of_mesh).collect()
    }
    fn write_channels(
        &self,
        u: Drives<'_, f64>,
        _: &[f64],
        _: &[f64],
        contacts: &[Contact],
        out: &mut [f64],
    ) {
        for (i, (out, contact)) in out.chunks_exact_mut(2).zip(contacts).enumerate() {
            let mesh = &u.all_waves()[if self.alike { 0 } else { STRIDE * i }..][..STRIDE];
            out[0] = contact.deflection + mesh[ERROR];
            out[1] = mesh[STIFFNESS] * contact.deflection;
        }
    }
}
