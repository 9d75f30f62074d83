//! Static deflection under load.

use crate::contact::{Contact, Piece};
use crate::error::check;
use crate::linear::balanced::{AtRest, piece_at};
use crate::linear::instants::{Instants, SPREAD, mean_contacts, smooth_intervals};
use crate::linear::modes::LinearError;
use crate::model::structure::drifts::Drifts;
use crate::model::{Periodic, State};
use crate::numeric::norms::largest;
use nalgebra::DMatrix;

/// A static state: deflections under the mean load, or under that at one instant, without motion.
///
/// ```
/// use gear_dynamics::linear::static_state;
/// use gear_dynamics::trains::{Body, MeshPart, Parts};
/// use gear_dynamics::Wave;
/// let mut parts = Parts::new();
/// parts.body("pinion", Body::new(1e-3)).body("wheel", Body::new(4e-3));
/// let mesh = MeshPart::external([20, 40], [0.03, 0.06], Wave::constant(2e8)?).half_backlash(5e-5);
/// parts.mesh("mesh", "pinion", "wheel", mesh);
/// parts.torque("drive", "pinion", 30.0).torque("load", "wheel", -60.0);
/// let rest = static_state(&parts.build("pinion", 100.0)?, None)?;
/// let contact = rest.contacts[0]; // 30 N m/0.03 m = 1000 N on 2e8 N/m past half the backlash
/// assert!((contact.force - 1000.0).abs() < 1e-9);
/// assert!((contact.deflection - 5.5e-5).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct StaticState {
    /// The time whose loads and drives the state balances; `None`: their means over a period.
    pub instant: Option<f64>,
    /// The state at rest at the time t: a start of integrations and solvers. A rigid motion of the model, or
    /// one that only a drag resists, is left at rest.
    pub state: State,
    /// Contacts with their deflections, edges and forces: means over the period, or those at the instant.
    /// Forces are by deflection: their mean exceeds the mean load where the teeth part in some instants of
    /// the period. Panels of the sum are then halved until none changes a mean force by more than 1e-7 of the
    /// largest; the largest error that was seen is 6e-7. If teeth part in thousands of mesh cycles, the mean
    /// is taken over 65 537 even instants. Forces that jump are then right to some 1e-5.
    pub contacts: Vec<Contact>,
    /// The piece of each contact.
    pub pieces: Vec<Piece>,
    /// Accelerations that are left: those along a motion that no stiffness resists, if the load does not
    /// balance.
    pub acceleration: Vec<f64>,
}

/// Maximum number of contact states that are tried.
const TRIES: usize = 64;

/// Maximum number of steps of implicit Euler.
const STEPS: usize = 400;

/// Newton's method converges in an implicit Euler step whose inverse exceeds the largest stiffness this many
/// times, unless an acceleration jumps: the bodies do not rest there.
const JUMP: f64 = 64.0;

/// Number of steps of implicit Euler, each eight times longer than the one before, after which bodies that
/// have not moved rest.
const RESTS: usize = 12;

/// Maximum number of intervals between two edges of the drives in the mean over a period.
const INTERVALS: usize = 16_384;

/// Distance of a deflection from an edge on which it rests, as a share of the largest deflection.
const NEAR: f64 = 1e-12;

/// Accelerations of bodies that rest, as a share of the load.
const AT_REST: f64 = 1e-13;

/// Number of Gauss panels in a period, first and at most.
const PANELS: [usize; 2] = [8, 16_384];

/// Largest change of a mean contact force by the halves of a panel that agrees with them, as a share of the
/// largest mean force `[1]`. A few panels have kinks.
const SAME_FORCE: f64 = 1e-7;

/// Number of Gauss panels in the sum that confirms a state. This sum sees smooth pulses down to a width of
/// 1/750 of the period.
const CONFIRMED: usize = 128;

