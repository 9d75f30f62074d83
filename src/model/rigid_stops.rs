//! The rigid stops of a model.

use crate::contact::piece::Piece;
use crate::excitation::side::Side;
use crate::model::equations::Model;

/// Whether the lower and the upper edge of every contact is a rigid stop. Empty if the model has no rigid
/// stop.
pub(crate) fn rigid_edges<M: Model + ?Sized>(model: &M) -> Vec<[bool; 2]> {
    let contacts = model.contacts();
    if contacts == 0 {
        return Vec::new();
    }
    let (mut u, q, mut v) = (vec![0.0; model.drives()], vec![0.0; model.dof()], vec![0.0; model.dof()]);
    model.drive(0.0, Side::After, &mut u);
    let mut rigid =
        |contact: usize| [Piece::Lower, Piece::Upper].map(|on| model.impact(contact, on, &u, &q, &mut v));
    let all: Vec<[bool; 2]> = (0..contacts).map(&mut rigid).collect();
    if all.iter().any(|rigid| *rigid != [false; 2]) { all } else { Vec::new() }
}

/// The first contact with a rigid stop. Methods that do not locate edges reject a model that has one.
pub(crate) fn first_stop<M: Model + ?Sized>(model: &M) -> Option<usize> {
    rigid_edges(model).iter().position(|rigid| *rigid != [false; 2])
}
