//! The algebra of a tape on intervals, order by order.

use crate::contact::Piece;
use crate::contact::piece::alternative;
use crate::interval::number::Interval;
use crate::scalar::Scalar;
use crate::series::PowerSeries;
use crate::tape::operations::{FormId, Guard, Op, Parity, Tape};

/// The pieces of all contacts: one of each, or two of which the motion may be on either.
#[derive(Clone, Copy, Debug)]
pub(crate) struct On<'p> {
    one: &'p [Piece],
    other: Option<&'p [Piece]>,
}

impl<'p> From<&'p [Piece]> for On<'p> {
    fn from(one: &'p [Piece]) -> Self {
        On { one, other: None }
    }
}

impl<'p> On<'p> {
    /// Each contact on its piece of the one list or of the other.
    pub(crate) fn either(one: &'p [Piece], other: &'p [Piece]) -> Self {
        On { one, other: Some(other) }
    }
    /// Both pieces of a contact.
    pub(crate) fn pieces(&self, contact: usize) -> [Piece; 2] {
        [self.one[contact], self.other.unwrap_or(self.one)[contact]]
    }
    /// The numbers that the pieces of some contacts may make in base 3.
    pub(crate) fn alternatives(&self, contact: usize, count: usize) -> Vec<usize> {
        (contact..contact + count).rev().fold(vec![0], |numbers, contact| {
            let [one, other] = self.pieces(contact);
            let digits = if one == other { vec![one] } else { vec![one, other] };
            numbers.iter().flat_map(|number| digits.iter().map(move |d| 3 * number + *d as usize)).collect()
        })
    }
    /// Whether an operation with this guard is read.
    pub(crate) fn applies(&self, guard: Guard) -> bool {
        match self.other {
            None => alternative(self.one, guard.contact, guard.count) == guard.alternative,
            Some(_) => self.alternatives(guard.contact, guard.count).contains(&guard.alternative),
        }
    }
}

/// A tape that is evaluated to enclosures of Taylor coefficients.
#[derive(Debug)]
pub(crate) struct Algebra {
    pub(crate) tape: Tape,
    needed: Vec<bool>,
}

/// Enclosures of the Taylor coefficients of all slots and forms of a tape.
#[derive(Debug, Default)]
pub(crate) struct Coefficients {
    /// Room for the coefficients of one slot or form.
    stride: usize,
    slots: Vec<Interval>,
    forms: Vec<Interval>,
    /// Number of coefficients of each form that are computed.
    done: Vec<usize>,
}

impl Coefficients {
    /// Coefficient n of a slot: coordinates, then velocities, then drives.
    pub(crate) fn slot(&self, slot: usize, n: usize) -> Interval {
        self.slots[slot * self.stride + n]
    }
    /// Coefficient n of a form that was evaluated.
    pub(crate) fn form(&self, form: FormId, n: usize) -> Interval {
        self.forms[form * self.stride + n]
    }
}

impl Algebra {
    pub(crate) fn new(tape: Tape) -> Self {
        Algebra { needed: tape.needed(), tape }
    }

    /// The coefficients up to `order` of the motion that starts in the box `x` of coordinates and velocities,
    /// with every contact on a given piece, or the hull of those on either of two pieces; those of
    /// accelerations and distances, too.
    pub(crate) fn expand(
        &self,
        pieces: On<'_>,
        x: &[Interval],
        drives: &[PowerSeries<Interval>],
        order: usize,
    ) -> Coefficients {
        let (tape, stride) = (&self.tape, order + 2);
        let all = tape.inputs() + tape.ops.len();
        let mut c = Coefficients {
            stride,
            slots: vec![Interval::ZERO; all * stride],
            forms: vec![Interval::ZERO; tape.forms.len() * stride],
            done: vec![0; tape.forms.len()],
        };
        for (i, x) in x.iter().enumerate() {
            c.slots[i * stride] = *x;
        }
        for (d, series) in drives.iter().enumerate() {
            let start = (2 * tape.dof + d) * stride;
            for (n, coefficient) in series.coefficients().iter().take(stride).enumerate() {
                c.slots[start + n] = *coefficient;
            }
        }
        for n in 0..=order {
            for (i, (op, guard)) in tape.ops.iter().enumerate() {
                if self.needed[tape.inputs() + i] && guard.is_none_or(|guard| pieces.applies(guard)) {
                    self.operate(op, tape.inputs() + i, n, pieces, &mut c);
                }
            }
            for (j, &form) in tape.accelerations.iter().enumerate() {
                let a = self.evaluate(form, n, &mut c);
                let next = Interval::from((n + 1) as f64);
                c.slots[j * stride + n + 1] = c.slots[(tape.dof + j) * stride + n] / next;
                c.slots[(tape.dof + j) * stride + n + 1] = a / next;
            }
            for form in tape.distances.iter().flatten().flatten() {
                self.evaluate(*form, n, &mut c);
            }
        }
        c
    }

