//! Check whether the integrals are too coarse for the accelerations along an orbit.

use crate::excitation::Side;
use crate::numeric::norms::largest;
use crate::numeric::spread::weyl;
use crate::periodic::balance::balance_error::BalanceError;
use crate::periodic::balance::equations::balance_equations::BalanceEquations;
use crate::periodic::balance::fourier_orbit::{AT_REST, FourierOrbit, turned};
use crate::periodic::balance::integration::integration_trait::Check;
use crate::periodic::balance::note::BalanceNote;
use crate::periodic::balance::series::transform::unpack;
use crate::roots::Residual;
use crate::roots::factors::Factors;
use num_complex::Complex64;

/// Largest change of the accelerations by finer integrals without a note, as a share of the largest
/// coefficient `[1]`.
pub(crate) const COARSE: f64 = 1e-6;

/// Factor on the number of samples or panels that shows whether they are enough.
pub(crate) const MORE: usize = 2;

/// If the samples interpolate the accelerations between them to this share, finer integrals are not computed
/// `[1]`.
const SMOOTH: f64 = 1e-9;

/// Number of instants between the samples at which the interpolation is checked.
const INSTANTS_BETWEEN: usize = 3;

/// Returns [`BalanceNote::Coarse`] if the Fourier coefficients of the accelerations change by more than
/// [`COARSE`] of the largest one when twice as many samples or panels are used.
///
/// `None` also if the samples already interpolate the accelerations to [`SMOOTH`], or if the finer equations
/// cannot be set up. Not checked: closed form, linearised orbits, and sampled contacts, for which `notes`
/// checks [`BalanceNote::Aliased`] instead.
pub(crate) fn note<'m>(
    equations: &mut BalanceEquations<'m>,
    orbit: &FourierOrbit,
    finer: impl FnOnce(&FourierOrbit) -> Result<BalanceEquations<'m>, BalanceError>,
) -> Option<BalanceNote> {
    match equations.work.integration.check() {
        Check::Unnecessary => return None,
        Check::BetweenSamples if between_samples(equations, orbit) <= SMOOTH => return None,
        Check::BetweenSamples | Check::Finer => {}
    }
    let mut finer = finer(orbit).ok()?;
    let x = finer.unknowns(orbit);
    let mut r = vec![0.0; x.len()];
    finer.residual(&x, &mut r);
    let sizes: Vec<f64> = finer.work.spectra.accelerations.iter().map(|fine| largest(fine)).collect();
    let sizes = against(&sizes, &equations.work.layout.scales);
    let mut share = 0.0f64;
    for ((coarse, fine), size) in
        equations.work.spectra.accelerations.iter().zip(&finer.work.spectra.accelerations).zip(sizes)
    {
        let apart = coarse.iter().zip(fine).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
        share = share.max(if apart > 0.0 { apart / size } else { 0.0 });
    }
    (share > COARSE).then_some(BalanceNote::Coarse { integrals: equations.integrals(), share })
}

/// Reference values of accelerations: their own sizes, or [`AT_REST`] times the largest in units of the
/// scales where that is larger. An acceleration below this share is rounding.
fn against(forces: &[f64], scales: &[f64]) -> Vec<f64> {
    let most = forces.iter().zip(scales).fold(0.0, |m: f64, (f, s)| m.max(f / s));
    forces.iter().zip(scales).map(|(f, s)| f.max(AT_REST * most * s)).collect()
}

/// Largest distance, between the samples, of the accelerations along an orbit from the trigonometric
/// polynomials through the samples, as a share of the largest acceleration. It reveals too few samples, and
/// drives whose orders appear as lower ones.
fn between_samples(equations: &mut BalanceEquations<'_>, orbit: &FourierOrbit) -> f64 {
    let grid = &mut equations.grid;
    let (n, m, span) = (grid.dof(), grid.samples(), grid.span());
    let (mut q, mut v, mut a) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    let mut z = vec![vec![Complex64::ZERO; m]; n];
    match equations.work.integration.plain_samples() {
        Some(samples) => {
            for (z, samples) in z.iter_mut().zip(samples) {
                z.iter_mut().zip(samples).for_each(|(z, a)| *z = (*a).into());
            }
        }
        None => {
            for s in 0..m {
                grid.state(s, &mut q, &mut v);
                grid.model.accel(grid.drives(s), &q, &v, &mut a);
                z.iter_mut().zip(&a).for_each(|(z, a)| z[s] = (*a).into());
            }
        }
    }
    let largest: Vec<f64> =
        z.iter().map(|z| z.iter().fold(0.0, |largest: f64, z| largest.max(z.re.abs()))).collect();
    let largest = against(&largest, &equations.work.layout.scales);
    z.iter_mut().for_each(|z| grid.transform.analyse(z));
    let shares: [f64; INSTANTS_BETWEEN] = std::array::from_fn(|probe| weyl(probe, 1));
    let times = shares.map(|share| span * share);
    let [sin, cos] = turned(shares);
    let mut motion = [vec![[0.0; INSTANTS_BETWEEN]; n], vec![[0.0; INSTANTS_BETWEEN]; n]];
    let [positions, rates] = &mut motion;
    orbit.motions(times, [sin, cos], positions, rates);
    let mut there = vec![[0.0; INSTANTS_BETWEEN]; n];
    let mut u = vec![0.0; grid.model.drives()];
    for probe in 0..INSTANTS_BETWEEN {
        let [positions, rates] = &motion;
        q.iter_mut().zip(positions).chain(v.iter_mut().zip(rates)).for_each(|(x, values)| *x = values[probe]);
        grid.model.drive(times[probe], Side::After, &mut u);
        grid.model.accel(&u, &q, &v, &mut a);
        there.iter_mut().zip(&a).for_each(|(values, a)| values[probe] = *a);
    }
    let turns: [Complex64; INSTANTS_BETWEEN] =
        std::array::from_fn(|probe| Complex64::new(cos[probe], sin[probe]));
    let mut worst = 0.0f64;
    for ((z, there), largest) in z.iter().zip(&there).zip(&largest) {
        // Horner's rule from the highest order down.
        let mut sums = [Complex64::ZERO; INSTANTS_BETWEEN];
        for k in (1..m.div_ceil(2)).rev() {
            let term = unpack(z, k).0;
            sums.iter_mut().zip(&turns).for_each(|(sum, turn)| *sum = (*sum + term) * turn);
        }
        for (sum, a) in sums.iter().zip(there) {
            let apart = (z[0].re / m as f64 + 2.0 * sum.re - a).abs();
            worst = worst.max(if apart > 0.0 { apart / largest } else { 0.0 });
        }
    }
    worst
}

/// One Newton correction of an orbit by given equations, as a share of its peak-to-peak value; infinite if
/// the equations are singular at the orbit.
pub(crate) fn correction(equations: &mut BalanceEquations<'_>, orbit: &FourierOrbit) -> f64 {
    let x = equations.unknowns(orbit);
    let (mut matrix, mut r) = (equations.matrix(), vec![0.0; x.len()]);
    equations.residual(&x, &mut r);
    equations.jacobian(&x, &mut matrix);
    let Ok(factors) = Factors::new(&matrix) else {
        return f64::INFINITY;
    };
    factors.solve(&mut r);
    let moved: Vec<f64> = x.iter().zip(&r).map(|(x, r)| x - r).collect();
    orbit.distance(&equations.orbit(&moved))
}
