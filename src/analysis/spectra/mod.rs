//! Amplitudes and densities over the frequency or the order.

pub(crate) mod density;
pub(crate) mod spectrum;
pub(crate) mod waterfall;
pub(crate) mod welch;
pub(crate) mod window;
