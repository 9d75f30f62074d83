//! The noncircular face gear pair of Liu 2021.

pub mod from_rest;
mod motions;
pub mod orders;
pub mod outcomes;
pub mod parameters;
pub mod portraits;
pub mod roots;
mod sweeps;
pub mod table2;
