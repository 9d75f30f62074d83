//! Seed and member of a process.

use crate::numeric::split_mix::CounterRng;

/// What the random numbers of a process depend on besides the stream. Default: seed 0, member 0.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Draws {
    pub(crate) seed: u64,
    pub(crate) member: u64,
}

impl Draws {
    /// The generator of a stream.
    pub(crate) fn stream(self, stream: u64) -> CounterRng {
        CounterRng::of_seed(self.seed).child(self.member).child(stream)
    }
}
