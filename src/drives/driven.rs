//! Drives given by functions of time.

use crate::drives::wrapped::{DriveRule, Wrapped, own_series};
use crate::error::{ParameterError, check};
use crate::excitation::Side;
use crate::excitation::earliest::earlier;
use crate::model::Model;
use crate::model::equations::check_slot;
use crate::series::Series;
use std::fmt;
use std::sync::Arc;

type OfTime = Arc<dyn Fn(f64) -> f64 + Send + Sync>;

/// A model with functions of time added to chosen drives, `u[slot] += f(t)`: for example a torque that
/// increases or a load that steps. A function of the angle of a shaft is a [`Wave`](crate::Wave) instead.
///
/// ```
/// use gear_dynamics::{drives::Driven, Model, Ring, models::ring::RingSet, excitation::Side};
/// let ring = Ring::as_printed(&RingSet::set_a(3, 1000.0).params()?)?;
/// let torque = ring.slot("motor torque")?;
/// // The torque increases by 5 N m/s for 2 s and is constant afterwards.
/// let run_up = Driven::new(ring).add(torque, |t| if t < 2.0 { 5.0 * t } else { 10.0 }, &[2.0])?;
/// let mut u = vec![0.0; run_up.drives()];
/// run_up.drive(1.0, Side::After, &mut u);
/// assert_eq!(u[torque], 44.0 + 5.0);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
pub type Driven<M> = Wrapped<M, TimeDrives>;

/// The rule of [`Driven`]: the functions of time and the drives to which they are added.
///
/// ```
/// use gear_dynamics::{drives::Driven, models::ring::RingSet, excitation::Side, Model, Ring};
/// let ring = Ring::as_printed(&RingSet::set_a(3, 1000.0).params()?)?;
/// let torque = ring.slot("motor torque")?;
/// let ramp = Driven::new(ring).add(torque, |t| 5.0 * t, &[])?;
/// let both = ramp.add(torque, |t| if t < 2.0 { 0.0 } else { 10.0 }, &[2.0])?;
/// let mut u = vec![0.0; both.drives()];
/// both.drive(2.0, Side::Before, &mut u);
/// assert!((u[torque] - (44.0 + 10.0)).abs() < 1e-12); // [N m]
/// both.drive(2.0, Side::After, &mut u);
/// assert!((u[torque] - (44.0 + 20.0)).abs() < 1e-12); // the step is added
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Default)]
pub struct TimeDrives {
    functions: Vec<(usize, OfTime)>,
    /// Instants at which functions jump or have a kink, increasing.
    edges: Vec<f64>,
}

impl fmt::Debug for TimeDrives {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let slots: Vec<usize> = self.functions.iter().map(|(slot, _)| *slot).collect();
        f.debug_struct("TimeDrives")
            .field("slots", &slots)
            .field("edges", &self.edges)
            .finish_non_exhaustive()
    }
}

impl<M: Model> Driven<M> {
    /// A model to which no function is added yet.
    pub fn new(model: M) -> Self {
        Wrapped::by_rule(model, TimeDrives::default())
    }

    /// Adds f(t) to the drive `slot`. `edges`: the instants at which f jumps or has a kink; solvers end
    /// their steps there. At these instants f is evaluated at the next smaller or the next larger
    /// floating-point number, for the value before or after a jump.
    ///
    /// # Errors
    /// A slot that the model does not have; an edge beyond ±1e50.
    pub fn add(
        self,
        slot: usize,
        f: impl Fn(f64) -> f64 + Send + Sync + 'static,
        edges: &[f64],
    ) -> Result<Self, ParameterError> {
        self.map_rule(|model, mut rule| {
            check_slot(model, slot)?;
            check::quantities("edges of the function", edges)?;
            rule.functions.push((slot, Arc::new(f)));
            rule.edges.extend(edges);
            rule.edges.sort_by(f64::total_cmp);
            rule.edges.dedup();
            Ok(rule)
        })
    }
}

impl<M: Model> DriveRule<M> for TimeDrives {
    fn drive(&self, model: &M, t: f64, side: Side, u: &mut [f64]) {
        model.drive(t, side, u);
        let on_edge = self.edges.binary_search_by(|edge| edge.total_cmp(&t)).is_ok();
        let seen = match side {
            _ if !on_edge => t,
            Side::Before => t.next_down(),
            Side::After => t.next_up(),
        };
        for (slot, f) in &self.functions {
            u[*slot] += f(seen);
        }
    }
    fn changes(&self, _: &M, drive: usize) -> bool {
        self.functions.iter().any(|(slot, _)| *slot == drive)
    }
    fn series(&self, model: &M, t: f64, coefficients: usize, u: &mut [Series]) {
        own_series(model, t, coefficients, u);
        for (slot, _) in &self.functions {
            u[*slot] = Series::refused("a function of time (`Driven`), which is a closure on plain numbers");
        }
    }
    fn next_edge(&self, model: &M, t: f64) -> Option<f64> {
        let next = self.edges.partition_point(|edge| *edge <= t);
        earlier(model.next_edge(t), self.edges.get(next).copied())
    }
}
