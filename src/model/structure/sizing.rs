//! Sizes of coordinates and velocities, from the terms of their equations.

use crate::contact::Piece;
use crate::excitation::Side;
use crate::model::equations::Model;
use crate::model::structure::slopes::{Slopes, accelerate};
use crate::model::terms::TermsScratch;

/// Sizes of coordinates and velocities at a state, each the sum of the terms of which it is made over a step
/// of length h:
///
/// Q_i = |q_i| + h |v_i| + h² T_i,   V_i = |v_i| + h T_i,
///
/// with the sum T_i of the terms of acceleration i ([`Terms`](crate::model::terms::Terms)), which contain the
/// sizes of the other coordinates. ε Q_i is the rounding error that the equations bring into coordinate i,
/// even if it rests at 0 because all terms cancel.
///
/// For a model without `Terms`, T_i = |a_i| + Σ_j (|∂a_i/∂q_j| Q_j + |∂a_i/∂v_j| V_j): what cancels within
/// a slope is not seen.
pub(crate) struct Sizing<'m> {
    model: &'m dyn Model,
    /// For a model without terms.
    slopes: Option<Slopes<'m>>,
    u: Vec<f64>,
    a: Vec<f64>,
    terms: Vec<f64>,
    scratch: TermsScratch,
    /// Q_i, then V_i.
    sizes: Vec<f64>,
}

impl<'m> Sizing<'m> {
    pub(crate) fn new(model: &'m dyn Model) -> Self {
        let n = model.dof();
        Sizing {
            model,
            slopes: model.offers().terms.is_none().then(|| Slopes::new(model, vec![0.0; 2 * n], 0.0)),
            u: vec![0.0; model.drives()],
            a: vec![0.0; n],
            terms: vec![0.0; n],
            scratch: TermsScratch::default(),
            sizes: vec![0.0; 2 * n],
        }
    }

    /// The sizes at a state before or after a step of length `h`: by deflection, or on pieces.
    pub(crate) fn at(&mut self, pieces: Option<&[Piece]>, t: f64, q: &[f64], v: &[f64], h: f64) -> &[f64] {
        self.over(pieces, t, q, v, [h, h])
    }

    /// The sizes with rounding errors that add up over a longer time: the terms contain the sizes of the
    /// coordinates over the first length, and act over the second one.
    pub(crate) fn over(
        &mut self,
        pieces: Option<&[Piece]>,
        t: f64,
        q: &[f64],
        v: &[f64],
        lengths: [f64; PASSES],
    ) -> &[f64] {
        let n = q.len();
        self.model.drive(t, Side::Before, &mut self.u);
        if let Some(slopes) = &mut self.slopes {
            // The step of the differences follows the values, since the terms are slope times value. It is a
            // small share of them: a motion may lie far from 0.
            for (scale, y) in slopes.scale.iter_mut().zip(q.iter().chain(v)) {
                *scale = scale.max(NEAR * y.abs());
            }
            slopes.at(pieces, &self.u, q, v);
            accelerate(self.model, pieces, &self.u, q, v, &mut self.a);
        }
        self.sizes.iter_mut().zip(q.iter().chain(v)).for_each(|(size, y)| *size = y.abs());
        let known = self.model.offers().terms;
        for h in lengths {
            match known {
                Some(known) => {
                    known.terms(pieces, &self.u, q, v, &self.sizes, &mut self.scratch, &mut self.terms);
                }
                None => self.terms_by_slopes(),
            }
            for i in 0..n {
                let terms = Some(self.terms[i]).filter(|terms| terms.is_finite()).unwrap_or(0.0);
                let speed = v[i].abs() + h * terms;
                (self.sizes[i], self.sizes[n + i]) = (q[i].abs() + h * speed, speed);
            }
        }
        &self.sizes
    }

    fn terms_by_slopes(&mut self) {
        let n = self.a.len();
        let Some(slopes) = &self.slopes else { return };
        let (by_q, by_v) = (&slopes.jacobian.q, &slopes.jacobian.v);
        let term = |slope: f64, y: f64| Some((slope * y).abs()).filter(|x| x.is_finite()).unwrap_or(0.0);
        for i in 0..n {
            let sum: f64 = (0..n)
                .map(|j| term(by_q[(i, j)], self.sizes[j]) + term(by_v[(i, j)], self.sizes[n + j]))
                .sum();
            self.terms[i] = sum + term(1.0, self.a[i]);
        }
    }
}

/// Size of the differences, as a share of a value. Their rounding is still far below the slopes.
const NEAR: f64 = 1e-3;

/// Number of evaluations of the terms: the second one contains the sizes of the other coordinates.
const PASSES: usize = 2;
