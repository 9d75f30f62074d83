//! Natural frequencies, damping ratios and modes.

use crate::contact::Piece;
use crate::error::ParameterError;
use crate::excitation::Side;
use crate::linear::symmetric::inertias;
use crate::model::structure::slopes::Slopes;
use crate::model::{Model, Periodic, State};
use crate::numeric::gauss::FIVE;
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
    #[error("no contact state carries the load: {tried} were tried")]
    NoContactState {
        /// Number of states tried.
        tried: usize,
    },
    /// A body that the contacts leave free stands under load.
    #[error(
        "the load moves the model freely: no force of a support or contact balances {residual:.1e} of the largest \
         acceleration, at most 1e-6 is allowed: hold a body, or state torques that balance (Parts::load)"
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
}

impl Mode {
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
    symmetric: bool,
}

/// Largest frequency of a rigid motion, as a share of the highest one.
const RIGID: f64 = 1e-6;

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
        let (n, period) = (model.dof(), model.period());
        let pieces = vec![Piece::Upper; model.contacts()];
        let rest = vec![0.0; n];
        let (mut u, mut slopes) = (vec![0.0; model.drives()], Slopes::new(model, vec![1.0; 2 * n], 0.0));
        let mut mean = [DMatrix::zeros(n, n), DMatrix::zeros(n, n)];
        let (mut t, mut edges) = (0.0, 0);
        while t < period {
            edges += 1;
            crate::error::check::count("edges of the drives in a period", &[edges], 10_000)?;
            let end = model.next_edge(t).map_or(period, |edge| edge.min(period));
            let h = (end - t) / PANELS as f64;
            for panel in 0..PANELS {
                for [x, weight] in FIVE {
                    model.drive(t + h * (panel as f64 + 0.5 + 0.5 * x), Side::After, &mut u);
                    slopes.at(Some(&pieces), &u, &rest, &rest);
                    let share = 0.5 * weight * h / period;
                    mean[0] += &slopes.jacobian.q * share;
                    mean[1] += &slopes.jacobian.v * share;
                }
            }
            t = end;
        }
        Modes::of(&mean[0], &mean[1], 0.0)
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
            crate::error::check::length("pieces", pieces.len(), model.contacts())?;
        }
        let mut u = vec![0.0; model.drives()];
        model.drive(*t, Side::After, &mut u);
        let mut slopes = Slopes::new(model, vec![1.0; 2 * n], 0.0);
        slopes.at(pieces, &u, q, v);
        Modes::of(&slopes.jacobian.q, &slopes.jacobian.v, *t)
    }

    /// Modes of ∂a/∂q and ∂a/∂v.
    fn of(q: &DMatrix<f64>, v: &DMatrix<f64>, t: f64) -> Result<Self, LinearError> {
        if q.iter().chain(v.iter()).any(|x| !x.is_finite()) {
            return Err(LinearError::NotFinite { t });
        }
        let stiffness = -q;
        let (mut list, symmetric) = match inertias(&stiffness) {
            Some(m) => (symmetric(&stiffness, &m)?, true),
            None => (general(&stiffness)?, false),
        };
        list.sort_by(|a, b| a.square.total_cmp(&b.square));
        let eigenvalues = damped(q, v)?;
        Ok(Modes { list, eigenvalues, symmetric })
    }

    /// Modes in the order of their frequencies; unstable modes and rigid motions first, with the frequency 0.
    ///
    /// A pair of complex frequencies of a stiffness that is not symmetric is left out; see
    /// [`eigenvalues`](Modes::eigenvalues).
    pub fn all(&self) -> &[Mode] {
        &self.list
    }
    /// Number of rigid motions: modes below a millionth of the highest frequency.
    pub fn rigid_count(&self) -> usize {
        self.list.iter().filter(|mode| mode.square == 0.0).count()
    }
    /// Number of statically unstable modes, ω² < 0: they come first in [`all`](Modes::all). A bearing
    /// with radial clearance has two about its centre; use [`about`](Modes::about) with a state in which it
    /// carries.
    pub fn unstable_count(&self) -> usize {
        self.list.iter().filter(|mode| mode.square < 0.0).count()
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
    pub fn eigenvalues(&self) -> &[Complex64] {
        &self.eigenvalues
    }
    /// Natural frequency and damping ratio of each of the [`eigenvalues`](Modes::eigenvalues). Rigid motions
    /// and overdamped modes are not among them: the list is shorter than [`hertz`](Modes::hertz).
    pub fn damped(&self) -> Vec<DampedMode> {
        let of =
            |value: &Complex64| DampedMode { hertz: value.norm() / TAU, ratio: -value.re / value.norm() };
        self.eigenvalues.iter().map(of).collect()
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
pub struct DampedMode {
    /// Undamped natural frequency |λ|/2π, in cycles per time unit.
    pub hertz: f64,
    /// Damping ratio ζ = -Re λ/|λ| `[1]`.
    pub ratio: f64,
}

/// The mode of an eigenvalue ω² among eigenvalues up to `most`, with its largest entry 1.
fn mode(square: f64, most: f64, shape: impl Iterator<Item = f64>) -> Mode {
    let mut shape: Vec<f64> = shape.collect();
    let largest = shape.iter().fold(0.0f64, |most, x| if x.abs() > most.abs() { *x } else { most });
    shape.iter_mut().for_each(|x| *x /= largest);
    let square = if square.abs() <= RIGID * RIGID * most { 0.0 } else { square };
    Mode { square, frequency: square.max(0.0).sqrt(), shape }
}

/// Modes of M⁻¹ K with diagonal M, from the symmetric matrix M^(1/2) A M^(-1/2).
fn symmetric(a: &DMatrix<f64>, m: &[f64]) -> Result<Vec<Mode>, LinearError> {
    let n = a.nrows();
    let root: Vec<f64> = m.iter().map(|m| m.sqrt()).collect();
    let entry =
        |i: usize, j: usize| 0.5 * (a[(i, j)] * (root[i] / root[j]) + a[(j, i)] * (root[j] / root[i]));
    let matrix = faer::Mat::from_fn(n, n, entry);
    let found =
        matrix.self_adjoint_eigen(faer::Side::Lower).map_err(|_| LinearError::NotConverged { rows: n })?;
    let (values, vectors) = (found.S().column_vector(), found.U());
    let most = (0..n).map(|k| values[k].abs()).fold(0.0, f64::max);
    Ok((0..n).map(|k| mode(values[k], most, (0..n).map(|i| vectors[(i, k)] / root[i]))).collect())
}

/// Modes of any matrix with real positive eigenvalues.
fn general(a: &DMatrix<f64>) -> Result<Vec<Mode>, LinearError> {
    let n = a.nrows();
    let matrix = faer::Mat::from_fn(n, n, |i, j| a[(i, j)]);
    let found = matrix.eigen().map_err(|_| LinearError::NotConverged { rows: n })?;
    let (values, vectors) = (found.S().column_vector(), found.U());
    let most = (0..n).map(|k| values[k].norm()).fold(0.0, f64::max);
    let real = |k: &usize| values[*k].im.abs() <= 1e-9 * most;
    Ok((0..n)
        .filter(real)
        .map(|k| {
            // A real eigenvector may carry a complex factor.
            let largest = (0..n).map(|i| vectors[(i, k)]).fold(Complex64::new(0.0, 0.0), |most, x| {
                if x.norm() > most.norm() { Complex64::new(x.re, x.im) } else { most }
            });
            let shape = (0..n).map(move |i| {
                let x = vectors[(i, k)];
                (Complex64::new(x.re, x.im) / largest).re
            });
            mode(values[k].re, most, shape)
        })
        .collect())
}

/// Eigenvalues of the first-order system with positive imaginary part.
fn damped(q: &DMatrix<f64>, v: &DMatrix<f64>) -> Result<Vec<Complex64>, LinearError> {
    let n = q.nrows();
    // Time in units of 1/ω, so that both halves have the same size.
    let omega = [q.amax().sqrt(), v.amax(), 1.0].into_iter().find(|omega| *omega > 0.0).unwrap_or(1.0);
    let matrix = faer::Mat::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
        (true, true) => 0.0,
        (true, false) => f64::from(u8::from(i == j - n)),
        (false, true) => q[(i - n, j)] / (omega * omega),
        (false, false) => v[(i - n, j - n)] / omega,
    });
    let values = matrix.eigenvalues().map_err(|_| LinearError::NotConverged { rows: 2 * n })?;
    let most = values.iter().map(|value| value.norm()).fold(0.0, f64::max);
    let mut values: Vec<Complex64> = values
        .iter()
        .filter(|value| value.im > RIGID * most)
        .map(|value| Complex64::new(value.re, value.im) * omega)
        .collect();
    values.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
    Ok(values)
}
