//! The order of the impacts at one instant.
//!
//! Of all contacts that touch their rigid stops, the one that approaches fastest strikes first; those that
//! approach equally fast strike together. This is repeated until none approaches. In a row of balls an impact
//! therefore passes from ball to ball (Newton's cradle), and equal members of a symmetric set stay equal.
//!
//! - Impacts together obey v⁺ = v + Σ λ_i Δ_i, with the change Δ_i of the velocities by impact i alone: no
//!   contact leaves more slowly than after its own impact, and only contacts that leave with just that speed
//!   receive an impulse, λ_i >= 0. For Newton's law of restitution with e <= 1 the energy does not grow: the
//!   impulses change it by ½ Σ P_i (s_i⁺ - s_i), with s_i⁺ = e_i s_i and the speeds s_i of approach.
//! - Impacts with e < 1 in rows that touch may follow one another without end, ever more slowly. Below
//!   [`RESOLUTION`] times the fastest approach of the instant, the contacts that still press come to rest
//!   relative to their stops, all together.
//! - After [`LONG`] impacts per stop, an approach below [`APART`] times the rounding of its speed counts as
//!   rest, too: the last impacts of rows with e < 1 may be slower than the velocities resolve.
//! - What is then left of the approach is rounding. Contacts that leave their stops no faster than rounding
//!   are moved apart by [`APART`] times the rounding of their speed, so that no later step finds them beyond
//!   their stops.
//! - What is left of the velocities depends on the order of the impacts, except for impacts that do not share
//!   a body and for elastic rows of equal bodies. Two unequal approaches that differ by less than [`TIED`]
//!   are taken together.   Source: Pfeiffer & Glocker, Multibody Dynamics with Unilateral Contacts, Chap. 8
//!   (laws
//!   of impact); Brogliato, Nonsmooth Mechanics, Sect. 6 (sequences of impacts).

use crate::contact::edge::Edge;
use crate::contact::{Contact, Piece};
use crate::model::Model;
use crate::numeric::search::complementarity::Complementarity;
use crate::numeric::spread::sign_patterns;
use crate::ode::edges::exit::Exit;

/// A contact approaches its stop if its speed of approach exceeds this share of the fastest one at this
/// instant `[1]`.
pub(crate) const RESOLUTION: f64 = 1e-9;

/// Contacts whose approach is slower than the fastest by less than this share of it strike together `[1]`.
const TIED: f64 = 1e-6;

/// Maximum number of impacts at one instant, per rigid stop of the model. Five balls that touch need 200 for
/// e = 0.
const MOST: usize = 10_000;

/// Number of impacts at one instant, per rigid stop of the model, after which the rounding of the speeds of
/// approach is measured.
const LONG: usize = 2;

/// Least speed at which contacts leave their stops after impacts, in units of the rounding of their speed
/// `[1]`.
const APART: f64 = 16.0;

/// Maximum number of times that contacts are moved apart at one instant, each time faster.
const TIMES: i32 = 10;

/// What happens next at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Next {
    /// No contact approaches its stop.
    Over,
    /// The chosen contacts strike.
    Impacts,
    /// The contacts press on their stops more slowly than the resolution.
    Rest,
    /// The contacts are to leave their stops faster than rounding.
    Apart,
}

/// The impacts of one instant.
#[derive(Default)]
pub(crate) struct Collisions {
    /// All rigid stops.
    exits: Vec<Exit>,
    /// Speed of approach to each stop; -∞ where the contact is not on the stop.
    approach: Vec<f64>,
    /// Whether the contact approached this stop before the first impact.
    arrives: Vec<bool>,
    /// Indices of the stops that strike next.
    chosen: Vec<usize>,
    /// Change of the velocities by the last impact on each stop alone; dof values for each stop.
    changes: Vec<f64>,
    /// Whether there was an impact on the stop.
    struck: Vec<bool>,
    /// Speed of the fastest approach at this instant.
    fastest: f64,
    /// Number of impacts.
    count: usize,
    /// Number of stops that were struck when the contacts last came to rest.
    rested: usize,
    /// How often contacts were moved apart.
    apart: i32,
    /// Effect of rounding of the velocities on the speed of approach to each stop.
    rounding: Vec<f64>,
    /// Speeds of approach to each stop that are rounding; 0 as long as there are few impacts.
    lost: Vec<f64>,
    /// Velocities after one impact alone.
    alone: Vec<f64>,
    matrix: Vec<f64>,
    right: Vec<f64>,
    problem: Complementarity,
}

