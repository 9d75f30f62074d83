//! Settling and shooting far from 0: linear chains that a large load winds up. Settling of long flights between hard flanks.

use crate::draw::Draw;
use crate::{Check, Outcome};
use gear_dynamics::model::from_fn;
use gear_dynamics::models::Oscillator;
use gear_dynamics::nalgebra::{DMatrix, DVector};
use gear_dynamics::num_complex::Complex64;
use gear_dynamics::ode::IntegrateError;
use gear_dynamics::trains::SpurPair;
use gear_dynamics::{Dop853, Integrator, Periodic, Settle, Shooting, State, Taylor};
use std::f64::consts::TAU;

/// The checks of this file.
pub const CHECKS: [Check; 2] = [
    Check { name: "closed-wound-chains", run: |draw| wound(draw).unwrap_or_else(Outcome::Fails) },
    Check { name: "settled-flights", run: |draw| flights(draw).unwrap_or_else(Outcome::Fails) },
];

fn told(error: impl std::fmt::Display) -> String {
    error.to_string()
}

/// q_i'' = -k_i (q_i - q_{i-1}) + k_{i+1} (q_{i+1} - q_i) - α q_i' + F_i + P_i cos Ωt with q_0 = 0 and a free end. All modes
/// decay by e^{-αT/2} in a period T = 2π/Ω.
#[derive(Clone, Debug)]
struct Chain {
    springs: Vec<f64>,
    damping: f64,
    speed: f64,
    load: Vec<f64>,
    pulse: Vec<f64>,
}

impl Chain {
    fn draw(draw: &mut Draw) -> Chain {
        let n = 1 + draw.below(3);
        let springs: Vec<f64> = (0..n).map(|_| draw.scale(0.1, 100.0)).collect();
        let wound = draw.scale(1.0, 1e6);
        let mut forces = |size: f64| (0..n).map(|_| size * draw.within(0.2, 1.0)).collect::<Vec<f64>>();
        let (load, pulse) = (forces(wound), forces(1.0));
        Chain { springs, damping: draw.scale(0.03, 0.3), speed: draw.scale(0.1, 3.0), load, pulse }
    }

    fn accel(&self, t: f64, q: &[f64], v: &[f64], a: &mut [f64]) {
        for i in 0..q.len() {
            let before = if i == 0 { 0.0 } else { q[i - 1] };
            let after = self.springs.get(i + 1).map_or(0.0, |k| k * (q[i + 1] - q[i]));
            a[i] = after - self.springs[i] * (q[i] - before) - self.damping * v[i]
                + self.load[i]
                + self.pulse[i] * (self.speed * t).cos();
        }
    }

    /// The stiffness matrix.
    fn stiffness(&self) -> DMatrix<f64> {
        let n = self.springs.len();
        let mut k = DMatrix::zeros(n, n);
        for (i, spring) in self.springs.iter().enumerate() {
            k[(i, i)] += spring;
            if i > 0 {
                k[(i - 1, i - 1)] += spring;
                k[(i, i - 1)] -= spring;
                k[(i - 1, i)] -= spring;
            }
        }
        k
    }

    /// The rest, and the complex amplitudes x of Re x e^{iΩt}.
    fn motion(&self) -> Option<(DVector<f64>, DVector<Complex64>)> {
        let rest = self.stiffness().lu().solve(&DVector::from_vec(self.load.clone()))?;
        let inertia = Complex64::new(-self.speed * self.speed, self.damping * self.speed);
        let mut dynamic = self.stiffness().map(|k| Complex64::new(k, 0.0));
        for i in 0..self.springs.len() {
            dynamic[(i, i)] += inertia;
        }
        let pulse =
            DVector::from_iterator(self.pulse.len(), self.pulse.iter().map(|p| Complex64::new(*p, 0.0)));
        Some((rest, dynamic.lu().solve(&pulse)?))
    }
}

