//! Constructors of models, and the functions of accepted models.

use super::laws;
use crate::case::{Case, Run, Stop, all_finite, finite, holds};
use crate::models;
use gear_dynamics::contact::Contact;
use gear_dynamics::drives::Noisy;
use gear_dynamics::excitation::Side;
use gear_dynamics::model::Jacobian;
use gear_dynamics::models::nfg::NfgPair2;
use gear_dynamics::{Model, NfgPair, Periodic, State};

/// Checks that drives, acceleration and contacts at a state are finite and that the edges are in order.
pub fn speaks(model: &(impl Model + ?Sized), state: &State) -> Run {
    speaks_numbers(model, state)?;
    let (mut u, mut contacts) = (vec![0.0; model.drives()], vec![Contact::default(); model.contacts()]);
    model.drive(state.t, Side::After, &mut u);
    model.contact(&u, &state.q, &state.v, &mut contacts);
    contacts.iter().try_for_each(|contact| holds(contact.lower <= contact.upper, || format!("{contact:?}")))
}

/// The same without the order of the edges: a half backlash that varies may become negative, which `check_model`
/// reports.
pub fn speaks_numbers(model: &(impl Model + ?Sized), state: &State) -> Run {
    let n = model.dof();
    let (mut u, mut a) = (vec![0.0; model.drives()], vec![0.0; n]);
    let mut contacts = vec![Contact::default(); model.contacts()];
    model.drive(state.t, Side::After, &mut u);
    // A law without an edge has an infinite one.
    holds(!u.iter().any(|u| u.is_nan()), || format!("drives {u:?}"))?;
    model.accel(&u, &state.q, &state.v, &mut a);
    all_finite("acceleration", &a)?;
    model.contact(&u, &state.q, &state.v, &mut contacts);
    for (i, contact) in contacts.iter().enumerate() {
        all_finite(format_args!("contact {i}"), &[contact.deflection, contact.rate, contact.force])?;
    }
    let mut jacobian = Jacobian::new(n);
    if model.offers().jacobian {
        model.jacobian(None, &u, &state.q, &state.v, &mut jacobian);
        all_finite("∂a/∂q", jacobian.q.as_slice())?;
        all_finite("∂a/∂v", jacobian.v.as_slice())?;
    }
    let edge = model.next_edge(state.t);
    holds(edge.is_none_or(|edge| edge > state.t), || format!("next_edge({:e}) is {edge:?}", state.t))
}

/// The face gear pair of one degree of freedom.
pub fn pair(case: &mut Case) -> Run {
    let (params, reading) = (models::pair_params(case), models::reading(case));
    if case.chance(0.5) {
        let own = models::own_pair(case)?;
        let start = own.on_drive_flank()?;
        return speaks_numbers(&own, &start);
    }
    let pair = NfgPair::of_reading(&params, reading)?;
    let figures = [pair.mean_radius(), pair.natural_frequency(), pair.half_backlash_angle(), pair.period()];
    all_finite("mean radius, natural frequency, half backlash, period", &figures)?;
    holds(pair.period() > 0.0, || format!("period {:e}", pair.period()))?;
    let start = pair.on_drive_flank()?;
    all_finite("static start", &[start.t, start.q[0], start.v[0]])?;
    speaks(&pair, &start)
}

/// The face gear pair of two degrees of freedom.
pub fn pair2(case: &mut Case) -> Run {
    let (params, reading) = (models::pair_params(case), models::reading(case));
    if case.chance(0.5) {
        let own = models::own_pair2(case)?;
        let start = own.on_drive_flank()?;
        return speaks_numbers(&own, &start);
    }
    let pair = NfgPair2::of_reading(&params, case.number(0.01), reading)?.with_torque(case.number(10.0))?;
    all_finite("damping, period", &[pair.damping(), pair.period()])?;
    holds(pair.period() > 0.0, || format!("period {:e}", pair.period()))?;
    let start = pair.on_drive_flank()?;
    all_finite("static start", &[start.q[0], start.q[1], start.v[0], start.v[1]])?;
    speaks(&pair, &start)
}

