//! Held processes added to the drives of a model.

use crate::drives::process::HeldProcess;
use crate::drives::wrapped::{DriveRule, Wrapped};
use crate::error::{ParameterError, check};
use crate::excitation::Side;
use crate::excitation::earliest::earlier;
use crate::model::Model;
use crate::series::Series;

/// A drive to which a process is added.
#[derive(Clone, Debug)]
struct Fill {
    slot: usize,
    gain: f64,
    /// Index of the process, and number of its stream.
    stream: usize,
}

/// A model with held processes added to chosen drives, `u[slot] += gain x(t)`.
///
/// The k-th process that is added has stream k. The same process, added twice, has independent values.
///
/// The wrapped model ([`bare`](Wrapped::bare)) remains periodic. The `Held` model is not periodic: the
/// compiler rejects a harmonic balance of it.
///
/// ```
/// use gear_dynamics::{drives::{Held, HeldProcess}, Model, Ring, models::ring::RingSet};
/// use rand_distr::Uniform;
/// let ring = Ring::as_printed(&RingSet::set_a(3, 1000.0).params()?)?;
/// // C_gΔ of Yao 2020: uniform on (0, 1) times 500 N s/m, one stream per mesh, hold time 0.1 ms.
/// let process = HeldProcess::new(1e-4, Uniform::new(0.0, 1.0)?)?.seed(1);
/// let mut noisy = Held::new(ring.clone());
/// for mesh in 0..3 {
///     noisy = noisy.add(&[(ring.slot(&format!("mesh damping {mesh}"))?, 500.0)], process.clone())?;
/// }
/// assert_eq!(noisy.next_edge(0.0), Some(1e-4));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type Held<M> = Wrapped<M, HeldDrives>;

/// The rule of [`Held`]: the held processes and the drives to which they are added.
///
/// ```
/// use gear_dynamics::{drives::{Held, HeldProcess}, excitation::Side, models::ring::RingSet, Model, Ring};
/// let ring = Ring::as_printed(&RingSet::set_a(3, 1000.0).params()?)?;
/// let slots = [ring.slot("mesh damping 0")?, ring.slot("mesh damping 1")?];
/// let process = HeldProcess::from_values(1e-3, &[0.0, 1.0])?;
/// let noisy = Held::new(ring).add(&slots.map(|slot| (slot, 500.0)), process)?;
/// let [mut before, mut after] = [vec![0.0; noisy.drives()], vec![0.0; noisy.drives()]];
/// noisy.drive(0.0005, Side::After, &mut before);
/// noisy.drive(0.0015, Side::After, &mut after);
/// assert_eq!(slots.map(|slot| after[slot] - before[slot]), [500.0; 2]); // one process, added to two drives
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct HeldDrives {
    processes: Vec<HeldProcess>,
    fills: Vec<Fill>,
}

impl<M: Model> DriveRule<M> for HeldDrives {
    fn drive(&self, model: &M, t: f64, side: Side, u: &mut [f64]) {
        model.drive(t, side, u);
        for fill in &self.fills {
            u[fill.slot] += fill.gain * self.processes[fill.stream].at(t, side, fill.stream as u64);
        }
    }
    fn changes(&self, _: &M, drive: usize) -> bool {
        self.fills.iter().any(|fill| fill.slot == drive)
    }
    fn series(&self, model: &M, t: f64, coefficients: usize, u: &mut [Series]) {
        if let Some(expanded) = model.offers().expansion {
            expanded.drive_series(t, coefficients, u);
        }
        for fill in &self.fills {
            let held = self.processes[fill.stream].at(t, Side::After, fill.stream as u64);
            u[fill.slot] = u[fill.slot] + Series::from(fill.gain * held);
        }
    }
    fn next_edge(&self, model: &M, t: f64) -> Option<f64> {
        self.processes.iter().fold(model.next_edge(t), |first, process| earlier(first, process.next_edge(t)))
    }
}

impl<M: Model> Held<M> {
    /// A model to which no process is added yet.
    pub fn new(model: M) -> Self {
        Wrapped::by_rule(model, HeldDrives::default())
    }

    /// Adds gain × x(t) to each of these `(slot, gain)`, with the same x(t) for all of them: to the lower and
    /// the upper edge of a mesh with the gains -g and g, for example, to vary its half backlash. Slots whose
    /// values are independent are added one by one.
    ///
    /// # Errors
    /// A slot that the model does not have; a gain beyond ±1e50.
    pub fn add(self, slots: &[(usize, f64)], process: HeldProcess) -> Result<Self, ParameterError> {
        self.map_rule(|model, mut rule| {
            let drives = model.drives();
            for &(slot, gain) in slots {
                if slot >= drives {
                    return Err(ParameterError::NoSuchSlot { slot, drives });
                }
                let gain = check::quantity("gain", gain)?;
                rule.fills.push(Fill { slot, gain, stream: rule.processes.len() });
            }
            rule.processes.push(process);
            Ok(rule)
        })
    }
}
