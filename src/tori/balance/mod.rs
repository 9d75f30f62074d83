//! Balance of a torus: Fourier series in several angles.

pub(crate) mod angle_grid;
pub(crate) mod fit;
pub(crate) mod quality;
pub(crate) mod settings;
pub(crate) mod torus;
pub(crate) mod torus_equations;
pub(crate) mod torus_error;
pub(crate) mod wave_vectors;
