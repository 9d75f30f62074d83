//! Drives over one period, evaluated once for all runs.

use crate::excitation::side::Side;
use crate::model::equations::Periodic;
use crate::model::machine::Machine;
use crate::model::shape::Shape;
use std::f64::consts::TAU;
use thiserror::Error;

/// Why no table can be made.
///
/// ```
/// let error = gear_dynamics::sweep::TableError::Size { steps: 0, drives: 3 };
/// assert_eq!(error.to_string(), "a table of 0 steps per period for 3 drives: at least one step, at most 67108864 numbers, two rows a step");
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum TableError {
    /// No steps, or too many.
    #[error(
        "a table of {steps} steps per period for {drives} drives: at least one step, at most {MOST} numbers, two rows a step"
    )]
    Size {
        /// Steps per period.
        steps: usize,
        /// Drives in a row.
        drives: usize,
    },
    /// A drive that jumps between the steps.
    #[error(
        "a drive jumps after {edge} of the period, which is step {at} of {steps}: take a number of steps that puts it on a whole one, \
         or an engine that locates edges"
    )]
    EdgeOffGrid {
        /// When, as a share of the period.
        edge: f64,
        /// Which step that would be.
        at: f64,
        /// Steps per period.
        steps: usize,
    },
    /// A drive that is not a number.
    #[error("drive {drive} is {value} at {phase} of the period")]
    NotFinite {
        /// Which drive.
        drive: usize,
        /// What it was.
        value: f64,
        /// When, as a share of the period.
        phase: f64,
    },
}

/// How far an edge may be from a grid point, in steps, and from where its two sides are looked at.
const ON_GRID: f64 = 1e-6;

/// Most numbers in a table: half a gigabyte.
const MOST: usize = 1 << 26;

/// Rows between two looks at whether to go on.
const STRETCH: usize = 64;

/// The drives at the start, the middle and the end of every step of one period.
///
/// Row 2i is the start of step i, row 2i + 1 its middle. The end of a step is the start of the next one, seen from before, unless a drive
/// jumps there.
#[derive(Debug)]
pub(crate) struct Table {
    /// All columns at the start.
    start: Vec<f64>,
    /// Columns that change over the period, or all if they are few; the others are filled in once.
    varying: Vec<usize>,
    /// Rows of the varying columns.
    values: Vec<f64>,
    /// The row at the end of each step.
    ends: Vec<u32>,
}

/// Up to this number of columns stand in rows as they are.
pub(crate) const WHOLE: usize = 16;

/// Whether the acceleration at rest is finite.
fn finite_at_rest<M: Periodic + ?Sized>(model: &M) -> bool {
    let (mut u, rest) = (vec![0.0; model.drives()], vec![0.0; model.dof()]);
    let mut a = rest.clone();
    model.drive(0.0, Side::After, &mut u);
    model.accel(&u, &rest, &rest, &mut a);
    a.iter().all(|a| a.is_finite())
}

impl Table {
    /// Whether there is room for one.
    pub(crate) fn check_size(steps: usize, drives: usize) -> Result<(), TableError> {
        let numbers = steps.checked_mul(2).and_then(|rows| rows.checked_mul(drives.max(1)));
        if steps > 0 && numbers.is_some_and(|numbers| numbers <= MOST) {
            Ok(())
        } else {
            Err(TableError::Size { steps, drives })
        }
    }

    /// The waves that all lanes share. `None`: not to go on.
    pub(crate) fn of_waves<G: Shape>(
        model: &Machine<G>,
        steps: usize,
        go_on: impl Fn() -> bool,
    ) -> Result<Option<Self>, TableError> {
        let (shape, waves) = (model.shape(), model.size().waves);
        let turn = TAU / f64::from(shape.repeats());
        let next = |share: f64| shape.next_edge(turn * share).map(|edge| edge / turn);
        Table::new(model, waves, steps, go_on, next, |share, side, out: &mut [f64]| {
            shape.waves(turn * share, side, out)
        })
    }

    /// All drives of one model. `None`: not to go on.
    pub(crate) fn of_drives<M: Periodic + ?Sized>(
        model: &M,
        steps: usize,
        go_on: impl Fn() -> bool,
    ) -> Result<Option<Self>, TableError> {
        let period = model.period();
        let next = |share: f64| model.next_edge(share * period).map(|edge| edge / period);
        Table::new(model, model.drives(), steps, go_on, next, |share, side, out: &mut [f64]| {
            model.drive(share * period, side, out)
        })
    }

    fn new<M: Periodic + ?Sized>(
        model: &M,
        columns: usize,
        steps: usize,
        go_on: impl Fn() -> bool,
        next_edge: impl Fn(f64) -> Option<f64>,
        mut read: impl FnMut(f64, Side, &mut [f64]),
    ) -> Result<Option<Self>, TableError> {
        Table::check_size(steps, columns)?;
        let jumps = edges(next_edge, steps)?;
        let n = steps as f64;
        let mut values = vec![0.0; 2 * steps * columns];
        for (row, out) in values.chunks_exact_mut(columns.max(1)).enumerate() {
            if row % STRETCH == 0 && !go_on() {
                return Ok(None);
            }
            // At a jump a little later, so that the side does not hang on rounding.
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
        // An edge that a contact does not have lies at the same infinity at all times, and leaves the acceleration finite.
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
        Ok(Some(Table { start, varying, values, ends }))
    }

    /// Steps in a period.
    pub(crate) fn steps(&self) -> usize {
        self.ends.len()
    }
    #[inline(always)]
    pub(crate) fn varying(&self) -> &[usize] {
        &self.varying
    }
    /// All columns at the start.
    pub(crate) fn start(&self) -> &[f64] {
        &self.start
    }
    /// A row of the varying columns.
    #[inline(always)]
    pub(crate) fn row(&self, row: usize) -> &[f64] {
        &self.values[row * self.varying.len()..][..self.varying.len()]
    }
    /// The row at the end of a step, and whether the next step starts with the same one.
    #[inline(always)]
    pub(crate) fn end(&self, step: usize) -> (usize, bool) {
        let row = self.ends[step] as usize;
        (row, row < 2 * self.ends.len())
    }
}

/// The grid points at which drives jump, in order; edges are shares of the period.
fn edges(next_edge: impl Fn(f64) -> Option<f64>, steps: usize) -> Result<Vec<usize>, TableError> {
    let n = steps as f64;
    let mut found = Vec::new();
    // Begun half a step early, so that a jump at the very start is met.
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
        // Past this grid point, so that there is an end to it however many edges crowd there.
        share = edge.max((at.round() + ON_GRID) / n);
    }
    found.dedup();
    Ok(found)
}
