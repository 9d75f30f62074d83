//! Adds elements to the algebra of a train by their rows.

use crate::contact::law_places::LawPlaces;
use crate::contact::{Mesh, Nonlinearity};
use crate::error::check;
use crate::excitation::Wave;
use crate::model::{Channel, Machine};
use crate::trains::assembly::planet_sets::planet_sets;
use crate::trains::assembly::rows::{Layout, Row};
use crate::trains::plan::train_plan::Plan;
use crate::trains::shape::elements::{Elements, Entry, RowSpring, Shaft, Spring, Tooth, ToothRest};
use crate::trains::shape::train_shape::{Train, TrainShape};
use crate::trains::train_error::TrainError;
use std::ops::Range;

/// A train whose elements are added one after the other.
pub(crate) struct Builder<'p, N> {
    pub(crate) layout: Layout<'p, N>,
    pub(crate) shape: TrainShape<N>,
    pub(crate) constants: Constants,
}

/// The constants after the speed, each with its value.
#[derive(Default)]
pub(crate) struct Constants {
    pub(crate) torques: Vec<(Channel, f64)>,
    pub(crate) dampings: Vec<(Channel, f64)>,
    pub(crate) halves: Vec<(Channel, f64)>,
    pub(crate) frictions: Vec<(Channel, f64)>,
}

