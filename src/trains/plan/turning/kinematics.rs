//! Mean speeds of all bodies, exact from tooth numbers.

use crate::trains::parts::collection::JoinedShaft;
use crate::trains::parts::mesh_part::Kind;
use crate::trains::plan::topology::{Gearing, Topology};
use crate::trains::plan::turning::fraction::Fraction;
use crate::trains::train_error::TrainError;

/// Σ coefficient · speed = 0, by the part `part`.
struct Relation {
    part: String,
    terms: Vec<(usize, Fraction)>,
}

/// Speeds over that of the reference body, counterclockwise positive.
pub(crate) struct Kinematics {
    pub(crate) speeds: Vec<Fraction>,
}

impl Kinematics {
    pub(crate) fn of<N>(topology: &Topology<N>) -> Result<Self, TrainError> {
        let relations = relations(topology);
        let mut speeds: Vec<Option<Fraction>> =
            topology.bodies.iter().map(|(_, body)| body.grounded.then_some(Fraction::ZERO)).collect();
        let name = |body: usize| topology.name(body);
        if speeds[topology.reference].is_some() {
            return Err(TrainError::ReferenceAtRest { body: name(topology.reference) });
        }
        speeds[topology.reference] = Some(Fraction::ONE);
        // The relations of each body, so that the search is linear in the number of parts.
        let mut of_body = vec![Vec::new(); speeds.len()];
        for (r, relation) in relations.iter().enumerate() {
            relation.terms.iter().for_each(|(body, _)| of_body[*body].push(r));
        }
        // The last relation comes first. Those of grounded bodies wait, so that a conflict with the ground is
        // named.
        let mut queue: Vec<usize> = (0..relations.len()).rev().collect();
        let grounded = |r: &usize| relations[*r].terms.iter().any(|(b, _)| topology.bodies[*b].1.grounded);
        queue.sort_by_key(|r| !grounded(r));
        loop {
            while let Some(r) = queue.pop() {
                let Relation { part, terms } = &relations[r];
                let mut unknown = (0..terms.len()).filter(|&i| speeds[terms[i].0].is_none());
                let (first, None) = (unknown.next(), unknown.next()) else { continue };
                let solved = first.unwrap_or(terms.len() - 1);
                let body = terms[solved].0;
                let Some(found) = solve(terms, solved, &speeds) else {
                    return Err(TrainError::NoCommonAngle { part: part.clone() });
                };
                match speeds[body] {
                    None => {
                        speeds[body] = Some(found);
                        queue.extend(&of_body[body]);
                    }
                    Some(expected) if expected != found => {
                        let (part, grounded) = (part.clone(), |b: &usize| topology.bodies[*b].1.grounded);
                        if let &[(a, _), (b, _)] = &terms[..]
                            && let Some(ground) = [a, b].into_iter().find(grounded)
                        {
                            let turns = if ground == a { b } else { a };
                            let speed = speeds[turns].map_or(0.0, Fraction::value);
                            let [body, ground] = [turns, ground].map(name);
                            return Err(TrainError::LockedToGround { part, body, speed, ground });
                        }
                        let body = name(body);
                        let [found, expected] = [found, expected].map(Fraction::value);
                        return Err(TrainError::Locked { part, body, found, expected });
                    }
                    Some(_) => {}
                }
            }
            if speeds.iter().all(Option::is_some) {
                break;
            }
            // Coupled planetary sets: relations with several unknown speeds.
            let solved = eliminate(&relations, &speeds);
            if solved.is_empty() {
                let body = speeds.iter().position(Option::is_none).unwrap_or(0);
                return Err(TrainError::SpeedUndetermined { body: name(body) });
            }
            for (body, speed) in solved {
                speeds[body] = Some(speed);
                queue.extend(&of_body[body]);
            }
        }
        Ok(Kinematics { speeds: speeds.into_iter().flatten().collect() })
    }

    /// 1 for a body that turns counterclockwise or not at all, -1 for a clockwise one.
    pub(crate) fn sense(&self, body: usize) -> f64 {
        if self.speeds[body].value() < 0.0 { -1.0 } else { 1.0 }
    }
    /// Speed of a body relative to a carrier, if there is one.
    pub(crate) fn relative(&self, body: usize, carrier: Option<usize>) -> Option<Fraction> {
        match carrier {
            Some(carrier) => self.speeds[body].minus(self.speeds[carrier]),
            None => Some(self.speeds[body]),
        }
    }
    /// Speed of a gear of a mesh relative to its carrier.
    pub(crate) fn of_gear<N>(&self, mesh: &Gearing<N>, gear: usize) -> Option<Fraction> {
        self.relative(mesh.ends[gear], mesh.carrier)
    }
    /// Teeth of a mesh that pass over the turns of the reference body.
    pub(crate) fn of_teeth<N>(&self, mesh: &Gearing<N>) -> Option<Fraction> {
        self.of_gear(mesh, 0)?.times(Fraction::whole(mesh.part.teeth[0].into()))
    }
}

