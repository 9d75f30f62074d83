//! ∂a/∂q and ∂a/∂v of any model: its own, or central differences.

use crate::contact::piece::Piece;
use crate::excitation::side::Side;
use crate::model::equations::{Jacobian, Model};

/// Reads Jacobians; arrays for differences are made when the first are taken.
pub(crate) struct Slopes<'m, M: ?Sized> {
    model: &'m M,
    /// Sizes of coordinates, then of velocities, for differences.
    pub(crate) scale: Vec<f64>,
    /// The last one read.
    pub(crate) jacobian: Jacobian,
    /// Whether the model has none of its own.
    pub(crate) differenced: bool,
    y: Vec<f64>,
    a: [Vec<f64>; 2],
    /// Of central differences, in units of size.
    step: f64,
}

impl<'m, M: Model + ?Sized> Slopes<'m, M> {
    /// For a flow of this tolerance: steps are 5e-6 of the size for the finest flow and grow with its cube root, so that flows of two
    /// tolerances show the error of the differences as well.
    pub(crate) fn new(model: &'m M, scale: Vec<f64>, tolerance: f64) -> Self {
        let (n, step) = (model.dof(), (1e-3 * tolerance).cbrt().clamp(5e-6, 1e-3));
        let (mut u, rest, mut jacobian) = (vec![0.0; model.drives()], vec![0.0; n], Jacobian::new(n));
        model.drive(0.0, Side::After, &mut u);
        let differenced = !model.jacobian(None, &u, &rest, &rest, &mut jacobian);
        let room = if differenced { n } else { 0 };
        Slopes {
            model,
            scale,
            jacobian,
            differenced,
            y: vec![0.0; 2 * room],
            a: [vec![0.0; room], vec![0.0; room]],
            step,
        }
    }

    /// Relative rounding error of a slope taken by differences. It is 0 for slopes that the model gives itself.
    pub(crate) fn noise(&self) -> f64 {
        if self.differenced { 0.5 * f64::EPSILON / self.step } else { 0.0 }
    }

    /// The model.
    pub(crate) fn model(&self) -> &'m M {
        self.model
    }

    /// Reads `jacobian`, with the contacts as they are or held on pieces, where the model can hold them.
    pub(crate) fn at(&mut self, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64]) {
        self.read(self.model, pieces, u, q, v);
    }

    /// The same of a model that stands for the one of these slopes.
    pub(crate) fn read<N: Model + ?Sized>(
        &mut self,
        model: &N,
        pieces: Option<&[Piece]>,
        u: &[f64],
        q: &[f64],
        v: &[f64],
    ) {
        if self.differenced || !model.jacobian(pieces, u, q, v, &mut self.jacobian) {
            self.differences(model, pieces, u, q, v);
        }
    }

    fn differences<N: Model + ?Sized>(
        &mut self,
        model: &N,
        pieces: Option<&[Piece]>,
        u: &[f64],
        q: &[f64],
        v: &[f64],
    ) {
        let n = q.len();
        // There is no room yet if the model gives some of its slopes.
        self.y.resize(2 * n, 0.0);
        self.a.iter_mut().for_each(|a| a.resize(n, 0.0));
        self.y[..n].copy_from_slice(q);
        self.y[n..].copy_from_slice(v);
        for (k, size) in self.scale.iter().enumerate() {
            let here = self.y[k];
            let h = self.step * size.max(1e-3 * here.abs());
            for (side, a) in [h, -h].into_iter().zip(&mut self.a) {
                self.y[k] = here + side;
                let (q, v) = self.y.split_at(n);
                accelerate(model, pieces, u, q, v, a);
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

/// q'' on held pieces where the model can hold them, as it is elsewhere; `false`: it should have held them and cannot.
#[inline]
pub(crate) fn accelerate<M: Model + ?Sized>(
    model: &M,
    pieces: Option<&[Piece]>,
    u: &[f64],
    q: &[f64],
    v: &[f64],
    a: &mut [f64],
) -> bool {
    if let Some(pieces) = pieces
        && model.accel_on_pieces(pieces, u, q, v, a)
    {
        return true;
    }
    model.accel(u, q, v, a);
    pieces.is_none()
}
