//! Gear trains as a shape.

use crate::contact::laws::backlash::Backlash;
use crate::contact::laws::nonlinearity::Nonlinearity;
use crate::contact::mesh::{Mesh, MeshDrives};
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
use crate::trains::shape::elements::{Entry, Friction, Journal, Motor, PlanetPlace, Rotating, RowSpring, Spring, Tooth, ToothRest};

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
/// Contact i is mesh i, in the order of their statement; clearances of shafts and bearings follow. Own channels:
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
/// assert_eq!((train.dof(), train.constant("mesh damping")?), (2, 0.0));
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
    pub(crate) frictions: Vec<Friction>,
    pub(crate) journals: Vec<Journal>,
    pub(crate) motors: Vec<Motor>,
    pub(crate) entries: Vec<Entry>,
    /// Each wave once: stiffnesses and signs take one drive, errors two.
    pub(crate) single: Vec<Wave>,
    pub(crate) errors: Vec<Wave>,
    /// Planets by carrier, in inertial coordinates; none in relative ones.
    pub(crate) sets: Vec<Vec<PlanetPlace>>,
    /// Names of the springs, then of the row springs.
    pub(crate) spring_names: [Vec<String>; 2],
    /// Whether all rows have two numbers and there is nothing but springs and meshes.
    pub(crate) plain: bool,
    /// Torques that are constants: for each named one, the coordinates and how much of it acts there.
    pub(crate) torques: Vec<Vec<Entry>>,
    /// Torques that are waves: place of the wave among `single`, of the constant among the torques, pulls.
    pub(crate) torque_waves: Vec<(usize, usize, std::ops::Range<usize>)>,
    pub(crate) names: Vec<Channel>,
    /// φ'/speed.
    pub(crate) ratio: f64,
}

/// The drives of a train by their meaning.
pub(crate) struct At<'u, S> {
    single: &'u [S],
    errors: &'u [[S; 2]],
    /// Edges of laws without a half width of their own: lower, upper and their rates over φ.
    edges: &'u [[S; 4]],
    pub(crate) speed: S,
    net: &'u [S],
    torques: &'u [S],
    damping: &'u [S],
    /// b of each contact.
    half: &'u [S],
    friction: &'u [S],
}

