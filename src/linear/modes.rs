//! Natural frequencies, damping ratios and modes.

use crate::contact::Piece;
use crate::error::{ParameterError, check};
use crate::excitation::Side;
use crate::linear::instants::{Instants, smooth_intervals};
use crate::linear::resolution::{self, errors};
use crate::linear::spectrum::Found;
use crate::model::structure::slopes::Slopes;
use crate::model::{Model, Periodic, State};
use nalgebra::DMatrix;
use num_complex::Complex64;
use std::f64::consts::TAU;
use thiserror::Error;

/// The reason why a linear analysis has no result.
///
/// ```
/// use gear_dynamics::linear::{LinearError, Modes};
/// use gear_dynamics::{NfgPair, NfgParams, State, contact::Piece};
/// let pair = NfgPair::new(&NfgParams::table1())?;
/// let error = Modes::about(&pair, &State::at_rest(1), Some(&[Piece::Upper; 2])).unwrap_err();
/// assert_eq!(error.to_string(), "pieces has 2 entries: 1 are needed");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum LinearError {
    /// A parameter out of its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// The derivative of the accelerations is not a number.
    #[error("the Jacobian of the model at t = {t:?} is not finite")]
    NotFinite {
        /// Time.
        t: f64,
    },
    /// Eigenvalues did not converge.
    #[error("the eigenvalues of a matrix of {rows} rows did not converge")]
    NotConverged {
        /// Number of rows.
        rows: usize,
    },
    /// No contact state is consistent with the load.
    #[error(
        "no contact state carries the load: {tried} were tried; check that a support or contact holds each body \
         against its torque, or give a start of your own, as the end of a run with damping"
    )]
    NoContactState {
        /// Number of states tried.
        tried: usize,
    },
    /// The lower edge of a gap lies above its upper edge, or is not a number. The backlash is then negative
    /// or not defined.
    #[error(
        "the gap of contact {contact} is negative or not a number: its lower edge is {lower:?}, its upper edge {upper:?}"
    )]
    NegativeGap {
        /// Index of the contact, from 0.
        contact: usize,
        /// Lower edge of the gap.
        lower: f64,
        /// Upper edge of the gap.
        upper: f64,
    },
    /// A body that the contacts leave free stands under load.
    #[error(
        "the load moves the model freely: no force of a support or contact balances {residual:.1e} of the largest \
         load, at most 1e-9 is allowed: hold a body, state torques that balance (Parts::load), or give a start"
    )]
    Free {
        /// Largest acceleration that is left, over the largest acceleration at rest.
        residual: f64,
    },
    /// The linearised motion does not decay: it has no stationary moments.
    #[error("the linearised motion does not decay: the largest growth rate is {rate:?}")]
    Grows {
        /// Largest real part of an eigenvalue [1/time]. A rigid motion has 0.
        rate: f64,
    },
    /// Noise that multiplies the state lets the mean square of the linearised motion grow without bound,
    /// although the mean decays.
    #[error(
        "the mean square of the linearised motion grows without bound: the noise on a stiffness or a damping feeds \
         in more energy than the damping takes out: lower its intensity, or raise the damping"
    )]
    MeanSquareGrows,
}

/// One mode.
///
/// ```
/// use gear_dynamics::linear::Modes;
/// use gear_dynamics::{NfgPair, NfgParams};
/// let pair = NfgPair::new(&NfgParams::table1())?;
/// let modes = Modes::in_contact(&pair, 0.0)?;
/// assert_eq!(modes.all()[0].shape(), [1.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Mode {
    /// ω², negative if the stiffness is.
    square: f64,
    frequency: f64,
    shape: Vec<f64>,
    /// Bound of the error of ω² by rounding; of a rigid motion, the largest ω² that this error may hide.
    error: f64,
    rigid: bool,
}

impl Mode {
    fn of(found: Found) -> Self {
        let Found { square, mut shape, error, rigid } = found;
        let largest = shape.iter().fold(0.0f64, |most, x| if x.abs() > most.abs() { *x } else { most });
        shape.iter_mut().for_each(|x| *x /= largest);
        Mode { square, frequency: square.max(0.0).sqrt(), shape, error, rigid }
    }

