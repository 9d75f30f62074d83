//! Bodies on springs between a floor and a ceiling; equal balls without springs are a case of them.

use gear_dynamics::contact::{Contact, Piece, PieceChoice, Restitution};
use gear_dynamics::model::{Channel, Drives, Scalar, Shape, Size};

/// Bodies in order on a line, each on a spring to its own place, with rigid stops between them, on the floor at 0 and
/// under the ceiling. Contact 0 is the floor, contact i lies below body i, the next one is the ceiling. The floor may be
/// stated a second time, last.
#[derive(Clone, Debug, PartialEq)]
pub struct Bodies {
    /// Masses.
    pub masses: Vec<f64>,
    /// Stiffness of the springs over the masses.
    pub squares: Vec<f64>,
    /// Places of the springs.
    pub places: Vec<f64>,
    /// Place of the ceiling.
    pub ceiling: f64,
    /// Coefficient of restitution of each contact, the ceiling included.
    pub restitution: Vec<f64>,
    /// Whether the floor is stated twice.
    pub twice: bool,
}

/// A rigid stop from below at each contact.
const STOPS: [[bool; 2]; 8] = [[true, false]; 8];

impl Bodies {
    /// Number of stops.
    pub fn stops(&self) -> usize {
        self.masses.len() + 1 + usize::from(self.twice)
    }
    /// The bodies of a stop and the signs of their coordinates in its deflection.
    pub fn sides(&self, contact: usize) -> [Option<(usize, f64)>; 2] {
        let n = self.masses.len();
        match contact {
            0 => [None, Some((0, 1.0))],
            i if i < n => [Some((i - 1, -1.0)), Some((i, 1.0))],
            i if i == n => [Some((n - 1, -1.0)), None],
            _ => [None, Some((0, 1.0))],
        }
    }
    /// The deflection at the coordinates or velocities `x`; `wall`: the place or velocity of the ceiling.
    pub fn of<S: Scalar>(&self, contact: usize, x: &[S], wall: f64) -> S {
        let first = S::from(if contact == self.masses.len() { wall } else { 0.0 });
        self.sides(contact).into_iter().flatten().fold(first, |sum, (body, sign)| sum + x[body] * sign)
    }
}

impl Shape for Bodies {
    fn size(&self) -> Size {
        Size { dof: self.masses.len(), contacts: self.stops(), constants: 1, ..Size::default() }
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
        let (deflection, rate) = (self.of(i, q, self.ceiling), self.of(i, v, 0.0));
        Contact { deflection, rate, lower: 0.0.into(), upper: S::from(f64::INFINITY), ..Contact::default() }
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, _: Drives<'_, S>, q: &[S], _: &[S], a: &mut [S]) {
        for (i, a) in a.iter_mut().enumerate() {
            *a = (S::from(self.places[i]) - q[i]) * self.squares[i];
        }
    }
    fn stops(&self) -> &[[bool; 2]] {
        &STOPS[..Bodies::stops(self)]
    }
    fn impact<S: Scalar>(&self, i: usize, _: Piece, _: Drives<'_, S>, _: &[S], v: &mut [S]) {
        let (mut row, mut over) = (vec![S::from(0.0); v.len()], vec![S::from(0.0); v.len()]);
        for (body, sign) in self.sides(i).into_iter().flatten() {
            row[body] = sign.into();
            over[body] = (sign / self.masses[body]).into();
        }
        let rate = self.of(i, v, 0.0);
        let e = self.restitution[if i > self.masses.len() { 0 } else { i }];
        if let Ok(stop) = Restitution::new(e) {
            stop.impulse(rate, &row, &over, v);
        }
    }
}
