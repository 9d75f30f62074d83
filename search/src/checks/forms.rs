//! One oscillator written in all ways, by all integrators, at random tolerances, against the reference.

use crate::draw::Draw;
use crate::reference::{Part, Plain};
use crate::{Check, Outcome};
use gear_dynamics::contact::{Contact, Piece};
use gear_dynamics::model::{Offers, from_fn};
use gear_dynamics::models::Oscillator;
use gear_dynamics::ode::{Rodas, Step};
use gear_dynamics::{Dop853, Integrator, Model, Rk4, Rk45, State, Taylor};
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// The checks of this file.
pub const CHECKS: [Check; 1] = [Check { name: "reference-of-forms", run: forms }];

/// q'' = F + P cos Ωt - c q' - k q - γ q³ - s (1 + a cos Ωt) g(q), less η q' while the contact touches.
#[derive(Clone, Debug)]
struct Plane {
    speed: f64,
    damping: f64,
    linear: f64,
    cubic: f64,
    mesh: f64,
    variation: f64,
    mean: f64,
    force: f64,
    half_backlash: f64,
    /// η: the force jumps at the edges.
    in_contact: f64,
    pieces: bool,
}

impl Plane {
    fn draw(draw: &mut Draw) -> Self {
        Plane {
            speed: draw.within(0.4, 2.5),
            damping: draw.within(0.02, 0.2),
            linear: draw.one_of(&[0.0, 0.2]),
            cubic: draw.one_of(&[0.0, 0.1]),
            mesh: draw.scale(0.5, 1e4),
            variation: draw.within(0.0, 0.3),
            mean: draw.within(0.05, 0.6),
            force: draw.within(0.0, 0.5),
            half_backlash: draw.scale(0.05, 2.0),
            in_contact: draw.one_of(&[0.0, 0.5]),
            pieces: draw.below(2) == 0,
        }
    }
    fn of_zone(&self, cos: f64, q: f64, v: f64, zone: f64) -> f64 {
        let depth = if zone == 0.0 { 0.0 } else { q - zone * self.half_backlash };
        let force = self.mesh * (1.0 + self.variation * cos) * depth + zone.abs() * self.in_contact * v;
        self.mean + self.force * cos - self.damping * v - self.linear * q - self.cubic * q * q * q - force
    }
    fn zone(&self, q: f64) -> f64 {
        if q.abs() > self.half_backlash { q.signum() } else { 0.0 }
    }
}

impl Model for Plane {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = self.of_zone((self.speed * u[0]).cos(), q[0], v[0], self.zone(q[0]));
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        let b = self.half_backlash;
        out[0] = Contact { deflection: q[0], rate: v[0], lower: -b, upper: b, ..Contact::default() };
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: self.pieces, ..Offers::default() }
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let zone = match pieces[0] {
            Piece::Lower => -1.0,
            Piece::Gap => 0.0,
            Piece::Upper => 1.0,
        };
        a[0] = self.of_zone((self.speed * u[0]).cos(), q[0], v[0], zone);
    }
}

/// A run: the end, and the crossings by the statistics of the run and by the steps.
type Run = Result<(State, [u64; 2]), String>;

fn run<I: Integrator>(solver: &I, model: &dyn Model, start: &State, end: f64) -> Run {
    let mut seen = 0;
    let mut observer = |step: &mut Step<'_>| {
        seen += step.crossings().len() as u64;
        ControlFlow::Continue(())
    };
    let finish = solver.run(model, start, end, &mut observer).map_err(|error| error.to_string())?;
    Ok((finish.state, [finish.stats.crossings, seen]))
}

/// A small difference.
const BESIDE: f64 = 1e-6;

/// A stay in contact or in the gap that is shorter than this share of the fastest time may lie between the stages of a step.
const BRIEF: f64 = 0.25;

/// Steps of the reference in a unit of its fastest time.
const STEPS: f64 = 300.0;

fn forms(draw: &mut Draw) -> Outcome {
    let plane = Plane::draw(draw);
    let start = State::new(0.0, &[draw.within(-1.5, 1.5) * plane.half_backlash], &[draw.within(-0.5, 0.5)]);
    let (end, rtol) = (draw.within(5.0, 25.0), draw.scale(1e-12, 1e-6));
    draw.note(|| format!("{plane:?} {start:?} {end} {rtol:e}"));
    compare(draw, &plane, &start, end, rtol)
        .unwrap_or_else(|error| Outcome::Fails(format!("{error}; {plane:?} {start:?} {end:?} {rtol:e}")))
}

