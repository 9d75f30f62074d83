//! What depends on what in a recorded algebra.

use crate::tape::operations::{FormId, Op, Tape};

/// For each slot a number that is equal for slots that are used by equal sets of operations and outputs.
pub(super) fn uses(tape: &Tape) -> Vec<u32> {
    let mut uses = vec![0; tape.inputs() + tape.ops.len()];
    let mut mark = |form: FormId, bit: u32| {
        tape.forms[form].terms.iter().for_each(|&(slot, _)| uses[slot as usize] |= 1 << bit);
    };
    for (op, _) in &tape.ops {
        for (place, form) in op.operands().into_iter().enumerate() {
            mark(form, if matches!(op, Op::Choice { .. }) { 0 } else { 1 + (place as u32).min(1) });
        }
    }
    tape.accelerations.iter().for_each(|&form| mark(form, 3));
    uses
}

/// Whether each slot depends on a root or a power.
pub(super) fn dependants_of_powers(tape: &Tape) -> Vec<bool> {
    let inputs = tape.inputs();
    let mut depends = vec![false; inputs + tape.ops.len()];
    for (i, (op, _)) in tape.ops.iter().enumerate() {
        let mut slots = op.operands().into_iter().flat_map(|form| &tape.forms[form].terms);
        depends[inputs + i] = matches!(op, Op::Sqrt(_) | Op::Power(..))
            || (*op == Op::Cos && depends[inputs + i - 1])
            || slots.any(|&(slot, _)| depends[slot as usize]);
    }
    depends
}

/// The level of each slot: 0 for inputs, otherwise 1 more than the largest level that its operation reads. A
/// product reads the columns of a choice, which are in the rows of the choice's own level.
pub(super) fn levels(tape: &Tape, needed: &[bool]) -> Vec<usize> {
    let inputs = tape.inputs();
    let mut levels = vec![0; inputs + tape.ops.len()];
    let is_choice = |slot: u32| {
        let op = (slot as usize).checked_sub(inputs).map(|op| &tape.ops[op].0);
        matches!(op, Some(Op::Choice { .. }))
    };
    for (i, (op, _)) in tape.ops.iter().enumerate().filter(|(i, _)| needed[inputs + i]) {
        let after = |form: FormId| {
            let form = &tape.forms[form];
            let slots = form.terms.iter().map(|&(slot, _)| levels[slot as usize]);
            match form.alone() {
                Some(slot) if matches!(op, Op::Product(..)) && is_choice(slot) => levels[slot as usize],
                _ => 1 + slots.max().unwrap_or(0),
            }
        };
        levels[inputs + i] = match op {
            Op::Cos => levels[inputs + i - 1],
            _ => op.operands().into_iter().map(after).max().unwrap_or(1),
        };
    }
    levels
}
