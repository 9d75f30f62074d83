//! Makes the shape and its constants from the parts.

use crate::contact::law_places::LawPlaces;
use crate::contact::laws::nonlinearity::Nonlinearity;
use crate::error::check;
use crate::excitation::wave::Wave;
use crate::model::equations::Channel;
use crate::model::machine::Machine;
use crate::trains::assembly::checks;
use crate::trains::assembly::rotation::{Rotations, rotations};
use crate::trains::assembly::rows::{Layout, Row};
use crate::trains::parts::collection::Parts;
use crate::trains::plan::kinematics::Kinematics;
use crate::trains::plan::names::Names;
use crate::trains::plan::orders::Orders;
use crate::trains::plan::places::{Planet, planets};
use crate::trains::shape::elements::{Entry, PlanetPlace, PlanetSet, RowSpring, Spring};
use crate::trains::shape::train_shape::{Train, TrainShape};
use crate::trains::shape::walk::Walk;
use crate::trains::train_error::TrainError;
use std::ops::Range;

impl<N: Nonlinearity + Clone> Parts<N> {
    /// Checks the parts and makes the model. `body` turns at the mean speed `speed` [rad/s]; the speeds of all
    /// others follow from tooth numbers.
    ///
    /// # Errors
    /// A value out of range, with its name; two parts with the same name; a name that does not exist; a mesh of a
    /// body with itself; a loop that cannot turn; a body whose speed does not follow; radii or phases that contradict
    /// tooth numbers; planets that do not assemble; [`Warning`](crate::trains::Warning)s that have not been accepted.
    pub fn build(&self, body: &str, speed: f64) -> Result<Train<N>, TrainError> {
        build(self, body, speed)
    }
}

fn build<N: Nonlinearity + Clone>(parts: &Parts<N>, body: &str, speed: f64) -> Result<Train<N>, TrainError> {
    checks::values(parts)?;
    let names = Names::of(parts)?;
    let reference = names.place("the reference", body)?;
    checks::parts(parts, &names)?;
    let kinematics = Kinematics::of(parts, &names, reference)?;
    let planets = planets(parts, &names, &kinematics)?;
    let (mut angle, mut centre, mut coordinates) = (Vec::new(), Vec::new(), Vec::new());
    for (name, body) in &parts.bodies {
        angle.push((!body.locked).then_some(coordinates.len()));
        if !body.locked {
            coordinates.push(Channel::new(format!("{name} angle"), "rad"));
        }
        let mut place = |axis: &str, there: bool| {
            there.then(|| {
                coordinates.push(Channel::new(format!("{name} {axis}"), "m"));
                coordinates.len() - 1
            })
        };
        let bearing = body.bearing.as_ref();
        centre.push([place("x", bearing.is_some_and(|b| !b.along_y)), place("y", bearing.is_some())]);
    }
    let layout = Layout { parts, kinematics: &kinematics, planets: &planets, angle, centre };
    let balances = layout.balances()?;
    let orders = Orders::of(parts, &names, &kinematics)?;
    let rotations = rotations(parts, &names, &kinematics, &orders, reference)?;
    let relative = layout.is_relative(balances);
    let mut assembly = Assembly::new(&layout, &names, &orders, &rotations, coordinates, relative);
    assembly.linear()?;
    assembly.uneven();
    assembly.torques()?;
    assembly.meshes()?;
    assembly.bearings()?;
    assembly.rotating()?;
    let (shape, values) = assembly.finish(speed)?;
    checks::held(parts, &shape)?;
    let names = shape.names.clone();
    let constants: Vec<(&str, f64)> = names.iter().map(|channel| &channel.name[..]).zip(values).collect();
    Ok(Machine::with_constants(shape, &constants)?)
}

pub(crate) struct Assembly<'p, N> {
    pub(crate) layout: &'p Layout<'p, N>,
    pub(crate) names: &'p Names,
    pub(crate) orders: &'p Orders,
    pub(crate) rotations: &'p Rotations,
    /// What a unit of generalised force along each coordinate does to the accelerations.
    pub(crate) per_inertia: Vec<f64>,
    /// The coordinate that relative coordinates leave out, and the rigid motion.
    pub(crate) dropped: Option<(usize, Vec<f64>)>,
    pub(crate) shape: TrainShape<N>,
    pub(crate) torque_values: Vec<(Channel, f64)>,
    pub(crate) dampings: Vec<(Channel, f64)>,
    pub(crate) halves: Vec<(Channel, f64)>,
    pub(crate) frictions: Vec<(Channel, f64)>,
}

