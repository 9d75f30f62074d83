//! What a sweep found: one row for each point.

use crate::error::check;
use crate::sweep::error::{PointError, RowsError, SweepError};
use crate::sweep::rows::hash::Hash;
use crate::sweep::rows::row::Row;
use crate::sweep::schedule::sweep::Sweep;
use crate::sweep::settings::points::Points;
use std::collections::BTreeMap;
use std::ops::Range;

/// Most figures in the rows of one chunk: two gigabytes.
const MOST_FIGURES: usize = 1 << 28;

/// Where the figures of a row stand.
#[derive(Clone, Debug, Default, PartialEq)]
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
    /// Period multiple, change, periods settled, margin to grazing, scatter.
    pub(crate) const HEAD: usize = 5;
    /// Of a channel: mean, RMS, least and largest value, deviation from the mean.
    const FIGURES: usize = 5;
    pub(crate) fn channel(&self, i: usize) -> usize {
        Layout::HEAD + Layout::FIGURES * i
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
        let rest = self.channels.checked_mul(Layout::FIGURES)?.checked_add(self.contacts.checked_mul(5)?)?;
        strobes.checked_add(rest)?.checked_add(Layout::HEAD + self.exponents)
    }
    pub(crate) fn stride(&self) -> usize {
        self.strobe(self.strobes)
    }
}

/// The rows of a sweep, or of a chunk of it: figures, or the error of a point, or nothing where it was cancelled.
///
/// ```
/// use gear_dynamics::{sweep::{Axis, LaneRk4, Points}, NfgPair, NfgParams, Sweep};
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
#[derive(Clone, Debug)]
pub struct Rows {
    /// What tells the sweep from others: a hash of its points and settings.
    pub(crate) sweep: u64,
    pub(crate) points: Points,
    pub(crate) names: Vec<String>,
    pub(crate) layout: Layout,
    /// The points that these rows are of.
    pub(crate) range: Range<usize>,
    pub(crate) data: Vec<f64>,
    pub(crate) done: Vec<bool>,
    pub(crate) errors: BTreeMap<usize, PointError>,
    /// Rows made once more with a quarter of the step, of points that are done.
    pub(crate) checks: BTreeMap<usize, Result<Vec<f64>, PointError>>,
    /// Why points have no exponent whose other figures are there.
    pub(crate) exponent_errors: BTreeMap<usize, PointError>,
    pub(crate) alone: usize,
}

/// The number of a point that was checked, and its row.
type CheckedPoint<'r> = (&'r usize, &'r Result<Vec<f64>, PointError>);

/// Equal bits: a figure that is missing is not a number.
fn same_bits(a: &[f64], b: &[f64]) -> bool {
    a.iter().map(|x| x.to_bits()).eq(b.iter().map(|x| x.to_bits()))
}

/// Equal in every figure; how many points ran alone is of no account.
impl PartialEq for Rows {
    fn eq(&self, other: &Rows) -> bool {
        let check = |(a, b): (CheckedPoint<'_>, CheckedPoint<'_>)| match (a.1, b.1) {
            (Ok(x), Ok(y)) => a.0 == b.0 && same_bits(x, y),
            _ => a == b,
        };
        let checks =
            self.checks.len() == other.checks.len() && self.checks.iter().zip(&other.checks).all(check);
        let errors = self.errors == other.errors && self.exponent_errors == other.exponent_errors;
        let figures = same_bits(&self.data, &other.data) && self.done == other.done;
        figures
            && errors
            && checks
            && self.range == other.range
            && self.layout == other.layout
            && self.points == other.points
            && self.sweep == other.sweep
    }
}

impl Rows {
    /// Nothing yet.
    pub(crate) fn new(sweep: &Sweep, layout: &Layout, range: Range<usize>) -> Self {
        Rows {
            sweep: Hash::of(sweep),
            points: sweep.points().clone(),
            names: sweep.names().to_vec(),
            layout: layout.clone(),
            data: vec![0.0; range.len() * layout.stride()],
            done: vec![false; range.len()],
            range,
            errors: BTreeMap::new(),
            checks: BTreeMap::new(),
            exponent_errors: BTreeMap::new(),
            alone: 0,
        }
    }

    /// Makes room for rows of this shape. `false`: there are some of another.
    ///
    /// # Errors
    /// More figures than there is room for.
    pub(crate) fn shape(&mut self, layout: &Layout) -> Result<bool, SweepError> {
        if !self.done.contains(&true) {
            Rows::check_room(self.range.len(), layout.stride_checked())?;
            self.data = Vec::new(); // given back before more is asked for
            self.data = vec![0.0; self.range.len() * layout.stride()];
            self.layout = layout.clone();
        }
        Ok(self.layout == *layout)
    }

