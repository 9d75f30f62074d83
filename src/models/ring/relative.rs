//! The paper's dimensionless relative coordinates as a view of the angles.

use crate::contact::laws::nonlinearity::Nonlinearity;
use crate::error::{ParameterError, check};
use crate::excitation::side::Side;
use crate::model::equations::State;
use crate::models::ring::shape::Ring;
use nalgebra::DMatrix;

/// [θ_M - θ_1, d_1/b_e, ..., d_n/b_e, θ_1 - θ_L1, ..., θ_n - θ_Ln] over τ = ω_n t: q1..q7 of the paper for n = 3.
///
/// The mesh coordinates are redundant: their sum is -Σ e_i(t)/b_e, always. A state that says otherwise drifts without bound, so it is
/// refused; [`close`](RelativeView::close) makes one consistent.   Source: Yao 2020, Eqs. (2), (3), corrected.
///
/// ```
/// use gear_dynamics::{Ring, models::ring::RingSet};
/// let ring = Ring::as_printed(&RingSet::a(3, 1000.0).params()?)?;
/// let view = ring.relative(2.65e-5, 1000.0)?;
/// let (mut q, mut v) = (vec![0.0; 7], vec![0.0; 7]);
/// assert!(view.to_angles(0.0, &q, &v).is_err()); // velocities at rest break the closure: e' is not zero
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

/// How closely the closure must be met, in units of the terms that enter it.
const CLOSURE: f64 = 1e-9;

impl<N: Nonlinearity> Ring<N> {
    /// Relative coordinates with nominal size b_e `[m]` and frequency ω_n [rad/s].
    ///
    /// # Errors
    /// A nominal size or a frequency outside 1e-50 .. 1e50.
    pub fn relative(&self, nominal_size: f64, frequency: f64) -> Result<RelativeView<'_, N>, ParameterError> {
        Ok(RelativeView {
            ring: self,
            length: check::scale("nominal size b_e", nominal_size)?,
            frequency: check::scale("frequency omega_n", frequency)?,
        })
    }
}

impl<N: Nonlinearity> RelativeView<'_, N> {
    /// Unit of each relative coordinate: 1 for shafts, b_e for meshes.
    fn units(&self) -> Vec<f64> {
        let n = self.ring.gears();
        (0..2 * n + 1).map(|i| if (1..=n).contains(&i) { self.length } else { 1.0 }).collect()
    }

    /// e_i and e_i' at t.
    fn errors(&self, t: f64) -> Vec<(f64, f64)> {
        let speed = self.ring.mesh_frequency();
        let jets = self.ring.shape().meshes.iter().map(|mesh| mesh.error().jet(speed * t, Side::After));
        jets.map(|jet| (jet.value, speed * jet.rate)).collect()
    }

    /// Relative coordinates and their rates over τ of a state in angles.
    ///
    /// # Panics
    /// If the state is not one of this ring.
    pub fn of(&self, state: &State) -> (Vec<f64>, Vec<f64>) {
        let b = self.ring.mesh_matrix();
        let units = self.units();
        assert_eq!((state.q.len(), state.v.len()), (units.len(), units.len()), "a state of another model");
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

    /// Sets the last mesh coordinate and its rate so that the ring closes.
    ///
    /// # Errors
    /// Coordinates or rates other than 2n + 1 in number.
    pub fn close(&self, t: f64, q: &mut [f64], v: &mut [f64]) -> Result<(), ParameterError> {
        let n = self.ring.gears();
        check::length("relative coordinates", q.len(), 2 * n + 1)?;
        check::length("relative rates", v.len(), 2 * n + 1)?;
        let (e, rate) = self.closure(t);
        q[n] = e - q[1..n].iter().sum::<f64>();
        v[n] = rate - v[1..n].iter().sum::<f64>();
        Ok(())
    }

    /// What the mesh coordinates and their rates have to sum to: -Σ e_i/b_e.
    fn closure(&self, t: f64) -> (f64, f64) {
        let sum = self.errors(t).iter().fold((0.0, 0.0), |sum, e| (sum.0 + e.0, sum.1 + e.1));
        (-sum.0 / self.length, -sum.1 / (self.length * self.frequency))
    }

    /// The state in angles, gear 1 at θ_1 = 0 and θ_1' = 0: the rigid motion is not in the relative coordinates.
    ///
    /// # Errors
    /// [`ParameterError::Inconsistent`] when the closure is not met.
    pub fn to_angles(&self, t: f64, q: &[f64], v: &[f64]) -> Result<State, ParameterError> {
        let n = self.ring.gears();
        check::length("relative coordinates", q.len(), 2 * n + 1)?;
        check::length("relative rates", v.len(), 2 * n + 1)?;
        check::quantities("relative coordinates", q)?;
        check::quantities("relative rates", v)?;
        let (e, rate) = self.closure(t);
        for (name, x, expected) in [("sum of the mesh coordinates", q, e), ("sum of the mesh rates", v, rate)]
        {
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

    /// The matrices ξ_ij and k_ij of q'' + 2 ξ q' + k g(q) = f with their signs: B M⁻¹ Bᵀ times the dampings and (given) mesh and
    /// shaft stiffnesses, in the units of the relative coordinates.   Source: Yao 2020, coefficient list under Eq. (2), corrected.
    ///
    /// # Errors
    /// Mesh stiffnesses not as many as meshes, negative or above 1e50.
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
