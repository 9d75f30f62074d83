//! Means of accelerations, Jacobians and contacts of a model at rest over a period.

use crate::contact::{Contact, Piece};
use crate::excitation::Side;
use crate::model::structure::gaps::first_negative;
use crate::model::structure::slopes::{Slopes, accelerate, offered};
use crate::model::terms::TermsScratch;
use crate::model::{Model, Periodic};
use crate::numeric::equations::entries::Entries;
use crate::numeric::gauss::FIVE;
use nalgebra::DMatrix;

/// The drives at some instants, with weights whose sum is 1.
pub(crate) struct Instants {
    drives: usize,
    /// One row of drives for each instant.
    u: Vec<f64>,
    weights: Vec<f64>,
}

impl Instants {
    /// One instant.
    pub(crate) fn at(model: &dyn Model, t: f64) -> Self {
        let mut u = vec![0.0; model.drives()];
        model.drive(t, Side::After, &mut u);
        Instants { drives: u.len(), u, weights: vec![1.0] }
    }

    /// The middles of `count` equal parts of the period.
    pub(crate) fn spread(model: &dyn Periodic, count: usize) -> Self {
        let (drives, period) = (model.drives(), model.period());
        let mut u = vec![0.0; drives * count];
        for k in 0..count {
            let t = period * ((k as f64 + 0.5) / count as f64);
            model.drive(t, Side::After, &mut u[drives * k..][..drives]);
        }
        Instants { drives, u, weights: vec![1.0 / count as f64; count] }
    }

    /// The points of the Gauss rule with 5 points on `panels` equal panels between two `bounds` each.
    pub(crate) fn of(model: &dyn Model, bounds: &[f64], panels: usize) -> Self {
        let (drives, span) = (model.drives(), bounds[bounds.len() - 1] - bounds[0]);
        let count = FIVE.len() * panels * (bounds.len() - 1);
        let mut instants =
            Instants { drives, u: vec![0.0; drives * count], weights: Vec::with_capacity(count) };
        for bound in bounds.windows(2) {
            let h = (bound[1] - bound[0]) / panels as f64;
            for panel in 0..panels {
                for [x, weight] in FIVE {
                    let row = drives * instants.weights.len();
                    let t = bound[0] + h * (panel as f64 + 0.5 + 0.5 * x);
                    model.drive(t, Side::After, &mut instants.u[row..][..drives]);
                    instants.weights.push(0.5 * weight * h / span);
                }
            }
        }
        instants
    }

    /// One instant in place of all if the drives are the same at all of them.
    pub(crate) fn joined(mut self) -> Self {
        let n = self.drives;
        if (1..self.weights.len()).all(|i| self.u[n * i..][..n] == self.u[..n]) {
            self.u.truncate(n);
            self.weights = vec![1.0];
        }
        self
    }

    /// Whether this is one instant.
    pub(crate) fn is_one(&self) -> bool {
        self.weights.len() == 1
    }

    /// The weight and the drives of each instant.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (f64, &[f64])> {
        self.weights
            .iter()
            .enumerate()
            .map(|(i, &weight)| (weight, &self.u[self.drives * i..][..self.drives]))
    }
}

/// Means of a model at rest over some instants.
pub(crate) struct Mean<'m> {
    pub(crate) model: &'m dyn Periodic,
    instants: Instants,
    /// Coordinates and velocities of 0.
    pub(crate) rest: Vec<f64>,
}

impl<'m> Mean<'m> {
    pub(crate) fn new(model: &'m dyn Periodic, instants: Instants) -> Self {
        Mean { model, instants, rest: vec![0.0; model.dof()] }
    }

    /// The mean acceleration at rest in a position.
    pub(crate) fn acceleration(&self, pieces: Option<&[Piece]>, q: &[f64]) -> Vec<f64> {
        let (mut mean, mut a) = (self.rest.clone(), self.rest.clone());
        for (weight, u) in self.instants.iter() {
            accelerate(self.model, pieces, u, q, &self.rest, &mut a);
            mean.iter_mut().zip(&a).for_each(|(mean, a)| *mean += weight * a);
        }
        mean
    }

    /// The mean size of each acceleration at q = 0.
    pub(crate) fn sizes(&self, pieces: &[Piece]) -> Vec<f64> {
        let (mut mean, mut a) = (self.rest.clone(), self.rest.clone());
        for (weight, u) in self.instants.iter() {
            accelerate(self.model, Some(pieces), u, &self.rest, &self.rest, &mut a);
            mean.iter_mut().zip(&a).for_each(|(mean, a)| *mean += weight * a.abs());
        }
        mean
    }

