//! Ensembles against the reference: every member of a family of oscillators in a dead zone by itself.

use crate::draw::Draw;
use crate::reference::{At, Plain, exceeds, extremes_of_cubic};
use crate::{Check, Outcome};
use gear_dynamics::models::Oscillator;
use gear_dynamics::sweep::{Distribution, Ensemble};
use gear_dynamics::{Dop853, ParameterError, State, Taylor};

/// The checks of this file.
pub const CHECKS: [Check; 1] =
    [Check { name: "reference-of-ensembles", run: |draw| ensembles(draw).unwrap_or_else(Outcome::Fails) }];

/// q'' = F + P cos ωt - c q' - s g(q) with the dead zone g of half backlash b.
#[derive(Clone, Debug)]
struct Member {
    force: [f64; 2],
    speed: f64,
    damping: f64,
    stiffness: f64,
    half_backlash: f64,
    start: [f64; 2],
}

/// What an ensemble keeps of a member: coordinate and velocity at each time, their peaks, the impacts.
struct Kept {
    values: Vec<[f64; 2]>,
    peaks: [f64; 2],
    impacts: u64,
}

/// Steps of the reference in a span of time.
const STEPS: f64 = 400.0;

fn told(error: impl std::fmt::Display) -> String {
    error.to_string()
}

impl Member {
    fn draw(draw: &mut Draw) -> Self {
        Member {
            force: [draw.within(-0.5, 0.5), draw.within(0.2, 1.0)],
            speed: draw.within(0.4, 1.5),
            damping: draw.within(0.02, 0.3),
            stiffness: draw.within(0.5, 3.0),
            half_backlash: draw.within(0.05, 0.8),
            start: [draw.within(-1.0, 1.0), draw.within(-1.0, 1.0)],
        }
    }

    fn model(&self) -> Result<Oscillator, ParameterError> {
        Oscillator::new(&[
            ("speed", self.speed),
            ("damping", self.damping),
            ("mesh stiffness", self.stiffness),
            ("mean force", self.force[0]),
            ("force", self.force[1]),
            ("half backlash", self.half_backlash),
        ])
    }

    fn reference(&self, end: f64, spans: usize, steps: f64) -> Kept {
        let accel = |at: &At<'_>, zone: i8| {
            let drive = self.force[0] + self.force[1] * (self.speed * at.t).cos();
            let depth = at.q[0] - f64::from(zone) * self.half_backlash;
            drive - self.damping * at.v[0] - f64::from(zone).abs() * self.stiffness * depth
        };
        let plain = Plain {
            dof: 1,
            contacts: 1,
            accel: &|at, zones, a| a[0] = accel(at, zones[0]),
            distances: &|at, _| [at.q[0] + self.half_backlash, at.q[0] - self.half_backlash],
            jump: &|_| f64::INFINITY,
            impact: None,
        };
        let mut kept = Kept { values: vec![self.start], peaks: [0.0; 2], impacts: 0 };
        let (mut y, span) = (self.start.to_vec(), end / spans as f64);
        for k in 0..spans {
            let [from, to] = [k, k + 1].map(|k| k as f64 * span);
            (y, _) = plain.run(from, &y, to, span / steps, &mut |part| {
                let (ends, h) = ([&part.start, &part.end], part.end.t - part.start.t);
                let [x, v] = [ends.map(|at| at.q[0]), ends.map(|at| at.v[0])];
                let a = ends.map(|at| accel(at, part.zones[0]));
                for (i, (values, slopes)) in [(x, v), (v, a)].into_iter().enumerate() {
                    let [low, high] = extremes_of_cubic(values, slopes, h);
                    kept.peaks[i] = kept.peaks[i].max(low.abs()).max(high.abs());
                }
                kept.impacts += u64::from(part.entered[0] && part.zones[0] != 0);
            });
            kept.values.push([y[0], y[1]]);
        }
        kept
    }
}

