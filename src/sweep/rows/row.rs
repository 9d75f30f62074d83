//! The figures of one point of a sweep.

use crate::analysis::rattle::{ContactStatistics, RattleState};
use crate::analysis::statistics::Summary;
use crate::error::ParameterError;
use crate::sweep::error::PointError;
use crate::sweep::rows::table::Rows;
use crate::sweep::settings::points::Point;

/// The figures of one point.
///
/// ```
/// use gear_dynamics::{sweep::{Axis, LaneRk4, Points}, NfgPair, NfgParams, RattleState, Sweep};
/// let rows = Sweep::over(Points::along(Axis::list("speed", &[180.0])?)).settle(4).measure(1).rattle().run(
///     &LaneRk4::<16>::new(63 * 32),
///     |p| NfgPair::new(&NfgParams { speed: p["speed"], ..NfgParams::table1() }),
///     |_, pair| pair.static_start(),
/// )?;
/// let row = rows.iter().next().ok_or("no row")?;
/// assert_eq!(row.contact(0).rattle_state(), RattleState::Bilateral);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Row<'r> {
    pub(crate) rows: &'r Rows,
    pub(crate) index: usize,
    pub(crate) data: &'r [f64],
}

/// Nearer to an edge than this share of the range of the penetration is a touch.
const GRAZING: f64 = 2e-3;

/// A peak-to-peak value that changes by more than this share of itself, or lost contact by more than this share of the time, is another answer.
const ANOTHER: f64 = 0.05;

