//! The generic form of a model against the plain one.

use super::point::Point;
use super::{FINE, Finding, GOLDEN, ROUNDING, check_periodic, differ};
use crate::model::{AsIs, Contact, Generic, OnPieces, Periodic, State};
use crate::piece::{Piece, Side};

/// The same as [`check_periodic`], and the generic form against the plain one.
pub fn check_generic<M: Generic + Periodic>(model: &M, typical: &State) -> Vec<Finding> {
    let mut findings = check_periodic(model, typical);
    if findings.iter().any(|f| matches!(f, Finding::State { .. } | Finding::BadPeriod { .. })) {
        return findings;
    }
    let n = model.dof();
    let mut point = Point::new(model, typical);
    point.measure();
    let (mut u, mut w) = (vec![0.0; model.drives()], vec![0.0; model.drives()]);
    let (mut a, mut b) = (vec![0.0; n], vec![0.0; n]);
    let compare = |a: &[f64], b: &[f64], findings: &mut Vec<Finding>| {
        for component in 0..n {
            let (generic, plain) = (a[component], b[component]);
            if differ(generic, plain, ROUNDING / FINE * point.terms[component], FINE) {
                findings.push(Finding::Generic { component, generic, plain });
            }
        }
    };
    model.drive(typical.t, Side::After, &mut u);
    model.accel_on(&AsIs, &u, &typical.q, &typical.v, &mut a);
    model.accel(&u, &typical.q, &typical.v, &mut b);
    compare(&a, &b, &mut findings);
    let pieces = vec![Piece::Gap; model.contacts()];
    model.accel_on(&OnPieces(&pieces), &u, &typical.q, &typical.v, &mut a);
    if model.accel_on_pieces(&pieces, &u, &typical.q, &typical.v, &mut b) {
        compare(&a, &b, &mut findings);
    }
    if model.phases() > model.drives() {
        findings.push(Finding::Phases { phases: model.phases(), drives: model.drives() });
        return findings;
    }
    // Shapes of phase below `phases`, constants of the run above: each is held against the plain drives at several instants.
    let mut constants = vec![f64::NAN; model.drives()];
    model.constants(&mut constants);
    for i in 0..4 {
        let share = (f64::from(i) * GOLDEN).fract();
        let t = typical.t + share * model.period();
        model.drive(t, Side::After, &mut u);
        w.fill(f64::NAN);
        let phase = (t / model.period()).rem_euclid(1.0);
        model.phase_drives(std::f64::consts::TAU * phase, Side::After, &mut w);
        w[model.phases()..].copy_from_slice(&constants[model.phases()..]);
        let size = u.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        for drive in 0..u.len() {
            if differ(w[drive], u[drive], 1e-6 * size, FINE)
                && !findings.iter().any(|f| matches!(f, Finding::Split { drive: d, .. } if *d == drive))
            {
                findings.push(Finding::Split { drive, split: w[drive], plain: u[drive] });
            }
        }
    }
    // Contacts, where the generic form has them.
    let contacts = model.contacts();
    let (mut plain, mut generic) = (vec![Contact::default(); contacts], vec![Contact::default(); contacts]);
    model.drive(typical.t, Side::After, &mut u);
    model.contact(&u, &typical.q, &typical.v, &mut plain);
    if model.contact_on(0..contacts, &u, &typical.q, &typical.v, &mut generic) {
        for (contact, (a, b)) in generic.iter().zip(&plain).enumerate() {
            let all = |c: &Contact| [c.deflection, c.rate, c.lower, c.upper, c.lower_rate, c.upper_rate, c.force];
            for (generic, plain) in all(a).into_iter().zip(all(b)) {
                if generic != plain && differ(generic, plain, 0.0, FINE) {
                    findings.push(Finding::GenericContact { contact, generic, plain });
                }
            }
        }
    }
    findings
}
