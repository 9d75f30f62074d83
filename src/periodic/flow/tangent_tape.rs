//! The derivative of a tape: a tape of the motion together with small differences of it.

use crate::model::drive_slope::DriveSlope;
use crate::tape::form::Form;
use crate::tape::operations::{FormId, Op, Parity, Tape};
use crate::tape::recording::Recording;

/// The tape of q'' = a(u, q, v) together with δq'' = ∂a/∂q δq + ∂a/∂v δv for a number of differences δ.
///
/// Coordinates and velocities are (q, δq_1, δq_2, ...). The distances are those of the motion alone. The last
/// differences are those with respect to the parameters `forced`, at a fixed phase: with ε = -T'/T, their
/// velocities are δv - ε v, and δq'' = ∂a/∂q δq + ∂a/∂v δv + ∂a/∂u u' - 2 ε a.
pub(crate) fn tangent(tape: &Tape, columns: usize, forced: &[DriveSlope]) -> Tape {
    let n = tape.dof;
    let all = n * (1 + columns);
    let free = columns - forced.len();
    let recording = Recording::new(all, tape.drives);
    let mut slots = Slots { recording, columns, forms: Vec::new() };
    // Forms of each slot of the tape: its value, then its differences.
    for (half, i) in [0, 1].into_iter().flat_map(|half| (0..n).map(move |i| (half, i))) {
        let form = |k: usize| {
            let own = Form::slot((half * all + k * n + i) as u32);
            match k.checked_sub(1 + free) {
                Some(by) if half == 1 => own.plus(&Form::slot((all + i) as u32), forced[by].speed),
                _ => own,
            }
        };
        slots.forms.push((0..=columns).map(form).collect());
    }
    for u in 0..tape.drives {
        let mut forms = slots.still(Form::slot((2 * all + u) as u32));
        forms[1 + free..].iter_mut().zip(forced).for_each(|(form, by)| *form = Form::constant(by.drives[u]));
        slots.forms.push(forms);
    }
    let needed = tape.needed();
    for (i, (op, guard)) in tape.ops.iter().enumerate() {
        match op {
            Op::Cos => {} // recorded with its sine
            _ if needed[tape.inputs() + i] => {
                let results = slots.recording.guarded(*guard, || slots.differences(op, tape));
                slots.forms.extend(results);
            }
            _ => {
                let results = if matches!(op, Op::SinCos(_)) { 2 } else { 1 };
                slots.forms.extend(vec![slots.still(Form::default()); results]);
            }
        }
    }
    let mut accelerations = vec![0; all];
    for (i, &a) in tape.accelerations.iter().enumerate() {
        let forms = slots.of(&tape.forms[a]);
        for (k, form) in forms.iter().enumerate() {
            let form = match k.checked_sub(1 + free) {
                Some(by) => form.plus(&forms[0], -2.0 * forced[by].speed),
                None => form.clone(),
            };
            accelerations[k * n + i] = slots.recording.keep(form);
        }
    }
    let value = |form: FormId| slots.recording.keep(slots.part(&tape.forms[form], 0));
    let distances = tape.distances.iter().map(|both| both.map(|one| one.map(value))).collect();
    slots.recording.finish(accelerations, distances)
}

struct Slots {
    recording: Recording,
    columns: usize,
    /// For each slot of the old tape its value, then its differences, as forms of the new tape.
    forms: Vec<Vec<Form>>,
}

impl Slots {
    /// A value without differences.
    fn still(&self, value: Form) -> Vec<Form> {
        let mut forms = vec![Form::default(); 1 + self.columns];
        forms[0] = value;
        forms
    }
    /// Part k of an old form: its value (k = 0) or a difference.
    fn part(&self, form: &Form, k: usize) -> Form {
        let start = Form::constant(if k == 0 { form.constant } else { 0.0 });
        form.terms.iter().fold(start, |sum, &(slot, weight)| {
            let term = &self.forms[slot as usize][k];
            if term.is_zero() { sum } else { sum.plus(term, weight) }
        })
    }
    fn of(&self, form: &Form) -> Vec<Form> {
        (0..=self.columns).map(|k| self.part(form, k)).collect()
    }

