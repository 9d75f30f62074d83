//! Gear trains as a shape.

use crate::contact::law_places::LawPlaces;
use crate::contact::laws::backlash::Backlash;
use crate::contact::laws::nonlinearity::Nonlinearity;
use crate::contact::mesh::Mesh;
use crate::contact::piece_choice::PieceChoice;
use crate::contact::tooth::Contact;
use crate::error::{ParameterError, check};
use crate::excitation::angle::earliest;
use crate::excitation::side::Side;
use crate::excitation::wave::{Angle, Wave};
use crate::model::equations::Channel;
use crate::model::machine::Machine;
use crate::model::shape::{Drives, Shape, Size};
use crate::scalar::Scalar;
use crate::trains::shape::elements::{
    Entry, Friction, Journal, Lever, Motor, PlanetSet, Rotating, RowSpring, Spring, Tooth, ToothRest, Uneven,
};
use crate::trains::shape::walk::Walk;

/// A gear train made of [`Parts`](crate::trains::Parts).
///
/// M q'' + (C + Ω G) q' + (K - Ω² K_c) q + Σ_i b_i W_i = T,   d_i = b_iᵀ q - e_i(φ),
/// W_i = c_i d_i' + k_i(φ) f_i(d_i)
///
/// The coordinates q are deviations from the kinematic rotation: for each body the angle along its own mean
/// rotation `[rad]` (counterclockwise for a body at rest), then x and y `[m]` if it has bearings, in the
/// order of the bodies ([`TrainShape::coordinates`]). M is diagonal, b_i is the row of mesh i, f_i its contact
/// law, e_i its static transmission error, Ω the speed of a rotating frame.   Source: Kahraman 1994 (JSV 173,
/// 125), Lin and Parker 1999 (J. Vib. Acoust. 121, 316).
///
/// Constants: `speed` [rad/s] of the reference body, each torque by its name [N m], `<mesh> damping` c
/// [N s/m], `<mesh> half backlash` b `[m]` (half of the backlash; if the law has one), `<mesh> friction` μ.
///
/// Contact i is mesh i, in the order of their statement; clearances of shafts and bearings follow, then the
/// inner kinks of the laws. Own channels:
/// `<mesh> transmission error` b_iᵀ q `[m]`.
///
/// ```
/// use gear_dynamics::trains::{Body, MeshPart, Parts};
/// use gear_dynamics::{Model, Wave};
/// let mut parts = Parts::new();
/// parts.body("pinion", Body::new(2e-3)).body("wheel", Body::new(8e-3));
/// parts.mesh("mesh", "pinion", "wheel", MeshPart::external([20, 40], [0.03, 0.06], Wave::constant(2e8)?));
/// parts.torque("motor", "pinion", 30.0).torque("load", "wheel", -60.0);
/// let train = parts.build("pinion", 100.0)?;
/// assert_eq!((train.dof(), train.constant("mesh damping")?), (1, 0.0)); // the torques balance: relative coordinates
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type Train<N = Backlash> = Machine<TrainShape<N>>;

