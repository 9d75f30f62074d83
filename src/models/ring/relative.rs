//! The dimensionless relative coordinates of Yao 2020, computed from the angles of the ring.

use crate::contact::Nonlinearity;
use crate::error::{ParameterError, check};
use crate::excitation::Side;
use crate::model::State;
use crate::models::ring::ring_shape::Ring;
use nalgebra::DMatrix;

/// The relative coordinates [θ_M - θ_1, d_1/b_e, ..., d_n/b_e, θ_1 - θ_L1, ..., θ_n - θ_Ln] over τ = ω_n t.
/// For n = 3 they are q1 .. q7 of Yao 2020.   Source: Yao 2020, Eqs. (2), (3), corrected.
///
/// The mesh coordinates are redundant: at every instant their sum is -Σ e_i(t)/b_e (the closure of the ring).
/// A state that violates the closure drifts without bound and is rejected; [`close`](RelativeView::close)
/// corrects it.
///
/// ```
/// use gear_dynamics::{Ring, models::ring::RingSet};
/// let ring = Ring::as_printed(&RingSet::set_a(3, 1000.0).params()?)?;
/// let view = ring.relative(2.65e-5, 1000.0)?;
/// let (mut q, mut v) = (vec![0.0; 7], vec![0.0; 7]);
/// assert!(view.to_angles(0.0, &q, &v).is_err()); // zero rates violate the closure, since e' is not zero
/// view.close(0.0, &mut q, &mut v)?;
/// assert!(view.to_angles(0.0, &q, &v).is_ok());
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct RelativeView<'r, N> {
    ring: &'r Ring<N>,
    length: f64,
    frequency: f64,
}

/// Maximum error of the closure, relative to its largest term.
const CLOSURE: f64 = 1e-9;

impl<N: Nonlinearity> Ring<N> {
    /// The relative coordinates of this ring, for a nominal length b_e `[m]` and a frequency ω_n [rad/s].
    ///
    /// # Errors
    /// A nominal length or a frequency outside 1e-50 .. 1e50.
    pub fn relative(&self, nominal_size: f64, frequency: f64) -> Result<RelativeView<'_, N>, ParameterError> {
        Ok(RelativeView {
            ring: self,
            length: check::scale("nominal size b_e", nominal_size)?,
            frequency: check::scale("frequency omega_n", frequency)?,
        })
    }
}

