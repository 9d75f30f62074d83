//! Rigid stops along a boundary: those that the orbits graze, and the softest impact.

use crate::branches::orbits::contact_trace::{ContactTrace, Rigid};
use crate::contact::edge::Edge;

/// Distance from a stop, over the range of motion, up to which an orbit grazes it `[1]`.
pub(crate) const GRAZES: f64 = 1e-9;

/// Squared speed of an impact, over the largest squared rate of its contact, below which it is a grazing, by
/// rounding, or the softest impact that a boundary follows `[1]`.
pub(crate) const SOFT: f64 = 1e-6;

/// The rigid stops that an orbit grazes and strikes at no other time: contacts with their edges. `range`:
/// the range of motion.
pub(crate) fn grazed_stops(rigid: &Rigid, trace: &ContactTrace, range: f64) -> Vec<(usize, Edge)> {
    let hard = |e: f64, contact: usize| e.abs() > SOFT * trace.fastest[contact].powi(2);
    let struck = |contact: usize, edge: Edge| {
        let mut impacts = trace.at_stops(rigid, true);
        impacts.any(|e| e.is_at(contact, edge) && hard(e.distance, contact))
    };
    let touches = trace.at_stops(rigid, false).filter(|e| e.distance.abs() <= GRAZES * range);
    let touches = touches.chain(trace.at_stops(rigid, true).filter(|e| !hard(e.distance, e.contact)));
    let mut stops = Vec::new();
    for e in touches.filter(|e| !struck(e.contact, e.edge)) {
        if !stops.contains(&(e.contact, e.edge)) {
            stops.push((e.contact, e.edge));
        }
    }
    stops
}

/// The least squared speed of an impact over the largest squared rate of its contact, with the contact;
/// `None` without impacts.
pub(crate) fn softest_impact(rigid: &Rigid, trace: &ContactTrace) -> Option<(f64, usize)> {
    let shares = trace.at_stops(rigid, true).map(|e| {
        let largest = trace.fastest[e.contact];
        (e.distance.abs() / (largest * largest), e.contact)
    });
    shares.min_by(|a, b| a.0.total_cmp(&b.0))
}
