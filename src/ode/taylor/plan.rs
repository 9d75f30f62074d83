//! The order in which a tape is evaluated, and the columns of its numbers.

use crate::contact::piece::Piece;
use crate::ode::taylor::functions::{Function, Placed};
use crate::ode::taylor::products::{BATCH, Products};
use crate::ode::taylor::rows::{BLOCK, Rows};
use crate::tape::form::Form;
use crate::tape::tape::{FormId, Guard, Op, Tape};
use std::collections::HashMap;

/// Operations whose operands are known once all levels before are evaluated.
#[derive(Debug, Default)]
pub(super) struct Level {
    /// Operands that are sums.
    pub(super) rows: Rows,
    choices: Vec<Choice>,
    pub(super) products: Vec<Products>,
    pub(super) functions: Vec<Placed>,
}

/// One of several columns, by the pieces of contacts.
#[derive(Debug)]
pub(super) struct Choice {
    contact: usize,
    count: usize,
    columns: Vec<u32>,
    out: u32,
}

/// A tape with a column for every number. Columns begin with the coordinates and the velocities.
#[derive(Debug)]
pub(super) struct Plan {
    pub(super) dof: usize,
    pub(super) width: usize,
    /// Column of the number 1.
    pub(super) one: usize,
    /// Drives that are needed, with their columns.
    pub(super) drives: Vec<(usize, usize)>,
    pub(super) levels: Vec<Level>,
    /// Accelerations, then distances.
    pub(super) outputs: Rows,
    /// First column of the accelerations.
    pub(super) first_acceleration: usize,
    /// First column of the distances.
    pub(super) first_distance: usize,
    /// The column that holds the numbers of each column on the present pieces.
    actual: Vec<u32>,
    /// Contact and edge (0 lower, 1 upper) of each distance.
    pub(super) edges: Vec<(usize, usize)>,
    /// Whether the distances depend on results of operations.
    pub(super) distances_need_levels: bool,
}

/// Σ piece_k 3^k over `count` contacts from `contact` on.
fn alternative(pieces: &[Piece], contact: usize, count: usize) -> usize {
    pieces[contact..][..count].iter().rev().fold(0, |index, piece| 3 * index + *piece as usize)
}

/// Columns that are handed out one after the other.
struct Columns {
    next: usize,
    of_slot: Vec<u32>,
    of_form: HashMap<FormId, u32>,
}

/// No column yet.
const NONE: u32 = u32::MAX;

impl Columns {
    fn take(&mut self, count: usize) -> usize {
        self.next += count;
        self.next - count
    }
}

impl Plan {
    pub(super) fn new(tape: &Tape) -> Self {
        let (inputs, n) = (tape.inputs(), tape.dof);
        let needed = tape.needed();
        let mut columns =
            Columns { next: 2 * n, of_slot: vec![NONE; inputs + tape.ops.len()], of_form: HashMap::new() };
        for slot in 0..2 * n {
            columns.of_slot[slot] = slot as u32;
        }
        let mut drives = Vec::new();
        for d in (0..tape.drives).filter(|d| needed[2 * n + d]) {
            let column = columns.take(1);
            columns.of_slot[2 * n + d] = column as u32;
            drives.push((d, column));
        }
        let (one, zero) = (columns.take(1), columns.take(1));
        let level_of = levels(tape, &needed);
        let count = level_of.iter().copied().max().unwrap_or(0);
        let mut made = Vec::with_capacity(count);
        for level in 1..=count {
            let ops: Vec<usize> = (0..tape.ops.len())
                .filter(|&i| needed[inputs + i] && level_of[inputs + i] == level)
                .collect();
            made.push(Level::new(tape, &ops, &mut columns, one as u32, zero as u32));
        }
        let (mut forms, mut edges) = (tape.accelerations.clone(), Vec::new());
        for (contact, both) in tape.distances.iter().enumerate() {
            for (edge, form) in both.iter().enumerate() {
                if let Some(form) = form {
                    forms.push(*form);
                    edges.push((contact, edge));
                }
            }
        }
        let first_acceleration = columns.take(forms.len().div_ceil(BLOCK) * BLOCK);
        let outputs: Vec<&Form> = forms.iter().map(|&form| &tape.forms[form]).collect();
        let outputs =
            Rows::new(&outputs, |slot| columns.of_slot[slot as usize], one as u32, first_acceleration);
        let distances_need_levels = forms[n..]
            .iter()
            .any(|&form| tape.forms[form].terms.iter().any(|&(slot, _)| slot as usize >= inputs));
        Plan {
            dof: n,
            width: columns.next.next_multiple_of(BLOCK),
            actual: (0..columns.next as u32).collect(),
            one,
            drives,
            levels: made,
            outputs,
            first_acceleration,
            first_distance: first_acceleration + n,
            edges,
            distances_need_levels,
        }
    }

