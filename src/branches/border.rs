//! Branches that run to infinity: the size of a motion, and the border of parametric instability.

use crate::branches::family::Family;
use crate::branches::orbits::measured::Measured;
use crate::branches::points::test_functions::fold;
use crate::contact::{Contact, Piece};
use crate::excitation::Side;
use crate::linear::static_state;
use crate::model::recording::{Terms, TermsScratch};
use crate::model::structure::drifts::Drifts;
use crate::model::structure::slopes::{accelerate, offered};
use crate::model::{Jacobian, Model, Offers, Periodic, State};
use crate::numeric::search::brent::Brent;
use crate::numeric::search::parabola::vertex;
use crate::ode::Budget;
use crate::periodic::{Multipliers, Variation};

/// What the size of a motion is compared with.
#[derive(Clone, Debug)]
pub(crate) enum Reference {
    /// For each contact the largest of its gap, its static deflection past the edge and its motion along the
    /// first orbit.
    Contacts(Vec<f64>),
    /// The largest range of a coordinate along the first orbit.
    Coordinates(f64),
}

impl Reference {
    /// The reference of a model and its first orbit.
    pub(crate) fn new(model: &dyn Periodic, first: &Measured) -> Self {
        match Reference::without_orbit(model) {
            None => Reference::Coordinates(first.largest_range()),
            Some(sizes) => {
                let size = |(i, size): (usize, f64)| size.max(first.trace.farthest(i));
                Reference::Contacts(sizes.into_iter().enumerate().map(size).collect())
            }
        }
    }

    /// The reference of a model whose first orbit may be large: on a branch from infinity, or a line that
    /// starts at a fold.
    pub(crate) fn of_any_orbit(model: &dyn Periodic, first: &Measured) -> Self {
        let sizes = Reference::without_orbit(model).filter(|sizes| sizes.iter().all(|size| *size > 0.0));
        sizes.map_or_else(|| Reference::new(model, first), Reference::Contacts)
    }

    /// The gap of each contact or, where that is larger, its static deflection. `None` without edges.
    fn without_orbit(model: &dyn Periodic) -> Option<Vec<f64>> {
        if contacts_at_rest(model).iter().all(|c| !c.lower.is_finite() && !c.upper.is_finite()) {
            return None;
        }
        let pressed = static_state(model, None).ok().map(|state| state.contacts);
        let size = |(i, c): (usize, &Contact)| {
            let gap = if c.lower.is_finite() && c.upper.is_finite() { c.upper - c.lower } else { 0.0 };
            let past = |c: &Contact| (c.deflection - c.upper).max(c.lower - c.deflection);
            gap.max(pressed.as_ref().map_or(0.0, |pressed| past(&pressed[i])))
        };
        Some(contacts_at_rest(model).iter().enumerate().map(size).collect())
    }

    /// The reference for further motions, after one of this size without a border: load and gap of the model
    /// at its parameter count as well. Without contacts the motion itself is the reference, since a motion
    /// that no border explains is bounded.
    pub(crate) fn raised(&self, model: &dyn Periodic, motion: f64) -> Self {
        match (self, Reference::without_orbit(model)) {
            (Reference::Contacts(old), Some(sizes)) if sizes.len() == old.len() => {
                Reference::Contacts(old.iter().zip(&sizes).map(|(old, size)| old.max(*size)).collect())
            }
            (Reference::Coordinates(first), _) => Reference::Coordinates(first * motion),
            _ => self.clone(),
        }
    }

    /// The size of a motion, as a multiple of the reference.
    pub(crate) fn motion(&self, measured: &Measured) -> f64 {
        let share = |size: f64, reference: f64| if reference > 0.0 { size / reference } else { 0.0 };
        match self {
            Reference::Coordinates(first) => share(measured.largest_range(), *first),
            Reference::Contacts(sizes) => {
                let of = sizes.iter().enumerate().map(|(i, size)| share(measured.trace.farthest(i), *size));
                of.fold(0.0, f64::max)
            }
        }
    }
}

/// The contacts at time 0 with all coordinates and velocities 0.
fn contacts_at_rest(model: &dyn Periodic) -> Vec<Contact> {
    let (mut u, rest) = (vec![0.0; model.drives()], vec![0.0; model.dof()]);
    model.drive(0.0, Side::After, &mut u);
    let mut contacts = vec![Contact::default(); model.contacts()];
    if !contacts.is_empty() {
        model.contact(&u, &rest, &rest, &mut contacts);
    }
    contacts
}

