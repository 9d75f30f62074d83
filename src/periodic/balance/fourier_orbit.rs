//! A periodic orbit as Fourier coefficients.

use crate::error::{ParameterError, check};
use crate::model::State;
use crate::numeric::norms::largest;
use crate::periodic::balance::note::BalanceNote;
use crate::periodic::balance::series::harmonics::Harmonics;
use crate::periodic::balance::series::transform::{Transform, read, samples_for, spread, write};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// q_j(t) = Σ_k c_jk cos(k ω t) + s_jk sin(k ω t): a periodic orbit, with notes on its reliability.
///
/// ```
/// use gear_dynamics::{Harmonics, periodic::FourierOrbit};
/// let orbit = FourierOrbit::new(&Harmonics::up_to(1), 4.0, &[vec![0.5, 3.0, -4.0]])?;
/// assert_eq!(orbit.amplitude(0, 1), 5.0);
/// assert_eq!(orbit.at(0.0).q, [3.5]);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, PartialEq)]
pub struct FourierOrbit {
    pub(crate) harmonics: Harmonics,
    pub(crate) period: f64,
    pub(crate) coefficients: Vec<f64>,
    pub(crate) mean_acceleration: Vec<f64>,
    pub(crate) mean_velocity: Vec<f64>,
    pub(crate) notes: Vec<BalanceNote>,
    pub(crate) iterations: usize,
    pub(crate) evaluations: usize,
    pub(crate) residual: f64,
}

/// Omits the coefficients, of which there may be thousands.
impl std::fmt::Debug for FourierOrbit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("FourierOrbit")
            .field("dof", &self.dof())
            .field("orders", &self.harmonics.orders().len())
            .field("highest", &self.harmonics.highest())
            .field("period", &self.period)
            .field("iterations", &self.iterations)
            .field("residual", &self.residual)
            .field("notes", &self.notes)
            .finish_non_exhaustive()
    }
}

impl FourierOrbit {
    /// Orbit from the coefficients of every coordinate, in the sequence of [`Harmonics`]. `period` is the
    /// period of the orbit, in the time unit of the model.
    ///
    /// # Errors
    /// [`ParameterError`] for a period that is not in [1e-50, 1e50], lists of the wrong length, coefficients
    /// beyond ±1e50, or orders above [`Harmonics::HIGHEST`].
    pub fn new(
        harmonics: &Harmonics,
        period: f64,
        coefficients: &[Vec<f64>],
    ) -> Result<Self, ParameterError> {
        harmonics.check()?;
        check::scale("period", period)?;
        for (j, list) in coefficients.iter().enumerate() {
            check::length(format!("coefficients of coordinate {j}"), list.len(), harmonics.unknowns())?;
            check::quantities(&format!("coefficients of coordinate {j}"), list)?;
        }
        Ok(FourierOrbit::of(harmonics, period, coefficients.concat(), coefficients.len()))
    }

    pub(crate) fn of(harmonics: &Harmonics, period: f64, coefficients: Vec<f64>, dof: usize) -> Self {
        FourierOrbit {
            harmonics: harmonics.clone(),
            period,
            coefficients,
            mean_acceleration: vec![0.0; dof],
            mean_velocity: vec![0.0; dof],
            notes: Vec::new(),
            iterations: 0,
            evaluations: 0,
            residual: f64::NAN,
        }
    }

    /// The same orbit with other orders: missing coefficients are zero, others are dropped. The number of
    /// periods of the model in one base period may change.
    pub fn on(&self, harmonics: &Harmonics) -> Self {
        let n = self.dof();
        let mut coefficients = vec![0.0; n * harmonics.unknowns()];
        // Order k is k/p times the frequency of the model, and p may differ.
        let (mine, theirs) = (self.harmonics.period_multiple(), harmonics.period_multiple());
        for (j, part) in coefficients.chunks_exact_mut(harmonics.unknowns()).enumerate() {
            for (i, &order) in harmonics.orders().iter().enumerate() {
                if order * mine % theirs == 0 {
                    write(&mut part[harmonics.place(i)..], order, self.complex(j, order * mine / theirs));
                }
            }
        }
        FourierOrbit {
            mean_acceleration: self.mean_acceleration.clone(),
            mean_velocity: self.mean_velocity.clone(),
            ..FourierOrbit::of(harmonics, self.period / mine as f64 * theirs as f64, coefficients, n)
        }
    }

    /// The same orbit without the orders above `highest`; `None` if no order is left.
    pub(crate) fn below(&self, highest: usize) -> Option<Self> {
        let orders: Vec<usize> = self.harmonics.orders().iter().copied().filter(|&k| k <= highest).collect();
        Harmonics::of_orders(&orders)
            .and_then(|h| h.with_period_multiple(self.harmonics.period_multiple()))
            .ok()
            .map(|harmonics| self.on(&harmonics))
    }

