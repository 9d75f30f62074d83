//! ∂a/∂q and ∂a/∂v of any model: its own, or central differences.

use crate::model::{Jacobian, Model};
use crate::piece::Piece;

/// Reads Jacobians, its arrays made once.
pub(crate) struct Slopes<'m, M: ?Sized> {
    model: &'m M,
    jacobian: Jacobian,
    y: Vec<f64>,
    a: [Vec<f64>; 2],
    /// Of central differences, in units of size.
    step: f64,
}

impl<'m, M: Model + ?Sized> Slopes<'m, M> {
    /// For a flow of this tolerance: steps are 5e-6 of the size for the finest flow and grow with its cube root, so that flows of two
    /// tolerances show the error of the differences as well.
    pub(crate) fn new(model: &'m M, tolerance: f64) -> Self {
        let (n, step) = (model.dof(), (1e-3 * tolerance).cbrt().clamp(5e-6, 1e-3));
        Slopes { model, jacobian: Jacobian::new(n), y: vec![0.0; 2 * n], a: [vec![0.0; n], vec![0.0; n]], step }
    }

    /// With the contacts as they are or held on pieces, where the model can hold them; `scale`: sizes of coordinates and velocities.
    pub(crate) fn read(&mut self, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64], scale: &[f64]) -> &Jacobian {
        let given = self.model.jacobian(pieces, u, q, v, &mut self.jacobian);
        if !given {
            self.differences(pieces, u, q, v, scale);
        }
        &self.jacobian
    }

    fn differences(&mut self, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64], scale: &[f64]) {
        let n = q.len();
        self.y[..n].copy_from_slice(q);
        self.y[n..].copy_from_slice(v);
        for (k, size) in scale.iter().enumerate() {
            let here = self.y[k];
            let h = self.step * size.max(1e-3 * here.abs());
            for (side, a) in [h, -h].into_iter().zip(&mut self.a) {
                self.y[k] = here + side;
                let (q, v) = self.y.split_at(n);
                if !accel(self.model, pieces, u, q, v, a) {
                    self.model.accel(u, q, v, a);
                }
            }
            let width = (here + h) - (here - h);
            self.y[k] = here;
            let (half, j) = if k < n { (&mut self.jacobian.q, k) } else { (&mut self.jacobian.v, k - n) };
            for i in 0..n {
                half[(i, j)] = (self.a[0][i] - self.a[1][i]) / width;
            }
        }
    }
}

/// q'' as it is or on pieces; `false`: the model cannot hold them.
pub(crate) fn accel<M: Model + ?Sized>(model: &M, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) -> bool {
    match pieces {
        Some(pieces) => model.accel_on_pieces(pieces, u, q, v, a),
        None => {
            model.accel(u, q, v, a);
            true
        }
    }
}
