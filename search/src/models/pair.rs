//! Dimensionless spur pairs.

use crate::draw::Draw;
use gear_dynamics::trains::{SpurPair, Train, TrainError};

/// A dimensionless spur pair: damping ratio, load, stiffness and error waves of two orders.
#[derive(Clone, Debug)]
pub struct Pair {
    /// Damping ratio ζ `[1]`, 0.01 to 0.1.
    pub zeta: f64,
    /// Load `[1]`, 0.02 to 0.6.
    pub load: f64,
    /// Stiffness waves: amplitudes of orders 1 and 2 `[1]`, within ±0.3.
    pub stiffness: [f64; 2],
    /// Error waves: amplitudes of orders 1 and 2 `[1]`, within ±0.3.
    pub error: [f64; 2],
}

impl Pair {
    /// Draws a pair.
    pub fn draw(draw: &mut Draw) -> Self {
        let (zeta, load) = (draw.within(0.01, 0.1), draw.within(0.02, 0.6));
        let mut wave = || [draw.within(-0.3, 0.3), draw.within(-0.3, 0.3)];
        let (stiffness, error) = (wave(), wave());
        Pair { zeta, load, stiffness, error }
    }
    /// Draws a pair that is parametrically unstable near the speed 1: the amplitude of the second order of its stiffness
    /// exceeds 4 ζ. Its forced branch can run to infinity there.
    pub fn draw_unstable(draw: &mut Draw) -> Self {
        let drawn = Pair::draw(draw);
        let zeta = draw.within(0.01, 0.04);
        let second = draw.one_of(&[-1.0, 1.0]) * draw.within(6.0 * zeta, 0.35);
        Pair { zeta, stiffness: [0.3 * drawn.stiffness[0], second], ..drawn }
    }
    /// Draws a pair that becomes parametrically unstable near the speed 1 if its damping ratio falls: the amplitude of the
    /// second order of its stiffness is less than 4 ζ. A fold of its forced branch runs to infinity then.
    pub fn draw_damped(draw: &mut Draw) -> Self {
        let drawn = Pair::draw(draw);
        // Pairs with more damping seldom have a fold that lasts, light loads seldom settle.
        let (zeta, load) = (draw.within(0.02, 0.05), draw.within(0.2, 0.6));
        let second = draw.one_of(&[-1.0, 1.0]) * draw.within(3.0, 3.9) * zeta;
        Pair { zeta, load, stiffness: [0.3 * drawn.stiffness[0], second], ..drawn }
    }
    /// The train at a speed `[1]`.
    pub fn at(&self, speed: f64) -> Result<Train, TrainError> {
        let pair = SpurPair::of_numbers(self.zeta, self.load, &self.stiffness, &self.error)?;
        pair.parts()?.build("driver", speed)
    }
}
