//! Mass, damping, stiffness and mesh matrix of the ring, and its modes.

use crate::contact::laws::nonlinearity::Nonlinearity;
use crate::error::{ParameterError, check};
use crate::models::ring::ring_params::mean;
use crate::models::ring::ring_shape::Ring;
use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Undamped natural frequencies and modes of a ring, and its damped eigenvalues.
///
/// ```
/// use gear_dynamics::{Ring, models::ring::RingSet};
/// let ring = Ring::as_printed(&RingSet::set_a(3, 1000.0).params()?)?;
/// let modes = ring.modes(&ring.mean_mesh_stiffness())?;
/// assert!((modes.hertz()[1] - 43.173_249_56).abs() < 1e-7);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Modes {
    frequencies: Vec<f64>,
    shapes: DMatrix<f64>,
    eigenvalues: Vec<Complex64>,
}

impl Modes {
    /// Undamped natural frequencies [rad/s], increasing. The first is that of the rigid mode, zero.
    pub fn frequencies(&self) -> &[f64] {
        &self.frequencies
    }
    /// Undamped natural frequencies `[Hz]`, increasing.
    pub fn hertz(&self) -> Vec<f64> {
        self.frequencies.iter().map(|w| w / TAU).collect()
    }
    /// Undamped modes φ as columns, in the order of the frequencies, normalised to φᵀ M φ = 1.
    pub fn shapes(&self) -> &DMatrix<f64> {
        &self.shapes
    }
    /// Eigenvalues λ [rad/s] of the damped ring with positive imaginary part, in the order of |λ|.
    ///
    /// The natural frequency is |λ| and the damping ratio -Re λ/|λ|. Overdamped modes are not listed.
    pub fn eigenvalues(&self) -> &[Complex64] {
        &self.eigenvalues
    }
}

/// Largest frequency of a rigid mode, as a share of the highest frequency.
const RIGID: f64 = 1e-7;

impl<N: Nonlinearity> Ring<N> {
    /// Mass matrix M = diag(J_M, J_1, J_L1, ..., J_n, J_Ln) [kg m²].
    pub fn mass_matrix(&self) -> DMatrix<f64> {
        DMatrix::from_diagonal(&DVector::from_vec(self.shape().inertias()))
    }

    /// Mesh matrix B: the deflections of the links are B θ, for the meshes less their transmission error.
    ///
    /// The rows are the motor shaft, the n meshes and the n output shafts; the columns are the angles θ.
    pub fn mesh_matrix(&self) -> DMatrix<f64> {
        let n = self.gears();
        let mut b = DMatrix::zeros(2 * n + 1, 2 * n + 1);
        b[(0, 0)] = 1.0;
        b[(0, 1)] = -1.0;
        for i in 0..n {
            let j = (i + 1) % n;
            b[(1 + i, 1 + 2 * i)] = self.shape().gears[i].base_radius;
            b[(1 + i, 1 + 2 * j)] = -self.shape().gears[j].base_radius;
            b[(1 + n + i, 1 + 2 * i)] = 1.0;
            b[(1 + n + i, 2 + 2 * i)] = -1.0;
        }
        b
    }

    /// Stiffnesses of the links: motor shaft, the given meshes, output shafts.
    pub(crate) fn link_stiffnesses(&self, mesh_stiffness: &[f64]) -> Result<Vec<f64>, ParameterError> {
        check::length("mesh stiffnesses", mesh_stiffness.len(), self.gears())?;
        for (i, &k) in mesh_stiffness.iter().enumerate() {
            check::not_negative(format!("mesh stiffness [{i}]"), k)?;
        }
        let outputs = self.shape().gears.iter().map(|gear| gear.load.shaft.stiffness);
        Ok(std::iter::once(self.shape().motor_shaft.stiffness)
            .chain(mesh_stiffness.iter().copied())
            .chain(outputs)
            .collect())
    }

