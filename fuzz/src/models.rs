//! Models behind one type, so that a generic run is compiled once: those of the crate, and one that a user
//! might write, with its mistakes.

use crate::case::{Case, Stop};
use crate::targets::{excitations, laws};
use gear_dynamics::contact::{Contact, ContactDamping, MixedLaw, Piece};
use gear_dynamics::excitation::Sum;
use gear_dynamics::model::{Jacobian, Offers};
use gear_dynamics::models::nfg::{
    CentreForcing, Damping, ErrorForcing, HalfBacklash, NfgPair2, NfgReading, Radius,
};
use gear_dynamics::models::ring::{Frame, RingParams, RingSet, Shaft};
use gear_dynamics::{Backlash, Mesh, Model, NfgPair, NfgParams, Periodic, Ring, State, Wave};

/// Any model, with the period that it states.
pub struct Erased {
    pub model: Box<dyn Model + Send + Sync>,
    pub period: f64,
    /// Whether the channels are finite while the motion is.
    pub sound: bool,
}

impl Erased {
    pub fn new(model: impl Model + Send + Sync + 'static, period: f64) -> Self {
        Erased { model: Box::new(model), period, sound: true }
    }
}

impl Model for Erased {
    fn dof(&self) -> usize {
        self.model.dof()
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.model.accel(u, q, v, a);
    }
    fn base(&self) -> Option<&dyn Model> {
        Some(&*self.model)
    }
    fn offers(&self) -> Offers<'_> {
        self.model.offers()
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.model.accel_on_pieces(pieces, u, q, v, a);
    }
    fn jacobian(&self, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64], out: &mut Jacobian) {
        self.model.jacobian(pieces, u, q, v, out);
    }
}

impl Periodic for Erased {
    fn period(&self) -> f64 {
        self.period
    }
}

/// Mistakes in a user's model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Slip {
    None,
    /// The acceleration is NaN from a time on.
    NotANumber(f64),
    /// A drive edge that is not later than the given time.
    DriveEdgeBehind,
    /// Drive edges closer than any step.
    EdgesWithoutEnd(f64),
    /// The lower edge lies above the upper one.
    NegativeGap,
    /// A deflection of NaN.
    Deflection,
    /// The rate of the contact has the wrong sign.
    Rate,
    /// A period of any size.
    Period(f64),
}

/// A chain of oscillators with a stop on the first one: a model that a new user might write.
#[derive(Clone, Debug)]
pub struct User {
    pub dof: usize,
    pub omega: f64,
    pub damping: f64,
    pub stiffness: f64,
    pub cubic: f64,
    pub force: f64,
    pub mean: f64,
    /// Stiffness of the stop and half backlash b of its gap; `None`: no contact.
    pub stop: Option<[f64; 2]>,
    /// Amplitude and frequency of the motion of the gap.
    pub shake: [f64; 2],
    /// Damping while the stop is in contact.
    pub touch: f64,
    pub pieces: bool,
    pub slip: Slip,
}

impl User {
    pub fn any(case: &mut Case) -> Self {
        let slip = if case.hostile() {
            let t = case.number(1.0);
            case.pick(&[
                Slip::NotANumber(t),
                Slip::DriveEdgeBehind,
                Slip::EdgesWithoutEnd(1e-14 * t.abs()),
                Slip::NegativeGap,
                Slip::Deflection,
                Slip::Rate,
                Slip::Period(t),
            ])
        } else {
            Slip::None
        };
        let user = User {
            dof: if case.hostile() { case.below(2) } else { 1 + case.below(3) },
            omega: case.quantity(1.0),
            damping: case.quantity(0.1),
            stiffness: case.quantity(1.0) * case.pick(&[0.0, 1.0, 1.0]),
            cubic: case.quantity(0.2) * case.pick(&[0.0, 0.0, 1.0]),
            force: case.quantity(0.5),
            mean: case.quantity(0.3) * case.pick(&[0.0, 1.0]),
            stop: case.chance(0.7).then(|| [case.quantity(10.0), case.quantity(0.5)]),
            shake: [case.quantity(0.2) * case.pick(&[0.0, 1.0]), case.quantity(3.0)],
            touch: case.quantity(0.5) * case.pick(&[0.0, 0.0, 1.0]),
            pieces: case.chance(0.6),
            slip,
        };
        case.note(|| format!("{user:?}"));
        user
    }

    fn edges(&self, t: f64) -> [f64; 4] {
        let ([_, b], [e, w]) = (self.stop.unwrap_or_default(), self.shake);
        let (shift, rate) = (e * (w * t).sin(), e * w * (w * t).cos());
        let b = if self.slip == Slip::NegativeGap { -b } else { b };
        [shift - b, shift + b, rate, rate]
    }
}

