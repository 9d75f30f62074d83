//! Nonlinear dynamics of gears with backlash, varying mesh stiffness and transmission error.
//!
//! A [`Model`] consists of drives, accelerations and contacts. A solver ([`Rk4`], [`Rk45`], [`Dop853`],
//! [`Taylor`]) advances it in time and locates the instants at which teeth touch or separate; [`Balance`]
//! and [`Shooting`] find periodic orbits; [`Sweep`] makes many runs. The [`guide`] starts with an example and
//! a list by purpose.
//!
#![doc = include_str!("../docs/links.md")]
#![doc = include_str!("../docs/planetary.md")]
#![warn(missing_debug_implementations)]

pub mod analysis;
pub mod branches;
pub mod certify;
pub mod check;
pub mod contact;
pub mod drives;
mod dual;
mod error;
pub mod excitation;
pub mod export;
mod interval;
pub mod linear;
pub mod model;
pub mod models;
mod numeric;
pub mod ode;
pub mod periodic;
pub mod processes;
pub mod random;
pub mod roots;
mod rounded;
mod scalar;
mod series;
mod steepness;
#[cfg(feature = "serde")]
mod stored;
pub mod sweep;
mod tape;
pub mod teeth;
pub mod tori;
pub mod trains;

pub use crate::analysis::contacts::rattle::{Rattle, RattleState};
pub use crate::analysis::settle::Settle;
pub use crate::analysis::statistics::Statistics;
pub use crate::contact::laws::backlash::Backlash;
pub use crate::contact::mesh::Mesh;
pub use crate::error::ParameterError;
pub use crate::excitation::wave::Wave;
pub use crate::model::equations::{Model, Periodic};
pub use crate::model::shapes::machine::Machine;
pub use crate::model::shapes::shape::Shape;
pub use crate::model::state::State;
pub use crate::models::nfg::nfg_params::NfgParams;
pub use crate::models::nfg::pair::NfgPair;
pub use crate::models::ring::ring_shape::Ring;
pub use crate::ode::budget::Budget;
pub use crate::ode::integrator::Integrator;
pub use crate::ode::methods::dop853::Dop853;
pub use crate::ode::methods::rk4::Rk4;
pub use crate::ode::methods::rk45::Rk45;
pub use crate::ode::taylor::settings::Taylor;
pub use crate::periodic::balance::series::harmonics::Harmonics;
pub use crate::periodic::balance::settings::Balance;
pub use crate::periodic::lyapunov::run::Lyapunov;
pub use crate::periodic::shooting::multiple::Shooting;
pub use crate::sweep::settings::sweep::Sweep;
// They stand in public signatures: matrices of rings and orbits, multipliers, spectra, distributions.
pub use {nalgebra, num_complex, rand_distr};

