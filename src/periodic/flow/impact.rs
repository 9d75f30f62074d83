//! Scratch arrays for the derivative of an impact on a rigid stop.

use crate::model::Model;
use crate::ode::edges::stops::Flight;

/// Scratch arrays for the derivative of an impact. V are the velocities after the impact.
pub(crate) struct ImpactScratch {
    /// Drives, coordinates and velocities of a neighbouring motion at its impact.
    pub(crate) u: Vec<f64>,
    pub(crate) q: Vec<f64>,
    /// Velocities of the motion after the impact.
    pub(crate) after: Vec<f64>,
    pub(crate) v: Vec<f64>,
    /// Derivative of V along the direction (-σ, δq, δv); σ is the time by which a neighbour arrives earlier.
    pub(crate) slope: Vec<f64>,
    /// δq and δv of the direction.
    pub(crate) direction: [Vec<f64>; 2],
    /// The last impact of each contact.
    pub(crate) flights: Vec<Flight>,
}

impl ImpactScratch {
    /// Without `stops` the arrays are empty: there are no impacts.
    pub(crate) fn new(model: &dyn Model, stops: bool) -> Self {
        let [dof, drives, contacts] =
            [model.dof(), model.drives(), model.contacts()].map(|count| if stops { count } else { 0 });
        let zeros = || vec![0.0; dof];
        ImpactScratch {
            flights: vec![Flight::NONE; contacts],
            u: vec![0.0; drives],
            q: zeros(),
            after: zeros(),
            v: zeros(),
            slope: zeros(),
            direction: [zeros(), zeros()],
        }
    }
}
