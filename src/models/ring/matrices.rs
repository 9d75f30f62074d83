//! Mass, damping, stiffness and mesh matrix of the ring.

use crate::contact::Nonlinearity;
use crate::error::{ParameterError, check};
use crate::models::ring::ring_shape::Ring;
use nalgebra::{DMatrix, DVector};

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
        self.shape().meshes.iter().map(|mesh| mesh.stiffness().mean()).collect()
    }
}
