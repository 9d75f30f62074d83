//! The drive table: drives over one period, computed once for all runs.

use crate::excitation::Side;
use crate::model::Periodic;
use crate::model::shapes::compiled::Code;
use std::f64::consts::TAU;
use thiserror::Error;

/// Errors of a drive table.
///
/// ```
/// let error = gear_dynamics::sweep::TableError::Size { steps: 0, drives: 3 };
/// let text = "a drive table of 0 steps per period and 3 drives is not available: steps must be at least 1, \
///             2 × steps × drives at most 67108864";
/// assert_eq!(error.to_string(), text);
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum TableError {
    /// No steps, or so many that the table exceeds its maximum size of 2²⁶ numbers.
    #[error(
        "a drive table of {steps} steps per period and {drives} drives is not available: steps must be at \
         least 1, 2 × steps × drives at most {MAX_VALUES}"
    )]
    Size {
        /// Steps per period.
        steps: usize,
        /// Number of drives in the table.
        drives: usize,
    },
    /// A drive edge that is not on a whole step.
    #[error(
        "a drive jumps at the fraction {edge:?} of the period, at step {at:?} of {steps}: it must jump at a \
         whole step; change the number of steps or use the engine Located"
    )]
    EdgeOffGrid {
        /// Instant of the edge, as a share of the period `[1]`.
        edge: f64,
        /// The same instant, in steps.
        at: f64,
        /// Steps per period.
        steps: usize,
    },
    /// A drive that is infinite or NaN.
    #[error("drive {drive} is {value:?} at the fraction {phase:?} of the period: it must be finite")]
    NotFinite {
        /// Index of the drive.
        drive: usize,
        /// Its value.
        value: f64,
        /// Instant, as a share of the period `[1]`.
        phase: f64,
    },
}

/// Maximum distance of a drive edge from a whole step, in steps. The drives before and after the edge are
/// evaluated at this distance from it.
const ON_GRID: f64 = 1e-6;

/// Maximum number of values in a table: half a gigabyte.
const MAX_VALUES: usize = 1 << 26;

/// Number of rows between two checks for cancellation.
const ROWS_UNCHECKED: usize = 64;

/// The drives at the start, the middle and the end of every step of one period.
///
/// Row 2i is the start of step i, row 2i + 1 its middle. The end of step i is the start of the next step; the
/// last step ends with row 0. If a drive jumps there, an additional row contains the drives before the jump.
#[derive(Debug)]
pub(crate) struct DriveTable {
    /// All columns at the start of the period.
    start: Vec<f64>,
    /// The columns in the rows: all if the table has at most [`WHOLE`] columns, else those that vary over the
    /// period. The other columns are written to the drives once, at the start of a run.
    varying: Vec<usize>,
    /// The rows, one after the other.
    values: Vec<f64>,
    /// Index of the row at the end of each step.
    ends: Vec<u32>,
}

/// Maximum number of columns for which the rows contain all columns.
pub(crate) const WHOLE: usize = 16;

/// Whether the acceleration at time 0 is finite for q = 0 and q' = 0.
fn finite_at_rest<M: Periodic + ?Sized>(model: &M) -> bool {
    let (mut u, rest) = (vec![0.0; model.drives()], vec![0.0; model.dof()]);
    let mut a = rest.clone();
    model.drive(0.0, Side::After, &mut u);
    model.accel(&u, &rest, &rest, &mut a);
    a.iter().all(|a| a.is_finite())
}

impl DriveTable {
    /// Checks the size of a table.
    ///
    /// # Errors
    /// [`TableError::Size`].
    pub(crate) fn check_size(steps: usize, drives: usize) -> Result<(), TableError> {
        let numbers = steps.checked_mul(2).and_then(|rows| rows.checked_mul(drives.max(1)));
        if steps > 0 && numbers.is_some_and(|numbers| numbers <= MAX_VALUES) {
            Ok(())
        } else {
            Err(TableError::Size { steps, drives })
        }
    }

    /// Table of the waves of a shape, for all runs that share lanes. `None` if `go_on` returns `false`.
    pub(crate) fn of_waves(
        model: &dyn Code,
        steps: usize,
        go_on: &dyn Fn() -> bool,
    ) -> Result<Option<Self>, TableError> {
        let turn = TAU / f64::from(model.repeats_in_turn());
        let next = |share: f64| model.edge_after(turn * share).map(|edge| edge / turn);
        DriveTable::new(model, model.size().waves, steps, go_on, next, |share, side, out: &mut [f64]| {
            model.waves_at(turn * share, side, out)
        })
    }

    /// Table of all drives of one model. `None` if `go_on` returns `false`.
    pub(crate) fn of_drives(
        model: &dyn Periodic,
        steps: usize,
        go_on: &dyn Fn() -> bool,
    ) -> Result<Option<Self>, TableError> {
        let period = model.period();
        let next = |share: f64| model.next_edge(share * period).map(|edge| edge / period);
        DriveTable::new(model, model.drives(), steps, go_on, next, |share, side, out: &mut [f64]| {
            model.drive(share * period, side, out)
        })
    }

