//! Contact laws recorded on all their pieces.

use crate::contact::piece::set_alternative;
use crate::contact::{Deflection, FixedPieces, Nonlinearity, Piece, PieceChoice, Place};
use crate::tape::node::Node;
use crate::tape::operations::{Guard, Op};
use crate::tape::recording::Recording;

/// Maximum number of inner kinks of one law: every combination of their pieces is recorded.
const KINKS: usize = 8;

/// Evaluation of contact laws on all their pieces, for a recording. The pieces of a run choose among them.
///
/// ```
/// use gear_dynamics::contact::{Contact, Piece};
/// use gear_dynamics::model::recording::{Node, Recorded};
/// // q'' = -f(q): a wall at q = 1 with the force q - 1.
/// let recorded = Recorded::of(1, 0, &|_| None, |every, _, q, _, a| {
///     let force = every.choice(0, 1, |pieces| match pieces {
///         [Piece::Upper] => q[0] - Node::from(1.0),
///         _ => Node::from(0.0),
///     });
///     a[0] = -force;
///     let lower = Node::from(f64::NEG_INFINITY);
///     vec![Contact { deflection: q[0], lower, upper: 1.0.into(), ..Contact::default() }]
/// });
/// assert_eq!(recorded.dof(), 1);
/// ```
#[derive(Debug)]
pub struct EveryPiece<'t>(pub(super) &'t Recording);

impl<'t> EveryPiece<'t> {
    /// Records what `on` returns for each combination of the pieces of `count` contacts from `contact` on.
    pub fn choice(&self, contact: usize, count: usize, mut on: impl FnMut(&[Piece]) -> Node<'t>) -> Node<'t> {
        if count > KINKS {
            let kink = Op::Kink("a contact law with more than 8 inner kinks");
            return Node::recorded(self.0, self.0.function(kink));
        }
        let mut pieces = vec![Piece::Lower; count];
        let forms = (0..3usize.pow(count as u32)).map(|alternative| {
            set_alternative(alternative, &mut pieces);
            let guard = Guard { contact, count, alternative };
            self.0.guarded(Some(guard), || on(&pieces)).form(self.0)
        });
        let forms = forms.collect();
        Node::recorded(self.0, self.0.choice(contact, count, forms))
    }
}

impl<'t> PieceChoice<Node<'t>> for EveryPiece<'t> {
    fn force<N: Nonlinearity>(&self, place: impl Into<Place>, law: &N, at: Deflection<Node<'t>>) -> Node<'t> {
        let Place { contact, kinks } = place.into();
        let on = |piece: Piece| match law.kinks() {
            0 => law.force_on(piece, &[], at),
            count => self.choice(kinks, count, |kinks| law.force_on(piece, kinks, at)),
        };
        self.choice(contact, 1, |pieces| on(pieces[0]))
    }
    fn touch(&self, i: usize, at: Deflection<Node<'t>>) -> Node<'t> {
        self.choice(i, 1, |pieces| FixedPieces(pieces).touch(0, at))
    }
}
