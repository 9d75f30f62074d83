//! Whether integrals are too coarse for the forces along an orbit.

use crate::excitation::side::Side;
use crate::model::equations::Periodic;
use crate::periodic::balance::equations::residual::{BalanceEquations, Method};
use crate::periodic::balance::error::BalanceError;
use crate::periodic::balance::note::BalanceNote;
use crate::periodic::balance::orbit::AT_REST;
use crate::periodic::balance::orbit::{FourierOrbit, turned};
use crate::periodic::balance::series::couplings::even;
use crate::periodic::balance::series::transform::unpack;
use crate::roots::factors::Factors;
use crate::roots::norms::largest;
use crate::roots::residual::Residual;
use num_complex::Complex64;

/// Forces that finer integrals change by more than this share of the largest are noted.
pub(crate) const COARSE: f64 = 1e-6;

/// Samples whose interpolation gives the forces between them this well need no finer ones.
const SMOOTH: f64 = 1e-9;

/// Instants looked at between samples.
const LOOKS: usize = 3;

/// A note, if integrals twice as fine give other forces. Sampled contacts have one of their own.
pub(crate) fn note<'m, M: Periodic + ?Sized>(
    equations: &mut BalanceEquations<'m, M>,
    orbit: &FourierOrbit,
    finer: impl FnOnce(&FourierOrbit) -> Result<BalanceEquations<'m, M>, BalanceError>,
) -> Option<BalanceNote> {
    let by_samples = match equations.method {
        Method::Closed(_) | Method::Held(..) => return None,
        Method::Sampled(_) if equations.grid.model.contacts() > 0 => return None,
        Method::Sampled(_) | Method::Truncated(..) => true,
        Method::Kinks(_) | Method::Panels(_) => false,
    };
    if by_samples && between_samples(equations, orbit) <= SMOOTH {
        return None;
    }
    let mut finer = finer(orbit).ok()?;
    let x = finer.unknowns(orbit);
    let mut r = vec![0.0; x.len()];
    finer.residual(&x, &mut r);
    let sizes: Vec<f64> = finer.spectra.force.iter().map(|fine| largest(fine)).collect();
    let sizes = against(&sizes, &equations.layout.scales);
    let mut share = 0.0f64;
    for ((coarse, fine), size) in equations.spectra.force.iter().zip(&finer.spectra.force).zip(sizes) {
        let apart = coarse.iter().zip(fine).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
        share = share.max(if apart > 0.0 { apart / size } else { 0.0 });
    }
    (share > COARSE).then_some(BalanceNote::Coarse { integrals: equations.integrals(), share })
}

/// What forces of these sizes are measured by: themselves, or a small share of the largest in units of the scales, below which one is rounding.
fn against(forces: &[f64], scales: &[f64]) -> Vec<f64> {
    let most = forces.iter().zip(scales).fold(0.0, |m: f64, (f, s)| m.max(f / s));
    forces.iter().zip(scales).map(|(f, s)| f.max(AT_REST * most * s)).collect()
}

/// How far the accelerations along an orbit are, between samples, from the trigonometric polynomials through these, as a share of the
/// largest: both too few samples and drives that fold onto lower orders show.
fn between_samples<M: Periodic + ?Sized>(
    equations: &mut BalanceEquations<'_, M>,
    orbit: &FourierOrbit,
) -> f64 {
    let grid = &mut equations.grid;
    let (n, m, span) = (grid.dof(), grid.samples(), grid.span());
    let (mut q, mut v, mut a) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    let mut z = vec![vec![Complex64::ZERO; m]; n];
    match &equations.method {
        Method::Sampled(samples) => {
            for (z, force) in z.iter_mut().zip(&samples.force) {
                z.iter_mut().zip(force).for_each(|(z, f)| *z = (*f).into());
            }
        }
        _ => {
            for s in 0..m {
                grid.state(s, &mut q, &mut v);
                grid.model.accel(grid.drives(s), &q, &v, &mut a);
                z.iter_mut().zip(&a).for_each(|(z, a)| z[s] = (*a).into());
            }
        }
    }
    let largest: Vec<f64> =
        z.iter().map(|z| z.iter().fold(0.0, |largest: f64, z| largest.max(z.re.abs()))).collect();
    let largest = against(&largest, &equations.layout.scales);
    z.iter_mut().for_each(|z| grid.transform.analyse(z));
    let shares: [f64; LOOKS] = std::array::from_fn(|look| even(look, 1));
    let times = shares.map(|share| span * share);
    let [sin, cos] = turned(shares);
    let mut motion = [vec![[0.0; LOOKS]; n], vec![[0.0; LOOKS]; n]];
    let [positions, rates] = &mut motion;
    orbit.motions(times, [sin, cos], positions, rates);
    let mut there = vec![[0.0; LOOKS]; n];
    let mut u = vec![0.0; grid.model.drives()];
    for look in 0..LOOKS {
        let [positions, rates] = &motion;
        q.iter_mut().zip(positions).chain(v.iter_mut().zip(rates)).for_each(|(x, looks)| *x = looks[look]);
        grid.model.drive(times[look], Side::After, &mut u);
        grid.model.accel(&u, &q, &v, &mut a);
        there.iter_mut().zip(&a).for_each(|(looks, a)| looks[look] = *a);
    }
    let turns: [Complex64; LOOKS] = std::array::from_fn(|look| Complex64::new(cos[look], sin[look]));
    let mut worst = 0.0f64;
    for ((z, there), largest) in z.iter().zip(&there).zip(&largest) {
        // Horner's rule from the highest order down.
        let mut sums = [Complex64::ZERO; LOOKS];
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

/// One Newton correction of an orbit towards given equations, as a share of the peak-to-peak; infinite if they are singular there.
pub(crate) fn correction<M: Periodic + ?Sized>(
    mut equations: BalanceEquations<'_, M>,
    orbit: &FourierOrbit,
) -> f64 {
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
