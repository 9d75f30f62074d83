//! Equal balls on a line between two walls.

use gear_dynamics::contact::{Contact, Piece, PieceChoice, Restitution};
use gear_dynamics::model::{Channel, Drives, Scalar, Shape, Size};

/// Balls of mass 1 and no size in order between walls at 0 and `wall`; impacts with e = 1. Contact i lies below ball i,
/// the last one between the last ball and the wall.
#[derive(Clone, Debug, PartialEq)]
pub struct Balls {
    /// Number of balls.
    pub count: usize,
    /// Place of the upper wall.
    pub wall: f64,
}

/// No mass: a rigid stop from below at each contact.
const STOPS: [[bool; 2]; 16] = [[true, false]; 16];

impl Shape for Balls {
    fn size(&self) -> Size {
        Size { dof: self.count, contacts: self.count + 1, constants: 1, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        vec![Channel::new("speed", "1")]
    }
    fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        _: &L,
        i: usize,
        _: Drives<'_, S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let of = |x: &[S], wall: f64| {
            let above = if i < self.count { x[i] } else { S::from(wall) };
            if i == 0 { above } else { above - x[i - 1] }
        };
        let upper = S::from(f64::INFINITY);
        Contact {
            deflection: of(q, self.wall),
            rate: of(v, 0.0),
            lower: 0.0.into(),
            upper,
            ..Contact::default()
        }
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, _: Drives<'_, S>, _: &[S], _: &[S], a: &mut [S]) {
        a.fill(0.0.into());
    }
    fn stops(&self) -> &[[bool; 2]] {
        &STOPS[..=self.count]
    }
    fn impact<S: Scalar>(&self, i: usize, _: Piece, _: Drives<'_, S>, _: &[S], v: &mut [S]) {
        let mut row = vec![S::from(0.0); v.len()];
        let mut rate = S::from(0.0);
        let bodies = [i.checked_sub(1).map(|below| (below, -1.0)), (i < self.count).then_some((i, 1.0))];
        for (body, sign) in bodies.into_iter().flatten() {
            row[body] = sign.into();
            rate = rate + v[body] * sign;
        }
        if let Ok(elastic) = Restitution::new(1.0) {
            elastic.impulse(rate, &row, &row, v);
        }
    }
}