    /// Orders of the series.
    pub fn harmonics(&self) -> &Harmonics {
        &self.harmonics
    }

    /// Number of coordinates.
    pub fn dof(&self) -> usize {
        self.mean_acceleration.len()
    }

    /// Period of the orbit: p periods of the model.
    pub fn period(&self) -> f64 {
        self.period
    }

    /// Base frequency ω = 2π/period, in radians per time unit of the model.
    pub fn frequency(&self) -> f64 {
        TAU / self.period
    }

    /// Coefficients of coordinate j: [mean, c_k, s_k, ...] with increasing k; no mean without order 0.
    ///
    /// # Panics
    /// If there is no coordinate j.
    pub fn coefficients(&self, j: usize) -> &[f64] {
        let width = self.harmonics.unknowns();
        &self.coefficients[j * width..(j + 1) * width]
    }

    pub(crate) fn all_coefficients(&self) -> &[f64] {
        &self.coefficients
    }

    /// Q_k of Σ_k Q_k e^{i k ω t}: the mean for k = 0, otherwise (c_k - i s_k)/2.
    fn complex(&self, j: usize, order: usize) -> Complex64 {
        read(self.coefficients(j), &self.harmonics, order)
    }

    /// Mean of coordinate j; 0 if order 0 is not kept.
    ///
    /// # Panics
    /// If there is no coordinate j.
    pub fn mean(&self, j: usize) -> f64 {
        self.complex(j, 0).re
    }

    /// A in A cos(k ω t + φ) of coordinate j; |mean| for order 0, and 0 for an order that is not kept.
    ///
    /// # Panics
    /// If there is no coordinate j.
    pub fn amplitude(&self, j: usize, order: usize) -> f64 {
        if order == 0 { self.mean(j).abs() } else { 2.0 * self.complex(j, order).norm() }
    }

    /// φ in A cos(k ω t + φ) of coordinate j `[rad]`.
    ///
    /// # Panics
    /// If there is no coordinate j.
    pub fn phase(&self, j: usize, order: usize) -> f64 {
        self.complex(j, order).arg()
    }

    /// State at time `t`, for example as the start of a run. A rigid motion with a mean acceleration starts
    /// from rest at t = 0.
    pub fn at(&self, t: f64) -> State {
        let mut state = State { t, ..State::at_rest(self.dof()) };
        self.motion(t, &mut state.q, &mut state.v);
        state
    }

    /// Computes coordinates and velocities at time `t`.
    pub(crate) fn motion(&self, t: f64, q: &mut [f64], v: &mut [f64]) {
        self.motions([t], turned([t / self.period]), q.as_chunks_mut().0, v.as_chunks_mut().0);
    }

    /// Computes coordinates and velocities at several instants together. `turn` holds sin ωt and cos ωt at
    /// the instants.
    pub(crate) fn motions<const K: usize>(
        &self,
        t: [f64; K],
        turn: [[f64; K]; 2],
        q: &mut [[f64; K]],
        v: &mut [[f64; K]],
    ) {
        let (omega, means) = (self.frequency(), usize::from(self.harmonics.has_mean()));
        let orders = &self.harmonics.orders()[means..];
        let first = orders.first().copied().unwrap_or(0);
        let at_first = match first {
            0 | 1 => turn,
            _ => turned(t.map(|t| first as f64 * (t / self.period).fract())),
        };
        for (j, rigid) in self.mean_acceleration.iter().enumerate() {
            let (mean, pairs) = self.coefficients(j).split_at(means);
            let (mut sum, mut rate) = ([mean.iter().sum::<f64>(); K], [0.0; K]);
            let ([mut sin, mut cos], mut here) = (at_first, first);
            for (&order, pair) in orders.iter().zip(pairs.as_chunks::<2>().0) {
                if order - here > FAR {
                    [sin, cos] = turned(t.map(|t| order as f64 * (t / self.period).fract()));
                    here = order;
                }
                while here < order {
                    here += 1;
                    for k in 0..K {
                        (sin[k], cos[k]) = (
                            sin[k] * turn[1][k] + cos[k] * turn[0][k],
                            cos[k] * turn[1][k] - sin[k] * turn[0][k],
                        );
                    }
                }
                for k in 0..K {
                    sum[k] += pair[0] * cos[k] + pair[1] * sin[k];
                    rate[k] += order as f64 * (pair[1] * cos[k] - pair[0] * sin[k]);
                }
            }
            for k in 0..K {
                let speed = self.mean_velocity[j] + rigid * t[k];
                q[j][k] = sum[k] + (speed - 0.5 * rigid * t[k]) * t[k];
                v[j][k] = omega * rate[k] + speed;
            }
        }
    }

