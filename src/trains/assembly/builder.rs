//! Adds elements to the algebra of a train by their rows.

use crate::contact::law_places::LawPlaces;
use crate::contact::{ContactDamping, Mesh, Nonlinearity};
use crate::error::check;
use crate::excitation::Wave;
use crate::model::{Channel, Machine};
use crate::trains::assembly::planet_sets::planet_sets;
use crate::trains::assembly::rows::{Layout, Row};
use crate::trains::plan::train_plan::Plan;
use crate::trains::shape::drawing::Shown;
use crate::trains::shape::elements::{Elements, Entry, RowSpring, Shaft, Spring, Tooth, ToothRest};
use crate::trains::shape::train_shape::{Train, TrainShape};
use crate::trains::train_error::TrainError;
use std::ops::Range;

/// A train whose elements are added one after the other.
pub(crate) struct Builder<'p, N> {
    pub(crate) layout: Layout<'p, N>,
    /// In relative coordinates: the coordinate that is left out, and the rigid motion, which is 1 there.
    pub(crate) frame: Option<(usize, Vec<f64>)>,
    pub(crate) elements: Elements,
    pub(crate) teeth: Vec<Tooth<N>>,
    pub(crate) rests: Vec<ToothRest<N>>,
    pub(crate) torques: Vec<Vec<Entry>>,
    pub(crate) constants: Constants,
    /// Order of the fastest mesh.
    pub(crate) fastest: u32,
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
        let per_inertia = match &frame {
            Some(_) => vec![1.0; layout.masses.len() - 1],
            None => layout.masses.iter().map(|mass| 1.0 / mass).collect(),
        };
        let elements = Elements { per_inertia, ..Elements::default() };
        let (teeth, rests, torques, constants) = Default::default();
        Builder { layout, frame, elements, teeth, rests, torques, constants, fastest: 1 }
    }

    /// The train with the speed as its first constant.
    pub(crate) fn train(mut self, speed: f64) -> Result<Train<N>, TrainError> {
        let speed = (Channel::new("speed", "rad/s"), check::scale("speed", speed)?);
        let (plain, loose) = self.share_shafts();
        let (sets, drawing) = (planet_sets(&self.layout), Shown(self.layout.drawing()));
        let inertia = self.inertia();
        let Builder { layout, frame, elements, teeth, mut rests, torques, constants, fastest } = self;
        let mut coordinates = layout.coordinates;
        if let Some((dropped, _)) = &frame {
            coordinates.remove(*dropped);
        }
        let Constants { torques: of_torques, dampings, halves, frictions } = constants;
        let constants = [vec![speed], of_torques, dampings, halves, frictions].concat();
        let (mut constants, values): (Vec<_>, Vec<_>) = constants.into_iter().unzip();
        if layout.plan.topology.without_units {
            let own = rests.iter_mut().map(|rest| &mut rest.channel);
            let all = coordinates.iter_mut().chain(&mut constants).chain(own);
            all.for_each(|channel| channel.unit = "1".into());
        }
        let touching = teeth.len() + elements.journals.len();
        let places = LawPlaces::of(teeth.iter().map(|tooth| &tooth.law), touching);
        let (masses, ratio) = (layout.masses, layout.plan.orders.ratio);
        #[rustfmt::skip]
        let shape = TrainShape {
            coordinates, elements, teeth, rests, places, plain, loose, torques, constants, sets, masses, inertia,
            frame, drawing, fastest, ratio,
        };
        let names = shape.constants.clone();
        let values: Vec<_> = names.iter().map(|channel| &channel.name[..]).zip(values).collect();
        Ok(Machine::of_constants(shape, &values)?)
    }

    /// Finds whether the train is plain and, if it is, moves a shaft of its first coordinate to each mesh.
    /// Returns the number of springs that no mesh evaluates, too: they come first.
    fn share_shafts(&mut self) -> (bool, usize) {
        let Elements { per_inertia, springs, single, jets, .. } = self.elements.clone();
        let plain = springs.iter().all(|spring| spring.levers == [1.0, -1.0])
            && self.rests.iter().all(|rest| rest.mesh.contact_damping() == ContactDamping::Always)
            && self.elements == Elements { per_inertia, springs, single, jets, ..Elements::default() };
        let mut loose = self.elements.springs.len();
        for tooth in self.teeth.iter_mut().filter(|_| plain) {
            let springs = &mut self.elements.springs[..loose];
            let place = springs.iter().position(|spring| spring.ends.contains(&tooth.at[0]));
            let Some(place) = place else { continue };
            tooth.shaft = springs[place].shaft_of(tooth.at[0]);
            springs[place..].rotate_left(1);
            loose -= 1;
        }
        (plain, loose)
    }

    /// The row without the coordinate that is left out: levers as the algebra reads them.
    pub(crate) fn levers(&self, row: &Row) -> Vec<Entry> {
        let Some((dropped, _)) = &self.frame else { return row.0.clone() };
        let kept = row.0.iter().filter(|entry| entry.at != *dropped);
        kept.map(|entry| Entry { at: self.place(entry.at), by: entry.by }).collect()
    }
    /// The accelerations that a unit of force along a row causes.
    pub(crate) fn pulls(&self, row: &Row) -> Vec<Entry> {
        let own = |entry: &Entry| Entry { at: entry.at, by: entry.by * self.per_inertia(entry.at) };
        let Some((dropped, rigid)) = &self.frame else { return row.0.iter().map(own).collect() };
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
        match &self.frame {
            Some((dropped, _)) if at > *dropped => at - 1,
            _ => at,
        }
    }
    /// The accelerations that a unit of force along a row causes, as a list of the algebra.
    pub(crate) fn kept_pulls(&mut self, row: &Row) -> Range<usize> {
        let pulls = self.pulls(row);
        self.elements.kept(&pulls)
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
            self.elements.springs.push(Spring { name, ends: at, pulls, stiffness, damping, levers });
        } else {
            let (levers, pulls) = (self.elements.kept(&levers), self.elements.kept(&pulls));
            self.elements.row_springs.push(RowSpring { name, levers, pulls, stiffness, damping });
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
        let elements = &mut self.elements;
        let (more_levers, more_pulls) = (elements.kept(&more_levers), elements.kept(&more_pulls));
        let [stiffness, error] = [elements.single(stiffness), elements.jet(error)].map(|place| place as u32);
        self.teeth.push(Tooth {
            at,
            stiffness,
            error,
            levers,
            pulls,
            shaft: Shaft::NONE,
            law: mesh.law().clone(),
        });
        self.rests.push(ToothRest { channel, more_levers, more_pulls, varying, mesh });
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
