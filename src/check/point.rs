//! The checks of a model at one state: finite values, Jacobian, pieces.

use crate::check::inconsistency::Inconsistency;
use crate::check::tolerances::{FINE, ROUGH, ROUNDING, differ};
use crate::contact::{Contact, Piece};
use crate::excitation::Side;
use crate::model::terms::TermsScratch;
use crate::model::{Jacobian, Model, State};
use crate::ode::probe::Probe;

/// Steps of the finite differences, as shares of the size of the coordinates or velocities.
///
/// A long step may cross an edge, and a short step is dominated by rounding. A derivative is reported only if
/// no usable step agrees with it.
const STEPS: [f64; 4] = [1e-6, 1e-8, 1e-10, 1e-12];

/// Exponents k of the steps size/2^k over which second differences contain rounding only.
const FAINT: std::ops::Range<i32> = 34..50;

/// A model at one state.
pub(crate) struct CheckPoint<'m> {
    pub(crate) model: &'m dyn Model,
    pub(crate) state: State,
    pub(crate) u: Vec<f64>,
    /// Largest absolute coordinate and velocity, or 1 if it is zero: the unit of the steps.
    pub(crate) size: [f64; 2],
    /// Σ_j |∂a_i/∂q_j q_j| + |a_i| of each acceleration, or the sum of the terms that its rounding suggests,
    /// if larger. Rounding is proportional to it.
    pub(crate) terms: Vec<f64>,
    /// Σ_j |∂d_i/∂q_j q_j| + |d_i| of each deflection.
    pub(crate) reach: Vec<f64>,
}

impl<'m> CheckPoint<'m> {
    pub(crate) fn new(model: &'m dyn Model, state: &State) -> Self {
        let mut u = vec![0.0; model.drives()];
        model.drive(state.t, Side::After, &mut u);
        let largest = |x: &[f64]| x.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let (q, v) = (largest(&state.q), largest(&state.v));
        let size = [if q > 0.0 { q } else { 1.0 }, if v > 0.0 { v } else { 1.0 }];
        let (terms, reach) = (vec![0.0; model.dof()], vec![0.0; model.contacts()]);
        CheckPoint { model, state: state.clone(), u, size, terms, reach }
    }

    /// The same coordinates and velocities at another instant. The sizes of the terms are kept.
    pub(crate) fn at(&self, t: f64) -> Self {
        let mut u = vec![0.0; self.model.drives()];
        self.model.drive(t, Side::After, &mut u);
        let State { q, v, .. } = &self.state;
        let mut later = CheckPoint {
            u,
            state: State::new(t, q, v),
            terms: self.terms.clone(),
            reach: Vec::new(),
            ..*self
        };
        let contacts = later.contacts(q, v);
        later.reach =
            self.reach.iter().zip(contacts).map(|(reach, c)| reach.max(c.deflection.abs())).collect();
        later
    }

    pub(crate) fn accel(&self, q: &[f64], v: &[f64]) -> Vec<f64> {
        // An entry that the model does not write is found.
        let mut a = vec![f64::NAN; self.model.dof()];
        self.model.accel(&self.u, q, v, &mut a);
        a
    }

    /// The acceleration on given pieces; `None` if the model does not offer it.
    pub(crate) fn accel_on_pieces(&self, pieces: &[Piece], q: &[f64], v: &[f64]) -> Option<Vec<f64>> {
        self.model.offers().pieces.then(|| {
            let mut a = vec![f64::NAN; self.model.dof()];
            self.model.accel_on_pieces(pieces, &self.u, q, v, &mut a);
            a
        })
    }

    /// The contacts at given coordinates and velocities, with the drives of this instant.
    pub(crate) fn contacts(&self, q: &[f64], v: &[f64]) -> Vec<Contact> {
        let mut contacts = vec![Contact::default(); self.model.contacts()];
        self.model.contact(&self.u, q, v, &mut contacts);
        contacts
    }

    pub(crate) fn pieces_at(&self, q: &[f64], v: &[f64]) -> Vec<Piece> {
        self.contacts(q, v).iter().map(Contact::piece).collect()
    }

    /// The terms of the accelerations at given coordinates: `terms`, or those that the model knows, if they
    /// are larger.
    pub(crate) fn terms_at(&self, q: &[f64], v: &[f64]) -> Vec<f64> {
        let mut terms = vec![0.0; self.model.dof()];
        if let Some(known) = self.model.offers().terms {
            known.terms(None, &self.u, q, v, &[q, v].concat(), &mut TermsScratch::default(), &mut terms);
        }
        terms.iter().zip(&self.terms).map(|(own, terms)| own.max(*terms)).collect()
    }

