//! Periodic orbits and their stability.
//!
//! [`Shooting`] finds an orbit of any model in the time domain, [`Balance`] as a Fourier series
//! ([`FourierOrbit`]), with an [`ErrorEstimate`]. [`Multipliers`] tell whether an orbit is stable.
//! [`Lyapunov`] gives the exponents of any motion and tells chaos from order. [`Variation`] integrates the
//! derivative of the flow. How orbits change with a parameter: [`branches`](crate::branches). The
//! [guide page](crate::guide::balance) compares balance and shooting.

pub(crate) mod balance;
pub(crate) mod error_estimate;
pub(crate) mod flow;
pub(crate) mod lyapunov;
pub(crate) mod metered;
pub(crate) mod multipliers;
pub(crate) mod pursuit;
pub(crate) mod shooting;

pub use crate::periodic::balance::balance_error::BalanceError;
pub use crate::periodic::balance::crossings::contact_history::{ContactHistory, ContactInterval};
pub use crate::periodic::balance::equations::balance_equations::BalanceEquations;
pub use crate::periodic::balance::fourier_orbit::FourierOrbit;
pub use crate::periodic::balance::integrals::Integrals;
pub use crate::periodic::balance::note::BalanceNote;
pub use crate::periodic::balance::series::harmonics::Harmonics;
pub use crate::periodic::balance::settings::Balance;
pub use crate::periodic::error_estimate::ErrorEstimate;
pub use crate::periodic::flow::flow_method::FlowMethod;
pub use crate::periodic::flow::variation::{Transition, Variation};
pub use crate::periodic::lyapunov::exponents::{Exponents, LyapunovError};
pub use crate::periodic::lyapunov::run::Lyapunov;
pub use crate::periodic::multipliers::{MultiplierError, Multipliers, Stability};
pub use crate::periodic::shooting::failure::{Iterate, ShootingError};
pub use crate::periodic::shooting::multiple::Shooting;
pub use crate::periodic::shooting::neighbour::Neighbour;
pub use crate::periodic::shooting::recorded::RecordedOrbit;
pub use crate::periodic::shooting::shooting_orbit::ShootingOrbit;