impl<'p, N: Nonlinearity + Clone> Assembly<'p, N> {
    fn new(
        layout: &'p Layout<'p, N>,
        names: &'p Names,
        orders: &'p Orders,
        rotations: &'p Rotations,
        coordinates: Vec<Channel>,
        relative: bool,
    ) -> Self {
        let mut per_inertia = Vec::new();
        for (_, body) in &layout.parts.bodies {
            if !body.locked {
                per_inertia.push(1.0 / body.inertia);
            }
            if let Some(bearing) = &body.bearing {
                per_inertia
                    .extend(std::iter::repeat_n(1.0 / bearing.mass, if bearing.along_y { 1 } else { 2 }));
            }
        }
        let dropped = relative.then(|| {
            let rigid = layout.rigid(coordinates.len());
            let last = layout.angle.iter().rev().flatten().copied().find(|&at| rigid[at] != 0.0).unwrap_or(0);
            (last, rigid.iter().map(|r| r / rigid[last]).collect())
        });
        let shape = TrainShape {
            coordinates,
            per_inertia: per_inertia.clone(),
            springs: Vec::new(),
            row_springs: Vec::new(),
            rotating: Vec::new(),
            frame_ratio: 0.0,
            teeth: Vec::new(),
            rests: Vec::new(),
            places: LawPlaces::default(),
            varying: Vec::new(),
            uneven: Vec::new(),
            frictions: Vec::new(),
            journals: Vec::new(),
            motors: Vec::new(),
            entries: Vec::new(),
            single: Vec::new(),
            jets: Vec::new(),
            sets: Vec::new(),
            fastest: 1,
            spring_names: Default::default(),
            walk: None,
            torques: Vec::new(),
            masses: per_inertia.iter().map(|inverse| 1.0 / inverse).collect(),
            frame: None,
            torque_waves: Vec::new(),
            names: Vec::new(),
            contact_names: Vec::new(),
            ratio: orders.ratio,
        };
        let (torque_values, dampings, halves, frictions) = Default::default();
        Assembly {
            layout,
            names,
            orders,
            rotations,
            per_inertia,
            dropped,
            shape,
            torque_values,
            dampings,
            halves,
            frictions,
        }
    }

    /// The row without the dropped coordinate: levers as the algebra reads them.
    pub(crate) fn levers(&self, row: &Row) -> Vec<Entry> {
        let Some((dropped, _)) = &self.dropped else { return row.0.clone() };
        let kept = row.0.iter().filter(|entry| entry.at != *dropped);
        kept.map(|entry| Entry { at: self.place(entry.at), by: entry.by }).collect()
    }
    /// The accelerations that a unit of force along a row causes.
    pub(crate) fn pulls(&self, row: &Row) -> Vec<Entry> {
        let own = |entry: &Entry| Entry { at: entry.at, by: entry.by * self.per_inertia[entry.at] };
        let Some((dropped, rigid)) = &self.dropped else { return row.0.iter().map(own).collect() };
        // The dropped coordinate accelerates by `rest`, and all others relative to it.
        let rest: f64 = row.0.iter().filter(|entry| entry.at == *dropped).map(|entry| own(entry).by).sum();
        let mut all = vec![0.0; rigid.len()];
        row.0.iter().for_each(|entry| all[entry.at] += own(entry).by);
        let relative = |at: usize| Entry { at: self.place(at), by: all[at] - rigid[at] * rest };
        let named = row.0.iter().map(|entry| entry.at);
        let others = (0..rigid.len()).filter(|at| row.0.iter().all(|entry| entry.at != *at));
        named.chain(others).filter(|at| at != dropped).map(relative).filter(|entry| entry.by != 0.0).collect()
    }
    /// The place of a coordinate among those that are kept.
    fn place(&self, at: usize) -> usize {
        match &self.dropped {
            Some((dropped, _)) if at > *dropped => at - 1,
            _ => at,
        }
    }
    pub(crate) fn kept_pulls(&mut self, row: &Row) -> Range<usize> {
        let pulls = self.pulls(row);
        self.kept(&pulls)
    }
    pub(crate) fn kept(&mut self, entries: &[Entry]) -> Range<usize> {
        let start = self.shape.entries.len();
        self.shape.entries.extend_from_slice(entries);
        start..self.shape.entries.len()
    }

    /// A spring and damper along a row.
    pub(crate) fn spring(&mut self, name: String, row: &Row, stiffness: f64, damping: f64) {
        if stiffness == 0.0 && damping == 0.0 {
            return;
        }
        let (levers, pulls) = (self.levers(row), self.pulls(row));
        if levers.is_empty() && pulls.is_empty() {
            return;
        }
        if let Some((ends, [levers, pulls])) = pair(&levers, &pulls) {
            let ends = ends.map(|end| end as u32);
            self.shape.springs.push(Spring { ends, pulls, stiffness, damping, levers });
            self.shape.spring_names[0].push(name);
        } else {
            let (levers, pulls) = (self.kept(&levers), self.kept(&pulls));
            self.shape.row_springs.push(RowSpring { levers, pulls, stiffness, damping });
            self.shape.spring_names[1].push(name);
        }
    }

    /// Shafts without clearance, and what holds bodies to the ground.
    fn linear(&mut self) -> Result<(), TrainError> {
        let parts = self.layout.parts;
        for shaft in parts.shafts.iter().filter(|shaft| shaft.half_clearance.is_none()) {
            let row = self.shaft_row(&shaft.name, &shaft.ends)?;
            self.spring(shaft.name.clone(), &row, shaft.stiffness, shaft.damping);
        }
        for (body, (name, part)) in parts.bodies.iter().enumerate() {
            let row = self.layout.own(body, 1.0);
            let [stiffness, damping] = part.support;
            self.spring(format!("{name} support"), &row, stiffness, damping + part.drag);
        }
        Ok(())
    }
    pub(crate) fn shaft_row(&self, name: &str, ends: &[String; 2]) -> Result<Row, TrainError> {
        Ok(self.layout.shaft(self.names.pair(name, ends)?))
    }

