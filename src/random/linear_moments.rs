//! Mean and covariance of a linearised model under white noise.

use crate::contact::{Contact, Piece};
use crate::error::check;
use crate::excitation::Side;
use crate::linear::{LinearError, Modes};
use crate::model::structure::slopes::{Slopes, accelerate};
use crate::model::{Model, State};
use crate::random::white::noise::{Target, WhiteNoise};
use crate::roots::Matrix;
use crate::roots::factors::{Factors, Floating};
use nalgebra::{DMatrix, DVector};

/// Stationary mean and covariance of a model under white noise, linearised about a state, without sampling.
///
/// With x = (q, q') and the deviation y of x from the state, in the sense of Ito:
///
/// y' = A y + b + Σ √D_k (B_k y + g_k) ξ_k,
/// A m + b = 0,
/// A P + P Aᵀ + Σ D_k (B_k P B_kᵀ + h_k h_kᵀ) = 0 with h_k = B_k m + g_k
///
/// m is the mean of y and P its covariance. For additive noise, B = 0, the last line is the equation of
/// Lyapunov. Noise on a damping or a stiffness has B; since it is meant in the sense of Stratonovich
/// ([`WhiteNoise::drives`]), A contains D B²/2 and b contains D B g/2.
///
/// The moments exist if A is stable and the mean square does not grow: if and only if the last line with the
/// identity in place of Σ D h hᵀ has a positive definite solution.   Source: Gardiner 2009, chapter 4; Damm
/// 2004.
///
/// All contacts stay on the pieces on which the state stands, and all drives keep their values at the time
/// of the state. The moments are those of the model if the motion rarely leaves these pieces: compare the
/// distance to the edges with the standard deviations.
///
/// ```
/// use gear_dynamics::random::{LinearMoments, WhiteNoise};
/// use gear_dynamics::{models::Oscillator, State};
/// // q'' + 0.5 q' + 4 q = 2 + √0.5 ξ: the mean is 2/4, the variances are D/(2 c k) and D/(2 c).
/// let free = Oscillator::new(&[("speed", 1.0), ("linear stiffness", 4.0), ("mean force", 2.0)])?;
/// let moments = LinearMoments::about(&free, &State::at_rest(1), &[WhiteNoise::bath(0, 0.5, 0.5)?])?;
/// assert!((moments.mean().q[0] - 0.5).abs() < 1e-12);
/// let covariance = moments.covariance(); // rows and columns: q0, v0
/// assert!((covariance[(0, 0)] - 0.125).abs() < 1e-12 && (covariance[(1, 1)] - 0.5).abs() < 1e-12);
/// assert!(covariance[(0, 1)].abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct LinearMoments {
    mean: State,
    covariance: DMatrix<f64>,
}

impl LinearMoments {
    /// Moments of the model linearised about a state, usually its [static
    /// state](crate::linear::static_state). The work grows with the sixth power of the degrees of freedom;
    /// at most 63 are allowed.
    ///
    /// # Errors
    /// A state or a noise that does not fit the model; [`LinearError::NotFinite`];
    /// [`LinearError::Grows`] and [`LinearError::MeanSquareGrows`] if there are no stationary moments.
    pub fn about(model: &dyn Model, state: &State, noise: &[WhiteNoise]) -> Result<Self, LinearError> {
        let n = model.dof();
        check::at_least("degrees of freedom", n, 1)?;
        let unknowns = n.saturating_mul(n.saturating_mul(2).saturating_add(1));
        check::count("second moments of the model, squared", &[unknowns, unknowns], check::NUMBERS)?;
        state.check(n)?;
        noise.iter().try_for_each(|noise| noise.check(model).map(drop))?;
        let motion = Motion::new(model, state, noise)?;
        motion.check_decay()?;
        let mean = motion.mean()?;
        // Below the smallest normal number a moment has no digits, and a variance may come out negative.
        let digits = |x: f64| if x.abs() < f64::MIN_POSITIVE { 0.0 } else { x };
        let covariance = motion.covariance(&mean)?.map(digits);
        let largest = covariance.iter().chain(&mean).fold(0.0, |sum: f64, x| sum + x.abs());
        check::representable("covariance of the model", largest, noise.iter().map(|noise| &noise.intensity))?;
        let (q, v) = mean.as_slice().split_at(n);
        let plus = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x + y).collect();
        Ok(LinearMoments {
            mean: State { t: state.t, q: plus(&state.q, q), v: plus(&state.v, v) },
            covariance,
        })
    }

    /// The mean of coordinates and velocities.
    pub fn mean(&self) -> &State {
        &self.mean
    }
    /// The covariance, with a row and a column for each coordinate, then for each velocity.
    pub fn covariance(&self) -> &DMatrix<f64> {
        &self.covariance
    }
}

/// slope · y + value.
struct Affine {
    slope: DMatrix<f64>,
    value: DVector<f64>,
}

/// The linearised motion y' = A y + b + Σ (B y + g) ξ, with √D in B and g.
struct Motion {
    drift: Affine,
    noise: Vec<Affine>,
}

