//! Times the integrators of this workspace beside those of other crates, `ode_solvers` and `differential-equations`,
//! and loops written by hand, on the rattling gear pair that the benchmarks of `gear-dynamics` call workload A and on rings
//! of 3 and 16 gears, B3 and B16: the same right-hand side, start, end, fixed step and tolerances for everyone, with the
//! error of each at the end. The crate itself is empty and is not published; it keeps the other crates out of the
//! dependencies of `gear-dynamics`. Everything is in its benchmark, `cargo bench -p peers`.
