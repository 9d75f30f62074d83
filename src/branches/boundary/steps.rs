//! The steps of a boundary: its points, turning points and ends.

use crate::branches::border::border;
use crate::branches::boundary::boundary_curve::{Boundary, BoundaryCurve};
use crate::branches::boundary::boundary_line::{BoundaryHead, BoundaryPoint, Turn};
use crate::branches::boundary::grazed_stops::{GRAZES, SOFT, softest_impact};
use crate::branches::boundary::half_orbit::whole;
use crate::branches::branch_end::BranchEnd;
use crate::branches::curve::equations::CurveError;
use crate::branches::curve::point::CurvePoint;
use crate::branches::orbits::by_shooting::orbit_curve::Passage;
use crate::branches::orbits::contact_trace::{ContactTrace, Extremum};
use crate::branches::orbits::measured::Measured;
use crate::branches::orbits::orbit_method::Orbits;
use crate::branches::steps::node::Node;
use crate::branches::steps::stepper::{Followed, Over, Stepper};
use crate::error::ParameterError;
use crate::model::{Channel, Periodic, State};
use crate::periodic::{Multipliers, ShootingOrbit};
use nalgebra::DVector;

/// Largest |dp/ds| at a cusp `[1]`.
const TURNS: f64 = 1e-4;

impl BoundaryCurve<'_> {
    /// The point as one of the orbits over p, at its λ.
    fn on_orbits(&self, point: &CurvePoint<Passage>) -> CurvePoint<Passage> {
        let n = point.x.len() - 1;
        self.slice.replace(point.p);
        CurvePoint { x: point.x.rows(0, n).into_owned(), p: point.x[n], ..point.clone() }
    }

    /// Whether the orbits pass a stop that was left out.
    fn strikes(&self, trace: &ContactTrace) -> Option<usize> {
        let (left_out, range) = (self.slice.left_out(), self.range);
        let past = |e: &&Extremum| {
            e.is_outermost() && e.depth() > GRAZES * range && left_out.contains(&(e.contact, e.edge))
        };
        trace.extremes.iter().find(past).map(|e| e.contact)
    }

    /// The boundary of the next point: the extremum of a grazing moves.
    fn moved(&self, trace: &ContactTrace) -> Option<Boundary> {
        match &self.boundary {
            Boundary::Grazing(extremum) => trace.nearest(extremum).copied().map(Boundary::Grazing),
            other => Some(*other),
        }
    }
}

impl Orbits for BoundaryCurve<'_> {
    type Orbit = ShootingOrbit;

    fn orbit(&self, point: &CurvePoint<Passage>) -> Result<(ShootingOrbit, Multipliers), CurveError> {
        let (orbit, multipliers) = self.orbits.orbit(&self.on_orbits(point))?;
        Ok(if self.orbits.is_over_half() { whole(orbit, &multipliers) } else { (orbit, multipliers) })
    }
    fn first_state(&self, point: &CurvePoint<Passage>) -> Option<(usize, State)> {
        self.orbits.first_state(&self.on_orbits(point))
    }
    fn measure(&self, point: &CurvePoint<Passage>, channels: &[Channel]) -> Result<Measured, CurveError> {
        self.orbits.measure(&self.on_orbits(point), channels)
    }
    fn clear_of(&self, impacts: &[f64]) -> Option<f64> {
        self.orbits.clear_of(impacts)
    }
    fn shifted(&self, point: &CurvePoint<Passage>, shift: f64) -> Result<DVector<f64>, CurveError> {
        let n = point.x.len() - 1;
        Ok(self.orbits.shifted(&self.on_orbits(point), shift)?.insert_row(n, point.x[n]))
    }
    fn shift_nodes(&mut self, shift: f64, x: &DVector<f64>) {
        self.orbits.shift_nodes(shift, x);
        if let Boundary::Grazing(extremum) = &mut self.boundary {
            extremum.phase = (extremum.phase - shift).rem_euclid(1.0);
        }
    }
    fn accept(&mut self, point: &CurvePoint<Passage>, measured: &Measured) {
        self.boundary = self.moved(&measured.trace).unwrap_or(self.boundary);
        self.softest = softest_impact(&self.rigid, &measured.trace).map_or(1.0, |(share, _)| share);
        let at = self.on_orbits(point);
        self.unit = at.p.abs().max(self.least_unit);
        self.orbits.accept(&at, measured);
    }
}