    /// Records an operation with its differences by the rules of differentiation: one list for each result.
    fn differences(&self, op: &Op, tape: &Tape) -> Vec<Vec<Form>> {
        let r = &self.recording;
        let parts = |form: FormId| -> Vec<FormId> {
            self.of(&tape.forms[form]).into_iter().map(|form| r.keep(form)).collect()
        };
        // The value of a function and its differences from the slope: δf = f'(a) δa.
        let chain = |value: FormId, slope: &dyn Fn() -> FormId, a: &[FormId]| {
            let moves = a[1..].iter().any(|&a| !r.form(a).is_zero());
            let slope = if moves { slope() } else { value };
            let differences = a[1..].iter().map(|&a| match r.form(a).is_zero() {
                true => Form::default(),
                false => r.form(r.product(slope, a)),
            });
            std::iter::once(r.form(value)).chain(differences).collect()
        };
        let result = match *op {
            Op::Sum(a) => {
                let a = parts(a);
                a.into_iter().map(|a| r.form(a)).collect()
            }
            Op::Product(a, b) => {
                let (a, b) = (parts(a), parts(b));
                let value = r.form(r.product(a[0], b[0]));
                let differences = (1..a.len())
                    .map(|k| r.form(r.product(a[k], b[0])).plus(&r.form(r.product(a[0], b[k])), 1.0));
                std::iter::once(value).chain(differences).collect()
            }
            Op::Quotient(a, b) => {
                let (a, b) = (parts(a), parts(b));
                let q = r.quotient(a[0], b[0]);
                let differences = (1..a.len()).map(|k| {
                    let top = r.form(a[k]).plus(&r.form(r.product(q, b[k])), -1.0);
                    r.form(r.quotient(r.keep(top), b[0]))
                });
                std::iter::once(r.form(q)).chain(differences).collect()
            }
            Op::Sqrt(a) => {
                let a = parts(a);
                let root = r.function(Op::Sqrt(a[0]));
                chain(root, &|| r.quotient(r.constant(0.5), root), &a)
            }
            Op::Power(a, p, parity) => {
                let a = parts(a);
                let slope_parity = match parity {
                    Parity::Plain => Parity::Plain,
                    Parity::Even => Parity::Odd,
                    Parity::Odd => Parity::Even,
                };
                let slope = || r.scaled(r.power(a[0], p - 1.0, slope_parity), p);
                chain(r.power(a[0], p, parity), &slope, &a)
            }
            Op::Exp(a) => {
                let a = parts(a);
                let exp = r.function(Op::Exp(a[0]));
                chain(exp, &|| exp, &a)
            }
            Op::Ln(a) => {
                let a = parts(a);
                chain(r.function(Op::Ln(a[0])), &|| r.quotient(r.constant(1.0), a[0]), &a)
            }
            Op::SinCos(a) => {
                let a = parts(a);
                let [sin, cos] = r.sin_cos(a[0]);
                return vec![chain(sin, &|| cos, &a), chain(cos, &|| r.scaled(sin, -1.0), &a)];
            }
            Op::Cos => unreachable!("recorded with its sine"),
            Op::Choice { contact, count, ref forms } => {
                let alternatives: Vec<Vec<FormId>> = forms.iter().map(|&form| parts(form)).collect();
                let part = |k: usize| {
                    let forms = alternatives.iter().map(|parts| parts[k]).collect();
                    r.form(r.choice(contact, count, forms))
                };
                (0..=self.columns).map(part).collect()
            }
            Op::Kink(name) => self.still(r.form(r.function(Op::Kink(name)))),
        };
        vec![result]
    }
}
