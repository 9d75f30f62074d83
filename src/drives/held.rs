//! Held processes: random processes that are constant on intervals of equal length.

use crate::drives::wrapped::{DriveRule, Wrapped};
use crate::error::{ParameterError, check};
use crate::excitation::Side;
use crate::excitation::earliest::earlier;
use crate::model::Model;
use crate::numeric::split_mix::{GOLDEN, mix};
use crate::series::Series;
use rand::TryRng;
use rand_distr::Distribution;
use std::convert::Infallible;
use std::fmt;
use std::sync::Arc;

/// Random numbers as a pure function of (seed, member, stream, index).
///
/// They are the SplitMix64 sequence from a start that is mixed from the four numbers. Source: Steele,
/// Lea & Flood, OOPSLA 2014. Numbers may be drawn in any order. Results therefore do not depend on step
/// sizes, threads or the partition of the work.
///
/// ```
/// use gear_dynamics::drives::CounterRng;
/// use rand::Rng;
/// // Index 5 before index 4; the values are the same on every platform.
/// assert_eq!(CounterRng::new(1, 2, 3, 5).next_u64(), 0xcfc0_0be6_e5b0_4057);
/// assert_eq!(CounterRng::new(1, 2, 3, 4).next_u64(), 0x4d89_ae18_701f_b6f3);
/// ```
#[derive(Clone, Debug)]
pub struct CounterRng(u64);

impl CounterRng {
    /// The generator of these four numbers.
    pub fn new(seed: u64, member: u64, stream: u64, index: u64) -> Self {
        let start = [member, stream, index].iter().fold(mix(seed.wrapping_add(GOLDEN)), |state, &word| {
            mix(state.wrapping_add(GOLDEN)
                ^ mix(word.wrapping_add(GOLDEN).wrapping_mul(0xd134_2543_de82_ef95)))
        });
        CounterRng(start)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(GOLDEN);
        mix(self.0)
    }
}

impl TryRng for CounterRng {
    type Error = Infallible;
    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        Ok((self.next() >> 32) as u32)
    }
    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        Ok(self.next())
    }
    fn try_fill_bytes(&mut self, out: &mut [u8]) -> Result<(), Infallible> {
        for chunk in out.chunks_mut(8) {
            chunk.copy_from_slice(&self.next().to_le_bytes()[..chunk.len()]);
        }
        Ok(())
    }
}

type Draw = Arc<dyn Fn(&mut CounterRng) -> f64 + Send + Sync>;

/// A held process: x(t) = x_k for k h <= t < (k + 1) h, with random or given values x_k and the hold time h.
///
/// With numbers drawn at every evaluation of the acceleration the result depends on the step size. With held
/// values it converges as the step size decreases, and the hold time h is a physical parameter. Source:
/// docs/theory.md, "Random damping".
///
/// ```
/// use gear_dynamics::{drives::HeldProcess, excitation::Side};
/// use rand_distr::Uniform;
/// let process = HeldProcess::new(0.5, Uniform::new(0.0, 1.0)?)?.seed(7);
/// assert_eq!(process.at(0.1, Side::After, 0), process.at(0.4, Side::After, 0));
/// assert_ne!(process.at(0.5, Side::Before, 0), process.at(0.5, Side::After, 0));
/// let given = HeldProcess::from_values(0.5, &[3.0, 5.0])?;
/// assert_eq!(given.at(0.7, Side::After, 0), 5.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct HeldProcess {
    hold: f64,
    seed: u64,
    member: u64,
    source: ValueSource,
}

#[derive(Clone)]
enum ValueSource {
    /// A draw from a distribution.
    Drawn(Draw),
    /// A list of values.
    Given(Arc<[f64]>),
}

