//! Newton and Broyden, with dense matrices and with blocks, against closed forms; equations without roots;
//! invalid input.

use crate::api::*;
use approx::assert_relative_eq;
use gear_dynamics::ParameterError as P;
use proptest::prelude::*;

/// Rosenbrock's valley as equations, with the root (1, 1).
struct Valley {
    own_jacobian: bool,
}

impl Residual for Valley {
    fn size(&self) -> usize {
        2
    }
    fn residual(&mut self, x: &[f64], r: &mut [f64]) {
        (r[0], r[1]) = (10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]);
    }
    fn jacobian(&mut self, x: &[f64], out: &mut Matrix) {
        if !self.own_jacobian {
            return differences(self, x, out);
        }
        out.column_mut(0).copy_from_slice(&[-20.0 * x[0], -1.0]);
        out.column_mut(1).copy_from_slice(&[10.0, 0.0]);
    }
}

#[test]
fn newton_with_either_jacobian() -> Result<(), RootError> {
    for own_jacobian in [true, false] {
        let root = Newton::new().solve(&mut Valley { own_jacobian }, &[-1.2, 1.0])?;
        assert_relative_eq!(root.x[0], 1.0, epsilon = 1e-10);
        assert_relative_eq!(root.x[1], 1.0, epsilon = 1e-10);
        assert_eq!(root.residuals.len(), root.iterations + 1);
    }
    Ok(())
}

/// Without damping Newton's method on atan x diverges from |x| > 1.39.
#[test]
fn damping_reaches_far() -> Result<(), RootError> {
    for start in [2.0, 10.0, 50.0] {
        let root = Newton::new().solve(&mut Equations::new(1, |x, r| r[0] = x[0].atan()), &[start])?;
        assert!(root.x[0].abs() < 1e-9 * start); // the tolerance is a share of the largest x of all iterates
    }
    Ok(())
}

/// The scaling of the equations does not change the iterates of the damped Newton method.
#[test]
fn newton_is_affine_invariant() -> Result<(), RootError> {
    let plain = Newton::new().solve(
        &mut Equations::new(2, |x, r| (r[0], r[1]) = (x[0] * x[1] - 1.0, x[0] - x[1].exp() + 1.0)),
        &[2.0, 2.0],
    )?;
    let scaled = Newton::new().solve(
        &mut Equations::new(2, |x, r| {
            (r[0], r[1]) = (1e8 * (x[0] * x[1] - 1.0), 1e-6 * (x[0] - x[1].exp() + 1.0))
        }),
        &[2.0, 2.0],
    )?;
    assert_eq!(plain.iterations, scaled.iterations);
    assert_relative_eq!(plain.x[0], scaled.x[0], epsilon = 1e-10);
    Ok(())
}

/// Broyden's good method solves linear equations in at most 2n steps.   Source: Gay 1979.
#[test]
fn broyden_ends_on_linear_problems() -> Result<(), RootError> {
    let a = [[2.0, 1.0, 0.0, 0.2], [0.5, 1.5, 0.3, 0.0], [0.0, 0.1, 1.2, 0.4], [0.3, 0.0, 0.0, 0.9]];
    let mut equations = Equations::new(4, |x: &[f64], r: &mut [f64]| {
        for (r, row) in r.iter_mut().zip(&a) {
            *r = row.iter().zip(x).map(|(a, x)| a * (x - 1.0)).sum();
        }
    });
    let root = Broyden::new().tolerance(1e-12).solve(&mut equations, &[0.0; 4])?;
    assert!(root.iterations <= 9, "{}", root.iterations);
    assert!(root.x.iter().all(|x| (x - 1.0).abs() < 1e-11));
    Ok(())
}

#[test]
fn every_broyden_finds_the_root() -> Result<(), RootError> {
    let equations = || {
        Equations::new(3, |x: &[f64], r: &mut [f64]| {
            r[0] = x[0] + 0.1 * (x[1] * x[2]).sin() - 0.3;
            r[1] = 1.3 * x[1] - 0.2 * x[0] * x[0] + 0.1;
            r[2] = 0.8 * x[2] + 0.05 * (x[0] + x[1]).exp() - 1.0;
        })
    };
    let reference = Newton::new().tolerance(1e-13).solve(&mut equations(), &[0.0; 3])?;
    let first = FirstJacobian::Given({
        let mut matrix = Matrix::dense(3);
        for (j, d) in [1.0, 1.3, 0.8].into_iter().enumerate() {
            matrix.column_mut(j)[j] = d;
        }
        matrix
    });
    for broyden in [
        Broyden::new(),
        Broyden::new().bad(),
        Broyden::new().first(FirstJacobian::Own),
        Broyden::new().first(first),
        Broyden::new().restart(3),
    ] {
        let root = broyden.tolerance(1e-12).solve(&mut equations(), &[0.0; 3])?;
        for (x, y) in root.x.iter().zip(&reference.x) {
            assert_relative_eq!(x, y, epsilon = 1e-10);
        }
    }
    Ok(())
}

