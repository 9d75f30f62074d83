//! Scalar products and largest components.

use crate::excitation::side::Side;
use crate::model::equations::Model;
use crate::model::slopes::{Slopes, accelerate};
use crate::ode::step::{Observer, Step};
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// aᵀ b.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// max |x_i|; NaN if one of them is.
pub(crate) fn largest(x: &[f64]) -> f64 {
    let any_nan = x.iter().any(|x| x.is_nan());
    if any_nan { f64::NAN } else { x.iter().map(|x| x.abs()).fold(0.0, |m, x| if x > m { x } else { m }) }
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_number_that_is_none_is_the_largest_wherever_it_stands() {
        for at in 0..3 {
            let mut x = [1.0, -2.0, 0.5];
            assert_eq!(crate::roots::norms::largest(&x), 2.0);
            x[at] = f64::NAN;
            assert!(crate::roots::norms::largest(&x).is_nan());
        }
    }
}

/// x - r (rᵀ x), r of length 1.
pub(crate) fn remove(r: &[f64], x: &mut [f64]) {
    let along = dot(r, x);
    x.iter_mut().zip(r).for_each(|(x, r)| *x -= along * r);
}
