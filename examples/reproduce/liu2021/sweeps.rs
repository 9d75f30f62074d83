//! Sweeps over one parameter, and their evaluation in words.

use super::super::support::{Outcome, coarse};
use super::motions::{Point, converged, paper, paper_orbit, paper_point};
use gear_dynamics::models::nfg::NfgReading;
use gear_dynamics::periodic::FourierOrbit;
use gear_dynamics::{NfgPair, NfgParams, RattleState};

/// A sweep over one parameter.
pub struct Sweep {
    pub file: &'static str,
    pub figure: &'static str,
    pub parameter: &'static str,
    pub axis: &'static str,
    pub from: f64,
    pub to: f64,
    /// Number of intervals for P and for the converged sweeps.
    pub intervals: [usize; 2],
    pub speed: f64,
    pub with: fn(f64, NfgParams) -> NfgParams,
}

pub const fn stiffness(speed: f64) -> Sweep {
    Sweep {
        file: "stiffness",
        figure: "Fig. 14",
        parameter: "a_k",
        axis: "a_k = k_r/k0 [1]",
        from: 0.1,
        to: 0.8,
        intervals: [14, 7],
        speed,
        with: |x, p| NfgParams { stiffness_harmonics: vec![[x * p.stiffness, 0.0]], ..p },
    }
}

pub const SWEEPS: [Sweep; 8] = [
    Sweep {
        file: "speed",
        figure: "Fig. 11",
        parameter: "omega_1",
        axis: "ω1 [rad/s]",
        from: 100.0,
        to: 250.0,
        intervals: [300, 60],
        speed: f64::NAN,
        with: |x, p| NfgParams { speed: x, ..p },
    },
    Sweep {
        file: "load",
        figure: "Fig. 15",
        parameter: "T_2",
        axis: "T2 [N m]",
        from: 0.0,
        to: 40.0,
        intervals: [80, 40],
        speed: 125.0,
        with: |x, p| NfgParams { load_torque: x, ..p },
    },
    Sweep {
        file: "error",
        figure: "Fig. 12",
        parameter: "e_r",
        axis: "e_r [m]",
        from: 0.0,
        to: 3e-5,
        intervals: [60, 15],
        speed: 160.0,
        with: |x, p| NfgParams { error_harmonics: vec![[0.0, x]], ..p },
    },
    Sweep {
        file: "eccentricity",
        figure: "Fig. 13",
        parameter: "epsilon",
        axis: "ε [1]",
        from: 0.0,
        to: 0.4,
        intervals: [80, 20],
        speed: 160.0,
        with: |x, p| NfgParams { eccentric_ratio: x, ..p },
    },
    stiffness(140.0),
    stiffness(145.0),
    stiffness(160.0),
    Sweep {
        file: "circular",
        figure: "Fig. 13b, ε = 0",
        parameter: "omega_1",
        axis: "ω1 [rad/s]",
        from: 100.0,
        to: 250.0,
        intervals: [60, 60],
        speed: f64::NAN,
        with: |x, p| NfgParams { speed: x, eccentric_ratio: 0.0, ..p },
    },
];

impl Sweep {
    pub fn title(&self) -> String {
        if self.speed.is_nan() {
            self.figure.into()
        } else {
            format!("{}, {} rad/s", self.figure, self.speed)
        }
    }
    /// The speed of the pinion at a value of the parameter `[rad/s]`.
    pub fn speed_at(&self, x: f64) -> f64 {
        if self.speed.is_nan() { x } else { self.speed }
    }
    /// Number of intervals of a reading.
    pub fn intervals(&self, reading: usize) -> usize {
        if coarse() { [4, 1][reading.min(1)] } else { self.intervals[reading.min(1)] }
    }
    pub fn value(&self, i: usize, intervals: usize) -> f64 {
        let x = self.from + (self.to - self.from) * i as f64 / intervals as f64;
        (1e9 * x).round() / 1e9
    }
    pub fn pair(&self, reading: usize, x: f64) -> Outcome<NfgPair> {
        let base = NfgParams::table1();
        let speed = if self.speed.is_nan() { base.speed } else { self.speed };
        let equations = if reading == EXACT { NfgReading::exact() } else { NfgReading::published() };
        Ok(NfgPair::of_reading(&(self.with)(x, NfgParams { speed, ..base }), equations)?)
    }
}

