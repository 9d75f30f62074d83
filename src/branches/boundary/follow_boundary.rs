//! Settings and start of a boundary.

use crate::branches::border::Reference;
use crate::branches::boundary::boundary_curve::{Boundary, BoundaryCurve};
use crate::branches::boundary::boundary_line::BoundaryLine;
use crate::branches::boundary::following_boundary::FollowingBoundary;
use crate::branches::boundary::grazed_stops::{grazed_stops, softest_impact};
use crate::branches::boundary::half_orbit::first_half;
use crate::branches::boundary::plane::{Plane, Slice};
use crate::branches::branch::BranchError;
use crate::branches::branch_end::BranchEnd;
use crate::branches::continuation::Continuation;
use crate::branches::curve::engine::Engine;
use crate::branches::orbits::by_shooting::orbit_curve::OrbitCurve;
use crate::branches::orbits::measure::{Measured, measure};
use crate::branches::points::branch_point::BranchPoint;
use crate::branches::points::kind::PointKind;
use crate::contact::piece::Piece;
use crate::periodic::shooting::shooting_orbit::ShootingOrbit;
use std::cell::{Cell, RefCell};
use std::rc::Rc;

/// Unit of p where p is near 0, as a share of the length of its bounds.
const SHARE: f64 = 0.1;

impl Continuation {
    /// Follows a located point of a branch over p (a fold, a period doubling, a Neimark-Sacker point, a symmetry
    /// breaking or a grazing, the onset of contact loss among them) along a second parameter λ, from the start of this continuation
    /// towards its end. The point was located at λ = `from`.
    ///
    /// The line passes extremes of λ and cusps. It ends at a bound of λ or p, where it returns to its start, where
    /// the extremum of the contact or the pair of multipliers ceases to exist, or at the maximum of points. A line of
    /// orbits with impacts on a rigid stop also ends where the speed of an impact falls below 1e-3 of the largest
    /// rate of its contact ([`BranchEnd::SoftImpact`]): beyond lies a resonant grazing, at which the multipliers are unbounded.
    ///
    /// Along the grazing of a rigid stop this stop is left out of the model: the grazing orbits are those without impacts
    /// on it. The line ends ([`BranchEnd::Stop`]) where they would pass the stop at another time.
    ///
    /// A symmetry breaking is followed within the symmetric orbits, over half their period. A branch point has no
    /// boundary: a change of a second parameter separates the two branches.   Source: Govaerts (2000), Ch. 4 and 8; for grazing, Dercole & Kuznetsov, ACM
    /// Trans. Math. Softw. 31, 95 (2005).
    ///
    /// # Errors
    /// [`BranchError`]: settings out of range; a point of a kind that has no boundary; a point that does not lie
    /// on the boundary at λ = `from`; the grazing of a rigid stop that the orbit strikes at another time.
    pub fn boundary(&self, plane: &dyn Plane, point: &BranchPoint) -> Result<BoundaryLine, BranchError> {
        let forward = self.begin_boundary(plane, point)?.finish();
        if !self.is_both_ways() || matches!(forward.end, BranchEnd::Closed | BranchEnd::Exhausted(_)) {
            return Ok(forward);
        }
        let start = ([point.parameter, self.from], forward.across);
        // What fails in the second direction does not lose the first.
        match self.boundary_from(plane, &forward.kind, start, &point.orbit, -self.heading()) {
            Ok(back) => Ok(back.finish().reversed_before(forward)),
            Err(_) => Ok(forward),
        }
    }

