//! The table of the rows of a sweep, one row for each point.

use crate::error::check;
use crate::sweep::rows::hash::Hash;
use crate::sweep::rows::layout::Layout;
use crate::sweep::settings::points::Points;
use crate::sweep::settings::sweep::Sweep;
use crate::sweep::sweep_error::{PointError, SweepError};
use std::collections::BTreeMap;
use std::ops::Range;

/// Maximum number of values in the rows of one chunk: two gigabytes.
const MAX_ROW_VALUES: usize = 1 << 28;

/// The rows of a sweep or of a chunk of it. Each point has a row, an error, or neither if the sweep was
/// cancelled before it ran.
///
/// ```
/// use gear_dynamics::{sweep::{Axis, LaneRk4}, NfgPair, NfgParams, Sweep};
/// let speeds = Axis::of_values("speed", &[100.0, 120.0])?;
/// let rows = Sweep::new(speeds).settle(3).measure(1).channels(&["q0"]).of(
///     &LaneRk4::new(63 * 32),
///     |p| NfgPair::new(&NfgParams { speed: p["speed"], ..NfgParams::table1() }),
/// ).run()?;
/// let row = rows.get(1)?;
/// assert!((row.channel("q0")?.mean + 6.9e-4).abs() < 1e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// With the feature `serde` rows are stored together with the points and settings of their sweep, and
/// [`Runner::resume`](crate::sweep::Runner::resume) completes rows that were read. `serde_json` keeps every
/// bit with its feature `float_roundtrip`. Errors of points are stored as their text.
///
/// ```
/// # use gear_dynamics::{sweep::{Axis, LaneRk4, Rows}, NfgPair, NfgParams, Sweep};
/// # let speeds = Axis::of_values("speed", &[100.0, 120.0])?;
/// # let rows = Sweep::new(speeds).settle(3).measure(1).channels(&["q0"]).of(
/// #     &LaneRk4::new(63 * 32),
/// #     |p| NfgPair::new(&NfgParams { speed: p["speed"], ..NfgParams::table1() }),
/// # ).run()?;
/// let text = serde_json::to_string(&rows)?;
/// let read: Rows = serde_json::from_str(&text)?;
/// assert_eq!(read, rows);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Rows {
    /// Points and settings of the sweep, without budgets.
    pub(crate) sweep: Sweep,
    pub(crate) layout: Layout,
    /// Units of the channels; none if they are not known. They are no result: rows that differ in them are
    /// equal.
    pub(crate) units: Vec<String>,
    /// Indices of the points of this chunk.
    pub(crate) range: Range<usize>,
    /// The rows, one after the other; zeros for points without a row.
    pub(crate) data: Vec<f64>,
    /// Whether each point has a row.
    pub(crate) done: Vec<bool>,
    /// Errors of points without a row.
    pub(crate) errors: BTreeMap<usize, PointError>,
    /// Results of the checks, for checked points that have a row.
    pub(crate) checks: BTreeMap<usize, Result<Vec<f64>, PointError>>,
    /// The errors of Lyapunov exponents and of multipliers. The row of such a point lacks these figures.
    pub(crate) exponent_errors: BTreeMap<usize, PointError>,
    /// Number of points that ran alone, without other lanes.
    pub(crate) alone: usize,
}

/// The index of a checked point and its result.
type CheckedPoint<'r> = (&'r usize, &'r Result<Vec<f64>, PointError>);

/// Whether the bits are equal. Missing values are NaN, which `==` would never find equal.
fn same_bits(a: &[f64], b: &[f64]) -> bool {
    a.iter().map(|x| x.to_bits()).eq(b.iter().map(|x| x.to_bits()))
}

