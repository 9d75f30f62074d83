//! The impacts of a run as a list.

use crate::analysis::contacts::impact::{Impact, ImpactSummary};
use crate::analysis::contacts::pieces::{Pieces, Visit};
use crate::contact::edge::Edge;
use crate::contact::{Contact, Piece};
use crate::error::{ParameterError, check};
use crate::excitation::Side;
use crate::export::ResultTable;
use crate::model::Model;
use crate::numeric::gauss::FIVE;
use crate::numeric::search::hermite::{Distance, Hermite};
use crate::ode::{Observer, Step};
use std::fmt;
use std::ops::ControlFlow;

/// Observer that lists the impacts of all contacts of a run: instant, flank, speed, impulse, flight before.
///
/// An impact is what [`Rattle`](crate::Rattle) counts as one: an entry from the gap onto a flank, if the gap
/// has a width, or a rebound from a rigid stop. A contact that touches at the start of the run has no impact
/// before it has separated. Rebounds of one contact at one instant are listed as one.
///
/// If the solver locates edges, instants and speeds are those of the edges. Impulses are integrals with five
/// Gauss points in each step, or in each [part](Step::parts) of it. Otherwise each step is sampled at the
/// five points; instants are the roots of a cubic between two samples, impulses are sums over the samples on
/// the flank.
///
/// The list grows without limit, by some 100 bytes for each impact. It is in order of time; without located
/// edges, impacts of different contacts between the same two samples are in order of the contacts. A run that
/// starts at the end time of the run before continues it; otherwise the flights and contacts of the two are
/// separate.
///
/// A mass of 2 kg hits a spring of 8 N/m at 3 m/s and leaves it after half a period, π/2 s, with the impulse
/// 2 m v:
///
/// ```
/// use gear_dynamics::{Backlash, Dop853, Integrator, Model, State};
/// use gear_dynamics::{analysis::Impacts, contact::{Contact, Nonlinearity, Piece}};
/// struct Mass;
/// impl Model for Mass {
///     fn dof(&self) -> usize { 1 }
///     fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
///         let mut contact = [Contact::default()];
///         self.contact(u, q, v, &mut contact);
///         a[0] = -contact[0].force / 2.0;
///     }
///     fn contacts(&self) -> usize { 1 }
///     fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
///         let force = 8.0 * (q[0] - 1.0).max(0.0);
///         out[0] = Contact { deflection: q[0], rate: v[0], upper: 1.0, force, ..Contact::default() };
///     }
/// }
/// let mut impacts = Impacts::new(&Mass);
/// let solver = Dop853::new().rtol(1e-11).atol(1e-13);
/// solver.run(&Mass, &State::new(0.0, &[0.0], &[3.0]), 4.0, &mut impacts)?;
/// let hit = impacts.all()[0];
/// assert_eq!((impacts.all().len(), hit.flank, hit.flight), (1, Piece::Upper, None));
/// assert!((hit.t - 1.0 / 3.0).abs() < 1e-10 && (hit.speed - 3.0).abs() < 1e-10);
/// assert!((hit.impulse.ok_or("no impulse")? - 12.0).abs() < 1e-8);
/// assert!((hit.duration().ok_or("no end")? - std::f64::consts::FRAC_PI_2).abs() < 1e-8);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use = "an observer records during a run"]
pub struct Impacts<'m> {
    pieces: Pieces<'m>,
    impacts: Vec<Impact>,
    watched: Vec<Watched>,
    masses: Vec<Option<f64>>,
    /// Observed time.
    time: f64,
    /// End of the last step.
    end: Option<f64>,
    y: Vec<f64>,
}

impl fmt::Debug for Impacts<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Impacts")
            .field("impacts", &self.impacts)
            .field("time", &self.time)
            .finish_non_exhaustive()
    }
}

/// What is known of one contact.
#[derive(Clone, Copy, Default)]
struct Watched {
    /// Index of the impact whose contact time has not ended.
    open: Option<usize>,
    /// Index of a rebound at the end of the last step.
    rebound: Option<usize>,
    /// Instant of the last separation.
    since: Option<f64>,
    /// The last sample, without located edges.
    sample: Option<(f64, Contact)>,
}

impl<'m> Impacts<'m> {
    /// Observes all contacts of a model.
    pub fn new(model: &'m dyn Model) -> Self {
        let contacts = model.offers().touching(model.contacts());
        Impacts {
            pieces: Pieces::new(model),
            impacts: Vec::new(),
            watched: vec![Watched::default(); contacts],
            masses: vec![None; contacts],
            time: 0.0,
            end: None,
            y: vec![0.0; 2 * model.dof()],
        }
    }

