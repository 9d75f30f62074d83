//! A tape while it is recorded.

use crate::scalar::is_product;
use crate::tape::form::Form;
use crate::tape::operations::{FormId, Guard, Op, Parity, Tape};
use std::cell::{Cell, RefCell};

/// Longest form that is copied into every form that uses it. A longer one becomes a slot.
const LONGEST: usize = 12;

/// Operations recorded so far. Constants are folded; sums are kept as forms.
#[derive(Debug, Default)]
pub struct Recording {
    inputs: usize,
    dof: usize,
    forms: RefCell<Vec<Form>>,
    ops: RefCell<Vec<(Op, Option<Guard>)>>,
    guard: Cell<Option<Guard>>,
}

impl Recording {
    /// A recording for a model of the given size, with nothing recorded.
    pub(crate) fn new(dof: usize, drives: usize) -> Self {
        Recording { inputs: 2 * dof + drives, dof, ..Recording::default() }
    }

    /// The finished tape.
    pub(crate) fn finish(self, accelerations: Vec<FormId>, distances: Vec<[Option<FormId>; 2]>) -> Tape {
        let (dof, drives) = (self.dof, self.inputs - 2 * self.dof);
        let (forms, ops) = (self.forms.into_inner(), self.ops.into_inner());
        Tape { dof, drives, forms, ops, accelerations, distances, measured: Vec::new() }
    }

    /// Records `f`; its operations are used only on the pieces of `guard`.
    pub(crate) fn guarded<T>(&self, guard: Option<Guard>, f: impl FnOnce() -> T) -> T {
        let outer = self.guard.replace(guard.or(self.guard.get()));
        let result = f();
        self.guard.set(outer);
        result
    }

    /// Whether the operations belong to one piece of a contact.
    pub(crate) fn is_guarded(&self) -> bool {
        self.guard.get().is_some()
    }

    pub(crate) fn keep(&self, form: Form) -> FormId {
        let form = if form.terms.len() > LONGEST {
            let long = self.push(form);
            self.op(Op::Sum(long))
        } else {
            form
        };
        self.push(form)
    }
    fn push(&self, form: Form) -> FormId {
        let mut forms = self.forms.borrow_mut();
        forms.push(form);
        forms.len() - 1
    }
    pub(crate) fn input(&self, slot: usize) -> FormId {
        self.push(Form::slot(slot as u32))
    }
    pub(crate) fn constant(&self, value: f64) -> FormId {
        self.push(Form::constant(value))
    }
    pub(crate) fn form(&self, id: FormId) -> Form {
        self.forms.borrow()[id].clone()
    }
    /// The value of a form that is a constant.
    pub(crate) fn value(&self, id: FormId) -> Option<f64> {
        self.forms.borrow()[id].value()
    }

    fn op(&self, op: Op) -> Form {
        let mut ops = self.ops.borrow_mut();
        ops.push((op, self.guard.get()));
        Form::slot((self.inputs + ops.len() - 1) as u32)
    }

    pub(crate) fn sum(&self, a: FormId, b: FormId, factor: f64) -> FormId {
        let sum = {
            let forms = self.forms.borrow();
            forms[a].plus(&forms[b], factor)
        };
        self.keep(sum)
    }
    pub(crate) fn scaled(&self, a: FormId, factor: f64) -> FormId {
        let scaled = self.forms.borrow()[a].times(factor);
        self.push(scaled)
    }
    pub(crate) fn product(&self, a: FormId, b: FormId) -> FormId {
        match (self.value(a), self.value(b)) {
            (Some(a), _) => self.scaled(b, a),
            (_, Some(b)) => self.scaled(a, b),
            _ => self.function(Op::Product(a, b)),
        }
    }
    pub(crate) fn quotient(&self, a: FormId, b: FormId) -> FormId {
        match (self.value(a), self.value(b)) {
            (Some(a), Some(b)) => self.constant(a / b),
            (_, Some(b)) => self.scaled(a, 1.0 / b),
            (Some(0.0), _) => self.constant(0.0),
            _ => self.function(Op::Quotient(a, b)),
        }
    }
    /// x^p.
    pub(crate) fn power(&self, a: FormId, p: f64, parity: Parity) -> FormId {
        if parity == Parity::Plain && is_product(p) {
            let mut factor = if p < 0.0 { self.quotient(self.constant(1.0), a) } else { a };
            let (mut left, mut power) = (p.abs() as u32, None);
            while left > 0 {
                if left % 2 == 1 {
                    power = Some(power.map_or(factor, |power| self.product(power, factor)));
                }
                left /= 2;
                if left > 0 {
                    factor = self.product(factor, factor);
                }
            }
            return power.unwrap_or_else(|| self.constant(1.0));
        }
        self.function(Op::Power(a, p, parity))
    }
    /// Sine and cosine.
    pub(crate) fn sin_cos(&self, a: FormId) -> [FormId; 2] {
        [self.function(Op::SinCos(a)), self.function(Op::Cos)]
    }
    /// One of several forms by the pieces of contacts.
    pub(crate) fn choice(&self, contact: usize, count: usize, forms: Vec<FormId>) -> FormId {
        let alike = {
            let all = self.forms.borrow();
            forms.iter().all(|&form| all[form] == all[forms[0]])
        };
        if alike { forms[0] } else { self.function(Op::Choice { contact, count, forms }) }
    }
    pub(crate) fn function(&self, op: Op) -> FormId {
        let result = self.op(op);
        self.push(result)
    }
}