impl Collisions {
    pub(crate) fn new(rigid: &[[bool; 2]], dof: usize) -> Self {
        let exits: Vec<Exit> = stops(rigid).collect();
        let n = exits.len();
        Collisions {
            approach: vec![0.0; n],
            arrives: vec![false; n],
            chosen: Vec::with_capacity(n),
            changes: vec![0.0; n * dof],
            struck: vec![false; n],
            fastest: 0.0,
            count: 0,
            rested: 0,
            apart: 0,
            rounding: vec![0.0; n],
            lost: vec![0.0; n],
            alone: vec![0.0; if n > 0 { dof } else { 0 }],
            matrix: Vec::with_capacity(n * n),
            right: Vec::with_capacity(n),
            problem: Complementarity::of_size(n),
            exits,
        }
    }

    /// Begins a new instant.
    pub(crate) fn begin(&mut self) {
        self.struck.fill(false);
        self.lost.fill(0.0);
        (self.fastest, self.count, self.rested, self.apart) = (0.0, 0, 0, 0);
    }

    /// Decides what happens next. `contacts`: at the present velocities; `touches`: whether a contact is on
    /// its stop.
    pub(crate) fn next(&mut self, contacts: &[Contact], touches: impl Fn(Exit, &Contact) -> bool) -> Next {
        let (mut top, mut pressing) = (0.0f64, 0.0f64);
        for ((exit, approach), lost) in self.exits.iter().zip(&mut self.approach).zip(&self.lost) {
            let c = &contacts[exit.contact];
            *approach = if touches(*exit, c) { speed(*exit, c) } else { f64::NEG_INFINITY };
            pressing = pressing.max(*approach);
            if *approach > *lost {
                top = top.max(*approach);
            }
        }
        self.fastest = self.fastest.max(pressing);
        let slow = RESOLUTION * self.fastest;
        if self.count == 0 {
            self.arrives.iter_mut().zip(&self.approach).for_each(|(arrives, s)| *arrives = *s > slow);
        }
        self.chosen.clear();
        if top > slow {
            let strikes =
                |k: &usize| self.approach[*k] >= (1.0 - TIED) * top && self.approach[*k] > self.lost[*k];
            self.chosen.extend((0..self.exits.len()).filter(strikes));
            self.count += self.chosen.len();
            self.chosen.iter().for_each(|&k| self.struck[k] = true);
            return Next::Impacts;
        }
        let fresh = |k: usize| self.approach[k] > 0.0 && !self.struck[k];
        let known = self.struck.iter().filter(|struck| **struck).count();
        if self.count == 0 {
            return Next::Over;
        }
        let is_slow = |k: usize| self.approach[k].abs() <= slow.max(self.lost[k]);
        let rests = |k: &usize| is_slow(*k) && (self.struck[*k] || fresh(*k));
        self.chosen.extend((0..self.exits.len()).filter(rests));
        // After a single impact, what is left of the approach is rounding.
        let new = self.rested != known || (0..self.exits.len()).any(fresh);
        match self.chosen.is_empty() {
            _ if pressing > 0.0 && self.count > 1 && new => Next::Rest,
            false if self.apart < TIMES => Next::Apart,
            _ => {
                self.chosen.clear();
                Next::Over
            }
        }
    }

    /// The most impacts that are allowed at one instant, if there were more.
    pub(crate) fn exceeded(&self) -> Option<usize> {
        let most = MOST * self.exits.len();
        (self.count > most).then_some(most)
    }

