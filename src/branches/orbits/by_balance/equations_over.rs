//! The equations of a balance along a parameter: one model at a time.

use crate::branches::curve::equations::CurveError;
use crate::branches::family::Family;
use crate::branches::orbits::by_balance::along_constant::AlongConstant;
use crate::model::Periodic;
use crate::periodic::balance::equations::rebinding::Unbound;
use crate::periodic::{Balance, BalanceEquations, FourierOrbit};
use std::rc::Rc;

/// Any model of a family.
pub(crate) type Any<'f> = dyn Periodic + 'f;

/// The model of one parameter and the arrays of its equations.
pub(crate) struct EquationsOver<'f> {
    family: &'f Family<'f>,
    balance: Balance,
    /// The orbit whose sizes are the scales of all unknowns.
    near: Rc<FourierOrbit>,
    current: Option<Current<'f>>,
}

/// The model of a parameter.
pub(crate) struct At<'m, 'f> {
    pub(crate) model: &'m Any<'f>,
    /// The derivative of the model with respect to the parameter, as a model, and the relative change of the
    /// speed of the phase. `None` if it is not known exactly.
    pub(crate) slope: Option<(&'m Any<'f>, f64)>,
}

struct Current<'f> {
    p: f64,
    model: Rc<Any<'f>>,
    /// See [`At::slope`].
    slope: Option<(Rc<Any<'f>>, f64)>,
    arrays: Unbound,
}

impl<'f> EquationsOver<'f> {
    pub(crate) fn new(family: &'f Family<'f>, balance: &Balance, near: Rc<FourierOrbit>) -> Self {
        EquationsOver { family, balance: balance.clone(), near, current: None }
    }

    /// Calls `work` with the equations at the parameter `p`. They are bound to the model of `p`, or set up
    /// anew if they cannot be.
    pub(crate) fn at<R>(
        &mut self,
        p: f64,
        work: impl for<'m> FnOnce(&mut BalanceEquations<'m>, At<'m, 'f>) -> R,
    ) -> Result<R, CurveError> {
        let current = match self.current.take() {
            Some(current) if current.p == p => current,
            other => self.move_to(p, other)?,
        };
        let Current { model, slope, arrays, .. } = current;
        let mut equations = arrays.bind(&*model);
        let at = At { model: &*model, slope: slope.as_ref().map(|(slope, speed)| (&**slope, *speed)) };
        let result = work(&mut equations, at);
        let arrays = equations.unbind();
        self.current = Some(Current { p, model, slope, arrays });
        Ok(result)
    }

    /// Calls `work` with the equations at the parameter of the last call.
    pub(crate) fn here<R>(
        &mut self,
        work: impl FnOnce(&mut BalanceEquations<'_>) -> R,
    ) -> Result<R, CurveError> {
        let p = self.current.as_ref().map_or(f64::NAN, |current| current.p);
        self.at(p, |equations, _| work(equations))
    }

    fn move_to(&mut self, p: f64, current: Option<Current<'f>>) -> Result<Current<'f>, CurveError> {
        let model: Rc<Any<'f>> = match self.family.at([p]) {
            Ok(model) => model.into(),
            Err(error) => {
                self.current = current;
                return Err(CurveError::Model { parameter: p, error });
            }
        };
        let constants = self.family.constants.is_some();
        let bound = current.and_then(|current| current.arrays.rebind(&*model, constants));
        let equations = match bound {
            Some(equations) => equations,
            None => self
                .balance
                .equations(&*model, &self.near)
                .map_err(|error| CurveError::Balance { parameter: p, error: Box::new(error) })?,
        };
        let arrays = equations.unbind();
        Ok(Current { p, slope: self.slope(&model), model, arrays })
    }

    fn slope(&self, model: &Rc<Any<'f>>) -> Option<(Rc<Any<'f>>, f64)> {
        let [constant] = self.family.constants?;
        if self.balance.truncated_forces || !model.offers().jacobian {
            return None;
        }
        let slope = AlongConstant::new(model, constant)?;
        let speed = slope.speed();
        Some((Rc::new(slope), speed))
    }
}
