//! The drives and the contacts of a train.

use crate::contact::law_places::LawPlaces;
use crate::contact::{Contact, Deflection, Nonlinearity, PieceChoice};
use crate::model::Drives;
use crate::scalar::Scalar;
use crate::trains::shape::elements::Tooth;
use crate::trains::shape::train_shape::TrainShape;
use std::ops::Range;

/// The drives of a train by their meaning.
#[derive(Clone, Copy)]
pub(crate) struct At<'u, S> {
    pub(crate) single: &'u [S],
    pub(crate) jets: &'u [[S; 2]],
    /// Edges of laws without a half backlash of their own: lower, upper and their rates over φ.
    pub(crate) edges: &'u [[S; 4]],
    pub(crate) speed: S,
    pub(crate) net: &'u [S],
    pub(crate) torques: &'u [S],
    pub(crate) damping: &'u [S],
    /// b of each contact.
    pub(crate) half: &'u [S],
    pub(crate) friction: &'u [S],
    /// The place of each law.
    pub(crate) places: &'u LawPlaces,
}

impl<N> Tooth<N> {
    /// Deflection and rate by the two coordinates of the tooth and their rates.
    #[inline(always)]
    pub(crate) fn deflection<S: Scalar>(&self, at: &At<S>, q: [S; 2], v: [S; 2]) -> [S; 2] {
        let ([r, s], [e, rate]) = (self.levers, at.jets[self.error as usize]);
        [q[0] * r + q[1] * s - e, v[0] * r + v[1] * s - at.speed * rate]
    }
}

impl<N: Nonlinearity> TrainShape<N> {
    /// The drives by their meaning. `PLAIN`: of a plain train, which has neither journals nor torques that
    /// vary.
    #[inline(always)]
    pub(crate) fn drives<'u, const PLAIN: bool, S: Scalar>(&'u self, u: Drives<'u, S>) -> At<'u, S> {
        let elements = &self.elements;
        let varying = if PLAIN { 0 } else { elements.torque_waves.len() + elements.motors.len() };
        let contacts = self.teeth.len() + if PLAIN { 0 } else { elements.journals.len() };
        let (single, rest) = u.all_waves().split_at(elements.single.len());
        let (jets, edges) = rest.split_at(2 * elements.jets.len());
        let (net, rest) = u.all_constants().split_at(elements.per_inertia.len());
        let (torques, rest) = rest.split_at(varying);
        let (damping, rest) = rest.split_at(contacts);
        let (half, friction) = rest.split_at(contacts);
        let (jets, edges) = (jets.as_chunks().0, edges.as_chunks().0);
        let places = &self.places;
        At { single, jets, edges, speed: u.speed(), net, torques, damping, half, friction, places }
    }

    /// Deflection and rate of tooth i.
    #[inline(always)]
    pub(crate) fn deflection<S: Scalar>(
        &self,
        i: usize,
        tooth: &Tooth<N>,
        at: &At<S>,
        q: &[S],
        v: &[S],
    ) -> [S; 2] {
        let [j, k] = tooth.at.map(|at| at as usize);
        self.with_further_levers(tooth.deflection(at, [q[j], q[k]], [v[j], v[k]]), i, at, q, v)
    }

    /// Adds all levers but the first two to deflection and rate of tooth i.
    #[inline(always)]
    pub(crate) fn with_further_levers<S: Scalar>(
        &self,
        [mut d, mut dv]: [S; 2],
        i: usize,
        at: &At<S>,
        q: &[S],
        v: &[S],
    ) -> [S; 2] {
        for entry in &self.elements.entries[self.rests[i].more_levers.clone()] {
            d = d + q[entry.at] * entry.by;
            dv = dv + v[entry.at] * entry.by;
        }
        if self.rests[i].varying.is_empty() { [d, dv] } else { self.varying_row([d, dv], i, at, q, v) }
    }

    /// Adds the levers of noncircular gears to deflection and rate of tooth i, out of the loops of round
    /// gears.
    #[inline(never)]
    fn varying_row<S: Scalar>(
        &self,
        [mut d, mut dv]: [S; 2],
        i: usize,
        at: &At<S>,
        q: &[S],
        v: &[S],
    ) -> [S; 2] {
        for lever in &self.elements.varying[self.rests[i].varying.clone()] {
            let [g, rate] = at.jets[lever.wave];
            d = d + q[lever.at] * g * lever.lever;
            dv = dv + (v[lever.at] * g + q[lever.at] * at.speed * rate) * lever.lever;
        }
        [d, dv]
    }

    /// Force of tooth i. `PLAIN`: its damping acts always.
    #[inline(always)]
    pub(crate) fn force<const PLAIN: bool, S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        i: usize,
        tooth: &Tooth<N>,
        at: &At<S>,
        [x, rate]: [S; 2],
    ) -> S {
        let [lower, upper] =
            if N::HALF_BACKLASH { [-at.half[i], at.half[i]] } else { [at.edges[i][0], at.edges[i][1]] };
        let (stiffness, damping) = (at.single[tooth.stiffness as usize], at.damping[i]);
        let deflection = Deflection { d: x, rate, lower, upper };
        if PLAIN {
            return stiffness * law.force(at.places.of_law(i), &tooth.law, deflection) + damping * rate;
        }
        self.rests[i].mesh.force(law, at.places.of_law(i), deflection, rate, stiffness, damping)
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
        let force = self.force::<false, _, _>(law, i, tooth, at, [deflection, rate]);
        if N::HALF_BACKLASH {
            let half = at.half[i];
            return Contact { deflection, rate, lower: -half, upper: half, force, ..Contact::default() };
        }
        let [lower, upper, lower_rate, upper_rate] = at.edges[i];
        let (lower_rate, upper_rate) = (lower_rate * at.speed, upper_rate * at.speed);
        Contact { deflection, rate, lower, upper, lower_rate, upper_rate, force }
    }

    /// r = √(x² + y²), its rate and the force along r, of contact i.
    #[inline(never)]
    pub(crate) fn journal_contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        i: usize,
        at: &At<S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let journal = &self.elements.journals[i - self.teeth.len()];
        let [[x, vx], [y, vy]] = journal.levers.each_ref().map(|levers| self.row(levers.clone(), q, v));
        let half = at.half[i];
        if journal.levers[0].is_empty() {
            let at = Deflection { d: y, rate: vy, lower: -half, upper: half };
            let force = law.force(i, &journal.law, at) * journal.stiffness;
            let edges = Contact { lower: -half, upper: half, ..Contact::default() };
            return Contact { deflection: y, rate: vy, force, ..edges };
        }
        let r = (x * x + y * y + S::from(journal.least)).sqrt();
        let rate = (x * vx + y * vy) / r;
        let at = Deflection { d: r, rate, lower: -half, upper: half };
        let force = law.force(i, &journal.law, at) * journal.stiffness;
        Contact { deflection: r, rate, lower: -half, upper: half, force, ..Contact::default() }
    }

    /// Σ lever q and Σ lever v.
    #[inline(always)]
    pub(crate) fn row<S: Scalar>(&self, levers: Range<usize>, q: &[S], v: &[S]) -> [S; 2] {
        let mut sums = [S::from(0.0); 2];
        for entry in &self.elements.entries[levers] {
            sums = [sums[0] + q[entry.at] * entry.by, sums[1] + v[entry.at] * entry.by];
        }
        sums
    }
}