    /// Starts a boundary that yields its points one by one. It can be stopped at any point; see
    /// [`resume_boundary`](Continuation::resume_boundary).
    ///
    /// # Errors
    /// As [`boundary`](Continuation::boundary).
    pub fn begin_boundary<'f>(
        &'f self,
        plane: &'f dyn Plane,
        point: &BranchPoint,
    ) -> Result<FollowingBoundary<'f>, BranchError> {
        self.check()?;
        let kind = point.kind.clone().ok_or(BranchError::Kind { kind: None, wanted: WANTED })?;
        let start = ([point.parameter, self.from], self.across(point.parameter)?);
        self.boundary_from(plane, &kind, start, &point.orbit, self.heading())
    }

    /// Continues a boundary from its last point in the direction in which it was followed. The result begins with
    /// that point.
    ///
    /// # Errors
    /// As [`boundary`](Continuation::boundary); also for a boundary without points.
    pub fn resume_boundary<'f>(
        &'f self,
        plane: &'f dyn Plane,
        line: &BoundaryLine,
    ) -> Result<FollowingBoundary<'f>, BranchError> {
        self.check()?;
        let last = line.points.last().ok_or(BranchError::NoPoints)?;
        self.check_within(last.parameters[1])?;
        let mut following =
            self.boundary_from(plane, &line.kind, (last.parameters, line.across), &last.orbit, line.heading)?;
        following.shift(last.arclength);
        Ok(following)
    }

    /// The boundary through an orbit. `heading`: sign of the first change of λ.
    fn boundary_from<'f>(
        &'f self,
        plane: &'f dyn Plane,
        kind: &PointKind,
        ([p, other], across): ([f64; 2], [f64; 2]),
        orbit: &ShootingOrbit,
        heading: f64,
    ) -> Result<FollowingBoundary<'f>, BranchError> {
        let least_unit = if self.is_bounded_across() { SHARE * (across[1] - across[0]) } else { 0.0 };
        let slice = Rc::new(Slice { plane, other: Cell::new(other), left_out: RefCell::new(Rc::new([])) });
        let meter = Rc::new(self.budget.begin());
        let unit = p.abs().max(least_unit);
        let half = (*kind == PointKind::SymmetryBreaking).then(|| first_half(orbit));
        let orbit = half.as_ref().unwrap_or(orbit);
        let mut orbits = OrbitCurve::new(slice.clone(), (p, unit), orbit, &self.shooting, meter)?;
        if half.is_some() {
            orbits = orbits.over_half();
        }
        let x = orbits.unknowns_of(orbit);
        let passage = orbits.pass(&*orbits.model(p)?, &x)?;
        let measured = measure(&orbits, p, &passage, &[])?;
        let boundary = boundary_of(kind, &measured)?;
        let range = measured.ranges.iter().take(measured.ranges.len() / 2).fold(0.0, |m: f64, r| m.max(*r));
        let model = slice.model([p, other])?;
        let rigid = model.offers().rigid_edges(model.contacts());
        drop(model);
        if let Boundary::Grazing(own) = &boundary {
            let grazed = grazed_stops(&rigid, &measured.trace, range);
            let edge = usize::from(!own.lower);
            if rigid.get(own.contact).is_some_and(|rigid| rigid[edge])
                && !grazed.contains(&(own.contact, own.edge()))
            {
                return Err(BranchError::Struck { contact: own.contact });
            }
            *slice.left_out.borrow_mut() = grazed.into();
        }
        let sequence = boundary.sequence(&measured.trace);
        let other_unit = self.unit();
        let model = slice.model([p, other])?;
        let rigid = model.offers().rigid_edges(model.contacts()); // without those that are left out
        let reference = Reference::of_any_orbit(&*model, &measured);
        drop(model);
        let motion = reference.motion(&measured);
        let size = (reference, motion);
        let softest = softest_impact(&rigid, &measured.trace).map_or(1.0, |(share, _)| share);
        let curve = BoundaryCurve { slice, orbits, boundary, unit, least_unit, other_unit, range, softest };
        let tolerance = self.shooting.correction_tolerance();
        let mut engine =
            Engine { curve, unit: other_unit, tolerance, max_corrections: 12, at_crossing: false };
        let n = x.len();
        let first = engine.start_towards(x.insert_row(n, p), other, heading)?;
        let line = BoundaryLine {
            parameters: plane.parameters(),
            kind: kind.clone(),
            points: Vec::new(),
            notes: Vec::new(),
            end: BranchEnd::Open,
            start: None,
            heading: first.slope(),
            across,
        };
        Ok(FollowingBoundary::new(self, engine, first, rigid, size, sequence, line)?)
    }
}

/// Kinds of points that have a boundary.
const WANTED: &str = "a fold, a period doubling, a Neimark-Sacker point, a symmetry breaking or a grazing";

/// What vanishes along the boundary of a point of this kind.
fn boundary_of(kind: &PointKind, measured: &Measured) -> Result<Boundary, BranchError> {
    match kind {
        PointKind::Fold => Ok(Boundary::Fold),
        PointKind::PeriodDoubling => Ok(Boundary::PeriodDoubling),
        PointKind::NeimarkSacker => Ok(Boundary::NeimarkSacker),
        PointKind::SymmetryBreaking => Ok(Boundary::SymmetryBreaking),
        PointKind::Grazing { contact, edge, .. } => {
            let lower = *edge == Piece::Lower;
            let of = measured.trace.extremes.iter().filter(|e| e.contact == *contact && e.lower == lower);
            let nearest = of.min_by(|a, b| a.distance.abs().total_cmp(&b.distance.abs()));
            Ok(Boundary::Grazing(*nearest.ok_or(BranchError::NoExtremum { contact: *contact })?))
        }
        kind => Err(BranchError::Kind { kind: Some(kind.clone()), wanted: WANTED }),
    }
}