proptest! {
    /// A ring of blocks with one leaf each: the solution in blocks equals that of the dense matrix.
    #[test]
    fn blocks_solve_as_dense(seed in 0u64..200, gears in 3usize..7, height in 1usize..5) {
        let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(1);
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let mut pattern = Vec::new();
        for i in 0..gears {
            let (next, leaf) = ((i + 1) % gears, gears + i);
            pattern.extend([(i, i), (leaf, leaf), (i, leaf), (leaf, i), (i, next), (next, i)]);
        }
        let heights = vec![height; 2 * gears];
        struct Linear { matrix: Matrix, right: Vec<f64> }
        impl Residual for Linear {
            fn size(&self) -> usize { self.right.len() }
            fn residual(&mut self, x: &[f64], r: &mut [f64]) {
                r.iter_mut().zip(self.matrix.times(x)).zip(&self.right).for_each(|((r, ax), b)| *r = ax - b);
            }
            fn matrix(&self) -> Matrix { self.matrix.clone() }
            fn jacobian(&mut self, _: &[f64], out: &mut Matrix) {
                *out = self.matrix.clone();
            }
        }
        let mut matrix = Matrix::blocks(&heights, &pattern).unwrap();
        for &(i, j) in &pattern {
            for (k, entry) in matrix.block_mut(i, j).iter_mut().enumerate() {
                *entry = random() + if i == j && k % (height + 1) == 0 { 4.0 } else { 0.0 };
            }
        }
        let right: Vec<f64> = (0..matrix.size()).map(|_| random()).collect();
        let full = nalgebra::DMatrix::from(&matrix);
        let expected = full.lu().solve(&nalgebra::DVector::from_column_slice(&right)).unwrap();
        let zero = vec![0.0; right.len()];
        let root = Newton::new().solve(&mut Linear { matrix, right }, &zero).unwrap();
        for (x, y) in root.x.iter().zip(expected.iter()) {
            prop_assert!((x - y).abs() < 1e-12, "{} against {}", x, y);
        }
    }
}

#[test]
fn wrong_length_is_refused() {
    let error = Newton::new().solve(&mut Valley { own_jacobian: true }, &[1.0]).unwrap_err();
    assert_eq!(error, P::Length { name: "guess".into(), expected: 2, found: 1 }.into());
    let error = Broyden::new()
        .first(FirstJacobian::Given(Matrix::dense(3)))
        .solve(&mut Valley { own_jacobian: true }, &[1.0, 1.0])
        .unwrap_err();
    let name = "unknowns of the first Jacobian".into();
    assert_eq!(error, P::Length { name, expected: 2, found: 3 }.into());
}

#[test]
fn tolerance_that_is_no_share_is_refused() {
    for tolerance in [0.0, -1.0, 1.0, 1e160, f64::NAN, f64::INFINITY] {
        let error = Newton::new()
            .tolerance(tolerance)
            .solve(&mut Valley { own_jacobian: true }, &[1.0, 2.0])
            .unwrap_err();
        assert!(error.to_string().starts_with("tolerance is "));
        let error = Broyden::new()
            .tolerance(tolerance)
            .solve(&mut Valley { own_jacobian: true }, &[1.0, 2.0])
            .unwrap_err();
        assert!(error.to_string().starts_with("tolerance is "));
    }
}

#[test]
fn residual_that_is_not_a_number_is_named() {
    let error = Newton::new()
        .solve(&mut Equations::new(2, |x, r| (r[0], r[1]) = (x[0], x[1].ln())), &[1.0, -1.0])
        .unwrap_err();
    assert!(matches!(error, RootError::NotFinite { equation: 1, .. }));
    assert_eq!(error.last().unwrap().x, [1.0, -1.0]);
}

