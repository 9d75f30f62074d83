//! Times of the integrators of `gear-dynamics` compared with those of the crates `ode_solvers` and
//! `differential-equations` and with loops written by hand: `cargo bench -p peers`. The problems are workload
//! A, the rattling gear pair, and B3 and B16, rings of 3 and 16 gears. All entrants get the same right-hand
//! side, start, end, fixed step and tolerances, and the error at the end is printed.
//!
//! The crate itself is empty and is not published. It keeps the other crates out of the dependencies of
//! `gear-dynamics`.
