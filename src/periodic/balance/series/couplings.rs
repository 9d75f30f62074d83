//! Couplings of a model: the dependence of its accelerations on its coordinates and velocities.

use crate::contact::piece::Piece;
use crate::excitation::side::Side;
use crate::model::equations::{Jacobian, Periodic};
use crate::model::slopes::Slopes;

/// Dependence of one acceleration on one coordinate or velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Slope {
    Constant(f64),
    /// Index of the periodic slope in [`Couplings::varying`].
    Periodic(usize),
}

/// ∂a_i/∂q_j and ∂a_i/∂v_j, for i = j and for slopes that are not always zero.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coupling {
    pub(crate) i: usize,
    pub(crate) j: usize,
    pub(crate) q: Slope,
    pub(crate) v: Slope,
}

/// Couplings of a model, found from Jacobians at several instants and states.
#[derive(Clone, Debug)]
pub(crate) struct Couplings {
    /// Sorted by column j, then by row i.
    pub(crate) list: Vec<Coupling>,
    /// Every periodic slope as (i, j, whether it is ∂a_i/∂v_j).
    pub(crate) varying: Vec<(usize, usize, bool)>,
    /// Largest |∂a_i/∂q_i| found.
    pub(crate) stiffest: f64,
}

/// Number of instants.
const LOOKS: usize = 16;

impl Couplings {
    pub(crate) fn find<M: Periodic + ?Sized>(slopes: &mut Slopes<'_, M>, holds: bool) -> Self {
        let (model, n) = (slopes.model(), slopes.model().dof());
        let mut first: Option<Jacobian> = None;
        // 0: always zero, 1: constant, 2: varying. If the pieces cannot be fixed, the samples may miss
        // couplings: all slopes then count as varying, if the Jacobian comes from differences or the model is
        // small.
        let hidden = !holds && (slopes.differenced || n <= 4);
        let mut kind = [vec![u8::from(hidden) * 2; n * n], vec![u8::from(hidden) * 2; n * n]];
        let (mut u, mut state) = (vec![0.0; model.drives()], vec![0.0; 2 * n]);
        let mut stiffest = 0.0f64;
        let held: Vec<Vec<Piece>> =
            [Piece::Gap, Piece::Lower, Piece::Upper].map(|p| vec![p; model.contacts()]).to_vec();
        let ways: Vec<Option<&[Piece]>> =
            if holds { held.iter().map(|p| Some(&p[..])).collect() } else { vec![None] };
        for look in 0..LOOKS {
            model.drive(model.period() * even(look, 0), Side::After, &mut u);
            let size = [0.1, 1.0, 3.0][look % 3];
            for (i, (x, scale)) in state.iter_mut().zip(&slopes.scale).enumerate() {
                *x = size * scale * (2.0 * even(look, 1 + 2 * (i % n) + i / n) - 1.0);
            }
            let (q, v) = state.split_at(n);
            for &pieces in &ways {
                slopes.at(pieces, &u, q, v);
                let reference = first.get_or_insert_with(|| slopes.jacobian.clone());
                for (kind, (now, then)) in kind
                    .iter_mut()
                    .zip([(&slopes.jacobian.q, &reference.q), (&slopes.jacobian.v, &reference.v)])
                {
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
                Slope::Periodic(varying.len() - 1)
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
    /// The same couplings with all slopes zero.
    pub(crate) fn without_slopes(&self) -> Self {
        let none = Slope::Constant(0.0);
        let list = self.list.iter().map(|c| Coupling { q: none, v: none, ..*c }).collect();
        Couplings { list, varying: Vec::new(), stiffest: self.stiffest }
    }
}

/// Numbers evenly spread over [0, 1), a different sequence for each direction: Weyl sequences of square
/// roots.
pub(crate) fn even(index: usize, direction: usize) -> f64 {
    ((index + 1) as f64 * ((2 * direction + 3) as f64).sqrt() + 0.137 * direction as f64).fract()
}

/// Whether a model evaluates its laws on fixed pieces (`accel_on_pieces`).
pub(crate) fn holds_pieces<M: Periodic + ?Sized>(model: &M) -> bool {
    let (mut u, rest, mut a) = (vec![0.0; model.drives()], vec![0.0; model.dof()], vec![0.0; model.dof()]);
    model.drive(0.0, Side::After, &mut u);
    model.accel_on_pieces(&vec![Piece::Gap; model.contacts()], &u, &rest, &rest, &mut a)
}
