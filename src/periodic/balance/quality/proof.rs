//! How good an orbit is.

use crate::contact::piece::Piece;
use crate::error::ParameterError;
use crate::model::equations::Periodic;
use crate::model::machine::Machine;
use crate::model::shape::Shape;
use crate::ode::budget::Meter;
use crate::periodic::balance::equations::residual::{BalanceEquations, Method};
use crate::periodic::balance::error::BalanceError;
use crate::periodic::balance::integrals::Integrals;
use crate::periodic::balance::note::BalanceNote;
use crate::periodic::balance::orbit::FourierOrbit;
use crate::periodic::balance::quadrature::pulses::pulses;
use crate::periodic::balance::quality::coarseness;
use crate::periodic::balance::quality::coarseness::{COARSE, correction};
use crate::periodic::balance::series::couplings::even;
use crate::periodic::balance::settings::Balance;
use crate::periodic::shooting::orbit::ShootingOrbit;
use nalgebra::DMatrix;
use nalgebra::DVector;

/// Proof of an orbit.
///
/// ```
/// use gear_dynamics::{Balance, Harmonics, NfgPair, NfgParams, contact::Piece};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let balance = Balance::new(Harmonics::up_to(70));
/// let orbit = balance.solve(&pair, &balance.linearised(&pair, Piece::Lower)?)?;
/// let proof = balance.prove(&pair, &orbit)?;
/// assert!((proof.truncation - 5.469e-6).abs() < 1e-9); // what 70 orders miss of the peak-to-peak
/// assert!(proof.aliasing < 1e-9 && proof.finer.harmonics().highest() == 91);
/// # Ok::<(), gear_dynamics::periodic::BalanceError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Proof {
    /// max |z_H - z_1.3H| over the peak-to-peak: the error of this orbit, where both converged.
    pub truncation: f64,
    /// The orbit on 1.3 H orders.
    pub finer: FourierOrbit,
    /// The first Newton correction that finer integrals ask for, over the peak-to-peak: exact ones where contacts were sampled, else twice the samples
    /// or half the panels' width, or panels around the pulses that the drives hide between them. What the root finder left over is in it too.
    pub aliasing: f64,
    /// The first correction of multiple shooting, over the range of motion: a few times smaller than the error when it is small; above 0.1,
    /// and infinite when shooting finds nothing, there is no orbit of the equation near.
    pub shooting: f64,
    /// The orbit of the equation itself, to 1e-12, with its monodromy, if shooting found it.
    pub polished: Option<ShootingOrbit>,
}

/// Orders must pass the fastest local natural order by this factor.
const RESOLVED: f64 = 1.2;

/// Sampling that moves an orbit by more than this share of its peak-to-peak is noted.
const ALIASED: f64 = 1e-3;

impl Balance {
    /// Solves again on 1.3 H orders, asks finer integrals for their correction, and shoots from the orbit.
    ///
    /// # Errors
    /// [`BalanceError`] if the finer balance has no orbit near this one: then it is not to be believed.
    pub fn prove<M: Periodic + ?Sized>(
        &self,
        model: &M,
        orbit: &FourierOrbit,
    ) -> Result<Proof, BalanceError> {
        self.prove_within(&model, orbit, &self.budget.begin())
    }

    fn prove_within(
        &self,
        model: &dyn Periodic,
        orbit: &FourierOrbit,
        meter: &Meter<'_>,
    ) -> Result<Proof, BalanceError> {
        let finer = self.on(self.harmonics().extended()).solve_within(model, orbit, meter)?;
        let pulsed = !pulses(model, orbit, self.harmonics()).is_empty();
        let better = match self.integrals {
            _ if pulsed => self.clone().integrals(Integrals::Panels).equations(model, orbit)?,
            Integrals::Sampled { .. } if model.contacts() > 0 => {
                Balance::new(self.harmonics().clone()).equations(model, orbit)?
            }
            _ => self.finer_equations(model, orbit)?,
        };
        proof(model, orbit, finer, correction(better, orbit), meter)
    }

    /// The same for an orbit of [`solve_truncating_forces`](Balance::solve_truncating_forces): on 1.3 H orders and with twice the samples, forces
    /// truncated too. Its truncation tells how far that balance is from its own limit; the shooting, how far from the equation.
    ///
    /// # Errors
    /// [`BalanceError`] if the finer balance has no orbit near this one.
    pub fn prove_truncating_forces<G: Shape>(
        &self,
        model: &Machine<G>,
        orbit: &FourierOrbit,
    ) -> Result<Proof, BalanceError> {
        let meter = self.budget.begin();
        let finer = self.on(self.harmonics().extended()).solve_truncating_within(model, orbit, &meter)?;
        let aliasing = correction(self.finer_equations(model, orbit)?.truncating_forces(), orbit);
        proof(&model, orbit, finer, aliasing, &meter)
    }

