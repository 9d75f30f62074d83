//! Where the equations of a balance over a parameter come from.

use crate::branches::family::{ByFunction, Family};
use crate::branches::orbits::by_balance::along_constant::AlongConstant;
use crate::error::ParameterError;
use crate::model::{Machine, Periodic, Shape};
use crate::periodic::{Balance, BalanceEquations, BalanceError, FourierOrbit};
use std::rc::Rc;

/// A family of models of type `M`, with the equations of their balance.
pub trait BalanceFamily<M: Periodic + ?Sized> {
    fn family(&self) -> &dyn Family;
    fn at(&self, p: f64) -> Result<Rc<M>, ParameterError>;
    fn equations<'m>(
        &self,
        balance: &Balance,
        model: &'m M,
        near: &FourierOrbit,
    ) -> Result<BalanceEquations<'m, M>, BalanceError>;
    fn solve(&self, balance: &Balance, model: &M, guess: &FourierOrbit)
    -> Result<FourierOrbit, BalanceError>;
    /// Whether the balance is one of the equation: its error is small with many orders. Default: yes.
    fn is_of_equation(&self) -> bool {
        true
    }
    /// The derivative of a model with respect to the parameter, as a model, and the relative change of the
    /// speed of the phase. `None` if it is not known exactly.
    fn slope(&self, _model: &Rc<M>) -> Option<(Rc<M>, f64)> {
        None
    }
}

/// The balance of the models of any family.
pub(crate) struct Plain<'f>(pub(crate) &'f dyn Family);

impl<'f> BalanceFamily<dyn Periodic + 'f> for Plain<'f> {
    fn family(&self) -> &dyn Family {
        self.0
    }
    fn at(&self, p: f64) -> Result<Rc<dyn Periodic + 'f>, ParameterError> {
        Ok(self.0.at(p)?.into())
    }
    fn equations<'m>(
        &self,
        balance: &Balance,
        model: &'m (dyn Periodic + 'f),
        near: &FourierOrbit,
    ) -> Result<BalanceEquations<'m, dyn Periodic + 'f>, BalanceError> {
        balance.equations(model, near)
    }
    fn solve(
        &self,
        balance: &Balance,
        model: &(dyn Periodic + 'f),
        guess: &FourierOrbit,
    ) -> Result<FourierOrbit, BalanceError> {
        balance.solve(model, guess)
    }
    fn slope(&self, model: &Rc<dyn Periodic + 'f>) -> Option<(Rc<dyn Periodic + 'f>, f64)> {
        let constant = self.0.constant()?;
        if !model.offers().jacobian {
            return None;
        }
        let slope = AlongConstant::new(model, constant)?;
        let speed = slope.speed();
        Some((Rc::new(slope), speed))
    }
}

/// The machines that a closure makes, with contact forces that a balance truncates to its orders before they
/// are multiplied by the stiffness, see [`Balance::solve_truncating_forces`].   Source: Liu 2021.
///
/// Folds, branch points and grazings are located. The multipliers of the points are those of the equation
/// along the series; changes of them are not located.
///
/// ```
/// use gear_dynamics::branches::{ByFunction, Continuation, PointKind, TruncatedForces};
/// use gear_dynamics::{Balance, Harmonics, NfgPair, NfgParams, contact::Piece, models::nfg::NfgReading};
/// let params = |speed| NfgParams { speed, ..NfgParams::table1() };
/// let at = |speed| NfgPair::with_reading(&params(speed), NfgReading::published());
/// let family = ByFunction::new("speed", "rad/s", at);
/// let balance = Balance::new(Harmonics::bands(63, 1, 2)?); // the 15 unknowns of Liu 2021
/// let guess = balance.linearised(&at(179.0)?, Piece::Lower)?;
/// let range = Continuation::new(179.0, 190.0).max_points(20).balance(balance);
/// let branch = range.run(&TruncatedForces(&family), &guess)?;
/// assert!((branch.of_kind(PointKind::Fold)[0].parameter - 179.9259).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct TruncatedForces<'f, F>(pub &'f ByFunction<F>);

/// Models whose orbits can be followed by harmonic balance.
pub trait Balanced {
    /// The type of the models.
    type Of<'f>: Periodic + ?Sized
    where
        Self: 'f;
    /// The models with the equations of their balance.
    fn balanced<'f>(&'f self) -> Rc<dyn BalanceFamily<Self::Of<'f>> + 'f>;
}

impl<F: Family> Balanced for F {
    type Of<'f>
        = dyn Periodic + 'f
    where
        F: 'f;

    fn balanced<'f>(&'f self) -> Rc<dyn BalanceFamily<dyn Periodic + 'f> + 'f> {
        Rc::new(Plain(self))
    }
}

impl<G, F> Balanced for TruncatedForces<'_, F>
where
    G: Shape + 'static,
    F: Fn(f64) -> Result<Machine<G>, ParameterError>,
{
    type Of<'f>
        = Machine<G>
    where
        Self: 'f;

    fn balanced<'f>(&'f self) -> Rc<dyn BalanceFamily<Machine<G>> + 'f> {
        Rc::new(TruncatedForces(self.0))
    }
}

impl<G, F> BalanceFamily<Machine<G>> for TruncatedForces<'_, F>
where
    G: Shape + 'static,
    F: Fn(f64) -> Result<Machine<G>, ParameterError>,
{
    fn family(&self) -> &dyn Family {
        self.0
    }
    fn at(&self, p: f64) -> Result<Rc<Machine<G>>, ParameterError> {
        self.0.make_at(p).map(Rc::new)
    }
    fn equations<'m>(
        &self,
        balance: &Balance,
        model: &'m Machine<G>,
        near: &FourierOrbit,
    ) -> Result<BalanceEquations<'m, Machine<G>>, BalanceError> {
        balance.truncating_equations(model, near, &balance.budget.begin())
    }
    fn solve(
        &self,
        balance: &Balance,
        model: &Machine<G>,
        guess: &FourierOrbit,
    ) -> Result<FourierOrbit, BalanceError> {
        balance.solve_truncating_forces(model, guess)
    }
    fn is_of_equation(&self) -> bool {
        false
    }
}