/// The static state of a model: the position at rest in which no coordinate accelerates, except along a rigid
/// motion. `t`: under the loads and drives at this time. `None`: under their means over a period.
///
/// With `None` the mean acceleration over the period T is 0: (1/T) ∫ a(u(t), q, 0) dt = 0. This mean takes
/// each contact on one flank, or in its gap, for the whole period. The teeth therefore carry the mean load
/// even if the transmission error exceeds the static deflection. A wave that acts alone, such as a load, a
/// stiffness or a transmission error, enters with its mean. A product of two waves, such as stiffness times
/// transmission error, enters with the mean of the product. The integral is a Gauss sum between the edges of
/// the drives. It begins with some 40 points. Their number is doubled, up to some 80 000, until the loads
/// balance to 1e-9. The last sum has at least 640 points: it may miss a smooth pulse narrower than 1/750 of
/// the period. If no sum balances, or in a period with more than 16 384 edges, the mean is taken over 65 537
/// even instants.
///
/// Every contact is on its upper flank at first; it changes to the lower flank if it pulls there, and to the
/// gap if both flanks pull. The load may be shared by contacts for which this search does not end. The bodies
/// then move from their position on all upper flanks until they rest. Their velocity is q' = a(q), the mean
/// acceleration of bodies that rest in q. Implicit Euler steps follow this motion. The steps grow while
/// Newton's method converges. The potential energy falls in the motion if no stiffness is negative. A contact
/// acts by its deflection at each instant, and if no state follows, by its mean deflection: the teeth of a
/// ring under a light load touch in some instants only.
///
/// A contact that carries nothing stands halfway between the positions in which its two flanks would rest, if
/// the others allow it. With a constant stiffness this is the middle of its gap.
///
/// If no pieces carry the mean load for the whole period, as with a lever that varies, and a finer sum has
/// the same mean loads or no state on flanks, the state is that at t = 0 ([`StaticState::instant`]).
///
/// A position balances if the acceleration that is left in each coordinate is at most 1e-9 of the load of
/// this coordinate, its acceleration in the gap, besides the rounding of the terms whose sum it is. Rigid
/// stops bear no load here ([`Model::impact`](crate::Model::impact)).
///
/// # Errors
/// A Jacobian that is not finite; a negative gap; no consistent contact state; a load that moves bodies
/// freely, as in a gap; a period out of its range, if `t` is `None`.
pub fn static_state(model: &dyn Periodic, t: impl Into<Option<f64>>) -> Result<StaticState, LinearError> {
    if let Some(t) = t.into() {
        check::finite("time", t)?;
        return AtRest::new(model, t, Instants::at(model, t), &unresisted_columns(model)).find();
    }
    let (found, points) = mean_state(model)?;
    let Some((bounds, panels)) = points else { return Ok(found) };
    Ok(with_contacts(found, model, &bounds, panels))
}

/// The state at rest under the mean loads, the default start of a run: [`static_state`] without its contacts.
pub(crate) fn default_start(model: &dyn Periodic) -> Result<State, LinearError> {
    Ok(mean_state(model)?.0.state)
}

/// The directions that no stiffness resists, one in each column.
fn unresisted_columns(model: &dyn Periodic) -> DMatrix<f64> {
    let Drifts { places, .. } = Drifts::of(model, model.period());
    DMatrix::from_fn(model.dof(), places.len(), |i, j| places[j][i])
}

/// The bounds of smooth intervals, and the number of panels in each, of a sum that confirms a state.
type Points = (Vec<f64>, usize);

/// The static state under the mean loads. `None`: no finer sum confirms it.
fn mean_state(model: &dyn Periodic) -> Result<(StaticState, Option<Points>), LinearError> {
    check::scale("period of the model", model.period())?;
    let (rigid, bounds) = (unresisted_columns(model), smooth_intervals(model, INTERVALS + 1));
    let intervals = bounds.len() - 1;
    let at_first = || AtRest::new(model, 0.0, Instants::at(model, 0.0), &rigid).find();
    let is_lost =
        |error: &LinearError| matches!(error, LinearError::Free { .. } | LinearError::NoContactState { .. });
    let at_even_instants = |otherwise: &dyn Fn() -> Result<StaticState, LinearError>| {
        let found = AtRest::new(model, 0.0, Instants::spread(model, SPREAD), &rigid).find();
        Ok((found.or_else(|error| if is_lost(&error) { otherwise() } else { Err(error) })?, None))
    };
    if intervals > INTERVALS {
        return at_even_instants(&at_first);
    }
    let mut panels = PANELS[0].div_ceil(intervals);
    let mut search = AtRest::new(model, 0.0, Instants::of(model, &bounds, panels), &rigid);
    loop {
        let found = match search.find() {
            Err(error) if is_lost(&error) => {
                // A coarse sum may lose the balance of loads that a finer one has.
                loop {
                    panels = (2 * panels).max(CONFIRMED.div_ceil(intervals));
                    let finer =
                        (panels * intervals <= PANELS[1]).then(|| Instants::of(model, &bounds, panels));
                    let finer = finer.map(|instants| AtRest::new(model, 0.0, instants, &rigid));
                    match finer.filter(|finer| !finer.has_loads_of(&search)) {
                        Some(finer) => search = finer,
                        None => return Ok((at_first()?, None)),
                    }
                    if search.by_flanks().is_ok() {
                        break;
                    }
                }
                continue;
            }
            found => found?,
        };
        panels *= 2;
        if panels * intervals > PANELS[1] {
            return at_even_instants(&|| Ok(found.clone()));
        }
        search = AtRest::new(model, 0.0, Instants::of(model, &bounds, panels), &rigid);
        if search.confirms(&found) {
            if panels * intervals >= CONFIRMED {
                return Ok((found, Some((bounds, panels))));
            }
            // Two coarse sums agree also if both miss a narrow pulse.
            panels = CONFIRMED.div_ceil(intervals);
            search = AtRest::new(model, 0.0, Instants::of(model, &bounds, panels), &rigid);
            if search.confirms(&found) {
                return Ok((found, Some((bounds, panels))));
            }
        }
    }
}