/// Σ coefficient · speed.
fn sum(terms: &[(usize, Fraction)], speeds: &[Option<Fraction>]) -> Option<Fraction> {
    terms.iter().try_fold(Fraction::ZERO, |sum, &(body, lever)| sum.plus(lever.times(speeds[body]?)?))
}

/// The speed of one term of a relation from the speeds of the others.
fn solve(terms: &[(usize, Fraction)], one: usize, speeds: &[Option<Fraction>]) -> Option<Fraction> {
    let rest = sum(&terms[..one], speeds)?.plus(sum(&terms[one + 1..], speeds)?)?;
    Fraction::ZERO.minus(rest)?.over(terms[one].1)
}

/// Maximum number of unknown speeds that are eliminated together.
const COUPLED: usize = 256;

/// Speeds that follow from several relations together, by Gauss-Jordan elimination.
fn eliminate(relations: &[Relation], speeds: &[Option<Fraction>]) -> Vec<(usize, Fraction)> {
    let open: Vec<&Relation> =
        relations.iter().filter(|r| r.terms.iter().any(|(body, _)| speeds[*body].is_none())).collect();
    let mut unknown: Vec<usize> = (0..speeds.len()).filter(|&body| speeds[body].is_none()).collect();
    unknown.retain(|body| open.iter().any(|r| r.terms.iter().any(|term| term.0 == *body)));
    if unknown.len() > COUPLED {
        return Vec::new();
    }
    // Rows: coefficients of the unknown speeds, then the right-hand side.
    let mut rows: Vec<Vec<Fraction>> = Vec::new();
    for relation in open {
        let (hidden, known): (Vec<(usize, Fraction)>, Vec<_>) =
            relation.terms.iter().copied().partition(|term| speeds[term.0].is_none());
        let mut row = vec![Fraction::ZERO; unknown.len() + 1];
        for (body, lever) in hidden {
            if let Some(column) = unknown.iter().position(|known| *known == body)
                && let Some(sum) = row[column].plus(lever)
            {
                row[column] = sum;
            }
        }
        if let Some(right) = sum(&known, speeds).and_then(|known| Fraction::ZERO.minus(known)) {
            row[unknown.len()] = right;
            rows.push(row);
        }
    }
    let mut pivots = Vec::new();
    for column in 0..unknown.len() {
        let Some(r) = (pivots.len()..rows.len()).find(|&r| !rows[r][column].is_zero()) else { continue };
        rows.swap(pivots.len(), r);
        let pivot = rows[pivots.len()].clone();
        let at = pivots.len();
        for (_, row) in rows.iter_mut().enumerate().filter(|(i, row)| *i != at && !row[column].is_zero()) {
            let Some(factor) = row[column].over(pivot[column]) else { return Vec::new() };
            for (x, p) in row.iter_mut().zip(&pivot) {
                match factor.times(*p).and_then(|p| x.minus(p)) {
                    Some(difference) => *x = difference,
                    None => return Vec::new(),
                }
            }
        }
        pivots.push(column);
    }
    let mut solved = Vec::new();
    for (row, &column) in rows.iter().zip(&pivots) {
        let alone = (0..unknown.len()).all(|other| other == column || row[other].is_zero());
        if alone && let Some(speed) = row[unknown.len()].over(row[column]) {
            solved.push((unknown[column], speed));
        }
    }
    solved
}

/// The relations of all shafts and meshes.
fn relations<N>(topology: &Topology<N>) -> Vec<Relation> {
    let shaft = |(shaft, [a, b]): &(&JoinedShaft<N>, [usize; 2])| {
        let terms = vec![(*a, Fraction::ONE), (*b, Fraction::whole(-1))];
        Relation { part: shaft.name.clone(), terms }
    };
    let mesh = |mesh: &Gearing<N>| {
        let [first, second] = mesh.part.teeth.map(i64::from);
        let second = if mesh.part.kind == Kind::External { second } else { -second };
        let [a, b] = mesh.ends;
        let mut terms = vec![(a, Fraction::whole(first)), (b, Fraction::whole(second))];
        if let Some(carrier) = mesh.carrier.filter(|_| first + second != 0) {
            terms.push((carrier, Fraction::whole(-(first + second))));
        }
        Relation { part: mesh.name.into(), terms }
    };
    topology.shafts.iter().map(shaft).chain(topology.meshes.iter().map(mesh)).collect()
}
