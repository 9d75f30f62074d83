//! Places and weights of differences, for the derivative f'(0) = Σ weight f(place h)/h.

/// A central difference of fourth order.
pub(crate) const CENTRAL: [(f64, f64); 4] =
    [(-2.0, 1.0 / 12.0), (-1.0, -2.0 / 3.0), (1.0, 2.0 / 3.0), (2.0, -1.0 / 12.0)];

/// A one-sided difference of third order.
pub(crate) const ONE_SIDED: [(f64, f64); 4] = [(0.0, -11.0 / 6.0), (1.0, 3.0), (2.0, -1.5), (3.0, 1.0 / 3.0)];

#[cfg(test)]
mod tests {
    use super::{CENTRAL, ONE_SIDED};

    /// The derivatives of powers of x, x^k at 0, are exact up to the order.
    #[test]
    fn powers_up_to_the_order() {
        for (weights, order) in [(CENTRAL, 4), (ONE_SIDED, 3)] {
            for k in 0..=order {
                let slope: f64 = weights.iter().map(|(place, weight)| weight * place.powi(k)).sum();
                assert!((slope - f64::from(u8::from(k == 1))).abs() < 1e-14, "{order} {k}: {slope}");
            }
        }
    }
}
