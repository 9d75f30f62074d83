//! The method by which a flow and its derivative are integrated.

use crate::model::drive_slope::DriveSlope;
use crate::model::{Model, State};
use crate::ode::taylor::integrate::Prepared;
use crate::ode::{Dop853, Finish, IntegrateError, Integrator, Observer, Taylor};
use crate::periodic::flow::tangent_tape::tangent;
use std::cell::RefCell;
use std::fmt;

/// The method by which [`Variation`](crate::periodic::Variation), [`Shooting`](crate::Shooting) and
/// [`Lyapunov`](crate::Lyapunov) integrate a motion with its derivatives.
///
/// Default: [`Taylor`](FlowMethod::Taylor) for a model that can be expanded, [`Dop853`](FlowMethod::Dop853)
/// for any other. The result says which one was used.
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, periodic::{FlowMethod, Variation}};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let start = pair.on_drive_flank()?;
/// let taylor = Variation::new().run(&pair, &start, 10.0)?;
/// let dop853 = Variation::new().flow_method(FlowMethod::Dop853).run(&pair, &start, 10.0)?;
/// assert_eq!((taylor.method, dop853.method), (FlowMethod::Taylor, FlowMethod::Dop853));
/// assert!((taylor.matrix - dop853.matrix).amax() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum FlowMethod {
    /// Taylor series, as [`Taylor`](crate::Taylor).
    Taylor,
    /// The Runge-Kutta method of [`Dop853`](crate::Dop853).
    Dop853,
}

impl fmt::Display for FlowMethod {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            FlowMethod::Taylor => "Taylor series",
            FlowMethod::Dop853 => "DOP853",
        })
    }
}

/// Tolerances and steps of a run.
pub(crate) struct Accuracy<'a> {
    /// Relative tolerance `[1]`.
    pub(crate) rtol: f64,
    /// Absolute tolerance of all components, or of each.
    pub(crate) atol: &'a [f64],
    /// Order of a Taylor series.
    pub(crate) order: usize,
    /// First step of DOP853; 0 if it is free.
    pub(crate) first: f64,
}

/// The tape of a model, with or without its derivatives, if it is integrated by Taylor series; `None`:
/// DOP853.
pub(crate) struct Expansion(Option<RefCell<Prepared>>);

impl Expansion {
    /// The expansion for a number of differences, the last ones with respect to the parameters `forced`.
    /// `wanted`: the method, if it is not chosen by the model.
    ///
    /// # Errors
    /// [`IntegrateError::NoSeries`] and [`IntegrateError::DriveWithoutSeries`] if `wanted` is Taylor.
    pub(crate) fn new(
        model: &dyn Model,
        columns: usize,
        forced: &[DriveSlope],
        wanted: Option<FlowMethod>,
    ) -> Result<Self, IntegrateError> {
        if wanted == Some(FlowMethod::Dop853) {
            return Ok(Expansion(None));
        }
        let moving = |drive: usize| forced.iter().any(|by| by.drives[drive] != 0.0);
        match (Prepared::with(model, &moving, |tape| tangent(&tape, columns, forced)), wanted) {
            (Ok(prepared), _) => Ok(Expansion(Some(RefCell::new(prepared)))),
            (Err(error), Some(_)) => Err(error),
            (Err(_), None) => Ok(Expansion(None)),
        }
    }

    /// The expansion of a model without its derivatives: by DOP853 if that is `wanted` or if there is no
    /// series.
    pub(crate) fn of_motion(model: &dyn Model, wanted: Option<FlowMethod>) -> Self {
        let series = || Prepared::new(model).ok().map(RefCell::new);
        Expansion(if wanted == Some(FlowMethod::Dop853) { None } else { series() })
    }

    /// No expansion: for flows that are integrated elsewhere.
    pub(crate) fn none() -> Self {
        Expansion(None)
    }

    /// Integrates the model of this expansion.
    pub(crate) fn run<M: Model + ?Sized, O: Observer>(
        &self,
        accuracy: &Accuracy<'_>,
        model: &M,
        start: &State,
        t_end: f64,
        observer: &mut O,
    ) -> Result<Finish, IntegrateError> {
        let &Accuracy { rtol, atol, order, first } = accuracy;
        match &self.0 {
            Some(prepared) => {
                let settings = Taylor::new().rtol(rtol).atol_each(atol).order(order);
                prepared.borrow_mut().run(&settings, &model, start, t_end, observer)
            }
            None => {
                let solver = Dop853::new().rtol(rtol).atol_each(atol);
                let solver = if first > 0.0 { solver.first_step(first) } else { solver };
                solver.run(model, start, t_end, observer)
            }
        }
    }

    pub(crate) fn method(&self) -> FlowMethod {
        if self.0.is_some() { FlowMethod::Taylor } else { FlowMethod::Dop853 }
    }
}