    /// Computes `terms` and `reach`.
    pub(crate) fn measure(&mut self) {
        let State { q, v, .. } = self.state.clone();
        let mut terms: Vec<f64> = self.accel(&q, &v).iter().map(|a| a.abs()).collect();
        let mut reach: Vec<f64> = self.contacts(&q, &v).iter().map(|c| c.deflection.abs()).collect();
        let deflections =
            |q: &[f64]| -> Vec<f64> { self.contacts(q, &v).iter().map(|c| c.deflection).collect() };
        for j in 0..q.len() {
            let h = 1e-4 * self.size[0];
            let (mut plus, mut minus) = (q.clone(), q.clone());
            (plus[j], minus[j]) = (q[j] + h, q[j] - h);
            let share = q[j].abs() / (2.0 * h);
            let add = |sums: &mut [f64], plus: &[f64], minus: &[f64]| {
                for ((sum, plus), minus) in sums.iter_mut().zip(plus).zip(minus) {
                    *sum += if (plus - minus).is_finite() { (plus - minus).abs() * share } else { 0.0 };
                }
            };
            add(&mut terms, &self.accel(&plus, &v), &self.accel(&minus, &v));
            add(&mut reach, &deflections(&plus), &deflections(&minus));
        }
        // Second differences over very short steps are rounding. They show the size of terms that cancel
        // inside the model.
        let here = self.accel(&q, &v);
        for j in 0..q.len() {
            for k in FAINT {
                let h = self.size[0] * 0.5f64.powi(k);
                let (mut plus, mut minus) = (q.clone(), q.clone());
                (plus[j], minus[j]) = (q[j] + h, q[j] - h);
                for (((terms, here), plus), minus) in
                    terms.iter_mut().zip(&here).zip(self.accel(&plus, &v)).zip(self.accel(&minus, &v))
                {
                    *terms = terms.max((plus - 2.0 * here + minus).abs() / f64::EPSILON);
                }
            }
        }
        (self.terms, self.reach) = (terms, reach);
        self.terms = self.terms_at(&q, &v);
    }

    /// Reports drives, accelerations and contacts that are NaN or infinite, and gaps of negative width.
    pub(crate) fn finite(&mut self, findings: &mut Vec<Inconsistency>) {
        let a = self.accel(&self.state.q, &self.state.v);
        for (what, values) in [("drive", &self.u), ("acceleration", &a)] {
            // A drive may be infinite: it may be the edge of a law without a flank on that side.
            let wrong = |x: f64| if what == "drive" { x.is_nan() } else { !x.is_finite() };
            let bad = values.iter().enumerate().filter(|(_, x)| wrong(**x));
            findings.extend(bad.map(|(index, _)| Inconsistency::NotFinite { what, index, t: self.state.t }));
        }
        let mut probe = Probe::new(self.model);
        let contacts = probe.read_contacts(self.state.t, Side::After, &self.state.q, &self.state.v);
        for (index, c) in contacts.iter().enumerate() {
            if !(c.deflection + c.rate + c.force).is_finite() || c.lower.is_nan() || c.upper.is_nan() {
                findings.push(Inconsistency::NotFinite { what: "contact", index, t: self.state.t });
            } else if c.lower > c.upper {
                findings.push(Inconsistency::NegativeGap { contact: index, lower: c.lower, upper: c.upper });
            }
        }
    }

    /// Compares the Jacobian with central differences, by steps in which no contact changes its piece.
    pub(crate) fn jacobian(&mut self, findings: &mut Vec<Inconsistency>) {
        if !self.model.offers().jacobian {
            return;
        }
        let n = self.model.dof();
        let mut given = Jacobian::new(n);
        let State { q, v, .. } = &self.state;
        self.model.jacobian(None, &self.u, q, v, &mut given);
        let pieces = self.pieces_at(q, v);
        for column in 0..2 * n {
            let (half, j) = (column / n, column % n);
            let entries = if half == 0 { given.q.column(j) } else { given.v.column(j) };
            // For each row: the difference by the longest step that disagrees, and whether any step agrees.
            let mut wrong: Vec<Option<f64>> = vec![None; n];
            let mut cleared = vec![false; n];
            for step in STEPS {
                let h = step * self.size[half];
                let (mut plus, mut minus) = ([q.clone(), v.clone()], [q.clone(), v.clone()]);
                plus[half][j] += h;
                minus[half][j] -= h;
                let twice = plus[half][j] - minus[half][j];
                if twice == 0.0 || [&plus, &minus].iter().any(|[q, v]| self.pieces_at(q, v) != pieces) {
                    continue;
                }
                let (a, b) = (self.accel(&plus[0], &plus[1]), self.accel(&minus[0], &minus[1]));
                for row in 0..n {
                    let differences = (a[row] - b[row]) / twice;
                    let rounding =
                        ROUNDING * (self.terms[row] + entries[row].abs() * self.size[half]) / twice;
                    let apart = (entries[row] - differences).abs();
                    if apart.is_nan() || apart > ROUGH * entries[row].abs().max(differences.abs()) + rounding
                    {
                        wrong[row].get_or_insert(differences);
                    } else {
                        cleared[row] = true;
                    }
                }
            }
            for row in (0..n).filter(|row| !cleared[*row]) {
                findings.extend(wrong[row].map(|differences| Inconsistency::Jacobian {
                    row,
                    column,
                    given: entries[row],
                    differences,
                }));
            }
        }
    }

    /// Compares the acceleration on the pieces on which the contacts stand with the acceleration itself: at
    /// the typical state, and with each contact moved to both sides of each of its edges.
    pub(crate) fn pieces(&mut self, findings: &mut Vec<Inconsistency>) {
        let State { q, v, .. } = self.state.clone();
        let mut places = vec![q];
        for contact in 0..self.model.contacts() {
            let Some(line) = self.line(contact) else { continue };
            for edge in line.edges() {
                places.extend([-0.3, 0.3].map(|share| line.to(line.place(edge) + share * line.length(edge))));
            }
        }
        let mut reported = vec![false; self.model.dof()];
        for q in places {
            let Some(fixed) = self.accel_on_pieces(&self.pieces_at(&q, &v), &q, &v) else { return };
            let free = self.accel(&q, &v);
            for component in 0..fixed.len() {
                let (on_pieces, accel) = (fixed[component], free[component]);
                if !reported[component]
                    && differ(on_pieces, accel, ROUNDING / FINE * self.terms[component], FINE)
                {
                    reported[component] = true;
                    findings.push(Inconsistency::Pieces { component, on_pieces, accel });
                }
            }
        }
    }
}
