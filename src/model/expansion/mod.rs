//! What a model offers to [`Taylor`](crate::Taylor): its algebra as a tape, its drives as series.

pub(crate) mod enclosed;
pub(crate) mod every_piece;
pub(crate) mod expand;
pub(crate) mod fourier_angle;
pub(crate) mod fourier_waves;
pub(crate) mod machine_tape;
pub(crate) mod sampled_waves;
pub(crate) mod wave_series;
pub(crate) mod waves_of_lanes;
