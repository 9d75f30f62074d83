//! Nothing: what every program has.

fn main() {}
