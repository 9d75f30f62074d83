//! Gaps of negative width.

use crate::contact::Contact;
use crate::excitation::Side;
use crate::model::equations::Model;
use crate::model::state::State;

/// The contacts of a model in a state.
pub(crate) fn contacts_at(model: &dyn Model, state: &State) -> Vec<Contact> {
    let (mut u, mut contacts) = (vec![0.0; model.drives()], vec![Contact::default(); model.contacts()]);
    model.drive(state.t, Side::After, &mut u);
    model.contact(&u, &state.q, &state.v, &mut contacts);
    contacts
}

/// The first contact with a negative gap in a state, with both edges.
pub(crate) fn negative_gap(model: &dyn Model, state: &State) -> Option<(usize, [f64; 2])> {
    first_negative(&contacts_at(model, state))
}

/// Whether the edges of a contact are in order: neither is NaN, and the lower one does not lie above the
/// upper one. Otherwise the acceleration on fixed pieces differs from the acceleration of the model itself.
#[inline(always)]
pub(crate) fn is_in_order(c: &Contact) -> bool {
    c.lower <= c.upper
}

/// The first of `contacts` whose edges are not in order, with both edges.
pub(crate) fn first_negative(contacts: &[Contact]) -> Option<(usize, [f64; 2])> {
    let negative = |(i, c): (usize, &Contact)| (!is_in_order(c)).then_some((i, [c.lower, c.upper]));
    contacts.iter().enumerate().find_map(negative)
}