    /// Coefficient n of a form.
    fn evaluate(&self, form: FormId, n: usize, c: &mut Coefficients) -> Interval {
        let place = form * c.stride + n;
        if c.done[form] == n {
            let of = &self.tape.forms[form];
            let start = if n == 0 { Interval::from(of.constant) } else { Interval::ZERO };
            let slots = &c.slots;
            c.forms[place] = of
                .terms
                .iter()
                .fold(start, |sum, &(slot, weight)| sum + slots[slot as usize * c.stride + n] * weight);
            c.done[form] = n + 1;
        }
        c.forms[place]
    }

    /// Writes coefficient n of an operation to its slot.
    fn operate(&self, op: &Op, slot: usize, n: usize, pieces: On<'_>, c: &mut Coefficients) {
        let (stride, whole) = (c.stride, |n: usize| Interval::from(n as f64));
        let own = slot * stride;
        let value = match op {
            Op::Sum(a) => self.evaluate(*a, n, c),
            Op::Product(a, b) => {
                self.evaluate(*a, n, c);
                self.evaluate(*b, n, c);
                let (a, b) = (&c.forms[a * stride..][..=n], &c.forms[b * stride..][..=n]);
                convolution(a, b)
            }
            Op::Quotient(a, b) => {
                let top = self.evaluate(*a, n, c);
                let first = {
                    self.evaluate(*b, n, c);
                    c.forms[b * stride]
                };
                let b = &c.forms[b * stride..][..=n];
                (top - convolution(&b[1..], &c.slots[own..][..n])) / first
            }
            Op::Sqrt(a) => {
                let top = self.evaluate(*a, n, c);
                let s = &c.slots[own..][..n.max(1)];
                match n {
                    0 => top.sqrt(),
                    _ => (top - convolution(&s[1..], &s[1..])) / (s[0] * 2.0),
                }
            }
            Op::Power(a, p, parity) => {
                self.evaluate(*a, n, c);
                let a = &c.forms[a * stride..][..=n];
                match n {
                    0 => power(a[0], *p, *parity),
                    _ => {
                        let terms = (1..=n).fold(Interval::ZERO, |sum, j| {
                            let weight =
                                Interval::from(j as f64) * (Interval::from(*p) + Interval::ONE) - whole(n);
                            sum + a[j] * weight * c.slots[own + n - j]
                        });
                        terms / (a[0] * whole(n))
                    }
                }
            }
            Op::Exp(a) => {
                let top = self.evaluate(*a, n, c);
                let a = &c.forms[a * stride..][..=n];
                match n {
                    0 => top.exp(),
                    _ => {
                        (1..=n).fold(Interval::ZERO, |sum, j| sum + a[j] * j as f64 * c.slots[own + n - j])
                            / whole(n)
                    }
                }
            }
            Op::Ln(a) => {
                let top = self.evaluate(*a, n, c);
                let a = &c.forms[a * stride..][..=n];
                match n {
                    0 => top.ln(),
                    _ => {
                        let sum = (1..n)
                            .fold(Interval::ZERO, |sum, j| sum + c.slots[own + j] * j as f64 * a[n - j]);
                        (top - sum / whole(n)) / a[0]
                    }
                }
            }
            Op::SinCos(a) => {
                let top = self.evaluate(*a, n, c);
                let a = &c.forms[a * stride..][..=n];
                let (sin, cos) = match n {
                    0 => top.sin_cos(),
                    _ => {
                        let [mut ds, mut dc] = [Interval::ZERO; 2];
                        for (j, a) in a.iter().enumerate().skip(1) {
                            let rate = *a * j as f64;
                            ds = ds + rate * c.slots[own + stride + n - j];
                            dc = dc - rate * c.slots[own + n - j];
                        }
                        (ds / whole(n), dc / whole(n))
                    }
                };
                c.slots[own + stride + n] = cos;
                sin
            }
            Op::Choice { contact, count, forms } => match pieces.other {
                None => self.evaluate(forms[alternative(pieces.one, *contact, *count)], n, c),
                Some(_) => {
                    let all = pieces.alternatives(*contact, *count).into_iter();
                    let values = all.map(|a| self.evaluate(forms[a], n, c));
                    values.reduce(Interval::hull).unwrap_or(Interval::LINE)
                }
            },
            Op::Cos => return, // written with its sine
            Op::Kink(_) => Interval::LINE,
        };
        c.slots[own + n] = value;
    }
}

/// Σ_j a_j b_(n-j) over two lists of equal length; the last of `b` belongs to the first of `a`.
fn convolution(a: &[Interval], b: &[Interval]) -> Interval {
    a.iter().zip(b.iter().rev()).fold(Interval::ZERO, |sum, (a, b)| sum + *a * *b)
}

fn power(x: Interval, p: f64, parity: Parity) -> Interval {
    match parity {
        Parity::Plain => x.powf(p),
        Parity::Even => x.abs().powf(p),
        Parity::Odd if x.low() >= 0.0 => x.powf(p),
        Parity::Odd if x.high() <= 0.0 => -x.abs().powf(p),
        Parity::Odd if p > 0.0 => {
            let [below, above] = [-x.low(), x.high()].map(|end| Interval::from(end).powf(p));
            (-below).hull(above)
        }
        Parity::Odd => Interval::LINE,
    }
}
