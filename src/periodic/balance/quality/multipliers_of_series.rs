//! Floquet multipliers along the series of a balance.

use crate::contact::Contact;
use crate::contact::edge::Edge;
use crate::error::check;
use crate::excitation::Side;
use crate::model::Periodic;
use crate::model::structure::drifts::Drifts;
use crate::ode::budget::Meter;
use crate::periodic::balance::admission::drifts;
use crate::periodic::balance::crossings::instants::{Crossings, OrbitCrossing};
use crate::periodic::balance::fourier_orbit::FourierOrbit;
use crate::periodic::balance::integration::jumps::BothSides;
use crate::periodic::balance::quadrature::panel_points::{MAX_EDGES, drive_edges};
use crate::periodic::balance::quality::series_flow::SeriesFlow;
use crate::periodic::balance::series::grid::Grid;
use crate::periodic::balance::series::spectra::Spectra;
use crate::periodic::balance::series::transform::samples_for;
use crate::periodic::balance::settings::Balance;
use crate::periodic::multipliers::{MultiplierError, Multipliers};
use std::f64::consts::TAU;

/// Length of a step as a phase of the fastest local oscillation `[rad]`. Over ten oscillations the error of
/// the multipliers is then about 1e-8 or less.
const PHASE_STEP: f64 = 1.2;

/// Number of corrections of an instant at which a contact passes an edge.
const CORRECTIONS: usize = 2;

/// Time over which the rate of an inner kink is a difference, as a share of 1 rad of the highest order `[1]`.
const AHEAD: f64 = 1e-6;

/// The smooth intervals of one span.
pub(crate) struct Smooth {
    /// Their ends, in increasing time.
    pub(crate) breaks: Vec<f64>,
    /// Whether an acceleration jumps at a crossing.
    pub(crate) jumps: bool,
}

/// A contact passes one of its edges.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CrossingTime {
    pub(crate) time: f64,
    pub(crate) contact: usize,
    pub(crate) edge: Edge,
}

impl From<&OrbitCrossing> for CrossingTime {
    /// With times in units of the distance of two samples.
    fn from(crossing: &OrbitCrossing) -> Self {
        let edge = Edge::between(crossing.from, crossing.to);
        CrossingTime { time: crossing.time(1.0), contact: crossing.contact, edge }
    }
}

impl Balance {
    /// Y' = [0 1; ∂a/∂q ∂a/∂v] Y over one span: Floquet multipliers of the equation linearised along a
    /// series. Of the settings only the [`Budget`](crate::Budget) matters.
    ///
    /// The method is Gauss collocation of order 12 on the smooth intervals between crossings and drive edges.
    /// Source: Hairer & Wanner II, Sect. IV.5.
    ///
    /// It is faster than shooting. The error estimate is the change when the top quarter of the orders is
    /// dropped and the steps are doubled. With rattle the crossings of a truncated series are slightly wrong;
    /// the multipliers of [`Shooting::solve_from`](crate::Shooting::solve_from) are then the reference. If an
    /// acceleration jumps at a crossing, the error is infinite and the stability undecided.
    ///
    /// # Errors
    /// [`MultiplierError`].
    pub fn multipliers(
        &self,
        model: &dyn Periodic,
        orbit: &FourierOrbit,
    ) -> Result<Multipliers, MultiplierError> {
        let n = model.dof();
        check::length("coordinates of the orbit", orbit.dof(), n)?;
        model.offers().refuse_stops(|contact| MultiplierError::RigidStop { contact })?;
        let drifts = drifts(model);
        let (breaks, jumps) = orbit.breaks(model);
        if breaks.len() > MAX_EDGES {
            return Err(MultiplierError::Breaks { count: breaks.len(), max: MAX_EDGES });
        }
        let (smooth, meter) = (Smooth { breaks, jumps }, self.budget.begin());
        let multipliers = orbit.multipliers_between(
            model,
            &drifts,
            &smooth,
            &|fewer| Some(fewer.breaks(model).0),
            &meter,
        )?;
        meter.left()?;
        Ok(multipliers)
    }
}

