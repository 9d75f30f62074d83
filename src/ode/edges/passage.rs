//! The passage of a run over edges: those of its contacts, rigid stops, and drive edges.

use crate::error::check;
use crate::model::{Model, State};
use crate::ode::edges::exit::Exit;
use crate::ode::edges::locate::Locator;
use crate::ode::edges::sliding::Sliding;
use crate::ode::edges::stops::Stops;
use crate::ode::integrate_error::IntegrateError;
use crate::ode::outcome::Stats;
use crate::ode::step::Crossing;
use crate::ode::stepping::ends::{Ends, halves};
use crate::ode::stepping::vector::Vector;

/// Largest magnitude of the end time of a run. Beyond it, products of steps and rates overflow.
const LAST_TIME: f64 = 1e50;

/// What every method does at edges: it takes the pieces of the contacts, ends steps with crossings and
/// impacts, and prepares the step after them. Where an edge lies in a step, the method finds itself.
pub(crate) struct Passage {
    pub(crate) locator: Locator,
    /// Crossings at the end of the current step.
    pub(crate) crossings: Vec<Crossing>,
    pub(crate) sliding: Sliding,
    /// Next drive edge; infinite if there is none.
    edge: f64,
    /// End of the run.
    end: f64,
    /// The smallest absolute tolerance of a coordinate; 0 without tolerances.
    atol: f64,
    /// Whether the motion has exceeded it.
    resolved: bool,
    /// Whether an edge was crossed before the motion exceeded it.
    unresolved: bool,
    /// Latest end of the next step: the next drive edge or the end of the run.
    pub(crate) stop: f64,
    pub(crate) stats: Stats,
    /// The end of the last fixed step in which an edge was crossed, and the crossings of each contact in it.
    crowd: (f64, Vec<u32>),
}

/// Largest number of crossings of one contact in a step of fixed length. A motion that crosses more often is
/// not resolved by such steps, or slides.
const CROWD: u32 = 16;

/// Number of drive edges whose mean distance is measured.
const EDGES: u32 = 64;

impl Passage {
    /// Begins a run from `e.t` to `end`. Without `locate` no edge of a contact is looked for.
    ///
    /// # Errors
    /// [`IntegrateError::TimeSpan`], [`IntegrateError::NegativeGap`], [`IntegrateError::BeyondStop`],
    /// [`IntegrateError::DriveEdge`].
    pub(crate) fn begin<V: Vector>(
        e: &mut Ends<'_, V>,
        end: f64,
        locate: bool,
    ) -> Result<Self, IntegrateError> {
        if !(end.abs() <= LAST_TIME && end > e.t) {
            return Err(IntegrateError::TimeSpan { start: e.t, end });
        }
        check::count("kinks that the model offers", &[e.model.offers().kinks], e.model.contacts())?;
        let locator = Locator::new(if locate { e.contacts.len() } else { 0 }, Stops::new(e.model, locate));
        let edge = edge_after(e.model, e.t)?;
        e.edges = [e.t, edge];
        let mut passage = Passage {
            crossings: Vec::with_capacity(2 * e.contacts.len() + locator.stops.room()),
            sliding: Sliding::default(),
            locator,
            edge,
            end,
            atol: halves(&e.atol).0.iter().copied().reduce(f64::min).unwrap_or(0.0),
            resolved: false,
            unresolved: false,
            stop: edge.min(end),
            stats: Stats::default(),
            crowd: (e.t, vec![0; if locate { e.contacts.len() } else { 0 }]),
        };
        if locate {
            passage.resolved = halves(&e.y).0.iter().any(|q| q.abs() >= passage.atol);
            passage.locator.measure_noise(e);
            passage.take_pieces(e, true)?;
        }
        Ok(passage)
    }

