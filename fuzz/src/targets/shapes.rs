//! Shapes of a user with mistakes, and the named constants of every machine.

use super::build::speaks;
use super::excitations::wave;
use super::sweeps;
use crate::case::{Case, Run, Stop, all_finite, finite, holds};
use crate::models;
use gear_dynamics::contact::{Contact, Deflection, PieceChoice};
use gear_dynamics::drives::Driven;
use gear_dynamics::excitation::{Angle, Side};
use gear_dynamics::model::{Channel, Drives, Scalar, Size};
use gear_dynamics::{
    Backlash, Integrator, Machine, Model, NfgPair, ParameterError, Periodic, Rk45, Shape, State, Wave,
};

/// Mistakes in a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Slip {
    None,
    /// Names of the constants: none, one missing, one repeated, one too many.
    Names(usize),
    /// A size that contradicts the rest of the shape: which entry, and its value.
    Size(usize, usize),
    /// Number of prepared constants.
    Prepared(usize),
    /// Value of the first prepared constant, the speed.
    Speed(f64),
    /// `check` refuses all constants.
    Refused,
    /// Value of wave 0 at all angles.
    Wave(f64),
    /// Wave 0 is proportional to the angle.
    Growing,
    /// Distance of the next edge from any angle.
    Edge(f64),
    /// Number of repetitions of the waves in a turn.
    Repeats(u32),
    /// Value of the acceleration.
    Acceleration(f64),
}

/// q'' + c q' + k(φ) q + s f(q - e(φ)) = F: a shape that a user might write, with mistakes.
#[derive(Clone, Debug, PartialEq)]
pub struct Own {
    stiffness: Wave,
    error: Wave,
    law: Backlash,
    slip: Slip,
}

impl Own {
    /// Whether the channels are finite while the motion is.
    pub fn is_sound(&self) -> bool {
        self.slip == Slip::None
    }
}

const NAMES: [&str; 5] = ["speed", "force", "damping", "contact stiffness", "half backlash"];

impl Shape for Own {
    fn size(&self) -> Size {
        let mut size = Size { dof: 1, waves: 3, contacts: 1, constants: 5, ..Size::default() };
        if let Slip::Size(of, count) = self.slip {
            *[&mut size.dof, &mut size.waves, &mut size.contacts, &mut size.constants][of] = count;
        }
        size
    }
    fn names(&self) -> Vec<Channel> {
        let mut names = NAMES.map(|name| Channel::new(name, "1")).to_vec();
        match self.slip {
            Slip::Names(0) => names.clear(),
            Slip::Names(1) => drop(names.pop()),
            Slip::Names(2) => names[1] = names[2].clone(),
            Slip::Names(_) => names.push(Channel::new("", "")),
            _ => {}
        }
        names
    }
    fn check(&self, constants: &[f64]) -> Result<(), ParameterError> {
        match self.slip {
            Slip::Refused => {
                Err(ParameterError::NotFinite { name: NAMES[0].into(), value: constants.len() as f64 })
            }
            _ => Ok(()),
        }
    }
    fn prepare<S: Scalar>(&self, constants: &[S]) -> Vec<S> {
        let mut prepared = constants.to_vec();
        match (self.slip, prepared.first_mut()) {
            (Slip::Prepared(count), _) => prepared.resize(count, S::from(1.0)),
            (Slip::Speed(speed), Some(first)) => *first = S::from(speed),
            (_, Some(first)) => *first = *first * 2.0,
            _ => {}
        }
        prepared
    }
    fn repeats(&self) -> u32 {
        match self.slip {
            Slip::Repeats(repeats) => repeats,
            _ => Wave::common_order([&self.stiffness, &self.error]),
        }
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        let error = self.error.jet(angle, side);
        let mut waves = [self.stiffness.value(angle, side), error.value, error.rate];
        match self.slip {
            Slip::Wave(value) => waves[0] = value.into(),
            Slip::Growing => waves[0] = angle.number(),
            _ => {}
        }
        u.iter_mut().zip(waves).for_each(|(u, wave)| *u = wave);
    }
    fn next_edge(&self, angle: f64) -> Option<f64> {
        match self.slip {
            Slip::Edge(ahead) => Some(angle + ahead),
            _ => [self.stiffness.next_edge(angle), self.error.next_edge(angle)]
                .into_iter()
                .flatten()
                .reduce(f64::min),
        }
    }
    fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        i: usize,
        u: Drives<'_, S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let ([_, e, rate], [_, _, stiffness, b]) = (u.waves(), u.constants());
        let (deflection, rate) = (q[0] - e, v[0] - rate * u.speed());
        let force =
            stiffness * law.force(i, &self.law, Deflection { d: deflection, rate, lower: -b, upper: b });
        Contact { deflection, rate, lower: -b, upper: b, force, ..Contact::default() }
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let ([stiffness], [force, damping]) = (u.waves(), u.constants());
        let first = force - damping * v[0] - stiffness * q[0] - self.contact(law, 0, u, q, v).force;
        a.fill(match self.slip {
            Slip::Acceleration(value) => S::from(value),
            _ => first,
        });
    }
}

