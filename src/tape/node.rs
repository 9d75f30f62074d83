//! Numbers that record the operations of an algebra.

use crate::scalar::{Scalar, is_product};
use crate::tape::operations::{FormId, Op, Parity};
use crate::tape::recording::Recording;
use std::fmt;
use std::ops::Add;
use std::ops::Div;
use std::ops::Mul;
use std::ops::Neg;
use std::ops::Sub;

/// A number that records the operations of an algebra: a constant, or a place on a tape.
///
/// [`Taylor`](crate::Taylor) runs the algebra of a [`Shape`](crate::Shape) once on these numbers and then
/// evaluates the tape to Taylor series. Constants are computed at once.
///
/// ```
/// use gear_dynamics::model::{recording::Node, Scalar};
/// let product = Node::from(3.0) * Node::from(0.5);
/// assert_eq!(product.sqrt().constant(), Some(1.5f64.sqrt()));
/// ```
#[derive(Clone, Copy)]
pub struct Node<'t>(Kind<'t>);

#[derive(Clone, Copy)]
enum Kind<'t> {
    Constant(f64),
    Recorded(&'t Recording, FormId),
}
use Kind::{Constant, Recorded};

impl<'t> Node<'t> {
    pub(crate) fn recorded(recording: &'t Recording, form: FormId) -> Self {
        match recording.value(form) {
            Some(value) => value.into(),
            None => Node(Recorded(recording, form)),
        }
    }
    /// The value, if it is a constant.
    pub fn constant(self) -> Option<f64> {
        match self.0 {
            Constant(value) => Some(value),
            Recorded(..) => None,
        }
    }
    /// The form on the tape.
    pub(crate) fn form(self, recording: &Recording) -> FormId {
        match self.0 {
            Constant(value) => recording.constant(value),
            Recorded(_, form) => form,
        }
    }

    /// A function of one number: computed for a constant, recorded otherwise.
    #[inline]
    fn apply(self, f: impl Fn(f64) -> f64, record: impl Fn(&Recording, FormId) -> FormId) -> Self {
        match self.0 {
            Constant(x) => f(x).into(),
            Recorded(tape, form) => Node::recorded(tape, record(tape, form)),
        }
    }
    /// A function of two numbers.
    #[inline]
    fn combine(
        self,
        other: Self,
        f: impl Fn(f64, f64) -> f64,
        record: impl Fn(&Recording, FormId, FormId) -> FormId,
    ) -> Self {
        let tape = match (self.0, other.0) {
            (Constant(a), Constant(b)) => return f(a, b).into(),
            (Recorded(tape, _), _) | (_, Recorded(tape, _)) => tape,
        };
        Node::recorded(tape, record(tape, self.form(tape), other.form(tape)))
    }
    fn kink(self, name: &'static str, f: impl Fn(f64) -> f64) -> Self {
        self.apply(f, |tape, _| tape.function(Op::Kink(name)))
    }
}

impl fmt::Debug for Node<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Constant(value) => write!(f, "{value:?}"),
            Recorded(_, form) => write!(f, "form {form}"),
        }
    }
}

impl From<f64> for Node<'_> {
    fn from(value: f64) -> Self {
        Node(Constant(value))
    }
}

impl Add for Node<'_> {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        self.combine(o, |a, b| a + b, |tape, a, b| tape.sum(a, b, 1.0))
    }
}
impl Sub for Node<'_> {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        self.combine(o, |a, b| a - b, |tape, a, b| tape.sum(a, b, -1.0))
    }
}
impl Neg for Node<'_> {
    type Output = Self;
    fn neg(self) -> Self {
        self * -1.0
    }
}
impl Mul<f64> for Node<'_> {
    type Output = Self;
    fn mul(self, o: f64) -> Self {
        self.apply(|x| x * o, |tape, form| tape.scaled(form, o))
    }
}
impl Mul for Node<'_> {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        self.combine(o, |a, b| a * b, Recording::product)
    }
}
impl Div for Node<'_> {
    type Output = Self;
    fn div(self, o: Self) -> Self {
        self.combine(o, |a, b| a / b, Recording::quotient)
    }
}

impl Scalar for Node<'_> {
    fn sqrt(self) -> Self {
        self.apply(f64::sqrt, |tape, form| tape.function(Op::Sqrt(form)))
    }
    fn abs(self) -> Self {
        self.kink("the absolute value of something that varies", f64::abs)
    }
    fn min(self, o: Self) -> Self {
        let kink = |tape: &Recording, _, _| tape.function(Op::Kink("the smaller of two numbers that vary"));
        self.combine(o, Scalar::min, kink)
    }
    fn max(self, o: Self) -> Self {
        let kink = |tape: &Recording, _, _| tape.function(Op::Kink("the larger of two numbers that vary"));
        self.combine(o, Scalar::max, kink)
    }
    fn step(self) -> Self {
        self.kink("the step of something that varies", Scalar::step)
    }
    fn powf(self, p: f64) -> Self {
        self.apply(|x| Scalar::powf(x, p), |tape, form| tape.power(form, p, Parity::Plain))
    }
    fn abs_powf(self, p: f64) -> Self {
        self.apply(
            |x| x.abs_powf(p),
            // On a piece of a contact the sign is known. Elsewhere an odd power would cross its kink unseen.
            |tape, form| match p % 2.0 == 1.0 && !tape.is_guarded() {
                true => tape.function(Op::Kink("an odd power of an absolute value that varies")),
                false => tape.power(form, p, Parity::Even),
            },
        )
    }
    fn signed_powf(self, p: f64) -> Self {
        self.apply(
            |x| x.signed_powf(p),
            |tape, form| match p % 2.0 {
                1.0 if is_product(p) => tape.power(form, p, Parity::Plain),
                0.0 if !tape.is_guarded() => tape.function(Op::Kink("a power with the sign of what varies")),
                _ => tape.power(form, p, Parity::Odd),
            },
        )
    }
    fn exp(self) -> Self {
        self.apply(Scalar::exp, |tape, form| tape.function(Op::Exp(form)))
    }
    fn ln(self) -> Self {
        self.apply(Scalar::ln, |tape, form| tape.function(Op::Ln(form)))
    }
    fn sin(self) -> Self {
        self.sin_cos().0
    }
    fn cos(self) -> Self {
        self.sin_cos().1
    }
    fn sin_cos(self) -> (Self, Self) {
        match self.0 {
            Constant(x) => (Scalar::sin(x).into(), Scalar::cos(x).into()),
            Recorded(tape, form) => {
                let [sin, cos] = tape.sin_cos(form);
                (Node::recorded(tape, sin), Node::recorded(tape, cos))
            }
        }
    }
}
