//! How good an orbit is.

use super::residual::Method;
use super::{Balance, BalanceEquations, BalanceError, BalanceNote, Integrals, Orbit};
use crate::model::Periodic;
use crate::orbit::Cycle;
use crate::piece::Piece;
use crate::root::{Factors, Residual};
use nalgebra::{DMatrix, DVector};

/// Proof of an orbit.
///
/// ```
/// use gear_dynamics::{Balance, Harmonics, NfgPair, NfgParams, Piece};
/// let pair = NfgPair::new(&NfgParams { speed: 220.0, ..NfgParams::table1() })?;
/// let balance = Balance::new(Harmonics::up_to(70));
/// let orbit = balance.solve(&pair, &balance.linearised(&pair, Piece::Lower)?);
/// assert!(orbit.is_err() || balance.prove(&pair, &orbit?)?.truncation > 1e-3);
/// # Ok::<(), gear_dynamics::BalanceError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Proof {
    /// max |z_H - z_1.3H| over the peak-to-peak: the error of this orbit, where both converged.
    pub truncation: f64,
    /// The orbit on 1.3 H orders.
    pub finer: Orbit,
    /// The correction that exact integrals ask for, over the peak-to-peak, where contacts were sampled; zero otherwise, also for the samples of
    /// a model without contacts.
    pub aliasing: f64,
    /// The first correction of multiple shooting, over the range of motion: a few times smaller than the error when it is small; above 0.1,
    /// and infinite when shooting finds nothing, there is no orbit of the equation near.
    pub shooting: f64,
    /// The orbit of the equation itself, to 1e-12, with its monodromy, if shooting found it.
    pub polished: Option<Cycle>,
}

/// Orders must pass the fastest local natural order by this factor.
const RESOLVED: f64 = 1.2;
/// Sampling that moves an orbit by more than this share of its peak-to-peak is noted.
const ALIASED: f64 = 1e-3;

impl Balance {
    /// Solves again on 1.3 H orders, asks for the correction of exact integrals where these were sampled, and shoots from the orbit.
    ///
    /// # Errors
    /// [`BalanceError`] if the finer balance has no orbit near this one: then it is not to be believed.
    pub fn prove<M: Periodic + ?Sized>(&self, model: &M, orbit: &Orbit) -> Result<Proof, BalanceError> {
        self.prove_any(&model, orbit)
    }

    fn prove_any(&self, model: &dyn Periodic, orbit: &Orbit) -> Result<Proof, BalanceError> {
        let finer = self.on(self.harmonics().extended()).solve(model, orbit)?;
        let aliasing = match self.integrals {
            Integrals::Sampled { .. } => aliasing(&self.equations(model, orbit)?, orbit)?,
            _ => 0.0,
        };
        let polished = orbit.polish(model).ok();
        let shooting = polished.as_ref().map_or(f64::INFINITY, Cycle::first_correction);
        Ok(Proof { truncation: orbit.distance(&finer), finer, aliasing, shooting, polished })
    }

    /// Adds orders until the truncation error falls below `accuracy`, a share of the peak-to-peak, up to order `highest`.
    ///
    /// # Errors
    /// [`BalanceError::Accuracy`] with the best orbit when that takes more orders; [`BalanceError`] if a solution is lost.
    pub fn solve_to<M: Periodic + ?Sized>(&self, model: &M, guess: &Orbit, accuracy: f64, highest: usize) -> Result<Proof, BalanceError> {
        crate::error::check::positive("accuracy", accuracy)?;
        let mut balance = self.clone();
        let mut orbit = balance.solve(model, guess)?;
        let mut reached = f64::INFINITY;
        loop {
            let further = balance.harmonics().extended();
            if further.highest() > highest {
                return Err(BalanceError::Accuracy { wanted: accuracy, reached, highest, best: Box::new(orbit) });
            }
            let proof = balance.prove(model, &orbit)?;
            reached = proof.truncation;
            if reached <= accuracy {
                return Ok(proof);
            }
            balance = balance.on(further);
            orbit = proof.finer;
        }
    }
}

/// What every solved orbit is checked for.
pub(super) fn notes<M: Periodic + ?Sized>(equations: &mut BalanceEquations<'_, M>, orbit: &Orbit) -> Vec<BalanceNote> {
    let mut notes = Vec::new();
    let (highest, needed) = (orbit.harmonics().highest(), RESOLVED * natural_order(equations));
    if (highest as f64) < needed {
        notes.push(BalanceNote::Unresolved { highest, needed });
    }
    if let Method::Sampled(_) = equations.method
        && equations.grid.model.contacts() > 0
        && let Ok(error) = aliasing(equations, orbit)
        && error > ALIASED
    {
        notes.push(BalanceNote::Aliased { samples: equations.grid.samples(), error });
    }
    notes
}

/// √(largest local stiffness)/ω, every contact on a flank.
fn natural_order<M: Periodic + ?Sized>(equations: &mut BalanceEquations<'_, M>) -> f64 {
    let (n, m) = (equations.layout.dof, equations.grid.samples());
    let pieces = vec![Piece::Lower; equations.grid.model.contacts()];
    let held = (!pieces.is_empty()).then_some(&pieces[..]);
    let (mut q, mut v) = (vec![0.0; n], vec![0.0; n]);
    let mut stiffest = 0.0f64;
    for s in (0..m).step_by((m / if n == 1 { 256 } else { 64 }).max(1)) {
        equations.grid.state(s, &mut q, &mut v);
        equations.slopes.at(held, equations.grid.drives(s), &q, &v);
        let slopes = &equations.slopes.jacobian.q;
        stiffest = stiffest.max(if n == 1 { -slopes[(0, 0)] } else { largest_eigenvalue(&-slopes) });
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

/// One Newton correction towards exact integrals, as a share of the peak-to-peak.
fn aliasing<M: Periodic + ?Sized>(equations: &BalanceEquations<'_, M>, orbit: &Orbit) -> Result<f64, BalanceError> {
    let exact = Balance::new(orbit.harmonics().clone());
    let mut exact = exact.equations(equations.grid.model, orbit)?;
    let x = exact.unknowns(orbit);
    let (mut matrix, mut r) = (exact.matrix(), vec![0.0; x.len()]);
    exact.residual(&x, &mut r);
    exact.jacobian(&x, &mut matrix);
    let Ok(factors) = Factors::new(&matrix) else {
        return Ok(f64::INFINITY);
    };
    factors.solve(&mut r);
    let moved: Vec<f64> = x.iter().zip(&r).map(|(x, r)| x - r).collect();
    Ok(orbit.distance(&exact.orbit(&moved)))
}