impl Followed for BoundaryCurve<'_> {
    type Point = BoundaryPoint;
    type What = Turn;
    /// The differences of the test functions make the corrections converge linearly.
    const FEW: usize = 8;
    const WAITING: usize = 0;

    fn channels(_: &BoundaryHead) -> &[Channel] {
        &[]
    }

    fn model(&self, point: &CurvePoint<Passage>) -> Result<Box<dyn Periodic + '_>, ParameterError> {
        self.slice.model([point.x[point.x.len() - 1], point.p])
    }

    fn columns(
        &self,
        point: &CurvePoint<Passage>,
        _: Measured,
        arclength: f64,
        turn: Option<Turn>,
    ) -> Result<BoundaryPoint, CurveError> {
        let (orbit, multipliers) = self.orbit(point)?;
        let parameters = [point.x[point.x.len() - 1], point.p];
        Ok(BoundaryPoint { parameters, arclength, turn, multipliers, orbit })
    }

    fn over(
        stepper: &mut Stepper<'_, Self>,
        reached: &Node<Passage>,
        step: f64,
    ) -> Result<Over<BoundaryPoint>, CurveError> {
        let turn = stepper.turn(&reached.point, step)?;
        let (curve, trace) = (&stepper.engine.curve, &reached.measured.trace);
        if let Some(contact) = curve.strikes(trace) {
            return Err(CurveError::Strikes { contact });
        }
        let next = curve.moved(trace).ok_or(CurveError::BoundaryEnds)?;
        let is_same = next.sequence(trace) == curve.boundary.sequence(&stepper.last.measured.trace);
        let notes = if is_same { Vec::new() } else { vec!["the contact sequence changed"] };
        Ok(Over::Passes(turn.into_iter().collect(), notes))
    }

    fn border(stepper: &Stepper<'_, Self>, next: &CurvePoint<Passage>, [_, motion]: [f64; 2]) -> Option<f64> {
        let curve = &stepper.engine.curve;
        let (multiple, state) = curve.first_state(next)?;
        border(
            &curve.slice.family(),
            next.x[next.x.len() - 1],
            curve.unit,
            multiple,
            (motion, &state),
            &stepper.settings.budget,
        )
    }

    fn end_at(&self, measured: &Measured) -> Option<BranchEnd> {
        let (share, contact) = softest_impact(&self.rigid, &measured.trace)?;
        (share < SOFT && share < self.softest).then_some(BranchEnd::SoftImpact { contact })
    }
}

impl Stepper<'_, BoundaryCurve<'_>> {
    /// The turning point between the last point and `next`, if λ turns back.
    fn turn(&mut self, next: &CurvePoint<Passage>, step: f64) -> Result<Option<BoundaryPoint>, CurveError> {
        let n = next.x.len() - 1;
        let slopes = [&self.last.point, next].map(|point| [point.tangent[n], point.slope()]);
        if slopes[0][1] * slopes[1][1] >= 0.0 {
            return Ok(None);
        }
        let both = slopes[0][0] * slopes[1][0] < 0.0;
        let found = self.engine.locate(&self.last.point, next, step, &mut |_, point| Some(point.slope()))?;
        let columns = |at: CurvePoint<Passage>| {
            let along = self.arclength + self.engine.distance(&self.last.point, &at);
            // At a cusp p turns back at the same point.
            let turn = if both && at.tangent[n].abs() < TURNS { Turn::Cusp } else { Turn::Extremum };
            self.engine.curve.columns(&at, self.last.measured.clone(), along, Some(turn))
        };
        found.map(columns).transpose()
    }
}