/// The index, kept as a loop over elements for lanes: see [`keep_rolled`](crate::scalar::keep_rolled).
#[inline(always)]
fn kept<S>(index: usize) -> usize {
    if const { size_of::<S>() == size_of::<f64>() } { index } else { crate::scalar::keep_rolled(index) }
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

    /// Mesh cycles of the fastest wave in a period: the highest order of a wave over that of their repetition.
    pub fn cycles_in_a_period(&self) -> u32 {
        let waves = self.single.iter().chain(&self.errors);
        waves.map(Wave::order).max().unwrap_or(1).div_ceil(self.repeats())
    }

    /// Number of contacts whose edges are waves.
    #[inline(always)]
    fn moving(&self) -> usize {
        if N::HALF_WIDTH { 0 } else { self.teeth.len() }
    }

    #[inline(always)]
    pub(crate) fn drives<'u, S: Scalar>(&self, u: Drives<'u, S>) -> At<'u, S> {
        let (n, contacts) = (self.per_inertia.len(), self.teeth.len() + self.journals.len());
        let (single, rest) = u.all_waves().split_at(self.single.len());
        let (errors, edges) = rest.split_at(2 * self.errors.len());
        let (net, rest) = u.all_constants().split_at(n);
        let (torques, rest) = rest.split_at(self.torque_waves.len() + self.motors.len());
        let (damping, rest) = rest.split_at(contacts);
        let (half, friction) = rest.split_at(contacts);
        let (errors, edges) = (errors.as_chunks().0, edges.as_chunks().0);
        At { single, errors, edges, speed: u.speed(), net, torques, damping, half, friction }
    }

    /// Deflection and rate of tooth i. `WIDE`: whether its row may have more than two numbers.
    #[inline(always)]
    fn deflection<const WIDE: bool, S: Scalar>(
        &self,
        i: usize,
        tooth: &Tooth<N>,
        at: &At<S>,
        q: &[S],
        v: &[S],
    ) -> [S; 2] {
        let ([j, k], [r, s]) = (tooth.at.map(|at| at as usize), tooth.levers);
        let [e, rate] = at.errors[tooth.error as usize];
        let (mut d, mut dv) = (q[j] * r + q[k] * s - e, v[j] * r + v[k] * s - at.speed * rate);
        if WIDE {
            for entry in &self.entries[self.rests[i].more_levers.clone()] {
                d = d + q[entry.at] * entry.by;
                dv = dv + v[entry.at] * entry.by;
            }
        }
        [d, dv]
    }

    /// Force of tooth i. `WIDE`: whether its damping may act in contact alone.
    #[inline(always)]
    fn force<const WIDE: bool, S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        i: usize,
        tooth: &Tooth<N>,
        at: &At<S>,
        [d, rate]: [S; 2],
    ) -> S {
        let [lower, upper] = if N::HALF_WIDTH {
            [-at.half[i], at.half[i]]
        } else {
            [at.edges[i][0], at.edges[i][1]]
        };
        let (stiffness, damping) = (at.single[tooth.stiffness as usize], at.damping[i]);
        if WIDE {
            let drives = MeshDrives { stiffness, damping, lower, upper };
            return self.rests[i].mesh.force(law, i, d, rate, rate, drives);
        }
        stiffness * law.force(i, &tooth.law, d, rate, lower, upper) + damping * rate
    }

    /// Contact i as the solvers see it.
    #[inline(always)]
    fn touch<S: Scalar, L: PieceChoice<S>>(&self, law: &L, i: usize, at: &At<S>, q: &[S], v: &[S]) -> Contact<S> {
        let Some(tooth) = self.teeth.get(i) else {
            return self.journal_contact(law, i, at, q, v);
        };
        let [deflection, rate] = self.deflection::<true, S>(i, tooth, at, q, v);
        let force = self.force::<true, S, L>(law, i, tooth, at, [deflection, rate]);
        if N::HALF_WIDTH {
            let half = at.half[i];
            return Contact { deflection, rate, lower: -half, upper: half, force, ..Contact::default() };
        }
        let [lower, upper, lower_rate, upper_rate] = at.edges[i];
        let (lower_rate, upper_rate) = (lower_rate * at.speed, upper_rate * at.speed);
        Contact { deflection, rate, lower, upper, lower_rate, upper_rate, force }
    }

    /// r = √(x² + y²), its rate and the force along r, of contact i.
    #[inline(never)]
    fn journal_contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        i: usize,
        at: &At<S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let journal = &self.journals[i - self.teeth.len()];
        let [[x, vx], [y, vy]] = journal.levers.each_ref().map(|levers| self.row(levers.clone(), q, v));
        let r = (x * x + y * y + S::from(journal.least)).sqrt();
        let half = at.half[i];
        let rate = (x * vx + y * vy) / r;
        let force = law.force(i, &journal.law, r, rate, -half, half) * journal.stiffness;
        Contact { deflection: r, rate, lower: -half, upper: half, force, ..Contact::default() }
    }

    /// The equations of [`Train`].
    #[inline(always)]
    fn accelerate<const WIDE: bool, S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        u: Drives<'_, S>,
        q: &[S],
        v: &[S],
        a: &mut [S],
    ) {
        let n = self.per_inertia.len();
        let (at, q, v, a) = (self.drives(u), &q[..n], &v[..n], &mut a[..n]);
        let (net, per_inertia) = (&at.net[..n], &self.per_inertia[..n]);
        for j in 0..n {
            let j = kept::<S>(j);
            a[j] = net[j] * per_inertia[j];
        }
        for spring in &self.springs {
            let [j, k] = spring.ends.map(|end| kept::<S>(end as usize));
            let (x, y) = if WIDE {
                let [r, s] = spring.levers;
                (q[j] * r + q[k] * s, v[j] * r + v[k] * s)
            } else {
                (q[j] - q[k], v[j] - v[k])
            };
            let force = x * spring.stiffness + y * spring.damping;
            a[j] = a[j] - force * spring.pulls[0];
            a[k] = a[k] - force * spring.pulls[1];
        }
        // Slices of one length: their bounds are checked once.
        let teeth = &self.teeth[..];
        let (damping, half) = (&at.damping[..teeth.len()], &at.half[..teeth.len()]);
        let at = At { damping, half, ..at };
        for i in 0..teeth.len() {
            let i = kept::<S>(i);
            let tooth = &teeth[i];
            let deflection = self.deflection::<WIDE, S>(i, tooth, &at, q, v);
            let w = self.force::<WIDE, S, L>(law, i, tooth, &at, deflection);
            let [j, k] = tooth.at.map(|at| at as usize);
            a[j] = a[j] - w * tooth.pulls[0];
            a[k] = a[k] - w * tooth.pulls[1];
            if WIDE {
                self.pull(self.rests[i].more_pulls.clone(), w, a);
            }
        }
        if WIDE {
            let at = self.drives(u);
            self.others(law, &at, q, v, a);
        }
    }

    /// [`accelerate`](TrainShape::accelerate) with everything, compiled once and not into every loop of the solvers.
    #[inline(never)]
    fn accelerate_apart<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        u: Drives<'_, S>,
        q: &[S],
        v: &[S],
        a: &mut [S],
    ) {
        self.accelerate::<true, S, L>(law, u, q, v, a);
    }

    /// Σ lever q and Σ lever v.
    #[inline(always)]
    fn row<S: Scalar>(&self, levers: std::ops::Range<usize>, q: &[S], v: &[S]) -> [S; 2] {
        let mut sums = [S::from(0.0); 2];
        for entry in &self.entries[levers] {
            sums = [sums[0] + q[entry.at] * entry.by, sums[1] + v[entry.at] * entry.by];
        }
        sums
    }
    /// a -= w pulls.
    #[inline(always)]
    fn pull<S: Scalar>(&self, pulls: std::ops::Range<usize>, w: S, a: &mut [S]) {
        for entry in &self.entries[pulls] {
            a[entry.at] = a[entry.at] - w * entry.by;
        }
    }

    /// Everything but torques, two-ended springs and mesh forces. It is compiled once for each number type: inlined
    /// into all loops of the lanes it would take minutes to compile.
    #[inline(never)]
    fn others<S: Scalar, L: PieceChoice<S>>(&self, law: &L, at: &At<S>, q: &[S], v: &[S], a: &mut [S]) {
        for spring in &self.row_springs {
            let [x, rate] = self.row(spring.levers.clone(), q, v);
            self.pull(spring.pulls.clone(), x * spring.stiffness + rate * spring.damping, a);
        }
        let omega = at.speed * self.frame_ratio;
        for term in &self.rotating {
            let x = q[term.j] * term.damping + v[term.j] * term.gyroscopic + omega * q[term.j] * term.centripetal;
            a[term.i] = a[term.i] - omega * x;
        }
        for (friction, mu) in self.frictions.iter().zip(at.friction) {
            let (i, tooth) = (friction.tooth, &self.teeth[friction.tooth]);
            let d = self.deflection::<true, S>(i, tooth, at, q, v);
            let w = self.force::<true, S, L>(law, i, tooth, at, d);
            self.pull(friction.pulls.clone(), w * *mu * at.single[friction.sign], a);
        }
        for (i, journal) in self.journals.iter().enumerate() {
            let i = self.teeth.len() + i;
            let contact = self.journal_contact(law, i, at, q, v);
            let along = contact.force / contact.deflection;
            for (levers, pulls) in journal.levers.iter().zip(&journal.pulls) {
                let [x, rate] = self.row(levers.clone(), q, v);
                self.pull(pulls.clone(), along * x + at.damping[i] * rate, a);
            }
        }
        for (wave, constant, pulls) in &self.torque_waves {
            self.pull(pulls.clone(), at.single[*wave] * at.torques[*constant], a);
        }
        for motor in &self.motors {
            let slip = S::from(1.0) - (at.speed * motor.ratio + v[motor.at]) * (1.0 / motor.synchronous);
            let most = slip * slip + S::from(motor.breakdown_slip * motor.breakdown_slip);
            let torque = at.torques[motor.torque] * slip * (2.0 * motor.breakdown_slip) / most;
            self.pull(motor.pulls.clone(), torque, a);
        }
    }

    /// Net torques by coordinate, from the named torques: b_j = Σ share · T.
    fn net<S: Scalar>(&self, torques: &[S]) -> Vec<S> {
        let mut net = vec![S::from(0.0); self.per_inertia.len()];
        for (rows, torque) in self.torques.iter().zip(torques) {
            for entry in rows {
                net[entry.at] = net[entry.at] + *torque * entry.by;
            }
        }
        net
    }
}

