//! The hash of rows.

/// Hash of words w: h ← rotl((h ⊕ w) × prime mod 2⁶⁴, 23).
///
/// It is FNV-1a with 64-bit words instead of bytes. The multiplication moves information to higher bits only;
/// the rotation moves it back to lower bits.
#[derive(Clone, Copy)]
pub(crate) struct Hash(u64);

impl Hash {
    /// Hash of words.
    pub(crate) fn of_words(words: impl Iterator<Item = u64>) -> u64 {
        words.fold(Hash::new(), Hash::with).0
    }
    fn new() -> Self {
        Hash(0xcbf2_9ce4_8422_2325)
    }
    fn with(self, word: u64) -> Self {
        Hash((self.0 ^ word).wrapping_mul(0x0000_0100_0000_01b3).rotate_left(23))
    }
}