/// Size of a motion from which on steps may be longer: a curve to infinity is straight.
const LARGE_MOTION: f64 = 20.0;

/// Factor of the maximum step there.
const FASTER: f64 = 20.0;

/// The maximum length of a step at a motion of this size.
pub(crate) fn longest_step(max_step: f64, motion: f64) -> f64 {
    if motion > LARGE_MOTION { FASTER * max_step } else { max_step }
}

impl Measured {
    fn largest_range(&self) -> f64 {
        self.ranges[..self.ranges.len() / 2].iter().fold(0.0, |most: f64, range| most.max(*range))
    }
}

/// A model with every contact on one flank at all deflections: without gaps.
struct OnFlank<'m> {
    model: &'m dyn Periodic,
    pieces: Vec<Piece>,
}

impl Model for OnFlank<'_> {
    fn dof(&self) -> usize {
        self.model.dof()
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        accelerate(self.model, Some(&self.pieces), u, q, v, a);
    }
    fn base(&self) -> Option<&dyn Model> {
        Some(self.model)
    }
    fn offers(&self) -> Offers<'_> {
        let Offers { jacobian, terms, .. } = self.model.offers();
        Offers { jacobian, terms: terms.and(Some(self)), ..Offers::default() }
    }
    fn contacts(&self) -> usize {
        0
    }
    fn jacobian(&self, _: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64], out: &mut Jacobian) {
        self.model.jacobian(offered(self.model, Some(&self.pieces)), u, q, v, out);
    }
}

impl Terms for OnFlank<'_> {
    fn terms(
        &self,
        _: Option<&[Piece]>,
        u: &[f64],
        q: &[f64],
        v: &[f64],
        sizes: &[f64],
        scratch: &mut TermsScratch,
        out: &mut [f64],
    ) {
        if let Some(known) = self.model.offers().terms {
            known.terms(Some(&self.pieces), u, q, v, sizes, scratch, out);
        }
    }
}

/// Multipliers of the model without gaps over `multiple` periods; `None` if its equations are not linear, or
/// differ from flank to flank. `large`: a state of a large motion, at which they are compared with those at
/// rest.
fn without_gaps(
    model: &dyn Periodic,
    multiple: usize,
    large: Option<&State>,
    budget: &Budget,
) -> Option<Multipliers> {
    let period = multiple as f64 * model.period();
    let unit = vec![1.0; 2 * model.dof()];
    let rigid = Drifts::of(model, model.period()).basis(&unit);
    let along = |flank: Piece, start: &State| {
        let on_flank = OnFlank { model, pieces: vec![flank; model.contacts()] };
        let passage = Variation::new().budget(budget.clone()).run(&on_flank, start, start.t + period).ok()?;
        Multipliers::without(&passage.matrix, &rigid, 0.0).ok()
    };
    let rest = State { t: 0.0, q: vec![0.0; model.dof()], v: vec![0.0; model.dof()] };
    let upper = along(Piece::Upper, &rest)?;
    if let Some(large) = large {
        let lower = along(Piece::Lower, &State { t: 0.0, ..large.clone() })?;
        if upper.distance(&lower) > EQUAL * upper.largest().max(1.0) {
            return None;
        }
    }
    Some(upper)
}

/// Largest difference of the multipliers of one linear system `[1]`.
const EQUAL: f64 = 1e-6;

/// Distances of the border from the last point, over those at which the motion is of order 1.
const DISTANCES: [f64; 7] = [0.1, 0.4, 1.6, 6.4, 25.6, 102.4, 409.6];

/// Accuracy of the border, as a share of the parameter `[1]`.
const BORDER_ACCURACY: f64 = 1e-15;

