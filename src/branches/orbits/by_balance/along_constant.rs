//! The derivative of a model with respect to a named constant, as a model.

use crate::contact::Piece;
use crate::model::drive_slope::DriveSlope;
use crate::model::{Jacobian, Model, Offers, Periodic};
use std::cell::RefCell;
use std::rc::Rc;

/// The accelerations da/dc = Σ_k ∂a/∂u_k ∂u_k/∂c + σ Σ_j ∂a/∂v_j v_j, with contacts and drives of the model.
///
/// It is the derivative at a fixed phase and fixed Fourier coefficients: the velocities grow with the speed
/// of the phase, dv/dc = σ v with σ = (∂φ'/∂c)/φ'.
pub(crate) struct AlongConstant<'f> {
    model: Rc<dyn Periodic + 'f>,
    slope: DriveSlope,
    scratch: RefCell<Scratch>,
}

struct Scratch {
    jacobian: Jacobian,
    y: Vec<f64>,
    a: [Vec<f64>; 2],
}

impl<'f> AlongConstant<'f> {
    /// `None` if the model has no named constants.
    pub(crate) fn new(model: &Rc<dyn Periodic + 'f>, constant: usize) -> Option<Self> {
        let (slope, n) = (model.offers().constants?.drive_slope(constant), model.dof());
        let scratch =
            Scratch { jacobian: Jacobian::new(n), y: vec![0.0; 2 * n], a: [vec![0.0; n], vec![0.0; n]] };
        Some(AlongConstant { model: model.clone(), slope, scratch: RefCell::new(scratch) })
    }

    /// σ.
    pub(crate) fn speed(&self) -> f64 {
        self.slope.speed
    }

    /// Σ_k ∂a/∂u_k ∂u_k/∂c.
    fn by_drives(&self, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        if let Some(constants) = self.model.offers().constants {
            constants.accel_along(&self.slope.drives, pieces, u, q, v, a);
        }
    }

    fn write(&self, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.by_drives(pieces, u, q, v, a);
        if self.slope.speed == 0.0 {
            return;
        }
        let jacobian = &mut self.scratch.borrow_mut().jacobian;
        self.model.jacobian(pieces, u, q, v, jacobian);
        for (j, v) in v.iter().enumerate() {
            a.iter_mut().zip(jacobian.v.column(j).iter()).for_each(|(a, b)| *a += self.slope.speed * b * v);
        }
    }
}

impl Model for AlongConstant<'_> {
    fn dof(&self) -> usize {
        self.model.dof()
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.write(None, u, q, v, a);
    }
    fn base(&self) -> Option<&dyn Model> {
        Some(&*self.model)
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: true, jacobian: true, ..Offers::default() }
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.write(Some(pieces), u, q, v, a);
    }
    /// Only for accelerations that are linear in coordinates and velocities: by differences with step 1,
    /// which are then exact, and the velocity part of σ from the Jacobian of the model.
    fn jacobian(&self, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64], out: &mut Jacobian) {
        let Scratch { jacobian, y, a: [here, there] } = &mut *self.scratch.borrow_mut();
        let n = q.len();
        self.model.jacobian(pieces, u, q, v, jacobian);
        self.by_drives(pieces, u, q, v, here);
        y[..n].copy_from_slice(q);
        y[n..].copy_from_slice(v);
        for k in 0..2 * n {
            y[k] += 1.0;
            self.by_drives(pieces, u, &y[..n], &y[n..], there);
            y[k] = if k < n { q[k] } else { v[k - n] };
            for i in 0..n {
                let slope = there[i] - here[i];
                if k < n {
                    out.q[(i, k)] = slope;
                } else {
                    out.v[(i, k - n)] = slope + self.slope.speed * jacobian.v[(i, k - n)];
                }
            }
        }
    }
}

impl Periodic for AlongConstant<'_> {
    fn period(&self) -> f64 {
        self.model.period()
    }
}
