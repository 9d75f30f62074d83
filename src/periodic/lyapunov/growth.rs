//! Growth of one direction along a run, with its standard error.

use std::collections::VecDeque;
use std::f64::consts::PI;

/// Logarithms of the growth of one direction: for each period, and for each part of a period at both ends of
/// the measured span.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Growth {
    pub(crate) periods: Vec<f64>,
    /// Cumulative growth, averaged over the parts of each period. The average removes the fluctuation of a
    /// rotating direction within the period.
    averages: Vec<f64>,
    /// Cumulative growth, its sum over the parts of the current period, and its value at the start of that
    /// period.
    whole: f64,
    sum: f64,
    begun: f64,
    /// Number of parts of a period.
    parts: usize,
    /// Growth of the last parts before the span, at most `reach` periods, from the second half of the
    /// alignment.
    before: VecDeque<f64>,
    /// Growth of the first and of the last parts of the span, at most `reach` periods.
    first: Vec<f64>,
    tail: VecDeque<f64>,
    /// Maximum number of periods inspected at each end.
    reach: usize,
    /// Angle by which the direction has turned from period to period `[rad]`, over each quarter of the
    /// measured periods.
    turned: [f64; 4],
    /// The same from part to part: a direction that turns once in a period stands still from period to
    /// period.
    path: f64,
    /// Number of periods to measure.
    planned: usize,
}

/// Maximum number of periods inspected at each end of the span: an eighth of the periods, at least the
/// first and at most the second number.
const ENDS: [usize; 2] = [8, 1024];

/// Largest angle, over a run, of a direction that is still on its first turn `[rad]`.
const TURN: f64 = PI;

/// A direction comes to rest if it turns in the last quarter of a run by less than this share of its angle in
/// the third quarter `[1]`. The first half may contain a fast turn to a direction that drifts slowly on.
const COMES_TO_REST: f64 = 0.5;

/// Angle of a direction that does not turn `[rad]`: errors of the flow.
const STILL: f64 = 1e-6;

/// Maximum number of tapers, and number of periods per taper.
const TAPERS: usize = 16;

const PERIODS: usize = 5;

/// Two standard errors in units of the standard deviation: for a sine of random phase (kurtosis 1.5, maximum
/// √2) and for a normal variable (kurtosis 3). They contain 92 % and 95 % of the values.
const SINE: f64 = 1.404;

const NORMAL: f64 = 2.0;

/// Half of the 97.725 % quantile of Student's t for 1, 2, ... degrees of freedom: two standard errors contain
/// 95.45 %.   Source: GUM (JCGM 100:2008), Table G.2.
#[rustfmt::skip]
const STUDENT: [f64; TAPERS - 1] = [
    6.985, 2.265, 1.655, 1.435, 1.325, 1.26, 1.215, 1.185, 1.16, 1.14, 1.125, 1.115, 1.105, 1.10, 1.09,
];

impl Growth {
    /// `planned`: number of periods to measure.
    pub(crate) fn new(parts: usize, planned: usize) -> Self {
        Growth {
            periods: Vec::new(),
            averages: Vec::new(),
            whole: 0.0,
            sum: 0.0,
            begun: 0.0,
            parts,
            before: VecDeque::new(),
            first: Vec::new(),
            tail: VecDeque::new(),
            reach: (planned / 8).clamp(ENDS[0], ENDS[1]),
            turned: [0.0; 4],
            path: 0.0,
            planned,
        }
    }

    /// Adds the growth of one part before the span. The caller omits the first half of the alignment, in
    /// which the directions are not aligned yet.
    pub(crate) fn align(&mut self, growth: f64) {
        self.before.push_back(growth);
        if self.before.len() > self.reach * self.parts {
            self.before.pop_front();
        }
    }
    /// Adds the growth of one part of the span.
    pub(crate) fn measure(&mut self, growth: f64) {
        if self.first.len() < self.reach * self.parts {
            self.first.push(growth);
        }
        self.tail.push_back(growth);
        if self.tail.len() > self.reach * self.parts {
            self.tail.pop_front();
        }
        self.whole += growth;
        self.sum += self.whole;
    }
    /// Adds the angle by which the direction turned in one part of the span.
    pub(crate) fn turn(&mut self, angle: f64) {
        self.path += angle;
    }
    /// Closes one period of the span, over which the direction turned by `angle`.
    pub(crate) fn period(&mut self, angle: f64) {
        let quarter = (4 * self.periods.len()).checked_div(self.planned).unwrap_or(0);
        self.turned[quarter.min(3)] += angle;
        self.periods.push(self.whole - self.begun);
        self.averages.push(self.sum / self.parts as f64);
        (self.begun, self.sum) = (self.whole, 0.0);
    }