    /// States at `count` uniform instants over one period, from t = 0: a guess for
    /// [`Shooting`](crate::Shooting).
    ///
    /// # Errors
    /// [`ParameterError`] for more than 2²⁶ numbers.
    pub fn states(&self, count: usize) -> Result<Vec<State>, ParameterError> {
        check::count("numbers of the states", &[count, 2 * self.dof()], check::NUMBERS)?;
        Ok((0..count).map(|i| self.at(self.period * i as f64 / count as f64)).collect())
    }

    /// Mean acceleration of every coordinate. It is zero unless the model has a rigid motion and the torques
    /// along it do not balance.
    pub fn mean_acceleration(&self) -> &[f64] {
        &self.mean_acceleration
    }

    /// Mean velocity of every coordinate. It is zero unless only the velocity acts along a direction of the
    /// model, as that of a rotor that a drag holds.
    pub fn mean_velocity(&self) -> &[f64] {
        &self.mean_velocity
    }

    /// Notes on the reliability of the orbit.
    pub fn notes(&self) -> &[BalanceNote] {
        &self.notes
    }

    /// Number of iterations of the root finder.
    pub fn iterations(&self) -> usize {
        self.iterations
    }

    /// Number of residuals that the root finder evaluated.
    pub fn evaluations(&self) -> usize {
        self.evaluations
    }

    /// Largest residual of the balance `[1/time²]`: a coefficient of q'' - a over the size of its coordinate.
    /// After convergence it is small compared with the square of the highest kept frequency. NaN for an orbit
    /// that no balance computed.
    pub fn residual(&self) -> f64 {
        self.residual
    }

    /// Whether one of the notes is a warning.
    pub fn is_doubtful(&self) -> bool {
        self.notes.iter().any(BalanceNote::is_warning)
    }

    /// max_j max_t |q_j - r_j|/range_j `[1]`: the distance of two orbits q and r over one period.
    ///
    /// range_j is the peak-to-peak value of q_j. For a coordinate at rest it is the largest peak-to-peak
    /// value, and if all are at rest the largest |mean|. The orbits are compared at equal shares of their
    /// periods. Rigid motions in the series count;
    /// [`mean_acceleration`](FourierOrbit::mean_acceleration) and
    /// [`mean_velocity`](FourierOrbit::mean_velocity) do not. Infinite if the numbers of
    /// coordinates differ or a difference is not finite.
    pub fn distance(&self, other: &FourierOrbit) -> f64 {
        let n = self.dof();
        if other.dof() != n {
            return f64::INFINITY;
        }
        let ranges: Vec<f64> = (0..n).map(|j| self.peak_to_peak(j)).collect();
        let moving = largest(&ranges);
        let most =
            if moving > 0.0 { moving } else { (0..n).fold(0.0, |m: f64, j| m.max(self.mean(j).abs())) };
        let m = samples_for(self.harmonics.highest().max(other.harmonics.highest()));
        let mut transform = Transform::new(m);
        let (mut a, mut b) = (vec![Complex64::ZERO; m], vec![Complex64::ZERO; m]);
        let mut worst = 0.0f64;
        for (j, range) in ranges.iter().enumerate() {
            spread(self.coefficients(j), &self.harmonics, 0.0, &mut a);
            spread(other.coefficients(j), &other.harmonics, 0.0, &mut b);
            a.iter_mut().zip(&b).for_each(|(a, b)| *a -= b);
            transform.synthesise(&mut a);
            let apart = a
                .iter()
                .fold(0.0, |m: f64, a| if a.re.is_finite() { m.max(a.re.abs()) } else { f64::INFINITY });
            if apart.is_infinite() {
                return f64::INFINITY;
            }
            if apart > 0.0 {
                worst = worst.max(apart / if *range > AT_REST * most { *range } else { most });
            }
        }
        worst
    }
}

/// Between orders further apart than this, sin kωt and cos kωt are computed anew instead of by rotation.
const FAR: usize = 1000;

/// sin 2πx and cos 2πx for several x.
pub(crate) fn turned<const K: usize>(x: [f64; K]) -> [[f64; K]; 2] {
    let turned = x.map(|x| libm::sincos(TAU * x.fract()));
    [turned.map(|(sin, _)| sin), turned.map(|(_, cos)| cos)]
}

/// Approximate extreme between two samples q + i v at a distance h in time: the value of the cubic Hermite
/// polynomial at the zero of the linearly interpolated velocity.
pub(crate) fn hermite_extreme(a: Complex64, b: Complex64, h: f64) -> f64 {
    let theta = a.im / (a.im - b.im);
    let (p, q) = (theta, 1.0 - theta);
    let value = |p: f64, q: f64| {
        a.re * q * q * (1.0 + 2.0 * p) + b.re * p * p * (1.0 + 2.0 * q) + h * p * q * (a.im * q - b.im * p)
    };
    value(p, q)
}

/// A coordinate below this share of the largest one is at rest `[1]`.
pub(crate) const AT_REST: f64 = 1e-6;
