//! One case: its random numbers, which are a function of seed, target and index alone, and its possible
//! results.

use std::fmt::Display;

/// The reason why a case ends early.
#[derive(Debug)]
pub enum Stop {
    /// An error of the crate: the intended answer to extreme values.
    Typed(String),
    /// A result that is NaN, or infinite although no infinity is documented.
    NotFinite(String),
    /// A promise that does not hold, for example a drive edge that is not later than the given time.
    Broken(String),
}

/// Any error of the crate ends a case as intended.
impl<E: std::error::Error> From<E> for Stop {
    fn from(error: E) -> Self {
        let text = error.to_string();
        if text.is_empty() { Stop::Broken("an error without a text".into()) } else { Stop::Typed(text) }
    }
}

/// The result of a target.
pub type Run = Result<(), Stop>;

/// Extreme numbers, to find values that are not checked.
const HOSTILE: [f64; 30] = [
    0.0,
    -0.0,
    5e-324,
    -5e-324,
    1e-310,
    f64::MIN_POSITIVE,
    1e-308,
    -1e-308,
    1e-200,
    1e-160,
    1e-100,
    1e-50,
    9e-51,
    1e-16,
    -1.0,
    1.0,
    9_007_199_254_740_993.0,
    1e50,
    -1e50,
    1e100,
    1e154,
    1e160,
    1e200,
    1e308,
    -1e308,
    f64::MAX,
    f64::MIN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::NAN,
];

/// Extreme counts, to find counts without a maximum.
const COUNTS: [usize; 13] = [
    0,
    1,
    2,
    3,
    1 << 12,
    1 << 24,
    u32::MAX as usize,
    1 << 32,
    1 << 53,
    1 << 62,
    1 << 63,
    usize::MAX - 1,
    usize::MAX,
];

/// The random numbers of one case: number n is a mix of seed, target, index and n.
pub struct Case {
    state: u64,
    /// Share of extreme values.
    temper: f64,
    verbose: bool,
    /// The last error that did not end the case.
    refused: Option<String>,
}

impl Case {
    /// Case `index` of a target. The share of extreme values is 0, 3 %, 10 % and 50 % in turn.
    pub fn new(seed: u64, target: &str, index: u64, verbose: bool) -> Self {
        let name = target.bytes().fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
        let state = mix(mix(seed ^ name) ^ mix(index));
        Case { state, temper: [0.0, 0.03, 0.1, 0.5][index as usize % 4], verbose, refused: None }
    }

    /// Prints a value that the case uses, if the case is run by name.
    pub fn note(&self, what: impl FnOnce() -> String) {
        if self.verbose {
            eprintln!("  {}", what());
        }
    }

    fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        mix(self.state)
    }
    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }
    /// Uniform in [-1, 1).
    pub fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }
    /// A whole number from 0 to n - 1.
    pub fn below(&mut self, n: usize) -> usize {
        (self.unit() * n as f64) as usize
    }
    /// True with this probability.
    pub fn chance(&mut self, p: f64) -> bool {
        self.unit() < p
    }
    /// An element of the list.
    pub fn pick<T: Clone>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())].clone()
    }
    /// A seed of any 64 bits.
    pub fn seed(&mut self) -> u64 {
        if self.hostile() { self.pick(&[0, 1, u64::MAX, 1 << 63]) } else { self.bits() }
    }
    /// Whether the next value is an extreme one.
    pub fn hostile(&mut self) -> bool {
        let temper = self.temper;
        self.chance(temper)
    }

    /// A value within a factor of e of a sensible one, or an extreme one.
    pub fn number(&mut self, sensible: f64) -> f64 {
        if !self.hostile() {
            return sensible * self.signed().exp();
        }
        match self.below(4) {
            0 => sensible * 10f64.powi(self.below(25) as i32 - 12),
            1 => -sensible,
            _ => self.pick(&HOSTILE),
        }
    }
    /// A value that a user's own code may contain: within the range of all quantities.
    pub fn quantity(&mut self, sensible: f64) -> f64 {
        let value = self.number(sensible);
        if value.abs() <= 1e50 { value } else { 1.0 }
    }
    /// A count between 1 and twice a sensible one, or an extreme one.
    pub fn count(&mut self, sensible: usize) -> usize {
        if self.hostile() { self.pick(&COUNTS) } else { self.effort(sensible) }
    }
    /// A count of work that is really done: at most twice a sensible one.
    pub fn effort(&mut self, sensible: usize) -> usize {
        if self.hostile() { self.below(2) } else { 1 + self.below(2 * sensible) }
    }
    /// A list of `length` numbers near a sensible value, or of another length.
    pub fn list(&mut self, length: usize, sensible: f64) -> Vec<f64> {
        let length = if self.hostile() { self.pick(&[0, 1, length + 1, length / 2]) } else { length };
        (0..length).map(|_| self.number(sensible) * if self.chance(0.3) { -1.0 } else { 1.0 }).collect()
    }
    /// Up to `most` pairs of cosine and sine amplitudes.
    pub fn pairs(&mut self, most: usize, sensible: f64) -> Vec<[f64; 2]> {
        (0..self.below(most + 1))
            .map(|_| [self.number(sensible), self.number(sensible) * self.signed()])
            .collect()
    }

    /// The accepted value. An error is stored, and the case goes on.
    pub fn accept<T, E: std::error::Error>(&mut self, result: Result<T, E>) -> Option<T> {
        result.map_err(|error| self.refused = Some(error.to_string())).ok()
    }
    /// The stored error.
    pub fn refused(self) -> Option<String> {
        self.refused
    }
}

/// Checks that a number is finite.
pub fn finite(what: impl Display, value: f64) -> Run {
    if value.is_finite() { Ok(()) } else { Err(Stop::NotFinite(format!("{what} is {value}"))) }
}

/// Checks that all numbers are finite.
pub fn all_finite(what: impl Display, values: &[f64]) -> Run {
    values.iter().enumerate().try_for_each(|(i, &value)| finite(format_args!("{what}[{i}]"), value))
}

/// Checks a promise.
pub fn holds(promise: bool, what: impl FnOnce() -> String) -> Run {
    if promise { Ok(()) } else { Err(Stop::Broken(what())) }
}

/// The finaliser of SplitMix64.   Source: Steele, Lea & Flood, OOPSLA 2014.
fn mix(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}
