//! The finished record of an algebra.

use crate::tape::form::Form;
use std::fmt;

/// Index of a form in its tape.
pub(crate) type FormId = usize;

/// The pieces on which an operation is evaluated: those of `count` contacts from `contact` on.
///
/// A lower flank has the number 0, a gap 1, an upper flank 2. `alternative` is the number that these digits
/// make in base 3, the first contact as the lowest digit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Guard {
    pub(crate) contact: usize,
    pub(crate) count: usize,
    pub(crate) alternative: usize,
}

/// How the sign of the base enters a power.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Parity {
    /// x^p: NaN for negative x.
    Plain,
    /// |x|^p.
    Even,
    /// |x|^p times the sign of x.
    Odd,
}

/// An operation that is no weighted sum. Operands are forms; each result is a slot.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Op {
    /// A form kept as a slot of its own, because it is long and used often.
    Sum(FormId),
    Product(FormId, FormId),
    Quotient(FormId, FormId),
    Sqrt(FormId),
    Power(FormId, f64, Parity),
    Exp(FormId),
    Ln(FormId),
    /// Sine; the cosine is the next slot.
    SinCos(FormId),
    /// The second result of the operation before.
    Cos,
    /// One of 3^count forms, by the pieces of `count` contacts from `contact` on.
    Choice {
        contact: usize,
        count: usize,
        forms: Vec<FormId>,
    },
    /// An operation without a series, by its name.
    Kink(&'static str),
}

impl Op {
    /// What a quotient is where its operand is 0.
    pub(crate) const DIVISION: &str = "a division by 0";
    /// What a logarithm is where its operand is 0.
    pub(crate) const LOGARITHM: &str = "the logarithm of 0";

    /// The forms that the operation reads.
    pub(crate) fn operands(&self) -> Vec<FormId> {
        match self {
            Op::Sum(a) | Op::Sqrt(a) | Op::Power(a, ..) | Op::Exp(a) | Op::Ln(a) | Op::SinCos(a) => vec![*a],
            Op::Product(a, b) | Op::Quotient(a, b) => vec![*a, *b],
            Op::Choice { forms, .. } => forms.clone(),
            Op::Cos | Op::Kink(_) => Vec::new(),
        }
    }
}

/// What a form of a tape returns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Output {
    /// The acceleration of a coordinate.
    Acceleration(usize),
    /// The distance of a contact from its lower edge (0) or its upper edge (1).
    Distance(usize, usize),
}

impl fmt::Display for Output {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Output::Acceleration(j) => write!(f, "the acceleration of coordinate {j}"),
            Output::Distance(contact, 0) => write!(f, "the lower edge of contact {contact}"),
            Output::Distance(contact, _) => write!(f, "the upper edge of contact {contact}"),
        }
    }
}

/// The algebra of a model: accelerations and the distances of its contacts from their edges.
///
/// Slots: coordinates, velocities and drives of the model, then one for each operation.
#[derive(Clone, Debug)]
pub(crate) struct Tape {
    pub(crate) dof: usize,
    pub(crate) drives: usize,
    pub(crate) forms: Vec<Form>,
    pub(crate) ops: Vec<(Op, Option<Guard>)>,
    pub(crate) accelerations: Vec<FormId>,
    /// For each contact its distance above the lower edge and below the upper edge, positive in the gap;
    /// `None` for an infinite edge.
    pub(crate) distances: Vec<[Option<FormId>; 2]>,
    /// The deflection and the force of each contact.
    pub(crate) measured: Vec<[FormId; 2]>,
}

impl Tape {
    /// Number of inputs: the slot of the first operation.
    pub(crate) fn inputs(&self) -> usize {
        2 * self.dof + self.drives
    }

    /// Number of contacts whose pieces are read.
    pub(crate) fn contacts_read(&self) -> usize {
        let reads = self.ops.iter().map(|(op, _)| match op {
            Op::Choice { contact, count, .. } => contact + count,
            _ => 0,
        });
        reads.max().unwrap_or(0)
    }

    /// Whether the distances of each contact read velocities.
    pub(crate) fn contacts_of_velocities(&self) -> Vec<bool> {
        let velocities = self.dof..2 * self.dof;
        let mut reads: Vec<bool> = (0..self.inputs()).map(|slot| velocities.contains(&slot)).collect();
        let form = |reads: &[bool], form: FormId| self.forms[form].terms.iter().any(|t| reads[t.0 as usize]);
        for (op, _) in &self.ops {
            let after = matches!(op, Op::Cos) && reads.last() == Some(&true);
            reads.push(after || op.operands().into_iter().any(|operand| form(&reads, operand)));
        }
        let contact = |edges: &[Option<FormId>; 2]| edges.iter().flatten().any(|edge| form(&reads, *edge));
        self.distances.iter().map(contact).collect()
    }

    /// The forms that the tape returns, each with what it is.
    fn outputs(&self) -> impl Iterator<Item = (FormId, Output)> + '_ {
        let accelerations = self.accelerations.iter().enumerate();
        let accelerations = accelerations.map(|(j, form)| (*form, Output::Acceleration(j)));
        let distances = self.distances.iter().enumerate().flat_map(|(contact, forms)| {
            let forms = forms.iter().enumerate();
            forms.filter_map(move |(side, form)| Some(((*form)?, Output::Distance(contact, side))))
        });
        accelerations.chain(distances)
    }

    /// Which slots are needed for the accelerations and distances.
    pub(crate) fn needed(&self) -> Vec<bool> {
        self.needed_with(&[])
    }
    /// Which slots are needed for the accelerations, the distances and further forms.
    pub(crate) fn needed_with(&self, further: &[FormId]) -> Vec<bool> {
        self.needed_for(self.outputs().map(|(form, _)| form).chain(further.iter().copied()).collect())
    }

    /// Which slots are needed for these forms.
    fn needed_for(&self, mut open: Vec<FormId>) -> Vec<bool> {
        let inputs = self.inputs();
        let mut needed = vec![false; inputs + self.ops.len()];
        let mut seen = vec![false; self.forms.len()];
        while let Some(form) = open.pop() {
            if std::mem::replace(&mut seen[form], true) {
                continue;
            }
            for &(slot, _) in &self.forms[form].terms {
                let mut slot = slot as usize;
                while !std::mem::replace(&mut needed[slot], true) && slot >= inputs {
                    let op = &self.ops[slot - inputs].0;
                    open.extend(op.operands());
                    if *op != Op::Cos {
                        break;
                    }
                    slot -= 1; // a cosine comes with its sine
                }
            }
        }
        needed
    }

    /// The first output that needs an operation without a series, and the name of that operation.
    pub(crate) fn kink(&self) -> Option<(Output, &'static str)> {
        let is_kink = |(op, _): &(Op, Option<Guard>)| matches!(op, Op::Kink(_));
        if !self.ops.iter().any(is_kink) {
            return None;
        }
        self.outputs().find_map(|(form, output)| {
            let needed = self.needed_for(vec![form]);
            self.ops.iter().zip(&needed[self.inputs()..]).find_map(|((op, _), needed)| match op {
                Op::Kink(name) if *needed => Some((output, *name)),
                _ => None,
            })
        })
    }
}