impl Model for User {
    fn dof(&self) -> usize {
        self.dof
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let mut piece = Piece::Gap;
        if self.stop.is_some() && self.dof > 0 {
            let mut contact = [Contact::default()];
            self.contact(u, q, v, &mut contact);
            piece = contact[0].piece();
        }
        self.held(piece, u, q, v, a);
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: self.pieces && self.contacts() > 0, ..Offers::default() }
    }
    fn next_edge(&self, t: f64) -> Option<f64> {
        match self.slip {
            Slip::DriveEdgeBehind => Some(t),
            Slip::EdgesWithoutEnd(spacing) => Some(t + spacing),
            _ => None,
        }
    }
    fn contacts(&self) -> usize {
        usize::from(self.stop.is_some() && self.dof > 0)
    }
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        if let Some([k, _]) = self.stop.filter(|_| self.dof > 0) {
            let [lower, upper, lower_rate, upper_rate] = self.edges(u[0]);
            let deflection = if self.slip == Slip::Deflection { f64::NAN } else { q[0] };
            let rate = if self.slip == Slip::Rate { -v[0] } else { v[0] };
            let force = k * ((q[0] - upper).max(0.0) - (lower - q[0]).max(0.0));
            out[0] = Contact { deflection, rate, lower, upper, lower_rate, upper_rate, force };
        }
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.held(pieces[0], u, q, v, a);
    }
}

impl User {
    fn held(&self, piece: Piece, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        for i in 0..self.dof {
            let before = if i > 0 { q[i - 1] } else { 0.0 };
            a[i] = -self.damping * v[i] - self.stiffness * (q[i] - before) - self.cubic * q[i].powi(3);
            a[i] += self.mean + self.force * (self.omega * u[0]).cos();
        }
        if let Some([k, _]) = self.stop.filter(|_| self.dof > 0) {
            let [lower, upper, rate, _] = self.edges(u[0]);
            match piece {
                Piece::Lower => a[0] -= k * (q[0] - lower) + self.touch * (v[0] - rate),
                Piece::Gap => {}
                Piece::Upper => a[0] -= k * (q[0] - upper) + self.touch * (v[0] - rate),
            }
        }
        if let Slip::NotANumber(from) = self.slip
            && u[0] > from
        {
            a.fill(f64::NAN);
        }
    }
}

/// Parameters of the face gear pair, near those of Liu 2021, Table 1.
pub fn pair_params(case: &mut Case) -> NfgParams {
    let table = NfgParams::table1();
    let params = NfgParams {
        module: case.number(table.module),
        pinion_teeth: if case.hostile() { case.count(18) as u32 } else { case.pick(&[18, 18, 16, 2]) },
        ratio: if case.hostile() { case.number(3.5) } else { case.pick(&[3.5, 3.5, 2.0]) },
        eccentric_ratio: case.number(0.2) * case.pick(&[0.0, 1.0]),
        pressure_angle: case.number(table.pressure_angle),
        load_torque: case.number(table.load_torque),
        inertia: case.number(table.inertia),
        stiffness: case.number(table.stiffness),
        stiffness_harmonics: case.pairs(2, 0.5e8),
        damping_ratio: case.number(table.damping_ratio),
        error: case.number(1e-5) * case.pick(&[0.0, 1.0]),
        error_harmonics: case.pairs(2, 1e-5),
        half_backlash: case.number(table.half_backlash),
        speed: case.number(table.speed),
    };
    case.note(|| format!("{params:?}"));
    params
}

/// Any reading of Liu 2021.
pub fn reading(case: &mut Case) -> NfgReading {
    let order = if case.hostile() { case.count(2) as u32 } else { 2 };
    // Thousands of terms at every evaluation are allowed but slow.
    let order = if order <= 10_000 { order.min(64) } else { order };
    let reading = NfgReading {
        radius: case.pick(&[Radius::Pitch, Radius::Base]),
        half_backlash: case.pick(&[HalfBacklash::Mean, HalfBacklash::Instant]),
        error_forcing: case.pick(&[ErrorForcing::MeanRadius, ErrorForcing::Frozen, ErrorForcing::Exact]),
        centre_forcing: case.pick(&[CentreForcing::Series(order), CentreForcing::Exact]),
        damping: case.pick(&[Damping::ConstantRatio, Damping::ConstantCoefficient]),
    };
    case.note(|| format!("{reading:?}"));
    reading
}