impl Row<'_> {
    /// Its place in the sweep.
    pub fn index(&self) -> usize {
        self.index
    }
    /// Its point.
    pub fn point(&self) -> Point<'_> {
        self.rows.points.point(self.index)
    }

    /// Mean, RMS, extremes and deviation of a channel over the measured periods.
    ///
    /// # Errors
    /// [`ParameterError::NoSuchChannel`] for one that was not asked for.
    pub fn channel(&self, name: &str) -> Result<Summary, ParameterError> {
        let known = || self.rows.names.join(", ");
        let place = self.rows.names.iter().position(|n| n == name);
        let i = place.ok_or_else(|| ParameterError::NoSuchChannel { name: name.into(), known: known() })?;
        let at = self.rows.layout.channel(i);
        let [mean, rms, min, max, deviation] = std::array::from_fn(|k| self.data[at + k]);
        Ok(Summary { mean, rms, min, max, deviation })
    }

    /// Rattle of contact `i`: shares of the time, and impacts over all measured periods.
    ///
    /// # Panics
    /// If there is no such contact or [`rattle`](crate::Sweep::rattle) was not asked for.
    pub fn contact(&self, i: usize) -> ContactStatistics {
        assert!(i < self.rows.layout.contacts, "contact {i} of {}", self.rows.layout.contacts);
        let at = self.rows.layout.contact(i);
        let x = &self.data[at..at + 5];
        ContactStatistics { time: [x[0], x[1], x[2]], impacts: [x[3] as u64, x[4] as u64] }
    }

    /// Rattle state of contact `i`.
    ///
    /// # Panics
    /// As [`contact`](Row::contact).
    pub fn rattle_state(&self, i: usize) -> RattleState {
        self.contact(i).rattle_state()
    }

    /// Periods after which the motion repeats, `None` when it does not: chaos, or not settled.
    pub fn period_multiple(&self) -> Option<usize> {
        Some(self.data[0] as usize).filter(|p| *p > 0)
    }
    /// The largest Lyapunov exponent per period, if [`lyapunov`](crate::Sweep::lyapunov) was asked for: positive in chaos, negative where
    /// small differences die out. `None` if it could not be computed: [`lyapunov_failure`](Row::lyapunov_failure) tells why.
    pub fn lyapunov(&self) -> Option<f64> {
        self.exponents().first().copied().filter(|x| !x.is_nan())
    }
    /// Why there is no exponent, although it was asked for.
    pub fn lyapunov_failure(&self) -> Option<&PointError> {
        self.rows.exponent_errors.get(&self.index).filter(|_| self.lyapunov().is_none())
    }
    /// Standard error of [`lyapunov`](Row::lyapunov), as in [`Exponents::standard_error`](crate::periodic::Exponents::standard_error).
    pub fn lyapunov_error(&self) -> Option<f64> {
        self.exponents().get(1).copied().filter(|x| !x.is_nan())
    }
    fn exponents(&self) -> &[f64] {
        let layout = &self.rows.layout;
        &self.data[layout.exponent()..][..layout.exponents]
    }

    /// How far the last return was off, as a share of the range of each coordinate and velocity over the last period: the convergence of the
    /// settling.
    pub fn change(&self) -> f64 {
        self.data[1]
    }
    /// Periods run before measuring.
    pub fn settled_after(&self) -> usize {
        self.data[2] as usize
    }
    /// Whether the teeth only just touch or only just part somewhere: a small change may turn the rattle state.
    pub fn grazes(&self) -> bool {
        self.data[3] < GRAZING
    }
    /// By how much what is read of the measured periods one by one differs, at the most: the peak-to-peak of a channel as a share of itself, lost
    /// contact as a share of the time. Infinite if only one period was measured, or neither channels nor [`rattle`](crate::Sweep::rattle).
    pub fn scatter(&self) -> f64 {
        self.data[4]
    }
    /// Whether the rattle state, the peak-to-peak values or the share of lost contact hang on small changes: a motion without period whose
    /// [`scatter`](Row::scatter) is above 5 % (chaos, or not settled), a [grazing](Row::grazes) one, one with a Lyapunov exponent above zero, or
    /// another rattle state, a peak-to-peak that is 5 % off or none at all with a quarter of the step, if the point was
    /// [checked](Row::checked).
    ///
    /// Fixed steps alone keep some motions from repeating whose figures are firm: those are not flagged.
    pub fn is_sensitive(&self) -> bool {
        let chaotic = self.period_multiple().is_none() && self.scatter() > ANOTHER;
        let grows = matches!(self.exponents(), [exponent, error] if *exponent > 2.0 * error);
        let another = self.checked().is_some_and(|check| check.map_or(true, |fine| self.differs(&fine)));
        chaotic || grows || another || self.grazes()
    }

    /// The same point with a quarter of the step, if it is one of those checked: its row, or why there is none.
    pub fn checked(&self) -> Option<Result<Row<'_>, &PointError>> {
        let row = |data| Row { rows: self.rows, index: self.index, data };
        self.rows.checks.get(&self.index).map(|check| check.as_ref().map(|data| row(data.as_slice())))
    }

    fn differs(&self, fine: &Row<'_>) -> bool {
        let layout = &self.rows.layout;
        let range =
            |row: &Row<'_>, i: usize| row.data[layout.channel(i) + 3] - row.data[layout.channel(i) + 2];
        let off = |i: usize| (range(self, i) - range(fine, i)).abs() > ANOTHER * range(fine, i);
        (0..layout.contacts).any(|i| self.rattle_state(i) != fine.rattle_state(i))
            || (0..layout.channels).any(off)
    }

    /// How far the mean, the RMS or an extreme of a channel may be off by the step: the largest change at a quarter of the step, that of the extremes
    /// twice over, since the finer grid may miss a peak as well. Of the point itself if it was checked, otherwise the larger one
    /// of the nearest checked points before and after it; `None` if there are none, or if the check of the point itself failed.
    pub fn error(&self, channel: &str) -> Option<f64> {
        let i = self.rows.names.iter().position(|n| n == channel)?;
        let of = |index: usize| {
            let fine = self.rows.checks.get(&index)?.as_ref().ok()?;
            let (coarse, at) = (self.rows.done_row(index)?.data, self.rows.layout.channel(i));
            Some((0..4).fold(0.0, |m: f64, k| {
                m.max((coarse[at + k] - fine[at + k]).abs() * if k < 2 { 256.0 / 255.0 } else { 2.0 })
            }))
        };
        let checks = &self.rows.checks;
        if checks.contains_key(&self.index) {
            return of(self.index);
        }
        let before = checks.range(..self.index).rev().find_map(|(index, _)| of(*index));
        let after = checks.range(self.index..).find_map(|(index, _)| of(*index));
        before.into_iter().chain(after).reduce(f64::max)
    }

    /// Strobed states, a period apart, the last ones of the run: `strobe(k)` of them were asked for.
    pub fn strobes(&self) -> impl Iterator<Item = &[f64]> {
        let layout = &self.rows.layout;
        (0..layout.strobes).map(|i| &self.data[layout.strobe(i) + 2 * layout.channels..layout.strobe(i + 1)])
    }

    /// Least and largest value of channel `name` in each of the periods that [`strobes`](Row::strobes) ends.
    ///
    /// # Errors
    /// [`ParameterError::NoSuchChannel`].
    pub fn extremes(&self, name: &str) -> Result<Vec<[f64; 2]>, ParameterError> {
        self.channel(name)?;
        let i = self.rows.names.iter().position(|n| n == name).unwrap_or(0);
        let layout = &self.rows.layout;
        Ok((0..layout.strobes)
            .map(|k| [self.data[layout.strobe(k) + 2 * i], self.data[layout.strobe(k) + 2 * i + 1]])
            .collect())
    }
}

impl Rows {
    /// The row of point `index`.
    ///
    /// # Errors
    /// The error of the point; [`PointError::NotReached`] if it was not run yet or is not of this chunk.
    pub fn get(&self, index: usize) -> Result<Row<'_>, PointError> {
        if let Some(error) = self.errors.get(&index) {
            return Err(error.clone());
        }
        self.done_row(index).ok_or(PointError::NotReached { index })
    }

    fn done_row(&self, index: usize) -> Option<Row<'_>> {
        let place = index.checked_sub(self.range.start)?;
        let stride = self.layout.stride();
        let done = *self.done.get(place)?;
        done.then(|| Row { rows: self, index, data: &self.data[place * stride..][..stride] })
    }

    /// All rows that were reached, in order.
    pub fn iter(&self) -> impl Iterator<Item = Row<'_>> {
        self.range.clone().filter_map(|index| self.done_row(index))
    }

    /// One column over all points, NaN where a point has no row: for pictures and for [Sobol indices](crate::sweep::SobolDesign).
    pub fn column(&self, of: impl Fn(&Row<'_>) -> f64) -> Vec<f64> {
        self.range.clone().map(|index| self.done_row(index).map_or(f64::NAN, |row| of(&row))).collect()
    }
}
