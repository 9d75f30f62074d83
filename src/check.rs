//! What is inconsistent in a model.

mod finding;

pub use finding::Finding;

use crate::channel::Probe;
use crate::model::{AsIs, Contact, Generic, Jacobian, Model, OnPieces, Periodic, State};
use crate::piece::{Piece, Side};

/// Relative agreement asked of differences, and of two ways to one number.
const ROUGH: f64 = 1e-4;
const FINE: f64 = 1e-9;

/// Whether two numbers part by more than a share of their size; a NaN always does.
fn differ(a: f64, b: f64, scale: f64, tolerance: f64) -> bool {
    let apart = (a - b).abs();
    apart.is_nan() || apart > tolerance * (scale.abs() + a.abs().max(b.abs()))
}

/// Looks for contradictions near a typical state, whose size sets the scale of the differences.
///
/// Drives against their edges, Jacobian against differences, pieces and contacts against the acceleration. An empty list is good news.
pub fn check_model<M: Model + ?Sized>(model: &M, typical: &State) -> Vec<Finding> {
    let mut findings = Vec::new();
    if (typical.q.len(), typical.v.len()) != (model.dof(), model.dof()) {
        return vec![Finding::State { given: [typical.q.len(), typical.v.len()], dof: model.dof() }];
    }
    let mut at = Point::new(model, typical);
    at.finite(&mut findings);
    if findings.is_empty() {
        at.jacobian(&mut findings);
        at.pieces(&mut findings);
        at.contact_rates(&mut findings);
        at.kinks(&mut findings);
        edges(model, typical.t, &mut findings);
    }
    findings
}

/// The same, and accelerations and contacts against the period.
pub fn check_periodic<M: Periodic + ?Sized>(model: &M, typical: &State) -> Vec<Finding> {
    let mut findings = check_model(model, typical);
    if findings.iter().any(|f| matches!(f, Finding::State { .. })) {
        return findings;
    }
    if !(model.period() > 0.0 && model.period().is_finite()) {
        findings.push(Finding::BadPeriod { period: model.period() });
        return findings;
    }
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
    // The golden section visits the period evenly and avoids its edges.
    for i in 1..=16 {
        let t = typical.t + (f64::from(i) * 0.618_033_988_749_894_9).fract() * model.period();
        let (first, second) = (seen(t), seen(t + model.period()));
        for (what, (first, second)) in ["acceleration", "gap"].into_iter().zip(first.iter().zip(&second)) {
            let size = first.iter().filter(|x| x.is_finite()).fold(0.0, |m: f64, x| m.max(x.abs()));
            for (index, (&first, &second)) in first.iter().zip(second).enumerate() {
                if first != second && differ(first, second, size, 1e-6) {
                    findings.push(Finding::Period { what, index, t, first, second });
                }
            }
        }
    }
    findings
}