    /// The sums of the sizes of the terms of each acceleration at rest in a position, at the first instant;
    /// `None`: the model does not know them.
    pub(crate) fn terms(&self, pieces: &[Piece], q: &[f64]) -> Option<Vec<f64>> {
        let (known, mut sums) = (self.model.offers().terms?, self.rest.clone());
        let sizes: Vec<f64> = q.iter().chain(&self.rest).map(|x| x.abs()).collect();
        let (scratch, (_, u)) = (&mut TermsScratch::default(), self.instants.iter().next()?);
        known.terms(offered(self.model, Some(pieces)), u, q, &self.rest, &sizes, scratch, &mut sums);
        Some(sums)
    }

    /// The mean of ∂a/∂q at rest in a position.
    pub(crate) fn jacobian(
        &self,
        slopes: &mut Slopes<'m>,
        pieces: Option<&[Piece]>,
        q: &[f64],
    ) -> DMatrix<f64> {
        let mut mean = DMatrix::zeros(q.len(), q.len());
        for (weight, u) in self.instants.iter() {
            slopes.at(pieces, u, q, &self.rest);
            mean.zip_apply(&slopes.jacobian.q, |mean, here| *mean += weight * here);
        }
        mean
    }

    /// The mean of -∂a/∂q as sparse entries.
    pub(crate) fn stiffness(&self, slopes: &mut Slopes<'m>, pieces: Option<&[Piece]>, q: &[f64]) -> Entries {
        let (n, mut mean) = (q.len(), Entries::default());
        mean.n = n;
        let (expansion, pieces) = (self.model.offers().expansion, offered(self.model, pieces));
        for (k, (weight, u)) in self.instants.iter().enumerate() {
            let mut next = 0;
            let mut add = |i: usize, j: usize, slope: f64| {
                if j < n && k == 0 {
                    mean.list.push((i, j, -weight * slope));
                } else if j < n {
                    mean.list[next].2 -= weight * slope;
                    next += 1;
                }
            };
            if !expansion.is_some_and(|model| model.entries(pieces, u, q, &self.rest, &mut add)) {
                let full = self.jacobian(slopes, pieces, q);
                let places = (0..n).flat_map(|j| (0..n).map(move |i| (i, j)));
                let filled = places.filter(|&at| full[at] != 0.0);
                return Entries { n, list: filled.map(|(i, j)| (i, j, -full[(i, j)])).collect() };
            }
        }
        mean
    }

    /// The first gap that is negative at q = 0, in the order of the instants, with its edges.
    pub(crate) fn negative_gap(&self) -> Option<(usize, [f64; 2])> {
        let mut here = vec![Contact::default(); self.model.contacts()];
        self.instants.iter().find_map(|(_, u)| {
            self.model.contact(u, &self.rest, &self.rest, &mut here);
            first_negative(&here)
        })
    }

    /// Whether each contact is off its flank at some instant in a position, or touches one from its gap,
    /// within `near`.
    pub(crate) fn leaves(&self, pieces: &[Piece], q: &[f64], near: f64) -> Vec<bool> {
        let mut here = vec![Contact::default(); self.model.contacts()];
        let mut leaves = vec![false; here.len()];
        for (_, u) in self.instants.iter() {
            self.model.contact(u, q, &self.rest, &mut here);
            for (leaves, (c, piece)) in leaves.iter_mut().zip(here.iter().zip(pieces)) {
                *leaves |= match piece {
                    Piece::Upper => c.deflection <= c.upper + near,
                    Piece::Lower => c.deflection >= c.lower - near,
                    Piece::Gap => c.penetration() >= -near,
                };
            }
        }
        leaves
    }

    /// The mean contacts in a position.
    pub(crate) fn contacts(&self, q: &[f64]) -> Vec<Contact> {
        let mut here = vec![Contact::default(); self.model.contacts()];
        let mut sums = vec![[0.0; 7]; here.len()];
        for (weight, u) in self.instants.iter() {
            self.model.contact(u, q, &self.rest, &mut here);
            add(&mut sums, weight, &here);
        }
        sums.into_iter().map(contact_of).collect()
    }

