//! The trait of models with a Taylor series.

use crate::contact::{Contact, Piece};
use crate::error::ParameterError;
use crate::interval::number::Interval;
use crate::model::expansion::every_piece::EveryPiece;
use crate::series::{PowerSeries, Series};
use crate::tape::node::Node;
use crate::tape::operations::Tape;
use crate::tape::recording::Recording;

/// A model that can be expanded into Taylor series over time.
///
/// [`Machine`](crate::Machine) implements it for every [`Shape`](crate::Shape), and
/// [`Wrapped`](crate::drives::rules::Wrapped) for its rules. [`Taylor`](crate::Taylor) asks for it through
/// [`Offers::expansion`](crate::model::Offers::expansion).
///
/// ```
/// use gear_dynamics::model::Series;
/// use gear_dynamics::{Model, NfgPair, NfgParams};
/// let pair = NfgPair::new(&NfgParams::table1())?;
/// let expanded = pair.offers().expansion.expect("a machine can be expanded");
/// let mut u = vec![Series::from(0.0); pair.drives()];
/// expanded.drive_series(0.0, 8, &mut u);
/// assert_eq!(u[0].coefficients().len(), 8);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
pub trait Expand {
    /// Records the algebra. `moving(d)`: drive d is written by [`drive_series`](Expand::drive_series) at
    /// every step, although it is a constant of the model.
    fn record(&self, moving: &dyn Fn(usize) -> bool) -> Recorded;
    /// Writes the drives after `t` to `u` as series over the time after `t`, with this number of
    /// coefficients.
    fn drive_series(&self, t: f64, coefficients: usize, u: &mut [Series]);
    /// Updates `u`, which contains the series after another instant. The implementation may skip drives that
    /// never change, and those that are not `needed`. Default: [`drive_series`](Expand::drive_series).
    fn redrive_series(&self, t: f64, coefficients: usize, needed: &[bool], u: &mut [Series]) {
        let _ = needed;
        self.drive_series(t, coefficients, u);
    }
    /// Calls `entry` with row, column and value of every entry of ∂a/∂(q, v) that is not always 0; columns of
    /// the velocities follow those of the coordinates. `false`: the entries are not known.
    #[doc(hidden)]
    fn entries(
        &self,
        pieces: Option<&[Piece]>,
        u: &[f64],
        q: &[f64],
        v: &[f64],
        entry: &mut dyn FnMut(usize, usize, f64),
    ) -> bool {
        let _ = (pieces, u, q, v, entry);
        false
    }
    /// The model with enclosed drives, for a [certificate](crate::certify). `given`: constants by name that
    /// are intervals; all others are the numbers of the model. Default: `None`, a model that cannot be
    /// enclosed.
    ///
    /// # Errors
    /// A name that the model does not have.
    fn enclosed(&self, given: &[(&str, Interval)]) -> Result<Option<Box<dyn Enclosed + '_>>, ParameterError> {
        let _ = given;
        Ok(None)
    }
}

/// The drives of a model and its period as enclosures: what a [certificate](crate::certify) reads.
///
/// ```
/// use gear_dynamics::{Model, NfgPair, NfgParams, Periodic};
/// let pair = NfgPair::new(&NfgParams::table1())?;
/// let enclosed = pair.offers().expansion.expect("a machine can be expanded").enclosed(&[])?;
/// assert!(enclosed.expect("a machine can be enclosed").period().contains(pair.period()));
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
pub trait Enclosed {
    /// The period of the drives.
    fn period(&self) -> Interval;
    /// Writes the drives as enclosed Taylor series over the time after `time`. `inside`: a time within the
    /// stretch, between the same drive edges.
    fn drives(&self, time: Interval, inside: f64, coefficients: usize, u: &mut [PowerSeries<Interval>]);
    /// The exact instant of the drive edge that the model finds at `time`.
    fn edge(&self, time: f64) -> Interval;
    /// The velocities after an impact on a rigid stop, recorded in place of the accelerations.
    fn impact(&self, contact: usize, on: Piece) -> Recorded;
}

/// A recorded algebra. Only [`Taylor`](crate::Taylor) reads it.
///
/// ```
/// use gear_dynamics::{Model, NfgPair, NfgParams};
/// let pair = NfgPair::new(&NfgParams::table1())?;
/// let recorded = pair.offers().expansion.expect("a machine can be expanded").record(&|_| false);
/// assert_eq!(recorded.dof(), 1);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Recorded(pub(crate) Tape);

impl Recorded {
    /// Records an algebra: `algebra(every, u, q, v, a)` writes the accelerations to `a`, from drives,
    /// coordinates and velocities, and returns the contacts, of which deflection and edges are read. It
    /// evaluates contact laws by `every`. `constant(d)`: the value of drive d, if it is constant.
    ///
    /// A [`Shape`](crate::Shape) needs no recording of its own. See [`EveryPiece`].
    pub fn of(
        dof: usize,
        drives: usize,
        constant: &dyn Fn(usize) -> Option<f64>,
        algebra: impl for<'t> FnOnce(
            &EveryPiece<'t>,
            &[Node<'t>],
            &[Node<'t>],
            &[Node<'t>],
            &mut [Node<'t>],
        ) -> Vec<Contact<Node<'t>>>,
    ) -> Self {
        let recording = Recording::new(dof, drives);
        let input = |slot: usize| Node::recorded(&recording, recording.input(slot));
        let drive = |d: usize| constant(d).map_or_else(|| input(2 * dof + d), Node::from);
        let q: Vec<Node<'_>> = (0..dof).map(input).collect();
        let v: Vec<Node<'_>> = (dof..2 * dof).map(input).collect();
        let u: Vec<Node<'_>> = (0..drives).map(drive).collect();
        let mut a = vec![Node::from(0.0); dof];
        let contacts = algebra(&EveryPiece(&recording), &u, &q, &v, &mut a);
        let accelerations = a.iter().map(|a| a.form(&recording)).collect();
        let finite = |edge: Node<'_>| edge.constant().is_none_or(f64::is_finite);
        let distances = contacts.iter().map(|c| {
            [(c.lower, c.deflection - c.lower), (c.upper, c.upper - c.deflection)]
                .map(|(edge, distance)| finite(edge).then(|| distance.form(&recording)))
        });
        let distances = distances.collect();
        let measured = contacts.iter().map(|c| [c.deflection, c.force].map(|number| number.form(&recording)));
        let measured = measured.collect();
        Recorded(Tape { measured, ..recording.finish(accelerations, distances) })
    }

    /// Number of degrees of freedom.
    pub fn dof(&self) -> usize {
        self.0.dof
    }
}
