//! Parameters carried from end to end.

use crate::motions::{Point, converged, pair, paper, paper_orbit, paper_point};
use crate::support::Outcome;
use gear_dynamics::{NfgPair, NfgParams, Orbit};

/// A parameter carried from end to end.
pub struct Sweep {
    pub file: &'static str,
    pub figure: &'static str,
    pub parameter: &'static str,
    pub axis: &'static str,
    pub from: f64,
    pub to: f64,
    /// Intervals of reading P and of the converged sweep.
    pub intervals: [usize; 2],
    pub speed: f64,
    pub with: fn(f64, NfgParams) -> NfgParams,
}

pub const fn stiffness(speed: f64) -> Sweep {
    Sweep {
        file: "stiffness",
        figure: "Fig. 14",
        parameter: "a_k",
        axis: "a_k = k_r/k0",
        from: 0.1,
        to: 0.8,
        intervals: [14, 7],
        speed,
        with: |x, p| NfgParams { stiffness_harmonics: vec![[x * p.stiffness, 0.0]], ..p },
    }
}

pub const SWEEPS: [Sweep; 7] = [
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
        axis: "ε",
        from: 0.0,
        to: 0.4,
        intervals: [80, 20],
        speed: 160.0,
        with: |x, p| NfgParams { eccentric_ratio: x, ..p },
    },
    stiffness(140.0),
    stiffness(145.0),
    stiffness(160.0),
];

impl Sweep {
    pub fn value(&self, i: usize, intervals: usize) -> f64 {
        let x = self.from + (self.to - self.from) * i as f64 / intervals as f64;
        (1e9 * x).round() / 1e9
    }
    pub fn pair(&self, x: f64) -> Outcome<NfgPair> {
        let base = NfgParams::table1();
        let speed = if self.speed.is_nan() { base.speed } else { self.speed };
        pair(&(self.with)(x, NfgParams { speed, ..base }))
    }
}

pub const READINGS: [&str; 2] = ["P", "converged"];

pub const BRANCHES: [&str; 2] = ["up", "down"];

/// The orbit carried from one value of the parameter to another, in halved steps where Newton fails; `None` at a fold.
pub fn carry(sweep: &Sweep, orbit: &Orbit, from: f64, to: f64, halvings: usize) -> Outcome<Option<Orbit>> {
    if let Ok(orbit) = paper()?.solve_truncating_forces(&sweep.pair(to)?, orbit) {
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

/// The points of one sweep of one reading in one direction, in order of the parameter; `None` where no orbit was found.
pub fn follow(sweep: &Sweep, reading: usize, branch: usize, tick: impl Fn()) -> Outcome<Vec<(f64, Option<Point>)>> {
    let n = sweep.intervals[reading];
    let mut orbit: Option<(f64, Orbit)> = None;
    let mut motion = None;
    let mut points = Vec::new();
    for i in 0..=n {
        let x = sweep.value(if branch == 0 { i } else { n - i }, n);
        let pair = sweep.pair(x)?;
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

/// Runs of equal words along a sweep: `none 100..152.25, unilateral 152.5..`; at most `most` of them.
pub fn spans(points: &[(f64, Option<Point>)], word: impl Fn(&Point) -> String, most: usize) -> String {
    let mut runs: Vec<(String, f64, f64)> = Vec::new();
    for (x, point) in points {
        let here = point.as_ref().map_or("no orbit".into(), &word);
        match runs.last_mut().filter(|(before, ..)| *before == here) {
            Some((.., last)) => *last = *x,
            None => runs.push((here, *x, *x)),
        }
    }
    let mut list: Vec<String> = runs.iter().take(most).map(|(word, a, b)| format!("{word} {a}..{b}")).collect();
    if runs.len() > most {
        list.push(format!("and {} more", runs.len() - most));
    }
    list.join(", ")
}

/// Where peak-to-peak changes by more than a third from point to point.
pub fn jumps(points: &[(f64, Option<Point>)]) -> String {
    let known: Vec<(f64, f64)> = points.iter().filter_map(|(x, p)| p.map(|p| (*x, p.ppv))).collect();
    let jump = |w: &&[(f64, f64)]| (w[1].1 / w[0].1).ln().abs() > 0.3;
    let list: Vec<String> =
        known.windows(2).filter(jump).map(|w| format!("{:.4e} to {:.4e} rad at {}..{}", w[0].1, w[1].1, w[0].0, w[1].0)).take(3).collect();
    if list.is_empty() { "none".into() } else { list.join("; ") }
}
