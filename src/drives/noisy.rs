//! Random processes added to the drives of a model.

use crate::drives::wrapped::{DriveRule, Wrapped, own_series};
use crate::error::{ParameterError, check};
use crate::excitation::Side;
use crate::excitation::earliest::earlier;
use crate::model::Model;
use crate::model::equations::check_slot;
use crate::processes::{Path, Process};
use crate::series::Series;
use std::fmt;
use std::sync::Arc;

/// A path and the drives to which it is added, with its gains.
#[derive(Clone)]
struct Added {
    path: Arc<dyn Path>,
    slots: Vec<(usize, f64)>,
}

/// A model with random processes added to chosen drives, `u[slot] += gain x(t)`.
///
/// The k-th process that is added has stream k. The same process, added twice, has independent paths.
///
/// The wrapped model ([`bare`](Wrapped::bare)) remains periodic. The `Noisy` model is not periodic: the
/// compiler rejects a harmonic balance of it.
///
/// ```
/// use gear_dynamics::{drives::Noisy, processes::HeldProcess, Model, Ring, models::ring::RingSet};
/// use rand_distr::Uniform;
/// let ring = Ring::as_printed(&RingSet::set_a(3, 1000.0).params()?)?;
/// // C_gΔ of Yao 2020: uniform on (0, 1) times 500 N s/m, one stream per mesh, hold time 0.1 ms.
/// let process = HeldProcess::new(1e-4, Uniform::new(0.0, 1.0)?)?.seed(1);
/// let mut noisy = Noisy::new(ring.clone());
/// for mesh in 0..3 {
///     noisy = noisy.add(&[(ring.slot(&format!("mesh damping {mesh}"))?, 500.0)], &process)?;
/// }
/// assert_eq!(noisy.next_edge(0.0), Some(1e-4));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type Noisy<M> = Wrapped<M, RandomDrives>;

/// The rule of [`Noisy`]: the paths of random processes and the drives to which they are added.
///
/// ```
/// use gear_dynamics::{drives::Noisy, excitation::Side, models::ring::RingSet, Model, Ring};
/// use gear_dynamics::processes::HeldProcess;
/// let ring = Ring::as_printed(&RingSet::set_a(3, 1000.0).params()?)?;
/// let slots = [ring.slot("mesh damping 0")?, ring.slot("mesh damping 1")?];
/// let process = HeldProcess::of_values(1e-3, &[0.0, 1.0])?;
/// let noisy = Noisy::new(ring).add(&slots.map(|slot| (slot, 500.0)), &process)?;
/// let [mut before, mut after] = [vec![0.0; noisy.drives()], vec![0.0; noisy.drives()]];
/// noisy.drive(0.0005, Side::After, &mut before);
/// noisy.drive(0.0015, Side::After, &mut after);
/// assert_eq!(slots.map(|slot| after[slot] - before[slot]), [500.0; 2]); // one path, added to two drives
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Default)]
pub struct RandomDrives(Vec<Added>);

impl fmt::Debug for RandomDrives {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.0.iter().map(|added| &added.slots)).finish()
    }
}

impl<M: Model> DriveRule<M> for RandomDrives {
    fn drive(&self, model: &M, t: f64, side: Side, u: &mut [f64]) {
        model.drive(t, side, u);
        for Added { path, slots } in &self.0 {
            let x = path.at(t, side);
            slots.iter().for_each(|(slot, gain)| u[*slot] += gain * x);
        }
    }
    fn changes(&self, _: &M, drive: usize) -> bool {
        self.0.iter().any(|added| added.slots.iter().any(|(slot, _)| *slot == drive))
    }
    fn series(&self, model: &M, t: f64, coefficients: usize, u: &mut [Series]) {
        own_series(model, t, coefficients, u);
        for Added { path, slots } in &self.0 {
            let x = path.series(t, coefficients);
            slots.iter().for_each(|(slot, gain)| u[*slot] = u[*slot] + x * *gain);
        }
    }
    fn next_edge(&self, model: &M, t: f64) -> Option<f64> {
        self.0.iter().fold(model.next_edge(t), |first, added| earlier(first, added.path.next_edge(t)))
    }
}

impl<M: Model> Noisy<M> {
    /// A model to which no process is added yet.
    pub fn new(model: M) -> Self {
        Wrapped::by_rule(model, RandomDrives::default())
    }

    /// Adds gain × x(t) to each of these `(slot, gain)`, with the same path x(t) for all of them: to the
    /// lower and the upper edge of a mesh with the gains -g and g, for example, to vary its half backlash.
    /// Slots whose paths are independent are added one by one.
    ///
    /// # Errors
    /// A slot that the model does not have; a gain beyond ±1e50.
    pub fn add(self, slots: &[(usize, f64)], process: &dyn Process) -> Result<Self, ParameterError> {
        self.map_rule(|model, mut rule| {
            for &(slot, gain) in slots {
                check_slot(model, slot)?;
                check::quantity("gain", gain)?;
            }
            rule.0.push(Added { path: process.path(rule.0.len() as u64), slots: slots.to_vec() });
            Ok(rule)
        })
    }
}
