//! Processes of a prescribed power density.

use crate::error::{ParameterError, check};
use crate::excitation::Side;
use crate::numeric::gauss;
use crate::numeric::sine::turned;
use crate::processes::draws::Draws;
use crate::processes::process::{Path, Process};
use crate::series::Series;
use rand_distr::{Distribution, UnitCircle};
use std::f64::consts::TAU;
use std::sync::Arc;

/// A process of a prescribed power density: a sum of harmonics with random phases.
///
/// ```text
/// x(t) = Σ_j a_j cos(2π f_j t + φ_j),   f_j = f0 + (j + 1/2) Δf,   a_j² / 2 = ∫ S df over cell j
/// mean 0,   variance Σ a_j²/2,   correlation Σ a_j² cos(2π f_j lag)/Σ a_j²
/// ```
///
/// The band f0 .. f1 is divided into N cells of the width Δf; the phases φ_j are uniform and independent.
/// Each path has the power of each cell exactly. For many cells x is Gaussian to a good approximation. The
/// path is smooth: it has no edges, and all its derivatives are exact.
///
/// After the recurrence time 1/Δf all harmonics have turned by the same angle relative to whole turns: x
/// repeats, for f0 = 0 with the other sign. A run that is longer learns nothing new from the process. An
/// evaluation takes N sines.
///
/// Source: Rice, Bell Syst. Tech. J. 23 (1944) 282; Shinozuka and Jan, J. Sound Vib. 25 (1972) 111.
///
/// ```
/// use gear_dynamics::{excitation::Side, processes::{Process, SpectralProcess}};
/// // A torque ripple: 0.5 (N m)²/Hz between 20 and 60 Hz, 200 harmonics.
/// let process = SpectralProcess::new(|_| 0.5, [20.0, 60.0], 200)?.seed(4);
/// assert!((process.variance().expect("closed form") - 20.0).abs() < 1e-12);
/// assert!((process.recurrence_time() - 5.0).abs() < 1e-12); // [s]
/// let path = process.path(0);
/// assert!((path.series(0.3, 24).at(1e-3) - path.at(0.301, Side::After)).abs() < 1e-12);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug)]
#[must_use = "a setting returns a new value"]
pub struct SpectralProcess {
    /// First frequency of the band, and width of a cell.
    start: f64,
    width: f64,
    /// a_j²/2.
    powers: Arc<[f64]>,
    draws: Draws,
}

/// Maximum number of harmonics. All are summed at every evaluation.
const HARMONICS: usize = 1 << 20;

impl SpectralProcess {
    /// A process with the one-sided density S(f) in the square of its unit per hertz, between two frequencies
    /// `[Hz]`, by this number of harmonics. Cells are integrated with 5 points. Defaults: seed 0, member 0.
    ///
    /// # Errors
    /// A density that is negative, not finite or beyond 1e50 at one of these points; a band whose first
    /// frequency is negative or not below the second; an angular frequency 2π f beyond 1e9; no harmonic or
    /// more than 2²⁰.
    pub fn new(
        density: impl Fn(f64) -> f64,
        band: [f64; 2],
        harmonics: usize,
    ) -> Result<Self, ParameterError> {
        check::at_least("harmonics", harmonics, 1)?;
        check::count("harmonics", &[harmonics], HARMONICS)?;
        let start = check::not_negative("first frequency of the band", band[0])?;
        check::positive("last frequency of the band", band[1])?;
        check::frequency("angular frequency of the end of the band", TAU * band[1])?;
        check::between("first frequency of the band", start, [0.0, band[1].next_down()])?;
        let width = check::above_zero("width of a cell", (band[1] - start) / harmonics as f64)?;
        let mut wrong = None;
        let mut power = |j: usize| {
            let from = start + j as f64 * width;
            gauss::integral(from, from + width, |f| {
                let value = check::not_negative(format!("density at {f:?} Hz"), density(f));
                value.unwrap_or_else(|error| {
                    wrong.get_or_insert(error);
                    0.0
                })
            })
        };
        let powers: Arc<[f64]> = (0..harmonics).map(&mut power).collect();
        wrong.map_or(Ok(SpectralProcess { start, width, powers, draws: Draws::default() }), Err)
    }

