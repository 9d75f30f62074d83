//! The equations of a bifurcation or an onset over two parameters.

use crate::branches::boundary::slice::Slice;
use crate::branches::curve::equations::{Curve, CurveError, Linear};
use crate::branches::orbits::by_shooting::measure::measure;
use crate::branches::orbits::by_shooting::orbit_curve::{OrbitCurve, Passage, Slopes};
use crate::branches::orbits::contact_trace::{ContactTrace, Extremum, Rigid};
use crate::branches::points::test_functions::{doubling, fold, torus};
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// What vanishes along a boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Boundary {
    Fold,
    PeriodDoubling,
    NeimarkSacker,
    /// A perturbation returns unchanged after half a period, in which a symmetric orbit changes its sign.
    SymmetryBreaking,
    /// The distance of this extremum from its edge, over the range of motion.
    Grazing(Extremum),
}

impl Boundary {
    /// The crossings of all edges of all contacts. At the edge of a grazing, where rounding decides about the
    /// extremum of the boundary, the number of other extremes past the edge replaces them.
    pub(crate) fn sequence(&self, trace: &ContactTrace) -> Vec<[u32; 2]> {
        let mut sequence = trace.crossings.clone();
        if let Boundary::Grazing(own) = self {
            let tracked = trace.nearest(own).map(|extremum| extremum.phase);
            let past = |e: &&Extremum| if e.maximum { e.distance > 0.0 } else { e.distance < 0.0 };
            let others = trace.extremes.iter().filter(|e| e.is_like(own) && Some(e.phase) != tracked);
            sequence[own.contact][own.edge as usize] = others.filter(past).count() as u32;
        }
        sequence
    }
}

/// G(x, p, λ) = 0 and ψ(x, p, λ) = 0 for an orbit x and the test function ψ of a boundary. Unknowns: x, then
/// p.
///
/// The derivatives of ψ are forward differences: one integration over the orbit for each unknown.
pub(crate) struct BoundaryCurve<'f> {
    pub(crate) slice: Arc<Slice<'f>>,
    pub(crate) orbits: OrbitCurve<'f>,
    pub(crate) boundary: Boundary,
    /// Which edges of each contact are rigid stops, without those that are left out.
    pub(crate) rigid: Rigid,
    /// Unit of p.
    pub(crate) unit: f64,
    /// Least unit of p.
    pub(crate) least_unit: f64,
    /// Unit of λ.
    pub(crate) other_unit: f64,
    /// Unit of a distance from an edge.
    pub(crate) range: f64,
    /// The least squared speed of an impact over the square of the largest velocity; 1 without impacts. The
    /// smaller it is, the shorter are the differences from which the derivatives of ψ follow.
    pub(crate) softest: f64,
}

/// Step of the differences of ψ, in units of the unknowns.
const PSI_STEP: f64 = 1e-6;

/// Share of `softest` from which on the step is shorter `[1]`.
const EASY: f64 = 10.0;

/// Step of the differences of G with respect to a parameter without exact derivative, in its unit.
const PLANE_STEP: f64 = 1e-5;

