//! Machines as tapes.

use crate::contact::laws::nonlinearity::Nonlinearity;
use crate::contact::piece::Piece;
use crate::contact::piece_choice::{FixedPieces, PieceChoice};
use crate::excitation::side::Side;
use crate::model::expansion::expand::{Expand, Recorded};
use crate::model::machine::Machine;
use crate::model::shape::{Drives, Shape, Size};
use crate::series::Series;
use crate::tape::node::Node;
use crate::tape::recording::Recording;
use crate::tape::tape::Guard;

/// All pieces, in the order in which a choice counts them.
const PIECES: [Piece; 3] = [Piece::Lower, Piece::Gap, Piece::Upper];

/// Records a contact law on all its pieces.
struct AllPieces<'t>(&'t Recording);

impl<'t> AllPieces<'t> {
    /// The choice among what `on` records for each combination of the pieces of `count` contacts.
    fn choice(&self, contact: usize, count: usize, mut on: impl FnMut(&[Piece]) -> Node<'t>) -> Node<'t> {
        let mut pieces = vec![Piece::Lower; count];
        let forms = (0..3usize.pow(count as u32)).map(|alternative| {
            let mut rest = alternative;
            for piece in &mut pieces {
                *piece = PIECES[rest % 3];
                rest /= 3;
            }
            let guard = Guard { contact, count, alternative };
            self.0.guarded(Some(guard), || on(&pieces)).form(self.0)
        });
        let forms = forms.collect();
        Node::recorded(self.0, self.0.choice(contact, count, forms))
    }
}

impl<'t> PieceChoice<Node<'t>> for AllPieces<'t> {
    fn force<N: Nonlinearity>(
        &self,
        i: usize,
        law: &N,
        x: Node<'t>,
        rate: Node<'t>,
        lower: Node<'t>,
        upper: Node<'t>,
    ) -> Node<'t> {
        self.choice(i, 1, |pieces| FixedPieces(pieces).force(0, law, x, rate, lower, upper))
    }
    fn force_of_switches<N: Nonlinearity>(
        &self,
        i: usize,
        law: &N,
        x: Node<'t>,
        rate: Node<'t>,
        lower: Node<'t>,
        upper: Node<'t>,
    ) -> Node<'t> {
        let all = law.switches();
        self.choice(i, all, |pieces| FixedPieces(pieces).force_of_switches(0, law, x, rate, lower, upper))
    }
    fn touch(&self, i: usize, x: Node<'t>, lower: Node<'t>, upper: Node<'t>) -> Node<'t> {
        self.choice(i, 1, |pieces| FixedPieces(pieces).touch(0, x, lower, upper))
    }
}

impl<G: Shape> Expand for Machine<G> {
    fn record(&self, moving: &dyn Fn(usize) -> bool) -> Recorded {
        let (Size { dof, waves, contacts, .. }, drives) = (self.size(), self.size().drives());
        let recording = Recording::new(dof, drives);
        let constants = self.own_drives();
        let input = |slot: usize| Node::recorded(&recording, recording.input(slot));
        let drive = |d: usize| match d < waves || moving(d) {
            true => input(2 * dof + d),
            false => constants[d - waves].into(),
        };
        let q: Vec<Node<'_>> = (0..dof).map(input).collect();
        let v: Vec<Node<'_>> = (dof..2 * dof).map(input).collect();
        let u: Vec<Node<'_>> = (0..drives).map(drive).collect();
        let mut a = vec![Node::from(0.0); dof];
        let (shape, law, u) = (self.shape(), AllPieces(&recording), Drives::new(waves, &u));
        shape.accel(&law, u, &q, &v, &mut a);
        let accelerations = a.iter().map(|a| a.form(&recording)).collect();
        let distance = |ahead: Node<'_>| {
            let infinite = ahead.constant().is_some_and(|d| d == f64::INFINITY);
            (!infinite).then(|| ahead.form(&recording))
        };
        let distances = (0..contacts)
            .map(|i| {
                let c = shape.contact(&law, i, u, &q, &v);
                let finite = |edge: Node<'_>| edge.constant().is_none_or(f64::is_finite);
                [
                    if finite(c.lower) { distance(c.deflection - c.lower) } else { None },
                    if finite(c.upper) { distance(c.upper - c.deflection) } else { None },
                ]
            })
            .collect();
        Recorded(recording.finish(accelerations, distances))
    }

    fn drive_series(&self, t: f64, coefficients: usize, u: &mut [Series]) {
        let speed = self.speed();
        let (waves, rest) = u.split_at_mut(self.size().waves);
        self.shape().waves(Series::variable(speed * t, speed, coefficients), Side::After, waves);
        for (u, value) in rest.iter_mut().zip(self.own_drives()) {
            *u = value.into();
        }
    }
    fn redrive_series(&self, t: f64, coefficients: usize, u: &mut [Series]) {
        let (speed, waves) = (self.speed(), self.size().waves);
        let angle = Series::variable(speed * t, speed, coefficients);
        self.shape().waves_again(angle, Side::After, &mut u[..waves]);
    }
}