/// The shape of a [`Train`]: everything except the constants. Trains of equal shape share lanes.
///
/// ```
/// # use gear_dynamics::trains::{Body, MeshPart, Parts};
/// # use gear_dynamics::Wave;
/// let mut parts = Parts::new();
/// parts.body("pinion", Body::new(2e-3)).body("wheel", Body::new(8e-3));
/// parts.mesh("mesh", "pinion", "wheel", MeshPart::external([20, 40], [0.03, 0.06], Wave::constant(2e8)?));
/// let train = parts.build("pinion", 100.0)?;
/// assert_eq!(train.shape().coordinates()[1].name, "wheel angle");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct TrainShape<N = Backlash> {
    pub(crate) coordinates: Vec<Channel>,
    /// What the net torque on each coordinate is multiplied by: 1/J. The torques of a relative frame are
    /// prepared as accelerations, and this is 1.
    pub(crate) per_inertia: Vec<f64>,
    pub(crate) springs: Vec<Spring>,
    pub(crate) row_springs: Vec<RowSpring>,
    pub(crate) rotating: Vec<Rotating>,
    /// Ω/φ' of the rotating frame.
    pub(crate) frame_ratio: f64,
    /// Meshes, then clearances of shafts.
    pub(crate) teeth: Vec<Tooth<N>>,
    pub(crate) rests: Vec<ToothRest<N>>,
    pub(crate) places: LawPlaces,
    pub(crate) varying: Vec<Lever>,
    pub(crate) uneven: Vec<Uneven>,
    pub(crate) frictions: Vec<Friction>,
    pub(crate) journals: Vec<Journal>,
    pub(crate) motors: Vec<Motor>,
    pub(crate) entries: Vec<Entry>,
    /// Each wave once. Stiffnesses and signs take one drive; errors, varying levers and uneven rotations take two, of
    /// which the second is the rate over φ.
    pub(crate) single: Vec<Wave>,
    pub(crate) jets: Vec<Wave>,
    pub(crate) sets: Vec<PlanetSet>,
    /// Masses and inertias of the inertial coordinates.
    pub(crate) masses: Vec<f64>,
    /// In relative coordinates: the coordinate that is left out, and the rigid motion, which is 1 there.
    pub(crate) frame: Option<(usize, Vec<f64>)>,
    /// Order of the fastest mesh.
    pub(crate) fastest: u32,
    /// Names of the springs, then of the row springs.
    pub(crate) spring_names: [Vec<String>; 2],
    /// The algebra of a train with nothing but shafts, constant torques and meshes of two coordinates.
    pub(crate) walk: Option<Walk<N>>,
    /// For each torque, the coordinates on which its constant acts and how much of it: a constant torque, and the part of
    /// the load that balances a torque. Torques over the angle and over the speed come first.
    pub(crate) torques: Vec<Vec<Entry>>,
    /// Torques that are waves: place of the wave among `single`, of the constant among the torques, pulls.
    pub(crate) torque_waves: Vec<(usize, usize, std::ops::Range<usize>)>,
    pub(crate) names: Vec<Channel>,
    /// Names of the contacts and units of their deflections: meshes, clearances of shafts, clearances of bearings.
    pub(crate) contact_names: Vec<Channel>,
    /// φ'/speed.
    pub(crate) ratio: f64,
}

impl<N: Nonlinearity> TrainShape<N> {
    /// Names and units of the coordinates.
    pub fn coordinates(&self) -> &[Channel] {
        &self.coordinates
    }
    /// The mesh of each contact that is not a radial clearance.
    pub fn meshes(&self) -> impl Iterator<Item = &Mesh<N>> {
        self.rests.iter().map(|rest| &rest.mesh)
    }
    /// Speed of the angle φ of the waves over the speed of the reference body.
    pub fn ratio(&self) -> f64 {
        self.ratio
    }

    /// Number of contacts whose edges are waves.
    #[inline(always)]
    fn moving(&self) -> usize {
        if N::HALF_WIDTH { 0 } else { self.teeth.len() }
    }

    /// Net torques by coordinate, from the named torques: b_j = Σ share · T. A load balances a torque over the speed at
    /// the speed φ'.
    fn net<S: Scalar>(&self, torques: &[S], speed: S) -> Vec<S> {
        let mut net = vec![S::from(0.0); self.per_inertia.len()];
        let waves = self.torque_waves.len();
        for (i, (rows, torque)) in self.torques.iter().zip(torques).enumerate() {
            for entry in rows {
                let torque = match i.checked_sub(waves).and_then(|i| self.motors.get(i)) {
                    Some(motor) => *torque * motor.characteristic.at(speed * motor.ratio),
                    None => *torque,
                };
                net[entry.at] = net[entry.at] + torque * entry.by;
            }
        }
        net
    }

    /// A motion in the inertial coordinates, whose momentum along the rigid motion is 0.
    pub(crate) fn in_inertial(&self, motion: &[f64]) -> Vec<f64> {
        let Some((dropped, rigid)) = &self.frame else { return motion.to_vec() };
        let mut all = motion.to_vec();
        all.insert(*dropped, 0.0);
        let sum = |x: &[f64]| -> f64 { (0..rigid.len()).map(|j| self.masses[j] * rigid[j] * x[j]).sum() };
        let share = sum(&all) / sum(rigid);
        all.iter_mut().zip(rigid).for_each(|(x, r)| *x -= share * r);
        all
    }
}

