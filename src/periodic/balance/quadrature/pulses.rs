//! Pulses of the drives that lie between the nodes of a quadrature.

use crate::contact::Piece;
use crate::model::Periodic;
use crate::numeric::gauss::ten;
use crate::numeric::lagrange::lagrange;
use crate::ode::budget::Meter;
use crate::periodic::balance::amplitudes::sizes;
use crate::periodic::balance::fourier_orbit::FourierOrbit;
use crate::periodic::balance::quadrature::panel_points::{drive_edges, panels};
use crate::periodic::balance::quadrature::resolution::DriveSampler;
use crate::periodic::balance::series::harmonics::Harmonics;

/// Number of instants of a period at which the drives are searched. Every pulse wider than 1/130 000 of the
/// period contains one of them.
const SEARCHED_INSTANTS: usize = 1 << 17;

/// Smallest departure of a pulse from the interpolation on the panels, as a share of the largest value at
/// their nodes `[1]`. A smaller departure over 1e-5 of the period changes the integrals by less than 1e-8.
const DEPARTS: f64 = 1e-3;

/// Halving ends when it changes the integrals by at most this share `[1]`.
const HALVES_AGREE: f64 = 1e-12;

/// Maximum number of halvings of a pulse. Its parts then reach the rounding of time.
const DEEPEST: usize = 40;

/// Maximum number of ends of panels of one pulse.
const MAX_ENDS_OF_A_PULSE: usize = 1 << 12;

/// Maximum number of ends of panels of all pulses together.
const MAX_ENDS: usize = 1 << 16;

/// Ends of additional panels within one span. They resolve pulses of the drives that lie between the nodes of
/// the panels for the kept orders and the orders of the drives.
pub(crate) fn pulses(
    model: &dyn Periodic,
    near: &FourierOrbit,
    harmonics: &Harmonics,
    meter: &Meter<'_>,
) -> Vec<f64> {
    let (size, period) = (sizes(near), model.period());
    let rates: Vec<f64> =
        size.iter().map(|s| s * near.frequency() * harmonics.highest().max(1) as f64).collect();
    let fixed = (model.contacts() > 0 && model.offers().pieces).then(|| vec![Piece::Upper; model.contacts()]);
    let mut drives = DriveSampler::new(model, [&size, &rates], vec![fixed], Some(meter));
    let mut breaks = drive_edges(model, period);
    breaks.extend([0.0, period]);
    breaks.sort_by(f64::total_cmp);
    let order =
        drives.panel_order(&breaks, period, harmonics.highest().div_ceil(harmonics.period_multiple()).max(8));
    let within = SignalReader { drives, period }.ends(&breaks, order);
    (0..harmonics.period_multiple())
        .flat_map(|k| within.iter().map(move |end| k as f64 * period + end))
        .collect()
}

/// Search for pulses in one period.
struct SignalReader<'m> {
    drives: DriveSampler<'m>,
    period: f64,
}

impl SignalReader<'_> {
    /// Ends of the additional panels within one period.
    fn ends(&mut self, breaks: &[f64], order: usize) -> Vec<f64> {
        let panels: Vec<(f64, f64)> = panels(breaks, self.period, order).collect();
        let signals = self.drives.signals();
        let nodes = ten();
        let basis = lagrange(nodes.map(|(node, _)| node));
        // Interpolating polynomial of every signal on every panel: coefficients of x^m, x in [-1, 1].
        let (mut foreseen, mut largest) =
            (vec![vec![[0.0; 10]; signals]; panels.len()], vec![0.0f64; signals]);
        let mut now = vec![0.0; signals];
        for (foreseen, &(middle, half)) in foreseen.iter_mut().zip(&panels) {
            for ((node, _), basis) in nodes.iter().zip(&basis) {
                self.drives.read(middle + half * node, None, &mut now);
                for ((foreseen, largest), x) in foreseen.iter_mut().zip(&mut largest).zip(&now) {
                    *largest = largest.max(x.abs());
                    foreseen.iter_mut().zip(basis).for_each(|(p, b)| *p += x * b);
                }
            }
        }
        let apart = self.period / SEARCHED_INSTANTS as f64;
        let mut ends = Vec::new();
        // Start and end of the last pulse. Departures at neighbouring instants extend it.
        let mut pulse: Option<(f64, f64)> = None;
        let mut done = |pulse: Option<(f64, f64)>, signals: &mut Self| {
            if let Some((start, end)) = pulse {
                ends.extend([start, end]);
                let most = (ends.len() + MAX_ENDS_OF_A_PULSE).min(MAX_ENDS);
                signals.halve((start, end), &largest, 0, most, &mut ends);
            }
        };
        for (foreseen, &(middle, half)) in foreseen.iter().zip(&panels) {
            let first = ((middle - half) / apart - 0.5).ceil().max(0.0) as usize;
            for instant in first.. {
                let t = (instant as f64 + 0.5) * apart;
                if t >= middle + half {
                    break;
                }
                self.drives.read(t, None, &mut now);
                let x = (t - middle) / half;
                let departs = now.iter().zip(foreseen).zip(&largest).any(|((now, p), largest)| {
                    (now - p.iter().rev().fold(0.0, |sum, p| sum * x + p)).abs() > DEPARTS * largest
                });
                if !departs {
                    continue;
                }
                let (start, end) = ((t - apart).max(middle - half), (t + apart).min(middle + half));
                pulse = match pulse {
                    Some((begun, until)) if start <= until => Some((begun, end)),
                    before => {
                        done(before, self);
                        Some((start, end))
                    }
                };
            }
        }
        done(pulse, self);
        ends
    }

    /// Halves an interval, and its halves again, at least three times and until the integrals no longer
    /// change or a limit is reached.
    fn halve(
        &mut self,
        (start, end): (f64, f64),
        largest: &[f64],
        depth: usize,
        most: usize,
        ends: &mut Vec<f64>,
    ) {
        let middle = 0.5 * (start + end);
        if depth >= DEEPEST || ends.len() >= most || middle <= start || middle >= end {
            return;
        }
        let ([whole, _], [first, size], [second, more]) =
            (self.integrals(start, end), self.integrals(start, middle), self.integrals(middle, end));
        let settled = |s: usize| {
            let all = (largest[s] * self.period).max(size[s] + more[s]);
            (whole[s] - first[s] - second[s]).abs() <= HALVES_AGREE * all
        };
        if depth > 2 && (0..largest.len()).all(settled) {
            return;
        }
        ends.push(middle);
        self.halve((start, middle), largest, depth + 1, most, ends);
        self.halve((middle, end), largest, depth + 1, most, ends);
    }

    /// ∫ f dt and ∫ |f| dt of every signal by one panel of ten Gauss points.
    fn integrals(&mut self, start: f64, end: f64) -> [Vec<f64>; 2] {
        let signals = self.drives.signals();
        let (mut sums, mut now) = ([vec![0.0; signals], vec![0.0; signals]], vec![0.0; signals]);
        let (middle, half) = (0.5 * (start + end), 0.5 * (end - start));
        for (node, weight) in ten() {
            self.drives.read(middle + half * node, None, &mut now);
            for (s, x) in now.iter().enumerate() {
                sums[0][s] += weight * half * x;
                sums[1][s] += weight * half * x.abs();
            }
        }
        sums
    }
}
