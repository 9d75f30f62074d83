//! What a sweep found: one row for each point.

use super::error::{PointError, SweepError};
use super::points::{Point, Points};
use crate::analysis::{ContactStatistics, RattleState, Summary};
use crate::error::ParameterError;
use std::collections::BTreeMap;
use std::ops::Range;

/// Where the figures of a row stand.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Layout {
    pub(crate) dof: usize,
    pub(crate) channels: usize,
    pub(crate) contacts: usize,
    /// Periods of which the strobed state and the extremes of the channels are kept.
    pub(crate) strobes: usize,
    /// The largest Lyapunov exponent and its standard error: 2 figures, or 0.
    pub(crate) exponents: usize,
}

impl Layout {
    /// Period multiple, change, periods settled, margin to grazing.
    pub(crate) const HEAD: usize = 4;
    pub(crate) fn channel(&self, i: usize) -> usize {
        Layout::HEAD + 4 * i
    }
    pub(crate) fn contact(&self, i: usize) -> usize {
        self.channel(self.channels) + 5 * i
    }
    /// Least and largest value of each channel, then the state.
    pub(crate) fn strobe_width(&self) -> usize {
        2 * self.channels + 2 * self.dof
    }
    pub(crate) fn exponent(&self) -> usize {
        self.contact(self.contacts)
    }
    pub(crate) fn strobe(&self, i: usize) -> usize {
        self.exponent() + self.exponents + self.strobe_width() * i
    }
    /// The stride, if it can be counted.
    pub(crate) fn stride_checked(&self) -> Option<usize> {
        let strobes = self.channels.checked_add(self.dof)?.checked_mul(2)?.checked_mul(self.strobes)?;
        let rest = self.channels.checked_mul(4)?.checked_add(self.contacts.checked_mul(5)?)?;
        strobes.checked_add(rest)?.checked_add(Layout::HEAD + self.exponents)
    }
    pub(crate) fn stride(&self) -> usize {
        self.strobe(self.strobes)
    }
}

/// The rows of a sweep, or of a chunk of it: figures, or the error of a point, or nothing where it was cancelled.
///
/// ```
/// use gear_dynamics::{Axis, NfgPair, NfgParams, Points, Sweep, LaneRk4};
/// let speeds = Points::along(Axis::list("speed", &[100.0, 120.0])?);
/// let rows = Sweep::over(speeds).settle(3).measure(1).channels(&["q1"]).run(
///     &LaneRk4::<16>::new(63 * 32),
///     |p| NfgPair::new(&NfgParams { speed: p["speed"], ..NfgParams::table1() }),
///     |_, pair| pair.static_start(),
/// )?;
/// let row = rows.row(1).ok_or("cancelled")?.map_err(Clone::clone)?;
/// assert!((row.channel("q1")?.mean + 6.9e-4).abs() < 1e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Rows {
    pub(crate) points: Points,
    pub(crate) names: Vec<String>,
    pub(crate) layout: Layout,
    /// The points that these rows are of.
    pub(crate) range: Range<usize>,
    pub(crate) data: Vec<f64>,
    pub(crate) done: Vec<bool>,
    pub(crate) errors: BTreeMap<usize, PointError>,
    /// Rows made once more with a quarter of the step.
    pub(crate) checks: BTreeMap<usize, Vec<f64>>,
    pub(crate) alone: usize,
}

impl Rows {
    pub(crate) fn new(points: &Points, names: &[String], layout: &Layout, range: Range<usize>) -> Self {
        Rows {
            points: points.clone(),
            names: names.to_vec(),
            layout: layout.clone(),
            data: vec![0.0; range.len() * layout.stride()],
            done: vec![false; range.len()],
            range,
            errors: BTreeMap::new(),
            checks: BTreeMap::new(),
            alone: 0,
        }
    }

    pub(crate) fn put(&mut self, index: usize, row: Result<Vec<f64>, PointError>) {
        let place = index - self.range.start;
        match row {
            Ok(row) => {
                let stride = self.layout.stride();
                self.data[place * stride..][..stride].copy_from_slice(&row);
                self.done[place] = true;
            }
            Err(error) => {
                self.errors.insert(index, error);
            }
        }
    }

