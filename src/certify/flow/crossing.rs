//! The motion over one crossing.

use crate::certify::flow::field::Field;
use crate::certify::flow::leg::{Image, Leg, LegCrossing};
use crate::certify::flow::part::Seen;
use crate::certify::flow::signs::{EdgeForm, edges, instant, keeps_sign, refined, stays};
use crate::certify::flow::stretch::{Stretch, Until};
use crate::certify::square::Square;
use crate::certify::unproved::Unproved;
use crate::contact::Piece;
use crate::interval::number::Interval;

/// The image of a box over a crossing.
///
/// The derivative of the leg is Φ⁺ S Φ⁻ with S = 1 + (f⁺ - f⁻) ∇h/h', over all states and instants of the
/// crossing; at a rigid stop with the derivative of the impact in place of 1.   Source: Leine & Nijmeijer,
/// Dynamics and Bifurcations of Non-Smooth Mechanical Systems, Sect. 7.4.
pub(crate) fn across(
    field: &Field<'_>,
    leg: &Leg,
    crossing: &LegCrossing,
    x: &[Interval],
    m: &[Interval],
    seen: &mut Seen<'_>,
) -> Result<Image, Unproved> {
    let (n, d) = (field.n, 2 * field.n);
    let &LegCrossing { contact, to, rebounds, near } = crossing;
    let grazing = Unproved::NearGrazing { contact, t: near };
    let length = (leg.end - leg.start).high();
    let about = near - leg.start.middle();
    // Also a time that is NaN.
    if !(about > 0.0 && about < length && leg.start.high() < near && near < leg.end.low()) {
        return Err(Unproved::Together { t: leg.start.middle(), after: near });
    }
    let reach = about + 0.5 * about.min(length - about);
    let first = Stretch::new(field, &leg.pieces, (leg.start, leg.inside()), x, reach)?;
    let Some(edge) = EdgeForm::of(field, &leg.pieces, crossing) else { return Err(grazing) };
    let own = field.motion.tape.distances[contact][edge.edge as usize].unwrap_or(edge.form);
    let (span, at) = instant(&first, &edge, about).ok_or(grazing.clone())?;
    keeps_sign(&first, &edge, 0.0, span.low())?;
    for other in edges(field, &leg.pieces).filter(|other| !other.is_on(&edge)) {
        keeps_sign(&first, &other, 0.0, at.high())?;
    }
    // The instant for the middle of the box.
    let narrow = first.narrow(leg.start, m);
    let rate = first.rate(edge.form, at);
    let of_middle = |s: Interval| narrow.distance(own, edge.form, s);
    let at_middle = refined(at, rate, of_middle).ok_or(grazing.clone())?;
    let (mut state, mut middle) = (first.state(at), narrow.state(at_middle));
    let (time, time_middle) = (leg.start + at, leg.start + at_middle);
    let mut slope = first.slope(at);

    // f⁻, f⁺, ∇h Φ⁻ and the jump.
    let u = field.drive_series(time, leg.inside(), 2);
    let columns = field.with_columns(&state, &slope);
    let along = field.edge_slope((contact, edge.edge), &leg.pieces, &columns, &u).ok_or(grazing)?;
    let along: Vec<Interval> = along.into_iter().map(|slope| slope / rate).collect();
    let accelerations = |pieces: &[Piece], state: &[Interval]| -> Vec<Interval> {
        let c = field.motion.expand(pieces.into(), state, &u, 0);
        field.motion.tape.accelerations.iter().map(|&form| c.form(form, 0)).collect()
    };
    let pieces = leg.pieces_after();
    let before = accelerations(&leg.pieces, &state);
    if rebounds {
        // Velocities jump there: the distance may not.
        let unit = field.with_columns(&state, &Square::identity(d));
        let slopes = field.edge_slope((contact, edge.edge), &leg.pieces, &unit, &u).unwrap_or_default();
        if slopes.iter().skip(n).any(|slope| *slope != Interval::ZERO) {
            let what = format!("the edge of contact {contact}, which depends on velocities");
            return Err(Unproved::NoEnclosure { what });
        }
        // Neighbours arrive later by -∇h δ/h': moved to the edge, thrown back, moved to the common instant.
        let moved = Square::from_fn(d, |i, k| {
            let rate = if i < n { state[n + i] } else { before[i - n] };
            slope.at(i, k) - rate * along[k]
        });
        let delays: Vec<Interval> = along.iter().map(|along| -*along).collect();
        let impact = |x: &[Interval]| field.rebound((contact, to), &pieces, x, (&moved, &delays), &u);
        let thrown = impact(&state)?;
        let thrown_middle = impact(&middle)?;
        middle[n..].copy_from_slice(&thrown_middle.velocities);
        state[n..].copy_from_slice(&thrown.velocities);
        let after = accelerations(&pieces, &state);
        slope = Square::from_fn(d, |i, k| {
            let (of_row, rate) = match i < n {
                true => (moved.at(i, k), state[n + i]),
                false => (thrown.difference(i - n, k), after[i - n]),
            };
            of_row + rate * along[k]
        });
    } else {
        let after = accelerations(&pieces, &state);
        slope = Square::from_fn(d, |i, k| match i < n {
            true => slope.at(i, k),
            false => slope.at(i, k) + (after[i - n] - before[i - n]) * along[k],
        });
    }
    if (leg.end - time).low() <= 0.0 {
        return Err(Unproved::Together { t: near, after: leg.end.middle() });
    }
    let second = Stretch::new(field, &pieces, (time, leg.inside()), &state, (leg.end - time).high())?;
    stays(&second, &pieces, second.length, &[edge])?;
    seen(&Until(&first, at));
    seen(&Until(&second, leg.end - time));
    let middle = second.narrow(time_middle, &middle).state(leg.end - time_middle);
    Ok(Image { middle, slope: second.slope(leg.end - time).times(&slope), crossing: Some(time) })
}