impl HeldProcess {
    /// A process with a new value of `distribution` after every hold time h > 0, in the time unit of the
    /// model. Defaults: seed 0, member 0.
    ///
    /// # Errors
    /// A hold time outside 1e-50 .. 1e50.
    pub fn new<D>(hold: f64, distribution: D) -> Result<Self, ParameterError>
    where
        D: Distribution<f64> + Send + Sync + 'static,
    {
        let draw = move |rng: &mut CounterRng| distribution.sample(rng);
        Ok(HeldProcess {
            hold: check::scale("hold time", hold)?,
            seed: 0,
            member: 0,
            source: ValueSource::Drawn(Arc::new(draw)),
        })
    }

    /// A process with given values, one for each hold time h. The last value applies after the end of the
    /// list. All streams have the same values.
    ///
    /// # Errors
    /// A hold time outside 1e-50 .. 1e50; an empty list; a value beyond ±1e50.
    pub fn from_values(hold: f64, values: &[f64]) -> Result<Self, ParameterError> {
        let hold = check::scale("hold time", hold)?;
        if values.is_empty() {
            return Err(ParameterError::Empty { name: "held values".into(), min: 1 });
        }
        check::quantities("held values", values)?;
        Ok(HeldProcess { hold, seed: 0, member: 0, source: ValueSource::Given(values.into()) })
    }

    /// The same process with another seed, for an independent experiment. Default: 0.
    pub fn seed(self, seed: u64) -> Self {
        HeldProcess { seed, ..self }
    }
    /// The same process for another member of an ensemble with the same seed. Default: 0.
    pub fn member(self, member: u64) -> Self {
        HeldProcess { member, ..self }
    }
    /// Hold time h, in the time unit of the model.
    pub fn hold(&self) -> f64 {
        self.hold
    }

    /// Value x_k of a stream. Different streams are independent: each mesh may have its own one, or all
    /// meshes share one.
    pub fn held(&self, stream: u64, k: u64) -> f64 {
        match &self.source {
            ValueSource::Drawn(draw) => draw(&mut CounterRng::new(self.seed, self.member, stream, k)),
            ValueSource::Given(values) => values[(k as usize).min(values.len() - 1)],
        }
    }

    /// The value x(t) of a stream; x_0 for t < 0. `side`: before or after a jump at `t`.
    pub fn at(&self, t: f64, side: Side, stream: u64) -> f64 {
        let k = self.index(t);
        let before = side == Side::Before && k > 0 && k as f64 * self.hold == t;
        self.held(stream, if before { k - 1 } else { k })
    }

    /// The k with k h <= t < (k + 1) h, in which k h is the rounded product. 0 for t < 0; at most 2^52.
    fn index(&self, t: f64) -> u64 {
        let guess = (t / self.hold).max(0.0);
        if guess >= LAST {
            return LAST as u64;
        }
        let mut k = guess as u64;
        while k > 0 && k as f64 * self.hold > t {
            k -= 1;
        }
        while (k + 1) as f64 * self.hold <= t {
            k += 1;
        }
        k
    }

    /// The first instant k h after `t`, with k >= 1.
    fn next_edge(&self, t: f64) -> Option<f64> {
        let edge = if t < 0.0 { self.hold } else { (self.index(t) + 1) as f64 * self.hold };
        (edge > t).then_some(edge)
    }
}

/// 2^52: largest index k. The numbers k and k + 1 are exact up to here.
const LAST: f64 = 4_503_599_627_370_496.0;

impl fmt::Debug for HeldProcess {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("HeldProcess")
            .field("hold", &self.hold)
            .field("seed", &self.seed)
            .finish_non_exhaustive()
    }
}

/// A process that is added to one drive.
#[derive(Clone, Debug)]
struct Fill {
    slot: usize,
    gain: f64,
    process: usize,
    stream: u64,
}

/// A model with held processes added to chosen drives, `u[slot] += gain x(t)`.
///
/// Streams are numbered consecutively over all processes of one `Held`. Two processes with the same seed on
/// different slots are therefore independent.
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
/// let slots =
///     (0..3).map(|mesh| ring.slot(&format!("mesh damping {mesh}"))).collect::<Result<Vec<_>, _>>()?;
/// let noisy = Held::new(ring).per_slot(&slots, 500.0, process)?;
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
/// let noisy = Held::new(ring).shared(&slots, 500.0, process)?;
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
    /// Number of streams in use.
    streams: u64,
}