    /// Whether there is room for `rows` rows of `stride` figures.
    pub(crate) fn check_room(rows: usize, stride: Option<usize>) -> Result<(), SweepError> {
        check::count(
            "figures of the rows; chunks hold fewer",
            &[rows, stride.unwrap_or(usize::MAX)],
            MOST_FIGURES,
        )?;
        Ok(())
    }

    pub(crate) fn put(&mut self, index: usize, row: &Result<Vec<f64>, PointError>) {
        let place = index - self.range.start;
        match row {
            Ok(row) => {
                let stride = self.layout.stride();
                self.data[place * stride..][..stride].copy_from_slice(row);
                self.done[place] = true;
            }
            Err(error) => {
                self.errors.insert(index, error.clone());
            }
        }
    }

    /// Takes a check of a point, if there is something to be checked.
    pub(crate) fn put_check(&mut self, index: usize, row: Result<Vec<f64>, PointError>) {
        if self.done[index - self.range.start] {
            self.checks.insert(index, row);
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
    /// How many points ran alone in the lane engine, because no other model in reach shared lanes with theirs. A word about the run, not about
    /// its figures: it goes with threads and chunks, counts for nothing in `==`, and is not kept in bytes.
    pub fn alone(&self) -> usize {
        self.alone
    }
    /// Why points have no [Lyapunov exponent](Row::lyapunov), by point: their other figures are among the rows.
    pub fn exponent_errors(&self) -> &BTreeMap<usize, PointError> {
        &self.exponent_errors
    }
    /// The errors of points that have no row, by point.
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

    /// One column over all points, NaN where a point has no row: for pictures and for [Sobol indices](crate::sweep::SobolDesign).
    pub fn column(&self, of: impl Fn(&Row<'_>) -> f64) -> Vec<f64> {
        self.range
            .clone()
            .map(|index| self.row(index).and_then(Result::ok).map_or(f64::NAN, |row| of(&row)))
            .collect()
    }

    /// Puts the chunks of one sweep together, in any order: bit-equal to the whole. Points that a cancelled chunk did not reach stay open:
    /// [`is_complete`](Rows::is_complete) tells, and [`Sweep::resume`] runs them.
    ///
    /// # Errors
    /// [`SweepError::Parts`] when a chunk is missing, there twice, or of another sweep; the error holds the parts.
    pub fn merge(mut parts: Vec<Rows>) -> Result<Rows, RowsError> {
        // Empty chunks come before the one that starts where they do.
        parts.sort_by_key(|part| (part.range.start, part.range.end));
        if let Some(row) = Rows::misfit(&parts) {
            return Err(RowsError { error: SweepError::Parts { row }, rows: parts });
        }
        let rows: usize = parts.iter().map(|part| part.done.len()).sum();
        let mut whole = parts.remove(0);
        // Room once, for nothing more: parts are let go as they are taken over.
        whole.data.reserve_exact(rows.saturating_sub(whole.done.len()) * whole.layout.stride());
        for part in parts {
            whole.range.end = part.range.end;
            whole.data.extend(part.data);
            whole.done.extend(part.done);
            whole.errors.extend(part.errors);
            whole.checks.extend(part.checks);
            whole.exponent_errors.extend(part.exponent_errors);
            whole.alone += part.alone;
        }
        Ok(whole)
    }

    /// The first row at which sorted parts do not make a whole.
    fn misfit(parts: &[Rows]) -> Option<usize> {
        let (Some(first), Some(last)) = (parts.first(), parts.last()) else { return Some(0) };
        let fits = |pair: &&[Rows]| {
            pair[1].range.start == pair[0].range.end
                && pair[1].sweep == first.sweep
                && pair[1].layout == first.layout
        };
        if let Some(pair) = parts.windows(2).find(|pair| !fits(pair)) {
            return Some(pair[0].range.end);
        }
        if first.range.start > 0 {
            return Some(0);
        }
        Some(last.range.end).filter(|end| *end != first.points.len())
    }

    /// A number that changes with any bit of any row or check, with the points that failed and with those that are missing: for comparing runs.
    pub fn fingerprint(&self) -> u64 {
        let figures = self.data.iter().map(|x| x.to_bits());
        let without =
            self.range.clone().zip(&self.done).filter(|(_, done)| !**done).map(|(index, _)| index as u64);
        let check = |(index, row): (&usize, &Result<Vec<f64>, PointError>)| {
            let figures: Vec<u64> = row.iter().flatten().map(|x| x.to_bits()).collect();
            [*index as u64, u64::from(row.is_err())].into_iter().chain(figures)
        };
        let errors = self.errors.keys().chain(self.exponent_errors.keys()).map(|i| *i as u64);
        let words = figures.chain(errors).chain(without).chain(self.checks.iter().flat_map(check));
        Hash::of_words(words)
    }
}