    /// Dampings of the links: motor shaft, meshes, output shafts.
    pub(crate) fn link_dampings(&self) -> Vec<f64> {
        let outputs = self.shape().gears.iter().map(|gear| gear.load.shaft.damping);
        let meshes = self.mesh_dampings().iter().copied();
        std::iter::once(self.shape().motor_shaft.damping).chain(meshes).chain(outputs).collect()
    }

    /// Bᵀ diag(links) B.
    fn assemble(&self, links: Vec<f64>) -> DMatrix<f64> {
        let b = self.mesh_matrix();
        b.transpose() * DMatrix::from_diagonal(&DVector::from_vec(links)) * b
    }

    /// Stiffness matrix K = Bᵀ k B [N m/rad] with all teeth in contact, for given mesh stiffnesses [N/m], one
    /// per mesh.
    ///
    /// # Errors
    /// A number of stiffnesses other than n; a stiffness that is negative or above 1e50.
    pub fn stiffness_matrix(&self, mesh_stiffness: &[f64]) -> Result<DMatrix<f64>, ParameterError> {
        Ok(self.assemble(self.link_stiffnesses(mesh_stiffness)?))
    }

    /// Damping matrix C = Bᵀ c B [N m s/rad].
    pub fn damping_matrix(&self) -> DMatrix<f64> {
        self.assemble(self.link_dampings())
    }

    /// Mean mesh stiffnesses [N/m]: the mean of each K_i(φ) over a mesh period.
    pub fn mean_mesh_stiffness(&self) -> Vec<f64> {
        self.shape().meshes.iter().map(|mesh| mean(mesh.stiffness())).collect()
    }

    /// Natural frequencies and modes with all teeth in contact, for given mesh stiffnesses [N/m], one per
    /// mesh.
    ///
    /// # Errors
    /// A number of stiffnesses other than n; a stiffness that is negative or above 1e50.
    /// [`ParameterError::NotFinite`] if the eigenvalue computation fails.
    pub fn modes(&self, mesh_stiffness: &[f64]) -> Result<Modes, ParameterError> {
        let k = self.stiffness_matrix(mesh_stiffness)?;
        let c = self.damping_matrix();
        let j = self.shape().inertias();
        let size = j.len();
        // The matrix M^(-1/2) K M^(-1/2) is symmetric.
        let root: Vec<f64> = j.iter().map(|j| j.sqrt()).collect();
        let scaled = faer::Mat::from_fn(size, size, |a, b| k[(a, b)] / (root[a] * root[b]));
        let failed =
            || ParameterError::NotFinite { name: "an eigenvalue of the ring".into(), value: f64::NAN };
        let eigen = scaled.self_adjoint_eigen(faer::Side::Lower).map_err(|_| failed())?;
        let frequencies: Vec<f64> = (0..size).map(|i| eigen.S().column_vector()[i].max(0.0).sqrt()).collect();
        let shapes = DMatrix::from_fn(size, size, |a, i| eigen.U()[(a, i)] / root[a]);
        // (Ω p, p')' = (Ω p', -Ω (Ω p) - D p') in the amplitudes p of the elastic modes. Both halves then
        // have one scale, and the rigid motion, of eigenvalue zero, is left out.
        let largest = frequencies.iter().copied().fold(0.0, f64::max);
        let elastic: Vec<usize> = (0..size).filter(|&i| frequencies[i] > RIGID * largest).collect();
        let damping = shapes.transpose() * c * &shapes;
        let m = elastic.len();
        let first_order = faer::Mat::from_fn(2 * m, 2 * m, |a, b| {
            let (i, j) = (elastic[a % m], elastic[b % m]);
            match (a < m, b < m) {
                (true, false) if i == j => frequencies[i],
                (false, true) if i == j => -frequencies[i],
                (false, false) => -damping[(i, j)],
                _ => 0.0,
            }
        });
        let all = first_order.eigenvalues().map_err(|_| failed())?;
        let mut eigenvalues: Vec<Complex64> =
            all.iter().filter(|l| l.im > 0.0).map(|l| Complex64::new(l.re, l.im)).collect();
        eigenvalues.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
        Ok(Modes { frequencies, shapes, eigenvalues })
    }
}
