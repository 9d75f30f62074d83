//! Steps of one's own: a Rosenbrock method for stiff models.

use gear_dynamics::nalgebra::{DMatrix, DVectorView};
use gear_dynamics::ode::{OneStep, Slope};

/// The method ROS2 of order 2 with an estimate of order 1, γ = 1 - 1/√2:
///
/// (1 - γ h J) k₁ = f(t, y) + γ h f_t
///
/// (1 - γ h J) k₂ = f(t + h, y + h k₁) - 2 k₁ - γ h f_t
///
/// y₁ = y + 3/2 h k₁ + 1/2 h k₂, error (1 - γ h J)⁻¹ (y₁ - (y + h k₁)). J and f_t are differences of f: the order of the method does not
/// depend on them.   Source: Verwer, Spee, Blom & Hundsdorfer, SIAM J. Sci. Comput. 20 (1999) 1456.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ros2;

impl OneStep for Ros2 {
    fn estimate_order(&self) -> u32 {
        1
    }
    fn work(&self, components: usize) -> usize {
        4 * components
    }
    fn step(&self, f: &mut Slope<'_>, end: &mut [f64], error: &mut [f64], work: &mut [f64]) {
        let (h, m, gamma) = (f.h(), end.len(), 1.0 - std::f64::consts::FRAC_1_SQRT_2);
        let mut parts = work.chunks_exact_mut(m);
        let [Some(y), Some(by_time), Some(k1), Some(k2)] = std::array::from_fn(|_| parts.next()) else {
            return;
        };
        y.copy_from_slice(f.start());
        const C: f64 = 1e-3;
        f.at(C, y, by_time);
        (0..m).for_each(|j| by_time[j] = gamma / C * (by_time[j] - f.first()[j]));
        let mut matrix = DMatrix::identity(m, m);
        for column in 0..m {
            let change = 1e-7 * (y[column].abs() + (h * f.first()[column]).abs()).max(1e-6);
            y[column] += change;
            f.at(0.0, y, k1);
            y[column] = f.start()[column];
            for row in 0..m {
                matrix[(row, column)] -= gamma * h * (k1[row] - f.first()[row]) / change;
            }
        }
        let factors = matrix.lu();
        let solve = |k: &mut [f64]| match factors.solve(&DVectorView::from_slice(k, m).into_owned()) {
            Some(solution) => k.copy_from_slice(solution.as_slice()),
            None => k.fill(f64::NAN),
        };
        (0..m).for_each(|j| k1[j] = f.first()[j] + by_time[j]);
        solve(k1);
        (0..m).for_each(|j| y[j] += h * k1[j]);
        f.at(1.0, y, k2);
        (0..m).for_each(|j| k2[j] -= 2.0 * k1[j] + by_time[j]);
        solve(k2);
        for j in 0..m {
            end[j] = f.start()[j] + h * (1.5 * k1[j] + 0.5 * k2[j]);
            error[j] = end[j] - y[j];
        }
        // y + h k₁ does not damp stiff components; their error after the filter is that of the method.
        solve(error);
    }
}

/// Heun's method of order 2, without an estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HeunStep;

impl OneStep for HeunStep {
    fn work(&self, components: usize) -> usize {
        components
    }
    fn step(&self, f: &mut Slope<'_>, end: &mut [f64], _: &mut [f64], second: &mut [f64]) {
        let h = f.h();
        (0..end.len()).for_each(|j| end[j] = f.start()[j] + h * f.first()[j]);
        f.at(1.0, end, second);
        (0..end.len()).for_each(|j| end[j] = f.start()[j] + 0.5 * h * (f.first()[j] + second[j]));
    }
}
