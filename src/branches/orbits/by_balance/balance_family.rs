//! Where the equations of a balance over a parameter come from.

use crate::branches::family::{ByFunction, Family};
use crate::branches::orbits::by_balance::along_constant::AlongConstant;
use crate::error::ParameterError;
use crate::model::equations::Periodic;
use crate::model::machine::Machine;
use crate::model::offers::Offers;
use crate::model::shape::Shape;
use crate::periodic::balance::balance_error::BalanceError;
use crate::periodic::balance::equations::balance_equations::BalanceEquations;
use crate::periodic::balance::fourier_orbit::FourierOrbit;
use crate::periodic::balance::settings::Balance;
use std::rc::Rc;

/// A family of models of type `M`, with the equations of their balance.
pub(crate) trait BalanceFamily<M: Periodic + ?Sized> {
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
        if !Offers::of(&**model).jacobian() {
            return None;
        }
        let slope = AlongConstant::new(model, constant)?;
        let speed = slope.speed();
        Some((Rc::new(slope), speed))
    }
}

/// The balance with truncated forces of the machines that a closure makes.
pub(crate) struct Truncating<'f, F>(pub(crate) &'f ByFunction<F>);

impl<G, F> BalanceFamily<Machine<G>> for Truncating<'_, F>
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
