//! The stretches beside located bifurcations of a step.

use crate::branches::curve::equations::CurveError;
use crate::branches::orbits::orbit_method::OrbitMethod;
use crate::branches::points::change::Change;
use crate::branches::steps::place::{Place, value};
use crate::branches::steps::within::{ASIDE, MAX_DIVISIONS, Within, Zero, is_near_circle};
use crate::numeric::search::parabola::may_dip;

impl<C: OrbitMethod> Within<'_, '_, C> {
    /// Searches the stretches between the points that are located at the distances `at`, and the narrow ones
    /// around these points for what the located points are not.
    pub(super) fn search_beside(
        &mut self,
        mut at: Vec<f64>,
        a: &Place<C::Solution>,
        b: &Place<C::Solution>,
        left: usize,
    ) -> Result<(), CurveError> {
        at.sort_by(f64::total_cmp);
        let aside = ASIDE * self.between.length();
        let mut from = None;
        for sigma in at {
            let start = from.as_ref().unwrap_or(a);
            let mut before = None;
            if sigma - start.sigma > 2.0 * aside {
                let place = self.at(sigma - aside)?;
                self.search_stretch(start, &place, left - 1)?;
                before = Some(place);
            }
            if b.sigma - sigma < 2.0 * aside {
                return Ok(());
            }
            let after = self.at(sigma + aside)?;
            if let Some(before) = before {
                self.search_passed(&before, &after)?;
            }
            from = Some(after);
        }
        match from {
            Some(from) => self.search_stretch(&from, b, left - 1),
            None => Ok(()),
        }
    }

    /// Searches on both sides of a crossing at which the branch turns back for multipliers that pass -1, or
    /// the unit circle as a pair. `at`: the distances of the points that are located. Tests of folds and of
    /// crossings are rounding errors there.
    pub(super) fn search_beside_turn(
        &mut self,
        at: &[f64],
        a: &Place<C::Solution>,
        b: &Place<C::Solution>,
    ) -> Result<(), CurveError> {
        let aside = ASIDE * self.between.length();
        let first = at.iter().copied().fold(b.sigma, f64::min) - aside;
        let last = at.iter().copied().fold(a.sigma, f64::max) + aside;
        if first - a.sigma > aside {
            let before = self.at(first)?;
            self.search_passed(a, &before)?;
        }
        if b.sigma - last > aside {
            let after = self.at(last)?;
            self.search_passed(&after, b)?;
        }
        Ok(())
    }

    /// Locates a doubling and a Neimark-Sacker point where their tests change sign between two places. A kind
    /// with a known point between the places is left out.
    fn search_passed(&mut self, a: &Place<C::Solution>, b: &Place<C::Solution>) -> Result<(), CurveError> {
        for change in [Change::NeimarkSacker, Change::PeriodDoubling] {
            let is_known = |(sigma, _, found): &(f64, _, Change)| {
                *found == change && (a.sigma..=b.sigma).contains(sigma)
            };
            if self.found.iter().any(is_known) {
                continue;
            }
            let ends = [a, b].map(|place| value(change, place).map(|value| [place.sigma, value]));
            if let [Some([_, from]), Some([_, to])] = ends
                && from * to < 0.0
                && let Zero::Nothing = self.locate(change, ends)?
            {
                self.unexplained.push(change.unlocated());
            }
        }
        Ok(())
    }

    /// Searches a stretch for bifurcations by the signs of the tests at its ends. If these signs show none
    /// and multipliers at both ends lie near the unit circle, the middle is searched, too.
    fn search_stretch(
        &mut self,
        a: &Place<C::Solution>,
        b: &Place<C::Solution>,
        left: usize,
    ) -> Result<(), CurveError> {
        let found = self.found.len();
        self.separate(a, b, left)?;
        let is_near = is_near_circle(a) && is_near_circle(b);
        if is_near && self.found.len() == found { self.search_middle(a, b) } else { Ok(()) }
    }

    /// Computes the orbit in the middle of a stretch whose ends show no bifurcation. A test with another sign
    /// there shows two bifurcations: multipliers leave the unit circle and come back.
    pub(crate) fn search_middle(
        &mut self,
        a: &Place<C::Solution>,
        b: &Place<C::Solution>,
    ) -> Result<(), CurveError> {
        let middle = self.at(0.5 * (a.sigma + b.sigma))?;
        for change in [Change::NeimarkSacker, Change::PeriodDoubling] {
            let [Some(from), Some(inside), Some(to)] = [a, &middle, b].map(|place| value(change, place))
            else {
                continue;
            };
            if from * to > 0.0 && from * inside < 0.0 {
                self.separate(a, &middle, MAX_DIVISIONS)?;
                return self.separate(&middle, b, MAX_DIVISIONS);
            }
            for (values, [start, end]) in
                [([to, inside, from], [a, &middle]), ([from, inside, to], [&middle, b])]
            {
                if may_dip(values, [1.0; 2]) {
                    self.search_dip(change, None, start, end)?;
                }
            }
        }
        Ok(())
    }
}
