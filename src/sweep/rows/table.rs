//! What a sweep found: one row for each point.

use crate::error::check;
use crate::sweep::error::{PointError, SweepError};
use crate::sweep::rows::hash::Hash;
use crate::sweep::rows::layout::Layout;
use crate::sweep::settings::points::Points;
use crate::sweep::settings::sweep::Sweep;
use std::collections::BTreeMap;
use std::ops::Range;

/// Most figures in the rows of one chunk: two gigabytes.
const MOST_FIGURES: usize = 1 << 28;

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
/// let row = rows.get(1)?;
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

    /// Whether a point of this chunk has neither a row nor an error.
    pub(crate) fn is_open(&self, index: usize) -> bool {
        !self.done[index - self.range.start] && !self.errors.contains_key(&index)
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

    /// Why points have no [Lyapunov exponent](crate::sweep::Row::lyapunov), by point: their other figures are among the rows.
    pub fn exponent_errors(&self) -> &BTreeMap<usize, PointError> {
        &self.exponent_errors
    }

    /// The errors of points that have no row, by point.
    pub fn errors(&self) -> &BTreeMap<usize, PointError> {
        &self.errors
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
