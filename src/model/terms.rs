//! The sums of terms in the equations of a model: the measure of its rounding errors.

use crate::contact::piece::Piece;
use crate::contact::piece_choice::{ByDeflection, FixedPieces, PieceChoice};
use crate::excitation::side::Side;
use crate::model::equations::Model;
use crate::model::machine::Machine;
use crate::model::shape::{Drives, Shape, Size};
use crate::model::slopes::{Slopes, accelerate};
use crate::rounded::Rounded;

/// A model that knows the terms of its accelerations. A [`Machine`](crate::Machine) does.
///
/// ```
/// use gear_dynamics::{Model, State, trains::SpurPair};
/// let pair = SpurPair::of_numbers(0.05, 0.1, &[-0.2], &[])?.parts()?.build("driver", 0.6)?;
/// let (mut u, mut terms) = (vec![0.0; pair.drives()], [0.0]);
/// pair.drive(0.0, gear_dynamics::excitation::Side::After, &mut u);
/// // q'' = 0.1 - 0.1 q' - 0.8 (q - 1) at q = 1.5 and q' = 0: terms 0.1, 0.8 * 1.5 and 0.8.
/// let model: &dyn Model = &pair;
/// let mut room = gear_dynamics::model::TermsRoom::default();
/// model.terms().ok_or("terms")?.terms(None, &u, &[1.5], &[0.0], &[1.5, 0.0], &mut room, &mut terms);
/// assert!((terms[0] - 2.1).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Terms {
    /// Writes for each acceleration the sum of the absolute values of its terms, in the unit of the
    /// acceleration: its rounding error over ε = 2.2e-16, before anything cancels. By deflection for `None`,
    /// or with every contact on a given piece.
    ///
    /// `sizes`: for each coordinate, then for each velocity, the sum of the terms that it is made of, at least
    /// its absolute value. `room`: memory that is kept from call to call.
    #[allow(clippy::too_many_arguments, reason = "a state, its sizes and the room for the result")]
    fn terms(
        &self,
        pieces: Option<&[Piece]>,
        u: &[f64],
        q: &[f64],
        v: &[f64],
        sizes: &[f64],
        room: &mut TermsRoom,
        out: &mut [f64],
    );
}

/// Memory of [`Terms`], kept from call to call: a call with used room does not allocate.
///
/// ```
/// use gear_dynamics::{Model, model::TermsRoom, trains::SpurPair};
/// let pair = SpurPair::of_numbers(0.05, 0.1, &[], &[])?.parts()?.build("driver", 0.6)?;
/// let (mut u, mut room, mut terms) = (vec![0.0; pair.drives()], TermsRoom::default(), [0.0]);
/// pair.drive(0.0, gear_dynamics::excitation::Side::After, &mut u);
/// let model: &dyn Model = &pair;
/// for (q, expected) in [(1.5, 2.6), (2.0, 3.1)] {
///     let known = model.terms().ok_or("terms")?;
///     known.terms(None, &u, &[q], &[0.0], &[q, 0.0], &mut room, &mut terms);
///     assert!((terms[0] - expected).abs() < 1e-12); // 0.1 + q + 1 of q'' = 0.1 - (q - 1)
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Default)]
pub struct TermsRoom {
    u: Vec<Rounded>,
    y: Vec<Rounded>,
    a: Vec<Rounded>,
}

impl std::fmt::Debug for TermsRoom {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("TermsRoom").finish_non_exhaustive()
    }
}

impl<G: Shape> Terms for Machine<G> {
    fn terms(
        &self,
        pieces: Option<&[Piece]>,
        u: &[f64],
        q: &[f64],
        v: &[f64],
        sizes: &[f64],
        room: &mut TermsRoom,
        out: &mut [f64],
    ) {
        match pieces {
            None => terms_of(self.shape(), &ByDeflection, u, [q, v], sizes, room, out),
            Some(pieces) => terms_of(self.shape(), &FixedPieces(pieces), u, [q, v], sizes, room, out),
        }
    }
}

fn terms_of<G: Shape, L: PieceChoice<Rounded>>(
    shape: &G,
    law: &L,
    u: &[f64],
    [q, v]: [&[f64]; 2],
    sizes: &[f64],
    room: &mut TermsRoom,
    out: &mut [f64],
) {
    let Size { dof: n, waves, .. } = shape.size();
    let TermsRoom { u: of_u, y, a } = room;
    of_u.clear();
    of_u.extend(u.iter().map(|&u| Rounded::from(u)));
    y.clear();
    let sized = q.iter().chain(v).zip(sizes);
    y.extend(sized.map(|(&value, &size)| Rounded { value, terms: size.max(value.abs()) }));
    a.clear();
    a.resize(n, Rounded::from(0.0));
    shape.accel(law, Drives::new(waves, of_u), &y[..n], &y[n..], a);
    out.iter_mut().zip(&*a).for_each(|(out, a)| *out = a.terms);
}

/// Sizes of coordinates and velocities at a state, each the sum of the terms of which it is made over a step of
/// length h:
///
/// Q_i = |q_i| + h |v_i| + h² T_i,   V_i = |v_i| + h T_i,
///
/// with the sum T_i of the terms of acceleration i ([`Terms`]), which contain the sizes of the other coordinates.
/// ε Q_i is the rounding error that the equations bring into coordinate i, even if it rests at 0 because all
/// terms cancel.
///
/// For a model without [`Terms`], T_i = |a_i| + Σ_j (|∂a_i/∂q_j| Q_j + |∂a_i/∂v_j| V_j): what cancels within
/// a slope is not seen.
pub(crate) struct Sizing<'m, M: ?Sized> {
    model: &'m M,
    /// For a model without terms.
    slopes: Option<Slopes<'m, M>>,
    u: Vec<f64>,
    a: Vec<f64>,
    terms: Vec<f64>,
    room: TermsRoom,
    /// Q_i, then V_i.
    sizes: Vec<f64>,
}

impl<'m, M: Model + ?Sized> Sizing<'m, M> {
    pub(crate) fn new(model: &'m M) -> Self {
        let n = model.dof();
        Sizing {
            model,
            slopes: model.terms().is_none().then(|| Slopes::new(model, vec![0.0; 2 * n], 0.0)),
            u: vec![0.0; model.drives()],
            a: vec![0.0; n],
            terms: vec![0.0; n],
            room: TermsRoom::default(),
            sizes: vec![0.0; 2 * n],
        }
    }

    /// The sizes at a state before or after a step of length `h`: by deflection, or on pieces.
    pub(crate) fn at(&mut self, pieces: Option<&[Piece]>, t: f64, q: &[f64], v: &[f64], h: f64) -> &[f64] {
        let n = q.len();
        self.model.drive(t, Side::Before, &mut self.u);
        if let Some(slopes) = &mut self.slopes {
            // The step of the differences follows the values, since the terms are slope times value.
            for (scale, y) in slopes.scale.iter_mut().zip(q.iter().chain(v)) {
                *scale = scale.max(y.abs());
            }
            slopes.at(pieces, &self.u, q, v);
            accelerate(self.model, pieces, &self.u, q, v, &mut self.a);
        }
        self.sizes.iter_mut().zip(q.iter().chain(v)).for_each(|(size, y)| *size = y.abs());
        for _ in 0..PASSES {
            match self.model.terms() {
                Some(known) => {
                    known.terms(pieces, &self.u, q, v, &self.sizes, &mut self.room, &mut self.terms);
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

/// Number of evaluations of the terms: the second one contains the sizes of the other coordinates.
const PASSES: usize = 2;