    /// Table with these columns. `next_edge` and `read` use the time as a share of the period `[1]`.
    fn new<M: Periodic + ?Sized>(
        model: &M,
        columns: usize,
        steps: usize,
        go_on: impl Fn() -> bool,
        next_edge: impl Fn(f64) -> Option<f64>,
        mut read: impl FnMut(f64, Side, &mut [f64]),
    ) -> Result<Option<Self>, TableError> {
        DriveTable::check_size(steps, columns)?;
        let jumps = edges(next_edge, steps)?;
        let n = steps as f64;
        let mut values = vec![0.0; 2 * steps * columns];
        for (row, out) in values.chunks_exact_mut(columns.max(1)).enumerate() {
            if row % ROWS_UNCHECKED == 0 && !go_on() {
                return Ok(None);
            }
            // At a drive edge the row is read slightly later, so that rounding cannot select the wrong side.
            let late = if row % 2 == 0 && jumps.binary_search(&(row / 2)).is_ok() { ON_GRID } else { 0.0 };
            read((0.5 * row as f64 + late) / n, Side::After, out);
        }
        let mut ends: Vec<u32> = (1..=steps).map(|i| 2 * (i % steps) as u32).collect();
        for &jump in &jumps {
            let step = if jump == 0 { steps } else { jump };
            ends[step - 1] = (values.len() / columns.max(1)) as u32;
            let old = values.len();
            values.resize(old + columns, 0.0);
            read((step as f64 - ON_GRID) / n, Side::Before, &mut values[old..]);
        }
        // An infinite drive is allowed if it is constant over the period and the acceleration at rest is
        // finite: this is an edge that the contact does not have.
        let same = |i: usize| values.iter().skip(i).step_by(columns).all(|x| *x == values[i]);
        let missing = |i: usize| values[i].is_infinite() && same(i) && finite_at_rest(model);
        if let Some(bad) = (0..values.len()).find(|&i| !values[i].is_finite() && !missing(i % columns)) {
            let (row, drive) = (bad / columns, bad % columns);
            return Err(TableError::NotFinite {
                drive,
                value: values[bad],
                phase: (0.5 * row as f64 / n).min(1.0),
            });
        }
        let start = values[..columns].to_vec();
        let varies = |c: usize| values.iter().skip(c).step_by(columns).any(|x| *x != start[c]);
        let varying: Vec<usize> = (0..columns).filter(|&c| columns <= WHOLE || varies(c)).collect();
        if varying.len() < columns {
            values = values.chunks_exact(columns).flat_map(|row| varying.iter().map(|&c| row[c])).collect();
        }
        Ok(Some(DriveTable { start, varying, values, ends }))
    }

    /// Number of steps per period.
    pub(crate) fn steps(&self) -> usize {
        self.ends.len()
    }
    /// Indices of the columns in the rows.
    #[inline(always)]
    pub(crate) fn varying(&self) -> &[usize] {
        &self.varying
    }
    /// All columns at the start of the period.
    pub(crate) fn start(&self) -> &[f64] {
        &self.start
    }
    /// Row `row`: the values of the columns [`varying`](DriveTable::varying).
    #[inline(always)]
    pub(crate) fn row(&self, row: usize) -> &[f64] {
        &self.values[row * self.varying.len()..][..self.varying.len()]
    }
    /// Index of the row at the end of a step, and whether the next step starts with the same row.
    #[inline(always)]
    pub(crate) fn end(&self, step: usize) -> (usize, bool) {
        let row = self.ends[step] as usize;
        (row, row < 2 * self.ends.len())
    }
    /// Whether a drive jumps at the start of a step.
    #[inline(always)]
    pub(crate) fn jumps_before(&self, step: usize) -> bool {
        let steps = self.ends.len();
        !self.end((step + steps - 1) % steps).1
    }
}

/// The whole steps at which drives jump, in order. `next_edge` returns the next edge as a share of the
/// period.
///
/// # Errors
/// [`TableError::EdgeOffGrid`].
fn edges(next_edge: impl Fn(f64) -> Option<f64>, steps: usize) -> Result<Vec<usize>, TableError> {
    let n = steps as f64;
    let mut found = Vec::new();
    // The search starts half a step early, so that it finds an edge at time 0.
    let mut share = -0.5 / n;
    while let Some(edge) = next_edge(share).filter(|edge| *edge > share) {
        let at = edge * n;
        if at > n - 0.5 {
            break;
        }
        if (at - at.round()).abs() > ON_GRID {
            return Err(TableError::EdgeOffGrid { edge, at, steps });
        }
        found.push(at.round().max(0.0) as usize);
        // Continues past this whole step: the loop ends even if many edges lie close together.
        share = edge.max((at.round() + ON_GRID) / n);
    }
    found.dedup();
    Ok(found)
}