fn compare(draw: &mut Draw, plane: &Plane, start: &State, end: f64, rtol: f64) -> Result<Outcome, String> {
    let b = plane.half_backlash;
    let reference = Plain {
        dof: 1,
        contacts: 1,
        accel: &|at, zones, a| {
            a[0] = plane.of_zone((plane.speed * at.t).cos(), at.q[0], at.v[0], f64::from(zones[0]));
        },
        distances: &|at, _| [at.q[0] + b, at.q[0] - b],
        jump: &|_| f64::INFINITY,
        impact: None,
    };
    let fastest = TAU / (1.0 + plane.mesh.sqrt()).max(plane.speed);
    let y = [start.q[0], start.v[0]];
    // The shortest stay in a zone.
    let (mut entry, mut shortest) = (None, f64::INFINITY);
    let mut stays = |part: &Part<'_>| {
        if part.entered[0]
            && let Some(entry) = entry.replace(part.start.t)
        {
            shortest = shortest.min(part.start.t - entry);
        }
    };
    let coarse = reference.run(0.0, &y, end, fastest / STEPS, &mut stays);
    let fine = reference.run(0.0, &y, end, 0.5 * fastest / STEPS, &mut |_| {});
    if coarse.1 != fine.1 {
        return Ok(Outcome::Skipped("the reference makes other crossings with half the step"));
    }
    let open = (coarse.0[0] - fine.0[0]).abs() + (coarse.0[1] - fine.0[1]).abs();
    // How much a small difference of the start grows.
    let beside = reference.run(0.0, &[y[0] + BESIDE, y[1] + BESIDE], end, fastest / STEPS, &mut |_| {});
    let growth = ((beside.0[0] - coarse.0[0]).abs() + (beside.0[1] - coarse.0[1]).abs()) / BESIDE;
    if growth > 1e3 || beside.1 != coarse.1 {
        return Ok(Outcome::Skipped("a small difference grows a thousandfold or changes the crossings"));
    }
    let smooth = plane.in_contact == 0.0;
    let formula = from_fn(1, |t, q, v, a| {
        a[0] = plane.of_zone((plane.speed * t).cos(), q[0], v[0], plane.zone(q[0]));
    });
    let formula = formula.map_err(|error| error.to_string())?;
    let atol = 1e-2 * rtol;
    let dop853 = Dop853::new().rtol(rtol).atol(atol);
    let mut runs: Vec<(&str, Run)> = vec![
        ("Model by Dop853", run(&dop853, plane, start, end)),
        ("Model by Rk45", run(&Rk45::new().rtol(rtol.max(1e-12)).atol(atol), plane, start, end)),
        ("Model by Rodas", run(&Rodas::new().rtol(rtol.max(1e-10)).atol(atol.max(1e-12)), plane, start, end)),
    ];
    // Without pieces a step that ends on an edge sees the jump of the force there.
    if plane.pieces || smooth {
        runs.push(("Model by Rk4", run(&Rk4::new(fastest / 200.0), plane, start, end)));
    }
    if smooth {
        // Without edges a short touch lies between the stages of a step: its error is bounded by docs/integrators.md.
        if shortest > BRIEF * fastest {
            runs.push(("formula by Dop853", run(&dop853, &formula, start, end)));
        }
        let constants = [
            ("speed", plane.speed),
            ("damping", plane.damping),
            ("linear stiffness", plane.linear),
            ("cubic stiffness", plane.cubic),
            ("mesh stiffness", plane.mesh),
            ("stiffness variation", plane.variation),
            ("mean force", plane.mean),
            ("force", plane.force),
            ("half backlash", plane.half_backlash),
        ];
        let machine = Oscillator::new(&constants).map_err(|error| error.to_string())?;
        runs.push(("Oscillator by Taylor", run(&Taylor::new().rtol(rtol).atol(atol), &machine, start, end)));
        runs.push(("Oscillator by Dop853", run(&dop853, &machine, start, end)));
    }
    for (name, found) in runs {
        let (state, crossings) = found.map_err(|error| format!("{name}: {error}"))?;
        draw.note(|| format!("{name} {:?} {:?} {crossings:?}, reference {:?}", state.q, state.v, fine));
        let off = (state.q[0] - fine.0[0]).abs() + (state.v[0] - fine.0[1]).abs();
        let fixed = name.ends_with("Rk4");
        let local = if fixed {
            1e-6
        } else {
            3e2 * (1.0 + plane.mesh.sqrt()) * rtol.max(if name == "Model by Rodas" { 1e-10 } else { 1e-12 })
        };
        let allowed = 3.0 * open + growth.max(1.0) * local + 1e-8;
        if off.is_nan() || off > allowed {
            return Err(format!("{name} is off by {off:e}, allowed {allowed:e}"));
        }
        if name != "formula by Dop853" && crossings != [fine.1; 2] && off < 1e-4 {
            return Err(format!("{name} reports {crossings:?} crossings of {}", fine.1));
        }
    }
    Ok(Outcome::Agrees)
}