impl BoundaryCurve<'_> {
    /// ψ of a passage.
    fn test(&self, p: f64, passage: &Passage) -> Result<f64, CurveError> {
        let value = match &self.boundary {
            Boundary::Grazing(extremum) => {
                let measured = measure(&self.orbits, p, passage, &[])?;
                measured.trace.nearest(extremum).map(|at| at.distance / self.range)
            }
            Boundary::Fold | Boundary::SymmetryBreaking => passage.multipliers.as_ref().map(fold),
            Boundary::PeriodDoubling => passage.multipliers.as_ref().map(doubling),
            Boundary::NeimarkSacker => passage.multipliers.as_ref().and_then(torus),
        };
        // The extremum or the pair of multipliers is gone: the boundary ends.
        value.ok_or(CurveError::BoundaryEnds)
    }

    /// ψ at other unknowns.
    fn test_at(&self, x: &DVector<f64>, p: f64, other: f64) -> Result<f64, CurveError> {
        let model = self.slice.model([p, other]);
        let model = model.map_err(|error| CurveError::Model { parameter: other, error })?;
        let passage = self.orbits.pass(&*model, x)?;
        drop(model);
        let before = self.slice.replace(other);
        let value = self.test(p, &passage);
        self.slice.replace(before);
        value
    }

    /// Forward difference of ψ; backward if there is no model ahead.
    fn slope(
        &self,
        psi: f64,
        h: f64,
        at: &dyn Fn(&Self, f64) -> Result<f64, CurveError>,
    ) -> Result<f64, CurveError> {
        match at(self, h) {
            Err(CurveError::Model { .. }) => Ok((psi - at(self, -h)?) / h),
            ahead => Ok((ahead? - psi) / h),
        }
    }

    fn parameters(&self, x: &DVector<f64>, p: f64, other: f64) -> Result<Slopes, CurveError> {
        let failed = |error| CurveError::Model { parameter: other, error };
        let model = self.slice.model([p, other]).map_err(failed)?;
        let exact = self.slice.plane.constants.zip(model.offers().constants);
        let units = [self.unit, self.other_unit];
        let forced = exact.map(|(places, constants)| {
            [0, 1].map(|k| constants.drive_slope(places[k]).times(units[k])).to_vec()
        });
        let known = forced.is_some();
        let mut slopes = self.orbits.slopes(&*model, x, &forced.unwrap_or_default())?;
        if !known {
            slopes.by_c = DMatrix::zeros(x.len(), 2);
            let of_p = |p: f64| self.slice.model([p, other]);
            let of_other = |other: f64| self.slice.model([p, other]);
            let columns = [
                self.orbits.differences(x, p, PLANE_STEP * self.unit, &of_p)?,
                self.orbits.differences(x, other, PLANE_STEP * self.other_unit, &of_other)?,
            ];
            for (k, columns) in columns.iter().enumerate() {
                for (i, column) in columns.iter().enumerate() {
                    slopes
                        .by_c
                        .view_mut((i * column.len(), k), (column.len(), 1))
                        .copy_from(&(column * units[k]));
                }
            }
        }
        Ok(slopes)
    }
}

impl Curve for BoundaryCurve<'_> {
    type Solution = Passage;

    fn linearise(&mut self, all: &DVector<f64>, other: f64) -> Result<Linear<Passage>, CurveError> {
        let n = all.len() - 1;
        let (x, p) = (all.rows(0, n).into_owned(), all[n]);
        self.slice.replace(other);
        let Slopes { residual, by_x, by_c, passage } = self.parameters(&x, p, other)?;
        let psi = self.test(p, &passage)?;
        let sizes = self.orbits.sizes();
        let (mut full, mut by_p) = (DMatrix::zeros(n + 1, n + 1), DVector::zeros(n + 1));
        full.view_mut((0, 0), (n, n)).copy_from(&by_x);
        full.view_mut((0, n), (n, 1)).copy_from(&(by_c.column(0) / self.unit));
        by_p.rows_mut(0, n).copy_from(&(by_c.column(1) / self.other_unit));
        let mut moved = x.clone();
        let step = PSI_STEP * (EASY * self.softest).min(1.0);
        for j in 0..n {
            let h = step * sizes[j];
            moved[j] = x[j] + h;
            full[(n, j)] = (self.test_at(&moved, p, other)? - psi) / h;
            moved[j] = x[j];
        }
        let h = step * self.unit;
        full[(n, n)] = self.slope(psi, h, &|this, h| this.test_at(&x, p + h, other))?;
        let h = step * self.other_unit;
        by_p[n] = self.slope(psi, h, &|this, h| this.test_at(&x, p, other + h))?;
        let residual = residual.insert_row(n, psi);
        Ok(Linear { residual, by_x: full, by_p, solution: passage })
    }

    fn units(&self) -> DVector<f64> {
        let own = self.orbits.units();
        let n = own.len();
        own.insert_row(n, self.unit)
    }
}
