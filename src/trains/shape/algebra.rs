//! The accelerations and contacts of a train.

use crate::contact::deflection::Deflection;
use crate::contact::laws::nonlinearity::Nonlinearity;
use crate::contact::piece_choice::{PieceChoice, Place};
use crate::contact::tooth::Contact;
use crate::model::shape::Drives;
use crate::scalar::{Scalar, keep_rolled};
use crate::trains::shape::elements::Tooth;
use crate::trains::shape::train_shape::TrainShape;
use std::ops::Range;

/// The drives of a train by their meaning.
#[derive(Clone, Copy)]
pub(crate) struct At<'u, S> {
    single: &'u [S],
    pub(crate) jets: &'u [[S; 2]],
    /// Edges of laws without a half width of their own: lower, upper and their rates over φ.
    edges: &'u [[S; 4]],
    pub(crate) speed: S,
    net: &'u [S],
    torques: &'u [S],
    damping: &'u [S],
    /// b of each contact.
    half: &'u [S],
    friction: &'u [S],
    places: &'u [Place],
}

impl<N: Nonlinearity> TrainShape<N> {
    /// The drives by their meaning.
    #[inline(always)]
    pub(crate) fn drives<'u, S: Scalar>(&'u self, u: Drives<'u, S>) -> At<'u, S> {
        let (n, contacts) = (self.per_inertia.len(), self.teeth.len() + self.journals.len());
        let (single, rest) = u.all_waves().split_at(self.single.len());
        let (jets, edges) = rest.split_at(2 * self.jets.len());
        let (net, rest) = u.all_constants().split_at(n);
        let (torques, rest) = rest.split_at(self.torque_waves.len() + self.motors.len());
        let (damping, rest) = rest.split_at(contacts);
        let (half, friction) = rest.split_at(contacts);
        let (jets, edges) = (jets.as_chunks().0, edges.as_chunks().0);
        let places = self.places.of_laws();
        At { single, jets, edges, speed: u.speed(), net, torques, damping, half, friction, places }
    }

    /// Deflection and rate of tooth i.
    #[inline(always)]
    fn deflection<S: Scalar>(&self, i: usize, tooth: &Tooth<N>, at: &At<S>, q: &[S], v: &[S]) -> [S; 2] {
        let ([j, k], [r, s]) = (tooth.at.map(|at| at as usize), tooth.levers);
        let [e, rate] = at.jets[tooth.error as usize];
        let (mut d, mut dv) = (q[j] * r + q[k] * s - e, v[j] * r + v[k] * s - at.speed * rate);
        for entry in &self.entries[self.rests[i].more_levers.clone()] {
            d = d + q[entry.at] * entry.by;
            dv = dv + v[entry.at] * entry.by;
        }
        if self.rests[i].varying.is_empty() { [d, dv] } else { self.varying_row([d, dv], i, at, q, v) }
    }

    /// Adds the levers of noncircular gears to deflection and rate of tooth i. Like
    /// [`varying_pull`](TrainShape::varying_pull) it is kept out of the loops of round gears.
    #[inline(never)]
    fn varying_row<S: Scalar>(
        &self,
        [mut d, mut dv]: [S; 2],
        i: usize,
        at: &At<S>,
        q: &[S],
        v: &[S],
    ) -> [S; 2] {
        for lever in &self.varying[self.rests[i].varying.clone()] {
            let [g, rate] = at.jets[lever.wave];
            d = d + q[lever.at] * g * lever.lever;
            dv = dv + (v[lever.at] * g + q[lever.at] * at.speed * rate) * lever.lever;
        }
        [d, dv]
    }
    /// The accelerations of noncircular gears by the force of tooth i.
    #[inline(never)]
    fn varying_pull<S: Scalar>(&self, i: usize, w: S, at: &At<S>, a: &mut [S]) {
        for lever in &self.varying[self.rests[i].varying.clone()] {
            a[lever.at] = a[lever.at] - w * at.jets[lever.wave][0] * lever.pull;
        }
    }

