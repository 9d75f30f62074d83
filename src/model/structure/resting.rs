//! Contacts that rest on an edge of their gap.

use crate::contact::edge::Edge;
use crate::contact::{Contact, Piece};
use crate::model::equations::Model;
use crate::model::structure::slopes::Slopes;

/// Rounding errors of the deflection within which a contact stands on its edge.
const ROUNDINGS: f64 = 16.0;

/// Two slopes are equal within this share of the largest one `[1]`.
const EQUAL: f64 = 1e-9;

/// The first contact that rests on an edge of its gap where the Jacobian of the model jumps. A motion that
/// stays there has two one-sided derivatives with respect to its start.
///
/// `slopes`: those of the model, or of one that `model` replaces. `None` also for a model that does not
/// evaluate its laws on fixed pieces. A rigid stop is not such an edge, nor is an inner kink of a law.
pub(crate) fn rests_on_kink(
    model: &dyn Model,
    slopes: &mut Slopes<'_>,
    contacts: &[Contact],
    u: &[f64],
    q: &[f64],
    v: &[f64],
) -> Option<usize> {
    let offers = model.offers();
    if !offers.pieces {
        return None;
    }
    let place = |i: usize, c: &Contact| {
        let rests = |edge: &Edge| {
            let rounding = ROUNDINGS * f64::EPSILON * c.deflection.abs();
            edge.distance(c).abs() <= rounding && edge.rate(c) == 0.0 && !edge.is_stop(offers.stops, i)
        };
        Edge::BOTH.into_iter().find(rests)
    };
    let mut pieces: Vec<Piece> = Vec::new();
    contacts[..offers.touching(contacts.len())].iter().enumerate().find_map(|(i, c)| {
        let edge = place(i, c)?;
        pieces.clear();
        pieces.extend(contacts.iter().map(Contact::piece));
        let other = if c.lower < c.upper { Piece::Gap } else { beyond(edge.flank()) };
        let [here, there] = [edge.flank(), other].map(|piece| {
            pieces[i] = piece;
            slopes.read(model, Some(&pieces), u, q, v);
            [slopes.jacobian.q.clone(), slopes.jacobian.v.clone()]
        });
        let jumps = here.iter().zip(&there).any(|(here, there)| {
            let limit = EQUAL * here.amax().max(there.amax());
            here.iter().zip(there).any(|(a, b)| (a - b).abs() > limit)
        });
        jumps.then_some(i)
    })
}

/// The other flank.
fn beyond(flank: Piece) -> Piece {
    if flank == Piece::Upper { Piece::Lower } else { Piece::Upper }
}
