//! Jacobians ∂a/∂q and ∂a/∂v of any model: those that the model provides, or central differences.

use crate::contact::Piece;
use crate::model::equations::Model;
use crate::model::jacobian::Jacobian;

/// Evaluates the Jacobian of a model. Arrays for differences are allocated when they are first needed.
pub(crate) struct Slopes<'m> {
    model: &'m dyn Model,
    /// Sizes of coordinates, then of velocities, for the steps of differences.
    pub(crate) scale: Vec<f64>,
    /// The Jacobian of the last evaluation.
    pub(crate) jacobian: Jacobian,
    /// Whether the model provides no Jacobian, so that differences are used.
    pub(crate) differenced: bool,
    y: Vec<f64>,
    a: [Vec<f64>; 2],
    /// Step of the central differences, as a share of the size.
    step: f64,
}

impl<'m> Slopes<'m> {
    /// The same slopes of another model, which offers a Jacobian if and only if this one does.
    pub(crate) fn with_model(self, model: &dyn Model) -> Slopes<'_> {
        let Slopes { scale, jacobian, differenced, y, a, step, .. } = self;
        Slopes { model, scale, jacobian, differenced, y, a, step }
    }
}

impl<'m> Slopes<'m> {
    /// Slopes for a flow with the given tolerance. The step of differences is ∛(1e-3 tolerance) of the size,
    /// within 5e-6 .. 1e-3. It grows with the tolerance, so that a comparison of flows with two tolerances
    /// also shows the error of the differences.
    pub(crate) fn new(model: &'m dyn Model, scale: Vec<f64>, tolerance: f64) -> Self {
        let (n, step) = (model.dof(), (1e-3 * tolerance).cbrt().clamp(5e-6, 1e-3));
        let (jacobian, differenced) = (Jacobian::new(n), !model.offers().jacobian);
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

    /// Relative rounding error of a Jacobian by differences, ε/(2 step) with ε = 2.2e-16. 0 for a Jacobian
    /// that the model provides.
    pub(crate) fn noise(&self) -> f64 {
        if self.differenced { 0.5 * f64::EPSILON / self.step } else { 0.0 }
    }

    /// The model.
    pub(crate) fn model(&self) -> &'m dyn Model {
        self.model
    }

    /// Evaluates `jacobian` by deflection, or on given pieces if the model can evaluate them.
    pub(crate) fn at(&mut self, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64]) {
        self.read(self.model, pieces, u, q, v);
    }

    /// Evaluates `jacobian` in the same way for another model that replaces the model of these slopes.
    pub(crate) fn read(
        &mut self,
        model: &dyn Model,
        pieces: Option<&[Piece]>,
        u: &[f64],
        q: &[f64],
        v: &[f64],
    ) {
        if self.differenced {
            self.differences(model, pieces, u, q, v);
        } else {
            model.jacobian(offered(model, pieces), u, q, v, &mut self.jacobian);
        }
    }

    /// Central differences ∂a/∂y ≈ (a(y + h) - a(y - h))/(2 h).
    fn differences(&mut self, model: &dyn Model, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64]) {
        let n = q.len();
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

/// The pieces if the model can evaluate its accelerations on them.
pub(crate) fn offered<'p>(model: &dyn Model, pieces: Option<&'p [Piece]>) -> Option<&'p [Piece]> {
    pieces.filter(|_| model.offers().pieces)
}

/// Writes q'' on given pieces if the model can evaluate them, by deflection otherwise.
#[inline]
pub(crate) fn accelerate(
    model: &dyn Model,
    pieces: Option<&[Piece]>,
    u: &[f64],
    q: &[f64],
    v: &[f64],
    a: &mut [f64],
) {
    match offered(model, pieces) {
        Some(pieces) => model.accel_on_pieces(pieces, u, q, v, a),
        None => model.accel(u, q, v, a),
    }
}