/// Rows are equal if all values, texts of errors, checks, points and settings are equal.
/// [`alone`](Rows::alone) is ignored.
impl PartialEq for Rows {
    fn eq(&self, other: &Rows) -> bool {
        let check = |(a, b): (CheckedPoint<'_>, CheckedPoint<'_>)| match (a.1, b.1) {
            (Ok(x), Ok(y)) => a.0 == b.0 && same_bits(x, y),
            (Err(x), Err(y)) => a.0 == b.0 && x.to_string() == y.to_string(),
            _ => false,
        };
        let texts = |errors: &BTreeMap<usize, PointError>| -> Vec<(usize, String)> {
            errors.iter().map(|(index, error)| (*index, error.to_string())).collect()
        };
        let checks =
            self.checks.len() == other.checks.len() && self.checks.iter().zip(&other.checks).all(check);
        let errors = texts(&self.errors) == texts(&other.errors)
            && texts(&self.exponent_errors) == texts(&other.exponent_errors);
        let figures = same_bits(&self.data, &other.data) && self.done == other.done;
        figures
            && errors
            && checks
            && self.range == other.range
            && self.layout == other.layout
            && self.sweep == other.sweep
    }
}

impl Rows {
    /// Rows without results.
    pub(crate) fn new(sweep: &Sweep, layout: &Layout, range: Range<usize>) -> Self {
        Rows {
            sweep: sweep.without_budget(),
            layout: layout.clone(),
            units: Vec::new(),
            data: vec![0.0; range.len() * layout.stride()],
            done: vec![false; range.len()],
            range,
            errors: BTreeMap::new(),
            checks: BTreeMap::new(),
            exponent_errors: BTreeMap::new(),
            alone: 0,
        }
    }

    /// Allocates rows of this layout if there are no rows yet. Returns `false` if there are rows of another
    /// layout.
    ///
    /// # Errors
    /// More than 2²⁸ values.
    pub(crate) fn shape(&mut self, layout: &Layout) -> Result<bool, SweepError> {
        if !self.done.contains(&true) {
            Rows::check_room(self.range.len(), layout.stride_checked())?;
            self.data = Vec::new(); // frees the old memory before the new memory is allocated
            self.data = vec![0.0; self.range.len() * layout.stride()];
            self.layout = layout.clone();
        }
        Ok(self.layout == *layout)
    }

    /// Checks the size of `rows` rows of `stride` values each; `stride` is `None` if it exceeds `usize::MAX`.
    ///
    /// # Errors
    /// More than 2²⁸ values.
    pub(crate) fn check_room(rows: usize, stride: Option<usize>) -> Result<(), SweepError> {
        check::count(
            "values in the rows (split the sweep into chunks)",
            &[rows, stride.unwrap_or(usize::MAX)],
            MAX_ROW_VALUES,
        )?;
        Ok(())
    }

    /// Stores the row or the error of a point.
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

    /// Stores the check of a point, if the point has a row.
    pub(crate) fn put_check(&mut self, index: usize, row: Result<Vec<f64>, PointError>) {
        if self.done[index - self.range.start] {
            self.checks.insert(index, row);
        }
    }

    /// Whether a point of this chunk has neither a row nor an error.
    pub(crate) fn is_open(&self, index: usize) -> bool {
        !self.done[index - self.range.start] && !self.errors.contains_key(&index)
    }

    /// Indices of the points of these rows in the sweep.
    pub fn range(&self) -> Range<usize> {
        self.range.clone()
    }

    /// The points of the whole sweep.
    pub fn points(&self) -> &Points {
        self.sweep.points()
    }

    /// Whether every point of these rows has a row or an error.
    pub fn is_complete(&self) -> bool {
        self.done.iter().filter(|done| **done).count() + self.errors.len() == self.done.len()
    }

    /// Number of points that [`LaneRk4`](crate::sweep::LaneRk4) ran alone, because no other run that was
    /// available had a model of equal shape. Such runs are slower.
    ///
    /// The number describes the execution, not the results: it depends on threads and chunks, is ignored by
    /// `==`, and is not stored.
    pub fn alone(&self) -> usize {
        self.alone
    }

    /// Errors of the [Lyapunov exponent](crate::sweep::Row::lyapunov) and of the
    /// [multipliers](crate::sweep::Row::multipliers), by the index of the point; that of the exponent if both
    /// failed. The rows contain all other results of these points.
    pub fn exponent_errors(&self) -> &BTreeMap<usize, PointError> {
        &self.exponent_errors
    }

    /// Errors of points without a row, by the index of the point.
    pub fn errors(&self) -> &BTreeMap<usize, PointError> {
        &self.errors
    }

    /// Hash for the comparison of runs. It depends on every bit of all rows and checks, and on the indices of
    /// failed and missing points.
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