/// The border of parametric instability near the parameter `p`: there the linear system without gaps has a
/// multiplier 1 over `multiple` periods, and no bounded motion. `motion`: size of the motion at p, whose
/// largest state is `large`. `unit`: unit of the parameter. Where the multiplier reaches 1 and does not pass
/// it, the border is the tip of an instability tongue. `None` if the model is not linear at large motions.
pub(crate) fn border(
    family: &Family<'_>,
    p: f64,
    unit: f64,
    multiple: usize,
    (motion, large): (f64, &State),
    budget: &Budget,
) -> Option<f64> {
    {
        let model = family.at([p]).ok()?;
        let (contacts, offers) = (model.contacts(), model.offers());
        let is_symmetric =
            contacts_at_rest(&*model).iter().all(|c| c.lower.is_finite() == c.upper.is_finite());
        if !is_symmetric || (contacts > 0 && !offers.pieces) || offers.first_stop().is_some() {
            return None;
        }
        without_gaps(&*model, multiple, Some(large), budget)?;
    }
    let test = |p: f64| Some(fold(&without_gaps(&*family.at([p]).ok()?, multiple, None, budget)?));
    let (at, accuracy) = (test(p)?, BORDER_ACCURACY * p.abs().max(unit));
    let between = |place: [f64; 2]| {
        let mut brent = Brent::new([p, at], place, accuracy);
        while let Some(p) = brent.next() {
            brent.take(p, test(p)?);
        }
        Some(brent.best())
    };
    for distance in DISTANCES {
        let h = distance * unit / motion;
        for end in [p + h, p - h] {
            let Some(value) = test(end) else { continue };
            if (value > 0.0) != (at > 0.0) {
                return between([end, value]);
            }
        }
    }
    match tip([p, at], DISTANCES.map(|distance| distance * unit / motion), test)? {
        Tip::Touches(p) => Some(p),
        Tip::Passes(place) => between(place),
    }
}

/// Most parabolas to a tip.
const PARABOLAS: usize = 20;

/// At a tip the test is below this share of its value at the farthest of the distances `[1]`.
const TOUCHES: f64 = 1e-3;

/// What a test does at the tip of an instability tongue.
enum Tip {
    /// It comes to 0 at this place.
    Touches(f64),
    /// It changes its sign twice within a short way: a place between, and the value there.
    Passes([f64; 2]),
}

/// The tip of an instability tongue near `p`, at which the test is `first`: there the test comes to 0. A line
/// of folds may come to it from outside of the tongue. `None` if the test does not come close to 0.
fn tip([mut p, first]: [f64; 2], distances: [f64; 7], test: impl Fn(f64) -> Option<f64>) -> Option<Tip> {
    let (h, far) = (distances[1], distances[6]);
    let large = test(p - far)?.abs().min(test(p + far)?.abs());
    for _ in 0..PARABOLAS {
        let places = [p - h, p, p + h];
        let values = [test(places[0])?, test(p)?, test(places[2])?];
        let [before, at, after] = values;
        if (at > 0.0) != (first > 0.0) {
            return Some(Tip::Passes([p, at]));
        }
        let shift = vertex(places, values) - p;
        // The test falls towards 0 from both sides.
        if (before + after - 2.0 * at) * at <= 0.0 || !shift.is_finite() {
            return None;
        }
        p += shift.clamp(-far, far);
        if shift.abs() < 1e-2 * h {
            return (at.abs() < TOUCHES * large).then_some(Tip::Touches(p));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use crate::branches::border::without_gaps;
    use crate::excitation::{Fourier, Wave};
    use crate::ode::Budget;
    use crate::trains::{Body, Members, Planetary};

    /// The differences of equal planets rest at rounding errors, which no step resolves: without gaps the
    /// set of the random search took minutes.
    #[test]
    fn equal_planets_without_gaps_take_few_steps() -> Result<(), Box<dyn std::error::Error>> {
        let wave = |k: f64, share: f64| Fourier::new(k, &[[share * k, 0.0]]).map(Wave::new);
        let members = Members {
            sun: (36, Body::new(1e-3)),
            planet: (24, Body::new(1e-3)),
            ring: (84, Body::new(5e-2).locked()),
            carrier: Body::new(3e-2),
        };
        let set = Planetary::new(2, 0.03, members, [wave(1.690e8, 0.297)?, wave(1.041e8, 0.218)?])?;
        let parts = set.damping(551.5).half_backlash(1.436e-5).parts();
        let train = { parts }.torque("drive", "sun", 43.8).load("carrier").build("sun", 564.02)?;
        let multipliers = without_gaps(&train, 1, None, &Budget::new().steps(2000)).ok_or("multipliers")?;
        assert_eq!(multipliers.values().len(), 6);
        Ok(())
    }
}