impl HeldDrives {
    fn fill(
        mut self,
        drives: usize,
        slots: &[usize],
        gains: &[f64],
        process: HeldProcess,
        streams: &[u64],
    ) -> Result<Self, ParameterError> {
        for ((&slot, &gain), &stream) in slots.iter().zip(gains).zip(streams) {
            if slot >= drives {
                return Err(ParameterError::NoSuchSlot { slot, drives });
            }
            let gain = check::quantity("gain", gain)?;
            let stream = self.streams + stream;
            self.fills.push(Fill { slot, gain, process: self.processes.len(), stream });
        }
        self.streams += streams.iter().max().map_or(0, |last| last + 1);
        self.processes.push(process);
        Ok(self)
    }
}

impl<M: Model> DriveRule<M> for HeldDrives {
    fn drive(&self, model: &M, t: f64, side: Side, u: &mut [f64]) {
        model.drive(t, side, u);
        for fill in &self.fills {
            u[fill.slot] += fill.gain * self.processes[fill.process].at(t, side, fill.stream);
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
            let held = self.processes[fill.process].at(t, Side::After, fill.stream);
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

    fn fill(
        self,
        slots: &[usize],
        gains: &[f64],
        process: HeldProcess,
        streams: &[u64],
    ) -> Result<Self, ParameterError> {
        self.map_rule(|model, rule| rule.fill(model.drives(), slots, gains, process, streams))
    }

    /// Adds a process with one stream to all slots: at every instant they have the same value.
    ///
    /// # Errors
    /// A slot that the model does not have; a gain beyond ±1e50.
    pub fn shared(self, slots: &[usize], gain: f64, process: HeldProcess) -> Result<Self, ParameterError> {
        self.fill(slots, &vec![gain; slots.len()], process, &vec![0; slots.len()])
    }

    /// Adds a process with one stream per slot: the values of the slots are independent.
    ///
    /// # Errors
    /// A slot that the model does not have; a gain beyond ±1e50.
    pub fn per_slot(self, slots: &[usize], gain: f64, process: HeldProcess) -> Result<Self, ParameterError> {
        let streams: Vec<u64> = (0..slots.len() as u64).collect();
        self.fill(slots, &vec![gain; slots.len()], process, &streams)
    }

    /// Adds a process with one stream and one gain per slot. With the dampings C_g of the meshes as gains,
    /// the process is relative to the damping of each mesh.
    ///
    /// # Errors
    /// A number of gains that differs from the number of slots; a slot that the model does not have; a gain
    /// beyond ±1e50.
    pub fn per_slot_with_gains(
        self,
        slots: &[usize],
        gains: &[f64],
        process: HeldProcess,
    ) -> Result<Self, ParameterError> {
        check::length("gains", gains.len(), slots.len())?;
        let streams: Vec<u64> = (0..slots.len() as u64).collect();
        self.fill(slots, gains, process, &streams)
    }

    /// Adds a process to the half widths of meshes, b + gain x(t), with one stream per mesh; b is half the
    /// backlash. `slots`: the drives with the lower and the upper edge of each mesh.
    ///
    /// # Errors
    /// A slot that the model does not have; a gain beyond ±1e50.
    pub fn clearance(
        self,
        slots: &[[usize; 2]],
        gain: f64,
        process: HeldProcess,
    ) -> Result<Self, ParameterError> {
        let flat: Vec<usize> = slots.iter().flatten().copied().collect();
        let gains: Vec<f64> = slots.iter().flat_map(|_| [-gain, gain]).collect();
        let streams: Vec<u64> = (0..slots.len() as u64).flat_map(|s| [s, s]).collect();
        self.fill(&flat, &gains, process, &streams)
    }
}