impl Motion {
    fn new(model: &dyn Model, state: &State, noise: &[WhiteNoise]) -> Result<Self, LinearError> {
        let (n, State { t, q, v }) = (model.dof(), state);
        let mut u = vec![0.0; model.drives()];
        model.drive(*t, Side::After, &mut u);
        let mut contacts = vec![Contact::default(); model.contacts()];
        model.contact(&u, q, v, &mut contacts);
        let pieces: Vec<Piece> = contacts.iter().map(Contact::piece).collect();
        if Modes::about(model, state, Some(&pieces))?.rigid_count() > 0 {
            return Err(LinearError::Grows { rate: 0.0 });
        }
        let mut slopes = Slopes::new(model, vec![1.0; 2 * n], 0.0);
        let mut under = |u: &[f64]| {
            slopes.at(Some(&pieces), u, q, v);
            let mut rates = [&v[..], &vec![0.0; n]].concat();
            accelerate(model, Some(&pieces), u, q, v, &mut rates[n..]);
            let mut slope = DMatrix::zeros(2 * n, 2 * n);
            slope.view_mut((0, n), (n, n)).fill_with_identity();
            slope.view_mut((n, 0), (n, n)).copy_from(&slopes.jacobian.q);
            slope.view_mut((n, n), (n, n)).copy_from(&slopes.jacobian.v);
            Affine { slope, value: DVector::from_vec(rates) }
        };
        let still = under(&u);
        let mut drift = Affine { slope: still.slope.clone(), value: still.value.clone() };
        let mut sources = Vec::with_capacity(noise.len());
        for WhiteNoise { target, intensity } in noise {
            let size = intensity.sqrt();
            let source = match target {
                Target::Bath { coordinate, damping } => {
                    let i = n + coordinate;
                    drift.slope[(i, i)] -= damping;
                    drift.value[i] -= damping * v[*coordinate];
                    let mut value = DVector::zeros(2 * n);
                    value[i] = size;
                    Affine { slope: DMatrix::zeros(2 * n, 2 * n), value }
                }
                Target::Drives(slots) => {
                    let (u, unit) = WhiteNoise::unit_on(slots, &u);
                    let Affine { slope, value } = under(&u);
                    let (slope, value) = (slope - &still.slope, value - &still.value);
                    Affine { slope: slope * (size / unit), value: value * (size / unit) }
                }
            };
            // From Stratonovich to Ito.
            drift.slope += &source.slope * &source.slope * 0.5;
            drift.value += &source.slope * &source.value * 0.5;
            sources.push(source);
        }
        let all = sources.iter().chain([&drift]).flat_map(|x| x.slope.iter().chain(&x.value));
        if all.into_iter().any(|x| !x.is_finite()) {
            return Err(LinearError::NotFinite { t: *t });
        }
        Ok(Motion { drift, noise: sources })
    }

    /// Checks that A is stable.
    fn check_decay(&self) -> Result<(), LinearError> {
        let a = &self.drift.slope;
        let (rows, n) = (a.nrows(), a.nrows() / 2);
        // Time in units of 1/ω, so that coordinates and velocities have the same size.
        let [stiffness, damping] = [0, n].map(|column| a.view((n, column), (n, n)).amax());
        let omega = stiffness.sqrt().max(damping).max(f64::MIN_POSITIVE);
        let unit = |i: usize| if i < n { 1.0 } else { omega };
        let scaled = faer::Mat::from_fn(rows, rows, |i, j| a[(i, j)] / omega * (unit(j) / unit(i)));
        let values = scaled.eigenvalues().map_err(|_| LinearError::NotConverged { rows })?;
        let rate = values.iter().map(|value| value.re).fold(f64::NEG_INFINITY, f64::max);
        // The zeros of motions without damping are known to rounding only.
        if rate < -1e-12 { Ok(()) } else { Err(LinearError::Grows { rate: rate * omega }) }
    }

    /// m = -A⁻¹ b.
    fn mean(&self) -> Result<DVector<f64>, LinearError> {
        let Affine { slope, value } = &self.drift;
        let mut a = Matrix::dense(value.len());
        (0..value.len()).for_each(|j| a.column_mut(j).copy_from_slice(slope.column(j).as_slice()));
        let mut mean = -value;
        let factors = Factors::new(&a).map_err(|_: Floating| LinearError::Grows { rate: 0.0 })?;
        factors.solve(mean.as_mut_slice());
        Ok(mean)
    }

    /// The covariance about a mean.
    fn covariance(&self, mean: &DVector<f64>) -> Result<DMatrix<f64>, LinearError> {
        let size = mean.len();
        let moments: Vec<[usize; 2]> = (0..size).flat_map(|i| (0..=i).map(move |j| [i, j])).collect();
        let a = &self.drift.slope;
        let mut operator = Matrix::dense(moments.len());
        for (column, &[k, l]) in moments.iter().enumerate() {
            // P has the entries kl and lk: one if k = l.
            let share = if k == l { 0.5 } else { 1.0 };
            for (to, &[i, j]) in operator.column_mut(column).iter_mut().zip(&moments) {
                let of = |i: usize, j: usize, k: usize, l: usize| {
                    let drift = if j == l { a[(i, k)] } else { 0.0 } + if i == l { a[(j, k)] } else { 0.0 };
                    drift + self.noise.iter().map(|b| b.slope[(i, k)] * b.slope[(j, l)]).sum::<f64>()
                };
                *to = share * (of(i, j, k, l) + of(i, j, l, k));
            }
        }
        let factors = Factors::new(&operator).map_err(|_: Floating| LinearError::MeanSquareGrows)?;
        let solve = |right: &DMatrix<f64>| {
            let mut x: Vec<f64> = moments.iter().map(|&[i, j]| -right[(i, j)]).collect();
            factors.solve(&mut x);
            let place = |i: usize, j: usize| i.max(j) * (i.max(j) + 1) / 2 + i.min(j);
            DMatrix::from_fn(size, size, |i, j| x[place(i, j)])
        };
        if solve(&DMatrix::identity(size, size)).cholesky().is_none() {
            return Err(LinearError::MeanSquareGrows);
        }
        let mut excitation = DMatrix::zeros(size, size);
        for Affine { slope, value } in &self.noise {
            let h = slope * mean + value;
            excitation += &h * h.transpose();
        }
        Ok(solve(&excitation))
    }
}
