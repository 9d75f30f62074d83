//! Derivatives of a located parameter with respect to all constants.

use crate::branches::branch_error::BranchError;
use crate::branches::curve::bordered::Bordered;
use crate::branches::curve::equations::CurveError;
use crate::branches::orbits::by_shooting::measure::measure;
use crate::branches::orbits::without_stops::WithoutStops;
use crate::branches::points::branch_point::BranchPoint;
use crate::branches::points::kind::{PointKind, SpecialPoint};
use crate::branches::points::test_functions::{doubling, torus};
use crate::branches::sensitivity::along::{along_direction, smooth};
use crate::branches::sensitivity::derivatives::{Neighbours, gather};
use crate::branches::sensitivity::quantity::Quantity;
use crate::branches::sensitivity::sensitivity_of_orbit::Sensitivity;
use crate::branches::sensitivity::totals::Totals;
use crate::contact::Piece;
use crate::contact::edge::Edge;
use crate::model::Periodic;
use crate::model::equations::Constants;
use crate::numeric::norms::right_vectors;
use crate::periodic::Multipliers;
use nalgebra::{DMatrix, DVector};
use std::rc::Rc;

impl Sensitivity {
    /// dp*/dc: derivatives of the parameter p* at which a located point lies, for example a jump speed or the
    /// onset of rattle, with respect to all constants c. The entry of the parameter itself is 0.
    ///
    /// `model`: any model of the branch. `parameter`: the constant along which the branch was followed; it
    /// takes the value at the point.
    ///
    /// - fold: dp*/dc = -(wᵀ ∂G/∂c)/(wᵀ ∂G/∂p) with the left null vector w of ∂G/∂x;
    /// - all other kinds: dp*/dc = -(dψ/dc)/(dψ/dp) with the test function ψ along the orbits; for a grazing
    ///   ψ is the distance of the contact from its edge, for a period doubling or a Neimark-Sacker point a
    ///   function of the multipliers, whose derivative is a difference of fourth order.
    ///
    /// Source: Govaerts, Numerical Methods for Bifurcations of Dynamical Equilibria, Ch. 4.
    ///
    /// # Errors
    /// [`BranchError::Kind`] for a point that was not located or is a crossing of branches;
    /// A model without named constants; an unknown constant.
    pub fn of_point(
        model: &dyn Periodic,
        parameter: &str,
        point: &BranchPoint,
    ) -> Result<Vec<f64>, BranchError> {
        let family = model.offers().named()?;
        let index = family.index(parameter)?;
        let at = without_grazed_stop(family.with_values(&[(index, point.parameter)])?, point);
        let constants = at.offers().named()?;
        let totals = Totals::new(&*at, constants, &point.orbit, Rc::new(point.orbit.budget.begin()))?;
        let along: Vec<f64> = match &point.located {
            Some(SpecialPoint::Bifurcation(PointKind::Fold)) => {
                let w = left_null(&totals.by_x).ok_or(CurveError::Singular)?;
                let slopes = totals.by_c.tr_mul(&w);
                slopes.iter().zip(&totals.units).map(|(slope, unit)| slope / unit).collect()
            }
            Some(SpecialPoint::Bifurcation(PointKind::PeriodDoubling)) => {
                return of_multipliers(&totals, constants, index, &|m| Some(doubling(m)));
            }
            Some(SpecialPoint::Bifurcation(PointKind::NeimarkSacker)) => {
                return of_multipliers(&totals, constants, index, &torus);
            }
            Some(SpecialPoint::Grazing { contact, flank, .. }) => {
                grazing(&totals, &*at, *contact, Edge::between(Piece::Gap, *flank))?
            }
            _ => {
                let wanted = "a fold, a period doubling, a Neimark-Sacker point or a grazing";
                return Err(BranchError::Kind { kind: point.kind(), wanted });
            }
        };
        let own = along[index];
        if !(own.is_finite() && own != 0.0) {
            return Err(CurveError::Singular.into());
        }
        let slope = |(k, slope): (usize, &f64)| if k == index { 0.0 } else { -slope / own };
        Ok(along.iter().enumerate().map(slope).collect())
    }
}