    /// Mean growth per period; NaN without periods.
    pub(crate) fn mean(&self) -> f64 {
        if self.periods.is_empty() {
            f64::NAN
        } else {
            self.periods.iter().sum::<f64>() / self.periods.len() as f64
        }
    }

    /// Standard error of the mean: the interval of ± two standard errors contains the exponent in 95 % of all
    /// cases. Infinite with fewer than three periods, or if the direction is still on its first turn.
    pub(crate) fn error(&self) -> f64 {
        if self.periods.len() < 3 || self.is_on_first_turn() {
            return f64::INFINITY;
        }
        self.diffusion().hypot(self.ends()).max(self.trend())
    }

    /// Whether the direction has turned by less than half a turn and does not come to rest: the run is
    /// shorter than the time in which the direction finds its growth.
    fn is_on_first_turn(&self) -> bool {
        let [.., third, fourth] = self.turned;
        self.path < TURN && third + fourth > STILL && fourth > COMES_TO_REST * third
    }

    /// The mean of the second half of the periods minus the mean of all of them: growth that falls like 1/t
    /// has not yet reached its limit, and no scatter shows it.
    fn trend(&self) -> f64 {
        let half = &self.periods[self.periods.len() / 2..];
        (half.iter().sum::<f64>() / half.len() as f64 - self.mean()).abs()
    }

    /// t √(S/N), S = Σ_k (Σ_i w_ki (g_i - ḡ))²/(K - Σ_k (Σ_i w_ki)²/(N - 1)): the error by the scatter of the
    /// growth.
    ///
    /// g_i is the growth from period to period, N the number of periods, w_k the first K sine tapers, S the
    /// spectral density of the growth at frequency 0, and t the entry of [`STUDENT`] for K - 1 degrees of
    /// freedom. The error is valid if the growth is correlated over less than about 1/K of the span. The
    /// tapers end in zero, so that the rotation of a direction at the ends does not contribute. Source:
    /// Riedel & Sidorenko, IEEE Trans. Signal Process. 43, 188 (1995).
    fn diffusion(&self) -> f64 {
        let steps: Vec<f64> = self.averages.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let n = steps.len();
        let mean = steps.iter().sum::<f64>() / n as f64;
        let count = (n / PERIODS).clamp(2, TAPERS);
        let unit = PI / (n + 1) as f64;
        let (mut square, mut freedom) = (0.0, count as f64);
        for k in 1..=count {
            let (mut part, mut weight) = (0.0, 0.0);
            for (i, growth) in steps.iter().enumerate() {
                let taper = (2.0 / (n + 1) as f64).sqrt() * (unit * (k * (i + 1)) as f64).sin();
                part += taper * (growth - mean);
                weight += taper;
            }
            square += part * part;
            freedom -= weight * weight / n as f64;
        }
        STUDENT[count - 2] * (square / freedom / (n + 1) as f64).sqrt()
    }

    /// c σ/(2 length): the error by the ends of the span.
    ///
    /// A rotating direction grows unevenly, so the mean depends on its angle at the start and at the end of
    /// the span. σ is the standard deviation of the growth over spans of equal length that are moved back
    /// part by part. The factor c of two standard errors is interpolated linearly in the kurtosis between
    /// [`SINE`] and [`NORMAL`].
    fn ends(&self) -> f64 {
        let periods = self.periods.len();
        // Number of moves: an eighth of the span. If that many parts before the span are known, the span is
        // moved back. Otherwise it is shortened by the moves.
        let eighth = self.parts * (periods / 8).clamp(1, self.reach);
        let moved = self.before.len() >= eighth;
        let moves = if moved { self.before.len().min(self.tail.len()) } else { eighth };
        let length = periods as f64 - if moved { 0.0 } else { moves as f64 / self.parts as f64 };
        let (before, tail) = (self.before.len(), self.tail.len());
        // sums[i]: growth over the span moved back by i parts minus growth over the last span.
        let gained = |i: usize| if moved { self.before[before - i] } else { self.first[moves - i] };
        let sums = (1..=moves).scan(0.0, |sum, i| {
            *sum += gained(i) - self.tail[tail - i];
            Some(*sum)
        });
        let sums: Vec<f64> = std::iter::once(0.0).chain(sums).collect();
        let moment = |about: f64, power: i32| {
            sums.iter().map(|sum| (sum - about).powi(power)).sum::<f64>() / sums.len() as f64
        };
        let middle = moment(0.0, 1);
        let square = moment(middle, 2);
        let kurtosis =
            if square > 0.0 { (moment(middle, 4) / (square * square)).clamp(1.5, 3.0) } else { 3.0 };
        let two = SINE + (NORMAL - SINE) * (kurtosis - 1.5) / 1.5;
        0.5 * two * square.sqrt() / length
    }
}
