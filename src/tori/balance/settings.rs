//! Balance of a torus: settings and solution.

use crate::contact::Piece;
use crate::error::check;
use crate::model::equations::lacks_pieces;
use crate::ode::Budget;
use crate::ode::budget::Meter;
use crate::periodic::metered::{Metered, RootFailure};
use crate::roots::{Newton, Residual, Root, RootError, RootFinder};
use crate::tori::balance::quality::{aliasing, between, smallest_rate};
use crate::tori::balance::torus::Torus;
use crate::tori::balance::torus_equations::TorusEquations;
use crate::tori::balance::torus_error::TorusError;
use crate::tori::balance::wave_vectors::WaveVectors;
use crate::tori::quasi_periodic::{QuasiPeriodic, checked_frequencies};

/// (ω·∂_θ)² q = a(u(θ), q, (ω·∂_θ) q): quasi-periodic motions by harmonic balance in several angles.
///
/// q(θ) is a Fourier series in the angles θ = ω t of all base frequencies. The residual has no component at
/// the kept wave vectors. Its coefficients are sums over an equidistant grid of angles, computed by fast
/// Fourier transforms. Newton's method uses the Jacobian of the model.   Source: Chua and Ushida, IEEE Trans.
/// Circuits Syst. 28 (1981) 953; Schilder, Vogt, Schreiber and Osinga, Int. J. Numer. Meth. Eng. 67 (2006)
/// 629.
///
/// With contacts that separate, q'' has kinks along curves on the torus. The grid does not locate them, and
/// the coefficients converge with a power of the order. [`Torus::residual_between`] and [`Torus::aliasing`]
/// show this; [`CircleShooting`](crate::tori::CircleShooting) locates the edges. The same holds for drives
/// that jump.
///
/// Stable and unstable tori satisfy the same equations, and a balance does not tell them apart. With two
/// frequencies [`CircleShooting`](crate::tori::CircleShooting) from [`Torus::section`] gives the growth of
/// perturbations.
///
/// A rigid motion leaves its mean undetermined ([`TorusError::Singular`]): use relative coordinates.
///
/// ```
/// use gear_dynamics::{Model, excitation::Side, tori::{QuasiPeriodic, TorusBalance, WaveVectors}};
/// struct Duffing; // q'' + 0.1 q' + q + 0.2 q³ = 0.3 cos 0.7t + 0.2 cos 0.7√3t
/// impl Model for Duffing {
///     fn dof(&self) -> usize { 1 }
///     fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
///         a[0] = u[0] - 0.1 * v[0] - q[0] - 0.2 * q[0].powi(3);
///     }
///     fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
///         self.drive_at(&[0.7 * t, 0.7 * 3f64.sqrt() * t], side, u);
///     }
/// }
/// impl QuasiPeriodic for Duffing {
///     fn frequencies(&self) -> Vec<f64> { vec![0.7, 0.7 * 3f64.sqrt()] }
///     fn drive_at(&self, angles: &[f64], _: Side, u: &mut [f64]) {
///         u[0] = 0.3 * angles[0].cos() + 0.2 * angles[1].cos();
///     }
/// }
/// let balance = TorusBalance::new(WaveVectors::within(&[13, 13])?);
/// let torus = balance.solve(&Duffing, &balance.at_rest(&Duffing, &[0.0])?)?;
/// assert!((torus.rms(0) - 0.502_479_824_8).abs() < 1e-9);
/// assert!(torus.residual_between() < 1e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[must_use = "a setting returns a new value"]
pub struct TorusBalance {
    vectors: WaveVectors,
    oversampling: usize,
    separation: f64,
    newton: Newton,
    budget: Budget,
}

/// Maximum oversampling.
const MAX_OVERSAMPLING: usize = 64;

impl TorusBalance {
    /// Defaults: oversampling 2, separation 1e-6, Newton's method with its default settings, the default
    /// [`Budget`].
    pub fn new(vectors: WaveVectors) -> Self {
        TorusBalance {
            vectors,
            oversampling: 2,
            separation: 1e-6,
            newton: Newton::new(),
            budget: Budget::new(),
        }
    }
    /// Points of the grid along angle d over 2 H_d + 1, with the highest order H_d, 1 to 64. Default: 2,
    /// without aliasing for cubic forces. More are needed with contacts.
    pub fn oversampling(self, oversampling: usize) -> Self {
        TorusBalance { oversampling, ..self }
    }
    /// Smallest accepted |k·ω| of the kept wave vectors k ≠ 0, over the highest base frequency `[1]`, in [0,
    /// 1). Default: 1e-6.
    pub fn separation(self, separation: f64) -> Self {
        TorusBalance { separation, ..self }
    }
    /// Settings of Newton's method.
    pub fn newton(self, newton: Newton) -> Self {
        TorusBalance { newton, ..self }
    }
    /// Maximum number of steps and maximum time of one call. A step is an evaluation of the balance.
    pub fn budget(self, budget: Budget) -> Self {
        TorusBalance { budget, ..self }
    }