fn slip(case: &mut Case) -> Slip {
    if !case.hostile() {
        return Slip::None;
    }
    let (count, value) = (case.below(8), case.number(1.0));
    match case.below(10) {
        0 => Slip::Names(count % 4),
        1 => Slip::Size(case.below(4), count),
        2 => Slip::Prepared(count),
        3 => Slip::Speed(value),
        4 => Slip::Refused,
        5 => Slip::Wave(value),
        6 => Slip::Growing,
        7 => Slip::Edge(value),
        8 => Slip::Repeats(case.count(2) as u32),
        _ => Slip::Acceleration(value),
    }
}

/// A user's machine with any values of its constants.
pub fn machine(case: &mut Case) -> Result<Machine<Own>, Stop> {
    let b = Backlash::new(case.quantity(0.5).abs())?;
    let shape = Own { stiffness: wave(case, 1, 1.0)?, error: wave(case, 1, 0.1)?, law: b, slip: slip(case) };
    case.note(|| format!("{shape:?}"));
    let mut constants: Vec<(&str, f64)> =
        NAMES.iter().zip([1.0, 0.5, 0.1, 10.0, 0.5]).map(|(name, x)| (*name, case.number(x))).collect();
    // A negative half backlash is reported by the check of the model.
    constants[4].1 = constants[4].1.abs();
    if case.hostile() {
        match case.below(4) {
            0 => drop(constants.pop()),
            1 => constants.push(("force", 1.0)),
            2 => constants.push(("no such constant", 1.0)),
            _ => constants.reverse(),
        }
    }
    case.note(|| format!("{constants:?}"));
    Ok(Machine::of_constants(shape, &constants)?)
}

/// A user's shape: an accepted one has finite numbers and runs in lanes.
pub fn own(case: &mut Case) -> Run {
    let machine = machine(case)?;
    if machine.shape().is_sound() {
        speaks(&machine, &State::at_rest(machine.dof()))?;
    }
    finite("period", machine.period())?;
    holds(machine.period() > 0.0, || format!("period {:e}", machine.period()))?;
    named(case, &machine)?;
    if matches!(machine.shape().slip, Slip::Size(..)) {
        return Ok(()); // the algebra of this shape may index beyond another size
    }
    sweeps::machines(case, &machine, "force")
}

