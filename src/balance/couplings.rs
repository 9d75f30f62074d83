//! Which accelerations depend on which coordinates, and how to ask for the slopes.

use crate::model::{Jacobian, Model, Periodic};
use crate::piece::{Piece, Side};

/// Slopes of the acceleration at one instant: the model's own, or central differences.
pub(super) struct Slopes<'m, M: ?Sized> {
    model: &'m M,
    /// Size of coordinates and velocities, for differences.
    size: [Vec<f64>; 2],
    pub(super) jacobian: Jacobian,
    /// Whether the model offers none.
    pub(super) differenced: bool,
    q: Vec<f64>,
    v: Vec<f64>,
    a: [Vec<f64>; 2],
}

impl<'m, M: Model + ?Sized> Slopes<'m, M> {
    pub(super) fn new(model: &'m M, size: [Vec<f64>; 2]) -> Self {
        let n = model.dof();
        let (mut u, rest) = (vec![0.0; model.drives()], vec![0.0; n]);
        model.drive(0.0, Side::After, &mut u);
        let mut jacobian = Jacobian::new(n);
        let differenced = !model.jacobian(None, &u, &rest, &rest, &mut jacobian);
        Slopes { model, size, jacobian, differenced, q: vec![0.0; n], v: vec![0.0; n], a: [vec![0.0; n], vec![0.0; n]] }
    }

    /// Size of coordinates (0) or velocities (1).
    pub(super) fn reach(&self, half: usize) -> Vec<f64> {
        self.size[half].clone()
    }

    /// Fills `jacobian`.
    pub(super) fn at(&mut self, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64]) {
        if !self.differenced && self.model.jacobian(pieces, u, q, v, &mut self.jacobian) {
            return;
        }
        let n = q.len();
        for column in 0..2 * n {
            let (half, j) = (column / n, column % n);
            let h = 1e-6 * self.size[half][j];
            for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
                self.q.copy_from_slice(q);
                self.v.copy_from_slice(v);
                if half == 0 {
                    self.q[j] += sign * h
                } else {
                    self.v[j] += sign * h
                }
                accelerate(self.model, pieces, u, &self.q, &self.v, &mut self.a[side]);
            }
            let target = if half == 0 { &mut self.jacobian.q } else { &mut self.jacobian.v };
            for i in 0..n {
                target[(i, j)] = (self.a[0][i] - self.a[1][i]) / (2.0 * h);
            }
        }
    }
}

/// q'', on held pieces if the model offers them.
#[inline]
pub(super) fn accelerate<M: Model + ?Sized>(model: &M, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
    if !pieces.is_some_and(|pieces| model.accel_on_pieces(pieces, u, q, v, a)) {
        model.accel(u, q, v, a);
    }
}

/// How one acceleration depends on one coordinate or velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Slope {
    Constant(f64),
    /// Number of the periodic slope.
    Varying(usize),
}

/// ∂a_i/∂q_j and ∂a_i/∂v_j, where they are not always zero.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coupling {
    pub(super) i: usize,
    pub(super) j: usize,
    pub(super) q: Slope,
    pub(super) v: Slope,
}

/// The pattern of a model, found by looking.
#[derive(Clone, Debug)]
pub(super) struct Couplings {
    /// By column j, then row i.
    pub(super) list: Vec<Coupling>,
    /// (i, j, of velocity) of every periodic slope.
    pub(super) varying: Vec<(usize, usize, bool)>,
    /// Largest |∂a_i/∂q_i| seen.
    pub(super) stiffest: f64,
}

/// Instants looked at.
const LOOKS: usize = 16;

impl Couplings {
    pub(super) fn find<M: Periodic + ?Sized>(slopes: &mut Slopes<'_, M>, holds: bool) -> Self {
        let (model, n) = (slopes.model, slopes.model.dof());
        let mut first: Option<Jacobian> = None;
        // 0 never, 1 constant, 2 varying; a model that hides its pieces may hide couplings too.
        let hidden = !holds && (slopes.differenced || n <= 4);
        let mut kind = [vec![u8::from(hidden) * 2; n * n], vec![u8::from(hidden) * 2; n * n]];
        let mut u = vec![0.0; model.drives()];
        let mut stiffest = 0.0f64;
        let held: Vec<Vec<Piece>> = [Piece::Gap, Piece::Lower, Piece::Upper].map(|p| vec![p; model.contacts()]).to_vec();
        let ways: Vec<Option<&[Piece]>> = if holds { held.iter().map(|p| Some(&p[..])).collect() } else { vec![None] };
        for look in 0..LOOKS {
            model.drive(model.period() * even(look, 0), Side::After, &mut u);
            let size = [0.1, 1.0, 3.0][look % 3];
            let random = |half: usize, j: usize| size * slopes.size[half][j] * (2.0 * even(look, 1 + 2 * j + half) - 1.0);
            let (q, v): (Vec<f64>, Vec<f64>) = (0..n).map(|j| (random(0, j), random(1, j))).unzip();
            for &pieces in &ways {
                slopes.at(pieces, &u, &q, &v);
                let reference = first.get_or_insert_with(|| slopes.jacobian.clone());
                for (kind, (now, then)) in kind.iter_mut().zip([(&slopes.jacobian.q, &reference.q), (&slopes.jacobian.v, &reference.v)]) {
                    for ((kind, now), then) in kind.iter_mut().zip(now).zip(then) {
                        let same = (now - then).abs() <= 1e-13 * then.abs();
                        *kind = (*kind).max(if !same { 2 } else { u8::from(*now != 0.0) });
                    }
                }
                stiffest = (0..n).fold(stiffest, |m, i| m.max(slopes.jacobian.q[(i, i)].abs()));
            }
        }
        let mut varying = Vec::new();
        let mut slope = |kind: u8, i: usize, j: usize, velocity: bool| match (kind, &first) {
            (2, _) => {
                varying.push((i, j, velocity));
                Slope::Varying(varying.len() - 1)
            }
            (_, Some(first)) => Slope::Constant(if velocity { first.v[(i, j)] } else { first.q[(i, j)] }),
            _ => Slope::Constant(0.0),
        };
        let mut list = Vec::new();
        for j in 0..n {
            for i in 0..n {
                let (of_q, of_v) = (kind[0][j * n + i], kind[1][j * n + i]);
                if of_q > 0 || of_v > 0 || i == j {
                    list.push(Coupling { i, j, q: slope(of_q, i, j, false), v: slope(of_v, i, j, true) });
                }
            }
        }
        Couplings { list, varying, stiffest }
    }
}

impl Couplings {
    /// The pattern alone: all slopes zero.
    pub(super) fn without_slopes(&self) -> Self {
        let none = Slope::Constant(0.0);
        let list = self.list.iter().map(|c| Coupling { q: none, v: none, ..*c }).collect();
        Couplings { list, varying: Vec::new(), stiffest: self.stiffest }
    }
}

/// Numbers spread over 0..1, different in every direction.   Weyl sequence of square roots.
pub(super) fn even(index: usize, direction: usize) -> f64 {
    ((index + 1) as f64 * ((2 * direction + 3) as f64).sqrt() + 0.137 * direction as f64).fract()
}
