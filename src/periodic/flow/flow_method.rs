//! The method by which a flow and its derivative are integrated.

use crate::model::drive_slope::DriveSlope;
use crate::model::{Model, State};
use crate::ode::taylor::integrate::Prepared;
use crate::ode::{Dop853, Finish, IntegrateError, Integrator, Observer, Step, Taylor};
use crate::periodic::flow::tangent_tape::tangent;
use std::cell::RefCell;
use std::fmt;
use std::sync::Arc;

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
    /// An [`Integrator`] of one's own: what a result says. As a setting it is the default.
    Own,
}

impl fmt::Display for FlowMethod {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            FlowMethod::Taylor => "Taylor series",
            FlowMethod::Dop853 => "DOP853",
            FlowMethod::Own => "an integrator of one's own",
        })
    }
}

/// The method that the settings of a flow ask for.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(from = "Option<FlowMethod>"))]
pub(crate) enum Chosen {
    /// The default for the model.
    #[default]
    ByModel,
    Method(FlowMethod),
    Own(OwnIntegrator),
}

impl From<Option<FlowMethod>> for Chosen {
    fn from(method: Option<FlowMethod>) -> Self {
        method.map_or(Chosen::ByModel, Chosen::Method)
    }
}

#[cfg(feature = "serde")]
impl serde::Serialize for Chosen {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Chosen::ByModel => serializer.serialize_none(),
            Chosen::Method(method) => serializer.serialize_some(method),
            Chosen::Own(_) => Err(serde::ser::Error::custom("an integrator of one's own cannot be stored")),
        }
    }
}

impl Chosen {
    /// The choice with another method. [`FlowMethod::Own`] keeps the integrator of one's own.
    pub(crate) fn with(self, method: FlowMethod) -> Self {
        match self {
            Chosen::Own(own) if method == FlowMethod::Own => Chosen::Own(own),
            _ => Chosen::Method(method),
        }
    }
    /// Whether the flow may be integrated by Taylor series.
    pub(crate) fn allows_series(&self) -> bool {
        !matches!(self, Chosen::Method(FlowMethod::Dop853) | Chosen::Own(_))
    }
}

/// The run of an [`Integrator`].
type Run = dyn Fn(&dyn Model, &State, f64, &mut dyn Observer) -> Result<Finish, IntegrateError> + Send + Sync;

/// An [`Integrator`] whose type is not known.
#[derive(Clone)]
pub(crate) struct OwnIntegrator(Arc<Run>);

impl OwnIntegrator {
    pub(crate) fn new(integrator: impl Integrator + Send + Sync + 'static) -> Self {
        OwnIntegrator(Arc::new(
            move |model: &dyn Model, start: &State, t_end: f64, observer: &mut dyn Observer| {
                let run = integrator.run(model, start, t_end, &mut |step: &mut Step<'_>| observer.step(step));
                run?.checked(model.dof(), t_end)
            },
        ))
    }
}

impl fmt::Debug for OwnIntegrator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an integrator of one's own")
    }
}

/// The same integrator, not an equal one.
impl PartialEq for OwnIntegrator {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
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

/// How the flow of a model is integrated.
pub(crate) enum Expansion {
    /// By Taylor series: the tape of the model, with or without its derivatives.
    Series(Box<RefCell<Prepared>>),
    Dop853,
    /// By an integrator with tolerances of its own.
    Own(OwnIntegrator),
}

impl Expansion {
    /// The expansion for a number of differences, the last ones with respect to the parameters `forced`.
    ///
    /// # Errors
    /// [`IntegrateError::NoSeries`] and [`IntegrateError::DriveWithoutSeries`] if Taylor is chosen.
    pub(crate) fn new(
        model: &dyn Model,
        columns: usize,
        forced: &[DriveSlope],
        chosen: &Chosen,
    ) -> Result<Self, IntegrateError> {
        match chosen {
            Chosen::Method(FlowMethod::Dop853) => return Ok(Expansion::Dop853),
            Chosen::Own(own) => return Ok(Expansion::Own(own.clone())),
            _ => {}
        }
        let moving = |drive: usize| forced.iter().any(|by| by.drives[drive] != 0.0);
        match Prepared::with(model, &moving, |tape| tangent(&tape, columns, forced)) {
            Ok(prepared) => Ok(Expansion::Series(Box::new(RefCell::new(prepared)))),
            Err(error) if *chosen == Chosen::Method(FlowMethod::Taylor) => Err(error),
            Err(_) => Ok(Expansion::Dop853),
        }
    }

    /// The expansion of a model without its derivatives: by what is chosen, by DOP853 if there is no series.
    pub(crate) fn of_motion(model: &dyn Model, chosen: &Chosen) -> Self {
        match chosen {
            Chosen::Method(FlowMethod::Dop853) => return Expansion::Dop853,
            Chosen::Own(own) => return Expansion::Own(own.clone()),
            _ => {}
        }
        Prepared::new(model)
            .map_or(Expansion::Dop853, |series| Expansion::Series(Box::new(RefCell::new(series))))
    }

    /// No expansion: for flows that are integrated elsewhere.
    pub(crate) fn none() -> Self {
        Expansion::Dop853
    }

    /// Integrates the model of this expansion.
    pub(crate) fn run(
        &self,
        accuracy: &Accuracy<'_>,
        model: &dyn Model,
        start: &State,
        t_end: f64,
        observer: &mut dyn Observer,
    ) -> Result<Finish, IntegrateError> {
        let &Accuracy { rtol, atol, order, first } = accuracy;
        match self {
            Expansion::Series(prepared) => {
                let settings = Taylor::new().rtol(rtol).atol_each(atol).order(order);
                prepared.borrow_mut().run(&settings, model, start, t_end, observer)
            }
            Expansion::Own(own) => {
                (own.0)(model, start, t_end, &mut |step: &mut Step<'_>| observer.step(step))
            }
            Expansion::Dop853 => {
                let solver = Dop853::new().rtol(rtol).atol_each(atol);
                let solver = if first > 0.0 { solver.first_step(first) } else { solver };
                solver.run(model, start, t_end, observer)
            }
        }
    }

    pub(crate) fn method(&self) -> FlowMethod {
        match self {
            Expansion::Series(_) => FlowMethod::Taylor,
            Expansion::Dop853 => FlowMethod::Dop853,
            Expansion::Own(_) => FlowMethod::Own,
        }
    }
}