#[test]
fn singular_jacobian_names_the_free_unknown() {
    // x[2] does not occur in the equations.
    let mut equations = Equations::new(3, |x: &[f64], r: &mut [f64]| {
        (r[0], r[1], r[2]) = (x[0] - 1.0, x[1] + x[0], x[0] - x[1])
    });
    assert!(matches!(
        Newton::new().solve(&mut equations, &[0.1, 0.2, 0.3]),
        Err(RootError::Singular { unknown: 2, .. })
    ));
}

#[test]
fn no_root_hands_back_the_last_iterate() {
    let mut equations = Equations::new(1, |x: &[f64], r: &mut [f64]| r[0] = x[0] * x[0] + 0.1);
    // At the minimum of the residual the Jacobian vanishes. With either method the error contains the last
    // iterate.
    let error = Newton::new().solve(&mut equations, &[1.0]).unwrap_err();
    assert!(error.last().is_some_and(|last| last.x[0].abs() < 1.0 && last.residual >= 0.1));
    let error = Broyden::new().max_iterations(7).solve(&mut equations, &[1.0]).unwrap_err();
    let RootError::NotConverged { last } = error else { panic!("{error}") };
    assert_eq!(last.residuals.len(), 8);
}

#[test]
fn blocks_outside_or_twice_are_refused() {
    assert!(matches!(Matrix::blocks(&[2, 2], &[(0, 2)]), Err(ParameterError::Wrong { value: 2.0, .. })));
    assert!(matches!(Matrix::blocks(&[2, 2], &[(0, 1), (0, 1)]), Err(ParameterError::Wrong { .. })));
}

/// Diagonal blocks that are singular or nearly so: pivots must be sought outside them.
#[test]
fn blocks_without_pivots_of_their_own() -> Result<(), Box<dyn std::error::Error>> {
    struct Swapped {
        diagonal: f64,
    }
    impl Residual for Swapped {
        fn size(&self) -> usize {
            6
        }
        fn residual(&mut self, x: &[f64], r: &mut [f64]) {
            for i in 0..6 {
                // Each pair of unknowns is coupled to the two other pairs.
                r[i] = self.diagonal * x[i] + [2.0, 3.0][i % 2] * x[(i + 2) % 6]
                    - 0.5 * x[(i + 4) % 6]
                    - i as f64;
            }
        }
        fn matrix(&self) -> Matrix {
            let pattern: Vec<(usize, usize)> = (0..9).map(|k| (k / 3, k % 3)).collect();
            Matrix::blocks(&[2, 2, 2], &pattern).unwrap()
        }
        fn jacobian(&mut self, _: &[f64], out: &mut Matrix) {
            for i in 0..3 {
                let mut set = |j: usize, value: [f64; 2]| {
                    let block = out.block_mut(i, j);
                    (block[0], block[3]) = (value[0], value[1]);
                };
                set(i, [self.diagonal; 2]);
                set((i + 1) % 3, [2.0, 3.0]);
                set((i + 2) % 3, [-0.5; 2]);
            }
        }
    }
    for diagonal in [0.0, 1e-18, 1e-14, 1e-12, 1e-9, 1e-5, 1.0] {
        let mut equations = Swapped { diagonal };
        let root = Newton::new().tolerance(1e-14).solve(&mut equations, &[0.0; 6])?;
        println!("{diagonal:e}: {} iterations, {:.1e}", root.iterations, root.residual);
        assert!(root.iterations <= 2 && root.residual < 1e-13, "{diagonal:e}: {:?}", root.residuals);
    }
    Ok(())
}

/// Factors are kept while the corrections shrink, and computed again when they do not: an equation like a
/// dead zone, stiff outside and soft inside.
#[test]
fn kept_factors_are_made_anew() {
    let dead_zone = |x: &[f64], r: &mut [f64]| r[0] = if x[0] < 1.0 { 0.1 * x[0] } else { x[0] - 0.9 };
    let root = Newton::new().solve(&mut Equations::new(1, dead_zone), &[11.0]).unwrap();
    assert!(root.x[0].abs() < 1e-9 && root.iterations <= 3, "{root:?}");
}

/// A linear map whose given Jacobian has one column that is 30 % too large and one that is 20 % too small. It
/// counts the evaluations of the Jacobian.
struct Misjudged {
    asked: usize,
}

