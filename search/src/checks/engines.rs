//! Every figure of every engine against the reference: spur pairs of parts from rest, through jumps and impacts.

use crate::draw::Draw;
use crate::reference::{Figures, Meter, Plain, next_of, wrapped};
use crate::{Check, Outcome};
use gear_dynamics::contact::ContactDamping;
use gear_dynamics::excitation::{Fourier, RectangularWave};
use gear_dynamics::sweep::bounds::SweepEngine;
use gear_dynamics::sweep::{Axis, LaneRk4, LaneTaylor, Located, TableRk4};
use gear_dynamics::trains::{Body, MeshPart, Parts, Train};
use gear_dynamics::{Dop853, Model, ParameterError, Periodic, Rk45, State, Sweep, Taylor, Wave};
use std::f64::consts::{PI, TAU};

/// The checks of this file.
pub const CHECKS: [Check; 1] = [Check { name: "reference-of-engines", run: engines }];

/// A spur pair along its line of action: m x'' = F - W with W = c d' + k(φ) f(d), d = x - e(φ).
#[derive(Clone, Debug)]
struct Pair {
    inertias: [f64; 2],
    teeth: [u32; 2],
    radii: [f64; 2],
    /// Duty of the high stiffness in 32nds of a mesh cycle, or 0: a cosine.
    duty: usize,
    stiffness: [f64; 2],
    error: [f64; 2],
    half_backlash: f64,
    damping: f64,
    in_contact: bool,
    torque: f64,
    speed: f64,
}

const SETTLE: usize = 3;
const MEASURE: usize = 2;

impl Pair {
    fn draw(draw: &mut Draw) -> Self {
        let teeth = [17 + draw.below(20) as u32, 30 + draw.below(40) as u32];
        let radii = teeth.map(|z| 1.5e-3 * f64::from(z));
        let inertias = [draw.scale(3e-4, 1e-2), draw.scale(1e-3, 1e-2)];
        let mass = 1.0 / (radii[0].powi(2) / inertias[0] + radii[1].powi(2) / inertias[1]);
        let mean = draw.scale(5e7, 5e8);
        let part = draw.within(0.02, 0.4);
        let frequency = (mean / mass).sqrt();
        let torque = draw.scale(1.0, 100.0);
        let size = torque / radii[0] / mean;
        Pair {
            inertias,
            teeth,
            radii,
            duty: if draw.below(3) == 0 { 0 } else { 2 + draw.below(28) },
            stiffness: [mean * (1.0 - part), mean * (1.0 + part)],
            error: [draw.within(-1.0, 1.0) * size, draw.within(-1.0, 1.0) * size],
            half_backlash: size * draw.scale(0.3, 30.0),
            damping: 2.0 * mass * frequency * draw.scale(0.01, 0.2),
            in_contact: draw.below(2) == 0,
            torque,
            speed: frequency * draw.within(0.3, 1.5) / f64::from(teeth[0]),
        }
    }

    fn train(&self) -> Result<Train, Box<dyn std::error::Error>> {
        let [low, high] = self.stiffness;
        let stiffness = match self.duty {
            0 => Wave::new(Fourier::new(0.5 * (low + high), &[[0.5 * (high - low), 0.0]])?),
            duty => Wave::new(RectangularWave::of_contact_ratio(1.0 + duty as f64 / 32.0, low, high)?),
        };
        let mut parts = Parts::new();
        parts.body("pinion", Body::new(self.inertias[0])).body("wheel", Body::new(self.inertias[1]));
        let mesh = MeshPart::external(self.teeth, self.radii, stiffness)
            .error(Wave::new(Fourier::new(0.0, &[self.error])?))
            .half_backlash(self.half_backlash)
            .damping(self.damping)
            .contact_damping(if self.in_contact {
                ContactDamping::InContact
            } else {
                ContactDamping::Always
            });
        parts.mesh("mesh", "pinion", "wheel", mesh).torque("drive", "pinion", self.torque).load("wheel");
        Ok(parts.build("pinion", self.speed)?)
    }

    fn deflection(&self, t: f64, x: f64, v: f64) -> [f64; 2] {
        let omega = self.speed * f64::from(self.teeth[0]);
        let (sin, cos) = (omega * t).sin_cos();
        let [a, b] = self.error;
        [x - a * cos - b * sin, v - omega * (b * cos - a * sin)]
    }

