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

/// The first contact whose lower edge lies above its upper one in a state, or is not a number, with both
/// edges. The force of such a contact on fixed pieces differs from its force by deflection.
pub(crate) fn negative_gap(model: &dyn Model, state: &State) -> Option<(usize, [f64; 2])> {
    first_negative(&contacts_at(model, state))
}

/// The first of `contacts` whose lower edge lies above its upper one, or is not a number, with both edges.
pub(crate) fn first_negative(contacts: &[Contact]) -> Option<(usize, [f64; 2])> {
    let negative = |(i, c): (usize, &Contact)| {
        (c.lower > c.upper || c.lower.is_nan() || c.upper.is_nan()).then_some((i, [c.lower, c.upper]))
    };
    contacts.iter().enumerate().find_map(negative)
}