    /// The mean contacts in a position, where a contact that swings across an edge of its gap has another
    /// deflection: that of its mean force on its flanks. With a stiffness k(t), its mean K and the upper edge
    /// u it is u + (1/T) ∫ k (d - u) dt/K, which is not the mean of d if k swings with it.
    pub(crate) fn pressed(&self, pieces: &[Piece], q: &[f64]) -> Vec<Contact> {
        let mut contacts = self.contacts(q);
        for i in self.swing(q) {
            let mut on = pieces.to_vec();
            let [lower, gap, upper] = [Piece::Lower, Piece::Gap, Piece::Upper].map(|piece| {
                on[i] = piece;
                self.acceleration(Some(&on), q)
            });
            // What the upper flank adds, and what the preload of the gap is, along the same direction.
            let (mut added, mut squares) = (0.0, 0.0);
            for ((lower, gap), upper) in lower.iter().zip(&gap).zip(&upper) {
                added += (upper - gap) * (upper - lower);
                squares += (upper - lower) * (upper - lower);
            }
            if squares > 0.0 && squares.is_finite() {
                let c = &mut contacts[i];
                c.deflection = c.upper - added / squares * (c.upper - c.lower);
            }
        }
        contacts
    }

    /// The contacts of finite gaps that lie on both sides of an edge, at one instant or another; none if they
    /// are more than [`SWINGING`].
    fn swing(&self, q: &[f64]) -> Vec<usize> {
        let mut here = vec![Contact::default(); self.model.contacts()];
        let mut sides = vec![[false; 4]; here.len()];
        for (_, u) in self.instants.iter() {
            self.model.contact(u, q, &self.rest, &mut here);
            for (sides, c) in sides.iter_mut().zip(&here) {
                let [lower, upper] = [c.deflection - c.lower, c.deflection - c.upper];
                let now = [lower < 0.0, lower > 0.0, upper < 0.0, upper > 0.0];
                sides.iter_mut().zip(now).for_each(|(side, now)| *side |= now);
            }
        }
        let gap = |i: usize| here[i].upper - here[i].lower;
        let swings = |i: usize| gap(i) > 0.0 && sides[i].chunks(2).any(|side| side == [true; 2]);
        let all: Vec<usize> = (0..here.len()).filter(|&i| swings(i) && gap(i).is_finite()).collect();
        if all.len() > SWINGING { Vec::new() } else { all }
    }
}

/// Largest number of contacts that swing across an edge whose mean forces on their flanks are computed: each
/// of them takes three mean accelerations.
const SWINGING: usize = 16;

/// Adds contacts with a weight.
fn add(sums: &mut [[f64; 7]], weight: f64, here: &[Contact]) {
    for (sums, c) in sums.iter_mut().zip(here) {
        let Contact { deflection, rate, lower, upper, lower_rate, upper_rate, force } = *c;
        let values = [deflection, rate, lower, upper, lower_rate, upper_rate, force];
        sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
    }
}

fn contact_of([deflection, rate, lower, upper, lower_rate, upper_rate, force]: [f64; 7]) -> Contact {
    Contact { deflection, rate, lower, upper, lower_rate, upper_rate, force }
}

/// Number of evenly spaced instants in a period that panels do not resolve: a prime number, which no order
/// divides.
pub(crate) const SPREAD: usize = 65_537;

/// Number of times that a panel is halved at most.
const HALVINGS: usize = 7;