impl Residual for Misjudged {
    fn size(&self) -> usize {
        2
    }
    fn residual(&mut self, x: &[f64], r: &mut [f64]) {
        (r[0], r[1]) = (2.0 * x[0] + x[1] - 3.0, x[0] - 3.0 * x[1] + 2.0);
    }
    fn jacobian(&mut self, _: &[f64], out: &mut Matrix) {
        self.asked += 1;
        out.column_mut(0).copy_from_slice(&[2.0 * 1.3, 1.3]);
        out.column_mut(1).copy_from_slice(&[0.8, -3.0 * 0.8]);
    }
}

/// Good Broyden updates of the factors solve a linear equation in 2n steps (Gay 1979). Without them each step
/// would leave a quarter of the error, and 1e-10 would take 17 steps.
#[test]
fn steps_teach_the_factors() -> Result<(), RootError> {
    let mut equations = Misjudged { asked: 0 };
    let root = Newton::new().solve(&mut equations, &[0.0, 0.0])?;
    assert_eq!(equations.asked, 1);
    assert!(root.iterations <= 4, "{}", root.iterations);
    assert!((root.x[0] - 1.0).abs() < 1e-10 && (root.x[1] - 1.0).abs() < 1e-10, "{:?}", root.x);
    Ok(())
}

/// Uniform numbers in [0, 1) by SplitMix64.
fn spread(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let mut z = *seed;
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    (z ^ (z >> 31)) as f64 / 2f64.powi(64)
}

/// e^(a x) = b x has no root for b < e a. A test of the step length alone accepts a root in 17 of 20 such
/// cases.
#[test]
fn broyden_finds_no_roots_where_there_are_none() {
    let mut equation = Equations::new(1, |x: &[f64], r: &mut [f64]| {
        r[0] = (1.715_613_691_730_086_2 * x[0]).exp() - 3.068_941_040_434_752 * x[0];
    });
    let error = Broyden::new()
        .first(FirstJacobian::Own)
        .tolerance(1.8e-8)
        .solve(&mut equation, &[1.2e-6])
        .unwrap_err();
    assert!(error.last().is_some_and(|last| last.residual > 1e-3), "{error}");
    let mut seed = 7;
    for case in 0..20_000 {
        let a = 0.2 + 2.8 * spread(&mut seed);
        let b = a * std::f64::consts::E * (0.05 + 0.9 * spread(&mut seed));
        let (tolerance, start) =
            (10f64.powf(-12.0 + 6.0 * spread(&mut seed)), 10f64.powf(-7.0 + 7.0 * spread(&mut seed)));
        let mut equation = Equations::new(1, |x: &[f64], r: &mut [f64]| r[0] = (a * x[0]).exp() - b * x[0]);
        let broyden = Broyden::new().tolerance(tolerance).max_iterations(25);
        let broyden = match case % 4 {
            0 => broyden,
            1 => broyden.bad().first(FirstJacobian::Own),
            2 => broyden.restart(3).first(FirstJacobian::Own),
            _ => broyden.first(FirstJacobian::Own),
        };
        let found = broyden.solve(&mut equation, &[start]);
        assert!(found.is_err(), "{a} {b} {tolerance:e} from {start:e}: {found:?}");
    }
}

/// The residual of a root is at most that of a correction by the tolerance, computed with the exact Jacobian.
#[test]
fn residuals_of_roots_are_what_the_tolerance_promises() {
    let mut seed = 3;
    let mut solved = 0;
    for case in 0..2000 {
        let k: Vec<f64> = (0..6).map(|_| 4.0 * spread(&mut seed) - 2.0).collect();
        let tolerance = 10f64.powf(-11.0 + 5.0 * spread(&mut seed));
        let guess = [2.0 * spread(&mut seed) - 1.0, 2.0 * spread(&mut seed) - 1.0];
        let mut equations = Equations::new(2, |x: &[f64], r: &mut [f64]| {
            r[0] = (k[0] * x[0]).exp() - k[1] * x[1] + k[2];
            r[1] = x[1] * x[1] + k[3] * x[0] * x[1] + k[4] * x[0] + k[5];
        });
        let found = match case % 3 {
            0 => Broyden::new().tolerance(tolerance).max_iterations(60).solve(&mut equations, &guess),
            1 => Broyden::new()
                .first(FirstJacobian::Own)
                .tolerance(tolerance)
                .max_iterations(60)
                .solve(&mut equations, &guess),
            _ => Newton::new().tolerance(tolerance).solve(&mut equations, &guess),
        };
        let Ok(root) = found else { continue };
        solved += 1;
        let x = &root.x;
        let rows = [
            (k[0] * (k[0] * x[0]).exp()).abs() + k[1].abs(),
            (k[3] * x[1] + k[4]).abs() + (2.0 * x[1] + k[3] * x[0]).abs(),
        ];
        let size = guess.iter().chain(x).fold(0.0f64, |m, x| m.max(x.abs()));
        let mut r = [0.0; 2];
        equations.residual(x, &mut r);
        for (r, row) in r.iter().zip(rows) {
            assert!(
                r.abs() <= 1.001 * tolerance * size * row,
                "{k:?}: {r:e} against {:e}",
                tolerance * size * row
            );
        }
    }
    assert!(solved > 800, "{solved}");
}