    /// Whether a body that turns has a torsional support.
    fn turning_support(&self) -> bool {
        self.layout.parts.bodies.iter().any(|(_, body)| !body.held && body.support != [0.0; 2])
    }

    /// The shape with all names, and the values of its constants.
    fn finish(self, speed: f64) -> Result<(TrainShape<N>, Vec<f64>), TrainError> {
        let turning_support = self.turning_support();
        let mut shape = self.shape;
        let sideways: Vec<bool> = shape.coordinates.iter().map(|channel| channel.unit == "m").collect();
        if let Some((dropped, _)) = &self.dropped {
            let part = [
                (self.layout.parts.rotating.is_some(), "a rotating frame"),
                (!shape.motors.is_empty(), "a torque over the speed"),
                (!shape.varying.is_empty(), "a noncircular gear"),
                (self.layout.parts.bodies.iter().any(|body| body.1.drag != 0.0), "drag"),
                (turning_support, "the support of a body that turns"),
            ];
            if let Some((_, part)) = part.iter().find(|(there, _)| *there) {
                return Err(TrainError::NotRelative { part: (*part).into() });
            }
            shape.coordinates.remove(*dropped);
            // Torques are prepared as accelerations.
            shape.per_inertia = vec![1.0; shape.coordinates.len()];
        }
        shape.frame = self.dropped;
        {
            let planets = self.layout.planets.iter().flatten();
            let mut carriers: Vec<usize> = planets.map(|planet| planet.carrier).collect();
            carriers.sort_unstable();
            carriers.dedup();
            let place = |(body, planet): (usize, &Planet)| PlanetPlace {
                at: self.layout.angle[body],
                centre: match self.layout.centre[body] {
                    [Some(x), Some(_)] => Some(x),
                    _ => None,
                },
                angle: planet.angle,
            };
            let parts = self.layout.parts;
            let of = |carrier: usize| {
                let carried = |body: usize| {
                    self.layout.planets[body].as_ref().filter(|planet| planet.carrier == carrier)
                };
                let mut bodies = vec![carrier];
                for (name, ends, _) in &parts.meshes {
                    let Ok([a, b]) = self.names.pair(name, ends) else { continue };
                    match (carried(a), carried(b)) {
                        (Some(_), None) => bodies.push(b),
                        (None, Some(_)) => bodies.push(a),
                        _ => {}
                    }
                }
                bodies.sort_unstable();
                bodies.dedup();
                let own = |body: usize| [self.layout.angle[body]].into_iter().chain(self.layout.centre[body]);
                let planets = (0..parts.bodies.len()).filter_map(|body| Some(place((body, carried(body)?))));
                let central = bodies.into_iter().flat_map(own).flatten().map(|at| (at, sideways[at]));
                PlanetSet { planets: planets.collect(), central: central.collect() }
            };
            shape.sets = carriers.into_iter().map(of).collect();
        }
        // Couplings stand among the teeth, journals after them: in the order of the constants.
        let speed = (Channel::new("speed", "rad/s"), check::scale("speed", speed)?);
        let (names, values) = std::iter::once(speed)
            .chain(self.torque_values)
            .chain(self.dampings)
            .chain(self.halves)
            .chain(self.frictions)
            .unzip();
        shape.names = names;
        let touching = shape.teeth.len() + shape.journals.len();
        shape.places = LawPlaces::of(shape.teeth.iter().map(|tooth| &tooth.law), touching);
        shape.walk = Walk::of(&shape);
        Ok((shape, values))
    }
}

/// A row of at most two coordinates as ends, levers and pulls.
fn pair(levers: &[Entry], pulls: &[Entry]) -> Option<([usize; 2], [[f64; 2]; 2])> {
    let mut ends: Vec<usize> = levers.iter().chain(pulls).map(|entry| entry.at).collect();
    let mut seen = Vec::new();
    ends.retain(|at| {
        !seen.contains(at) && {
            seen.push(*at);
            true
        }
    });
    let ends = match ends[..] {
        [one] => [one, one],
        [one, two] => [one, two],
        _ => return None,
    };
    let by = |entries: &[Entry]| {
        let of = |at: usize| entries.iter().find(|entry| entry.at == at).map_or(0.0, |entry| entry.by);
        [of(ends[0]), if ends[0] == ends[1] { 0.0 } else { of(ends[1]) }]
    };
    Some((ends, [by(levers), by(pulls)]))
}

/// The place of a wave in a list that holds each once.
pub(crate) fn once(list: &mut Vec<Wave>, wave: Wave) -> usize {
    list.iter().position(|known| *known == wave).unwrap_or_else(|| {
        list.push(wave);
        list.len() - 1
    })
}