    /// The stops that strike next.
    pub(crate) fn chosen(&self) -> impl Iterator<Item = Exit> + '_ {
        self.chosen.iter().map(|&k| self.exits[k])
    }
    /// All stops that contacts approach.
    pub(crate) fn approached(&self) -> impl Iterator<Item = Exit> + '_ {
        let slow = RESOLUTION * self.fastest;
        self.exits.iter().zip(&self.approach).filter(move |(_, s)| **s > slow).map(|(exit, _)| *exit)
    }
    /// The stops with an impact at this instant.
    pub(crate) fn struck(&self) -> impl Iterator<Item = Exit> + '_ {
        self.exits.iter().zip(&self.struck).filter(|(_, struck)| **struck).map(|(exit, _)| *exit)
    }
    /// Whether a contact approached this stop before the first impact of the instant.
    pub(crate) fn arrives(&self, exit: Exit) -> bool {
        self.exits.iter().zip(&self.arrives).any(|(own, arrives)| *own == exit && *arrives)
    }

    /// Computes the velocities after the chosen impacts, or at rest. `contacts`: scratch.
    pub(crate) fn resolve(
        &mut self,
        model: &dyn Model,
        next: Next,
        [u, q]: [&[f64]; 2],
        v: &mut [f64],
        contacts: &mut [Contact],
    ) {
        let dof = v.len();
        if next == Next::Impacts && self.count > LONG * self.exits.len() && self.lost[self.chosen[0]] == 0.0 {
            self.lose(model, [u, q, v], contacts);
        }
        if next == Next::Apart && !self.hasten(model, [u, q, v], contacts) {
            return;
        }
        for &k in &self.chosen {
            if next != Next::Impacts && self.struck[k] {
                continue;
            }
            self.struck[k] = true;
            self.alone.copy_from_slice(v);
            model.impact(self.exits[k].contact, self.exits[k].edge.flank(), u, q, &mut self.alone);
            for ((change, after), v) in self.changes[k * dof..][..dof].iter_mut().zip(&self.alone).zip(&*v) {
                *change = after - v;
            }
        }
        match (next, &*self.chosen) {
            (Next::Impacts, [_]) => return v.copy_from_slice(&self.alone),
            (Next::Rest, _) => self.rested = self.struck.iter().filter(|struck| **struck).count(),
            _ => {}
        }
        let n = self.chosen.len();
        self.matrix.resize(n * n, 0.0);
        for (j, &k) in self.chosen.iter().enumerate() {
            let change = &mut self.changes[k * dof..][..dof];
            self.alone.iter_mut().zip(&*v).zip(&*change).for_each(|((to, v), change)| *to = v + change);
            model.contact(u, q, &self.alone, contacts);
            for (i, &other) in self.chosen.iter().enumerate() {
                let exit = self.exits[other];
                self.matrix[i * n + j] = self.approach[other] - speed(exit, &contacts[exit.contact]);
            }
            // The last impacts on the stops may differ by many orders: each as one of unit speed.
            let own = self.matrix[j * n + j];
            if next != Next::Impacts && own > 0.0 {
                change.iter_mut().for_each(|change| *change /= own);
                (0..n).for_each(|i| self.matrix[i * n + j] /= own);
            }
        }
        self.right.clear();
        for (i, &k) in self.chosen.iter().enumerate() {
            let change = match next {
                Next::Rest => -self.approach[k],
                Next::Apart => -self.approach[k] - 4f64.powi(self.apart - 1) * self.above_rounding(k),
                _ => -self.matrix[i * n + i],
            };
            self.right.push(change);
        }
        let solved = self.problem.solve(&self.matrix, &self.right);
        for (j, &k) in self.chosen.iter().enumerate() {
            // Stops that move towards one another have no common solution: one impact, then the others.
            let share = match (solved, next) {
                (true, _) => self.problem.z[j],
                (false, Next::Impacts) if j == 0 => 1.0,
                _ => 0.0,
            };
            v.iter_mut().zip(&self.changes[k * dof..][..dof]).for_each(|(v, change)| *v += share * change);
        }
    }

    /// Speed of a contact that leaves its stop faster than rounding.
    fn above_rounding(&self, k: usize) -> f64 {
        APART * self.rounding[k].max(f64::EPSILON * self.fastest)
    }

    /// Speeds of approach below [`APART`] times their rounding are lost from now on.
    #[cold]
    fn lose(&mut self, model: &dyn Model, state: [&[f64]; 3], contacts: &mut [Contact]) {
        self.measure_rounding(model, state, contacts);
        self.lost.iter_mut().zip(&self.rounding).for_each(|(lost, r)| *lost = lost.max(APART * r));
    }

    /// Returns whether a contact is to be moved apart, faster than the last time.
    #[cold]
    fn hasten(&mut self, model: &dyn Model, state: [&[f64]; 3], contacts: &mut [Contact]) -> bool {
        self.measure_rounding(model, state, contacts);
        let together = self.chosen.iter().any(|&k| self.approach[k] > -0.5 * self.above_rounding(k));
        self.apart = if together { self.apart + 1 } else { TIMES };
        together
    }

    /// Measures the effect of rounding on the speeds of approach.
    fn measure_rounding(&mut self, model: &dyn Model, [u, q, v]: [&[f64]; 3], contacts: &mut [Contact]) {
        self.rounding.fill(0.0);
        for sign in sign_patterns(v.len()) {
            let components = self.alone.iter_mut().zip(v).enumerate();
            components.for_each(|(j, (shaken, v))| *shaken = v * (1.0 + sign(j) * f64::EPSILON));
            model.contact(u, q, &self.alone, contacts);
            for ((rounding, exit), approach) in self.rounding.iter_mut().zip(&self.exits).zip(&self.approach)
            {
                if approach.is_finite() {
                    *rounding = rounding.max((speed(*exit, &contacts[exit.contact]) - approach).abs());
                }
            }
        }
    }
}

/// All rigid stops, as exits of their contacts.
pub(crate) fn stops(rigid: &[[bool; 2]]) -> impl Iterator<Item = Exit> + '_ {
    rigid.iter().enumerate().flat_map(|(contact, rigid)| {
        let rigid = Edge::BOTH.into_iter().filter(|edge| rigid[*edge as usize]);
        rigid.map(move |edge| Exit { contact, edge })
    })
}

/// Speed at which a contact in its gap approaches a stop.
pub(crate) fn speed(exit: Exit, c: &Contact) -> f64 {
    -exit.distance(Piece::Gap, c, 1.0).rate
}