    /// Adds orders until the truncation error, the correction of finer integrals and that of shooting, which sees what no kept order does, all
    /// fall below `accuracy`, a share of the peak-to-peak, up to order `highest`.
    ///
    /// # Errors
    /// [`BalanceError::Accuracy`] with the best orbit when that takes more orders, or when no orbit is found on more; [`BalanceError`] if there is none
    /// from the guess.
    pub fn solve_to<M: Periodic + ?Sized>(
        &self,
        model: &M,
        guess: &FourierOrbit,
        accuracy: f64,
        highest: usize,
    ) -> Result<Proof, BalanceError> {
        crate::error::check::positive("accuracy", accuracy)?;
        let least = self.harmonics().highest();
        if highest < least {
            return Err(ParameterError::TooFew { name: "highest order".into(), value: highest, least }.into());
        }
        let (mut balance, meter) = (self.clone(), self.budget.begin());
        let mut orbit = balance.solve_within(&model, guess, &meter)?;
        let mut reached = f64::INFINITY;
        loop {
            let further = balance.harmonics().extended();
            if further.highest() > highest {
                return Err(BalanceError::Accuracy {
                    wanted: accuracy,
                    reached,
                    highest,
                    best: Box::new(orbit),
                    cause: None,
                });
            }
            let proof = match balance.prove_within(&model, &orbit, &meter) {
                Ok(proof) => proof,
                Err(error) => {
                    let (highest, cause) = (balance.harmonics().highest(), Some(Box::new(error)));
                    return Err(BalanceError::Accuracy {
                        wanted: accuracy,
                        reached,
                        highest,
                        best: Box::new(orbit),
                        cause,
                    });
                }
            };
            reached = proof.truncation.max(proof.aliasing).max(proof.shooting);
            if reached <= accuracy {
                return Ok(proof);
            }
            balance = balance.on(further);
            orbit = proof.finer;
        }
    }
}

fn proof(
    model: &dyn Periodic,
    orbit: &FourierOrbit,
    finer: FourierOrbit,
    aliasing: f64,
    meter: &Meter<'_>,
) -> Result<Proof, BalanceError> {
    let polished = orbit.polish_metered(model, meter).ok();
    if let Some(exhausted) = meter.exhausted() {
        return Err(BalanceError::Budget { exhausted, last: Box::new(finer), history: Vec::new() });
    }
    let shooting = polished.as_ref().map_or(f64::INFINITY, ShootingOrbit::first_correction);
    Ok(Proof { truncation: orbit.distance(&finer), finer, aliasing, shooting, polished })
}

/// What every solved orbit is checked for.
pub(crate) fn notes<'m, M: Periodic + ?Sized>(
    equations: &mut BalanceEquations<'m, M>,
    orbit: &FourierOrbit,
    finer: impl FnOnce(&FourierOrbit) -> Result<BalanceEquations<'m, M>, BalanceError>,
) -> Vec<BalanceNote> {
    let mut notes = Vec::new();
    let (highest, needed) = (orbit.harmonics().highest(), RESOLVED * natural_order(equations));
    if (highest as f64) < needed {
        notes.push(BalanceNote::Unresolved { highest, needed });
    }
    if let Method::Sampled(_) = equations.method
        && equations.grid.model.contacts() > 0
        && let Ok(exact) = Balance::new(orbit.harmonics().clone()).equations(equations.grid.model, orbit)
    {
        let error = correction(exact, orbit);
        if error > ALIASED {
            notes.push(BalanceNote::Aliased { samples: equations.grid.samples(), error });
        }
    }
    if !orbit.harmonics().has_mean() {
        let share = mean_force(equations);
        notes.extend((share > COARSE).then_some(BalanceNote::MeanForce { share }));
    }
    notes.extend(coarseness::note(equations, orbit, finer));
    notes
}

/// The mean acceleration along an orbit, as a share of the largest of its coordinate.
fn mean_force<M: Periodic + ?Sized>(equations: &BalanceEquations<'_, M>) -> f64 {
    let (grid, n) = (&equations.grid, equations.layout.dof);
    let (mut q, mut v, mut a) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    let mut seen = vec![[0.0f64; 2]; n];
    for s in 0..grid.samples() {
        grid.state(s, &mut q, &mut v);
        grid.model.accel(grid.drives(s), &q, &v, &mut a);
        seen.iter_mut()
            .zip(&a)
            .for_each(|([sum, largest], a)| (*sum, *largest) = (*sum + a, largest.max(a.abs())));
    }
    let share = |[sum, largest]: [f64; 2]| {
        if largest > 0.0 { (sum / grid.samples() as f64).abs() / largest } else { 0.0 }
    };
    seen.into_iter().map(share).fold(0.0, f64::max)
}

/// √(largest local stiffness)/ω, every contact on a flank.
fn natural_order<M: Periodic + ?Sized>(equations: &mut BalanceEquations<'_, M>) -> f64 {
    let (n, m, contacts) = (equations.layout.dof, equations.grid.samples(), equations.grid.model.contacts());
    let flanks = match contacts {
        0 => vec![None],
        _ => vec![Some(vec![Piece::Lower; contacts]), Some(vec![Piece::Upper; contacts])],
    };
    let (mut q, mut v) = (vec![0.0; n], vec![0.0; n]);
    let mut stiffest = 0.0f64;
    let looks = m.min(if n == 1 { 128 } else { 64 });
    for look in 0..looks {
        // Evenly spread, but in step with no drive.
        let s = if looks == m { look } else { (even(look, 0) * m as f64) as usize };
        equations.grid.state(s, &mut q, &mut v);
        for flank in &flanks {
            equations.slopes.at(flank.as_deref(), equations.grid.drives(s), &q, &v);
            let slopes = &equations.slopes.jacobian.q;
            stiffest = stiffest.max(if n == 1 { -slopes[(0, 0)] } else { largest_eigenvalue(&-slopes) });
        }
    }
    stiffest.sqrt() / equations.layout.omega
}

/// By power iteration: M⁻¹K is similar to a symmetric matrix without negative eigenvalues.
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
