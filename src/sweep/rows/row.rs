//! A row: the results of one point of a sweep.

use crate::analysis::{ContactStatistics, Summary};
use crate::error::{ParameterError, check};
use crate::periodic::multipliers::Multipliers;
use crate::sweep::rows::collection::Rows;
use crate::sweep::rows::layout::Layout;
use crate::sweep::settings::points::Point;
use crate::sweep::sweep_error::PointError;
use num_complex::Complex64;

/// The results of one point of a sweep.
///
/// ```
/// use gear_dynamics::{sweep::{Axis, LaneRk4}, NfgPair, NfgParams, RattleState, Sweep};
/// let rows = Sweep::new(Axis::of_values("speed", &[180.0])?).settle(4).measure(1).rattle().of(
///     &LaneRk4::new(63 * 32),
///     |p| NfgPair::new(&NfgParams { speed: p["speed"], ..NfgParams::table1() }),
/// ).run()?;
/// let row = rows.iter().next().ok_or("no row")?;
/// assert_eq!(row.contacts()[0].rattle_state(), RattleState::Bilateral);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Row<'r> {
    pub(crate) rows: &'r Rows,
    pub(crate) index: usize,
    pub(crate) data: &'r [f64],
}

/// Margin to grazing below which a contact grazes, as a share of the range of the penetration `[1]`.
const GRAZING: f64 = 2e-3;

/// Maximum insignificant difference `[1]`: of a peak-to-peak value as a share of itself, of a contact loss as
/// a share of the time.
const ANOTHER: f64 = 0.05;

