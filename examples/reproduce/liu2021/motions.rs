//! Motions of the pair: by the harmonic balance of Liu 2021, and converged.

use super::super::support::{Outcome, coarse};
use gear_dynamics::analysis::{SettleError, Summary};
use gear_dynamics::contact::Piece;
use gear_dynamics::models::nfg::NfgReading;
use gear_dynamics::periodic::{BalanceError, FourierOrbit, Integrals, ShootingOrbit, Stability};
use gear_dynamics::roots::Broyden;
use gear_dynamics::{
    Balance, Dop853, Harmonics, Integrator, NfgPair, NfgParams, Periodic, Rattle, RattleState, Settle,
    Shooting, State, Statistics,
};

/// Turns of the face gear for settling, and for measuring if the motion does not repeat.
pub fn turns() -> [usize; 2] {
    if coarse() { [20, 4] } else { [200, 40] }
}

/// Maximum number of turns of an orbit.
const TURNS: usize = 8;

/// Returns within this share of the range of motion decide where shooting does not.
const CLOSE: f64 = 1e-9;

/// The channel of f(q).
pub const ELASTIC: &str = "elastic part";

/// Order of the mesh frequency: teeth of the face gear.
pub const MESH: usize = 63;

/// The published equations.
pub fn pair(params: &NfgParams) -> Outcome<NfgPair> {
    Ok(NfgPair::of_reading(params, NfgReading::published())?)
}

pub fn solver() -> Dop853 {
    Dop853::new().rtol(1e-9).atol_each(&[1e-14, 1e-15])
}

/// One point of a sweep.
#[derive(Clone, Copy)]
pub struct Point {
    pub state: RattleState,
    /// Peak-to-peak value of q `[rad]`.
    pub ppv: f64,
    /// Peak-to-peak value of f(q), the elastic part `[rad]`.
    pub elastic: f64,
    /// `stable`, `unstable`, `undecided` or `aperiodic`.
    pub stable: &'static str,
}

pub fn word(stability: Option<Stability>) -> &'static str {
    match stability {
        Some(Stability::Stable) => "stable",
        Some(Stability::Unstable) => "unstable",
        Some(Stability::Undecided) | None => "undecided",
    }
}

/// The harmonic balance of Liu 2021: 15 unknowns, 1024 samples.
pub fn paper() -> Result<Balance, BalanceError> {
    let sampled = Integrals::Sampled { samples: 1024 };
    Ok(Balance::new(Harmonics::bands(MESH, 1, 2)?).integrals(sampled).truncated_forces())
}

/// The orbit by Newton's method from the linear flank. Beyond the fold, where this fails, Newton and then
/// Broyden as in Liu 2021 start from a run in time.
pub fn paper_orbit(pair: &NfgPair) -> Outcome<Option<FourierOrbit>> {
    let newton = paper()?;
    if let Ok(orbit) = newton.solve(pair, &newton.linearised(pair, Piece::Lower)?) {
        return Ok(Some(orbit));
    }
    let run = run(pair)?;
    Ok(newton.solve(pair, &run).or_else(|_| broyden()?.solve(pair, &run)).ok())
}

/// A run in time from the static start, projected on the 15 unknowns.
pub fn run(pair: &NfgPair) -> Outcome<FourierOrbit> {
    let settle = Settle::new().tolerance(1e-4).max_periods(8);
    let late = match settle.run(&solver(), pair, &pair.on_drive_flank()?) {
        Ok(steady) => steady.state,
        Err(error) => error.last().cloned().ok_or(error)?,
    };
    Ok(FourierOrbit::project(&solver(), pair, &late, paper()?.harmonics())?)
}

/// The guess of Liu 2021: rest on the drive flank.
pub fn at_rest(pair: &NfgPair) -> Outcome<FourierOrbit> {
    let harmonics = paper()?.harmonics().clone();
    let mut coefficients = vec![0.0; harmonics.unknowns()];
    coefficients[0] = pair.on_drive_flank()?.q[0];
    Ok(FourierOrbit::new(&harmonics, pair.period(), &[coefficients])?)
}

/// The balance of Liu 2021 solved by Broyden's good method from the identity, as in Liu 2021.
pub fn broyden() -> Result<Balance, BalanceError> {
    Ok(paper()?.root_finder(Broyden::new()))
}

pub fn paper_point(pair: &NfgPair, orbit: &FourierOrbit) -> Outcome<Point> {
    /// 500 samples in a period of the highest order: the extremes are accurate to 2e-5 of its amplitude.
    const SAMPLES: usize = 32_768;
    let state = orbit.contacts(pair)?[0].statistics.rattle_state();
    let elastic = Summary::of_samples(&orbit.history(SAMPLES)?.channel(pair, ELASTIC)?)?.peak_to_peak();
    // Multipliers of the published equations linearised along the series; Liu 2021 does not state stability.
    let multipliers = Balance::new(orbit.harmonics().clone()).multipliers(pair, orbit);
    let stable = word(multipliers.ok().map(|m| m.stability()));
    Ok(Point { state, ppv: orbit.peak_to_peak(0), elastic, stable })
}

/// A motion that repeats and is stable.
pub enum Cycle {
    /// Found by shooting.
    Orbit(Box<ShootingOrbit>),
    /// A run that returns after so many turns, again and again, where shooting does not converge: an orbit within 1e-6
    /// of its range from one that grazes.
    Returns(State, usize),
}

