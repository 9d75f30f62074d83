//! Gear trains as a shape.

use crate::contact::law_places::LawPlaces;
use crate::contact::laws::nonlinearity::LanesOf;
use crate::contact::{Backlash, Contact, Nonlinearity, PieceChoice};
use crate::error::{ParameterError, check};
use crate::excitation::{Angle, Side, Wave, earliest};
use crate::model::{Channel, Drives, Machine, Shape, Size};
use crate::scalar::Scalar;
use crate::trains::shape::drawing::{Drawing, Shown};
use crate::trains::shape::elements::{Elements, Entry, PlanetSet, Tooth, ToothRest};

/// A gear train made of [`Parts`](crate::trains::Parts).
///
/// M q'' + (C + Ω G) q' + (K - Ω² K_c) q + Σ_i b_i W_i = T,   d_i = b_iᵀ q - e_i(φ),
/// W_i = c_i d_i' + k_i(φ) f_i(d_i)
///
/// The coordinates q are deviations from the kinematic rotation: for each body the angle along its own mean
/// rotation `[rad]` (counterclockwise for a body at rest), then x and y `[m]` if it has bearings, in the
/// order of the bodies ([`TrainShape::coordinates`]). M is diagonal, b_i is the row of mesh i, f_i its
/// contact law, e_i its static transmission error, Ω the speed of a rotating frame.   Source: Kahraman 1994
/// (JSV 173, 125), Lin and Parker 1999 (J. Vib. Acoust. 121, 316).
///
/// Constants: `speed` [rad/s] of the reference body, each torque by its name [N m], `<mesh> damping` c
/// [N s/m], `<mesh> half backlash` b `[m]` (half of the backlash; if the law has one), `<mesh> friction` μ.
///
/// Contact i is mesh i, in the order of their statement; clearances of shafts and bearings follow, then the
/// inner kinks of the laws. Own channels: `<mesh> transmission error` b_iᵀ q `[m]`.
///
/// ```
/// use gear_dynamics::trains::{Body, MeshPart, Parts};
/// use gear_dynamics::{Model, Wave};
/// let mut parts = Parts::new();
/// parts.body("pinion", Body::new(2e-3)).body("wheel", Body::new(8e-3));
/// parts.mesh("mesh", "pinion", "wheel", MeshPart::external([20, 40], [0.03, 0.06], Wave::constant(2e8)?));
/// parts.torque("motor", "pinion", 30.0).torque("load", "wheel", -60.0);
/// let train = parts.build("pinion", 100.0)?;
/// // The torques balance: relative coordinates.
/// assert_eq!((train.dof(), train.constant("mesh damping")?), (1, 0.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type Train<N = Backlash> = Machine<TrainShape<N>>;

/// The shape of a [`Train`]: everything except the constants. Trains of equal shape share lanes; the
/// [`drawing`](TrainShape::drawing) does not matter for that.
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
    pub(crate) elements: Elements,
    /// Meshes, then clearances of shafts.
    pub(crate) teeth: Vec<Tooth<N>>,
    pub(crate) rests: Vec<ToothRest<N>>,
    pub(crate) places: LawPlaces,
    /// Whether the train has nothing but shafts, constant torques and meshes of at most two coordinates whose
    /// damping always acts. Its meshes then evaluate one shaft each.
    pub(crate) plain: bool,
    /// Number of springs, from the first one, that no mesh evaluates.
    pub(crate) loose: usize,
    /// For each torque, the coordinates on which its constant acts and how much of it: a constant torque, and
    /// the part of the load that balances a torque. Torques over the angle and over the speed come first.
    pub(crate) torques: Vec<Vec<Entry>>,
    pub(crate) constants: Vec<Channel>,
    pub(crate) sets: Vec<PlanetSet>,
    /// Masses and inertias of the inertial coordinates.
    pub(crate) masses: Vec<f64>,
    /// Accelerations by φ'' = 1.
    pub(crate) inertia: Vec<f64>,
    /// In relative coordinates: the coordinate that is left out, and the rigid motion, which is 1 there.
    pub(crate) frame: Option<(usize, Vec<f64>)>,
    pub(crate) drawing: Shown,
    /// Order of the fastest mesh.
    pub(crate) fastest: u32,
    /// φ'/speed.
    pub(crate) ratio: f64,
}

impl<N: Nonlinearity> TrainShape<N> {
    /// Names and units of the coordinates.
    pub fn coordinates(&self) -> &[Channel] {
        &self.coordinates
    }
    /// What a drawing of the train shows.
    pub fn drawing(&self) -> &Drawing {
        &self.drawing.0
    }
    /// Speed of the angle φ of the waves over the speed of the reference body.
    pub fn ratio(&self) -> f64 {
        self.ratio
    }

    /// Number of contacts whose edges are waves.
    #[inline(always)]
    fn moving(&self) -> usize {
        if N::HALF_BACKLASH { 0 } else { self.teeth.len() }
    }