/// The mean contacts of a model in a position over a period, by Gauss sums on `panels` panels between two
/// `bounds` each. If the sums on twice as many panels are the same within `agree`, they are returned: equal
/// panels that fill a period without edges are exact for nearly all orders of its waves, however fast they
/// are. A force by deflection has a kink where the teeth part. A panel is then halved until its share of each
/// mean force changes by at most `agree`. Kinks in thousands of mesh cycles change all panels together: the
/// period is then summed at even instants.
pub(crate) fn mean_contacts(
    model: &dyn Periodic,
    q: &[f64],
    (bounds, panels): (&[f64], usize),
    agree: f64,
) -> Vec<Contact> {
    let n = model.contacts();
    let mut u = vec![0.0; model.drives()];
    model.drive(bounds[0], Side::After, &mut u);
    let mut sums = PanelSums {
        model,
        q,
        rest: vec![0.0; q.len()],
        u: u.repeat(FIVE.len()),
        here: vec![Contact::default(); n],
        span: bounds[bounds.len() - 1] - bounds[0],
        agree,
        all: vec![[0.0; 7]; n],
        changes: vec![0.0; n],
    };
    let equal = |panels: usize| {
        bounds.windows(2).flat_map(move |bound| {
            let h = (bound[1] - bound[0]) / panels as f64;
            (0..panels).map(move |panel| [panel, panel + 1].map(|k| bound[0] + h * k as f64))
        })
    };
    let [coarse, fine] = [panels, 2 * panels].map(|panels| {
        let mut means = vec![[0.0; 7]; n];
        equal(panels).for_each(|ends| add_sums(&mut means, &sums.panel(ends)));
        means
    });
    if sums.are_same(&coarse, &fine) {
        return fine.into_iter().map(contact_of).collect();
    }
    for ends in equal(panels) {
        let whole = sums.panel(ends);
        sums.refine(ends, whole, HALVINGS);
    }
    if sums.changes.iter().any(|&change| change > KINKS * agree) {
        return Mean::new(model, Instants::spread(model, SPREAD)).contacts(q);
    }
    sums.all.into_iter().map(contact_of).collect()
}

/// Largest allowed sum of the last changes of all panels, in units of the change that one panel may have
/// `[1]`. A few kinks stay below it.
const KINKS: f64 = 64.0;

/// Adds sums of contacts.
fn add_sums(all: &mut [[f64; 7]], sums: &[[f64; 7]]) {
    all.iter_mut().zip(sums).for_each(|(all, x)| all.iter_mut().zip(x).for_each(|(all, x)| *all += x));
}

/// Sums of contacts over panels.
struct PanelSums<'m> {
    model: &'m dyn Periodic,
    q: &'m [f64],
    /// Velocities of 0.
    rest: Vec<f64>,
    /// The drives at the points of a panel.
    u: Vec<f64>,
    here: Vec<Contact>,
    span: f64,
    agree: f64,
    all: Vec<[f64; 7]>,
    /// The sum of the last changes of the force of each contact by halving.
    changes: Vec<f64>,
}

impl PanelSums<'_> {
    /// The share of a panel in the means.
    fn panel(&mut self, [from, to]: [f64; 2]) -> Vec<[f64; 7]> {
        let (h, drives) = (to - from, self.model.drives());
        let times = FIVE.map(|[x, _]| from + h * (0.5 + 0.5 * x));
        self.model.redrive(&times, Side::After, &mut self.u);
        let mut sums = vec![[0.0; 7]; self.here.len()];
        for (i, [_, weight]) in FIVE.into_iter().enumerate() {
            self.model.contact(&self.u[drives * i..][..drives], self.q, &self.rest, &mut self.here);
            add(&mut sums, 0.5 * weight * h / self.span, &self.here);
        }
        sums
    }

    /// Whether no force differs by more than `agree`.
    fn are_same(&self, a: &[[f64; 7]], b: &[[f64; 7]]) -> bool {
        a.iter().zip(b).all(|(a, b)| (a[6] - b[6]).abs() <= self.agree)
    }

    /// Adds a panel, whose share is `whole` by its five points.
    fn refine(&mut self, [from, to]: [f64; 2], whole: Vec<[f64; 7]>, halvings: usize) {
        let middle = 0.5 * (from + to);
        let ends = [[from, middle], [middle, to]];
        let [left, right] = ends.map(|ends| self.panel(ends));
        let mut both = left.clone();
        add_sums(&mut both, &right);
        if halvings > 0 && !self.are_same(&whole, &both) {
            ends.into_iter()
                .zip([left, right])
                .for_each(|(ends, half)| self.refine(ends, half, halvings - 1));
            return;
        }
        for ((change, before), after) in self.changes.iter_mut().zip(&whole).zip(&both) {
            *change += (before[6] - after[6]).abs();
        }
        add_sums(&mut self.all, &both);
    }
}

/// 0, the edges of the drives in the first period, and its end; at most `most` intervals, which then end
/// before the period does.
pub(crate) fn smooth_intervals(model: &dyn Periodic, most: usize) -> Vec<f64> {
    let period = model.period();
    let mut bounds = vec![0.0];
    let mut t = 0.0;
    while t < period && bounds.len() <= most {
        t = model.next_edge(t).filter(|&edge| edge > t && edge < period).unwrap_or(period);
        bounds.push(t);
    }
    bounds
}