    /// The torus of a motion at rest, `q` constant: a guess for [`solve`](TorusBalance::solve). For contacts
    /// with moving edges start from [`linearised`](TorusBalance::linearised) instead.
    ///
    /// # Errors
    /// [`TorusError`] for frequencies, drives or coordinates that are not valid.
    pub fn at_rest(&self, model: &dyn QuasiPeriodic, q: &[f64]) -> Result<Torus, TorusError> {
        Ok(Torus::constant(&self.vectors, &checked_frequencies(model)?, q)?)
    }

    /// The torus with every contact fixed on one piece: the usual guess for a model with contacts. The
    /// residual between the points and the aliasing are not measured.
    ///
    /// # Errors
    /// [`TorusError`]; [`TorusError::NoPieces`] if the model does not evaluate its laws on fixed pieces.
    pub fn linearised(&self, model: &dyn QuasiPeriodic, flank: Piece) -> Result<Torus, TorusError> {
        let frequencies = checked_frequencies(model)?;
        let rest = Torus::constant(&self.vectors, &frequencies, &vec![0.0; model.dof()])?;
        self.check(model, &rest, &frequencies)?;
        if lacks_pieces(model) {
            return Err(TorusError::NoPieces);
        }
        let meter = self.budget.begin();
        let mut equations = TorusEquations::new(model, &self.vectors, &rest, self.oversampling)?
            .on_fixed_pieces(&vec![flank; model.contacts()]);
        let x = equations.unknowns(&rest);
        let root = self.newton.solve(&mut Metered { equations: &mut equations, meter: &meter }, &x);
        finish(&equations, root, &meter)
    }

    /// Finds a torus from a guess: a motion at rest, a linearised or fitted torus, the torus of a
    /// neighbouring model, or of the same model with other orders.
    ///
    /// # Errors
    /// [`TorusError`]; [`TorusError::last`] returns the last iterate.
    pub fn solve(&self, model: &dyn QuasiPeriodic, guess: &Torus) -> Result<Torus, TorusError> {
        let frequencies = checked_frequencies(model)?;
        self.check(model, guess, &frequencies)?;
        let meter = self.budget.begin();
        // The velocities of the guess follow the frequencies of the model.
        let guess = Torus::of(self.vectors.clone(), frequencies, guess.on(&self.vectors).all().to_vec());
        let mut equations = TorusEquations::new(model, &self.vectors, &guess, self.oversampling)?;
        let x = equations.unknowns(&guess);
        let root = self.newton.solve(&mut Metered { equations: &mut equations, meter: &meter }, &x);
        let mut torus = finish(&equations, root, &meter)?;
        let stopped =
            |exhausted, torus: &Torus| TorusError::Exhausted { exhausted, last: Box::new(torus.clone()) };
        torus.quality.between = between(model, &torus, &meter).map_err(|e| stopped(e, &torus))?;
        let finer = TorusEquations::new(model, &self.vectors, &torus, 2 * self.oversampling);
        // Beyond the limits of memory the aliasing stays unknown.
        if let Ok(mut finer) = finer {
            torus.quality.aliasing = aliasing(&mut equations, &mut finer, &torus);
        }
        Ok(torus)
    }

    fn check(&self, model: &dyn QuasiPeriodic, guess: &Torus, frequencies: &[f64]) -> Result<(), TorusError> {
        check::at_least("oversampling", self.oversampling, 1)?;
        check::count("oversampling", &[self.oversampling], MAX_OVERSAMPLING)?;
        check::fraction("separation", self.separation)?;
        check::length("highest orders", self.vectors.angles(), frequencies.len())?;
        check::length("frequencies of the guess", guess.frequencies().len(), frequencies.len())?;
        check::length("coordinates of the torus", guess.dof(), model.dof())?;
        model.offers().refuse_stops(|contact| TorusError::RigidStop { contact })?;
        let highest = frequencies.iter().fold(0.0f64, |m, w| m.max(*w));
        let limit = self.separation * highest;
        let (rate, vector) = smallest_rate(&self.vectors, frequencies);
        if rate < limit {
            return Err(TorusError::Commensurate { vector, rate, limit });
        }
        Ok(())
    }
}

fn finish(
    equations: &TorusEquations<'_>,
    root: Result<Root, RootError>,
    meter: &Meter<'_>,
) -> Result<Torus, TorusError> {
    let torus = |root: Root| {
        let mut torus = equations.torus(&root.x);
        torus.quality.residual = root.residual;
        (torus.quality.iterations, torus.quality.evaluations) = (root.iterations, root.evaluations);
        torus.quality.residuals = root.residuals;
        torus
    };
    let width = equations.size() / equations.dof();
    let error = match root {
        Ok(root) => return Ok(torus(root)),
        Err(error) => error,
    };
    let (failure, root) = RootFailure::of(error, meter)?;
    let last = Box::new(torus(root));
    Err(match failure {
        RootFailure::Exhausted(exhausted) => TorusError::Exhausted { exhausted, last },
        RootFailure::Slope { equation, unknown } => {
            TorusError::Slope { acceleration: equation / width, coordinate: unknown / width, last }
        }
        RootFailure::Singular { unknown } => {
            let (coordinate, vector) = equations.meaning(unknown);
            TorusError::Singular { coordinate, vector, last }
        }
        RootFailure::NotConverged => TorusError::NotConverged { last },
        RootFailure::NotFinite => TorusError::NotFinite { last },
    })
}
