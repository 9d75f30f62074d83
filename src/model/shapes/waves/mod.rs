//! The waves of a machine as finite Fourier series: in numbers, series and lanes.

pub(crate) mod fourier_angle;
pub(crate) mod fourier_waves;
pub(crate) mod sampled_waves;
pub(crate) mod wave_series;
pub(crate) mod waves_of_lanes;
