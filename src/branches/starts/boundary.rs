//! The start of a boundary over two parameters.

use crate::branches::border::Reference;
use crate::branches::boundary::boundary_curve::{Boundary, BoundaryCurve};
use crate::branches::boundary::boundary_line::{BoundaryHead, BoundaryLine, BoundaryPoint};
use crate::branches::boundary::grazed_stops::{grazed_stops, softest_impact};
use crate::branches::boundary::half_orbit::first_half;
use crate::branches::boundary::slice::Slice;
use crate::branches::branch_error::BranchError;
use crate::branches::continuation::Continuation;
use crate::branches::curve::engine::Engine;
use crate::branches::family::Family;
use crate::branches::following::Following;
use crate::branches::orbits::by_shooting::measure::measure;
use crate::branches::orbits::by_shooting::orbit_curve::OrbitCurve;
use crate::branches::orbits::measured::Measured;
use crate::branches::points::branch_point::BranchPoint;
use crate::branches::points::kind::{PointKind, SpecialPoint};
use crate::branches::starts::start::{Resume, Start};
use crate::branches::steps::stepper::Stepper;
use crate::contact::Piece;
use crate::contact::edge::Edge;
use crate::periodic::ShootingOrbit;
use std::rc::Rc;
use std::sync::Arc;

/// Unit of p where p is near 0, as a share of the length of its bounds.
const UNIT_NEAR_ZERO: f64 = 0.1;

/// The boundary of a located point.
impl Start<2> for &BranchPoint {
    type Point = BoundaryPoint;

    fn begin<'f>(
        self,
        settings: &'f Continuation,
        plane: &'f Family<'f, 2>,
    ) -> Result<Following<'f, BoundaryPoint>, BranchError> {
        let what = self.located.as_ref().ok_or(BranchError::Kind { kind: None, wanted: HAVE_BOUNDARY })?;
        let start = ([self.parameter, settings.from], settings.across(self.parameter)?);
        settings.boundary_from(plane, what, start, &self.orbit, settings.heading()).map(Following::new)
    }
}

impl Resume<2> for BoundaryPoint {
    fn resume<'f>(
        &self,
        line: &BoundaryLine,
        heading: f64,
        settings: &'f Continuation,
        plane: &'f Family<'f, 2>,
    ) -> Result<Following<'f, Self>, BranchError> {
        let BoundaryHead { what, across, .. } = &line.head;
        let start = (self.parameters, *across);
        settings.boundary_from(plane, what, start, &self.orbit, heading).map(Following::new)
    }
}

impl Continuation {
    /// The boundary through an orbit. `heading`: sign of the first change of λ.
    fn boundary_from<'f>(
        &'f self,
        plane: &'f Family<'f, 2>,
        what: &SpecialPoint,
        ([p, other], across): ([f64; 2], [f64; 2]),
        orbit: &ShootingOrbit,
        heading: f64,
    ) -> Result<Stepper<'f, BoundaryCurve<'f>>, BranchError> {
        let shooting = self.shooting_of_boundary()?;
        let least_unit =
            if self.is_bounded_across() { UNIT_NEAR_ZERO * (across[1] - across[0]) } else { 0.0 };
        let slice = Arc::new(Slice::new(plane, other));
        let meter = Rc::new(self.budget.begin());
        let unit = p.abs().max(least_unit);
        let half = (what.kind() == PointKind::SymmetryBreaking).then(|| first_half(orbit));
        let orbit = half.as_ref().unwrap_or(orbit);
        let mut orbits = OrbitCurve::new(slice.family(), (p, unit), orbit, &shooting, meter)?;
        if half.is_some() {
            orbits = orbits.over_half();
        }
        let x = orbits.unknowns_of(orbit);
        let passage = orbits.pass(&*orbits.model(p)?, &x)?;
        let measured = measure(&orbits, p, &passage, &[])?;
        let boundary = boundary_of(what, &measured)?;
        let range = measured.ranges.iter().take(measured.ranges.len() / 2).fold(0.0, |m: f64, r| m.max(*r));
        let model = slice.model([p, other])?;
        let rigid = model.offers().rigid_edges(model.contacts());
        drop(model);
        if let Boundary::Grazing(own) = &boundary {
            let grazed = grazed_stops(&rigid, &measured.trace, range);
            if own.edge.is_stop(&rigid, own.contact) && !grazed.contains(&(own.contact, own.edge)) {
                return Err(BranchError::Struck { contact: own.contact });
            }
            slice.leave_out(grazed);
        }
        let other_unit = self.unit();
        let model = slice.model([p, other])?;
        let rigid = model.offers().rigid_edges(model.contacts()); // without those that are left out
        let reference = Reference::of_any_orbit(&*model, &measured);
        drop(model);
        let softest = softest_impact(&rigid, &measured.trace).map_or(1.0, |(share, _)| share);
        let curve = BoundaryCurve {
            slice,
            orbits,
            boundary,
            rigid: rigid.clone(),
            unit,
            least_unit,
            other_unit,
            range,
            softest,
        };
        let tolerance = shooting.tolerance;
        let mut engine =
            Engine { curve, unit: other_unit, tolerance, max_corrections: 12, at_crossing: false };
        let n = x.len();
        let first = engine.start_towards(x.insert_row(n, p), other, heading)?;
        let head = BoundaryHead { parameters: plane.parameters.clone(), what: *what, across };
        Ok(Stepper::new(self, engine, (first, measured), head, (reference, rigid), Some(across))?)
    }
}

/// Kinds of points that have a boundary.
const HAVE_BOUNDARY: &str =
    "a fold, a period doubling, a Neimark-Sacker point, a symmetry breaking or a grazing";

/// What vanishes along the boundary of a point of this kind.
fn boundary_of(what: &SpecialPoint, measured: &Measured) -> Result<Boundary, BranchError> {
    match *what {
        SpecialPoint::Bifurcation(PointKind::Fold) => Ok(Boundary::Fold),
        SpecialPoint::Bifurcation(PointKind::PeriodDoubling) => Ok(Boundary::PeriodDoubling),
        SpecialPoint::Bifurcation(PointKind::NeimarkSacker) => Ok(Boundary::NeimarkSacker),
        SpecialPoint::Bifurcation(PointKind::SymmetryBreaking) => Ok(Boundary::SymmetryBreaking),
        SpecialPoint::Bifurcation(kind) => Err(BranchError::Kind { kind: Some(kind), wanted: HAVE_BOUNDARY }),
        SpecialPoint::Grazing { contact, flank, .. } => {
            let nearest = measured.trace.closest(contact, Edge::between(Piece::Gap, flank));
            Ok(Boundary::Grazing(*nearest.ok_or(BranchError::NoExtremum { contact })?))
        }
    }
}