    /// Force of tooth i.
    #[inline(always)]
    fn force<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        i: usize,
        tooth: &Tooth<N>,
        at: &At<S>,
        [x, rate]: [S; 2],
    ) -> S {
        let [lower, upper] =
            if N::HALF_WIDTH { [-at.half[i], at.half[i]] } else { [at.edges[i][0], at.edges[i][1]] };
        let (stiffness, damping) = (at.single[tooth.stiffness as usize], at.damping[i]);
        let deflection = Deflection { x, rate, lower, upper };
        self.rests[i].mesh.force(law, at.places[i], deflection, rate, stiffness, damping)
    }

    /// Contact i as the solvers see it.
    #[inline(always)]
    pub(crate) fn touch<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        i: usize,
        at: &At<S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let Some(tooth) = self.teeth.get(i) else {
            return self.journal_contact(law, i, at, q, v);
        };
        let [deflection, rate] = self.deflection(i, tooth, at, q, v);
        let force = self.force(law, i, tooth, at, [deflection, rate]);
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
        let half = at.half[i];
        if journal.levers[0].is_empty() {
            let at = Deflection { x: y, rate: vy, lower: -half, upper: half };
            let force = law.force(i, &journal.law, at) * journal.stiffness;
            let edges = Contact { lower: -half, upper: half, ..Contact::default() };
            return Contact { deflection: y, rate: vy, force, ..edges };
        }
        let r = (x * x + y * y + S::from(journal.least)).sqrt();
        let rate = (x * vx + y * vy) / r;
        let at = Deflection { x: r, rate, lower: -half, upper: half };
        let force = law.force(i, &journal.law, at) * journal.stiffness;
        Contact { deflection: r, rate, lower: -half, upper: half, force, ..Contact::default() }
    }

    /// The equations of [`Train`] with everything that its parts may be.
    #[inline(always)]
    pub(crate) fn accelerate<S: Scalar, L: PieceChoice<S>>(
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
            let j = keep_rolled(j);
            a[j] = net[j] * per_inertia[j];
        }
        for spring in &self.springs {
            let ([j, k], [r, s]) = (spring.ends.map(|end| keep_rolled(end as usize)), spring.levers);
            let force = (q[j] * r + q[k] * s) * spring.stiffness + (v[j] * r + v[k] * s) * spring.damping;
            a[j] = a[j] - force * spring.pulls[0];
            a[k] = a[k] - force * spring.pulls[1];
        }
        // Slices of one length: their bounds are checked once.
        let (teeth, rests) = (&self.teeth[..], &self.rests[..self.teeth.len()]);
        let (damping, half) = (&at.damping[..teeth.len()], &at.half[..teeth.len()]);
        let bounded = At { damping, half, places: &at.places[..teeth.len()], ..at };
        for i in 0..teeth.len() {
            let i = keep_rolled(i);
            let tooth = &teeth[i];
            let deflection = self.deflection(i, tooth, &bounded, q, v);
            let w = self.force(law, i, tooth, &bounded, deflection);
            let [j, k] = tooth.at.map(|at| at as usize);
            a[j] = a[j] - w * tooth.pulls[0];
            a[k] = a[k] - w * tooth.pulls[1];
            self.pull(rests[i].more_pulls.clone(), w, a);
            if !rests[i].varying.is_empty() {
                self.varying_pull(i, w, &bounded, a);
            }
        }
        self.others(law, &at, q, v, a);
    }

    /// [`accelerate`](TrainShape::accelerate), compiled once and not into every loop of the solvers.
    #[inline(never)]
    pub(crate) fn accelerate_apart<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        u: Drives<'_, S>,
        q: &[S],
        v: &[S],
        a: &mut [S],
    ) {
        self.accelerate(law, u, q, v, a);
    }

    /// Σ lever q and Σ lever v.
    #[inline(always)]
    fn row<S: Scalar>(&self, levers: Range<usize>, q: &[S], v: &[S]) -> [S; 2] {
        let mut sums = [S::from(0.0); 2];
        for entry in &self.entries[levers] {
            sums = [sums[0] + q[entry.at] * entry.by, sums[1] + v[entry.at] * entry.by];
        }
        sums
    }
    /// a -= w pulls.
    #[inline(always)]
    fn pull<S: Scalar>(&self, pulls: Range<usize>, w: S, a: &mut [S]) {
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
            let x =
                q[term.j] * term.damping + v[term.j] * term.gyroscopic + omega * q[term.j] * term.centripetal;
            a[term.i] = a[term.i] - omega * x;
        }
        for (friction, mu) in self.frictions.iter().zip(at.friction) {
            let (i, tooth) = (friction.tooth, &self.teeth[friction.tooth]);
            let d = self.deflection(i, tooth, at, q, v);
            let w = self.force(law, i, tooth, at, d);
            self.pull(friction.pulls.clone(), w * *mu * at.single[friction.sign], a);
        }
        for (i, journal) in self.journals.iter().enumerate() {
            let i = self.teeth.len() + i;
            let contact = self.journal_contact(law, i, at, q, v);
            if journal.levers[0].is_empty() {
                let [_, rate] = self.row(journal.levers[1].clone(), q, v);
                self.pull(journal.pulls[1].clone(), contact.force + at.damping[i] * rate, a);
                continue;
            }
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
            let kinematic = at.speed * motor.ratio;
            let kinematic = motor.rotation.map_or(kinematic, |wave| kinematic * at.jets[wave][0]);
            let share = motor.characteristic.at(kinematic + v[motor.at]);
            self.pull(motor.pulls.clone(), at.torques[motor.torque] * share, a);
        }
        for uneven in &self.uneven {
            let rate = at.jets[uneven.wave][1];
            a[uneven.at] = a[uneven.at] - at.speed * at.speed * rate * uneven.ratio;
        }
    }
}
