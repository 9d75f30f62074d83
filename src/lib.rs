//! Nonlinear gear dynamics: backlash, mesh stiffness and rattle, integrated with located tooth edges.
//!
//! A gear model is drives, algebra and contacts ([`Model`]); solvers ([`Integrator`]: [`Rk4`], [`Rk45`], [`Dop853`]) advance any model,
//! locate the edges of its backlash and never straddle a jump of its drives; observers ([`Statistics`], [`Rattle`], [`Section`],
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
//! assert_eq!(rattle.contact(0).state(), RattleState::Bilateral);
//! assert_eq!(turn.stats.crossings, 252);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | what | where |
//! |---|---|
//! | a model of one's own | [`Shape`], [`Machine`], or two methods of [`Model`]; [`check_model`] says what is inconsistent |
//! | gear models | [`NfgPair`], [`NfgPair2`], [`Ring`] |
//! | functions of an angle | [`Wave`], [`Excitation`]: [`Fourier`], [`RectangularWave`], [`InstantCentre`], [`Table`], [`Function`], ... |
//! | contact laws | [`Nonlinearity`]: [`Backlash`], [`AsymmetricBacklash`], [`VaryingBacklash`], [`PowerLaw`], [`NoPullBacklash`], [`Damped`], ...; rigid stops: [`Restitution`]; [table](guide::contact_laws) |
//! | random drives, functions of time | [`HeldProcess`], [`Held`]; [`Driven`] |
//! | periodic orbits | [`Balance`], [`Harmonics`], [`FourierOrbit`], [`Proof`]; [`Shooting`], [`ShootingOrbit`], [`Multipliers`], [`Stability`]; [`Lyapunov`] |
//! | equations of one's own | [`Newton`], [`Broyden`], [`Residual`] |
//! | what to read off | [`Statistics`], [`Spectrum`], [`Rattle`], [`strobe`], [`Section`], [`Settle`], named channels by [`Probe`] |
//! | many runs | [`Sweep`] with [`LaneRk4`], [`TableRk4`], [`Located`]; [`Bifurcation`], [`Attractors`], [`Ensemble`], [`RandomParameters`] |
//! | limits on work | [`Budget`]: steps, time, a flag |
//! | changing speed | [`PhaseLaw`], [`VaryingSpeed`], [`Waterfall`] |
//! | background | [`guide`] |

mod analysis;
mod balance;
mod budget;
mod channel;
mod check;
mod driven;
mod dual;
mod error;
mod excitation;
mod held;
mod impact;
mod jacobian;
mod lanes;
mod machine;
mod mesh;
mod model;
mod models;
mod nonlinearity;
mod ode;
mod orbit;
mod phase;
mod piece;
mod root;
mod scalar;
mod shape;
mod slopes;
mod sweep;
mod wrapped;

pub use analysis::{
    ContactStatistics, Direction, Rattle, RattleState, Section, Settle, Spectrum, Statistics, Steady,
    Summary, Unsettled, Waterfall, WaterfallError, WaterfallLine, Window, strobe,
};
pub use balance::{
    Balance, BalanceEquations, BalanceError, BalanceNote, ContactHistory, FourierOrbit, Harmonics, Integrals,
    Proof,
};
pub use budget::{Budget, Exhausted};
pub use channel::Probe;
pub use check::{Inconsistency, check_model, check_periodic};
pub use driven::{Driven, TimeDrives};
pub use dual::Dual;
pub use error::ParameterError;
pub use excitation::{
    CentreCurve, Constant, Excitation, Fourier, Function, InstantCentre, Jet, Product, RectangularWave,
    Scaled, Sum, Table, Wave, earliest, same,
};
pub use held::{CounterRng, Held, HeldDrives, HeldProcess};
pub use impact::Restitution;
pub use lanes::{InstructionSet, Lanes, TableError};
pub use machine::Machine;
pub use mesh::{ContactDamping, Mesh};
pub use model::{Channel, Contact, Jacobian, Model, Periodic, State};
pub use models::{
    CentreForcing, Damping, ErrorForcing, Frame, Gear, HalfWidth, Load, Modes, Motor, NfgPair, NfgPair2,
    NfgParams, NfgReading, NfgShape, NfgShape2, Radius, RelativeView, Ring, RingParams, RingSet, RingShape,
    Shaft,
};
pub use nonlinearity::{
    AsymmetricBacklash, Backlash, Cubic, Damped, Edges, Linear, MixedLaw, NoPullBacklash, Nonlinearity,
    PowerLaw, SmoothedBacklash, VaryingBacklash,
};
pub use ode::{
    Adaptive, Crossing, Dop853, DormandPrince5, DormandPrince8, Failed, Finish, IntegrateError, Integrator,
    Observer, Rk4, Rk45, Stats, Step, StepView, Trajectory, uniform_times,
};
pub use orbit::{
    Exponents, Iterate, Lyapunov, LyapunovError, Multipliers, Shooting, ShootingError, ShootingOrbit,
    Stability, Transition, Variation,
};
pub use phase::{PhaseLaw, VaryingSpeed};
pub use piece::{Piece, Side};
pub use root::{Broyden, Equations, FirstJacobian, Matrix, Newton, Residual, Root, RootError};
pub use scalar::{Scalar, keep_rolled};
pub use shape::{ByDeflection, Drives, FixedPieces, PieceChoice, Shape, Size};
pub use sweep::{
    Attractor, Attractors, Axis, Bands, Bifurcation, Diagram, DiagramPoint, Distribution, Ensemble,
    EnsembleError, LaneRk4, Located, Monitor, Point, PointError, Points, RandomParameters, Row, Rows,
    RowsError, SobolDesign, SobolIndex, Sweep, SweepEngine, SweepError, TableRk4, WarmStart,
};
pub use wrapped::{DriveRule, Wrapped};

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
