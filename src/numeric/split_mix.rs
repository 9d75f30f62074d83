//! The generator SplitMix64.   Source: Steele, Lea and Flood, OOPSLA 2014.

use rand::TryRng;
use std::convert::Infallible;

/// What the state advances by.
pub(crate) const GOLDEN_GAMMA: u64 = 0x9e37_79b9_7f4a_7c15;

/// The number of a state.
pub(crate) fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Random numbers as a pure function of (seed, member, stream, index).
///
/// They are the SplitMix64 sequence from a start that is mixed from the four numbers. Numbers may be drawn in
/// any order. Results therefore do not depend on step sizes, threads or the partition of the work.
#[derive(Clone, Debug)]
pub(crate) struct CounterRng(u64);

impl CounterRng {
    /// The generator of these four numbers.
    pub(crate) fn new(seed: u64, member: u64, stream: u64, index: u64) -> Self {
        CounterRng::of_seed(seed).child(member).child(stream).child(index)
    }
    /// The generator of a seed alone.
    pub(crate) fn of_seed(seed: u64) -> Self {
        CounterRng(mix(seed.wrapping_add(GOLDEN_GAMMA)))
    }
    /// The generator of the numbers of this one and one more number.
    #[inline]
    pub(crate) fn child(&self, word: u64) -> Self {
        let word = mix(word.wrapping_add(GOLDEN_GAMMA).wrapping_mul(0xd134_2543_de82_ef95));
        CounterRng(mix(self.0.wrapping_add(GOLDEN_GAMMA) ^ word))
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(GOLDEN_GAMMA);
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

#[cfg(test)]
mod tests {
    use super::CounterRng;
    use rand::Rng;

    /// Number 5 before number 4; the values are the same on every platform.
    #[test]
    fn values_are_fixed() {
        assert_eq!(CounterRng::new(1, 2, 3, 5).next_u64(), 0xcfc0_0be6_e5b0_4057);
        assert_eq!(CounterRng::new(1, 2, 3, 4).next_u64(), 0x4d89_ae18_701f_b6f3);
    }
}