    /// ω² as the eigenvalue of the stiffness over the inertia; negative for a mode that is statically
    /// unstable.
    pub fn square(&self) -> f64 {
        self.square
    }
    /// Undamped natural frequency [rad per time unit]; 0 for a rigid motion and for an unstable mode.
    pub fn frequency(&self) -> f64 {
        self.frequency
    }
    /// Undamped natural frequency in cycles per time unit; Hz for a model in seconds.
    pub fn hertz(&self) -> f64 {
        self.frequency / TAU
    }
    /// Estimate of the error of [`square`](Mode::square) by rounding, as a share of it `[1]`; that of the
    /// frequency is half of it. 0 for a rigid motion.
    ///
    /// The accelerations are sums in double precision: a stiffness of 1 N/m on a body with another one of
    /// 1e12 N/m has four correct digits, of which the estimate counts on two. Infinite for a mode whose
    /// square is 0 and that is not rigid.
    pub fn rounding(&self) -> f64 {
        match (self.rigid, self.square == 0.0) {
            (true, _) => 0.0,
            (false, true) => f64::INFINITY,
            (false, false) => self.error / self.square.abs(),
        }
    }
    /// Whether double precision resolves the mode: [`rounding`](Mode::rounding) is below 1/2. If not, the
    /// errors of the Jacobian may be as large as the square, and its sign may be wrong. Leave the stiffest
    /// part out, as a rigid connection.
    pub fn is_resolved(&self) -> bool {
        self.rounding() < 0.5
    }
    /// For a rigid motion, the largest frequency that the rounding of the Jacobian may hide [rad per time
    /// unit], to first order; 0 for any other mode. A soft support whose frequency lies below it cannot be
    /// told from none. Two masses of 1 kg on a spring of 1e14 N/m may hide up to 1 rad/s.
    pub fn hidden_frequency(&self) -> f64 {
        if self.rigid { self.error.sqrt() } else { 0.0 }
    }
    /// Mode by coordinate, with the largest entry 1.
    pub fn shape(&self) -> &[f64] {
        &self.shape
    }
}

/// Modes of a model about a contact state.
///
/// Undamped: ∂a/∂q φ = -ω² φ. Damped: eigenvalues λ of [0, I; ∂a/∂q, ∂a/∂q']. a are the accelerations of the
/// model on the given pieces of its contact laws, at given drives.   Source: Meirovitch, Fundamentals of
/// Vibrations, chapter 7.
///
/// Rigid motions are counted by the rank of ∂a/∂q. A resistance counts in two cases: it is larger than the
/// rounding of the largest stiffness on the same coordinates, or an entry of ∂a/∂q that is larger than its
/// own error remains of it when the stiffer couplings are eliminated. A soft spring between two stiff groups
/// is therefore a coupling, whatever its stiffness. The errors of the entries are:
///
/// - for a Jacobian that the model provides, 8 ε of each entry, ε = 2.2e-16, and for a
///   [`Machine`](crate::Machine) 8 ε of the sum of the terms of each entry; for a mean over a period 64 ε
///   more;
/// - for differences, 16 ε of each entry, or four times what steps of other lengths change if that is more.
///
/// What lies below these errors cannot be seen: 1e12 + 1e-9 = 1e12, so that a spring of 1e-9 to the ground
/// beside one of 1e12 leaves a rigid motion. Its [`hidden_frequency`](Mode::hidden_frequency) says which
/// frequency may hide behind it. A coupling that is certain while the errors hide its frequency
/// gives a mode with [`is_resolved`](Mode::is_resolved) false, whose [`rounding`](Mode::rounding) bounds the
/// error. If all couplings are springs between coordinates, its square is that of the springs without what
/// the errors may hide to the ground: 0.01 between two stiff groups of 1e12 keeps its digits. For other
/// couplings, for example by gears, its square and shape are rounding, and so is the share of that shape in
/// the rigid motion.
///
/// ```
/// use gear_dynamics::linear::Modes;
/// use gear_dynamics::trains::{Body, MeshPart, Parts};
/// use gear_dynamics::Wave;
/// let mut parts = Parts::new();
/// parts.body("pinion", Body::new(1e-3)).body("wheel", Body::new(4e-3));
/// parts.mesh("mesh", "pinion", "wheel", MeshPart::external([20, 40], [0.03, 0.06], Wave::constant(2e8)?));
/// let modes = Modes::in_contact(&parts.build("pinion", 100.0)?, 0.0)?;
/// let exact = (2e8 * (0.03f64.powi(2) / 1e-3 + 0.06f64.powi(2) / 4e-3)).sqrt();
/// assert_eq!(modes.rigid_count(), 1);
/// assert!((modes.all()[1].frequency() / exact - 1.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Modes {
    list: Vec<Mode>,
    eigenvalues: Vec<Complex64>,
    /// Errors of the eigenvalues as shares of them.
    roundings: Vec<f64>,
    symmetric: bool,
}