    /// Net torques by coordinate, from the named torques: b_j = Σ share · T. A load balances a torque over
    /// the speed at the speed φ'.
    fn net<S: Scalar>(&self, torques: &[S], speed: S) -> Vec<S> {
        let mut net = vec![S::from(0.0); self.elements.per_inertia.len()];
        let waves = self.elements.torque_waves.len();
        for (i, (rows, torque)) in self.torques.iter().zip(torques).enumerate() {
            for entry in rows {
                let torque = match i.checked_sub(waves).and_then(|i| self.elements.motors.get(i)) {
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
    const LANES: LanesOf = N::LANES;
    #[inline(always)]
    fn size(&self) -> Size {
        let contacts = self.teeth.len() + self.elements.journals.len();
        let waves = self.elements.single.len() + 2 * self.elements.jets.len() + 4 * self.moving();
        let dof = self.elements.per_inertia.len();
        let torques = self.elements.torque_waves.len() + self.elements.motors.len();
        let constants = 1 + dof + torques + 2 * contacts + self.elements.frictions.len();
        let kinks = self.places.kinks();
        Size { dof, waves, contacts: contacts + kinks, kinks, constants }
    }
    fn names(&self) -> Vec<Channel> {
        self.constants.clone()
    }
    fn prepare<S: Scalar>(&self, constants: &[S]) -> Vec<S> {
        let (torques, rest) = constants[1..].split_at(self.torques.len());
        let speed = constants[0] * self.ratio;
        let mut prepared = vec![speed];
        prepared.extend(self.net(torques, speed));
        // Waves and motors come first among the torques.
        prepared.extend_from_slice(&torques[..self.elements.torque_waves.len() + self.elements.motors.len()]);
        let contacts = self.teeth.len() + self.elements.journals.len();
        let (damping, rest) = rest.split_at(contacts);
        prepared.extend_from_slice(damping);
        // A law without a half backlash of its own has no such constant.
        let own = if N::HALF_BACKLASH { contacts } else { self.elements.journals.len() };
        prepared.extend(std::iter::repeat_n(S::from(0.0), contacts - own));
        prepared.extend_from_slice(rest);
        prepared
    }
    fn check(&self, constants: &[f64]) -> Result<(), ParameterError> {
        check::scale("speed", constants[0])?;
        let rest = 1 + self.torques.len();
        self.constants[rest..]
            .iter()
            .zip(&constants[rest..])
            .try_for_each(|(name, value)| check::not_negative(&name.name, *value).map(drop))
    }

    #[inline(always)]
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        if self.plain {
            self.accelerate::<true, _, _>(law, u, q, v, a);
        } else if const { size_of::<S>() <= size_of::<f64>() } {
            self.accelerate_apart(law, u, q, v, a);
        } else {
            self.accelerate::<false, _, _>(law, u, q, v, a);
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
        let at = self.drives::<false, _>(u);
        let (i, kink) = self.places.place(i);
        let touch = self.touch(law, i, &at, q, v);
        kink.map_or(touch, |[of, k]| LawPlaces::kink(&self.teeth[of].law, k, touch))
    }

    #[inline(always)]
    fn inertia(&self) -> &[f64] {
        &self.inertia
    }
    fn reference_ratio(&self) -> f64 {
        self.ratio
    }
    fn bodies(&self) -> Vec<(&str, f64)> {
        let bodies = self.drawing().bodies.iter();
        bodies.filter_map(|body| Some((&body.name[..], body.ratio?))).collect()
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        let (single, rest) = u.split_at_mut(self.elements.single.len());
        for (u, wave) in single.iter_mut().zip(&self.elements.single) {
            *u = wave.value(angle, side);
        }
        let (jets, edges) = rest.split_at_mut(2 * self.elements.jets.len());
        for (u, wave) in jets.as_chunks_mut::<2>().0.iter_mut().zip(&self.elements.jets) {
            let jet = wave.jet(angle, side);
            *u = [jet.value, jet.rate];
        }
        for (u, tooth) in edges.as_chunks_mut::<4>().0.iter_mut().zip(&self.rests) {
            *u = tooth.mesh.law_edges(angle, side);
        }
    }
    fn next_edge(&self, angle: f64) -> Option<f64> {
        let waves = self.elements.single.iter().chain(&self.elements.jets).map(|wave| wave.next_edge(angle));
        let laws = self.rests.iter().map(|rest| rest.mesh.next_edge_of_law(angle));
        earliest(waves.chain(laws))
    }
    fn next_knot(&self, angle: f64) -> Option<f64> {
        let waves = self.elements.single.iter().chain(&self.elements.jets).map(|wave| wave.next_knot(angle));
        let laws = self.rests.iter().map(|rest| rest.mesh.next_knot_of_law(angle));
        earliest(waves.chain(laws))
    }
    fn repeats(&self) -> u32 {
        let waves = Wave::gcd_of_orders(self.elements.single.iter().chain(&self.elements.jets));
        let laws = self.rests.iter().map(|rest| rest.mesh.repeats_of_law());
        laws.fold(waves, crate::excitation::wave::gcd).max(1)
    }
    fn cycles_in_a_period(&self) -> u32 {
        self.fastest.div_ceil(self.repeats())
    }

    fn channels(&self) -> Vec<Channel> {
        let of = |ToothRest { channel, .. }: &ToothRest<N>| {
            Channel::new(format!("{} transmission error", channel.name), channel.unit.clone())
        };
        self.rests.iter().map(of).collect()
    }
    fn write_channels(
        &self,
        u: Drives<'_, f64>,
        _: &[f64],
        _: &[f64],
        contacts: &[Contact],
        out: &mut [f64],
    ) {
        let at = self.drives::<false, _>(u);
        for ((out, tooth), contact) in out.iter_mut().zip(&self.teeth).zip(contacts) {
            *out = contact.deflection + at.jets[tooth.error as usize][0];
        }
    }
}