/// Compares a distribution with the numbers it should have, each with its own error.
fn same(found: &Distribution, exact: &[f64], before: &[f64]) -> Result<(), String> {
    let n = exact.len() as f64;
    let allowed = exact.iter().zip(before).map(|(x, y)| 2.0 * (x - y).abs()).fold(0.0, f64::max) + 1e-9;
    let mean = exact.iter().sum::<f64>() / n;
    let variance = exact.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
    let mut sorted = exact.to_vec();
    sorted.sort_by(f64::total_cmp);
    let quantile = |p: f64| {
        let at = p * (n - 1.0);
        let i = (at as usize).min(sorted.len() - 2);
        sorted[i] + (at - i as f64) * (sorted[i + 1] - sorted[i])
    };
    let found_variance = found.variance().map_err(told)?;
    // An error e of each value changes the variance by at most 2 e √(n/(n - 1)) of the deviation, and by e².
    let of_variance = 2.0 * allowed * (variance * n / (n - 1.0)).sqrt() + 2.0 * allowed * allowed;
    let figures = [
        ("mean", found.mean(), mean, allowed),
        ("minimum", found.min(), sorted[0], allowed),
        ("maximum", found.max(), sorted[sorted.len() - 1], allowed),
        ("quantile of 0.3", found.quantile(0.3).map_err(told)?, quantile(0.3), allowed),
        ("quantile of 0.9", found.quantile(0.9).map_err(told)?, quantile(0.9), allowed),
        ("variance", found_variance, variance, of_variance),
        ("standard error", found.standard_error(), (found_variance / n).sqrt(), 1e-12),
        ("count", found.count() as f64, n, 0.0),
    ];
    for (what, found, exact, allowed) in figures {
        if exceeds((found - exact).abs(), allowed) {
            return Err(format!("{what} {found:?}, {exact:?}, allowed {allowed:e}"));
        }
    }
    Ok(())
}

fn ensembles(draw: &mut Draw) -> Result<Outcome, String> {
    let count = 2 + draw.below(5);
    let members: Vec<Member> = (0..count).map(|_| Member::draw(draw)).collect();
    let (end, spans) = (draw.within(6.0, 20.0), 1 + draw.below(4));
    let text = format!("end {end:?} spans {spans} {members:?}");
    draw.note(|| text.clone());
    let steps = STEPS * (end / 6.0).ceil() / spans as f64;
    let kept = |steps: f64| members.iter().map(|member| member.reference(end, spans, steps)).collect();
    let [coarse, fine]: [Vec<Kept>; 2] = [steps, 2.0 * steps].map(kept);
    if coarse.iter().zip(&fine).any(|(x, y)| x.impacts != y.impacts) {
        return Ok(Outcome::Skipped("the reference counts other impacts with half the step"));
    }
    let family = |member: u64| {
        let member = &members[member as usize];
        let [x, v] = member.start;
        Ok::<_, ParameterError>((member.model()?, State::new(0.0, &[x], &[v])))
    };
    let names = ["q0", "v0"];
    let ensemble = Ensemble::new(count as u64, end, spans).map_err(told)?;
    let ensemble = ensemble.channels(&names).peaks(&names).rattle();
    let runs = [
        ("Dop853", ensemble.run(&Dop853::new().rtol(1e-12).atol(1e-14), family)),
        ("Taylor", ensemble.run(&Taylor::new(), family)),
    ];
    for (name, bands) in runs {
        let bands = bands.map_err(|error| format!("{name}: {error}; {text}"))?;
        let of = |what: String| move |error: String| format!("{name}: {what}: {error}");
        let compare = || -> Result<(), String> {
            for (i, channel) in names.into_iter().enumerate() {
                for k in 0..=spans {
                    let [before, exact] = [&coarse, &fine]
                        .map(|all| all.iter().map(|kept| kept.values[k][i]).collect::<Vec<f64>>());
                    let found = bands.at(channel, k).map_err(told)?;
                    same(found, &exact, &before).map_err(of(format!("{channel} at time {k}")))?;
                }
                let [before, exact] =
                    [&coarse, &fine].map(|all| all.iter().map(|kept| kept.peaks[i]).collect::<Vec<f64>>());
                let found = bands.peak(channel).map_err(told)?;
                same(found, &exact, &before).map_err(of(format!("peak of {channel}")))?;
            }
            let exact: Vec<f64> = fine.iter().map(|kept| kept.impacts as f64).collect();
            let found = bands.impacts(0).ok_or_else(|| "no impacts".to_owned())?;
            same(found, &exact, &exact).map_err(of("impacts".into()))
        };
        compare().map_err(|error| format!("{error}; {text}"))?;
    }
    Ok(Outcome::Agrees)
}
