//! How steep the functions of a tape are along a motion.

use crate::ode::taylor::expansion::coefficients::Coefficients;
use crate::ode::taylor::expansion::functions::Function;
use crate::ode::taylor::expansion::rows::EIGHT;
use crate::steepness::{JETS, logarithm, steepness};
use crate::tape::operations::{Op, Tape};

/// A product of so many coordinates and velocities may vanish in all coefficients that are computed.
const HIGH_DEGREE: usize = 12;

impl Coefficients {
    /// The largest [`steepness`] of the active functions, from their arguments of the first orders `[1/s]`. A
    /// sine is 0: its coefficients are as large as those of its argument.
    pub(crate) fn steepness(&self) -> f64 {
        let (x, stride) = (self.x.as_flattened(), EIGHT * self.plan.width);
        let jets = |column: u32| -> [f64; JETS] { std::array::from_fn(|n| x[n * stride + column as usize]) };
        let power = |column: u32, p: f64| logarithm(jets(column)).map(|w| p * w);
        let all = self.plan.functions().map(|function| match function.function {
            Function::Exp(a) => steepness(jets(a)),
            Function::Quotient(_, b) => steepness(power(b, 1.0)),
            Function::Ln(a) => steepness(power(a, 1.0)),
            Function::Sqrt(a) => steepness(power(a, 0.5)),
            Function::Power(a, p, _) => steepness(power(a, p)),
            Function::SinCos(_) => 0.0,
        });
        all.fold(0.0, f64::max)
    }
}

/// Whether the last coefficients of a motion may hide what is in a later part of its step: its tape contains
/// a function with singular points or of fast growth, or products of high degree.
pub(crate) fn may_hide(tape: &Tape) -> bool {
    let mut degrees = vec![1; tape.inputs()];
    let needed = tape.needed();
    let degree_of = |form: usize, degrees: &[usize]| {
        tape.forms[form].terms.iter().map(|(slot, _)| degrees[*slot as usize]).max().unwrap_or(0)
    };
    for (op, _) in &tape.ops {
        let operands = op.operands().into_iter().map(|form| degree_of(form, &degrees));
        let degree = match op {
            Op::Product(..) => operands.sum(),
            _ => operands.max().unwrap_or(0),
        };
        degrees.push(degree);
    }
    tape.ops.iter().zip(tape.inputs()..).any(|((op, _), slot)| {
        let steep = matches!(op, Op::Quotient(..) | Op::Sqrt(_) | Op::Power(..) | Op::Exp(_) | Op::Ln(_));
        needed[slot] && (steep || degrees[slot] > HIGH_DEGREE)
    })
}