impl Row<'_> {
    /// Index of the point in the sweep, counted from 0.
    pub fn index(&self) -> usize {
        self.index
    }
    /// The point.
    pub fn point(&self) -> Point<'_> {
        self.rows.points().point(self.index)
    }

    /// Mean, RMS, extremes and deviation of a channel over the measured periods.
    ///
    /// # Errors
    /// [`ParameterError::NoSuchChannel`] for a channel that [`channels`](crate::Sweep::channels) did not
    /// request.
    pub fn channel(&self, name: &str) -> Result<Summary, ParameterError> {
        let i = check::channel_index(self.rows.sweep.names(), name)?;
        Ok(self.summary(i))
    }
    fn summary(&self, channel: usize) -> Summary {
        let place = self.rows.layout.channel(channel);
        let &[mean, rms, min, max, deviation] = Layout::group(self.data, place);
        Summary { mean, rms, min, max, deviation }
    }

    /// Statistics of each contact: contact times as shares of the measured time `[1]`, and numbers of
    /// impacts in all measured periods. Empty without [`rattle`](crate::Sweep::rattle).
    pub fn contacts(&self) -> Vec<ContactStatistics> {
        let of = |i: usize| {
            let &[lower, gap, upper, impacts @ ..] = Layout::group(self.data, self.rows.layout.contact(i));
            ContactStatistics { time: [lower, gap, upper], impacts: impacts.map(|count| count as u64) }
        };
        (0..self.rows.layout.contacts).map(of).collect()
    }

    /// Period multiple, change, settling periods, margin to grazing, scatter.
    fn head(&self) -> &[f64; Layout::GROUP] {
        Layout::group(self.data, Layout::HEAD)
    }

    /// Period multiple p of the motion; `None` if the motion does not repeat within the tolerance: chaos, not
    /// settled, p above 16, or a run of fewer than 2 p periods.
    pub fn period_multiple(&self) -> Option<usize> {
        let [multiple, ..] = self.head();
        Some(*multiple as usize).filter(|p| *p > 0)
    }
    /// The largest Lyapunov exponent per period. It is positive in chaos and negative if small differences
    /// decay. `None` without [`lyapunov`](crate::Sweep::lyapunov), or if it could not be computed;
    /// [`Rows::exponent_errors`] has the error.
    pub fn lyapunov(&self) -> Option<f64> {
        self.exponents().first().copied().filter(|x| !x.is_nan())
    }
    /// Standard error of [`lyapunov`](Row::lyapunov) per period, as in
    /// [`Exponents::standard_error`](crate::periodic::Exponents::standard_error).
    pub fn lyapunov_standard_error(&self) -> Option<f64> {
        self.exponents().get(1).copied().filter(|x| !x.is_nan())
    }
    /// The Floquet multipliers of the orbit near the last state of the run, with their error as in
    /// [`ShootingOrbit::multipliers`](crate::periodic::ShootingOrbit::multipliers). `None` without
    /// [`multipliers`](crate::Sweep::multipliers), for a motion that does not repeat, or if no orbit was
    /// found; [`Rows::exponent_errors`] has the error.
    pub fn multipliers(&self) -> Option<Multipliers> {
        let layout = &self.rows.layout;
        let (error, parts) = self.data[layout.multiplier()..][..layout.multipliers].split_last()?;
        let parts = parts.as_chunks().0.iter().filter(|[re, _]| !re.is_nan());
        let values = parts.map(|&[re, im]| Complex64::new(re, im)).collect();
        (!error.is_nan()).then(|| Multipliers::new(values, *error))
    }
    /// The exponent and its standard error; empty if not requested.
    fn exponents(&self) -> &[f64] {
        let layout = &self.rows.layout;
        &self.data[layout.exponent()..][..layout.exponents]
    }

    /// Distance of the last strobed state from the one a period multiple earlier: the convergence of
    /// settling. It is the maximum over the coordinates and velocities, each as a share of its range over the
    /// last period `[1]`.
    ///
    /// If the motion does not repeat, it is the minimum of the distances after 1 to 16 periods; infinite
    /// for a run of one period.
    pub fn change(&self) -> f64 {
        let [_, change, ..] = self.head();
        *change
    }
    /// Number of settling periods of the run.
    pub fn settled_after(&self) -> usize {
        let [_, _, settled, ..] = self.head();
        *settled as usize
    }
    /// Whether a contact grazes: its teeth barely touch or barely separate, so that a small change may alter
    /// the rattle state.
    ///
    /// The test uses three penetrations: the maximum on each flank, and the minimum of the larger of both. A
    /// contact grazes if the magnitude of one of them is less than 0.2 % of the range of the penetration.
    /// Always `false` without [`rattle`](crate::Sweep::rattle) and with the engines
    /// [`Located`](crate::sweep::Located) and [`LaneTaylor`](crate::sweep::LaneTaylor), which do not measure
    /// penetrations.
    pub fn grazes(&self) -> bool {
        let [_, _, _, margin, _] = self.head();
        *margin < GRAZING
    }
    /// Maximum difference `[1]` between the measured periods: of the peak-to-peak value of a channel as a
    /// share of itself, of a contact loss as a share of the time. Infinite with one measured period, or
    /// without channels and [`rattle`](crate::Sweep::rattle).
    pub fn scatter(&self) -> f64 {
        let [.., scatter] = self.head();
        *scatter
    }
    /// Whether rattle state, peak-to-peak values or contact loss depend on small changes. This is the case if
    ///
    /// - the motion does not repeat and its [`scatter`](Row::scatter) is above 5 % (chaos, or not settled);
    /// - a contact [grazes](Row::grazes);
    /// - the Lyapunov exponent is more than two standard errors above zero; or
    /// - the point was [checked](Row::checked), and its check has another rattle state, a peak-to-peak value
    ///   that differs by more than 5 %, or an error.
    ///
    /// A fixed step alone may prevent a motion from repeating although its results are accurate. Such a
    /// motion has a small scatter and does not count as sensitive.
    pub fn is_sensitive(&self) -> bool {
        let chaotic = self.period_multiple().is_none() && self.scatter() > ANOTHER;
        let grows = matches!(self.exponents(), [exponent, error] if *exponent > 2.0 * error);
        let another = self.checked().is_some_and(|check| check.map_or(true, |fine| self.differs(&fine)));
        chaotic || grows || another || self.grazes()
    }

    /// The result of the [check](crate::Sweep::check_every) of this point: its row or its error. `None` if
    /// the point was not checked.
    pub fn checked(&self) -> Option<Result<Row<'_>, &PointError>> {
        let row = |data| Row { rows: self.rows, index: self.index, data };
        self.rows.checks.get(&self.index).map(|check| check.as_ref().map(|data| row(data.as_slice())))
    }

    /// Whether a rattle state differs from that of `fine`, or a peak-to-peak value by more than [`ANOTHER`].
    fn differs(&self, fine: &Row<'_>) -> bool {
        let off = |i: usize| {
            let [own, fine] = [self, fine].map(|row| row.summary(i).peak_to_peak());
            (own - fine).abs() > ANOTHER * fine
        };
        let states = |row: &Row<'_>| row.contacts().iter().map(|c| c.rattle_state()).collect::<Vec<_>>();
        states(self) != states(fine) || (0..self.rows.layout.channels).any(off)
    }

    /// Estimated error of mean, RMS and extremes of a channel due to the step, in the unit of the channel.
    ///
    /// It is the maximum of 256/255 |x' - x| for mean and RMS (Richardson extrapolation at order 4) and of 2
    /// |x' - x| for minimum and maximum. Here x' is the value of the check. The factor 2 accounts
    /// for peaks that the finer steps miss as well.
    ///
    /// For a point that was not checked it is the larger estimate of the nearest checked points before and
    /// after it. `None` without checked points, for a channel that was not requested, or if the check of the
    /// point itself failed.
    pub fn step_error(&self, channel: &str) -> Option<f64> {
        let i = self.rows.sweep.names().iter().position(|n| n == channel)?;
        let of = |index: usize| {
            let fine = self.rows.checks.get(&index)?.as_ref().ok()?;
            let place = self.rows.layout.channel(i);
            let [coarse, fine] = [self.rows.done_row(index)?.data, fine].map(|row| Layout::group(row, place));
            // Mean, RMS, minimum, maximum.
            let factors = [256.0 / 255.0, 256.0 / 255.0, 2.0, 2.0];
            let errors = coarse.iter().zip(fine).zip(factors).map(|((x, y), factor)| (x - y).abs() * factor);
            Some(errors.fold(0.0, f64::max))
        };
        let checks = &self.rows.checks;
        if checks.contains_key(&self.index) {
            return of(self.index);
        }
        let before = checks.range(..self.index).rev().find_map(|(index, _)| of(*index));
        let after = checks.range(self.index..).find_map(|(index, _)| of(*index));
        before.into_iter().chain(after).reduce(f64::max)
    }

    /// The last strobed states of the run (coordinates, then velocities), one per period, the newest last.
    /// Their number is that of [`strobe`](crate::Sweep::strobe), at most the number of measured periods.
    pub fn strobes(&self) -> impl Iterator<Item = &[f64]> {
        let layout = &self.rows.layout;
        (0..layout.strobes).map(|i| &self.data[layout.strobe(i) + 2 * layout.channels..layout.strobe(i + 1)])
    }

    /// Minimum and maximum of channel `name` in each period that ends with one of the
    /// [`strobes`](Row::strobes).
    ///
    /// # Errors
    /// [`ParameterError::NoSuchChannel`].
    pub fn extremes(&self, name: &str) -> Result<Vec<[f64; 2]>, ParameterError> {
        let i = check::channel_index(self.rows.sweep.names(), name)?;
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
    /// The error of the point; [`PointError::NotReached`] if it was not run yet or belongs to another chunk.
    pub fn get(&self, index: usize) -> Result<Row<'_>, PointError> {
        if let Some(error) = self.errors.get(&index) {
            return Err(error.clone());
        }
        self.done_row(index).ok_or(PointError::NotReached { index })
    }

    /// The row of point `index`; `None` if there is none.
    fn done_row(&self, index: usize) -> Option<Row<'_>> {
        let place = index.checked_sub(self.range.start)?;
        let stride = self.layout.stride();
        let done = *self.done.get(place)? && !self.errors.contains_key(&index);
        done.then(|| Row { rows: self, index, data: &self.data[place * stride..][..stride] })
    }

    /// All rows, in the order of their points.
    pub fn iter(&self) -> impl Iterator<Item = Row<'_>> {
        self.range.clone().filter_map(|index| self.done_row(index))
    }

    /// One value per point, NaN for a point without a row. Use: plots and [Sobol
    /// indices](crate::sweep::SobolDesign).
    pub fn column(&self, of: impl Fn(&Row<'_>) -> f64) -> Vec<f64> {
        self.range.clone().map(|index| self.done_row(index).map_or(f64::NAN, |row| of(&row))).collect()
    }
}
