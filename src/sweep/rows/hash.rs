//! Hashes that identify rows and sweeps.

use std::fmt;
use std::fmt::Debug;
use std::fmt::Write;

/// Hash of words w: h ← rotl((h ⊕ w) × prime mod 2⁶⁴, 23).
///
/// It is FNV-1a with 64-bit words instead of bytes. The multiplication moves information to higher bits only;
/// the rotation moves it back to lower bits.
#[derive(Clone, Copy)]
pub(crate) struct Hash(pub(crate) u64);

impl Hash {
    /// Hash of words.
    pub(crate) fn of_words(words: impl Iterator<Item = u64>) -> u64 {
        words.fold(Hash::new(), Hash::with).0
    }
    /// Hash of bytes, in words of eight bytes, and of their number.
    pub(crate) fn of_bytes(bytes: &[u8]) -> u64 {
        let word = |bytes: &[u8]| bytes.iter().rev().fold(0, |word, byte| word << 8 | u64::from(*byte));
        Hash::of_words(bytes.chunks(8).map(word).chain([bytes.len() as u64]))
    }
    /// Hash of the `Debug` text of a value. A new field of the type therefore changes the hash.
    pub(crate) fn of(value: &impl Debug) -> u64 {
        let mut hash = Hash::new();
        // Writing to a hash cannot fail.
        let _ = write!(hash, "{value:?}");
        hash.0
    }
    fn new() -> Self {
        Hash(0xcbf2_9ce4_8422_2325)
    }
    fn with(self, word: u64) -> Self {
        Hash((self.0 ^ word).wrapping_mul(0x0000_0100_0000_01b3).rotate_left(23))
    }
}

impl Write for Hash {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        *self = text.bytes().fold(*self, |hash, byte| hash.with(u64::from(byte)));
        Ok(())
    }
}