    fn force(&self, t: f64, x: f64, v: f64, zone: i8) -> f64 {
        let angle = wrapped(self.speed * f64::from(self.teeth[0]) * t);
        let [low, high] = self.stiffness;
        let stiffness = match self.duty {
            0 => 0.5 * (low + high) + 0.5 * (high - low) * angle.cos(),
            duty if angle.abs() < PI * duty as f64 / 32.0 => high,
            _ => low,
        };
        let [d, rate] = self.deflection(t, x, v);
        let damping = if self.in_contact && zone == 0 { 0.0 } else { self.damping };
        damping * rate + f64::from(zone).abs() * stiffness * (d - f64::from(zone) * self.half_backlash)
    }

    /// The acceleration.
    fn acceleration(&self, t: f64, x: f64, v: f64, zone: i8) -> f64 {
        let per_mass = self.radii[0].powi(2) / self.inertias[0] + self.radii[1].powi(2) / self.inertias[1];
        per_mass * (self.torque / self.radii[0] - self.force(t, x, v, zone))
    }

    fn cycle(&self) -> f64 {
        TAU / (self.speed * f64::from(self.teeth[0]))
    }

    fn zone(&self, t: f64, x: f64) -> i8 {
        let [d, _] = self.deflection(t, x, 0.0);
        if d < -self.half_backlash { -1 } else { i8::from(d > self.half_backlash) }
    }

    /// The motion of lanes with `steps` steps a cycle of the classical Runge-Kutta method, each stage on the zone of its
    /// state. The stiffness jumps at ends of steps.
    fn fixed(&self, steps: usize) -> Motion {
        let h = self.cycle() / steps as f64;
        let slope = |t: f64, [x, v]: [f64; 2]| [v, self.acceleration(t, x, v, self.zone(t, x))];
        let moved = |[x, v]: [f64; 2], by: f64, [dx, dv]: [f64; 2]| [x + by * dx, v + by * dv];
        let mut figures = [Figures { means: [0.0; 2], extremes: [f64::INFINITY, f64::NEG_INFINITY] }; 2];
        let (mut y, mut before, mut time, mut impacts) = ([0.0; 2], 0, [0.0; 3], [0; 2]);
        let (first, samples) = (SETTLE * steps, MEASURE * steps);
        for k in 0..first + samples {
            let t = k as f64 * h;
            let [x, v] = y;
            let zone = self.zone(t, x);
            if k >= first {
                // Both sides of a jump.
                let sides = [t - 1e-6 * h, t + 1e-6 * h].map(|t| self.force(t, x, v, zone));
                let [d, _] = self.deflection(t, x, v);
                for (figures, values) in figures.iter_mut().zip([[d, d], sides]) {
                    for value in values {
                        figures.means[0] += 0.5 * value / samples as f64;
                        figures.means[1] += 0.5 * value * value / samples as f64;
                        let [low, high] = figures.extremes;
                        figures.extremes = [low.min(value), high.max(value)];
                    }
                }
                time[(zone + 1) as usize] += 1.0 / samples as f64;
                if before == 0 && zone != 0 {
                    impacts[usize::from(zone > 0)] += 1;
                }
            }
            before = zone;
            let k1 = slope(t + 1e-6 * h, y);
            let k2 = slope(t + 0.5 * h, moved(y, 0.5 * h, k1));
            let k3 = slope(t + 0.5 * h, moved(y, 0.5 * h, k2));
            let k4 = slope(t + h - 1e-6 * h, moved(y, h, k3));
            let sum = [0, 1].map(|i| (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]) / 6.0);
            y = moved(y, h, sum);
        }
        figures.iter_mut().for_each(|figures| figures.means[1] = figures.means[1].sqrt());
        (figures, time, impacts)
    }

    /// The motion from `start` with `steps` steps a cycle and located edges.
    fn reference(&self, steps: f64, start: f64) -> Motion {
        let cycle = self.cycle();
        let places = match self.duty {
            0 => Vec::new(),
            duty => [-1.0, 1.0].map(|side| side * duty as f64 / 64.0 * cycle).to_vec(),
        };
        let plain = Plain {
            dof: 1,
            contacts: 1,
            accel: &|at, zones, a| a[0] = self.acceleration(at.t, at.q[0], at.v[0], zones[0]),
            distances: &|at, _| {
                let [d, _] = self.deflection(at.t, at.q[0], at.v[0]);
                [d + self.half_backlash, d - self.half_backlash]
            },
            jump: &|t| next_of(&places, cycle, t),
            impact: None,
        };
        let h = cycle / steps;
        let (mut meters, mut time, mut impacts) = ([Meter::default(), Meter::default()], [0.0; 3], [0; 2]);
        let begin = SETTLE as f64 * cycle;
        let (y, _) = plain.run(0.0, &[start, 0.0], begin, h, &mut |_| {});
        plain.run(begin, &y, begin + MEASURE as f64 * cycle, h, &mut |part| {
            let zone = part.zones[0];
            let ends = [&part.start, &part.end].map(|at| (at.t, at.q[0], at.v[0]));
            meters[0].add(part, ends.map(|(t, x, v)| self.deflection(t, x, v)[0]));
            meters[1].add(part, ends.map(|(t, x, v)| self.force(t, x, v, zone)));
            time[(zone + 1) as usize] += (part.end.t - part.start.t) / (MEASURE as f64 * cycle);
            if part.entered[0] && zone != 0 {
                impacts[usize::from(zone > 0)] += 1;
            }
        });
        (meters.map(|meter| meter.figures()), time, impacts)
    }
}

