//! Weighted sums: the operands of recorded operations.

/// constant + Σ weight × slot, slots increasing. A slot is an input or the result of an operation.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Form {
    pub(crate) constant: f64,
    pub(crate) terms: Vec<(u32, f64)>,
}

impl Form {
    pub(crate) fn constant(constant: f64) -> Self {
        Form { constant, terms: Vec::new() }
    }
    pub(crate) fn slot(slot: u32) -> Self {
        Form { constant: 0.0, terms: vec![(slot, 1.0)] }
    }
    /// Its value, if it is a constant.
    pub(crate) fn value(&self) -> Option<f64> {
        self.terms.is_empty().then_some(self.constant)
    }
    pub(crate) fn is_zero(&self) -> bool {
        self.value() == Some(0.0)
    }
    /// The slot, if the form is one slot with weight 1.
    pub(crate) fn alone(&self) -> Option<u32> {
        match self.terms[..] {
            [(slot, 1.0)] if self.constant == 0.0 => Some(slot),
            _ => None,
        }
    }

    pub(crate) fn times(&self, factor: f64) -> Self {
        if factor == 0.0 {
            return Form::default();
        }
        let terms = self.terms.iter().map(|&(slot, weight)| (slot, weight * factor)).collect();
        Form { constant: self.constant * factor, terms }
    }

    /// The sum of this form and `factor` times another one.
    pub(crate) fn plus(&self, other: &Form, factor: f64) -> Self {
        let (mut a, mut b) = (self.terms.iter().peekable(), other.terms.iter().peekable());
        let mut terms = Vec::with_capacity(self.terms.len() + other.terms.len());
        loop {
            let term = match (a.peek(), b.peek()) {
                (Some(x), Some(y)) if x.0 == y.0 => {
                    let sum = (x.0, x.1 + factor * y.1);
                    a.next();
                    b.next();
                    sum
                }
                (Some(x), y) if y.is_none_or(|y| x.0 < y.0) => {
                    let own = **x;
                    a.next();
                    own
                }
                (_, Some(y)) => {
                    let from_other = (y.0, factor * y.1);
                    b.next();
                    from_other
                }
                (_, None) => break,
            };
            if term.1 != 0.0 {
                terms.push(term);
            }
        }
        Form { constant: self.constant + factor * other.constant, terms }
    }
}