/// The same, and the generic form against the plain one.
pub fn check_generic<M: Generic + Periodic>(model: &M, typical: &State) -> Vec<Finding> {
    let mut findings = check_periodic(model, typical);
    if findings.iter().any(|f| matches!(f, Finding::State { .. } | Finding::BadPeriod { .. })) {
        return findings;
    }
    let n = model.dof();
    let (mut u, mut w) = (vec![0.0; model.drives()], vec![0.0; model.drives()]);
    let (mut a, mut b) = (vec![0.0; n], vec![0.0; n]);
    model.drive(typical.t, Side::After, &mut u);
    model.accel_on(&AsIs, &u, &typical.q, &typical.v, &mut a);
    model.accel(&u, &typical.q, &typical.v, &mut b);
    for component in 0..n {
        if differ(a[component], b[component], 0.0, FINE) {
            findings.push(Finding::Generic { component, generic: a[component], plain: b[component] });
        }
    }
    let pieces = vec![Piece::Gap; model.contacts()];
    model.accel_on(&OnPieces(&pieces), &u, &typical.q, &typical.v, &mut a);
    if model.accel_on_pieces(&pieces, &u, &typical.q, &typical.v, &mut b) {
        for component in 0..n {
            if differ(a[component], b[component], 0.0, FINE) {
                findings.push(Finding::Generic { component, generic: a[component], plain: b[component] });
            }
        }
    }
    if model.phases() > model.drives() {
        findings.push(Finding::Phases { phases: model.phases(), drives: model.drives() });
        return findings;
    }
    // Shapes of phase below `phases`, constants of the run above: each is held against the plain drives at several instants.
    let mut constants = vec![f64::NAN; model.drives()];
    model.constants(&mut constants);
    for i in 0..4 {
        let share = (f64::from(i) * 0.618_033_988_749_894_9).fract();
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

/// A model at one state.
struct Point<'m, M: ?Sized> {
    model: &'m M,
    state: State,
    u: Vec<f64>,
    /// Size of coordinates and of velocities, for differences.
    size: [f64; 2],
}

impl<'m, M: Model + ?Sized> Point<'m, M> {
    fn new(model: &'m M, state: &State) -> Self {
        let mut u = vec![0.0; model.drives()];
        model.drive(state.t, Side::After, &mut u);
        let largest = |x: &[f64]| x.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let (q, v) = (largest(&state.q), largest(&state.v));
        let size = [if q > 0.0 { q } else { 1.0 }, if v > 0.0 { v } else { 1.0 }];
        Point { model, state: state.clone(), u, size }
    }

    fn accel(&self, q: &[f64], v: &[f64]) -> Vec<f64> {
        let mut a = vec![0.0; self.model.dof()];
        self.model.accel(&self.u, q, v, &mut a);
        a
    }

    fn finite(&mut self, findings: &mut Vec<Finding>) {
        let a = self.accel(&self.state.q, &self.state.v);
        for (what, values) in [("drive", &self.u), ("acceleration", &a)] {
            let bad = values.iter().enumerate().filter(|(_, x)| !x.is_finite());
            findings.extend(bad.map(|(index, _)| Finding::NotFinite { what, index, t: self.state.t }));
        }
        let mut probe = Probe::new(self.model);
        let contacts = probe.read_contacts(self.state.t, Side::After, &self.state.q, &self.state.v);
        for (index, c) in contacts.iter().enumerate() {
            if !(c.deflection + c.rate + c.force).is_finite() || c.lower.is_nan() || c.upper.is_nan() {
                findings.push(Finding::NotFinite { what: "contact", index, t: self.state.t });
            } else if c.lower > c.upper {
                findings.push(Finding::NegativeGap { contact: index, lower: c.lower, upper: c.upper });
            }
        }
    }

    /// Central differences, unless the step meets an edge.
    fn jacobian(&mut self, findings: &mut Vec<Finding>) {
        let n = self.model.dof();
        let mut given = Jacobian::new(n);
        if !self.model.jacobian(None, &self.u, &self.state.q, &self.state.v, &mut given) {
            return;
        }
        for column in 0..2 * n {
            let (half, j) = (column / n, column % n);
            let h = 1e-6 * self.size[half];
            let moved = |sign: f64| {
                let (mut q, mut v) = (self.state.q.clone(), self.state.v.clone());
                if half == 0 {
                    q[j] += sign * h
                } else {
                    v[j] += sign * h
                }
                self.accel(&q, &v)
            };
            let (plus, minus) = (moved(1.0), moved(-1.0));
            let entries = if half == 0 { given.q.column(j) } else { given.v.column(j) };
            for row in 0..n {
                let differences = (plus[row] - minus[row]) / (2.0 * h);
                let rounding = 1e-9 * plus[row].abs() / h;
                if differ(entries[row], differences, rounding, ROUGH) {
                    findings.push(Finding::Jacobian { row, column, given: entries[row], differences });
                }
            }
        }
    }

    fn pieces(&mut self, findings: &mut Vec<Finding>) {
        let pieces: Vec<Piece> = Probe::new(self.model)
            .read_contacts(self.state.t, Side::After, &self.state.q, &self.state.v)
            .iter()
            .map(Contact::piece)
            .collect();
        let mut held = vec![0.0; self.model.dof()];
        if self.model.accel_on_pieces(&pieces, &self.u, &self.state.q, &self.state.v, &mut held) {
            let free = self.accel(&self.state.q, &self.state.v);
            for component in 0..held.len() {
                if differ(held[component], free[component], 0.0, FINE) {
                    findings.push(Finding::Pieces { component, held: held[component], free: free[component] });
                }
            }
        }
    }

    /// d(deflection)/dt and d(edge)/dt along q' = v by central differences in time. The time scale of the drives is not known, so several
    /// steps are tried, and a rate is wrong only if all of them contradict it.
    fn contact_rates(&mut self, findings: &mut Vec<Finding>) {
        let mut probe = Probe::new(self.model);
        let here: Vec<Contact> = probe.read_contacts(self.state.t, Side::After, &self.state.q, &self.state.v).to_vec();
        let still = self.state.v.iter().all(|v| *v == 0.0);
        let longest = 1e-4 * if still { 1.0 } else { (self.size[0] / self.size[1]).min(1.0) };
        let mut moved = |h: f64| {
            let q: Vec<f64> = self.state.q.iter().zip(&self.state.v).map(|(q, v)| q + h * v).collect();
            probe.read_contacts(self.state.t + h, Side::After, &q, &self.state.v).to_vec()
        };
        let steps: Vec<f64> = (0..8).map(|i| longest * 0.1f64.powi(i)).filter(|h| self.state.t + h > self.state.t).collect();
        let sides: Vec<_> = steps.iter().map(|h| (*h, moved(*h), moved(-*h))).collect();
        for (contact, c) in here.iter().enumerate() {
            let wrong = |given: f64, of: &dyn Fn(&Contact) -> f64| {
                let differences = |(h, p, m): &(f64, Vec<Contact>, Vec<Contact>)| (of(&p[contact]) - of(&m[contact])) / (2.0 * h);
                let contradicts = |side: &(f64, Vec<Contact>, Vec<Contact>)| {
                    let rounding = 16.0 * f64::EPSILON * (of(c).abs() + given.abs() * self.state.t.abs()) / side.0;
                    let (found, apart) = (differences(side), (given - differences(side)).abs());
                    apart.is_nan() || apart > ROUGH * given.abs().max(found.abs()) + rounding
                };
                (of(c).is_finite() && sides.iter().all(contradicts)).then(|| sides.first().map_or(f64::NAN, differences))
            };
            if let Some(differences) = wrong(c.rate, &|c| c.deflection) {
                findings.push(Finding::ContactRate { contact, given: c.rate, differences });
            }
            for (given, differences) in
                [(c.lower_rate, wrong(c.lower_rate, &|c| c.lower)), (c.upper_rate, wrong(c.upper_rate, &|c| c.upper))]
            {
                findings.extend(differences.map(|differences| Finding::EdgeRate { contact, given, differences }));
            }
        }
    }

    /// At each finite edge the force must bend or jump: otherwise the edge is not where the kink is.
    fn kinks(&mut self, findings: &mut Vec<Finding>) {
        let n = self.model.dof();
        let mut probe = Probe::new(self.model);
        for contact in 0..self.model.contacts() {
            let mut deflection = |q: &[f64]| probe.read_contacts(self.state.t, Side::After, q, &self.state.v)[contact];
            // The direction in which this deflection grows fastest.
            let base = deflection(&self.state.q);
            let gradient: Vec<f64> = (0..n)
                .map(|j| {
                    let mut q = self.state.q.clone();
                    q[j] += 1e-4 * self.size[0];
                    (deflection(&q).deflection - base.deflection) / (1e-4 * self.size[0])
                })
                .collect();
            let square: f64 = gradient.iter().map(|g| g * g).sum();
            if square == 0.0 || !square.is_finite() {
                continue;
            }
            let to =
                |d: f64| -> Vec<f64> { self.state.q.iter().zip(&gradient).map(|(q, g)| q + (d - base.deflection) * g / square).collect() };
            for edge in [base.lower, base.upper] {
                let gap = base.upper - base.lower;
                if !edge.is_finite() || gap <= 0.0 || !gap.is_finite() {
                    continue;
                }
                // Second difference across the edge against the second difference beside it.
                let h = 1e-3 * gap;
                let bend = |middle: f64| {
                    let [a, b, c] = [middle - h, middle, middle + h].map(|d| self.accel(&to(d), &self.state.v));
                    (0..n).map(|i| (a[i] - 2.0 * b[i] + c[i]).abs()).fold(0.0, f64::max)
                };
                let beside = bend(edge - 0.1 * gap).max(bend(edge + 0.1 * gap));
                if bend(edge) <= 3.0 * beside {
                    findings.push(Finding::Kink { contact, edge });
                }
            }
        }
    }
}

/// Edges lie ahead, and between them the drives do not jump.
fn edges<M: Model + ?Sized>(model: &M, start: f64, findings: &mut Vec<Finding>) {
    let mut t = start;
    for _ in 0..8 {
        let Some(edge) = model.next_edge(t) else {
            break;
        };
        if edge <= t {
            findings.push(Finding::EdgeBehind { t, edge });
            break;
        }
        t = edge;
    }
    // Both sides of instants that are not edges must agree.
    let (mut u, mut w) = (vec![0.0; model.drives()], vec![0.0; model.drives()]);
    let span = if t > start { t - start } else { 1.0 };
    for i in 0..64 {
        let t = start + span * (f64::from(i) * 0.618_033_988_749_894_9).fract();
        model.drive(t, Side::Before, &mut u);
        model.drive(t, Side::After, &mut w);
        if let Some(drive) = (0..u.len()).find(|&d| u[d] != w[d])
            && model.next_edge(t - 1e-9 * span) != Some(t)
        {
            findings.push(Finding::UnannouncedJump { drive, t });
            break;
        }
    }
}
