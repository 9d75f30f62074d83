//! What depends on what in a recorded algebra.

use crate::steepness::{JETS, are_hidden};
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

/// A sum of terms that vary with the time alone: slots or columns, with weights. Waves can cancel in it, so
/// that it is 0 with many coefficients at one instant and large at the next.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TimeSum(Vec<(u32, f64)>);

impl TimeSum {
    /// The sum of the columns in which the slots stand.
    pub(crate) fn of_columns(mut self, column: impl Fn(u32) -> u32) -> Self {
        self.0.iter_mut().for_each(|(of, _)| *of = column(*of));
        self
    }

    /// Whether the coefficients of order `n` and n - 1 do not show the sum. `at(column, k)`: coefficient k.
    #[inline]
    pub(crate) fn hides(&self, n: usize, at: impl Fn(u32, usize) -> f64) -> bool {
        let [last, below, before] = [n, n - 1, n - 2].map(|n| {
            let terms = self.0.iter().map(|&(column, weight)| weight * at(column, n));
            terms.fold([0.0, 0.0], |[sum, size], term| [sum + term, size + term.abs()])
        });
        let time = (before[1] / last[1]).sqrt();
        are_hidden([last, below], if time.is_finite() { time } else { 0.0 })
    }

    /// How steep the sum is, from the coefficients 1 to [`JETS`] of its terms: waves of the rate ω have
    /// n (n - 1) |c_n| = ω² |c_(n-2)| `[1/s]`.
    pub(crate) fn steepness(&self, at: impl Fn(u32, usize) -> f64) -> f64 {
        let size = |n: usize| self.0.iter().map(|&(c, weight)| (weight * at(c, n)).abs()).sum::<f64>();
        let square = |n: usize| if size(n) > 0.0 { (n * n - n) as f64 * size(n) / size(n - 2) } else { 0.0 };
        square(JETS - 1).max(square(JETS)).sqrt()
    }
}

/// The sums of two and more terms that vary with the time alone, in slots. `still`: whether a drive is
/// constant.
pub(crate) fn time_sums(tape: &Tape, still: impl Fn(usize) -> bool) -> Vec<TimeSum> {
    #[derive(Clone, Copy, PartialEq, PartialOrd)]
    enum Varies {
        Never,
        WithTime,
        WithMotion,
    }
    use Varies::{Never, WithMotion, WithTime};
    let mut all = vec![WithMotion; 2 * tape.dof];
    all.extend((0..tape.drives).map(|drive| if still(drive) { Never } else { WithTime }));
    for (op, _) in &tape.ops {
        let slots = op.operands().into_iter().flat_map(|form| &tape.forms[form].terms);
        let most = slots.map(|&(slot, _)| all[slot as usize]);
        let most = most.fold(Never, |most, next| if most < next { next } else { most });
        all.push(match op {
            Op::Cos => all.last().copied().unwrap_or(Never),
            Op::Choice { .. } if most != Never => WithMotion,
            _ => most,
        });
    }
    let needed = tape.needed();
    let operations = tape.ops.iter().zip(&needed[tape.inputs()..]).filter(|(_, needed)| **needed);
    let operands = operations.flat_map(|((op, _), _)| op.operands());
    let outputs = tape.accelerations.iter().chain(tape.distances.iter().flatten().flatten()).copied();
    let mut sums: Vec<TimeSum> = Vec::new();
    for form in operands.chain(outputs) {
        let terms = tape.forms[form].terms.iter().filter(|(slot, _)| all[*slot as usize] == WithTime);
        let sum = TimeSum(terms.copied().collect());
        if sum.0.len() > 1 && !sums.contains(&sum) {
            sums.push(sum);
        }
    }
    sums
}