impl FourierOrbit {
    /// Multipliers with known smooth intervals. `again`: ends of the smooth intervals of the series with
    /// fewer orders that estimates the error; `None` if they are not found, and the error is then infinite.
    pub(crate) fn multipliers_between(
        &self,
        model: &dyn Periodic,
        drifts: &Drifts,
        smooth: &Smooth,
        again: &dyn Fn(&FourierOrbit) -> Option<Vec<f64>>,
        meter: &Meter<'_>,
    ) -> Result<Multipliers, MultiplierError> {
        let n = self.dof();
        let basis = drifts.basis(&vec![1.0; 2 * n]);
        let mut flow = SeriesFlow::new(self, model, meter);
        let multipliers =
            Multipliers::without(&flow.monodromy(self, &smooth.breaks, PHASE_STEP)?, &basis, 0.0)?;
        if smooth.jumps {
            return Ok(multipliers.with_error(f64::INFINITY));
        }
        let highest = self.harmonics().highest();
        let rough = self.below(highest - highest.div_ceil(4)).and_then(|fewer| {
            let monodromy = flow.monodromy(&fewer, &again(&fewer)?, 2.0 * PHASE_STEP).ok()?;
            Multipliers::without(&monodromy, &basis, 0.0).ok()
        });
        Ok(multipliers.compared_with(rough))
    }

    /// The instants at which contacts of this orbit pass their edges, near those of a similar orbit. `None`
    /// if one is further away than 1 rad of the highest order.
    pub(crate) fn crossings_near(
        &self,
        model: &dyn Periodic,
        crossings: impl Iterator<Item = CrossingTime>,
    ) -> Option<Vec<f64>> {
        let n = self.dof();
        let (mut q, mut v, mut u) = (vec![0.0; n], vec![0.0; n], vec![0.0; model.drives()]);
        let mut contacts = vec![Contact::default(); model.contacts()];
        let reach = self.period() / (TAU * self.harmonics().highest().max(1) as f64);
        let touching = model.offers().touching(contacts.len());
        let mut distance = |crossing: &CrossingTime, t: f64| {
            self.motion(t, &mut q, &mut v);
            model.drive(t, Side::After, &mut u);
            model.contact(&u, &q, &v, &mut contacts);
            let c = &contacts[crossing.contact];
            [crossing.edge.distance(c), crossing.edge.rate(c)]
        };
        let mut near = |crossing: CrossingTime| {
            let mut t = crossing.time;
            for _ in 0..CORRECTIONS {
                let [d, mut rate] = distance(&crossing, t);
                if crossing.contact >= touching {
                    // The model does not give the rate of an inner kink.
                    let ahead = AHEAD * reach;
                    rate = (distance(&crossing, t + ahead)[0] - d) / ahead;
                }
                t -= d / rate;
            }
            ((t - crossing.time).abs() < reach).then_some(t)
        };
        crossings.map(&mut near).collect()
    }

    /// Ends of the smooth intervals of one span, and whether an acceleration jumps at a crossing. Y then
    /// jumps too; the collocation does not contain that jump.
    fn breaks(&self, model: &dyn Periodic) -> (Vec<f64>, bool) {
        let mut breaks = drive_edges(model, self.period());
        breaks.extend([0.0, self.period()]);
        let mut jumps = false;
        if model.contacts() > 0 {
            let mut grid = Grid::new(model, self.harmonics(), samples_for(self.harmonics().highest()));
            grid.set(self.all_coefficients(), self.mean_velocity());
            let mut crossings = Crossings::new(model.contacts(), grid.samples());
            crossings.locate(&mut grid);
            breaks.extend(crossings.list().iter().map(|e| e.time(grid.step())));
            let mut spectra = Spectra::new(self.dof(), 0, self.harmonics());
            BothSides::new(self.dof(), model.contacts()).jumps(&grid, &crossings, &mut spectra);
            jumps = !spectra.jumps.is_empty();
        }
        breaks.sort_by(f64::total_cmp);
        (breaks, jumps)
    }
}