/// The readings: the balance of Liu 2021; converged motions of the published equations; converged motions of
/// the exact equations.
pub const READINGS: [&str; 3] = ["P", "published", "exact"];
const EXACT: usize = 2;

pub const BRANCHES: [&str; 2] = ["up", "down"];

/// Number of branches: upwards only in a short run.
pub fn branches() -> usize {
    if coarse() { 1 } else { BRANCHES.len() }
}

/// Follows the orbit of P from one value of the parameter to another, with halved steps if Newton fails;
/// `None` at a fold.
pub fn carry(
    sweep: &Sweep,
    orbit: &FourierOrbit,
    from: f64,
    to: f64,
    halvings: usize,
) -> Outcome<Option<FourierOrbit>> {
    if let Ok(orbit) = paper()?.solve(&sweep.pair(0, to)?, orbit) {
        return Ok(Some(orbit));
    }
    if halvings == 0 {
        return Ok(None);
    }
    let middle = 0.5 * (from + to);
    match carry(sweep, orbit, from, middle, halvings - 1)? {
        Some(orbit) => carry(sweep, &orbit, middle, to, halvings - 1),
        None => Ok(None),
    }
}

/// The points of one sweep for one reading and direction, in ascending order of the parameter; `None` if no
/// orbit was found.
pub fn follow(
    sweep: &Sweep,
    reading: usize,
    branch: usize,
    tick: impl Fn(),
) -> Outcome<Vec<(f64, Option<Point>)>> {
    let n = sweep.intervals(reading);
    let mut orbit: Option<(f64, FourierOrbit)> = None;
    let mut motion = None;
    let mut points = Vec::new();
    for i in 0..=n {
        let x = sweep.value(if branch == 0 { i } else { n - i }, n);
        let pair = sweep.pair(reading, x)?;
        let point = if reading == 0 {
            let carried = match orbit.take() {
                Some((before, orbit)) => carry(sweep, &orbit, before, x, 6)?,
                None => None,
            };
            let next = if carried.is_some() { carried } else { paper_orbit(&pair)? };
            let point = next.as_ref().map(|orbit| paper_point(&pair, orbit)).transpose()?;
            orbit = next.map(|orbit| (x, orbit));
            point
        } else {
            let (next, point) = converged(&pair, motion.as_ref())?;
            motion = Some(next);
            Some(point)
        };
        points.push((x, point));
        tick();
    }
    if branch == 1 {
        points.reverse();
    }
    Ok(points)
}

/// Intervals of equal words along a sweep, for example `none 100..152.25, unilateral 152.5..160`; at most
/// `most` of them.
pub fn spans(points: &[(f64, Option<Point>)], word: impl Fn(&Point) -> String, most: usize) -> String {
    let mut runs: Vec<(String, f64, f64)> = Vec::new();
    for (x, point) in points {
        let here = point.as_ref().map_or("no orbit".into(), &word);
        match runs.last_mut().filter(|(before, ..)| *before == here) {
            Some((.., last)) => *last = *x,
            None => runs.push((here, *x, *x)),
        }
    }
    let mut list: Vec<String> =
        runs.iter().take(most).map(|(word, a, b)| format!("{word} {a}..{b}")).collect();
    if runs.len() > most {
        list.push(format!("and {} more intervals", runs.len() - most));
    }
    list.join(", ")
}

