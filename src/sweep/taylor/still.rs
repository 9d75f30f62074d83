//! Numbers of a lane that have no higher orders: constants of the model and what follows from them.

use crate::contact::Piece;
use crate::contact::piece::alternative;
use crate::scalar::Scalar;
use crate::tape::operations::Parity;

/// How a still number follows from those before it.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Still {
    /// A drive of the model.
    Drive(usize),
    /// constant + Σ weight × still number.
    Sum(f64, Vec<(usize, f64)>),
    Product(usize, usize),
    Quotient(usize, usize),
    Sqrt(usize),
    Power(usize, f64, Parity),
    Exp(usize),
    Ln(usize),
    Sin(usize),
    Cos(usize),
    /// The one of several numbers that belongs to the chosen piece.
    Choice {
        selector: usize,
        among: Vec<usize>,
    },
}

/// The still numbers of a program.
#[derive(Debug, Default)]
pub(super) struct Stills {
    all: Vec<Still>,
}

impl Stills {
    pub(super) fn len(&self) -> usize {
        self.all.len()
    }
    /// The index of a number: a new one, or that of the same number before.
    pub(super) fn keep(&mut self, still: Still) -> usize {
        self.all.iter().position(|known| *known == still).unwrap_or_else(|| self.push(still))
    }
    pub(super) fn push(&mut self, still: Still) -> usize {
        self.all.push(still);
        self.all.len() - 1
    }

    /// Computes all numbers of a lane from the drives of its model and the pieces of its contacts.
    pub(super) fn write(
        &self,
        drives: &[f64],
        pieces: &[Piece],
        selectors: &[(usize, usize)],
        out: &mut [f64],
    ) {
        for (i, still) in self.all.iter().enumerate() {
            out[i] = match still {
                Still::Drive(drive) => drives[*drive],
                Still::Sum(constant, terms) => {
                    terms.iter().fold(*constant, |sum, (still, weight)| sum + weight * out[*still])
                }
                Still::Product(a, b) => out[*a] * out[*b],
                Still::Quotient(a, b) => out[*a] / out[*b],
                Still::Sqrt(a) => out[*a].sqrt(),
                Still::Power(a, p, Parity::Plain) => Scalar::powf(out[*a], *p),
                Still::Power(a, p, Parity::Even) => out[*a].abs_powf(*p),
                Still::Power(a, p, Parity::Odd) => out[*a].signed_powf(*p),
                Still::Exp(a) => Scalar::exp(out[*a]),
                Still::Ln(a) => Scalar::ln(out[*a]),
                Still::Sin(a) => Scalar::sin_cos(out[*a]).0,
                Still::Cos(a) => Scalar::sin_cos(out[*a]).1,
                Still::Choice { selector, among } => {
                    let (contact, count) = selectors[*selector];
                    out[among[alternative(pieces, contact, count)]]
                }
            };
        }
    }
}