/// The state with mean contacts that hold the kinks where teeth part, which the balance on fixed pieces does
/// not see.
fn with_contacts(found: StaticState, model: &dyn Periodic, bounds: &[f64], panels: usize) -> StaticState {
    let largest = found.contacts.iter().fold(0.0, |most: f64, c| most.max(c.force.abs()));
    let contacts = mean_contacts(model, &found.state.q, (bounds, panels), SAME_FORCE * largest);
    StaticState { contacts, ..found }
}

/// The search for a static state.
impl AtRest<'_> {
    fn find(&self) -> Result<StaticState, LinearError> {
        if let Some((contact, [lower, upper])) = self.mean.negative_gap() {
            return Err(LinearError::NegativeGap { contact, lower, upper });
        }
        let found = match self.by_flanks() {
            Err(error @ (LinearError::Free { .. } | LinearError::NoContactState { .. })) => {
                let start = self.balanced(&self.flanks, &self.mean.rest);
                let start = start.map_or(self.mean.rest.clone(), |(q, _)| q);
                let found = self.by_descent(&start, false).or_else(|| self.by_descent(&start, true));
                found.ok_or(error)
            }
            found => found,
        };
        found.map(|found| self.without_idle_flanks(found))
    }

    /// The state with each contact that carries nothing halfway between its two flanks. A wave that moves a
    /// flank against the contact would else leave it there. A contact stays where it is if it lacks a flank,
    /// or if another contact forbids the new place.
    fn without_idle_flanks(&self, mut found: StaticState) -> StaticState {
        let with = |found: &StaticState, of: &[usize], piece: Piece| {
            let mut pieces = found.pieces.clone();
            of.iter().for_each(|&i| pieces[i] = piece);
            pieces
        };
        // A contact that never leaves its flank carries.
        let leaves = self.mean.leaves(&found.pieces, &found.state.q, rounding(&found.contacts));
        let is_idle = |&i: &usize| leaves[i] && self.balances(&with(&found, &[i], Piece::Gap), &found);
        let idle: Vec<usize> = (0..leaves.len()).filter(is_idle).collect();
        if idle.is_empty() {
            return found;
        }
        let middle = |found: &StaticState, of: &[usize]| {
            let on = |piece| Some(self.balanced(&with(found, of, piece), &found.state.q).ok()?.0);
            let ends = on(Piece::Lower)?.into_iter().zip(on(Piece::Upper)?);
            let between: Vec<f64> = ends.map(|(x, y)| 0.5 * (x + y)).collect();
            let state = self.resting(with(found, of, Piece::Gap), &between)?;
            let is_inside = |&i: &usize| state.contacts[i].penetration() < -rounding(&state.contacts);
            of.iter().all(is_inside).then_some(state)
        };
        if let Some(all) = middle(&found, &idle) {
            return all;
        }
        for i in idle {
            found = middle(&found, &[i]).unwrap_or(found);
        }
        found
    }

    /// The state that balances on `pieces`, if every contact lies on its piece, an edge included.
    fn resting(&self, pieces: Vec<Piece>, from: &[f64]) -> Option<StaticState> {
        let (q, acceleration) = self.balanced(&pieces, from).ok()?;
        let contacts = self.mean.contacts(&q);
        let near = rounding(&contacts);
        let lies = |(piece, c): (&Piece, &Contact)| match piece {
            Piece::Upper => c.deflection >= c.upper - near,
            Piece::Lower => c.deflection <= c.lower + near,
            Piece::Gap => c.penetration() <= near,
        };
        let all = pieces.iter().zip(&contacts).all(lies);
        all.then(|| self.state(q, contacts, pieces, acceleration))
    }

    /// Whether a state that was found with fewer instants balances.
    fn confirms(&self, found: &StaticState) -> bool {
        self.balances(&found.pieces, found)
    }

    /// Whether the position of a state balances on `pieces` as on its own, within the rounding of these.
    fn balances(&self, pieces: &[Piece], found: &StaticState) -> bool {
        let mean = &self.mean;
        let a = mean.acceleration(Some(pieces), &found.state.q);
        let changes: Vec<f64> = a.iter().zip(&found.acceleration).map(|(a, before)| a - before).collect();
        self.excess(&found.pieces, &changes, &found.state.q, &mean.rest) <= 1.0
    }

    /// The [first flanks](AtRest::flanks); a contact that pulls changes its piece.
    fn by_flanks(&self) -> Result<StaticState, LinearError> {
        let mean = &self.mean;
        let mut pieces = self.flanks.clone();
        // Flanks that a contact has left because it pulled.
        let mut left = vec![[false; 2]; pieces.len()];
        let mut tried = Vec::new();
        // What was tried before would repeat for ever.
        while tried.len() < TRIES && !tried.contains(&(pieces.clone(), left.clone())) {
            tried.push((pieces.clone(), left.clone()));
            let (q, acceleration) = self.balanced(&pieces, &mean.rest)?;
            let pressed = mean.pressed(&pieces, &q);
            let near = rounding(&pressed);
            let next = |i: usize| next_piece(pieces[i], &pressed[i], near, &mut left[i]);
            let found: Vec<Piece> = (0..pieces.len()).map(next).collect();
            if found == pieces {
                return Ok(self.state(q.clone(), mean.contacts(&q), pieces, acceleration));
            }
            pieces = found;
        }
        Err(LinearError::NoContactState { tried: tried.len() })
    }

    /// The end of the motion q' = a(q) from `start`, without its rigid part. `None`: no contact state of this
    /// motion balances. `is_mean`: each contact acts by its mean deflection, and by that at each instant
    /// otherwise.
    fn by_descent(&self, start: &[f64], is_mean: bool) -> Option<StaticState> {
        let (mean, mut q, mut slopes) = (&self.mean, start.to_vec(), self.slopes());
        let at = |q: &[f64]| mean.contacts(q).iter().map(piece_at).collect::<Vec<_>>();
        let on = |q: &[f64]| is_mean.then(|| at(q));
        // The inverse of the first step is the largest stiffness.
        let stiffest = mean.stiffness(&mut slopes, Some(&self.flanks), &q).largest();
        let (load, mut inverse, mut stiffness) = (self.load(), stiffest, None);
        let (mut refused, mut rests) = (None, 0);
        for _ in 0..STEPS {
            if !(inverse.is_finite() && inverse > 0.0 && rests < RESTS) {
                return None;
            }
            let Some(next) = self.euler(&mut slopes, &on, &mut stiffness, &q, inverse) else {
                let on = on(&q);
                let mut here = || mean.stiffness(&mut slopes, on.as_deref(), &q).largest();
                if inverse > JUMP * stiffest && inverse > JUMP * here() {
                    return None;
                }
                (inverse, stiffness) = (16.0 * inverse, None);
                continue;
            };
            let moved = q.iter().zip(&next).fold(0.0f64, |most, (x, y)| most.max((x - y).abs()));
            // The accelerations that are left are those of the step.
            rests = if moved * inverse <= AT_REST * load {
                RESTS
            } else if moved <= 1e-12 * largest(&next) {
                rests + 1
            } else {
                0
            };
            q = next;
            inverse /= 8.0;
            let pieces = at(&q);
            // Where the bodies rest, parts without load may lie in another place than before.
            if refused.as_ref() == Some(&pieces) && rests < RESTS {
                continue;
            }
            if let Some(found) = self.resting(pieces.clone(), &q) {
                return Some(found);
            }
            refused = Some(pieces);
        }
        None
    }

    fn state(
        &self,
        q: Vec<f64>,
        contacts: Vec<Contact>,
        pieces: Vec<Piece>,
        acceleration: Vec<f64>,
    ) -> StaticState {
        let AtRest { t, of_instant, mean, .. } = self;
        StaticState {
            instant: of_instant.then_some(*t),
            state: State { t: *t, q, v: mean.rest.clone() },
            contacts,
            pieces,
            acceleration,
        }
    }
}

/// Distance of a deflection from an edge on which it rests, by rounding.
fn rounding(contacts: &[Contact]) -> f64 {
    NEAR * contacts.iter().fold(0.0, |most: f64, c| most.max(c.deflection.abs()))
}

/// The piece to try after `piece`: the same if the deflection lies on it, within `near`. A flank that pulls
/// gives way to the other flank, and to the gap if that has pulled before.
fn next_piece(piece: Piece, contact: &Contact, near: f64, left: &mut [bool; 2]) -> Piece {
    let upper = contact.deflection >= contact.upper - near;
    let lower = contact.deflection <= contact.lower + near;
    match piece {
        Piece::Upper if upper => Piece::Upper,
        Piece::Lower if lower => Piece::Lower,
        Piece::Gap if upper => Piece::Upper,
        Piece::Gap if lower => Piece::Lower,
        Piece::Gap => Piece::Gap,
        Piece::Upper => {
            left[1] = true;
            if contact.lower.is_finite() && !left[0] { Piece::Lower } else { Piece::Gap }
        }
        Piece::Lower => {
            left[0] = true;
            if contact.upper.is_finite() && !left[1] { Piece::Upper } else { Piece::Gap }
        }
    }
}