    /// The points these rows are of, by their place in the sweep.
    pub fn range(&self) -> Range<usize> {
        self.range.clone()
    }
    /// The points of the whole sweep.
    pub fn points(&self) -> &Points {
        &self.points
    }
    /// Whether every point has its row or its error.
    pub fn is_complete(&self) -> bool {
        self.done.iter().filter(|done| **done).count() + self.errors.len() == self.done.len()
    }
    /// How many points ran alone, because no other model in reach shares lanes with theirs.
    pub fn alone(&self) -> usize {
        self.alone
    }
    /// The errors, by point.
    pub fn errors(&self) -> &BTreeMap<usize, PointError> {
        &self.errors
    }

    /// Point `index`: its row, its error, or `None` if it was not reached or is not of this chunk.
    pub fn row(&self, index: usize) -> Option<Result<Row<'_>, &PointError>> {
        if !self.range.contains(&index) {
            return None;
        }
        if let Some(error) = self.errors.get(&index) {
            return Some(Err(error));
        }
        let place = index - self.range.start;
        let stride = self.layout.stride();
        self.done[place].then(|| Ok(Row { rows: self, index, data: &self.data[place * stride..][..stride] }))
    }

    /// All rows that were reached, in order.
    pub fn iter(&self) -> impl Iterator<Item = Row<'_>> {
        self.range.clone().filter_map(|index| self.row(index)?.ok())
    }

    /// One column over all points, NaN where a point has no row: for pictures and for [Sobol indices](crate::SobolDesign).
    pub fn column(&self, of: impl Fn(&Row<'_>) -> f64) -> Vec<f64> {
        self.range.clone().map(|index| self.row(index).and_then(Result::ok).map_or(f64::NAN, |row| of(&row))).collect()
    }

    /// Puts the chunks of one sweep together: bit-equal to the whole.
    ///
    /// # Errors
    /// [`SweepError::Parts`] when rows are missing, there twice, or of different sweeps.
    pub fn merge(mut parts: Vec<Rows>) -> Result<Rows, SweepError> {
        parts.sort_by_key(|part| part.range.start);
        let mut parts = parts.into_iter();
        let mut whole = parts.next().ok_or(SweepError::Parts { row: 0 })?;
        for part in parts {
            let fits = part.range.start == whole.range.end && part.layout == whole.layout && part.points == whole.points;
            if !fits || part.names != whole.names {
                return Err(SweepError::Parts { row: whole.range.end });
            }
            whole.range.end = part.range.end;
            whole.data.extend(part.data);
            whole.done.extend(part.done);
            whole.errors.extend(part.errors);
            whole.checks.extend(part.checks);
            whole.alone += part.alone;
        }
        if whole.range != (0..whole.points.len()) {
            let row = if whole.range.start > 0 { 0 } else { whole.range.end };
            return Err(SweepError::Parts { row });
        }
        Ok(whole)
    }

    /// A number that changes with any bit of any row: for comparing runs.
    pub fn fingerprint(&self) -> u64 {
        // FNV-1a over the bits.
        let words = self.data.iter().map(|x| x.to_bits()).chain(self.errors.keys().map(|i| *i as u64));
        words.fold(0xcbf2_9ce4_8422_2325, |hash, word| (hash ^ word).wrapping_mul(0x0000_0100_0000_01b3).rotate_left(23))
    }
}

/// The figures of one point.
///
/// ```
/// use gear_dynamics::{Axis, LaneRk4, NfgPair, NfgParams, Points, RattleState, Sweep};
/// let rows = Sweep::over(Points::along(Axis::list("speed", &[180.0])?)).settle(4).measure(1).rattle().run(
///     &LaneRk4::<16>::new(63 * 32),
///     |p| NfgPair::new(&NfgParams { speed: p["speed"], ..NfgParams::table1() }),
///     |_, pair| pair.static_start(),
/// )?;
/// let row = rows.iter().next().ok_or("no row")?;
/// assert_eq!(row.contact(0).state(), RattleState::Bilateral);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Row<'r> {
    rows: &'r Rows,
    index: usize,
    data: &'r [f64],
}