    /// Sets the effective mass m `[kg]` of contact `contact`, from which the impulses of rigid stops follow.
    ///
    /// m = 1/(bᵀ M⁻¹ b) with the mass matrix M and the row b of the deflection d = bᵀ q. It holds if no other
    /// contact strikes at the same instant. The equations of a [`Model`] contain no masses, only
    /// accelerations.
    ///
    /// # Errors
    /// [`ParameterError::NoSuchContact`]; a mass outside 1e-50 .. 1e50.
    pub fn effective_mass(mut self, contact: usize, mass: f64) -> Result<Self, ParameterError> {
        let contacts = self.masses.len();
        let place =
            self.masses.get_mut(contact).ok_or(ParameterError::NoSuchContact { contact, contacts })?;
        *place = Some(check::scale(format!("effective mass of contact {contact}"), mass)?);
        Ok(self)
    }

    /// All impacts so far.
    pub fn all(&self) -> &[Impact] {
        &self.impacts
    }

    /// The impacts of one contact; the first contact is 0.
    pub fn of(&self, contact: usize) -> impl Iterator<Item = &Impact> {
        self.impacts.iter().filter(move |impact| impact.contact == contact)
    }

    /// Figures of the impacts of each contact over the observed time.
    ///
    /// For the figures of a periodic motion, start the observed run while the teeth are apart: contacts that
    /// already touch at its start are not impacts.
    pub fn summaries(&self) -> Vec<ImpactSummary> {
        (0..self.watched.len()).map(|contact| ImpactSummary::of(self.of(contact), self.time)).collect()
    }

    /// A table of all impacts: contact, flank (-1 lower, 1 upper) and the fields of [`Impact`]. What an
    /// impact does not have is NaN.
    pub fn table(&self) -> ResultTable {
        let columns = [
            ("contact", "1"),
            ("flank", "1"),
            ("t", ""),
            ("speed", ""),
            ("flight", ""),
            ("left", ""),
            ("separation", ""),
            ("impulse", ""),
        ];
        let rows = self.impacts.iter().map(|impact| {
            let flank = if impact.flank == Piece::Upper { 1.0 } else { -1.0 };
            let [flight, left, separation, impulse] =
                [impact.flight, impact.left, impact.separation, impact.impulse]
                    .map(|x| x.unwrap_or(f64::NAN));
            [impact.contact as f64, flank, impact.t, impact.speed, flight, left, separation, impulse]
        });
        ResultTable::of_rows(columns, rows)
    }

    /// Begins an impact of contact `i` at `t`.
    fn touch(&mut self, i: usize, flank: Piece, t: f64, speed: f64) -> usize {
        // Rounding of two roots between the same samples may exchange them.
        let flight = self.watched[i].since.map(|since| (t - since).max(0.0));
        self.impacts.push(Impact {
            contact: i,
            flank,
            t,
            speed,
            flight,
            left: None,
            separation: None,
            impulse: None,
        });
        self.impacts.len() - 1
    }

    /// Ends the contact time of contact `i` at `t`.
    fn leave(&mut self, i: usize, t: f64, separation: f64) {
        if let Some(k) = self.watched[i].open.take() {
            (self.impacts[k].left, self.impacts[k].separation) = (Some(t), Some(separation));
        }
        self.watched[i].since = Some(t);
    }

    /// A change of piece, or a sample.
    fn visit(&mut self, visit: &Visit) {
        let i = visit.contact;
        let Some(now) = visit.at else { return };
        let before = self.watched[i].sample;
        let crossing = |edge: Edge| match before {
            Some(before) => root(edge, before, (visit.t, now)),
            None => (visit.t, edge.depth_rate(&now)),
        };
        if let Some(edge) = visit.from.filter(|from| *from != visit.piece).and_then(Edge::of) {
            let (t, rate) = crossing(edge);
            self.leave(i, t, -rate);
        }
        if let Some(edge) = Edge::of(visit.piece).filter(|_| visit.is_impact) {
            let (t, speed) = crossing(edge);
            let k = self.touch(i, visit.piece, t, speed);
            self.impacts[k].impulse = Some(0.0);
            self.watched[i].open = Some(k);
        }
    }

