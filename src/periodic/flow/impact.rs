//! Impacts along a motion, and what their derivatives need.

use crate::model::equations::Model;
use crate::ode::edges::stops::Flight;

/// What the derivative of an impact is taken in.
pub(crate) struct Impact {
    pub(crate) u: Vec<f64>,
    pub(crate) q: Vec<f64>,
    /// Velocities behind the impact, of the motion and of neighbours.
    pub(crate) behind: Vec<f64>,
    pub(crate) v: Vec<f64>,
    /// ∂V along the direction (-share, δq, δv).
    pub(crate) slope: Vec<f64>,
    pub(crate) direction: [Vec<f64>; 2],
    pub(crate) flights: Vec<Flight>,
}

impl Impact {
    pub(crate) fn new<M: Model + ?Sized>(model: &M) -> Self {
        let zeros = || vec![0.0; model.dof()];
        let flights = vec![Flight::NONE; model.contacts()];
        Impact {
            flights,
            u: vec![0.0; model.drives()],
            q: zeros(),
            behind: zeros(),
            v: zeros(),
            slope: zeros(),
            direction: [zeros(), zeros()],
        }
    }
}