impl<N: Nonlinearity> Shape for TrainShape<N> {
    #[inline(always)]
    fn size(&self) -> Size {
        let contacts = self.teeth.len() + self.journals.len();
        let waves = self.single.len() + 2 * self.jets.len() + 4 * self.moving();
        let dof = self.per_inertia.len();
        let torques = self.torque_waves.len() + self.motors.len();
        let constants = 1 + dof + torques + 2 * contacts + self.frictions.len();
        Size { dof, waves, contacts: contacts + self.places.kinks(), constants }
    }
    fn constants(&self) -> Vec<Channel> {
        self.names.clone()
    }
    fn prepare<S: Scalar>(&self, constants: &[S]) -> Vec<S> {
        let (torques, rest) = constants[1..].split_at(self.torques.len());
        let speed = constants[0] * self.ratio;
        let mut prepared = vec![speed];
        prepared.extend(self.net(torques, speed));
        // Waves and motors come first among the torques.
        prepared.extend_from_slice(&torques[..self.torque_waves.len() + self.motors.len()]);
        let contacts = self.teeth.len() + self.journals.len();
        let (damping, rest) = rest.split_at(contacts);
        prepared.extend_from_slice(damping);
        // A law without a half width of its own has no such constant.
        let own = if N::HALF_WIDTH { contacts } else { self.journals.len() };
        prepared.extend(std::iter::repeat_n(S::from(0.0), contacts - own));
        prepared.extend_from_slice(rest);
        prepared
    }
    fn check(&self, constants: &[f64]) -> Result<(), ParameterError> {
        check::scale("speed", constants[0])?;
        let rest = 1 + self.torques.len();
        self.names[rest..]
            .iter()
            .zip(&constants[rest..])
            .try_for_each(|(name, value)| check::not_negative(&name.name, *value).map(drop))
    }

    #[inline(always)]
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        if let Some(walk) = &self.walk {
            walk.accelerate(self, law, u, q, v, a);
        } else if const { size_of::<S>() <= size_of::<f64>() } {
            self.accelerate_apart(law, u, q, v, a);
        } else {
            self.accelerate(law, u, q, v, a);
        }
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
        let at = self.drives(u);
        self.places.contact(i, |i| &self.teeth[i].law, |i| self.touch(law, i, &at, q, v))
    }
    fn kinks(&self) -> usize {
        self.places.kinks()
    }

    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        let (single, rest) = u.split_at_mut(self.single.len());
        for (u, wave) in single.iter_mut().zip(&self.single) {
            *u = wave.value(angle, side);
        }
        let (jets, edges) = rest.split_at_mut(2 * self.jets.len());
        for (u, wave) in jets.as_chunks_mut::<2>().0.iter_mut().zip(&self.jets) {
            let jet = wave.jet(angle, side);
            *u = [jet.value, jet.rate];
        }
        for (u, tooth) in edges.as_chunks_mut::<4>().0.iter_mut().zip(&self.rests) {
            *u = tooth.mesh.law_edges(angle, side);
        }
    }
    fn next_edge(&self, angle: f64) -> Option<f64> {
        let waves = self.single.iter().chain(&self.jets).map(|wave| wave.next_edge(angle));
        let laws = self.rests.iter().map(|rest| rest.mesh.next_edge_of_law(angle));
        earliest(waves.chain(laws))
    }
    fn repeats(&self) -> u32 {
        let waves = Wave::divisor_of_orders(self.single.iter().chain(&self.jets));
        let laws = self.rests.iter().map(|rest| rest.mesh.repeats_of_law());
        laws.fold(waves, crate::excitation::wave::divisor).max(1)
    }
    fn cycles_in_a_period(&self) -> u32 {
        self.fastest.div_ceil(self.repeats())
    }

    fn channels(&self) -> Vec<Channel> {
        let of = |contact: &Channel| {
            Channel::new(format!("{} transmission error", contact.name), contact.unit.clone())
        };
        self.contact_names[..self.teeth.len()].iter().map(of).collect()
    }
    fn observe(&self, u: Drives<'_, f64>, _: &[f64], _: &[f64], contacts: &[Contact], out: &mut [f64]) {
        let at = self.drives(u);
        for ((out, tooth), contact) in out.iter_mut().zip(&self.teeth).zip(contacts) {
            *out = contact.deflection + at.jets[tooth.error as usize][0];
        }
    }
}