/// A settled state, and an orbit by shooting, are off from the closed form by what they state, and by what the solver errs.
fn wound(draw: &mut Draw) -> Result<Outcome, String> {
    let chain = Chain::draw(draw);
    let text = format!("{chain:?}");
    draw.note(|| text.clone());
    let n = chain.springs.len();
    let (rest, response) = chain.motion().ok_or("a singular chain")?;
    let period = TAU / chain.speed;
    let at = |t: f64| -> State {
        let turned: Vec<Complex64> = response.iter().map(|x| x * Complex64::cis(chain.speed * t)).collect();
        let q: Vec<f64> = (0..n).map(|i| rest[i] + turned[i].re).collect();
        let v: Vec<f64> = turned.iter().map(|x| -chain.speed * x.im).collect();
        State::new(t, &q, &v)
    };
    // As a share of the range of each coordinate and velocity.
    let off = |state: &State| {
        let exact = at(state.t);
        (0..n).fold(0.0f64, |most, i| {
            let range = 2.0 * response[i].norm();
            let of_q = (state.q[i] - exact.q[i]).abs() / range;
            most.max(of_q).max((state.v[i] - exact.v[i]).abs() / (range * chain.speed))
        })
    };
    // What a solver errs in a period, at most, of four that begin at other phases: rounding differs from run to run.
    let of_a_period = |solver: &dyn Integrator, model: &dyn Periodic| -> Result<f64, String> {
        let starts = (0..4).map(|phase| at(0.25 * f64::from(phase) * period));
        starts
            .map(|start| Ok(off(&solver.end(&model, &start, start.t + period).map_err(told)?)))
            .try_fold(0.0f64, |most, own: Result<f64, String>| own.map(|own| most.max(own)))
    };
    let inner = chain.clone();
    let formula = from_fn(n, move |t, q, v, a| inner.accel(t, q, v, a)).map_err(told)?;
    let formula = formula.with_period(period).map_err(told)?;
    let machine = Oscillator::new(&[
        ("speed", chain.speed),
        ("damping", chain.damping),
        ("linear stiffness", chain.springs[0]),
        ("mean force", chain.load[0]),
        ("force", chain.pulse[0]),
    ])
    .map_err(told)?;
    // A step adds up the forces of the springs: their rounding is not below the tolerance.
    let force = chain.springs.iter().fold(1.0f64, |most, k| most.max(*k)) * rest.amax();
    let dop853 = Dop853::new().rtol(1e-13).atol(1e-14 + 8.0 * f64::EPSILON * force);
    let mut runs: Vec<(&str, &dyn Integrator, &dyn Periodic)> = vec![("formula", &dop853, &formula)];
    let taylor = Taylor::new();
    if n == 1 {
        runs.extend([
            ("Dop853", &dop853 as &dyn Integrator, &machine as &dyn Periodic),
            ("Taylor", &taylor, &machine),
        ]);
    }
    let contraction = (-0.5 * chain.damping * period).exp();
    let mut start = at(0.0);
    for i in 0..n {
        start.q[i] += draw.within(-1.0, 1.0) * response[i].norm();
    }
    for (name, solver, model) in runs {
        let settle = Settle::new().max_periods(5_000).max_period_multiple(1);
        let own = of_a_period(solver, &model)?;
        let of_solver = 10.0 * own / (1.0 - contraction) + 1e-9;
        match settle.run(solver, &model, &start) {
            Ok(steady) => {
                let (off, error) = (off(&steady.state), steady.error());
                let error = if error.is_finite() { error } else { steady.change / (1.0 - contraction) };
                draw.note(|| {
                    format!("{name}: off {off:e}, error {error:e}, own {own:e}, {} periods", steady.periods)
                });
                if off.is_nan() || off > 10.0 * error + of_solver {
                    return Err(format!("{name}: off by {off:e}, error {error:e}, a period {own:e}; {text}"));
                }
            }
            Err(error) if own > 1e-10 => {
                draw.note(|| format!("{name}: {error}"));
                return Ok(Outcome::Skipped("the solver does not resolve the motion"));
            }
            Err(error) => return Err(format!("{name}: {error}; {text}")),
        }
    }
    match Shooting::new().solve(&formula, &start) {
        Ok(orbit) => {
            let error = orbit.accuracy();
            let own = of_a_period(&dop853, &formula)?;
            let allowed = (10.0 * error + 10.0 * own) / (1.0 - contraction) + 1e-7;
            let off = off(&orbit.states()[0]);
            draw.note(|| format!("shooting: off {off:e}, accuracy {error:e}, a period {own:e}"));
            if off.is_nan() || off > allowed {
                return Err(format!("shooting: off by {off:e}, accuracy {error:e}; {text}"));
            }
        }
        Err(error) => draw.note(|| format!("shooting: {error}")),
    }
    Ok(Outcome::Agrees)
}

/// Long flights and hard flanks: what settles returns, by the other solver, after one more period of its orbit.
fn flights(draw: &mut Draw) -> Result<Outcome, String> {
    let (model, start, size): (Box<dyn Periodic>, f64, f64) = if draw.below(2) == 0 {
        // A slow transmission error lifts a light load off its flank.
        let (speed, error) = (draw.scale(3e-4, 0.3), draw.scale(0.3, 10.0));
        let load = draw.within(0.1, 0.9) * error * speed * speed;
        let zeta = speed * draw.scale(0.002, 0.3);
        draw.note(|| format!("a slow pair: speed {speed:e}, error {error}, load {load:e}, zeta {zeta:e}"));
        let pair = SpurPair::of_numbers(zeta, load, &[0.2], &[error]).map_err(told)?;
        let train = pair.parts().map_err(told)?.build("driver", speed).map_err(told)?;
        (Box::new(train), 1.0 + error, error)
    } else {
        let given = [
            ("speed", draw.scale(0.3, 3.0)),
            ("damping", draw.scale(0.03, 1.0)),
            ("mesh stiffness", draw.scale(1.0, 1e9)),
            ("mean force", draw.within(-1.0, 1.0)),
            ("force", draw.within(0.1, 1.0)),
            ("half backlash", draw.scale(0.01, 10.0)),
        ];
        draw.note(|| format!("{given:?}"));
        let model = Oscillator::new(&given).map_err(told)?;
        let range = (2.0 * given[5].1).min(given[4].1 / given[0].1.powi(2));
        (Box::new(model), given[5].1 * given[3].1.signum(), range)
    };
    let start = State::new(0.0, &[start], &[0.0]);
    let (taylor, dop853) = (Taylor::new(), Dop853::new().rtol(1e-9).atol(1e-11 * size));
    for (solver, other) in [(&dop853 as &dyn Integrator, &taylor as &dyn Integrator), (&taylor, &dop853)] {
        let Ok(steady) = Settle::new().max_periods(100).run(solver, &model, &start) else { continue };
        let end = steady.state.t + steady.period_multiple as f64 * model.period();
        let again = match other.end(&model, &steady.state, end) {
            Err(IntegrateError::BelowRounding { .. }) => continue,
            again => again.map_err(told)?,
        };
        let apart = (again.q[0] - steady.state.q[0]).abs() / size;
        draw.note(|| format!("{} periods, change {:e}, again {apart:e}", steady.periods, steady.change));
        if apart.is_nan() || apart > 1e-4 + 10.0 * steady.change {
            return Err(format!(
                "{apart:e} apart after {} periods, {:e} stated",
                steady.periods, steady.change
            ));
        }
    }
    Ok(Outcome::Agrees)
}