/// The figures of deflection and mesh force, the shares of time below, in and above the gap, the impacts on both flanks.
type Motion = ([Figures; 2], [f64; 3], [u64; 2]);

fn told(error: impl std::fmt::Display) -> String {
    error.to_string()
}

/// Steps of the lanes in a mesh cycle.
const LANES: usize = 32 * 64;

/// Steps of the reference in a mesh cycle.
const STEPS: f64 = 2048.0;

/// Largest number of steps of the scheme of the lanes for a motion that is sensitive to its start.
const MOST: usize = 64 * LANES;

/// Accuracy of the figures of fixed steps beside those of the same steps: the weight of one sample.
const FIXED: f64 = 1.0 / (MEASURE * LANES) as f64;

/// The row of `Located(Rk45)`, which has the lowest order.
const BY_RK45: usize = 3;

/// Largest error of this row for a sensitive motion, as a multiple of that of others.
const SENSITIVE: f64 = 10.0;

fn engines(draw: &mut Draw) -> Outcome {
    let pair = Pair::draw(draw);
    draw.note(|| format!("{pair:?}"));
    compare(draw, &pair).unwrap_or_else(|error| Outcome::Fails(format!("{error}; {pair:?}")))
}

/// Mean, RMS, minimum and maximum of the two channels.
type Numbers = [[f64; 4]; 2];

