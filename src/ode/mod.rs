//! Integration in time, with located edges.
//!
//! An [`Integrator`] runs a model to a time or to an end of a run. [`Dop853`] takes every model. [`Taylor`]
//! is the fastest for smooth pieces at tight tolerances, and [`Rk45`] is for loose ones. [`Rodas`] is for
//! stiff models. [`Rk4`] has fixed steps.
//! A [`Trajectory`] keeps a motion, an [`Observer`] sees each of its steps, a [`Probe`] names its channels.
//! A [`Budget`] limits steps and time and cancels. The [guide page](crate::guide::integrators) helps to
//! choose.

pub(crate) mod budget;
pub(crate) mod driver;
pub(crate) mod edges;
pub(crate) mod integrate_error;
pub(crate) mod integrator;
pub(crate) mod methods;
pub(crate) mod outcome;
pub(crate) mod probe;
pub(crate) mod rejections;
pub(crate) mod shifted;
pub(crate) mod step;
pub(crate) mod stepping;
pub(crate) mod taylor;
pub(crate) mod trajectory;

pub use crate::ode::budget::{Budget, Exhausted};
pub use crate::ode::integrate_error::IntegrateError;
pub use crate::ode::integrator::Integrator;
pub use crate::ode::methods::adaptive::Adaptive;
pub use crate::ode::methods::dop853::Dop853;
pub use crate::ode::methods::rk4::Rk4;
pub use crate::ode::methods::rk45::Rk45;
pub use crate::ode::methods::rodas::Rodas;
pub use crate::ode::methods::stepped::Stepped;
pub use crate::ode::outcome::{Finish, Stats};
pub use crate::ode::probe::Probe;
pub use crate::ode::step::{Crossing, Observer, Step, StepView};
pub use crate::ode::stepping::one_step::{OneStep, Slope};
pub use crate::ode::taylor::settings::Taylor;
pub use crate::ode::trajectory::{Failed, Trajectory, uniform_times};