/// Rings, their matrices, modes and relative coordinates.
pub fn ring(case: &mut Case) -> Run {
    let ring = models::ring(case)?;
    let n = ring.gears();
    all_finite(
        "imbalance, acceleration, period",
        &[ring.torque_imbalance(), ring.rigid_acceleration(), ring.period()],
    )?;
    all_finite("rigid motion", ring.rigid_motion())?;
    let mean = ring.mean_mesh_stiffness();
    all_finite("mean mesh stiffness", &mean)?;
    speaks_numbers(&ring, &State::at_rest(ring.dof()))?;
    all_finite("mass", ring.mass_matrix().as_slice())?;
    all_finite("damping", ring.damping_matrix().as_slice())?;
    let stiffness = if case.chance(0.5) { mean } else { case.list(n, 1e8) };
    all_finite("stiffness", ring.stiffness_matrix(&stiffness)?.as_slice())?;
    if let Some(modes) = case.accept(gear_dynamics::linear::Modes::mean_in_contact(&ring)) {
        all_finite("frequencies", &modes.frequencies())?;
        modes.all().iter().try_for_each(|mode| all_finite("shape of a mode", mode.shape()))?;
        modes.eigenvalues().iter().try_for_each(|value| all_finite("eigenvalue", &[value.re, value.im]))?;
    }
    let view = ring.relative(case.number(1e-5), case.number(1e4))?;
    let (q, v) = view.of(&State::at_rest(ring.dof()));
    all_finite("relative q", &q)?;
    all_finite("relative v", &v)?;
    let mut moved: (Vec<f64>, Vec<f64>) = (case.list(q.len(), 1.0), case.list(v.len(), 1.0));
    let t = case.number(1e-3);
    if moved.0.len() == q.len() && moved.1.len() == v.len() {
        view.close(t, &mut moved.0, &mut moved.1)?;
    }
    let state = view.to_angles(t, &moved.0, &moved.1)?;
    all_finite("angles", &state.q)?;
    let (c, k) = view.coefficients(&stiffness)?;
    all_finite("relative damping", c.as_slice())?;
    all_finite("relative stiffness", k.as_slice())
}

/// A pair with held processes on existing and other slots.
pub fn held_pair(case: &mut Case) -> Result<(Noisy<NfgPair>, State), Stop> {
    let pair = NfgPair::new(&models::pair_params(case))?;
    let start = pair.on_drive_flank()?;
    let mut held = Noisy::new(pair);
    for _ in 0..1 + case.below(3) {
        let process = laws::process(case, 20.0, 1e-3)?;
        let mut slots: Vec<usize> = (0..case.below(3))
            .map(|_| if case.hostile() { case.count(12) } else { case.below(12) })
            .collect();
        let name = case.pick(&["load torque", "damping ratio", "speed", "no such constant"]);
        slots.extend(held.bare().slot(name).ok());
        let gains = case.list(slots.len(), 1.0);
        let slots: Vec<(usize, f64)> = slots.into_iter().zip(gains).collect();
        case.note(|| format!("slots {slots:?}, {process:?}, first {:?}", process.held(0, 0)));
        held = held.add(&slots, &process)?;
    }
    Ok((held, start))
}

/// The drives of such a pair.
pub fn held(case: &mut Case) -> Run {
    let (held, start) = held_pair(case)?;
    finite("speed", held.bare().constant("speed")?)?;
    let mut t = 0.0;
    for _ in 0..10 {
        let mut u = vec![0.0; held.drives()];
        held.drive(t, case.pick(&[Side::Before, Side::After]), &mut u);
        all_finite(format_args!("drives at {t:e}"), &u)?;
        let edge = held.next_edge(t);
        holds(edge.is_none_or(|edge| edge > t), || format!("next_edge({t:e}) is {edge:?}"))?;
        t = edge.unwrap_or(t + 1.0);
    }
    let _ = start;
    Ok(())
}
