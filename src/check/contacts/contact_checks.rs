//! Comparison of contacts and accelerations at the edges: kinks, pieces, forces and impacts.

use crate::check::contacts::deflection_line::Line;
use crate::check::inconsistency::Inconsistency;
use crate::check::point::CheckPoint;
use crate::check::tolerances::{FINE, ROUNDING};
use crate::contact::Piece;
use crate::contact::edge::Edge;
use crate::model::State;

/// Pairs of distances from an edge at which functions are sampled, as shares of [`Line::length`].
///
/// The change of slope at a kink is the same at both distances. That of a smooth function is a hundredth at
/// the shorter distance.
const NEAR: [[f64; 2]; 2] = [[1e-2, 1e-4], [1e-4, 1e-6]];

/// Largest ratio of the changes of a smooth function at the shorter and at the longer distance.
const SMOOTH: f64 = 0.03;

/// Least share of the bend at the longer distance that the bend of a kink has at the shorter one `[1]`.
const KINK: f64 = 0.5;

/// Least ratio of the change of a value over a kink to the second differences beside it `[1]`.
const CURVED: f64 = 4.0;

/// Depths past an edge, each twice the one before, as shares of [`Line::length`].
const DEPTHS: [f64; 3] = [0.1, 0.2, 0.4];

/// Largest deviation from a power of the depth `[1]`.
const POWER: f64 = 0.01;

/// The change of a function at an edge, from samples on both sides.
#[derive(Clone, Copy)]
struct Change {
    /// Right limit less left limit.
    jump: f64,
    /// Right slope less left slope.
    bend: f64,
    /// Second differences on the left and on the right.
    curve: [f64; 2],
}

impl Change {
    /// The change from values at the distances -3h, -2h, -h, h, 2h, 3h from the edge.
    fn of(f: [f64; 6], h: f64) -> Self {
        let [left, right] = [2.0 * f[2] - f[1], 2.0 * f[3] - f[4]];
        let slopes = [(f[2] - f[1]) / h, (f[4] - f[3]) / h];
        Change {
            jump: right - left,
            bend: slopes[1] - slopes[0],
            curve: [f[0] - 2.0 * f[1] + f[2], f[5] - 2.0 * f[4] + f[3]],
        }
    }

    /// Whether the function is not smooth at the edge: it has a kink or a jump, or its second differences on
    /// both sides differ by more than 30 %.
    ///
    /// `far`, `near`: the changes at the longer and at the shorter distance; `h`: the shorter distance;
    /// `noise`: rounding of the values.
    fn is_edge([far, near]: [Change; 2], h: f64, noise: f64) -> bool {
        let [left, right] = far.curve;
        (near.bend.abs() * h > 8.0 * noise && near.bend.abs() > SMOOTH * far.bend.abs())
            || (near.jump.abs() > 8.0 * noise && near.jump.abs() > SMOOTH * far.jump.abs())
            || ((right - left).abs() > 8.0 * noise
                && (right - left).abs() > 0.3 * left.abs().max(right.abs()))
    }
}

/// Changes of accelerations and force at one edge.
struct EdgeChange {
    /// Deflection at the edge.
    edge: f64,
    /// The shorter distance.
    h: f64,
    /// For each component, at the longer and at the shorter distance.
    acceleration: Vec<[Change; 2]>,
    /// At the longer and at the shorter distance.
    force: [Change; 2],
    /// Largest absolute value of the sampled forces.
    largest: f64,
}