    /// Adds ∫ ±W dt ≈ `time` · ±W to the open impact of contact `i`.
    fn press(&mut self, i: usize, force: f64, time: f64) {
        if let Some(k) = self.watched[i].open {
            let impact = &mut self.impacts[k];
            let force = if impact.flank == Piece::Upper { force } else { -force };
            impact.impulse = impact.impulse.map(|sum| sum + force * time);
        }
    }

    /// Adds the integrals over a step with located edges.
    fn integrate(&mut self, step: &mut Step<'_>) {
        if self.watched.iter().all(|watched| watched.open.is_none()) {
            return;
        }
        for part in 0..step.parts() {
            let (t0, t1) = step.part(part);
            let (middle, half) = (0.5 * (t0 + t1), 0.5 * (t1 - t0));
            for [x, w] in FIVE {
                let t = middle + half * x;
                step.at(t, &mut self.y);
                let (q, v) = self.y.split_at(self.y.len() / 2);
                self.pieces.probe.read_contacts(t, Side::After, q, v);
                for i in 0..self.watched.len() {
                    let force = self.pieces.probe.contacts()[i].force;
                    self.press(i, force, half * w);
                }
            }
        }
    }

    /// Reads the speeds after the rebounds at the end of the last step.
    fn end_rebounds(&mut self, step: &Step<'_>) {
        if self.watched.iter().all(|watched| watched.rebound.is_none()) {
            return;
        }
        self.pieces.probe.read_contacts(step.t0(), Side::After, step.q0(), step.v0());
        for i in 0..self.watched.len() {
            if let Some(k) = self.watched[i].rebound.take() {
                let impact = &mut self.impacts[k];
                let edge = Edge::between(Piece::Gap, impact.flank);
                let separation = -edge.depth_rate(&self.pieces.probe.contacts()[i]);
                impact.separation = Some(separation);
                impact.impulse = self.masses[i].map(|mass| mass * (impact.speed + separation));
            }
        }
    }

    /// Adds the rebounds at the end of a step.
    fn rebound(&mut self, step: &Step<'_>) {
        if !step.crossings().iter().any(|crossing| crossing.rebounds) {
            return;
        }
        let t = step.t1();
        self.pieces.probe.read_contacts(t, Side::Before, step.q1(), step.v1());
        for crossing in step.crossings().iter().filter(|crossing| crossing.rebounds) {
            let i = crossing.contact;
            if self.watched[i].rebound.is_none() {
                let edge = Edge::between(crossing.from, crossing.to);
                let speed = edge.depth_rate(&self.pieces.probe.contacts()[i]);
                let k = self.touch(i, crossing.to, t, speed);
                self.impacts[k].left = Some(t);
                (self.watched[i].rebound, self.watched[i].since) = (Some(k), Some(t));
            }
        }
    }
}

impl Observer for Impacts<'_> {
    fn fits(&self, dof: usize, contacts: usize) -> Result<(), ParameterError> {
        self.pieces.probe.fits(dof, contacts)
    }
    fn step(&mut self, step: &mut Step<'_>) -> ControlFlow<()> {
        if self.end.is_some_and(|end| end != step.t0()) {
            self.pieces.forget();
            self.watched.fill(Watched::default());
        }
        self.end_rebounds(step);
        self.pieces.follow(step);
        let located = step.pieces().is_some();
        for k in 0..self.pieces.visits().len() {
            let visit = self.pieces.visits()[k];
            self.visit(&visit);
            if let (false, Some(at)) = (located, visit.at) {
                self.press(visit.contact, at.force, visit.time);
                self.watched[visit.contact].sample = Some((visit.t, at));
            }
        }
        if located {
            self.integrate(step);
            self.rebound(step);
        }
        self.time += step.t1() - step.t0();
        self.end = Some(step.t1());
        ControlFlow::Continue(())
    }
}

/// Instant at which the depth past an edge vanishes between two samples, and its rate there: a root of the
/// cubic through depths and rates. The later sample if the depth does not change its sign, as where an edge
/// jumps.
fn root(edge: Edge, (t0, before): (f64, Contact), (t1, now): (f64, Contact)) -> (f64, f64) {
    let width = t1 - t0;
    let distance = |c: &Contact| Distance { value: edge.depth(c), rate: edge.depth_rate(c) };
    let (d0, d1) = (distance(&before), distance(&now));
    if (d0.value > 0.0) == (d1.value > 0.0) || width.is_nan() || width <= 0.0 {
        return (t1, d1.rate);
    }
    let cubic = Hermite::over(width, d0, d1);
    let sigma = cubic.root();
    (t0 + width * sigma, cubic.slope(sigma) / width)
}
