//! Nonlinear gear dynamics: backlash, mesh stiffness and rattle, integrated with located tooth edges.
//!
//! A gear model is drives, algebra and contacts ([`Model`]); solvers ([`Integrator`]: [`Rk4`], [`Rk45`], [`Dop853`]) advance any model,
//! locate the edges of its backlash and never straddle a jump of its drives; observers ([`Statistics`], [`Rattle`], [`Section`](analysis::Section),
//! closures) see every step; [`Settle`] runs a periodic model until it repeats.
//!
//! The noncircular face gear pair at 180 rad/s rattles on both flanks, 252 edges crossed in a turn:
//!
//! ```
//! use gear_dynamics::{Dop853, Integrator, NfgPair, NfgParams, Periodic, Rattle, RattleState, Settle};
//!
//! let pair = NfgPair::new(&NfgParams { speed: 180.0, ..NfgParams::table1() })?;
//! let solver = Dop853::new().rtol(1e-9).atol(1e-14);
//! let steady = Settle::new().tolerance(1e-7).run(&solver, &pair, &pair.static_start()?)?;
//!
//! let mut rattle = Rattle::new(&pair);
//! let turn = solver.run(&pair, &steady.state, steady.state.t + pair.period(), &mut rattle)?;
//! assert_eq!(rattle.contact(0).rattle_state(), RattleState::Bilateral);
//! assert_eq!(turn.stats.crossings, 252);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | what | where |
//! |---|---|
//! | a model of one's own | [`Shape`], [`Machine`], or two methods of [`Model`]; [`check_model`](check::check_model) says what is inconsistent |
//! | gear models | [`NfgPair`], [`NfgPair2`](models::nfg::NfgPair2), [`Ring`] |
//! | functions of an angle | [`Wave`], [`Excitation`](excitation::Excitation): [`Fourier`](excitation::Fourier), [`RectangularWave`](excitation::RectangularWave), [`InstantCentre`](excitation::InstantCentre), [`Table`](excitation::Table), [`Function`](excitation::Function), ... |
//! | contact laws | [`Nonlinearity`](contact::Nonlinearity): [`Backlash`], [`AsymmetricBacklash`](contact::AsymmetricBacklash), [`VaryingBacklash`](contact::VaryingBacklash), [`PowerLaw`](contact::PowerLaw), [`NoPullBacklash`](contact::NoPullBacklash), [`Damped`](contact::Damped), ...; rigid stops: [`Restitution`](contact::Restitution); [table](guide::contact_laws) |
//! | random drives, functions of time | [`HeldProcess`](drives::HeldProcess), [`Held`](drives::Held); [`Driven`](drives::Driven) |
//! | periodic orbits | [`Balance`], [`Harmonics`], [`FourierOrbit`](periodic::FourierOrbit), [`Proof`](periodic::Proof); [`Shooting`], [`ShootingOrbit`](periodic::ShootingOrbit), [`Multipliers`](periodic::Multipliers), [`Stability`](periodic::Stability); [`Lyapunov`] |
//! | equations of one's own | [`Newton`](roots::Newton), [`Broyden`](roots::Broyden), [`Residual`](roots::Residual) |
//! | what to read off | [`Statistics`], [`Spectrum`](analysis::Spectrum), [`Rattle`], [`strobe`](analysis::strobe), [`Section`](analysis::Section), [`Settle`], named channels by [`Probe`](analysis::Probe) |
//! | many runs | [`Sweep`] with [`LaneRk4`](sweep::LaneRk4), [`TableRk4`](sweep::TableRk4), [`Located`](sweep::Located); [`Bifurcation`](sweep::Bifurcation), [`Attractors`](sweep::Attractors), [`Ensemble`](sweep::Ensemble), [`RandomParameters`](sweep::RandomParameters) |
//! | limits on work | [`Budget`]: steps, time, a flag |
//! | changing speed | [`PhaseLaw`](drives::PhaseLaw), [`VaryingSpeed`](drives::VaryingSpeed), [`Waterfall`](analysis::Waterfall) |
//! | background | [`guide`] |

pub mod analysis;
pub mod check;
pub mod contact;
pub mod drives;
mod dual;
mod error;
pub mod excitation;
pub mod model;
pub mod models;
pub mod ode;
pub mod periodic;
pub mod roots;
mod scalar;
pub mod sweep;

pub use crate::analysis::rattle::{Rattle, RattleState};
pub use crate::analysis::settle::Settle;
pub use crate::analysis::statistics::Statistics;
pub use crate::contact::laws::backlash::Backlash;
pub use crate::contact::mesh::Mesh;
pub use crate::error::ParameterError;
pub use crate::excitation::wave::Wave;
pub use crate::model::equations::{Model, Periodic, State};
pub use crate::model::machine::Machine;
pub use crate::model::shape::Shape;
pub use crate::models::nfg::pair::NfgPair;
pub use crate::models::nfg::params::NfgParams;
pub use crate::models::ring::shape::Ring;
pub use crate::ode::budget::Budget;
pub use crate::ode::integrator::Integrator;
pub use crate::ode::methods::dop853::Dop853;
pub use crate::ode::methods::rk4::Rk4;
pub use crate::ode::methods::rk45::Rk45;
pub use crate::periodic::balance::series::harmonics::Harmonics;
pub use crate::periodic::balance::settings::Balance;
pub use crate::periodic::lyapunov::run::Lyapunov;
pub use crate::periodic::shooting::multiple::Shooting;
pub use crate::sweep::settings::sweep::Sweep;

/// Guide pages: theory, a model of one's own, events, contact laws, periodic orbits, the two models, sweeps, errata of their papers, references.
pub mod guide {
    #[doc = include_str!("../docs/theory.md")]
    pub mod theory {}
    #[doc = include_str!("../docs/own-model.md")]
    pub mod own_model {}
    #[doc = include_str!("../docs/events.md")]
    pub mod events {}
    #[doc = include_str!("../docs/contact-laws.md")]
    pub mod contact_laws {}
    #[doc = include_str!("../docs/balance.md")]
    pub mod balance {}
    #[doc = include_str!("../docs/models.md")]
    pub mod models {}
    #[doc = include_str!("../docs/sweeps.md")]
    pub mod sweeps {}
    #[doc = include_str!("../docs/errata.md")]
    pub mod errata {}
    #[doc = include_str!("../docs/references.md")]
    pub mod references {}
    /// The README, so that its code is tested.
    #[doc = include_str!("../README.md")]
    #[cfg(doctest)]
    pub mod readme {}
}