fn compare(draw: &mut Draw, pair: &Pair) -> Result<Outcome, String> {
    let train = pair.train().map_err(told)?;
    let [coarse, fine] = [STEPS, 2.0 * STEPS].map(|steps| pair.reference(steps, 0.0));
    if coarse.2 != fine.2 {
        return Ok(Outcome::Skipped("the reference counts other impacts with half the step"));
    }
    let fixed = pair.fixed(LANES);
    let numbers =
        |figures: &[Figures; 2]| figures.map(|f| [f.means[0], f.means[1], f.extremes[0], f.extremes[1]]);
    let (exact, before, fixed_numbers): (Numbers, Numbers, Numbers) =
        (numbers(&fine.0), numbers(&coarse.0), numbers(&fixed.0));
    let size = [0, 1].map(|i| exact[i][3] - exact[i][2]);
    // (name, row, accuracy as a share of the range)
    type Row = Result<(Numbers, [f64; 3], [u64; 2]), String>;
    let rows: [(&str, Row, Option<f64>); 6] = [
        ("LaneTaylor", row(&train, &LaneTaylor::new(Taylor::new())), Some(1e-8)),
        ("Located(Dop853)", row(&train, &Located(Dop853::new().rtol(1e-11).atol(1e-17))), Some(1e-8)),
        ("Located(Taylor)", row(&train, &Located(Taylor::new())), Some(1e-8)),
        ("Located(Rk45)", row(&train, &Located(Rk45::new().rtol(1e-9).atol(1e-15))), Some(1e-6)),
        ("LaneRk4", row(&train, &LaneRk4::new(LANES)), None),
        ("TableRk4", row(&train, &TableRk4::new(LANES)), None),
    ];
    // The scheme itself comes to the motion: with as many steps as the lanes make, unless the motion is
    // sensitive to its start.
    let apart = |numbers: &Numbers| -> f64 {
        let off = |i: usize, k: usize| (numbers[i][k] - exact[i][k]).abs() / size[i];
        (0..2).flat_map(|i| (0..4).map(move |k| off(i, k))).fold(0.0, f64::max)
    };
    let beside = pair.reference(STEPS, 1e-3 * size[0]);
    let is_sensitive = apart(&numbers(&beside.0)) > 1e-2 || beside.2 != fine.2;
    let by = |steps: usize| apart(&numbers(&pair.fixed(steps).0));
    let (mut steps, mut off) = (LANES, by(LANES));
    // A force with damping in contact only jumps at an edge: its extreme beside the jump converges with the first order. So
    // does the instant at which a motion without it meets an edge within a step: its error must then fall with that order.
    while off > 1e-2 && steps < MOST {
        let before = off;
        steps *= 8;
        off = by(steps);
        if !(is_sensitive || pair.in_contact) && off > 0.25 * before {
            return Err(format!(
                "{steps} fixed steps are off by {off:e} of the range, an eighth of them by {before:e}"
            ));
        }
    }
    draw.note(|| format!("{steps} fixed steps are off by {off:e} of the range"));
    if off.is_nan() || off > 1e-2 {
        return Err(format!("{steps} fixed steps are off by {off:e} of the range"));
    }
    // A sensitive motion multiplies the errors of all steps. They must then follow the tolerance: the figures of a
    // tenth of the tolerance have the accuracy asked for.
    let mut rows = rows;
    if is_sensitive {
        let (_, coarse, share) = &rows[BY_RK45];
        let off = coarse.as_ref().map_or(0.0, |coarse| apart(&coarse.0));
        if share.is_some_and(|share| off > share && off < SENSITIVE * share) {
            rows[BY_RK45].1 = self::row(&train, &Located(Rk45::new().rtol(1e-10).atol(1e-16)));
        }
    }
    for (name, row, located) in rows {
        let (found, time, impacts) = row.map_err(|error| format!("{name}: {error}"))?;
        // Fixed steps are compared with the same steps, of which a mean is a sum.
        let (expected, share, exact, open) = match located {
            Some(share) => (&fine, share, exact, 6.0),
            None => (&fixed, FIXED, fixed_numbers, 0.0),
        };
        draw.note(|| {
            format!(
                "{name} {found:?} {time:?} {impacts:?}\n  reference {exact:?} {:?} {:?}",
                expected.1, expected.2
            )
        });
        for channel in 0..2 {
            for (k, what) in ["mean", "RMS", "minimum", "maximum"].into_iter().enumerate() {
                let open = open * (exact[channel][k] - before[channel][k]).abs() + share * size[channel];
                let off = (found[channel][k] - exact[channel][k]).abs();
                if off.is_nan() || off > open {
                    let channel = ["deflection", "mesh force"][channel];
                    return Err(format!("{name}: {what} of {channel} off by {off:e}, allowed {open:e}"));
                }
            }
        }
        let off = (0..3).map(|k| (time[k] - expected.1[k]).abs()).fold(0.0, f64::max);
        if off > 1e-5 + 3.0 * share {
            return Err(format!("{name}: times of contact {time:?}, {:?}", expected.1));
        }
        if impacts != expected.2 {
            return Err(format!("{name}: impacts {impacts:?}, {:?}", expected.2));
        }
    }
    Ok(Outcome::Agrees)
}

fn row<E: SweepEngine<Train>>(train: &Train, engine: &E) -> Result<(Numbers, [f64; 3], [u64; 2]), String> {
    let speed = train.constant("speed").map_err(told)?;
    let cycle = train.period();
    let points = Axis::of_values("speed", &[speed]).map_err(told)?;
    let sweep =
        Sweep::new(points).settle(SETTLE).measure(MEASURE).channels(&["deflection", "mesh force"]).rattle();
    let sweep = sweep.of(engine, |p| train.with("speed", p["speed"]));
    let rows =
        sweep.start(|_, model| Ok::<_, ParameterError>(State::at_rest(model.dof()))).run().map_err(told)?;
    let row = rows.get(0).map_err(told)?;
    let numbers = ["deflection", "mesh force"]
        .map(|channel| row.channel(channel).map_or([f64::NAN; 4], |s| [s.mean, s.rms, s.min, s.max]));
    let contact = row.contacts().first().copied().ok_or_else(|| format!("no contact, period {cycle}"))?;
    Ok((numbers, contact.time, contact.impacts))
}
