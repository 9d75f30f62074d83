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

    /// The figures of deflection and mesh force, the shares of time and the impacts, with `steps` steps a cycle.
    /// Last the impacts whose first sample on the flank lanes measure: those one step earlier.
    fn reference(&self, steps: f64) -> ([Figures; 2], [f64; 3], [[u64; 2]; 2]) {
        let cycle = TAU / (self.speed * f64::from(self.teeth[0]));
        let per_mass = self.radii[0].powi(2) / self.inertias[0] + self.radii[1].powi(2) / self.inertias[1];
        let pushed = self.torque / self.radii[0];
        let places = match self.duty {
            0 => Vec::new(),
            duty => [-1.0, 1.0].map(|side| side * duty as f64 / 64.0 * cycle).to_vec(),
        };
        let plain = Plain {
            dof: 1,
            contacts: 1,
            accel: &|at, zones, a| a[0] = per_mass * (pushed - self.force(at.t, at.q[0], at.v[0], zones[0])),
            distances: &|at, _| {
                let [d, _] = self.deflection(at.t, at.q[0], at.v[0]);
                [d + self.half_backlash, d - self.half_backlash]
            },
            jump: &|t| next_of(&places, cycle, t),
            impact: None,
        };
        let h = cycle / steps;
        let (mut meters, mut time, mut impacts) =
            ([Meter::default(), Meter::default()], [0.0; 3], [[0; 2]; 2]);
        let begin = SETTLE as f64 * cycle;
        let step = cycle / LANES as f64;
        let (y, _) = plain.run(0.0, &[0.0, 0.0], begin - step, h, &mut |_| {});
        let (y, _) = plain.run(begin - step, &y, begin, h, &mut |part| {
            let zone = part.zones[0];
            if part.entered[0] && zone != 0 {
                impacts[1][usize::from(zone > 0)] += 1;
            }
        });
        let end = begin + MEASURE as f64 * cycle;
        plain.run(begin, &y, end, h, &mut |part| {
            let zone = part.zones[0];
            let ends = [&part.start, &part.end].map(|at| (at.t, at.q[0], at.v[0]));
            meters[0].add(part, ends.map(|(t, x, v)| self.deflection(t, x, v)[0]));
            meters[1].add(part, ends.map(|(t, x, v)| self.force(t, x, v, zone)));
            time[(zone + 1) as usize] += (part.end.t - part.start.t) / (MEASURE as f64 * cycle);
            if part.entered[0] && zone != 0 {
                impacts[0][usize::from(zone > 0)] += 1;
                impacts[1][usize::from(zone > 0)] += u64::from(part.start.t <= end - step);
            }
        });
        (meters.map(|meter| meter.figures()), time, impacts)
    }
}

fn told(error: impl std::fmt::Display) -> String {
    error.to_string()
}

/// Steps of the lanes in a mesh cycle.
const LANES: usize = 32 * 64;

/// Steps of the reference in a mesh cycle.
const STEPS: f64 = 2048.0;

fn engines(draw: &mut Draw) -> Outcome {
    let pair = Pair::draw(draw);
    draw.note(|| format!("{pair:?}"));
    compare(draw, &pair).unwrap_or_else(|error| Outcome::Fails(format!("{error}; {pair:?}")))
}

/// Mean, RMS, minimum and maximum of the two channels.
type Numbers = [[f64; 4]; 2];

fn compare(draw: &mut Draw, pair: &Pair) -> Result<Outcome, String> {
    let train = pair.train().map_err(told)?;
    let [coarse, fine] = [STEPS, 2.0 * STEPS].map(|steps| pair.reference(steps));
    if coarse.2 != fine.2 {
        return Ok(Outcome::Skipped("the reference counts other impacts with half the step"));
    }
    let numbers =
        |figures: &[Figures; 2]| figures.map(|f| [f.means[0], f.means[1], f.extremes[0], f.extremes[1]]);
    let (exact, before): (Numbers, Numbers) = (numbers(&fine.0), numbers(&coarse.0));
    let size = [0, 1].map(|i| exact[i][3] - exact[i][2]);
    // (name, row, accuracy as a share of the range)
    type Row = Result<(Numbers, [f64; 3], [u64; 2]), String>;
    let rows: [(&str, Row, f64); 6] = [
        ("LaneTaylor", row(&train, &LaneTaylor::new(Taylor::new())), 1e-8),
        ("Located(Dop853)", row(&train, &Located(Dop853::new().rtol(1e-11).atol(1e-17))), 1e-8),
        ("Located(Taylor)", row(&train, &Located(Taylor::new())), 1e-8),
        ("Located(Rk45)", row(&train, &Located(Rk45::new().rtol(1e-9).atol(1e-15))), 1e-6),
        ("LaneRk4", row(&train, &LaneRk4::new(LANES)), 1e-2),
        ("TableRk4", row(&train, &TableRk4::new(LANES)), 1e-2),
    ];
    for (name, row, share) in rows {
        let (found, time, impacts) = row.map_err(|error| format!("{name}: {error}"))?;
        draw.note(|| {
            format!("{name} {found:?} {time:?} {impacts:?}\n  reference {exact:?} {:?} {:?}", fine.1, fine.2)
        });
        for channel in 0..2 {
            for (k, what) in ["mean", "RMS", "minimum", "maximum"].into_iter().enumerate() {
                let open = 6.0 * (exact[channel][k] - before[channel][k]).abs() + share * size[channel];
                let off = (found[channel][k] - exact[channel][k]).abs();
                if off.is_nan() || off > open {
                    let channel = ["deflection", "mesh force"][channel];
                    return Err(format!("{name}: {what} of {channel} off by {off:e}, allowed {open:e}"));
                }
            }
        }
        let off = (0..3).map(|k| (time[k] - fine.1[k]).abs()).fold(0.0, f64::max);
        if off > 1e-5 + 3.0 * share {
            return Err(format!("{name}: times of contact {time:?}, {:?}", fine.1));
        }
        let is_fixed = share >= 1e-4;
        let expected = fine.2[usize::from(is_fixed)];
        // Fixed steps may pass over a contact that is shorter than a step.
        if impacts != expected && !(is_fixed && impacts[0] + impacts[1] <= expected[0] + expected[1]) {
            return Err(format!("{name}: impacts {impacts:?}, {expected:?}"));
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