/// x = 0 and e^x y = 1: at the guess the slope of the second equation is 1e20 times that at the root and
/// predicts a correction of almost zero. Newton must judge by the slopes at the root.
#[test]
fn newton_judges_by_slopes_of_the_root_itself() -> Result<(), RootError> {
    struct Steep;
    impl Residual for Steep {
        fn size(&self) -> usize {
            2
        }
        fn residual(&mut self, x: &[f64], r: &mut [f64]) {
            (r[0], r[1]) = (x[0], x[0].exp() * x[1] - 1.0);
        }
        fn jacobian(&mut self, x: &[f64], out: &mut Matrix) {
            out.column_mut(0).copy_from_slice(&[1.0, x[0].exp() * x[1]]);
            out.column_mut(1).copy_from_slice(&[0.0, x[0].exp()]);
        }
    }
    let root = Newton::new().solve(&mut Steep, &[46.0, 0.0])?;
    assert!(root.residual < 1e-9 && (root.x[1] - 1.0).abs() < 1e-8, "{root:?}");
    Ok(())
}

/// To the right of a kink the slope is 500 times that on its left, where the root lies. No part of the
/// correction reduces the residual as predicted.
#[test]
fn newton_passes_slopes_that_jump() -> Result<(), RootError> {
    let kink = |x: &[f64], r: &mut [f64]| r[0] = 1.0 + if x[0] > 0.0 { 100.0 * x[0] } else { 0.2 * x[0] };
    let root = Newton::new().solve(&mut Equations::new(1, kink), &[1e-4])?;
    assert!((root.x[0] + 5.0).abs() < 1e-9 && root.iterations < 8, "{root:?}");
    Ok(())
}

#[test]
fn no_equations_are_refused() {
    let empty = |error| matches!(error, RootError::Parameter(P::TooFew { value: 0, min: 1, .. }));
    assert!(empty(Newton::new().solve(&mut Equations::new(0, |_, _| {}), &[]).unwrap_err()));
    assert!(empty(Broyden::new().solve(&mut Equations::new(0, |_, _| {}), &[]).unwrap_err()));
}

/// A slope that is NaN is named; the matrix is not reported as singular.
#[test]
fn slope_that_is_not_a_number_is_named() {
    struct Torn;
    impl Residual for Torn {
        fn size(&self) -> usize {
            2
        }
        fn residual(&mut self, x: &[f64], r: &mut [f64]) {
            (r[0], r[1]) = (x[0] + x[1] - 1.0, x[0] - x[1]);
        }
        fn jacobian(&mut self, _: &[f64], out: &mut Matrix) {
            out.column_mut(0).copy_from_slice(&[1.0, f64::NAN]);
            out.column_mut(1).copy_from_slice(&[1.0, -1.0]);
        }
    }
    for found in [
        Newton::new().solve(&mut Torn, &[0.0; 2]),
        Broyden::new().first(FirstJacobian::Own).solve(&mut Torn, &[0.0; 2]),
    ] {
        assert!(
            matches!(found, Err(RootError::Slope { equation: 1, unknown: 0, value, .. }) if value.is_nan()),
            "{found:?}"
        );
    }
}

#[test]
fn blocks_that_cannot_be_stored_are_refused() {
    for heights in [&[usize::MAX, 2][..], &[2, usize::MAX], &[1 << 20, 1 << 20]] {
        assert!(matches!(Matrix::blocks(heights, &[(0, 0), (1, 1)]), Err(ParameterError::TooMany { .. })));
    }
}