    /// A process whose density is the line through the points `(f [Hz], S)` of a table, between its first and
    /// its last frequency. See [`new`](SpectralProcess::new).
    ///
    /// # Errors
    /// Those of [`new`](SpectralProcess::new); fewer than two points; frequencies that do not increase.
    pub fn of_table(table: &[[f64; 2]], harmonics: usize) -> Result<Self, ParameterError> {
        check::at_least("points of the density", table.len(), 2)?;
        for (i, pair) in table.windows(2).enumerate() {
            check::positive(format!("frequency step after point {i}"), pair[1][0] - pair[0][0])?;
        }
        for [f, density] in table {
            check::not_negative(format!("density at {f:?} Hz"), *density)?;
        }
        let line = |f: f64| {
            let after = table.partition_point(|[known, _]| *known <= f).clamp(1, table.len() - 1);
            let [[f0, s0], [f1, s1]] = [table[after - 1], table[after]];
            let share = ((f - f0) / (f1 - f0)).clamp(0.0, 1.0);
            (1.0 - share) * s0 + share * s1
        };
        SpectralProcess::new(line, [table[0][0], table[table.len() - 1][0]], harmonics)
    }
    /// The same process with another seed, for an independent experiment. Default: 0.
    pub fn seed(self, seed: u64) -> Self {
        SpectralProcess { draws: Draws { seed, ..self.draws }, ..self }
    }
    /// The same process for another member of an ensemble with the same seed. Default: 0.
    pub fn member(self, member: u64) -> Self {
        SpectralProcess { draws: Draws { member, ..self.draws }, ..self }
    }
    /// The recurrence time 1/Δf `[s]`.
    pub fn recurrence_time(&self) -> f64 {
        1.0 / self.width
    }

    fn frequency(&self, j: usize) -> f64 {
        self.start + (j as f64 + 0.5) * self.width
    }
}

impl Process for SpectralProcess {
    fn path(&self, stream: u64) -> Arc<dyn Path> {
        let stream = self.draws.stream(stream);
        let harmonic = |(j, power): (usize, &f64)| {
            let phase: [f64; 2] = UnitCircle.sample(&mut stream.child(j as u64));
            let amplitude = (2.0 * power).sqrt();
            Harmonic { turn: TAU * self.frequency(j), start: phase.map(|x| amplitude * x) }
        };
        let harmonics = self.powers.iter().enumerate().map(harmonic).collect();
        Arc::new(Harmonics { harmonics, spacing: TAU * self.width })
    }
    fn mean(&self) -> Option<f64> {
        Some(0.0)
    }
    fn variance(&self) -> Option<f64> {
        Some(self.powers.iter().sum())
    }
    /// `None` if no cell has power.
    fn correlation(&self, lag: f64) -> Option<f64> {
        let cosine = |(j, power): (usize, &f64)| power * libm::cos(TAU * self.frequency(j) * lag);
        let variance = self.variance().filter(|variance| *variance > 0.0)?;
        Some(self.powers.iter().enumerate().map(cosine).sum::<f64>() / variance)
    }
    /// The mean density of the cell of this frequency; 0 outside of the band.
    fn density(&self, frequency: f64) -> Option<f64> {
        let cell = ((frequency - self.start) / self.width).floor();
        let power = (cell >= 0.0).then(|| self.powers.get(cell as usize)).flatten();
        Some(power.map_or(0.0, |power| power / self.width))
    }
}

/// One harmonic: its angular frequency, and a cos φ, a sin φ.
struct Harmonic {
    turn: f64,
    start: [f64; 2],
}

/// A path.
struct Harmonics {
    harmonics: Vec<Harmonic>,
    /// Difference of neighbouring angular frequencies.
    spacing: f64,
}

/// Number of harmonics that share one evaluation of sine and cosine. The others follow by rotations.
const SHARING: usize = 32;

impl Harmonics {
    /// Calls `f` for each harmonic with its angular frequency, and a cos and a sin of its angle at `t`.
    #[inline]
    fn each(&self, t: f64, mut f: impl FnMut(f64, [f64; 2])) {
        let next = libm::sincos(self.spacing * t);
        for group in self.harmonics.chunks(SHARING) {
            let (mut s, mut c) = libm::sincos(group[0].turn * t);
            for Harmonic { turn, start: [a, b] } in group {
                f(*turn, [a * c - b * s, a * s + b * c]);
                (s, c) = turned((s, c), next);
            }
        }
    }
}

impl Path for Harmonics {
    fn at(&self, t: f64, _: Side) -> f64 {
        let mut sum = 0.0;
        self.each(t, |_, [cosine, _]| sum += cosine);
        sum
    }
    fn next_edge(&self, _: f64) -> Option<f64> {
        None
    }
    fn series(&self, t: f64, coefficients: usize) -> Series {
        let like = Series::variable(0.0, 0.0, coefficients);
        let mut sums = [0.0; Series::CAPACITY];
        self.each(t, |turn, [cosine, sine]| {
            let (mut pair, mut weight) = ([cosine, -sine], 1.0);
            for (n, sum) in sums[..coefficients.min(Series::CAPACITY)].iter_mut().enumerate() {
                *sum += weight * pair[0];
                pair = [pair[1], -pair[0]];
                weight *= turn / (n + 1) as f64;
            }
        });
        Series::from_coefficients(&like, |n| sums[n])
    }
}
