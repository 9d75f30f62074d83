//! Harmonic balance: periodic orbits as Fourier series, with estimates of their errors.

pub(crate) mod admission;
pub(crate) mod amplitudes;
pub(crate) mod balance_error;
pub(crate) mod crossings;
pub(crate) mod equations;
pub(crate) mod fourier_orbit;
pub(crate) mod integrals;
pub(crate) mod integration;
pub(crate) mod note;
pub(crate) mod quadrature;
pub(crate) mod quality;
pub(crate) mod reading;
pub(crate) mod series;
pub(crate) mod settings;
pub(crate) mod solve;