    /// Refuses a run with more drive edges ahead than it may have steps, by the mean distance of the next
    /// [`EDGES`] of them.
    ///
    /// # Errors
    /// [`IntegrateError::TooManyEdges`], [`IntegrateError::DriveEdge`].
    pub(crate) fn fits(&self, model: &dyn Model, t: f64, max_steps: usize) -> Result<(), IntegrateError> {
        let least = (self.end - t) / max_steps as f64;
        let mut last = self.edge;
        if last - t >= least {
            return Ok(());
        }
        for _ in 1..EDGES {
            if last >= self.end {
                return Ok(());
            }
            last = edge_after(model, last)?;
        }
        let apart = (last - t) / f64::from(EDGES);
        if apart >= least { Ok(()) } else { Err(IntegrateError::TooManyEdges { t, apart, max_steps }) }
    }

    /// Moves the end of the run.
    pub(crate) fn extend(&mut self, end: f64) {
        self.end = end;
        self.stop = self.edge.min(end);
    }

    /// Whether a step that ends at `t1` ends on the next drive edge.
    #[inline(always)]
    pub(crate) fn is_drive_edge(&self, t1: f64) -> bool {
        self.edge == t1
    }

    /// A contact leaves its piece at the start of the step: it changes its piece. The step must be repeated.
    ///
    /// # Errors
    /// [`IntegrateError::EdgeStall`], [`IntegrateError::RestsOnStop`].
    pub(crate) fn leave<V: Vector>(&mut self, e: &mut Ends<'_, V>, exit: Exit) -> Result<(), IntegrateError> {
        if exit.edge.is_stop(&self.locator.stops.rigid, exit.contact) {
            return self.locator.presses(e.t, exit.contact);
        }
        let changed = self.locator.change(&mut e.pieces, exit);
        changed.then_some(()).ok_or(IntegrateError::EdgeStall { t: e.t, contact: exit.contact })
    }

    /// Checks that the gap, or a coordinate up to this crossing, is at least as large as the absolute
    /// tolerance.
    ///
    /// # Errors
    /// [`IntegrateError::BelowTolerance`], [`IntegrateError::NoRoomBetweenStops`].
    #[inline]
    pub(crate) fn check_tolerance<V: Vector>(
        &mut self,
        e: &Ends<'_, V>,
        contact: usize,
    ) -> Result<(), IntegrateError> {
        if self.resolved {
            return Ok(());
        }
        let gap = e.contacts[contact].upper - e.contacts[contact].lower;
        let coordinates = halves(&e.y).0.iter().chain(halves(&e.y1).0);
        let motion = coordinates.fold(if gap.is_finite() { gap } else { 0.0 }, |m: f64, q| m.max(q.abs()));
        self.resolved = motion >= self.atol;
        if self.resolved {
            return Ok(());
        }
        if gap == 0.0 && self.locator.stops.rigid.get(contact) == Some(&[true; 2]) {
            return Err(IntegrateError::NoRoomBetweenStops { t: e.t1, contact });
        }
        Err(IntegrateError::BelowTolerance { t: e.t1, contact, atol: self.atol, motion })
    }

    /// The error of a contact that stalls: [`BelowTolerance`](IntegrateError::BelowTolerance) if that is the
    /// cause.
    #[cold]
    pub(crate) fn cause<V: Vector>(
        &mut self,
        e: &Ends<'_, V>,
        contact: usize,
        stall: IntegrateError,
    ) -> IntegrateError {
        self.check_tolerance(e, contact).err().unwrap_or(stall)
    }

    /// Ends the step with the crossing of the located exit, all that happen together with it, and the impacts
    /// that follow. `e.contacts` must be the contacts at the end of the step.
    ///
    /// # Errors
    /// [`IntegrateError::EdgeStall`], [`IntegrateError::RestsOnStop`], [`IntegrateError::BelowTolerance`].
    #[inline]
    pub(crate) fn cross<V: Vector>(
        &mut self,
        e: &mut Ends<'_, V>,
        located: Exit,
    ) -> Result<(), IntegrateError> {
        // The first crossing does not show how large the motion is: a run may start on an edge, and a moving
        // edge may meet a mass that rests at 0.
        match self.check_tolerance(e, located.contact) {
            Err(error) if self.unresolved => return Err(error),
            Err(_) => self.unresolved = true,
            Ok(()) => {}
        }
        let Passage { locator, crossings, sliding, .. } = self;
        let together = locator.together(&e.pieces, &e.contacts, located);
        crossings.extend([located].into_iter().chain(together).map(|exit| {
            let rebounds = exit.edge.is_stop(&locator.stops.rigid, exit.contact);
            exit.crossing(e.pieces[exit.contact], rebounds)
        }));
        if let Some(contact) = sliding.find(e, crossings, self.edge, &locator.noise) {
            return Err(IntegrateError::EdgeStall { t: e.t1, contact });
        }
        for crossing in crossings.iter().filter(|c| !c.rebounds) {
            let (value, ..) = locator.miss(&e.pieces, &e.contacts, Exit::of(crossing));
            locator.missed[crossing.contact] = 2.0 * value.abs();
        }
        locator.strike_at_end(e, crossings)?;
        self.stats.crossings += self.crossings.len() as u64;
        Ok(())
    }