/// The numbers of a ring, near set A.
pub fn ring_set(case: &mut Case) -> RingSet {
    let gears = if case.hostile() { case.count(4) } else { case.pick(&[3, 4, 4, 6]) };
    // The set is created with a moderate number of gears, which is then replaced.
    let base = if gears <= 16 {
        RingSet::set_a(gears, 3000.0)
    } else {
        RingSet { gears, ..RingSet::set_a(4, 3000.0) }
    };
    let mut shaft = |k: f64, c: f64| Shaft { stiffness: case.number(k), damping: case.number(c) };
    let (motor_shaft, output_shaft) = (shaft(973.0, 0.0257), shaft(24_913.0, 0.117));
    let phases = (0..base.phases.len()).map(|i| case.number(1.0 + i as f64)).collect();
    let set = RingSet {
        rpm: case.number(base.rpm),
        teeth: if case.hostile() { case.count(30) as u32 } else { base.teeth },
        motor_inertia: case.number(base.motor_inertia),
        gear_inertia: case.number(base.gear_inertia),
        load_inertia: case.number(base.load_inertia),
        base_radius: case.number(base.base_radius),
        motor_shaft,
        output_shaft,
        mesh_stiffness: case.number(base.mesh_stiffness),
        stiffness_harmonics: if case.hostile() {
            case.list(2, 0.1)
        } else {
            base.stiffness_harmonics.clone()
        },
        mesh_damping: case.number(base.mesh_damping),
        half_backlash: case.number(1e-5),
        error: case.number(5e-6),
        phases: if case.hostile() { case.list(gears.min(8), 1.0) } else { phases },
        motor_torque: case.number(8.0),
        load_torque: case.number(base.load_torque),
        ..base
    };
    case.note(|| format!("{set:?}"));
    set
}

/// A mesh with any waves and any contact law.
fn mesh(case: &mut Case, stiffness: f64, error: f64) -> Result<Mesh<laws::Any>, Stop> {
    let damping = case.pick(&[ContactDamping::Always, ContactDamping::InContact]);
    let mut k = excitations::wave(case, 1, 0.2 * stiffness)?;
    if !case.hostile() {
        k = Wave::new(Sum::new(vec![Wave::constant(stiffness)?, k]));
    }
    let e = excitations::wave(case, 1, error)?;
    let mesh = Mesh::new(k, e, laws::law(case, 1e-5)?).with_contact_damping(damping);
    case.note(|| format!("{mesh:?}"));
    Ok(mesh)
}

/// The face gear pair with such a mesh.
pub fn own_pair(case: &mut Case) -> Result<NfgPair<laws::Any>, Stop> {
    let (params, reading, mesh) = (pair_params(case), reading(case), mesh(case, 3e8, 1e-5)?);
    Ok(NfgPair::of_mesh(&params, reading, mesh)?)
}

/// The pair of two degrees of freedom with such a mesh.
pub fn own_pair2(case: &mut Case) -> Result<NfgPair2<laws::Any>, Stop> {
    let (params, reading, mesh) = (pair_params(case), reading(case), mesh(case, 3e8, 1e-5)?);
    Ok(NfgPair2::of_mesh(&params, case.number(0.01), reading, mesh)?)
}

/// A ring with several contact laws, in either frame, as printed or corrected.
pub fn ring(case: &mut Case) -> Result<Ring<laws::Any>, Stop> {
    let params = ring_set(case).params()?;
    let own = case.chance(0.5);
    let mut meshes = Vec::new();
    for of_set in &params.meshes {
        meshes.push(if own {
            mesh(case, 1e8, 1e-5)?
        } else {
            let law = MixedLaw::Backlash(Backlash::new(case.number(1e-5))?);
            Mesh::new(of_set.stiffness().clone(), of_set.error().clone(), law)
        });
    }
    let mesh_damping =
        if case.hostile() { case.list(meshes.len(), 500.0) } else { vec![case.number(500.0); meshes.len()] };
    let RingParams { motor, gears, omega, teeth, .. } = params;
    let params = RingParams { motor, gears, meshes, mesh_damping, omega, teeth };
    let printed = params.gears.len() % 2 == 1 || case.chance(0.3);
    let frame = case.pick(&[Frame::Inertial, Frame::Rigid]);
    Ok(if printed { Ring::as_printed_of_laws(&params, frame)? } else { Ring::of_laws(&params, frame)? })
}

/// A state near another one, or one of the wrong size.
pub fn state(case: &mut Case, near: State) -> State {
    let mut state = near;
    if case.chance(0.3) {
        for x in state.q.iter_mut().chain(&mut state.v) {
            let size = x.abs().max(1e-5);
            *x += case.number(size) * case.signed();
        }
    }
    if case.hostile() {
        match case.below(4) {
            0 => drop(state.q.pop()),
            1 => state.v.push(0.0),
            2 => state.t = case.number(1.0),
            _ => state.q.iter_mut().chain(&mut state.v).for_each(|x| *x = case.number(1.0)),
        }
    }
    state
}
