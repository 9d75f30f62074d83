//! Notes on the reliability of a solved orbit.

use crate::contact::Piece;
use crate::numeric::spread::weyl;
use crate::periodic::balance::balance_error::BalanceError;
use crate::periodic::balance::equations::balance_equations::BalanceEquations;
use crate::periodic::balance::fourier_orbit::FourierOrbit;
use crate::periodic::balance::note::BalanceNote;
use crate::periodic::balance::quality::coarseness::{self, COARSE, correction};
use crate::periodic::balance::settings::Balance;
use nalgebra::{DMatrix, DVector};

/// Required ratio of the highest order to the fastest local natural order `[1]`.
const RESOLVED: f64 = 1.2;

/// Largest error by sampling without a note, as a share of the peak-to-peak value `[1]`.
const ALIASED: f64 = 1e-3;

/// Checks a solved orbit and returns its notes.
pub(crate) fn notes<'m>(
    equations: &mut BalanceEquations<'m>,
    orbit: &FourierOrbit,
    finer: impl FnOnce(&FourierOrbit) -> Result<BalanceEquations<'m>, BalanceError>,
) -> Vec<BalanceNote> {
    let mut notes = Vec::new();
    let (highest, needed) = (orbit.harmonics().highest(), RESOLVED * natural_order(equations));
    if (highest as f64) < needed {
        notes.push(BalanceNote::Unresolved { highest, needed });
    }
    if equations.work.integration.plain_samples().is_some()
        && equations.grid.model.contacts() > 0
        && let Ok(mut exact) = Balance::new(orbit.harmonics().clone()).equations(equations.grid.model, orbit)
    {
        let error = correction(&mut exact, orbit);
        if error > ALIASED {
            notes.push(BalanceNote::Aliased { samples: equations.grid.samples(), error });
        }
    }
    if !orbit.harmonics().has_mean() {
        let share = mean_acceleration_share(equations);
        notes.extend((share > COARSE).then_some(BalanceNote::MeanAcceleration { share }));
    }
    notes.extend(coarseness::note(equations, orbit, finer));
    notes
}

/// Largest mean acceleration of a coordinate along an orbit, as a share of the largest acceleration of this
/// coordinate.
fn mean_acceleration_share(equations: &BalanceEquations<'_>) -> f64 {
    let (grid, n) = (&equations.grid, equations.work.layout.dof);
    let (mut q, mut v, mut a) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    let mut ranges = vec![[0.0f64; 2]; n];
    for s in 0..grid.samples() {
        grid.state(s, &mut q, &mut v);
        grid.model.accel(grid.drives(s), &q, &v, &mut a);
        ranges
            .iter_mut()
            .zip(&a)
            .for_each(|([sum, largest], a)| (*sum, *largest) = (*sum + a, largest.max(a.abs())));
    }
    let share = |[sum, largest]: [f64; 2]| {
        if largest > 0.0 { (sum / grid.samples() as f64).abs() / largest } else { 0.0 }
    };
    ranges.into_iter().map(share).fold(0.0, f64::max)
}

/// √(largest local stiffness)/ω, with every contact on a flank.
fn natural_order(equations: &mut BalanceEquations<'_>) -> f64 {
    let (n, m, contacts) =
        (equations.work.layout.dof, equations.grid.samples(), equations.grid.model.contacts());
    let flanks = match contacts {
        0 => vec![None],
        _ => vec![Some(vec![Piece::Lower; contacts]), Some(vec![Piece::Upper; contacts])],
    };
    let (mut q, mut v) = (vec![0.0; n], vec![0.0; n]);
    let mut stiffest = 0.0f64;
    let instants = m.min(if n == 1 { 128 } else { 64 });
    for probe in 0..instants {
        // Evenly spread, but not in phase with any drive.
        let s = if instants == m { probe } else { (weyl(probe, 0) * m as f64) as usize };
        equations.grid.state(s, &mut q, &mut v);
        for flank in &flanks {
            equations.slopes.at(flank.as_deref(), equations.grid.drives(s), &q, &v);
            let slopes = &equations.slopes.jacobian.q;
            stiffest = stiffest.max(if n == 1 { -slopes[(0, 0)] } else { largest_eigenvalue(&-slopes) });
        }
    }
    stiffest.sqrt() / equations.work.layout.omega
}

/// Largest eigenvalue, by power iteration. M⁻¹K is similar to a symmetric matrix without negative
/// eigenvalues.
fn largest_eigenvalue(stiffness: &DMatrix<f64>) -> f64 {
    let mut mode = DVector::from_fn(stiffness.nrows(), |i, _| 1.0 + (i as f64 * 0.7).sin());
    let mut eigenvalue = 0.0;
    for _ in 0..60 {
        let next = stiffness * &mode;
        eigenvalue = next.norm() / mode.norm();
        if !(eigenvalue > 0.0 && eigenvalue.is_finite()) {
            return 0.0;
        }
        mode = next / eigenvalue;
    }
    eigenvalue
}
