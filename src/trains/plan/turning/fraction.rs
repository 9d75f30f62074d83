//! Exact fractions, for speeds that follow from tooth numbers.

/// A reduced fraction with a positive denominator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Fraction {
    num: i128,
    den: i128,
}

fn gcd(a: i128, b: i128) -> i128 {
    if b == 0 { a.abs() } else { gcd(b, a % b) }
}

impl Fraction {
    pub(crate) const ZERO: Fraction = Fraction { num: 0, den: 1 };
    pub(crate) const ONE: Fraction = Fraction { num: 1, den: 1 };

    /// num/den; `None` if den is 0 or a number overflows.
    fn of(num: Option<i128>, den: Option<i128>) -> Option<Self> {
        let (num, den) = (num?, den?);
        let common = gcd(num, den);
        (den != 0).then(|| Fraction { num: den.signum() * num / common, den: den.abs() / common })
    }
    pub(crate) fn whole(value: i64) -> Self {
        Fraction { num: value.into(), den: 1 }
    }
    pub(crate) fn plus(self, other: Self) -> Option<Self> {
        let cross = self.num.checked_mul(other.den)?.checked_add(other.num.checked_mul(self.den)?);
        Fraction::of(cross, self.den.checked_mul(other.den))
    }
    pub(crate) fn minus(self, other: Self) -> Option<Self> {
        self.plus(Fraction { num: -other.num, den: other.den })
    }
    pub(crate) fn times(self, other: Self) -> Option<Self> {
        Fraction::of(self.num.checked_mul(other.num), self.den.checked_mul(other.den))
    }
    pub(crate) fn over(self, other: Self) -> Option<Self> {
        Fraction::of(self.num.checked_mul(other.den), self.den.checked_mul(other.num))
    }
    pub(crate) fn abs(self) -> Self {
        Fraction { num: self.num.abs(), ..self }
    }
    pub(crate) fn is_zero(self) -> bool {
        self.num == 0
    }
    pub(crate) fn value(self) -> f64 {
        self.num as f64 / self.den as f64
    }
    /// The largest fraction of which both are whole multiples.
    pub(crate) fn common(self, other: Self) -> Option<Self> {
        let den = self.den.checked_mul(other.den / gcd(self.den, other.den))?;
        let [a, b] = [self, other].map(|f| f.num.checked_mul(den / f.den));
        Fraction::of(Some(gcd(a?, b?)), Some(den))
    }
    /// The whole number that it is, if it is a `u32`.
    pub(crate) fn as_count(self) -> Option<u32> {
        if self.den == 1 { u32::try_from(self.num).ok() } else { None }
    }
}

#[cfg(test)]
mod tests {
    use super::Fraction;

    #[test]
    fn common_divisor_of_fractions() {
        let third = Fraction::ONE.over(Fraction::whole(3)).unwrap();
        let half = Fraction::ONE.over(Fraction::whole(-2)).unwrap();
        let common = third.common(half).unwrap();
        assert_eq!(common.value(), 1.0 / 6.0);
        assert_eq!(third.over(common).unwrap().as_count(), Some(2));
        assert_eq!(half.plus(third).unwrap().value(), -1.0 / 6.0);
    }
}
