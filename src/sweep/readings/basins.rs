//! The motions on which the runs of a sweep ended: attractors and their basins.

use crate::error::{ParameterError, check};
use crate::sweep::rows::collection::Rows;
use crate::sweep::rows::row::Row;

/// The motions on which the runs of a sweep ended, distinguished by their strobed states. If the points of
/// the sweep are starts, the labels are the basins of attraction.
///
/// ```
/// use gear_dynamics::{sweep::{Attractors, Axis, LaneRk4, Points}, NfgPair, NfgParams, State, Sweep};
/// let starts = Points::grid(vec![Axis::linear("q", -8e-4, -6e-4, 3)?, Axis::linear("v", -1e-5, 1e-5, 2)?])?;
/// let rows = Sweep::new(starts).settle(20).measure(4).strobe(4).of(
///     &LaneRk4::new(63 * 32),
///     |_| NfgPair::new(&NfgParams { speed: 110.0, ..NfgParams::table1() }),
/// )
/// .start(|p, _| State::new(0.0, &[p["q"]], &[p["v"]]))
/// .run()?;
/// let attractors = Attractors::find(&rows, 1e-6)?;
/// assert_eq!(attractors.all().len(), 1); // one motion, wherever it starts
/// assert_eq!(attractors.label(5), Some(0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Attractors {
    first: usize,
    labels: Vec<Option<usize>>,
    list: Vec<Attractor>,
}

/// One motion on which runs ended.
///
/// ```
/// use gear_dynamics::sweep::{Attractors, Axis, TableRk4};
/// use gear_dynamics::{ParameterError, State, Sweep, model::from_fn};
/// // q'' + 3 q' + 2 q = cos 2t
/// let swing = from_fn(1, |t, q, v, a| a[0] = (2.0 * t).cos() - 3.0 * v[0] - 2.0 * q[0])?;
/// let swing = swing.with_period(std::f64::consts::PI)?;
/// let starts = Axis::linear("q", -1.0, 1.0, 5)?;
/// let rows = Sweep::new(starts).settle(20).measure(2).strobe(1).of(
///     &TableRk4::new(64),
///     |_| Ok::<_, ParameterError>(swing),
/// )
/// .start(|p, _| State::new(0.0, &[p["q"]], &[0.0]))
/// .run()?;
/// let attractors = Attractors::find(&rows, 1e-6)?;
/// let attractor = &attractors.all()[0];
/// assert_eq!((attractor.period_multiple, attractor.rows), (Some(1), 5));
/// // Closed form: q = (3 sin 2t - cos 2t)/20.
/// assert!((attractor.states[0][0] + 0.05).abs() < 1e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct Attractor {
    /// Period multiple of the motion. All motions that do not repeat form one attractor with `None`.
    pub period_multiple: Option<usize>,
    /// One strobed state for each period, coordinates then velocities; empty if the motion does not repeat.
    pub states: Vec<Vec<f64>>,
    /// Number of rows that ended on this motion.
    pub rows: usize,
}

impl Attractors {
    /// The attractors of rows with strobed states.
    ///
    /// Two motions of p periods with strobed states a_k and b_k are the same if a shift s < p exists with max
    /// |a_k - b_(k + s mod p)|/scale ≤ `tolerance` for all k. The scale of a coordinate is the maximum
    /// |coordinate| of all strobed states, that of a velocity the maximum |velocity|. A motion with more
    /// periods than strobed states counts as one that does not repeat.
    ///
    /// # Errors
    /// Rows without strobed states; a tolerance that is not positive and finite.
    pub fn find(rows: &Rows, tolerance: f64) -> Result<Self, ParameterError> {
        check::positive("tolerance of one motion", tolerance)?;
        // Without rows the list of motions is empty; this is not an error.
        if rows.layout.strobes == 0 && rows.iter().next().is_some() {
            return Err(ParameterError::TooFew { name: "strobed states of a row".into(), value: 0, min: 1 });
        }
        let n = rows.layout.dof;
        let mut scale = [f64::MIN_POSITIVE; 2];
        for state in rows.iter().flat_map(|row| row.strobes().map(<[f64]>::to_vec).collect::<Vec<_>>()) {
            for (i, x) in state.iter().enumerate() {
                scale[usize::from(i >= n)] = scale[usize::from(i >= n)].max(x.abs());
            }
        }
        let apart = |a: &[f64], b: &[f64]| {
            a.iter()
                .zip(b)
                .enumerate()
                .fold(0.0, |m: f64, (i, (a, b))| m.max((a - b).abs() / scale[usize::from(i >= n)]))
        };
        let mut list: Vec<Attractor> = Vec::new();
        let mut label = |row: &Row<'_>| {
            let period_multiple = row.period_multiple().filter(|p| *p <= rows.layout.strobes);
            let strobes: Vec<Vec<f64>> = row.strobes().map(<[f64]>::to_vec).collect();
            let states = strobes[strobes.len() - period_multiple.unwrap_or(0)..].to_vec();
            let p = states.len();
            let same = |other: &Attractor| {
                other.period_multiple == period_multiple
                    && (p == 0
                        || (0..p).any(|shift| {
                            (0..p).all(|k| apart(&states[k], &other.states[(k + shift) % p]) <= tolerance)
                        }))
            };
            let place = list.iter().position(same).unwrap_or_else(|| {
                list.push(Attractor { period_multiple, states: states.clone(), rows: 0 });
                list.len() - 1
            });
            list[place].rows += 1;
            place
        };
        let labels = rows.range().map(|index| rows.get(index).ok().map(|row| label(&row))).collect();
        Ok(Attractors { first: rows.range().start, labels, list })
    }

    /// The motions, in the order of the first row that ended on each.
    pub fn all(&self) -> &[Attractor] {
        &self.list
    }
    /// Index in [`all`](Attractors::all) of the motion on which the row of point `index` ended; `None` if
    /// the point has no row.
    pub fn label(&self, index: usize) -> Option<usize> {
        index.checked_sub(self.first).and_then(|place| self.labels.get(place).copied().flatten())
    }
}