/// The onset of bilateral rattle, where a bilateral point follows another: where, and the growth of the
/// peak-to-peak values of q and f(q).
pub fn onset(points: &[(f64, Option<Point>)]) -> Vec<String> {
    let known = known(points);
    let first = known
        .windows(2)
        .find(|w| w[0].1.state != RattleState::Bilateral && w[1].1.state == RattleState::Bilateral);
    let Some(w) = first else { return vec!["nowhere".into(), "-".into(), "-".into()] };
    let ([a, b], [x0, x1]) = ([w[0].1, w[1].1], [w[0].0, w[1].0]);
    let grown = |of: fn(&Point) -> f64| format!("{:.3e} to {:.3e}, x {:.1}", of(&a), of(&b), of(&b) / of(&a));
    vec![format!("{x0} and {x1}"), grown(|p| p.ppv), grown(|p| p.elastic)]
}

/// For each rattle state the peak-to-peak value at its first and last point, and the number of intervals
/// between neighbours of this state in which it falls.
pub fn trend(points: &[(f64, Option<Point>)], of: fn(&Point) -> f64) -> Vec<String> {
    let known = known(points);
    let word = |state: RattleState| {
        let first = known.iter().find(|p| p.1.state == state)?;
        let last = known.iter().rfind(|p| p.1.state == state)?;
        let pairs: Vec<f64> = known
            .windows(2)
            .filter(|w| w[0].1.state == state && w[1].1.state == state)
            .map(|w| of(&w[1].1) / of(&w[0].1) - 1.0)
            .collect();
        let falls = pairs.iter().filter(|change| **change < -1e-4).count();
        let deepest = pairs.iter().fold(0.0f64, |m, x| m.min(*x));
        let ends = format!("{:.3e} at {} to {:.3e} at {}", of(&first.1), first.0, of(&last.1), last.0);
        Some(match falls {
            0 => format!("{ends}, falls in none of {}", pairs.len()),
            _ => format!("{ends}, falls in {falls} of {}, by up to {:.0} %", pairs.len(), -100.0 * deepest),
        })
    };
    let states = [RattleState::None, RattleState::Unilateral, RattleState::Bilateral];
    states.iter().map(|state| word(*state).unwrap_or("-".into())).collect()
}

fn known(points: &[(f64, Option<Point>)]) -> Vec<(f64, Point)> {
    points.iter().filter_map(|(x, p)| p.map(|p| (*x, p))).collect()
}

/// Differences of the peak-to-peak values of P from those of the converged motion at common parameters: the
/// maximum where both have one rattle state, and the maximum of all.
pub fn misses(p: &[(f64, Option<Point>)], truth: &[(f64, Option<Point>)]) -> Vec<String> {
    let both: Vec<(f64, f64, bool)> = known(truth)
        .iter()
        .filter_map(|(x, t)| {
            known(p).iter().find(|(y, _)| y == x).map(|(_, p)| (*x, p.ppv / t.ppv - 1.0, p.state == t.state))
        })
        .collect();
    let worst =
        |same: bool| both.iter().filter(|m| m.2 || !same).max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    let say = |m: Option<&(f64, f64, bool)>| {
        m.map_or("nothing".into(), |m| format!("{:+.0} % at {}", 100.0 * m.1, m.0))
    };
    let same = both.iter().filter(|m| m.2).count();
    vec![format!("{same} of {}", both.len()), say(worst(true)), say(worst(false))]
}

/// Intervals in which the peak-to-peak value changes by more than a third.
pub fn jumps(points: &[(f64, Option<Point>)]) -> String {
    let known: Vec<(f64, f64)> = known(points).iter().map(|(x, p)| (*x, p.ppv)).collect();
    let jump = |w: &&[(f64, f64)]| (w[1].1 / w[0].1).ln().abs() > 0.3;
    let list: Vec<String> = known
        .windows(2)
        .filter(jump)
        .map(|w| format!("{:.4e} to {:.4e} rad at {}..{}", w[0].1, w[1].1, w[0].0, w[1].0))
        .take(3)
        .collect();
    if list.is_empty() { "none".into() } else { list.join("; ") }
}