impl<N: Nonlinearity> Shape for TrainShape<N> {
    #[inline(always)]
    fn size(&self) -> Size {
        let contacts = self.teeth.len() + self.journals.len();
        let waves = self.single.len() + 2 * self.errors.len() + 4 * self.moving();
        let dof = self.per_inertia.len();
        let torques = self.torque_waves.len() + self.motors.len();
        Size { dof, waves, contacts, constants: 1 + dof + torques + 2 * contacts + self.frictions.len() }
    }
    fn constants(&self) -> Vec<Channel> {
        self.names.clone()
    }
    fn prepare<S: Scalar>(&self, constants: &[S]) -> Vec<S> {
        let (torques, rest) = constants[1..].split_at(self.torques.len());
        let mut prepared = vec![constants[0] * self.ratio];
        prepared.extend(self.net(torques));
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
        if self.plain {
            self.accelerate::<false, S, L>(law, u, q, v, a);
        } else if const { size_of::<S>() <= size_of::<f64>() } {
            self.accelerate_apart(law, u, q, v, a);
        } else {
            self.accelerate::<true, S, L>(law, u, q, v, a);
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
        self.touch(law, i, &self.drives(u), q, v)
    }

    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        let (single, rest) = u.split_at_mut(self.single.len());
        for (u, wave) in single.iter_mut().zip(&self.single) {
            *u = wave.value(angle, side);
        }
        let (errors, edges) = rest.split_at_mut(2 * self.errors.len());
        for (u, wave) in errors.as_chunks_mut::<2>().0.iter_mut().zip(&self.errors) {
            let error = wave.jet(angle, side);
            *u = [error.value, error.rate];
        }
        for (u, tooth) in edges.as_chunks_mut::<4>().0.iter_mut().zip(&self.rests) {
            *u = tooth.mesh.law_edges(angle, side);
        }
    }
    fn next_edge(&self, angle: f64) -> Option<f64> {
        let waves = self.single.iter().chain(&self.errors).map(|wave| wave.next_edge(angle));
        let laws = self.rests.iter().map(|rest| rest.mesh.next_edge_of_law(angle));
        earliest(waves.chain(laws))
    }
    fn repeats(&self) -> u32 {
        let waves = Wave::divisor_of_orders(self.single.iter().chain(&self.errors));
        let laws = self.rests.iter().map(|rest| rest.mesh.repeats_of_law());
        laws.fold(waves, crate::excitation::wave::divisor).max(1)
    }

    fn channels(&self) -> Vec<Channel> {
        let names = self.names[1 + self.torques.len()..].iter();
        let mesh = |name: &Channel| name.name.trim_end_matches(" damping").to_string();
        names
            .take(self.teeth.len())
            .map(|name| Channel::new(format!("{} transmission error", mesh(name)), "m"))
            .collect()
    }
    fn observe(&self, u: Drives<'_, f64>, _: &[f64], _: &[f64], contacts: &[Contact], out: &mut [f64]) {
        let at = self.drives(u);
        for ((out, tooth), contact) in out.iter_mut().zip(&self.teeth).zip(contacts) {
            *out = contact.deflection + at.errors[tooth.error as usize][0];
        }
    }
}
