//! The vector instructions of the lanes.

use pulp::Arch;
use pulp::WithSimd;

/// The vector instructions with which lanes run. The choice affects the time of a run only: the results are
/// equal bit by bit.
///
/// ```
/// use gear_dynamics::{sweep::{Axis, InstructionSet, LaneRk4}, NfgPair, NfgParams, Sweep};
/// let speeds = Axis::linear("speed", 100.0, 130.0, 8)?;
/// let sweep = Sweep::new(speeds).settle(0).measure(1).channels(&["q0"]);
/// let bits = |set| {
///     sweep.of(
///         &LaneRk4::new(63 * 16).instructions(set),
///         |p| NfgPair::new(&NfgParams { speed: p["speed"], ..NfgParams::table1() }),
///     ).run()
/// };
/// let baseline = bits(InstructionSet::Baseline)?.fingerprint();
/// for set in InstructionSet::available() {
///     assert_eq!(bits(set)?.fingerprint(), baseline);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum InstructionSet {
    /// The widest instructions of the processor, detected at run time. Default.
    #[default]
    Best,
    /// The instructions that every processor of the compilation target has.
    Baseline,
    /// AVX2. On an x86-64 processor without AVX2: as `Baseline`. On other architectures: as `Best`.
    Avx2,
}

impl InstructionSet {
    /// The variants that differ on this processor, the widest last.
    pub fn available() -> Vec<InstructionSet> {
        let mut sets = vec![InstructionSet::Baseline];
        #[cfg(target_arch = "x86_64")]
        {
            if pulp::x86::V3::try_new().is_some() {
                sets.push(InstructionSet::Avx2);
            }
            if pulp::x86::V4::try_new().is_some() {
                sets.push(InstructionSet::Best);
            }
        }
        #[cfg(not(target_arch = "x86_64"))]
        sets.push(InstructionSet::Best);
        sets
    }

    /// The corresponding architecture of the crate pulp.
    fn arch(self) -> Arch {
        match self {
            InstructionSet::Best => Arch::new(),
            InstructionSet::Baseline => Arch::Scalar,
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx2 => pulp::x86::V3::try_new().map_or(Arch::Scalar, Arch::V3),
            #[cfg(not(target_arch = "x86_64"))]
            InstructionSet::Avx2 => Arch::new(),
        }
    }

    /// Runs an operation that is compiled for these instructions.
    #[inline(always)]
    pub(crate) fn run<O: WithSimd>(self, operation: O) -> O::Output {
        self.arch().dispatch(operation)
    }
}