/// Guide: an example, what serves which purpose, and pages on theory, models and methods.
///
/// - A [`Model`] consists of drives (functions of time), algebra (accelerations) and contacts.
/// - A solver (an [`Integrator`]: [`Rk4`], [`Rk45`], [`Dop853`], [`Taylor`], ..) advances a model in time;
///   see [which solver](guide::integrators). It locates the instants at which teeth touch or separate. No
///   step extends over such an instant or over a jump of the drives.
/// - An observer receives every step: [`Statistics`], [`Rattle`], [`Section`](analysis::Section) or a
///   closure.
/// - [`Settle`] integrates a periodic model until its state repeats.
///
/// Example: the noncircular face gear pair of Liu 2021 at 180 rad/s. It rattles on both flanks and crosses
/// edges of the gap 252 times in one turn.
///
/// ```
/// use gear_dynamics::{Dop853, Integrator, NfgPair, NfgParams, Periodic, Rattle, RattleState, Settle};
///
/// let pair = NfgPair::new(&NfgParams { speed: 180.0, ..NfgParams::table1() })?;
/// let solver = Dop853::new().rtol(1e-9).atol(1e-14);
/// let steady = Settle::new().tolerance(1e-7).run(&solver, &pair, None)?;
///
/// let mut rattle = Rattle::new(&pair);
/// let turn = solver.run(&pair, &steady.state, steady.state.t + pair.period(), &mut rattle)?;
/// assert_eq!(rattle.contacts()[0].rattle_state(), RattleState::Bilateral);
/// assert_eq!(turn.stats.crossings, 252);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Contents
///
/// - **A course** ([chapter 1](guide::course::ch01)): ten chapters from two gears on a bench to a rattle
///   map and a train of one's own. Pages [from Python and MATLAB](guide::from_python_and_matlab) and on a
///   [robot joint](guide::robot_joint).
/// - **Your own model**: [`Shape`] and [`Machine`], one formula by [`from_fn`](model::from_fn), or two
///   methods of [`Model`]. [`check_model`](check::check_model) finds inconsistencies in it.
/// - **Gear trains from parts** ([page](guide::trains)): [`Parts`](trains::Parts) of bodies, shafts,
///   bearings, meshes and torques make a [`Train`](trains::Train); ready are [`SpurPair`](trains::SpurPair),
///   [`Planetary`](trains::Planetary) and others.
/// - **Linear analysis** of any model: [`Modes`](linear::Modes), [`Campbell`](linear::Campbell),
///   [`static_state`](linear::static_state).
/// - **Gear models**: [`NfgPair`] and [`NfgPair2`](models::nfg::NfgPair2) (Liu 2021), [`Ring`] (Yao 2020).
/// - **Functions of an angle**: [`Wave`] and [`Excitation`](excitation::Excitation), with
///   [`Fourier`](excitation::Fourier), [`RectangularWave`](excitation::RectangularWave),
///   [`InstantCentre`](excitation::InstantCentre), [`Table`](excitation::Table),
///   [`Function`](excitation::Function) and others.
/// - **Teeth** ([which method](guide::teeth)): [`GearPair`](teeth::GearPair) computes the geometry of
///   involute gears, [`MethodB`](teeth::MethodB) (ISO 6336) and [`PotentialEnergy`](teeth::PotentialEnergy)
///   the mesh stiffness, [`TransmissionError`](teeth::TransmissionError) the error of a quality grade,
///   [`ToothLoss`](teeth::ToothLoss) and [`TipRelief`](teeth::TipRelief) faults and reliefs.
/// - **Contact laws** ([table](guide::contact_laws)): [`Nonlinearity`](contact::Nonlinearity), with
///   [`Backlash`], [`AsymmetricBacklash`](contact::AsymmetricBacklash),
///   [`VaryingBacklash`](contact::VaryingBacklash), [`PowerLaw`](contact::PowerLaw),
///   [`NoPullBacklash`](contact::NoPullBacklash), [`Damped`](contact::Damped) and others. Rigid stops:
///   [`Restitution`](contact::Restitution).
/// - **Random drives** ([page](guide::random)): [`Noisy`](drives::Noisy) adds a
///   [`Process`](processes::Process), such as [`HeldProcess`](processes::HeldProcess),
///   [`OrnsteinUhlenbeck`](processes::OrnsteinUhlenbeck) or [`FilteredNoise`](processes::FilteredNoise).
/// - **Functions of time**: [`Driven`](drives::Driven).
/// - **Varying speed**: [`SpeedLaw`](drives::SpeedLaw), [`VaryingSpeed`](drives::VaryingSpeed),
///   [`Waterfall`](analysis::Waterfall).
/// - **Periodic orbits by harmonic balance**: [`Balance`], [`Harmonics`],
///   [`FourierOrbit`](periodic::FourierOrbit), [`ErrorEstimate`](periodic::ErrorEstimate).
/// - **Periodic orbits by multiple shooting, and stability**: [`Shooting`],
///   [`ShootingOrbit`](periodic::ShootingOrbit), [`Multipliers`](periodic::Multipliers),
///   [`Stability`](periodic::Stability), [`Lyapunov`].
/// - **Certificates** ([page](guide::certificates)): [`certify`](periodic::ShootingOrbit::certify) proves
///   that an orbit exists; [`Certificate`](certify::Certificate) bounds its figures.
/// - **Branches of periodic orbits** ([page](guide::branches)): [`Continuation`](branches::Continuation) over
///   a parameter with located bifurcations, boundaries over two parameters,
///   [`Sensitivity`](branches::Sensitivity) to all constants, [`Fit`](branches::Fit),
///   [`Least`](branches::Least).
/// - **Quasi-periodic motions** ([page](guide::tori)): [`TorusBalance`](tori::TorusBalance) for several base
///   frequencies, [`CircleShooting`](tori::CircleShooting) for invariant circles with contact loss or of
///   unknown rotation, [`WithShafts`](tori::WithShafts) for waves of further shafts.
/// - **Densities under white noise** ([page](guide::random_density)):
///   [`PathIntegration`](random::PathIntegration), for one degree of freedom.
/// - **Your own equations**: [`Residual`](roots::Residual), solved by [`Newton`](roots::Newton) or
///   [`Broyden`](roots::Broyden).
/// - **Results of a run** ([page](guide::results)): [`Statistics`], [`Rattle`],
///   [`Impacts`](analysis::Impacts), [`Spectrum`](analysis::Spectrum), [`Welch`](analysis::Welch),
///   [`Section`](analysis::Section), [`Settle`], and named channels by
///   [`Probe`](ode::Probe).
/// - **Tables of results as CSV and NPY**: [`ResultTable`](export::ResultTable), [`Csv`](export::Csv).
/// - **Sweeps**: [`Sweep`] with the engines [`LaneRk4`](sweep::LaneRk4), [`TableRk4`](sweep::TableRk4),
///   [`LaneTaylor`](sweep::LaneTaylor) and [`Located`](sweep::Located);
///   [`Bifurcation`](sweep::Bifurcation), [`Attractors`](sweep::Attractors), [`Ensemble`](sweep::Ensemble),
///   [`RandomParameters`](sweep::RandomParameters).
/// - **Random loads** ([white noise](guide::random_white)): [`LongRun`](random::LongRun) under
///   [`WhiteNoise`](random::WhiteNoise), [`FirstPassage`](random::FirstPassage),
///   [`Splitting`](random::Splitting) for rare events, [`LinearMoments`](random::LinearMoments) without
///   sampling.
/// - **Limits on work**: [`Budget`], for steps, wall time and cancellation.
/// - **Background**: [`guide`].
pub mod guide {
    /// A course of ten chapters with one pair of gears: from drawing data to a rattle map, and to a train of
    /// one's own. It needs neither Rust nor nonlinear dynamics, and is read in an afternoon.
    pub mod course {
        /// Drawing data become one equation of motion.
        ///
        #[doc = include_str!("../docs/pictures/01-excitation.svg")]
        ///
        #[doc = include_str!("../docs/links.md")]
        #[doc = include_str!("../docs/course/01-one-coordinate.md")]
        pub mod ch01 {}
        /// At which speeds a pair resonates, and how long the linear answer is right.
        ///
        #[doc = include_str!("../docs/pictures/02-response.svg")]
        ///
        #[doc = include_str!("../docs/links.md")]
        #[doc = include_str!("../docs/course/02-linear-response.md")]
        pub mod ch02 {}
        /// What happens when teeth separate, and why a program must know the instant.
        ///
        #[doc = include_str!("../docs/pictures/03-contact-loss.svg")]
        ///
        #[doc = include_str!("../docs/links.md")]
        #[doc = include_str!("../docs/course/03-contact-loss.md")]
        pub mod ch03 {}
        /// One periodic orbit, and how large its error is.
        ///
        #[doc = include_str!("../docs/pictures/04-orbit.svg")]
        ///
        #[doc = include_str!("../docs/links.md")]
        #[doc = include_str!("../docs/course/04-one-orbit.md")]
        pub mod ch04 {}
        /// Why a pair jumps, and at other speeds upwards than downwards.
        ///
        #[doc = include_str!("../docs/pictures/05-jumps.svg")]
        ///
        #[doc = include_str!("../docs/links.md")]
        #[doc = include_str!("../docs/course/05-jumps.md")]
        pub mod ch05 {}
        /// Where, over speed and torque, a pair rattles.
        ///
        #[doc = include_str!("../docs/pictures/06-map.svg")]
        ///
        #[doc = include_str!("../docs/links.md")]
        #[doc = include_str!("../docs/course/06-maps.md")]
        pub mod ch06 {}
        /// What an uneven torque does to the peak of the mesh force.
        ///
        #[doc = include_str!("../docs/pictures/07-random.svg")]
        ///
        #[doc = include_str!("../docs/links.md")]
        #[doc = include_str!("../docs/course/07-random-loads.md")]
        pub mod ch07 {}
        /// A contact law of one's own.
        ///
        #[doc = include_str!("../docs/pictures/08-law.svg")]
        ///
        #[doc = include_str!("../docs/links.md")]
        #[doc = include_str!("../docs/course/08-own-law.md")]
        pub mod ch08 {}
        /// A train of one's own, from teeth to the orders of its noise.
        ///
        #[doc = include_str!("../docs/pictures/09-orders.svg")]
        ///
        #[doc = include_str!("../docs/links.md")]
        #[doc = include_str!("../docs/course/09-own-train.md")]
        pub mod ch09 {}
        /// Units, scaling, and which tool answers which question.
        ///
        #[doc = include_str!("../docs/pictures/10-solvers.svg")]
        ///
        #[doc = include_str!("../docs/links.md")]
        #[doc = include_str!("../docs/course/10-which-solver.md")]
        pub mod ch10 {}
    }
    #[doc = include_str!("../docs/links.md")]
    #[doc = include_str!("../docs/from-python-and-matlab.md")]
    pub mod from_python_and_matlab {}
    #[doc = include_str!("../docs/links.md")]
    #[doc = include_str!("../docs/robot-joint.md")]
    pub mod robot_joint {}
    /// Fourteen pictures; `examples/gallery/` has a function for each.
    ///
    /// `cargo run --release -p examples --example gallery` redraws all.
    ///
    /// # 1. Mesh stiffness and transmission error
    ///
    #[doc = include_str!("../docs/pictures/01-excitation.svg")]
    ///
    /// # 2. Linear response and response with contact loss
    ///
    #[doc = include_str!("../docs/pictures/02-response.svg")]
    ///
    /// # 3. Deflection and force over time, the gap shaded
    ///
    #[doc = include_str!("../docs/pictures/03-contact-loss.svg")]
    ///
    /// # 4. An orbit in the phase plane
    ///
    #[doc = include_str!("../docs/pictures/04-orbit.svg")]
    ///
    /// # 5. A branch with its folds and grazings, sweeps up and down
    ///
    #[doc = include_str!("../docs/pictures/05-jumps.svg")]
    ///
    /// # 6. Rattle map with the lines of onset and fold
    ///
    #[doc = include_str!("../docs/pictures/06-map.svg")]
    ///
    /// # 7. Mesh force under a random torque: mean and band
    ///
    #[doc = include_str!("../docs/pictures/07-random.svg")]
    ///
    /// # 8. A contact law of one's own, and how it moves the folds
    ///
    #[doc = include_str!("../docs/pictures/08-law.svg")]
    ///
    /// # 9. Orders of the mesh forces of a two-stage gearbox, by source
    ///
    #[doc = include_str!("../docs/pictures/09-orders.svg")]
    ///
    /// # 10. Error over work of the solvers
    ///
    #[doc = include_str!("../docs/pictures/10-solvers.svg")]
    ///
    /// # 11. Campbell diagram of the gearbox
    ///
    #[doc = include_str!("../docs/pictures/11-campbell.svg")]
    ///
    /// # 12. Modes of a planetary set
    ///
    #[doc = include_str!("../docs/pictures/12-modes.svg")]
    ///
    /// # 13. Random torques and their power densities
    ///
    #[doc = include_str!("../docs/pictures/13-paths.svg")]
    ///
    /// # 14. A density of deflections, and rare events by splitting
    ///
    #[doc = include_str!("../docs/pictures/14-chances.svg")]
    pub mod gallery {}
    #[doc = include_str!("../docs/links.md")]
    #[doc = include_str!("../docs/start.md")]
    pub mod start {}
    #[doc = include_str!("../docs/links.md")]
    #[doc = include_str!("../docs/errors.md")]
    pub mod errors {}
    #[doc = include_str!("../docs/links.md")]
    #[doc = include_str!("../docs/theory.md")]
    pub mod theory {}
    #[doc = include_str!("../docs/links.md")]
    #[doc = include_str!("../docs/own-model.md")]
    pub mod own_model {}
    /// Which solver for which purpose, at which cost.
    ///
    #[doc = include_str!("../docs/integrators.svg")]
    ///
    #[doc = include_str!("../docs/links.md")]
    #[doc = include_str!("../docs/integrators.md")]
    pub mod integrators {}
    #[doc = include_str!("../docs/links.md")]
    #[doc = include_str!("../docs/events.md")]
    pub mod events {}
    #[doc = include_str!("../docs/links.md")]
    #[doc = include_str!("../docs/results.md")]
    pub mod results {}
    #[doc = include_str!("../docs/links.md")]
    #[doc = include_str!("../docs/certificates.md")]
    pub mod certificates {}
    #[doc = include_str!("../docs/links.md")]
    #[doc = include_str!("../docs/contact-laws.md")]
    pub mod contact_laws {}
    #[doc = include_str!("../docs/links.md")]
    #[doc = include_str!("../docs/trains.md")]
    pub mod trains {}
    #[doc = include_str!("../docs/links.md")]
    #[doc = include_str!("../docs/ready-trains.md")]
    pub mod ready_trains {}
    #[doc = include_str!("../docs/links.md")]
    #[doc = include_str!("../docs/teeth.md")]
    pub mod teeth {}
    #[doc = include_str!("../docs/links.md")]
    #[doc = include_str!("../docs/balance.md")]
    pub mod balance {}
    #[doc = include_str!("../docs/links.md")]
    #[doc = include_str!("../docs/branches.md")]
    pub mod branches {}
    #[doc = include_str!("../docs/links.md")]
    #[doc = include_str!("../docs/tori.md")]
    pub mod tori {}
    #[doc = include_str!("../docs/links.md")]
    #[doc = include_str!("../docs/random-density.md")]
    pub mod random_density {}
    #[doc = include_str!("../docs/links.md")]
    #[doc = include_str!("../docs/models.md")]
    pub mod models {}
    #[doc = include_str!("../docs/links.md")]
    #[doc = include_str!("../docs/sweeps.md")]
    pub mod sweeps {}
    /// With what probability teeth part, and how sure that is. Pictures 1 to 3 of the page:
    ///
    #[doc = include_str!("../docs/pictures/13-paths.svg")]
    ///
    #[doc = include_str!("../docs/pictures/rattle-atlas.svg")]
    ///
    #[doc = include_str!("../docs/pictures/14-chances.svg")]
    ///
    #[doc = include_str!("../docs/links.md")]
    #[doc = include_str!("../docs/random.md")]
    pub mod random {}
    #[doc = include_str!("../docs/links.md")]
    #[doc = include_str!("../docs/random-white.md")]
    pub mod random_white {}
    #[doc = include_str!("../docs/links.md")]
    #[doc = include_str!("../docs/errata.md")]
    pub mod errata {}
    #[doc = include_str!("../docs/links.md")]
    #[doc = include_str!("../docs/reproduction.md")]
    pub mod reproduction {}
    #[doc = include_str!("../docs/links.md")]
    #[doc = include_str!("../docs/validation.md")]
    pub mod validation {}
    #[doc = include_str!("../docs/links.md")]
    #[doc = include_str!("../docs/references.md")]
    pub mod references {}
    #[doc = include_str!("../docs/links.md")]
    #[doc = include_str!("../docs/glossary.md")]
    pub mod glossary {}
    #[doc = include_str!("../docs/links.md")]
    #[doc = include_str!("../ARCHITECTURE.md")]
    pub mod architecture {}
    /// The README, included here so that its code is tested.
    #[doc = include_str!("../README.md")]
    #[cfg(doctest)]
    pub mod readme {}
}