/// Nearer to an edge than this share of the range of the penetration is a touch.
const GRAZING: f64 = 2e-3;

impl Row<'_> {
    /// Its place in the sweep.
    pub fn index(&self) -> usize {
        self.index
    }
    /// Its point.
    pub fn point(&self) -> Point<'_> {
        self.rows.points.point(self.index)
    }

    /// Mean, RMS and extremes of a channel over the measured periods.
    ///
    /// # Errors
    /// [`ParameterError::NoSuchChannel`] for one that was not asked for.
    pub fn channel(&self, name: &str) -> Result<Summary, ParameterError> {
        let known = || self.rows.names.join(", ");
        let place = self.rows.names.iter().position(|n| n == name);
        let i = place.ok_or_else(|| ParameterError::NoSuchChannel { name: name.into(), known: known() })?;
        let at = self.rows.layout.channel(i);
        Ok(Summary { mean: self.data[at], rms: self.data[at + 1], min: self.data[at + 2], max: self.data[at + 3] })
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
    pub fn state(&self, i: usize) -> RattleState {
        self.contact(i).state()
    }

    /// Periods after which the motion repeats, `None` when it does not: chaos, or not settled.
    pub fn period_multiple(&self) -> Option<usize> {
        Some(self.data[0] as usize).filter(|p| *p > 0)
    }
    /// The largest Lyapunov exponent per period, if [`lyapunov`](crate::Sweep::lyapunov) was asked for: positive in chaos, negative where
    /// small differences die out.
    pub fn lyapunov(&self) -> Option<f64> {
        self.exponents().first().copied()
    }
    /// Standard error of [`lyapunov`](Row::lyapunov), from the scatter of up to 16 batches of periods.
    pub fn lyapunov_error(&self) -> Option<f64> {
        self.exponents().get(1).copied()
    }
    fn exponents(&self) -> &[f64] {
        let layout = &self.rows.layout;
        &self.data[layout.exponent()..][..layout.exponents]
    }

    /// How far the last return was off, in units of the largest strobed coordinate and velocity: the convergence of the settling.
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
    /// Whether the answer hangs on small changes: no period, grazing, or another answer at a quarter of the step.
    pub fn is_sensitive(&self) -> bool {
        self.period_multiple().is_none() || self.grazes() || self.checked().is_some_and(|fine| self.differs(&fine))
    }

    /// The same point with a quarter of the step, if it is one of those checked.
    pub fn checked(&self) -> Option<Row<'_>> {
        self.rows.checks.get(&self.index).map(|data| Row { rows: self.rows, index: self.index, data })
    }

    fn differs(&self, fine: &Row<'_>) -> bool {
        let states = (0..self.rows.layout.contacts).any(|i| self.state(i) != fine.state(i));
        states || self.data[0] != fine.data[0]
    }

    /// How far the mean, the RMS or an extreme of a channel may be off by the step: the largest change at a quarter of the step, that of the extremes
    /// twice over, since the finer grid may miss a peak as well. Of the point itself if it was checked, otherwise the larger one
    /// of the nearest checked points before and after it; `None` if there are none.
    pub fn error(&self, channel: &str) -> Option<f64> {
        let i = self.rows.names.iter().position(|n| n == channel)?;
        let of = |(index, fine): (&usize, &Vec<f64>)| {
            let (stride, at) = (self.rows.layout.stride(), self.rows.layout.channel(i));
            let coarse = &self.rows.data[(index - self.rows.range.start) * stride..][..stride];
            (0..4).fold(0.0, |m: f64, k| m.max((coarse[at + k] - fine[at + k]).abs() * if k < 2 { 256.0 / 255.0 } else { 2.0 }))
        };
        let before = self.rows.checks.range(..=self.index).next_back();
        if let Some(own) = before.filter(|(index, _)| **index == self.index) {
            return Some(of(own));
        }
        let after = self.rows.checks.range(self.index..).next();
        before.into_iter().chain(after).map(of).reduce(f64::max)
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
        Ok((0..layout.strobes).map(|k| [self.data[layout.strobe(k) + 2 * i], self.data[layout.strobe(k) + 2 * i + 1]]).collect())
    }
}