/// Values, slots and slopes by name, good names and bad ones.
pub fn named<G: Shape>(case: &mut Case, machine: &Machine<G>) -> Run {
    let mut names: Vec<String> = machine.names().iter().map(|channel| channel.name.clone()).collect();
    let known = names.len();
    holds(machine.shares_lanes_with(machine) && *machine == machine.clone(), || {
        "a copy is another machine".into()
    })?;
    let mut other = machine.clone();
    for _ in 0..4 {
        if case.hostile() {
            names.extend(["", "no such constant", "Speed"].map(String::from));
        }
        let name = case.pick(&names);
        let exists = names[..known].contains(&name);
        let value = case.accept(machine.constant(&name));
        holds(value.is_some() == exists, || format!("constant \"{name}\" is {value:?}"))?;
        let size = value.unwrap_or(1.0);
        let next = case.number(if size == 0.0 { 1.0 } else { size });
        case.note(|| format!("with \"{name}\" = {next:e}"));
        if let Some(with) = case.accept(other.with(&name, next)) {
            holds(exists && with.constant(&name)? == next, || format!("\"{name}\" is not {next:e}"))?;
            holds(with.shares_lanes_with(machine), || "another constant, another shape".into())?;
            all_finite("prepared constants", with.prepared_constants())?;
            finite("period", with.period())?;
            other = with;
        }
        // Most constants are converted and are not drives.
        let slot = machine.slot(&name).ok();
        holds(slot.is_none_or(|slot| exists && slot < machine.drives()), || {
            format!("slot of \"{name}\": {slot:?}")
        })?;
        let mut u = vec![0.0; machine.drives()];
        machine.drive(case.signed(), Side::After, &mut u);
        holds(slot.is_none_or(|slot| u[slot] == size), || format!("slot of \"{name}\": {slot:?} of {u:?}"))?;
        let short = case.hostile();
        let rest = vec![0.0; if short { machine.dof() + 1 } else { machine.dof() }];
        let slope = case.accept(machine.slope(&name, &u, &rest, &rest));
        holds(slope.is_none() || (exists && !short), || format!("slope by \"{name}\": {slope:?}"))?;
        holds(slope.is_none_or(|slope| slope.len() == machine.dof()), || "a slope of another length".into())?;
    }
    Ok(())
}

/// The named constants of the models of the crate.
pub fn names(case: &mut Case) -> Run {
    match case.below(4) {
        0 => {
            let model = models::own_pair(case)?;
            named(case, &model)
        }
        1 => {
            let model = models::own_pair2(case)?;
            named(case, &model)
        }
        2 => {
            let (params, reading) = (models::pair_params(case), models::reading(case));
            named(case, &NfgPair::of_reading(&params, reading)?)
        }
        _ => {
            let model = models::ring(case)?;
            named(case, &model)
        }
    }
}

/// Functions of time on existing and other drives.
pub fn driven(case: &mut Case) -> Run {
    let pair = NfgPair::new(&models::pair_params(case))?;
    let start = pair.on_drive_flank()?;
    let mut driven = Driven::new(pair);
    for _ in 0..1 + case.below(2) {
        // Rates of waves are not changed: moving edges with wrong rates make runs very slow.
        let slot =
            if case.hostile() { 4 + case.count(12).min(1 << 60) } else { case.pick(&[0, 4, 8, 9, 10, 11]) };
        let edges: Vec<f64> = (0..case.below(4)).map(|_| case.number(10.0) * case.signed()).collect();
        let (scale, at) = (case.quantity(1e-3), edges.first().copied().unwrap_or(0.0));
        case.note(|| format!("slot {slot}, edges {edges:?}, scale {scale:e}"));
        driven = driven.add(slot, move |t| if t < at { 0.0 } else { scale }, &edges)?;
    }
    let mut t = -1.0;
    for _ in 0..10 {
        let mut u = vec![0.0; driven.drives()];
        driven.drive(t, case.pick(&[Side::Before, Side::After]), &mut u);
        all_finite(format_args!("drives at {t:e}"), &u)?;
        let edge = driven.next_edge(t);
        holds(edge.is_none_or(|edge| edge > t), || format!("next_edge({t:e}) is {edge:?}"))?;
        t = edge.unwrap_or(t + 1.0);
    }
    let end = Rk45::new().rtol(1e-6).atol(1e-12).max_steps(4_000).end(&driven, &start, case.number(10.0))?;
    all_finite("q under functions of time", &end.q)
}
