//! The equations of a balance along a parameter: one model at a time.

use crate::branches::curve::equations::CurveError;
use crate::branches::orbits::by_balance::balance_family::BalanceFamily;
use crate::model::Periodic;
use crate::periodic::balance::equations::rebinding::Unbound;
use crate::periodic::{Balance, BalanceEquations, FourierOrbit};
use std::rc::Rc;

/// The model of one parameter and the arrays of its equations.
pub(crate) struct BalanceRoom<'f, M: Periodic + ?Sized> {
    family: Rc<dyn BalanceFamily<M> + 'f>,
    balance: Balance,
    /// The orbit whose sizes are the scales of all unknowns.
    near: Rc<FourierOrbit>,
    held: Option<Held<M>>,
}

/// The model of a parameter.
pub(crate) struct At<'m, M: ?Sized> {
    pub(crate) model: &'m M,
    /// See [`BalanceFamily::slope`].
    pub(crate) slope: Option<(&'m M, f64)>,
}

struct Held<M: ?Sized> {
    p: f64,
    model: Rc<M>,
    /// See [`BalanceFamily::slope`].
    slope: Option<(Rc<M>, f64)>,
    arrays: Unbound<M>,
}

impl<'f, M: Periodic + ?Sized> BalanceRoom<'f, M> {
    pub(crate) fn new(
        family: Rc<dyn BalanceFamily<M> + 'f>,
        balance: &Balance,
        near: Rc<FourierOrbit>,
    ) -> Self {
        BalanceRoom { family, balance: balance.clone(), near, held: None }
    }

    /// Calls `work` with the equations at the parameter `p`. They are bound to the model of `p`, or set up
    /// anew if they cannot be.
    pub(crate) fn at<R>(
        &mut self,
        p: f64,
        work: impl for<'m> FnOnce(&mut BalanceEquations<'m, M>, At<'m, M>) -> R,
    ) -> Result<R, CurveError> {
        let held = match self.held.take() {
            Some(held) if held.p == p => held,
            other => self.move_to(p, other)?,
        };
        let Held { model, slope, arrays, .. } = held;
        let mut equations = arrays.bind(&*model);
        let at = At { model: &*model, slope: slope.as_ref().map(|(slope, speed)| (&**slope, *speed)) };
        let result = work(&mut equations, at);
        let arrays = equations.unbind();
        self.held = Some(Held { p, model, slope, arrays });
        Ok(result)
    }

    /// Calls `work` with the equations at the parameter of the last call.
    pub(crate) fn here<R>(
        &mut self,
        work: impl FnOnce(&mut BalanceEquations<'_, M>) -> R,
    ) -> Result<R, CurveError> {
        let p = self.held.as_ref().map_or(f64::NAN, |held| held.p);
        self.at(p, |equations, _| work(equations))
    }

    fn move_to(&mut self, p: f64, held: Option<Held<M>>) -> Result<Held<M>, CurveError> {
        let model = match self.family.at(p) {
            Ok(model) => model,
            Err(error) => {
                self.held = held;
                return Err(CurveError::Model { parameter: p, error });
            }
        };
        let constants = self.family.family().constant().is_some();
        let bound = held.and_then(|held| held.arrays.rebind(&model, constants));
        let equations = match bound {
            Some(equations) => equations,
            None => self
                .family
                .equations(&self.balance, &model, &self.near)
                .map_err(|error| CurveError::Balance { parameter: p, error: Box::new(error) })?,
        };
        let arrays = equations.unbind();
        Ok(Held { p, slope: self.family.slope(&model), model, arrays })
    }
}
