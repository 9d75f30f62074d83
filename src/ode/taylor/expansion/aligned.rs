//! Numbers in lines of the cache.

use crate::ode::taylor::expansion::rows::{EIGHT, Eight};
use std::ops::{Deref, DerefMut};

/// Bytes of a line of the cache.
const LINE: usize = 64;

/// Blocks of eight numbers, each in one line of the cache.
#[derive(Debug, Default)]
pub(crate) struct Aligned {
    numbers: Vec<f64>,
    first: usize,
    count: usize,
}

impl Aligned {
    /// This number of blocks of zeros.
    pub(crate) fn new(count: usize) -> Self {
        let numbers = vec![0.0; EIGHT * (count + 1)];
        let first = numbers.as_ptr().align_offset(LINE).min(EIGHT);
        Aligned { numbers, first, count }
    }
}

impl Deref for Aligned {
    type Target = [Eight];
    #[inline(always)]
    fn deref(&self) -> &[Eight] {
        self.numbers[self.first..][..EIGHT * self.count].as_chunks().0
    }
}

impl DerefMut for Aligned {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [Eight] {
        self.numbers[self.first..][..EIGHT * self.count].as_chunks_mut().0
    }
}
