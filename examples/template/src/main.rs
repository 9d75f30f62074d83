//! The periodic motion of a spur pair, followed over its speed.

use gear_dynamics::branches::{Continuation, Family};
use gear_dynamics::trains::SpurPair;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Damping ratio, load, harmonics of the mesh stiffness and of the transmission error.
    let pair = SpurPair::of_numbers(0.05, 0.1, &[0.2], &[0.05])?.parts()?.build("driver", 1.0)?;
    let branch = Continuation::new(0.4, 1.4).run(&Family::over(&pair, ["speed"])?, None)?;
    println!("{branch}");
    Ok(())
}