/// Roundings of the mean of ∂a/∂q over a period, a sum of at least 320 matrices, in ε = 2.2e-16 of its terms.
const ROUNDINGS_OF_MEAN: f64 = 64.0;

impl Modes {
    /// Modes at time t with all teeth on their upper (drive) flanks.
    ///
    /// # Errors
    /// A model whose Jacobian is not finite; eigenvalues that do not converge.
    pub fn in_contact(model: &dyn Model, t: f64) -> Result<Self, LinearError> {
        let rest = State { t, ..State::at_rest(model.dof()) };
        Modes::about(model, &rest, Some(&vec![Piece::Upper; model.contacts()]))
    }

    /// Modes with all teeth on their upper (drive) flanks and the mean of the Jacobian over a period: of the
    /// mean mesh stiffness. The mean is taken by Gauss quadrature on 64 panels between two edges of the
    /// drives.
    ///
    /// # Errors
    /// As [`in_contact`](Modes::in_contact); more than 10 000 edges in a period.
    pub fn mean_in_contact(model: &dyn Periodic) -> Result<Self, LinearError> {
        const PANELS: usize = 64;
        const EDGES: usize = 10_000;
        let (n, pieces) = (model.dof(), vec![Piece::Upper; model.contacts()]);
        let bounds = smooth_intervals(model, EDGES + 1);
        check::count("edges of the drives in a period", &[bounds.len() - 1], EDGES)?;
        let rest = vec![0.0; n];
        let mut slopes = Slopes::new(model, vec![1.0; 2 * n], 0.0);
        let mut mean = [DMatrix::zeros(n, n), DMatrix::zeros(n, n)];
        let mut error = DMatrix::zeros(n, n);
        for bound in bounds.windows(2) {
            let part = (bound[1] - bound[0]) / model.period();
            let mut known = DMatrix::zeros(n, n);
            for (k, (weight, u)) in Instants::of(model, bound, PANELS).iter().enumerate() {
                slopes.at(Some(&pieces), u, &rest, &rest);
                if k == 0 {
                    known = errors(&mut slopes, Some(&pieces), u, [&rest, &rest]);
                }
                mean[0] += &slopes.jacobian.q * (weight * part);
                mean[1] += &slopes.jacobian.v * (weight * part);
                error += slopes.jacobian.q.abs() * (ROUNDINGS_OF_MEAN * f64::EPSILON * weight * part);
            }
            error += known * part;
        }
        Modes::of([&mean[0], &mean[1]], 0.0, &error)
    }

    /// Modes about a state. `pieces`: that of each contact; `None`: those on which the state stands.
    ///
    /// # Errors
    /// As [`in_contact`](Modes::in_contact); a wrong number of pieces; a state that does not fit the model.
    pub fn about(model: &dyn Model, state: &State, pieces: Option<&[Piece]>) -> Result<Self, LinearError> {
        let n = model.dof();
        state.check(n)?;
        let State { t, q, v } = state;
        if let Some(pieces) = pieces {
            check::length("pieces", pieces.len(), model.contacts())?;
        }
        let mut u = vec![0.0; model.drives()];
        model.drive(*t, Side::After, &mut u);
        let mut slopes = Slopes::new(model, vec![1.0; 2 * n], 0.0);
        slopes.at(pieces, &u, q, v);
        let error = errors(&mut slopes, pieces, &u, [q, v]);
        Modes::of([&slopes.jacobian.q, &slopes.jacobian.v], *t, &error)
    }

