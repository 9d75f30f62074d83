//! The checks of a model near one state.

use crate::check::inconsistency::Inconsistency;
use crate::check::point::Point;
use crate::check::tolerances::{GOLDEN, ROUNDING};
use crate::excitation::side::Side;
use crate::model::equations::{Model, Periodic, State};
use crate::ode::probe::Probe;

/// Looks for contradictions near a typical state, whose size sets the scale of the differences.
///
/// Drives against their edges, Jacobian against differences, pieces and contacts against the acceleration. An empty list is good news. A
/// factor that is wrong throughout the force of a contact stays unseen, since masses are not known, and so does damping that it lacks.
pub fn check_model<M: Model + ?Sized>(model: &M, typical: &State) -> Vec<Inconsistency> {
    check_over(model, typical, None)
}

/// The same with the period of the drives, if it is known.
fn check_over<M: Model + ?Sized>(model: &M, typical: &State, period: Option<f64>) -> Vec<Inconsistency> {
    let mut findings = Vec::new();
    if (typical.q.len(), typical.v.len()) != (model.dof(), model.dof()) {
        return vec![Inconsistency::State { given: [typical.q.len(), typical.v.len()], dof: model.dof() }];
    }
    let mut at = Point::new(model, typical);
    at.finite(&mut findings);
    if findings.is_empty() {
        at.measure();
        at.jacobian(&mut findings);
        at.pieces(&mut findings);
        at.rates(period, &mut findings);
        at.kinks(&mut findings);
        if !findings.iter().any(|f| matches!(f, Inconsistency::Kink { .. })) {
            at.untold_kinks(&mut findings);
        }
        crate::check::drives::check(model, typical, period, &mut findings);
    }
    findings
}

/// The same, and accelerations and contacts against the period: of all that does not repeat, what is off the most.
pub fn check_periodic<M: Periodic + ?Sized>(model: &M, typical: &State) -> Vec<Inconsistency> {
    let period = Some(model.period()).filter(|period| *period > 0.0 && period.is_finite());
    let mut findings = check_over(model, typical, period);
    if findings.iter().any(|f| matches!(f, Inconsistency::State { .. })) {
        return findings;
    }
    let Some(period) = period else {
        findings.push(Inconsistency::BadPeriod { period: model.period() });
        return findings;
    };
    let mut point = Point::new(model, typical);
    point.measure();
    // Drives may well not repeat, as time itself; what comes of them has to.
    let mut probe = Probe::new(model);
    let mut seen = |t: f64| -> [Vec<f64>; 2] {
        let mut a = vec![0.0; model.dof()];
        let mut u = vec![0.0; model.drives()];
        model.drive(t, Side::After, &mut u);
        model.accel(&u, &typical.q, &typical.v, &mut a);
        let contacts = probe.read_contacts(t, Side::After, &typical.q, &typical.v);
        [a, contacts.iter().flat_map(|c| [c.deflection - c.lower, c.deflection - c.upper]).collect()]
    };
    let gap_terms: Vec<f64> = point.reach.iter().flat_map(|reach| [*reach; 2]).collect();
    let mut worst = [(0.0, None), (0.0, None)];
    for i in 1..=16 {
        let t = typical.t + (f64::from(i) * GOLDEN).fract() * period;
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
