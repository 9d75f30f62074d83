//! Tapes with other inputs.

use crate::tape::form::Form;
use crate::tape::operations::Tape;

/// The same algebra with `dof` coordinates and `drives` drives. `input`: the new slot of an old input; `None`
/// for an input that is 0.
pub(crate) fn with_inputs(
    tape: &Tape,
    [dof, drives]: [usize; 2],
    input: impl Fn(usize) -> Option<usize>,
) -> Tape {
    let [old, new] = [tape.inputs(), 2 * dof + drives];
    let moved = |&(slot, weight): &(u32, f64)| {
        let slot = slot as usize;
        let slot = if slot < old { input(slot)? } else { slot - old + new };
        Some((slot as u32, weight))
    };
    let form = |form: &Form| {
        let mut terms: Vec<(u32, f64)> = form.terms.iter().filter_map(moved).collect();
        terms.sort_by_key(|term| term.0);
        Form { constant: form.constant, terms }
    };
    Tape { dof, drives, forms: tape.forms.iter().map(form).collect(), ..tape.clone() }
}