    /// Modes of ∂a/∂q, whose entries have these errors, and of ∂a/∂v.
    fn of([q, v]: [&DMatrix<f64>; 2], t: f64, error: &DMatrix<f64>) -> Result<Self, LinearError> {
        if q.iter().chain(v.iter()).any(|x| !x.is_finite()) {
            return Err(LinearError::NotFinite { t });
        }
        let found = resolution::spectrum([q, v], error);
        let spectrum = found.ok_or(LinearError::NotConverged { rows: q.nrows() })?;
        let mut list: Vec<Mode> = spectrum.modes.into_iter().map(Mode::of).collect();
        list.sort_by(|a, b| a.square.total_cmp(&b.square));
        let (eigenvalues, roundings) =
            spectrum.damped.iter().map(|damped| (damped.value, damped.rounding)).unzip();
        Ok(Modes { list, eigenvalues, roundings, symmetric: spectrum.symmetric })
    }

    /// Modes in the order of their frequencies; unstable modes and rigid motions first, with the frequency 0.
    ///
    /// A pair of complex frequencies of a stiffness that is not symmetric is left out; see
    /// [`eigenvalues`](Modes::eigenvalues).
    pub fn all(&self) -> &[Mode] {
        &self.list
    }
    /// Number of rigid motions: motions that no coupling of the model resists. [`Modes`] states the rule.
    pub fn rigid_count(&self) -> usize {
        self.list.iter().filter(|mode| mode.rigid).count()
    }
    /// Number of statically unstable modes, ω² < 0: they come first in [`all`](Modes::all). A bearing
    /// with radial clearance has two about its centre; use [`about`](Modes::about) with a state in which it
    /// carries.
    pub fn unstable_count(&self) -> usize {
        self.list.iter().filter(|mode| mode.square < 0.0 && mode.is_resolved()).count()
    }
    /// Undamped natural frequencies [rad per time unit].
    pub fn frequencies(&self) -> Vec<f64> {
        self.list.iter().map(Mode::frequency).collect()
    }
    /// Undamped natural frequencies in cycles per time unit.
    pub fn hertz(&self) -> Vec<f64> {
        self.list.iter().map(Mode::hertz).collect()
    }
    /// Whether the stiffness is symmetric, so that all frequencies are real.
    pub fn is_symmetric(&self) -> bool {
        self.symmetric
    }
    /// Eigenvalues λ of the damped model with positive imaginary part, in the order of |λ|.
    ///
    /// The natural frequency is |λ| and the damping ratio -Re λ/|λ|. Overdamped modes are not listed.
    /// [`damped`](Modes::damped) gives the error of each by rounding.
    pub fn eigenvalues(&self) -> &[Complex64] {
        &self.eigenvalues
    }
    /// Natural frequency and damping ratio of each of the [`eigenvalues`](Modes::eigenvalues). Rigid motions
    /// and overdamped modes are not among them: the list is shorter than [`hertz`](Modes::hertz).
    ///
    /// A mode that is not [resolved](Mode::is_resolved) without damping is either listed with
    /// [`DampedMode::is_resolved`] false, or counts as overdamped.
    pub fn damped(&self) -> Vec<DampedMode> {
        let of = |(value, rounding): (&Complex64, &f64)| DampedMode {
            hertz: value.norm() / TAU,
            ratio: -value.re / value.norm(),
            rounding: *rounding,
        };
        self.eigenvalues.iter().zip(&self.roundings).map(of).collect()
    }
}

/// Natural frequency and damping ratio of a mode, by its eigenvalue λ.
///
/// ```
/// use gear_dynamics::{State, linear::Modes, model::from_fn};
/// let swing = from_fn(1, |_, q, v, a| a[0] = -0.6 * v[0] - 9.0 * q[0])?; // 2 ζ ω = 0.6, ω = 3
/// let mode = Modes::about(&swing, &State::at_rest(1), None)?.damped()[0];
/// assert!((mode.hertz - 3.0 / std::f64::consts::TAU).abs() < 1e-9 && (mode.ratio - 0.1).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct DampedMode {
    /// Undamped natural frequency |λ|/2π, in cycles per time unit.
    pub hertz: f64,
    /// Damping ratio ζ = -Re λ/|λ| `[1]`.
    pub ratio: f64,
    /// Estimate of the error of λ by rounding, as a share of |λ| `[1]`. It is that of the frequency, and the
    /// absolute error of the damping ratio.
    pub rounding: f64,
}

impl DampedMode {
    /// Whether double precision resolves the mode: [`rounding`](DampedMode::rounding) is below 1/4, that of
    /// the square of the frequency below 1/2.
    pub fn is_resolved(&self) -> bool {
        self.rounding < 0.25
    }
}