    /// Sets the pieces on which all choices and functions are evaluated.
    pub(super) fn set_pieces(&mut self, pieces: &[Piece]) {
        // A choice is not copied: what reads it reads the chosen column.
        for level in &mut self.levels {
            for choice in &level.choices {
                let chosen = choice.columns[alternative(pieces, choice.contact, choice.count)];
                self.actual[choice.out as usize] = self.actual[chosen as usize];
            }
            level.rows.redirect(&self.actual);
            level.products.iter_mut().for_each(|products| products.redirect(&self.actual));
            for function in &mut level.functions {
                function.function = function.source.redirected(&self.actual);
                let stands =
                    |guard: Guard| alternative(pieces, guard.contact, guard.count) == guard.alternative;
                function.active = function.guard.is_none_or(stands);
            }
        }
        self.outputs.redirect(&self.actual);
    }

    /// The active functions.
    pub(super) fn functions(&self) -> impl Iterator<Item = &Placed> {
        self.levels.iter().flat_map(|level| &level.functions).filter(|function| function.active)
    }
}

/// The level of each slot: 0 for inputs, otherwise 1 more than the largest level that its operation reads.
fn levels(tape: &Tape, needed: &[bool]) -> Vec<usize> {
    let inputs = tape.inputs();
    let mut levels = vec![0; inputs + tape.ops.len()];
    for (i, (op, _)) in tape.ops.iter().enumerate().filter(|(i, _)| needed[inputs + i]) {
        let slots = op.operands().into_iter().flat_map(|form| &tape.forms[form].terms);
        levels[inputs + i] = match op {
            Op::Cos => levels[inputs + i - 1],
            _ => 1 + slots.map(|&(slot, _)| levels[slot as usize]).max().unwrap_or(0),
        };
    }
    levels
}

impl Level {
    /// The level of the given operations. Their operands get columns where they have none.
    fn new(tape: &Tape, ops: &[usize], columns: &mut Columns, one: u32, zero: u32) -> Self {
        let inputs = tape.inputs();
        // Operands that are sums become rows. A kept sum is the row of its form.
        let mut rows: Vec<FormId> = Vec::new();
        for &i in ops {
            for form in tape.ops[i].0.operands() {
                let sum = tape.forms[form].alone().is_none() && !tape.forms[form].is_zero();
                if (sum || matches!(tape.ops[i].0, Op::Sum(_))) && !columns.of_form.contains_key(&form) {
                    columns.of_form.insert(form, NONE);
                    rows.push(form);
                }
            }
        }
        let first = columns.take(rows.len().div_ceil(BLOCK) * BLOCK);
        for (r, form) in rows.iter().enumerate() {
            columns.of_form.insert(*form, (first + r) as u32);
        }
        let forms: Vec<&Form> = rows.iter().map(|&form| &tape.forms[form]).collect();
        let rows = Rows::new(&forms, |slot| columns.of_slot[slot as usize], one, first);

        let operand = |form: FormId, columns: &Columns| match columns.of_form.get(&form) {
            Some(&column) => column,
            None if tape.forms[form].is_zero() => zero,
            None => columns.of_slot[tape.forms[form].alone().expect("a row or a slot") as usize],
        };
        let (mut choices, mut functions) = (Vec::new(), Vec::new());
        let (mut pairs, mut results) = (Vec::new(), Vec::new());
        for &i in ops {
            let (op, guard) = &tape.ops[i];
            let function = match op {
                Op::Sum(a) => {
                    columns.of_slot[inputs + i] = operand(*a, columns);
                    continue;
                }
                Op::Product(a, b) => {
                    pairs.push([operand(*a, columns), operand(*b, columns)]);
                    results.push(inputs + i);
                    continue;
                }
                Op::Choice { contact, count, forms } => {
                    let alternatives: Vec<u32> = forms.iter().map(|&form| operand(form, columns)).collect();
                    let out = columns.take(1) as u32;
                    columns.of_slot[inputs + i] = out;
                    choices.push(Choice { contact: *contact, count: *count, columns: alternatives, out });
                    continue;
                }
                Op::Cos | Op::Kink(_) => continue,
                Op::Quotient(a, b) => Function::Quotient(operand(*a, columns), operand(*b, columns)),
                Op::Sqrt(a) => Function::Sqrt(operand(*a, columns)),
                Op::Power(a, p, parity) => Function::Power(operand(*a, columns), *p, *parity),
                Op::Exp(a) => Function::Exp(operand(*a, columns)),
                Op::Ln(a) => Function::Ln(operand(*a, columns)),
                Op::SinCos(a) => Function::SinCos(operand(*a, columns)),
            };
            let out = columns.take(if matches!(function, Function::SinCos(_)) { 2 } else { 1 });
            columns.of_slot[inputs + i] = out as u32;
            if let Function::SinCos(_) = function {
                columns.of_slot[inputs + i + 1] = out as u32 + 1;
            }
            functions.push(Placed { source: function, function, guard: *guard, active: true, out });
        }
        let mut products = Vec::new();
        for (pairs, results) in pairs.chunks(BATCH).zip(results.chunks(BATCH)) {
            let out = columns.take(BATCH);
            for (l, &slot) in results.iter().enumerate() {
                columns.of_slot[slot] = (out + l) as u32;
            }
            products.push(Products::new(pairs, zero, out));
        }
        Level { rows, choices, products, functions }
    }
}
