//! Contact laws that are continuous at an edge.

use crate::certify::flow::algebra::On;
use crate::tape::form::Form;
use crate::tape::operations::{FormId, Op, Tape};

/// Whether all that a tape records is the same on both pieces of a contact where its distance is 0, whatever
/// the pieces of the other contacts are.
///
/// The difference of two alternatives has to vanish with the distance d: a multiple of d, compared in its
/// recorded coefficients, and operations that vanish with d (a product with a factor that does, a root or a
/// positive power of it).
pub(crate) fn is_continuous(tape: &Tape, on: On<'_>, contact: usize, distance: FormId) -> bool {
    let (inputs, needed) = (tape.inputs(), tape.needed());
    let distance = resolved(tape, &tape.forms[distance]);
    // Which slots vanish with the distance. Operations read earlier slots only.
    let mut zero = vec![false; inputs + tape.ops.len()];
    for (i, (op, guard)) in tape.ops.iter().enumerate() {
        if !needed[inputs + i] || !guard.is_none_or(|guard| on.applies(guard)) {
            continue;
        }
        let vanishes = |form: FormId| vanishes(&resolved(tape, &tape.forms[form]), &distance, &zero);
        zero[inputs + i] = match op {
            Op::Sum(a) | Op::Sqrt(a) | Op::Quotient(a, _) => vanishes(*a),
            Op::Product(a, b) => vanishes(*a) || vanishes(*b),
            Op::Power(a, p, _) => *p > 0.0 && vanishes(*a),
            Op::Choice { contact: first, count, forms } => {
                let own = *first <= contact && contact < first + count;
                let all = on.alternatives(*first, *count);
                if own && !agree(tape, on, (contact, *first), &all, forms, &distance, &zero) {
                    return false;
                }
                all.iter().all(|&a| vanishes(forms[a]))
            }
            Op::Exp(_) | Op::Ln(_) | Op::SinCos(_) | Op::Cos | Op::Kink(_) => false,
        };
    }
    true
}

/// Whether alternatives that differ in the piece of the contact alone agree where its distance is 0.
fn agree(
    tape: &Tape,
    on: On<'_>,
    (contact, first): (usize, usize),
    all: &[usize],
    forms: &[FormId],
    distance: &Form,
    zero: &[bool],
) -> bool {
    let place = 3usize.pow((contact - first) as u32);
    let [before, after] = on.pieces(contact).map(|piece| piece as usize);
    all.iter().filter(|&&a| a / place % 3 == before).all(|&a| {
        let other = a - before * place + after * place;
        let [a, b] = [a, other].map(|a| resolved(tape, &tape.forms[forms[a]]));
        vanishes(&b.plus(&a, -1.0), distance, zero)
    })
}

/// Whether a form is 0 where the distance and some slots are 0.
fn vanishes(form: &Form, distance: &Form, zero: &[bool]) -> bool {
    let rest = |factor: f64| form.plus(distance, -factor);
    let shares = distance.terms.iter().filter_map(|&(slot, weight)| {
        let own = form.terms.iter().find(|term| term.0 == slot)?;
        Some(own.1 / weight)
    });
    let left = |rest: Form| rest.constant == 0.0 && rest.terms.iter().all(|term| zero[term.0 as usize]);
    left(form.clone()) || shares.into_iter().any(|share| left(rest(share)))
}

/// A form in which kept sums are replaced by their terms.
fn resolved(tape: &Tape, form: &Form) -> Form {
    let inputs = tape.inputs();
    form.terms.iter().fold(Form::constant(form.constant), |sum, &(slot, weight)| {
        match (slot as usize).checked_sub(inputs).map(|i| &tape.ops[i].0) {
            Some(Op::Sum(long)) => sum.plus(&resolved(tape, &tape.forms[*long]), weight),
            _ => sum.plus(&Form::slot(slot), weight),
        }
    })
}

#[cfg(test)]
mod tests {
    use crate::certify::flow::algebra::On;
    use crate::certify::flow::continuity::is_continuous;
    use crate::contact::{
        AsymmetricBacklash, Backlash, Contact, Damped, Deflection, Nonlinearity, Piece, PieceChoice, PowerLaw,
    };
    use crate::error::ParameterError;
    use crate::model::recording::Recorded;

    /// q_i'' = -k f(q_i, q_i') of two oscillators, of which the first one enters its upper flank.
    fn enters<N: Nonlinearity>(law: &N) -> bool {
        let tape = Recorded::of(2, 2, &|_| None, |every, u, q, v, a| {
            let edges = |i: usize| Deflection { d: q[i], rate: v[i], lower: -u[1], upper: u[1] };
            (0..2).for_each(|i| a[i] = -(u[0] * every.force(i, law, edges(i))));
            let contact =
                |i: usize| Contact { deflection: q[i], lower: -u[1], upper: u[1], ..Contact::default() };
            vec![contact(0), contact(1)]
        });
        let (before, after) = ([Piece::Gap; 2], [Piece::Upper, Piece::Gap]);
        let distance = tape.0.distances[0][1].expect("a finite edge");
        is_continuous(&tape.0, On::either(&before, &after), 0, distance)
    }

    #[test]
    fn laws_that_jump_are_found() -> Result<(), ParameterError> {
        let backlash = Backlash::new(1.0)?;
        assert!(enters(&backlash));
        assert!(enters(&AsymmetricBacklash::new(-1.0, 1.0)?.with_slopes(0.3, 1.7)?));
        assert!(enters(&PowerLaw::new(1.0, 1.5, 1.0)?));
        assert!(enters(&Damped::by_force(backlash, 0.3)?));
        assert!(enters(&Damped::by_stiffness_always(backlash, 0.3)?));
        assert!(!enters(&Damped::by_stiffness(backlash, 0.3)?));
        Ok(())
    }
}