impl CheckPoint<'_> {
    /// Tests every contact at its finite edges and reports to `findings` if
    /// - no acceleration has a kink, a jump or a change of curvature there (not tested if the deflection
    ///   depends on velocities),
    /// - `accel_on_pieces` gives the same on both pieces (reported once),
    /// - the changes of the contact force and of the acceleration do not have the same ratio at all edges.
    ///
    /// At a rigid stop it tests the impact instead. Skipped: a deflection that does not depend on the
    /// coordinates, a gap without width, an edge near which another contact changes its piece.
    pub(crate) fn kinks(&mut self, findings: &mut Vec<Inconsistency>) {
        let rigid = self.model.offers().rigid_edges(self.model.contacts());
        for contact in 0..self.model.offers().touching(self.model.contacts()) {
            let Some(line) = self.line(contact) else { continue };
            let speeds = self.speeds(contact, &line);
            let mut seen: [Vec<EdgeChange>; 2] = Default::default();
            for edge in line.edges() {
                let place = line.place(edge);
                if edge.is_stop(&rigid, contact) {
                    findings.extend(self.stop(contact, &line, edge));
                    continue;
                }
                let [still, moving] = [&speeds[0], &speeds[1]].map(|v| self.look(contact, &line, v, edge));
                let (Some(still), Some(moving)) = (still, moving) else { continue };
                let is_edge = |(row, changes): (usize, &[Change; 2])| {
                    Change::is_edge(*changes, still.h, ROUNDING * self.terms[row])
                };
                if ![&still, &moving].iter().any(|seen| seen.acceleration.iter().enumerate().any(is_edge)) {
                    // A deflection that depends on the rate may have no effect at these velocities.
                    if !self.moves_with_velocities(contact) && !self.grows_as_a_power(contact, &line, edge) {
                        findings.push(Inconsistency::Kink { contact, edge: place });
                    }
                    continue;
                }
                if self.ignores_pieces(contact, &line, edge)
                    && !findings.iter().any(|f| matches!(f, Inconsistency::PiecesIgnored { .. }))
                {
                    findings.push(Inconsistency::PiecesIgnored { contact, edge: place });
                }
                seen[0].push(still);
                seen[1].push(moving);
            }
            findings.extend(seen.iter().find_map(|seen| self.force(contact, seen)));
        }
    }

    /// Whether the deflection of a contact depends on velocities.
    fn moves_with_velocities(&self, contact: usize) -> bool {
        let State { q, v, .. } = &self.state;
        let deflection = |v: &[f64]| self.contacts(q, v)[contact].deflection;
        let base = deflection(v);
        (0..v.len()).any(|j| {
            let mut v = v.clone();
            v[j] += self.size[1];
            deflection(&v) != base
        })
    }

    /// Checks the impact on a rigid stop: the relative speed after it points away from the stop and does not
    /// exceed the relative speed before it.
    fn stop(&self, contact: usize, line: &Line, edge: Edge) -> Option<Inconsistency> {
        let q = line.to(line.place(edge));
        let leaving = |v: &[f64]| edge.sign_on(Piece::Gap) * edge.rate(&self.contacts(&q, v)[contact]);
        let [still, moving] = self.speeds(contact, line);
        let swing = moving.iter().zip(&still).map(|(a, b)| a - b);
        let mut v: Vec<f64> =
            still.iter().zip(swing).map(|(still, swing)| still + edge.outward() * swing).collect();
        let approach = -leaving(&v);
        if approach.is_nan() || approach <= 0.0 {
            return None; // the contact does not approach the stop
        }
        self.model.impact(contact, edge.flank(), &self.u, &q, &mut v);
        let leaves = leaving(&v);
        let right = leaves >= -FINE * approach && leaves <= (1.0 + FINE) * approach;
        (!right).then_some(Inconsistency::Rebound { contact, edge: line.place(edge), approach, leaves })
    }

    /// Velocities at which the deflection is at rest, and velocities at which it moves, so that damping has
    /// an effect.
    fn speeds(&self, contact: usize, line: &Line) -> [Vec<f64>; 2] {
        let State { q, v, .. } = &self.state;
        let c = self.contacts(q, v)[contact];
        let at = |rate: f64| -> Vec<f64> {
            v.iter().zip(&line.per_deflection).map(|(v, g)| v + (rate - c.rate) * g).collect()
        };
        let largest = line.per_deflection.iter().fold(0.0, |m: f64, g| m.max(g.abs()));
        [at(0.0), at(c.rate.abs().max(self.size[1] / largest))]
    }

    /// Samples accelerations and force at an edge, at distances at which no other contact changes its piece.
    /// `None` if there are no such distances.
    fn look(&self, contact: usize, line: &Line, v: &[f64], edge: Edge) -> Option<EdgeChange> {
        let place = line.place(edge);
        for shares in NEAR {
            let distances = shares.map(|share| share * line.length(edge));
            if distances[1] < 1e3 * f64::EPSILON * self.reach[contact] {
                continue;
            }
            let pieces = |d: f64| self.pieces_at(&line.to(d), v);
            let [below, above] = [-3.0, 3.0].map(|k| pieces(place + k * distances[0]));
            let others_stay = below.iter().zip(&above).enumerate().all(|(i, (a, b))| i == contact || a == b);
            if !others_stay || below[contact] == above[contact] {
                continue;
            }
            let at = |h: f64| [-3.0, -2.0, -1.0, 1.0, 2.0, 3.0].map(|k| line.to(place + k * h));
            let accelerations = distances.map(|h| at(h).map(|q| self.accel(&q, v)));
            let forces = distances.map(|h| at(h).map(|q| self.contacts(&q, v)[contact].force));
            let change = |row: usize, i: usize| {
                Change::of(std::array::from_fn(|k| accelerations[i][k][row]), distances[i])
            };
            return Some(EdgeChange {
                edge: place,
                h: distances[1],
                acceleration: (0..self.model.dof()).map(|row| [change(row, 0), change(row, 1)]).collect(),
                force: std::array::from_fn(|i| Change::of(forces[i], distances[i])),
                largest: forces.as_flattened().iter().fold(0.0, |m: f64, f| m.max(f.abs())),
            });
        }
        None
    }

    /// Whether the effect of a contact on the accelerations grows as a power of the depth past an edge, from
    /// 0 at the edge on. A power above 2 has no kink that samples near the edge show.
    fn grows_as_a_power(&self, contact: usize, line: &Line, edge: Edge) -> bool {
        let v = &self.state.v;
        let effect = |share: f64| {
            let q = line.to(line.place(edge) + edge.outward() * share * line.length(edge));
            let mut pieces = self.pieces_at(&q, v);
            pieces[contact] = Piece::Gap;
            let without = self.accel_on_pieces(&pieces, &q, v)?;
            let apart =
                self.accel(&q, v).iter().zip(&without).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            Some(apart)
        };
        match DEPTHS.map(effect) {
            [Some(a), Some(b), Some(c)] => a > 0.0 && (b * b - a * c).abs() < POWER * b * b,
            _ => false,
        }
    }

    /// Whether the acceleration on the piece beyond an edge equals that of the law itself bit by bit, at 0.3
    /// lengths on both sides of the edge.
    fn ignores_pieces(&self, contact: usize, line: &Line, edge: Edge) -> bool {
        let v = &self.state.v;
        [-0.3, 0.3].into_iter().all(|share| {
            let q = line.to(line.place(edge) + share * line.length(edge));
            let mut pieces = self.pieces_at(&q, v);
            pieces[contact] = if pieces[contact] == Piece::Gap { edge.flank() } else { Piece::Gap };
            self.accel_on_pieces(&pieces, &q, v).is_some_and(|a| a == self.accel(&q, v))
        })
    }

    /// Compares the changes of force and acceleration at all edges of a contact. Their ratio is an effective
    /// mass and must be the same at all edges, for slopes and for jumps.
    fn force(&self, contact: usize, edges: &[EdgeChange]) -> Option<Inconsistency> {
        // The component with the largest change of slope relative to its rounding, summed over all edges.
        let strength = |row: usize| {
            let of = |seen: &EdgeChange| {
                (seen.acceleration[row][1].bend * seen.h).abs() / (self.terms[row] + f64::MIN_POSITIVE)
            };
            edges.iter().map(of).sum::<f64>()
        };
        let row = (0..self.model.dof()).max_by(|a, b| strength(*a).total_cmp(&strength(*b))).unwrap_or(0);
        let clear = |change: Change, h: f64, terms: f64| change.bend.abs() * h > 1e4 * f64::EPSILON * terms;
        let mut per_force: Option<f64> = None;
        for seen in edges {
            let ([far, a], w, h) = (seen.acceleration[row], seen.force[1], seen.h);
            // The bend of a power of the depth decreases towards the edge: smooth terms have a share of it.
            // At both distances together they may hide it, but they have second differences of its size.
            let curve = a.curve[0].abs().max(a.curve[1].abs());
            let smooth = a.bend.abs() < KINK * far.bend.abs() || a.bend.abs() * h < CURVED * curve;
            if !clear(a, h, self.terms[row]) || smooth {
                continue;
            }
            let noise = ROUNDING * seen.largest;
            if w.bend.abs() * h <= 8.0 * noise || w.bend.abs() <= SMOOTH * seen.force[0].bend.abs() {
                return Some(Inconsistency::NoForce { contact, edge: seen.edge });
            }
            let ratio = *per_force.get_or_insert(a.bend / w.bend);
            // Slopes times h, then jumps, both as forces. `least` is the absolute tolerance.
            let least =
                1e-3 * w.bend.abs() * h + 8.0 * noise + 64.0 * ROUNDING * (self.terms[row] / ratio).abs();
            for (given, expected) in [(w.bend * h, a.bend / ratio * h), (w.jump, a.jump / ratio)] {
                if (given - expected).abs() > 1e-2 * given.abs().max(expected.abs()) + least {
                    return Some(Inconsistency::Force { contact, edge: seen.edge, given, expected });
                }
            }
        }
        None
    }
}
