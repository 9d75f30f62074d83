//! Gear models: the noncircular face gear pair and the closed-loop ring.

mod nfg;
mod ring;

pub use nfg::{
    CentreForcing, Damping, ErrorForcing, HalfWidth, NfgPair, NfgPair2, NfgParams, NfgReading, NfgShape,
    NfgShape2, Radius,
};
pub use ring::{Frame, Gear, Load, Modes, Motor, RelativeView, Ring, RingParams, RingSet, RingShape, Shaft};
