//! The checks of a model near one state.

use crate::check::inconsistency::Inconsistency;
use crate::check::point::CheckPoint;
use crate::check::tolerances::ROUNDING;
use crate::contact::edge::Edge;
use crate::excitation::Side;
use crate::model::{Model, Periodic, State};
use crate::numeric::spread::golden;
use crate::ode::probe::Probe;

/// Checks a model for inconsistencies near a typical state. Returns the findings; an empty list if there are
/// none. The magnitude of the typical state sets the steps of finite differences.
///
/// The checks compare:
/// - what [`Model::offers`] declares with what the model implements;
/// - the Jacobian with differences of `accel`, and `accel_on_pieces` with `accel`;
/// - the rates of contacts and edges with differences of deflections and edges in time. This is done at the
///   instant of the state and at four more phases of the period. A model without period is checked at four
///   instants within each of 1, 1e-3, 1e3 and 1e-6 units of time;
/// - edges, forces and impacts of contacts with the kinks and jumps of `accel`;
/// - the drives with the edges that `next_edge` returns.
///
/// Three errors are not found: a constant factor in the force of a contact, because masses are not known;
/// missing damping in the force of a contact, if the damping acts in the gap as well; a jump that `accel`
/// makes of the time, because only jumps of drives are compared with `next_edge`.
pub fn check_model(model: &dyn Model, typical: &State) -> Vec<Inconsistency> {
    check_over(model, typical, None)
}

/// Checks a model. `period`: the period of the drives, if it is known.
fn check_over(model: &dyn Model, typical: &State, period: Option<f64>) -> Vec<Inconsistency> {
    let mut findings = Vec::new();
    if (typical.q.len(), typical.v.len()) != (model.dof(), model.dof()) {
        return vec![Inconsistency::State { given: [typical.q.len(), typical.v.len()], dof: model.dof() }];
    }
    let mut at = CheckPoint::new(model, typical);
    at.finite(&mut findings);
    if findings.is_empty() {
        at.offers(&mut findings);
    }
    if findings.is_empty() {
        at.measure();
        at.jacobian(&mut findings);
        at.pieces(&mut findings);
        at.rates(period, &mut findings);
        at.kinks(&mut findings);
        if !findings.iter().any(|f| matches!(f, Inconsistency::Kink { .. })) {
            at.undeclared_kinks(&mut findings);
        }
        crate::check::drives::check(model, typical, period, &mut findings);
    }
    findings
}

/// Checks a periodic model: the checks of [`check_model`], and whether accelerations and distances from edges
/// repeat with the period. Of those that do not repeat, the one with the largest deviation is reported.
pub fn check_periodic(model: &dyn Periodic, typical: &State) -> Vec<Inconsistency> {
    let period = Some(model.period()).filter(|period| *period > 0.0 && period.is_finite());
    let mut findings = check_over(model, typical, period);
    if findings.iter().any(|f| matches!(f, Inconsistency::State { .. })) {
        return findings;
    }
    let Some(period) = period else {
        findings.push(Inconsistency::BadPeriod { period: model.period() });
        return findings;
    };
    let mut point = CheckPoint::new(model, typical);
    point.measure();
    // The drives themselves need not repeat: one of them may be time. Accelerations and contacts must repeat.
    let mut probe = Probe::new(model);
    let mut seen = |t: f64| -> [Vec<f64>; 2] {
        let mut a = vec![0.0; model.dof()];
        let mut u = vec![0.0; model.drives()];
        model.drive(t, Side::After, &mut u);
        model.accel(&u, &typical.q, &typical.v, &mut a);
        let contacts = probe.read_contacts(t, Side::After, &typical.q, &typical.v);
        [a, contacts.iter().flat_map(|c| Edge::BOTH.map(|edge| edge.distance(c))).collect()]
    };
    let gap_terms: Vec<f64> = point.reach.iter().flat_map(|reach| [*reach; 2]).collect();
    let mut worst = [(0.0, None), (0.0, None)];
    for i in 1..=16 {
        let t = typical.t + golden(f64::from(i)) * period;
        let (one, two) = (seen(t), seen(t + period));
        for (k, (what, terms)) in
            [("acceleration", &point.terms), ("gap", &gap_terms)].into_iter().enumerate()
        {
            let size = one[k].iter().filter(|x| x.is_finite()).fold(0.0, |m: f64, x| m.max(x.abs()));
            for (index, (&first, &second)) in one[k].iter().zip(&two[k]).enumerate() {
                let allowed = 1e-6 * (size + first.abs().max(second.abs())) + ROUNDING * terms[index];
                let off =
                    if (first - second).is_nan() { f64::INFINITY } else { (first - second).abs() / allowed };
                if first != second && off > 1.0 && off > worst[k].0 {
                    worst[k] = (off, Some(Inconsistency::Period { what, index, t, first, second }));
                }
            }
        }
    }
    let [acceleration, gap] = worst.map(|(_, finding)| finding);
    findings.extend(acceleration.or(gap));
    findings
}
