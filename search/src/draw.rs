//! The random numbers of one case.

/// Random numbers that are a function of seed, check and index alone.
pub struct Draw {
    state: u64,
    verbose: bool,
}

impl Draw {
    /// The numbers of one case. `verbose`: [`note`](Draw::note) prints.
    pub fn new(seed: u64, check: &str, index: u64, verbose: bool) -> Self {
        let name = check.bytes().fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
        Draw { state: mix(mix(seed ^ name) ^ mix(index)), verbose }
    }
    /// Prints a value that the case uses, if the case is run by name.
    pub fn note(&self, what: impl FnOnce() -> String) {
        if self.verbose {
            println!("  {}", what());
        }
    }
    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        (mix(self.state) >> 11) as f64 / (1u64 << 53) as f64
    }
    /// Uniform in [low, high).
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
    /// Uniform in the logarithm, in [low, high).
    pub fn scale(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.unit())
    }
    /// A whole number from 0 to n - 1.
    pub fn below(&mut self, n: usize) -> usize {
        ((self.unit() * n as f64) as usize).min(n - 1)
    }
    /// One of several values.
    pub fn one_of<T: Copy>(&mut self, values: &[T]) -> T {
        values[self.below(values.len())]
    }
}

/// Finalizer of SplitMix64.   Source: Steele, Lea & Flood, Proc. OOPSLA 2014, 453.
fn mix(x: u64) -> u64 {
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}
