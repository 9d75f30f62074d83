//! The deflections at which the accelerations change their piece.

use crate::contact::Contact;
use crate::contact::edge::Edge;
use crate::excitation::Side;
use crate::model::Model;

/// The coordinates in `range` at which a contact of the model reaches an edge at t = 0 and at rest. A
/// deflection that depends on the velocity has no such place and is left out.
pub(crate) fn edges_at_start(model: &dyn Model, range: [f64; 2], speed: f64) -> Vec<f64> {
    let (mut u, mut contacts) = (vec![0.0; model.drives()], vec![Contact::default(); model.contacts()]);
    model.drive(0.0, Side::After, &mut u);
    let mut edges = Vec::new();
    for i in 0..contacts.len() {
        for edge in Edge::BOTH {
            let mut depth = |x: f64, v: f64| {
                model.contact(&u, &[x], &[v], &mut contacts);
                edge.distance(&contacts[i])
            };
            let middle = 0.5 * (range[0] + range[1]);
            if depth(middle, speed) == depth(middle, 0.0) {
                edges.extend(root(range, |x| depth(x, 0.0)));
            }
        }
    }
    edges
}

/// A root of a function that is linear, or nearly so, by the secant method.
fn root([low, high]: [f64; 2], mut f: impl FnMut(f64) -> f64) -> Option<f64> {
    let ([mut a, mut b], mut fa, mut fb) = ([low, high], f(low), f(high));
    if fa.is_nan() || fb.is_nan() || fa * fb >= 0.0 {
        return None;
    }
    for _ in 0..60 {
        let next = a - fa * (b - a) / (fb - fa);
        if !next.is_finite() || (next - b).abs() <= 1e-15 * (high - low) {
            break;
        }
        (a, fa, b, fb) = (b, fb, next, f(next));
        if fb == 0.0 {
            break;
        }
    }
    Some(b).filter(|x| low < *x && *x < high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::Oscillator;

    #[test]
    fn edges_of_a_dead_zone() {
        let pair = [("speed", 1.0), ("mesh stiffness", 1.0), ("half backlash", 0.5)];
        let mut edges = edges_at_start(&Oscillator::new(&pair).unwrap(), [-2.0, 3.0], 1.0);
        edges.sort_by(f64::total_cmp);
        assert_eq!(edges, [-0.5, 0.5]);
    }
}