    /// Counts the crossings at the time `t` in a step of fixed length that ends at `until`. The parts of the
    /// step between crossings do not shrink where a motion slides.
    ///
    /// # Errors
    /// [`IntegrateError::EdgeStall`].
    pub(crate) fn count(&mut self, t: f64, until: f64) -> Result<(), IntegrateError> {
        let Passage { crossings, crowd: (end, counts), .. } = self;
        if *end != until {
            *end = until;
            counts.fill(0);
        }
        for contact in crossings.iter().filter(|c| !c.rebounds).map(|c| c.contact) {
            counts[contact] += 1;
            if counts[contact] > CROWD {
                return Err(IntegrateError::EdgeStall { t, contact });
            }
        }
        Ok(())
    }

    /// The state at the end of the run, after the impacts there: a further run can start from it.
    ///
    /// # Errors
    /// [`IntegrateError::Unbounded`] if a component is larger than that of a start may be.
    pub(crate) fn finish<V: Vector>(&self, e: &mut Ends<'_, V>) -> Result<State, IntegrateError> {
        self.locator.stops.write(&mut e.y1);
        e.finish()
    }

    /// Prepares the start of the next step: velocities after impacts, pieces, the next drive edge. Returns
    /// the maximum length of that step; infinite without impacts.
    ///
    /// # Errors
    /// [`IntegrateError::NegativeGap`], [`IntegrateError::BeyondStop`], [`IntegrateError::DriveEdge`], if the
    /// step ended on a drive edge.
    #[inline(always)]
    pub(crate) fn pass<V: Vector, const LOCATE: bool>(
        &mut self,
        e: &mut Ends<'_, V>,
        at_drive_edge: bool,
    ) -> Result<f64, IntegrateError> {
        let mut longest = f64::INFINITY;
        if LOCATE {
            longest = self.locator.rebound(e);
            for crossing in self.crossings.iter().filter(|c| !c.rebounds) {
                e.pieces[crossing.contact] = crossing.to;
                self.locator.fresh[crossing.contact] = true;
            }
        }
        if at_drive_edge {
            self.edge = edge_after(e.model, e.t)?;
            self.stop = self.edge.min(self.end);
            e.edges = [e.t, self.edge];
            if LOCATE {
                self.take_pieces(e, false)?;
            }
            self.stats.drive_edges += 1;
        }
        if LOCATE {
            self.crossings.iter().for_each(|c| self.locator.missed[c.contact] = 0.0);
        }
        Ok(longest)
    }

    /// Determines the pieces of all contacts at the start of the step and checks their gaps and rigid stops.
    fn take_pieces<V: Vector>(&mut self, e: &mut Ends<'_, V>, afresh: bool) -> Result<(), IntegrateError> {
        self.locator.classify(e, afresh);
        e.check_gaps(e.t)?;
        self.locator.check_stops(e.t)
    }
}

/// The next drive edge after `t`; infinite if there is none.
fn edge_after(model: &dyn Model, t: f64) -> Result<f64, IntegrateError> {
    match model.next_edge(t) {
        None => Ok(f64::INFINITY),
        Some(edge) if edge > t => Ok(edge),
        Some(edge) => Err(IntegrateError::DriveEdge { t, edge }),
    }
}