/// The model without the rigid stop that the orbit of a grazing touches, unless it strikes it at another
/// time.
fn without_grazed_stop<'m>(model: Box<dyn Periodic + 'm>, point: &BranchPoint) -> Box<dyn Periodic + 'm> {
    if let Some(SpecialPoint::Grazing { contact, flank, .. }) = point.located {
        let edge = Edge::between(Piece::Gap, flank);
        if point.crossings[contact][edge as usize] == 0 {
            return Box::new(WithoutStops::new(model, &[(contact, edge)]));
        }
    }
    model
}

/// dp*/dc where a function ψ of the multipliers vanishes.
///
/// With the unit tangent (x_s, p_s) of the branch and the bounded solution of G_x x_c + G_p p_c = -G_c that
/// is orthogonal to it, dp*/dc = p_c - p_s (dψ along (x_c, p_c, c))/(dψ along the tangent). Near a fold dx/dc
/// itself is unbounded.
fn of_multipliers(
    totals: &Totals<'_>,
    constants: &dyn Constants,
    index: usize,
    of: &dyn Fn(&Multipliers) -> Option<f64>,
) -> Result<Vec<f64>, BranchError> {
    let n = totals.x.len();
    let wide = |last: Option<&DVector<f64>>| {
        DMatrix::from_fn(n + 1, n + 1, |i, j| match (i < n, j < n) {
            (true, true) => totals.by_x[(i, j)] * totals.size(j),
            (true, false) => totals.by_c[(i, index)],
            (false, _) => last.map_or(0.0, |last| last[j]),
        })
    };
    let right = right_vectors(wide(None)).ok_or(CurveError::Singular)?;
    let tangent = right.row(n).transpose();
    let factors = Bordered::new(wide(Some(&tangent))).ok_or(CurveError::Singular)?;
    let unscaled = |z: &DVector<f64>| DVector::from_fn(n, |j, _| z[j] * totals.size(j));
    let value = constants.values();
    let unit = totals.units[index];
    let at = |h: f64| constants.with_values(&[(index, value[index] + h * tangent[n] * unit)]);
    let by_tangent = smooth(along_direction(totals, &unscaled(&tangent), &at, of)?)?;
    if !(by_tangent.is_finite() && by_tangent != 0.0) {
        return Err(CurveError::Singular.into());
    }
    let mut all = Vec::with_capacity(totals.units.len());
    for (k, own) in totals.units.iter().enumerate() {
        if k == index {
            all.push(0.0);
            continue;
        }
        let mut right = DVector::zeros(n + 1);
        right.rows_mut(0, n).copy_from(&-totals.by_c.column(k));
        let z = factors.solve(right);
        let both = |h: f64| {
            let [c, p] = [value[k] + h * own, value[index] + h * z[n] * unit];
            constants.with_values(&[(k, c), (index, p)])
        };
        let along = smooth(along_direction(totals, &unscaled(&z), &both, of)?)?;
        all.push((z[n] - tangent[n] * along / by_tangent) * unit / own);
    }
    Ok(all)
}

/// Derivatives of the distance at the extremum that is nearest to its edge.
fn grazing(
    totals: &Totals<'_>,
    model: &dyn Periodic,
    contact: usize,
    edge: Edge,
) -> Result<Vec<f64>, BranchError> {
    let constants = model.offers().named()?;
    let slopes = totals.solve()?;
    let neighbours = Neighbours::new(constants, &totals.units, model.period())?;
    let measured = measure(&totals.curve, 0.0, &totals.passage, &[])?;
    let nearest = measured.trace.closest(contact, edge).ok_or(BranchError::NoExtremum { contact })?;
    let (start, period) = (totals.passage.states[0].t, totals.passage.end - totals.passage.states[0].t);
    let instant = start + nearest.phase * period;
    let quantity = [Quantity::Distance { contact, edge }];
    let gathered = gather(totals, model, &neighbours, &slopes, &quantity, Some(instant))?;
    Ok(gathered[0].at.iter().zip(&totals.units).map(|(slope, unit)| slope / unit).collect())
}

/// The left singular vector of the smallest singular value: a right one of the transposed matrix, since left
/// ones are divided by the singular value, which is 0.
fn left_null(matrix: &DMatrix<f64>) -> Option<DVector<f64>> {
    let right = right_vectors(matrix.transpose())?;
    Some(right.row(right.nrows() - 1).transpose())
}
