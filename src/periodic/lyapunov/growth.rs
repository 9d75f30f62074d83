//! How fast one direction grows along a run, and how well that is known.

use std::collections::VecDeque;
use std::f64::consts::PI;

/// Logarithms of the growth of one direction: period by period, and part by part at both ends of the span that is measured.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Growth {
    pub(crate) periods: Vec<f64>,
    /// The whole growth, averaged over each period: a direction that turns shows in it no more than its mean.
    averages: Vec<f64>,
    /// The whole growth, its sum over the period under way, and its value where that begins.
    whole: f64,
    sum: f64,
    begun: f64,
    /// Parts of a period.
    parts: usize,
    /// The parts before the span, up to [`ENDS`] periods of them, once directions are half aligned; of a run that has none, the first ones of
    /// the span.
    head: VecDeque<f64>,
    /// Whether the head lies before the span.
    before: bool,
    /// The last parts of the span, as many as there are in the head.
    tail: VecDeque<f64>,
}

/// Most periods looked at before the span and at its end.
const ENDS: usize = 8;

/// Most tapers, and the periods that one of them needs.
const TAPERS: usize = 16;

const PERIODS: usize = 5;

/// Two errors, in units of the standard deviation: of a sine of random phase, whose kurtosis is 1.5 and whose largest value √2, and of a normal
/// variable, whose kurtosis is 3. Both hold 93 to 95 %.
const SINE: f64 = 1.404;

const NORMAL: f64 = 2.0;

/// Half of the 97.725 % quantile of Student's t for 1, 2, ... degrees of freedom: two errors hold 95.45 %.   Source: GUM (JCGM 100:2008),
/// Table G.2.
#[rustfmt::skip]
const STUDENT: [f64; TAPERS - 1] = [
    6.985, 2.265, 1.655, 1.435, 1.325, 1.26, 1.215, 1.185, 1.16, 1.14, 1.125, 1.115, 1.105, 1.10, 1.09,
];

impl Growth {
    pub(crate) fn new(parts: usize) -> Self {
        let (periods, averages, head, tail) = (Vec::new(), Vec::new(), VecDeque::new(), VecDeque::new());
        Growth { periods, averages, whole: 0.0, sum: 0.0, begun: 0.0, parts, head, before: false, tail }
    }

    /// A part before the span. Those of the first half of all periods to align tell of directions that are not aligned yet.
    pub(crate) fn align(&mut self, growth: f64) {
        self.before = true;
        self.head.push_back(growth);
        if self.head.len() > ENDS * self.parts {
            self.head.pop_front();
        }
    }
    /// A part of the span.
    pub(crate) fn measure(&mut self, growth: f64) {
        if !self.before && self.head.len() < ENDS * self.parts {
            self.head.push_back(growth);
        }
        self.tail.push_back(growth);
        if self.tail.len() > ENDS * self.parts {
            self.tail.pop_front();
        }
        self.whole += growth;
        self.sum += self.whole;
    }
    /// A period of the span is over.
    pub(crate) fn period(&mut self) {
        self.periods.push(self.whole - self.begun);
        self.averages.push(self.sum / self.parts as f64);
        (self.begun, self.sum) = (self.whole, 0.0);
    }

    /// Per period.
    pub(crate) fn mean(&self) -> f64 {
        if self.periods.is_empty() {
            f64::NAN
        } else {
            self.periods.iter().sum::<f64>() / self.periods.len() as f64
        }
    }

    /// The standard error of the mean: two of them hold it in 95 % of all cases. Infinite with fewer than three periods.
    pub(crate) fn error(&self) -> f64 {
        if self.periods.len() < 3 { f64::INFINITY } else { self.diffusion().hypot(self.ends()) }
    }

    /// What chance does: the spectrum of the growth at frequency 0, from its projections on the first K sine tapers, over the length of the
    /// span, with Student's t for K - 1 degrees of freedom. It holds if growth is correlated for less than about 1/K of the span. Tapers
    /// end in zero, so that they do not see a direction turn.   Source: Riedel & Sidorenko, IEEE Trans. Signal Process. 43, 188 (1995).
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

    /// What the ends of the span do: a direction that turns grows by fits and starts, and a mean depends on where in a turn it begins and ends. The
    /// scatter of the means over spans of the same length, moved back part by part.
    fn ends(&self) -> f64 {
        let periods = self.periods.len();
        // Before the span all that is there; within it the span has to be shortened.
        let moves = if self.before {
            self.head.len().min(self.tail.len())
        } else {
            self.parts * (periods / 8).clamp(1, ENDS)
        };
        let length =
            if self.before { periods as f64 } else { periods as f64 - moves as f64 / self.parts as f64 };
        let (head, tail) = (self.head.len(), self.tail.len());
        // The sum over a span without that over the last one.
        let gained = |i: usize| if self.before { self.head[head - i] } else { self.head[moves - i] };
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