/// Units of a deflection and of its damping.
pub(crate) type Units = [&'static str; 2];
pub(crate) const ALONG: Units = ["m", "N s/m"];
pub(crate) const ABOUT: Units = ["rad", "N m s/rad"];

impl<'p, N: Nonlinearity + Clone> Builder<'p, N> {
    pub(crate) fn of(plan: &'p Plan<'p, N>) -> Self {
        let layout = Layout::of(plan);
        let frame = plan.relative.then(|| {
            let rigid = layout.rigid();
            let last = layout.angle.iter().rev().flatten().copied().find(|&at| rigid[at] != 0.0).unwrap_or(0);
            (last, rigid.iter().map(|r| r / rigid[last]).collect())
        });
        let (mut coordinates, masses) = (layout.coordinates.clone(), layout.masses.clone());
        let mut per_inertia: Vec<f64> = masses.iter().map(|mass| 1.0 / mass).collect();
        if let Some((dropped, _)) = &frame {
            coordinates.remove(*dropped);
            per_inertia = vec![1.0; coordinates.len()];
        }
        let elements = Elements { per_inertia, ..Elements::default() };
        let (sets, drawing, ratio) = (planet_sets(&layout), layout.drawing(), plan.orders.ratio);
        let (teeth, rests, places, torques, constants) = Default::default();
        let shape = TrainShape {
            coordinates,
            elements,
            teeth,
            rests,
            places,
            plain: false,
            loose: 0,
            torques,
            constants,
            sets,
            masses,
            frame,
            drawing,
            fastest: 1,
            ratio,
        };
        Builder { layout, shape, constants: Default::default() }
    }

    /// The train with the speed as its first constant.
    pub(crate) fn train(self, speed: f64) -> Result<Train<N>, TrainError> {
        let speed = (Channel::new("speed", "rad/s"), check::scale("speed", speed)?);
        let Constants { torques, dampings, halves, frictions } = self.constants;
        let constants = [vec![speed], torques, dampings, halves, frictions].concat();
        let names = constants.iter().map(|(channel, _)| channel.clone()).collect();
        let mut shape = TrainShape { constants: names, ..self.shape };
        if self.layout.plan.topology.without_units {
            let own = shape.rests.iter_mut().map(|rest| &mut rest.channel);
            let all = shape.coordinates.iter_mut().chain(&mut shape.constants).chain(own);
            all.for_each(|channel| channel.unit = "1".into());
        }
        shape.share_shafts();
        let touching = shape.teeth.len() + shape.elements.journals.len();
        shape.places = LawPlaces::of(shape.teeth.iter().map(|tooth| &tooth.law), touching);
        let values: Vec<_> = constants.iter().map(|(channel, value)| (&channel.name[..], *value)).collect();
        Ok(Machine::with_constants(shape, &values)?)
    }

    /// The row without the coordinate that is left out: levers as the algebra reads them.
    pub(crate) fn levers(&self, row: &Row) -> Vec<Entry> {
        let Some((dropped, _)) = &self.shape.frame else { return row.0.clone() };
        let kept = row.0.iter().filter(|entry| entry.at != *dropped);
        kept.map(|entry| Entry { at: self.place(entry.at), by: entry.by }).collect()
    }
    /// The accelerations that a unit of force along a row causes.
    pub(crate) fn pulls(&self, row: &Row) -> Vec<Entry> {
        let own = |entry: &Entry| Entry { at: entry.at, by: entry.by * self.per_inertia(entry.at) };
        let Some((dropped, rigid)) = &self.shape.frame else { return row.0.iter().map(own).collect() };
        // The dropped coordinate accelerates by `rest`, and all others relative to it.
        let rest: f64 = row.0.iter().filter(|entry| entry.at == *dropped).map(|entry| own(entry).by).sum();
        let mut all = vec![0.0; rigid.len()];
        row.0.iter().for_each(|entry| all[entry.at] += own(entry).by);
        let relative = |at: usize| Entry { at: self.place(at), by: all[at] - rigid[at] * rest };
        let named = row.0.iter().map(|entry| entry.at);
        let others = (0..rigid.len()).filter(|at| row.0.iter().all(|entry| entry.at != *at));
        named.chain(others).filter(|at| at != dropped).map(relative).filter(|entry| entry.by != 0.0).collect()
    }
    pub(crate) fn per_inertia(&self, at: usize) -> f64 {
        1.0 / self.layout.masses[at]
    }
    /// The place of a coordinate among those that are kept.
    fn place(&self, at: usize) -> usize {
        match &self.shape.frame {
            Some((dropped, _)) if at > *dropped => at - 1,
            _ => at,
        }
    }
    /// The accelerations that a unit of force along a row causes, as a list of the algebra.
    pub(crate) fn kept_pulls(&mut self, row: &Row) -> Range<usize> {
        let pulls = self.pulls(row);
        self.shape.elements.kept(&pulls)
    }

    /// Adds a spring and damper along a row.
    pub(crate) fn spring(&mut self, name: String, row: &Row, stiffness: f64, damping: f64) {
        let (levers, pulls) = (self.levers(row), self.pulls(row));
        if stiffness == 0.0 && damping == 0.0 || levers.is_empty() && pulls.is_empty() {
            return;
        }
        let ends = Ends::of(&levers, &pulls);
        if ends.more_levers.is_empty() && ends.more_pulls.is_empty() {
            let Ends { at, levers, pulls, .. } = ends;
            self.shape.elements.springs.push(Spring { name, ends: at, pulls, stiffness, damping, levers });
        } else {
            let (levers, pulls) = (self.shape.elements.kept(&levers), self.shape.elements.kept(&pulls));
            self.shape.elements.row_springs.push(RowSpring { name, levers, pulls, stiffness, damping });
        }
    }

    /// Adds a contact along a row, whose waves are `stiffness` and `error`. `varying`: the levers that vary.
    pub(crate) fn tooth(
        &mut self,
        channel: Channel,
        row: &Row,
        varying: Range<usize>,
        [stiffness, error]: [Wave; 2],
        mesh: Mesh<N>,
    ) {
        let Ends { at, levers, pulls, more_levers, more_pulls } =
            Ends::of(&self.levers(row), &self.pulls(row));
        let elements = &mut self.shape.elements;
        let (more_levers, more_pulls) = (elements.kept(&more_levers), elements.kept(&more_pulls));
        let [stiffness, error] = [elements.single(stiffness), elements.jet(error)].map(|place| place as u32);
        self.shape.teeth.push(Tooth {
            at,
            stiffness,
            error,
            levers,
            pulls,
            shaft: Shaft::NONE,
            law: mesh.law().clone(),
        });
        self.shape.rests.push(ToothRest { channel, more_levers, more_pulls, varying, mesh });
    }

    /// The channel of a contact, whose damping and, if it is one, half clearance become constants.
    pub(crate) fn contact(
        &mut self,
        name: &str,
        [unit, of_damping]: Units,
        damping: f64,
        half: Option<(&str, f64)>,
    ) -> Channel {
        self.constants.dampings.push((Channel::new(format!("{name} damping"), of_damping), damping));
        let half = half.map(|(what, half)| (Channel::new(format!("{name} {what}"), unit), half));
        self.constants.halves.extend(half);
        Channel::new(name, unit)
    }
}

/// A row at its first two coordinates, and the rest of it. Of one coordinate, both places are equal and the
/// second numbers are 0.
struct Ends {
    at: [u32; 2],
    levers: [f64; 2],
    pulls: [f64; 2],
    more_levers: Vec<Entry>,
    more_pulls: Vec<Entry>,
}

impl Ends {
    fn of(levers: &[Entry], pulls: &[Entry]) -> Self {
        let mut places = levers.iter().chain(pulls).map(|entry| entry.at);
        let first = places.next().unwrap_or(0);
        let second = places.find(|at| *at != first).unwrap_or(first);
        let two = |entries: &[Entry]| {
            let by = |at: usize| entries.iter().find(|entry| entry.at == at).map_or(0.0, |entry| entry.by);
            [by(first), if second == first { 0.0 } else { by(second) }]
        };
        let more = |entries: &[Entry]| {
            entries.iter().filter(|entry| ![first, second].contains(&entry.at)).copied().collect()
        };
        Ends {
            at: [first, second].map(|at| at as u32),
            levers: two(levers),
            pulls: two(pulls),
            more_levers: more(levers),
            more_pulls: more(pulls),
        }
    }
}

impl Elements {
    /// Adds entries to the list of all.
    pub(crate) fn kept(&mut self, entries: &[Entry]) -> Range<usize> {
        let start = self.entries.len();
        self.entries.extend_from_slice(entries);
        start..self.entries.len()
    }
    /// The place of a wave whose value alone is read.
    pub(crate) fn single(&mut self, wave: Wave) -> usize {
        once(&mut self.single, wave)
    }
    /// The place of a wave that is read with its rate.
    pub(crate) fn jet(&mut self, wave: Wave) -> usize {
        once(&mut self.jets, wave)
    }
}

/// The place of a wave in a list that holds each once.
fn once(list: &mut Vec<Wave>, wave: Wave) -> usize {
    list.iter().position(|known| *known == wave).unwrap_or_else(|| {
        list.push(wave);
        list.len() - 1
    })
}
