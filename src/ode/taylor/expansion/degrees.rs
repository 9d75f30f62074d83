//! Of how many factors the products of a tape consist, and what its last coefficients may hide.

use crate::steepness::HIGH_DEGREE;
use crate::tape::operations::{Op, Tape};

/// For each slot an upper bound of the number of coordinates, velocities and drives that are multiplied in
/// it. A sine or cosine counts twice, because it is as flat as a square beside its extremes. Each drive
/// counts as `drive` factors.
fn degrees(tape: &Tape, drive: usize) -> Vec<usize> {
    let mut degrees = vec![1; 2 * tape.dof];
    degrees.resize(tape.inputs(), drive);
    let degree_of = |form: usize, degrees: &[usize]| {
        tape.forms[form].terms.iter().map(|(slot, _)| degrees[*slot as usize]).max().unwrap_or(0)
    };
    for (op, _) in &tape.ops {
        let operands = op.operands().into_iter().map(|form| degree_of(form, &degrees));
        let degree = match op {
            Op::Product(..) => operands.fold(0, usize::saturating_add),
            Op::SinCos(_) => operands.fold(0, usize::max).saturating_mul(2),
            Op::Cos => degrees.last().copied().unwrap_or(0),
            _ => operands.max().unwrap_or(0),
        };
        degrees.push(degree);
    }
    degrees
}

/// The slots of products of high degree.
pub(crate) fn high_products(tape: &Tape) -> Vec<usize> {
    let (degrees, needed) = (degrees(tape, 1), tape.needed());
    let ops = tape.ops.iter().zip(tape.inputs()..);
    let high = ops.filter(|((op, _), slot)| {
        matches!(op, Op::Product(..)) && needed[*slot] && degrees[*slot] > HIGH_DEGREE
    });
    high.map(|(_, slot)| slot).collect()
}

/// Whether the last coefficients of a motion may hide what is in a later part of its step: its tape contains
/// a function with singular points or of fast growth, or products of high degree.
pub(crate) fn may_hide(tape: &Tape) -> bool {
    let (degrees, needed) = (degrees(tape, 1), tape.needed());
    tape.ops.iter().zip(tape.inputs()..).any(|((op, _), slot)| {
        let steep = matches!(op, Op::Quotient(..) | Op::Sqrt(_) | Op::Power(..) | Op::Exp(_) | Op::Ln(_));
        needed[slot] && (steep || degrees[slot] > HIGH_DEGREE)
    })
}

/// Whether the Taylor series of a motion may lack several orders in a row, so that its last two terms are 0.
/// This holds for equations that are not linear in coordinates and velocities. The series of a linear
/// equation with constant drives has at least every second order.
pub(crate) fn may_have_gaps(tape: &Tape) -> bool {
    degrees(tape, 0).iter().zip(tape.needed()).any(|(degree, needed)| needed && *degree > 1)
}
