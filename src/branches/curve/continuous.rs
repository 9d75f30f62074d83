//! Whether a step stays on one curve.

use crate::branches::curve::engine::Engine;
use crate::branches::curve::equations::{Curve, CurveError};
use crate::branches::curve::locate::Between;
use crate::branches::curve::point::CurvePoint;

/// Largest first correction of the interpolated middle of a step on one curve, as a share of the step `[1]`.
const STRAIGHT: f64 = 0.05;

/// First correction below which the interpolation is exact: what curves differ by is larger `[1]`.
const EXACT: f64 = 1e-8;

/// Factor by which the first correction falls at least from a part of a smooth curve to its halves. Close to
/// its limit it falls by 1/16 `[1]`.
const FALLS: f64 = 0.125;

/// How often in a row it falls: where two curves meet, a half may pass both by chance.
const IN_A_ROW: u32 = 2;

/// How often a part is halved.
const HALVES: u32 = 7;

/// A part of a step: its ends, its middle and the first correction of the interpolated middle.
struct Part<S> {
    ends: [CurvePoint<S>; 2],
    middle: CurvePoint<S>,
    off: f64,
}

impl<C: Curve> Engine<C> {
    /// Computes the points in the middle of a step and of its halves. If the step has jumped to another
    /// curve, no point lies near the interpolation between its ends, or the points lie on both curves: the
    /// interpolation is then as wrong over the half with the jump as over the whole step. `ds`: distance of
    /// `b` from `a` along the tangent of `a`.
    ///
    /// # Errors
    /// The error of the corrections; [`CurveError::Turned`] if the first one is large, or does not fall as
    /// that of a smooth curve.
    pub(crate) fn is_continuous(
        &mut self,
        a: &CurvePoint<C::Solution>,
        b: &CurvePoint<C::Solution>,
        ds: f64,
    ) -> Result<(), CurveError> {
        let whole = self.part(a, b, ds)?;
        let off = whole.off;
        if off > STRAIGHT * ds || !self.is_smooth(&whole, 0, HALVES)? {
            return Err(CurveError::Turned { angle: (off / ds).atan(), step: ds });
        }
        Ok(())
    }

    /// Whether the corrections fall from a part to its halves. `fallen`: how often they have fallen before.
    fn is_smooth(&mut self, part: &Part<C::Solution>, fallen: u32, left: u32) -> Result<bool, CurveError> {
        if part.off < EXACT || fallen == IN_A_ROW {
            return Ok(true);
        }
        if left == 0 {
            return Ok(false);
        }
        for [start, end] in [[&part.ends[0], &part.middle], [&part.middle, &part.ends[1]]] {
            let half = self.part(start, end, self.distance(start, end))?;
            let fallen = if half.off < FALLS * part.off { fallen + 1 } else { 0 };
            if !self.is_smooth(&half, fallen, left - 1)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    fn part(
        &mut self,
        a: &CurvePoint<C::Solution>,
        b: &CurvePoint<C::Solution>,
        ds: f64,
    ) -> Result<Part<C::Solution>, CurveError> {
        let middle = self.point_at(&Between::new(a, b, ds), 0.5 * ds)?;
        let off = middle.corrections.first().copied().unwrap_or(0.0);
        Ok(Part { ends: [a.clone(), b.clone()], middle, off })
    }
}