impl Cycle {
    pub fn start(&self) -> &State {
        match self {
            Cycle::Orbit(orbit) => &orbit.states()[0],
            Cycle::Returns(state, _) => state,
        }
    }
    pub fn turns(&self) -> usize {
        match self {
            Cycle::Orbit(orbit) => orbit.least_period_multiple(),
            Cycle::Returns(_, turns) => *turns,
        }
    }
}

/// The motion of a converged sweep: one that repeats, or a state on one that does not.
pub struct Motion {
    pub start: State,
    pub cycle: Option<Cycle>,
    pub speed: f64,
}

pub fn shooting() -> Shooting {
    Shooting::new().tolerance(1e-9).flow_tolerance(1e-13).max_iterations(16)
}

/// The state after a run of at most so many [`turns`] from `start`, and the stable motion of up to `TURNS` turns near
/// it, if there is one. A run that repeats near an unstable orbit has not settled and goes on. A run that has come near
/// a return without settling is shot for the numbers of turns of its nearest returns. Where shooting finds no orbit,
/// returns within `CLOSE` over some more turns decide.
pub fn settled(pair: &NfgPair, start: &State) -> Outcome<(State, Option<Cycle>)> {
    let settle = Settle::new().tolerance(1e-5).max_periods(turns()[0]).max_period_multiple(TURNS);
    let stable = |state: &State, turns: usize| {
        let cycle = shooting().period_multiple(turns).solve(pair, state).ok();
        cycle.filter(|cycle| cycle.stability() == Stability::Stable)
    };
    let mut state = match settle.run(&solver(), pair, start) {
        Ok(steady) => {
            let state = State { t: 0.0, ..steady.state };
            if let Some(cycle) = stable(&state, steady.period_multiple) {
                return Ok((state, Some(Cycle::Orbit(Box::new(cycle)))));
            }
            solver().end(pair, &state, turns()[0] as f64 * pair.period())?
        }
        Err(SettleError::Aperiodic { last, .. }) => last,
        Err(failed) => return Err(failed.into()),
    };
    state.t = 0.0;
    if let Some(cycle) = nearest_returns(pair, &state)?.into_iter().find_map(|turns| stable(&state, turns)) {
        return Ok((state, Some(Cycle::Orbit(Box::new(cycle)))));
    }
    let close = Settle::new().tolerance(CLOSE).max_periods(8 * TURNS).max_period_multiple(TURNS);
    let cycle = match close.run(&solver(), pair, &state) {
        Ok(steady) => Some(Cycle::Returns(State { t: 0.0, ..steady.state }, steady.period_multiple)),
        Err(SettleError::Aperiodic { .. }) => None,
        Err(failed) => return Err(failed.into()),
    };
    Ok((state, cycle))
}

/// The numbers of turns, up to `TURNS`, after which the motion returns nearest to `start`, or ten times as far; none if
/// it comes no nearer than 1 % of the gap.
fn nearest_returns(pair: &NfgPair, start: &State) -> Outcome<Vec<usize>> {
    let (mut state, mut apart) = (start.clone(), Vec::with_capacity(TURNS));
    for _ in 0..TURNS {
        state = solver().end(pair, &state, state.t + pair.period())?;
        apart.push((state.q[0] - start.q[0]).abs().max((state.v[0] - start.v[0]).abs()));
    }
    let nearest = apart.iter().fold(f64::INFINITY, |least, apart| least.min(*apart));
    let near =
        |turns: &usize| apart[turns - 1] <= 10.0 * nearest && nearest < 0.02 * pair.half_backlash_angle();
    Ok((1..=TURNS).filter(near).collect())
}

/// The motion to which a run from the previous motion settles, polished if it repeats.
pub fn converged(pair: &NfgPair, before: Option<&Motion>) -> Outcome<(Motion, Point)> {
    let speed = pair.speed();
    let motion = |start: State, cycle: Option<Cycle>| Motion { start, cycle, speed };
    let start = match before {
        // The same phase; velocities are proportional to the speed.
        Some(b) => State::new(0.0, &b.start.q, &[b.start.v[0] * speed / b.speed]),
        None => pair.on_drive_flank()?,
    };
    let (state, cycle) = settled(pair, &start)?;
    if let Some(cycle) = cycle {
        let point = on_cycle(pair, &cycle)?;
        return Ok((motion(cycle.start().clone(), Some(cycle)), point));
    }
    let (mut rattle, mut statistics) = (Rattle::new(pair), Statistics::new(pair, &["q0", ELASTIC])?);
    let run =
        solver().run(pair, &state, turns()[1] as f64 * pair.period(), &mut (&mut rattle, &mut statistics))?;
    Ok((motion(run.state, None), seen(&rattle, &statistics, "aperiodic")?))
}

fn seen(rattle: &Rattle<'_>, statistics: &Statistics<'_>, stable: &'static str) -> Outcome<Point> {
    let ppv = |channel| statistics.summary(channel).map(|s| s.peak_to_peak());
    Ok(Point { state: rattle.contacts()[0].rattle_state(), ppv: ppv("q0")?, elastic: ppv(ELASTIC)?, stable })
}

pub fn on_cycle(pair: &NfgPair, cycle: &Cycle) -> Outcome<Point> {
    let (mut rattle, mut statistics) = (Rattle::new(pair), Statistics::new(pair, &["q0", ELASTIC])?);
    let mut both = (&mut rattle, &mut statistics);
    let stability = match cycle {
        Cycle::Orbit(orbit) => {
            orbit.observe(pair, &mut both)?;
            orbit.stability()
        }
        Cycle::Returns(state, turns) => {
            solver().run(pair, state, state.t + *turns as f64 * pair.period(), &mut both)?;
            Stability::Stable
        }
    };
    seen(&rattle, &statistics, word(Some(stability)))
}