impl<N: Nonlinearity> RelativeView<'_, N> {
    /// Unit of each relative coordinate: 1 rad for shafts, b_e `[m]` for meshes.
    fn units(&self) -> Vec<f64> {
        let n = self.ring.gears();
        (0..2 * n + 1).map(|i| if (1..=n).contains(&i) { self.length } else { 1.0 }).collect()
    }

    /// The transmission errors e_i `[m]` and their rates e_i' [m/s] at t `[s]`.
    fn errors(&self, t: f64) -> Vec<(f64, f64)> {
        let speed = self.ring.speed();
        let jets = self.ring.shape().meshes.iter().map(|mesh| mesh.error().jet(speed * t, Side::After));
        jets.map(|jet| (jet.value, speed * jet.rate)).collect()
    }

    /// Relative coordinates and their rates over τ of a state in angles.
    ///
    /// # Panics
    /// If the state does not have 2n + 1 coordinates and velocities.
    pub fn of(&self, state: &State) -> (Vec<f64>, Vec<f64>) {
        let b = self.ring.mesh_matrix();
        let units = self.units();
        assert_eq!((state.q.len(), state.v.len()), (units.len(), units.len()), "coordinates, velocities");
        let errors = self.errors(state.t);
        let row = |x: &[f64], i: usize| (0..x.len()).map(|j| b[(i, j)] * x[j]).sum::<f64>();
        let error = |i: usize| {
            if i >= 1 && i <= errors.len() { errors[i - 1] } else { (0.0, 0.0) }
        };
        let q = (0..units.len()).map(|i| (row(&state.q, i) - error(i).0) / units[i]).collect();
        let v =
            (0..units.len()).map(|i| (row(&state.v, i) - error(i).1) / (units[i] * self.frequency)).collect();
        (q, v)
    }

    /// Sets the last mesh coordinate and its rate such that the closure holds at t `[s]`.
    ///
    /// # Errors
    /// A number of coordinates or rates other than 2n + 1.
    pub fn close(&self, t: f64, q: &mut [f64], v: &mut [f64]) -> Result<(), ParameterError> {
        let n = self.ring.gears();
        check::length("relative coordinates", q.len(), 2 * n + 1)?;
        check::length("relative rates", v.len(), 2 * n + 1)?;
        let (e, rate) = self.closure(t);
        q[n] = e - q[1..n].iter().sum::<f64>();
        v[n] = rate - v[1..n].iter().sum::<f64>();
        Ok(())
    }

    /// The sums of the mesh coordinates and of their rates that the closure requires: -Σ e_i/b_e and
    /// -Σ e_i'/(b_e ω_n).
    fn closure(&self, t: f64) -> (f64, f64) {
        let sum = self.errors(t).iter().fold((0.0, 0.0), |sum, e| (sum.0 + e.0, sum.1 + e.1));
        (-sum.0 / self.length, -sum.1 / (self.length * self.frequency))
    }

    /// The state in angles, with θ_1 = 0 and θ_1' = 0, because relative coordinates do not determine the
    /// rigid motion.
    ///
    /// # Errors
    /// A number of coordinates or rates other than 2n + 1, or a value beyond ±1e50.
    /// [`ParameterError::Inconsistent`] if the error of the closure exceeds 1e-9 of its largest term.
    pub fn to_angles(&self, t: f64, q: &[f64], v: &[f64]) -> Result<State, ParameterError> {
        let n = self.ring.gears();
        check::length("relative coordinates", q.len(), 2 * n + 1)?;
        check::length("relative rates", v.len(), 2 * n + 1)?;
        check::quantities("relative coordinates", q)?;
        check::quantities("relative rates", v)?;
        let (e, rate) = self.closure(t);
        for (name, x, expected) in [
            ("closure of the ring, the sum of the mesh coordinates,", q, e),
            ("closure of the ring, the sum of the mesh rates,", v, rate),
        ] {
            let found: f64 = x[1..=n].iter().sum();
            let size = x[1..=n].iter().fold(expected.abs(), |m, x| m.max(x.abs()));
            if (found - expected).abs() > CLOSURE * size {
                return Err(ParameterError::Inconsistent { name: name.into(), found, expected });
            }
        }
        let errors = self.errors(t);
        let unroll = |x: &[f64], scale: f64, error: &dyn Fn(usize) -> f64| {
            let gears = &self.ring.shape().gears;
            let mut angles = vec![0.0; 2 * n + 1];
            angles[0] = scale * x[0];
            for i in 0..n {
                if i > 0 {
                    let moved = gears[i - 1].base_radius * angles[2 * i - 1]
                        - scale * self.length * x[i]
                        - error(i - 1);
                    angles[2 * i + 1] = moved / gears[i].base_radius;
                }
                angles[2 * i + 2] = angles[2 * i + 1] - scale * x[n + 1 + i];
            }
            angles
        };
        Ok(State { t, q: unroll(q, 1.0, &|i| errors[i].0), v: unroll(v, self.frequency, &|i| errors[i].1) })
    }

    /// The matrices ξ and k of q'' + 2 ξ q' + k g(q) = f in relative coordinates. g acts on the mesh
    /// coordinates only; shafts are linear. All terms are added: minus
    /// signs of the printed equations are in the entries.
    ///
    /// 2 ξ = U⁻¹ B M⁻¹ Bᵀ diag(c) U/ω_n,   k = U⁻¹ B M⁻¹ Bᵀ diag(K) U/ω_n²
    ///
    /// B: [mesh matrix](Ring::mesh_matrix); M: [mass matrix](Ring::mass_matrix); c, K: dampings and
    /// stiffnesses of the motor shaft, the n meshes and the n output shafts; U = diag(1 rad for shafts, b_e
    /// for meshes); b_e, ω_n: the arguments of [`Ring::relative`]. The given stiffnesses [N/m] are those of
    /// the n meshes; the others are those of the ring.   Source: Yao 2020, coefficient list under Eq. (2),
    /// corrected ([errata](crate::guide::errata)).
    ///
    /// # Errors
    /// A number of stiffnesses other than n; a stiffness that is negative or above 1e50.
    pub fn coefficients(
        &self,
        mesh_stiffness: &[f64],
    ) -> Result<(DMatrix<f64>, DMatrix<f64>), ParameterError> {
        let (dampings, stiffnesses) =
            (self.ring.link_dampings(), self.ring.link_stiffnesses(mesh_stiffness)?);
        let b = self.ring.mesh_matrix();
        let inverse = DMatrix::from_diagonal(
            &self.ring.shape().inertias().iter().map(|j| 1.0 / j).collect::<Vec<_>>().into(),
        );
        let coupling = &b * inverse * b.transpose();
        let units = self.units();
        let size = units.len();
        let w = self.frequency;
        let scaled = |links: &[f64], factor: f64| {
            DMatrix::from_fn(size, size, |i, j| coupling[(i, j)] * links[j] * units[j] / units[i] * factor)
        };
        Ok((scaled(&dampings, 0.5 / w), scaled(&stiffnesses, 1.0 / (w * w))))
    }
}
