//! Makes the shape and its constants from the parts.

use crate::contact::laws::backlash::Backlash;
use crate::contact::laws::nonlinearity::Nonlinearity;
use crate::contact::mesh::{ContactDamping, Mesh};
use crate::error::check;
use crate::excitation::angle::Constant;
use crate::excitation::combine::{Product, Sum};
use crate::excitation::wave::Wave;
use crate::model::equations::Channel;
use crate::model::machine::Machine;
use crate::trains::build::checks;
use crate::trains::build::fraction::Fraction;
use crate::trains::build::kinematics::Kinematics;
use crate::trains::build::names::Names;
use crate::trains::build::orders::Orders;
use crate::trains::build::places::{Planet, planets, snapped};
use crate::trains::build::rows::{Layout, Row};
use crate::trains::build::train_error::TrainError;
use crate::trains::parts::collection::{Coordinates, Course, Parts};
use crate::trains::shape::elements::{
    Entry, Friction, Journal, Motor, PlanetPlace, Rotating, RowSpring, Spring, Tooth, ToothRest,
};
use crate::trains::shape::train_shape::{Train, TrainShape};
use std::f64::consts::TAU;
use std::ops::Range;

pub(crate) fn build<N: Nonlinearity + Clone>(
    parts: &Parts<N>,
    body: &str,
    speed: f64,
) -> Result<Train<N>, TrainError> {
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
    checks::train(&layout, &names)?;
    let orders = Orders::of(parts, &names, &kinematics)?;
    let mut assembly = Assembly::new(&layout, &names, &orders, coordinates);
    assembly.linear()?;
    assembly.torques()?;
    assembly.meshes()?;
    assembly.bearings()?;
    assembly.rotating()?;
    let (shape, values) = assembly.finish(speed)?;
    checks::balance(&layout, &shape)?;
    let names = shape.names.clone();
    let constants: Vec<(&str, f64)> = names.iter().map(|channel| &channel.name[..]).zip(values).collect();
    Ok(Machine::with_constants(shape, &constants)?)
}

struct Assembly<'p, N> {
    layout: &'p Layout<'p, N>,
    names: &'p Names,
    orders: &'p Orders,
    /// What a unit of generalised force along each coordinate does to the accelerations.
    per_inertia: Vec<f64>,
    /// The coordinate that relative coordinates leave out, and the rigid motion.
    dropped: Option<(usize, Vec<f64>)>,
    shape: TrainShape<N>,
    torque_values: Vec<(Channel, f64)>,
    dampings: Vec<(Channel, f64)>,
    halves: Vec<(Channel, f64)>,
    frictions: Vec<(Channel, f64)>,
}

impl<'p, N: Nonlinearity + Clone> Assembly<'p, N> {
    fn new(layout: &'p Layout<'p, N>, names: &'p Names, orders: &'p Orders, coordinates: Vec<Channel>) -> Self {
        let mut per_inertia = Vec::new();
        for (_, body) in &layout.parts.bodies {
            if !body.locked {
                per_inertia.push(1.0 / body.inertia);
            }
            if let Some(bearing) = &body.bearing {
                per_inertia.extend(std::iter::repeat_n(1.0 / bearing.mass, if bearing.along_y { 1 } else { 2 }));
            }
        }
        let dropped = (layout.parts.coordinates == Coordinates::Relative).then(|| {
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
            frictions: Vec::new(),
            journals: Vec::new(),
            motors: Vec::new(),
            entries: Vec::new(),
            single: Vec::new(),
            errors: Vec::new(),
            sets: Vec::new(),
            spring_names: Default::default(),
            plain: false,
            torques: Vec::new(),
            torque_waves: Vec::new(),
            names: Vec::new(),
            ratio: orders.ratio,
        };
        let (torque_values, dampings, halves, frictions) = Default::default();
        Assembly {
            layout,
            names,
            orders,
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
    fn levers(&self, row: &Row) -> Vec<Entry> {
        let Some((dropped, _)) = &self.dropped else { return row.0.clone() };
        let kept = row.0.iter().filter(|entry| entry.at != *dropped);
        kept.map(|entry| Entry { at: self.place(entry.at), by: entry.by }).collect()
    }
    /// The accelerations that a unit of force along a row causes.
    fn pulls(&self, row: &Row) -> Vec<Entry> {
        let own = |entry: &Entry| Entry { at: entry.at, by: entry.by * self.per_inertia[entry.at] };
        let Some((dropped, rigid)) = &self.dropped else { return row.0.iter().map(own).collect() };
        // The dropped coordinate accelerates by `rest`, and all others relative to it.
        let rest: f64 = row.0.iter().filter(|entry| entry.at == *dropped).map(|entry| own(entry).by).sum();
        let mut all = vec![0.0; rigid.len()];
        row.0.iter().for_each(|entry| all[entry.at] += own(entry).by);
        let relative = |at: usize| Entry { at: self.place(at), by: all[at] - rigid[at] * rest };
        let named = row.0.iter().map(|entry| entry.at);
        let others = (0..rigid.len()).filter(|at| row.0.iter().all(|entry| entry.at != *at));
        named
            .chain(others)
            .filter(|at| at != dropped)
            .map(relative)
            .filter(|entry| entry.by != 0.0)
            .collect()
    }
    /// The place of a coordinate among those that are kept.
    fn place(&self, at: usize) -> usize {
        match &self.dropped {
            Some((dropped, _)) if at > *dropped => at - 1,
            _ => at,
        }
    }
    fn kept(&mut self, entries: &[Entry]) -> Range<usize> {
        let start = self.shape.entries.len();
        self.shape.entries.extend_from_slice(entries);
        start..self.shape.entries.len()
    }

    /// A spring and damper along a row.
    fn spring(&mut self, name: String, row: &Row, stiffness: f64, damping: f64) {
        if stiffness == 0.0 && damping == 0.0 {
            return;
        }
        let (levers, pulls) = (self.levers(row), self.pulls(row));
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
    fn shaft_row(&self, name: &str, ends: &[String; 2]) -> Result<Row, TrainError> {
        Ok(self.layout.shaft(self.names.pair(name, ends)?))
    }

    /// Torques: waves and motors first, then those that are constant.
    fn torques(&mut self) -> Result<(), TrainError> {
        let parts = self.layout.parts;
        let constant = |torque: &&crate::trains::parts::collection::TorquePart| torque.course == Course::Constant;
        let waves = parts.torques.iter().filter(|torque| matches!(torque.course, Course::OfAngle(_)));
        let motors = parts.torques.iter().filter(|torque| matches!(torque.course, Course::Motor { .. }));
        for (place, torque) in waves.chain(motors).enumerate() {
            let body = self.names.place(&torque.name, &torque.body)?;
            // A torque drives: its pull is that of a force against its row.
            let row = self.layout.own(body, -1.0);
            let pulls = self.pulls(&row);
            let pulls = self.kept(&pulls);
            match &torque.course {
                Course::OfAngle(wave) => {
                    let wave = self.turning(&torque.name, wave, self.orders.turn(body))?;
                    let wave = once(&mut self.shape.single, wave);
                    self.shape.torque_waves.push((wave, place, pulls));
                }
                Course::Motor { breakdown_slip, synchronous } => self.shape.motors.push(Motor {
                    at: self.layout.angle[body].unwrap_or(0),
                    pulls,
                    ratio: self.layout.kinematics.speeds[body].value().abs() / self.orders.ratio,
                    torque: place,
                    breakdown_slip: *breakdown_slip,
                    synchronous: *synchronous,
                }),
                Course::Constant => {}
            }
            self.shape.torques.push(Vec::new());
            self.torque_values.push((Channel::new(&torque.name, "N m"), torque.value));
        }
        for torque in parts.torques.iter().filter(constant) {
            let body = self.names.place(&torque.name, &torque.body)?;
            let row = self.layout.own(body, 1.0);
            self.shape.torques.push(if self.dropped.is_some() { self.pulls(&row) } else { row.0 });
            self.torque_values.push((Channel::new(&torque.name, "N m"), torque.value));
        }
        Ok(())
    }

    /// A wave over the turn of a body or over a mesh angle as a wave of φ.
    fn turning(&self, part: &str, wave: &Wave, order: Option<Fraction>) -> Result<Wave, TrainError> {
        self.orders.wave(part, wave, order)
    }

    fn meshes(&mut self) -> Result<(), TrainError> {
        let parts = self.layout.parts;
        for (name, ends, part) in &parts.meshes {
            let bodies = self.names.pair(name, ends)?;
            let [row, friction] = self.layout.mesh(name, bodies, part)?;
            let carrier = self.names.carrier_of(parts, name, bodies)?;
            let planet = bodies.iter().find_map(|&body| self.layout.planets[body].as_ref());
            let place = planet.map_or(0.0, |planet| planet.ahead);
            let ahead = snapped(place + part.phase);
            if let Some(stated) = part.stated_phase {
                let gap = snapped(stated - ahead);
                if gap.min(1.0 - gap) > 1e-6 {
                    return Err(TrainError::PhaseContradicts { mesh: name.clone(), stated, computed: ahead });
                }
            }
            let relative = |gear: usize| self.layout.kinematics.relative(bodies[gear], carrier).map(Fraction::abs);
            let tooth = relative(0).and_then(|speed| speed.times(Fraction::whole(part.teeth[0].into())));
            let tooth_order = self.orders.order(tooth);
            let along = |wave: &Wave| -> Result<Wave, TrainError> {
                Ok(self.turning(name, wave, tooth)?.with_phase(TAU * ahead)?)
            };
            let (mut stiffness, mut error) = (vec![along(&part.stiffness)?], vec![along(&part.error)?]);
            for gear in [0, 1] {
                if let Some(wave) = &part.faults[gear] {
                    stiffness.push(self.turning(name, wave, relative(gear))?);
                }
                if let Some(wave) = &part.runout[gear] {
                    error.push(self.turning(name, wave, relative(gear))?);
                }
            }
            let stiffness = one_of(stiffness, |waves| Wave::new(Product::new(waves)));
            let error = one_of(error, |waves| Wave::new(Sum::new(waves)));
            let mesh = Mesh::new(Wave::new(Constant::zero()), Wave::new(Constant::zero()), part.law.clone())
                .with_contact_damping(part.contact_damping)
                .per_turn(tooth_order.unwrap_or(1))?;
            self.tooth(&row, [stiffness, error], mesh);
            self.dampings.push((Channel::new(format!("{name} damping"), "N s/m"), part.damping));
            if N::HALF_WIDTH {
                self.halves.push((Channel::new(format!("{name} half backlash"), "m"), part.half_backlash));
            }
            if let Some(part) = &part.friction {
                let pulls = self.pulls(&friction);
                let pulls = self.kept(&pulls);
                let sign = self.turning(name, &part.sign, tooth)?.with_phase(TAU * ahead)?;
                let sign = once(&mut self.shape.single, sign);
                self.shape.frictions.push(Friction { tooth: self.shape.teeth.len() - 1, sign, pulls });
                self.frictions.push((Channel::new(format!("{name} friction"), "1"), part.coefficient));
            }
        }
        for shaft in &parts.shafts {
            let Some(half) = shaft.half_clearance else { continue };
            // Couplings have the law of the meshes: `Parts::shaft_with_clearance` exists for Backlash alone.
            let Some((_, _, mesh)) = parts.meshes.first() else {
                return Err(TrainError::CouplingAlone { shaft: shaft.name.clone() });
            };
            let row = self.shaft_row(&shaft.name, &shaft.ends)?;
            let mesh = Mesh::new(Wave::new(Constant::zero()), Wave::new(Constant::zero()), mesh.law.clone());
            let waves = [Wave::constant(shaft.stiffness)?, Wave::new(Constant::zero())];
            self.tooth(&row, waves, mesh);
            self.dampings.push((Channel::new(format!("{} damping", shaft.name), "N m s/rad"), shaft.damping));
            self.halves.push((Channel::new(format!("{} half backlash", shaft.name), "rad"), half));
        }
        Ok(())
    }
    fn tooth(&mut self, row: &Row, [stiffness, error]: [Wave; 2], mesh: Mesh<N>) {
        let (levers, pulls) = (self.levers(row), self.pulls(row));
        let at = match levers[..] {
            [] => [0, 0],
            [one] => [one.at, pulls.iter().map(|pull| pull.at).find(|at| *at != one.at).unwrap_or(one.at)],
            [one, two, ..] => [one.at, two.at],
        };
        let ([levers, more_levers], [pulls, more_pulls]) = (split(at, &levers), split(at, &pulls));
        let two = |entries: &[Entry]| {
            let by = |at: usize| entries.iter().find(|entry| entry.at == at).map_or(0.0, |entry| entry.by);
            [by(at[0]), if at[1] == at[0] { 0.0 } else { by(at[1]) }]
        };
        let (levers, pulls) = (two(&levers), two(&pulls));
        let (more_levers, more_pulls) = (self.kept(&more_levers), self.kept(&more_pulls));
        let stiffness = once(&mut self.shape.single, stiffness);
        let error = once(&mut self.shape.errors, error);
        let (at, law) = (at.map(|at| at as u32), mesh.law().clone());
        let [stiffness, error] = [stiffness, error].map(|place| place as u32);
        self.shape.teeth.push(Tooth { at, stiffness, error, levers, pulls, law });
        self.shape.rests.push(ToothRest { more_levers, more_pulls, mesh });
    }

    fn bearings(&mut self) -> Result<(), TrainError> {
        let parts = self.layout.parts;
        for (body, (name, part)) in parts.bodies.iter().enumerate() {
            let Some(bearing) = part.bearing else { continue };
            let rows = self.layout.bearing(body);
            if bearing.clearance == 0.0 {
                for (axis, row) in rows.iter().enumerate() {
                    let name = format!("{name} bearing {}", ["x", "y"][axis]);
                    self.spring(name, row, bearing.stiffness[axis], bearing.damping[axis]);
                }
                continue;
            }
            let [levers, pulls] = [rows.each_ref().map(|row| self.levers(row)), rows.map(|row| self.pulls(&row))];
            let levers = levers.map(|entries| self.kept(&entries));
            let pulls = pulls.map(|entries| self.kept(&entries));
            let law = Backlash::new(0.0)?;
            let least = (1e-9 * bearing.clearance).powi(2);
            let stiffness = bearing.stiffness[0];
            self.shape.journals.push(Journal { levers, pulls, stiffness, least, law });
            self.dampings.push((Channel::new(format!("{name} bearing damping"), "N s/m"), bearing.damping[0]));
            self.halves.push((Channel::new(format!("{name} bearing half clearance"), "m"), bearing.clearance));
        }
        Ok(())
    }

    /// Gyroscopic and centripetal terms of all masses, and bearing dampers at rest, seen from a rotating frame.
    fn rotating(&mut self) -> Result<(), TrainError> {
        let parts = self.layout.parts;
        let Some(carrier) = &parts.rotating else { return Ok(()) };
        let carrier = self.names.place("the rotating frame", carrier)?;
        // x and y are counterclockwise from each other; the frame turns with the sense of the carrier.
        self.shape.frame_ratio = self.layout.kinematics.speeds[carrier].value() / self.orders.ratio;
        for (body, (name, part)) in parts.bodies.iter().enumerate() {
            let (Some(bearing), [x, Some(y)]) = (part.bearing, self.layout.centre[body]) else { continue };
            let planet = self.layout.planets[body].is_some();
            let [c, other] = bearing.damping;
            if !planet && (c != other || bearing.stiffness[0] != bearing.stiffness[1]) {
                let why = "its directions turn in a rotating frame";
                return Err(TrainError::NotIsotropic { body: name.clone(), why });
            }
            // The damper of a planet's bearing turns with the carrier.
            let damping = if planet { 0.0 } else { c / bearing.mass };
            let Some(x) = x else {
                let why = "its directions turn in a rotating frame";
                return Err(TrainError::NotIsotropic { body: name.clone(), why });
            };
            for (i, j, way) in [(x, y, -1.0), (y, x, 1.0)] {
                let (damping, gyroscopic) = (way * damping, way * 2.0);
                self.shape.rotating.push(Rotating { i, j, damping, gyroscopic, centripetal: 0.0 });
            }
            for i in [x, y] {
                self.shape.rotating.push(Rotating { i, j: i, damping: 0.0, gyroscopic: 0.0, centripetal: -1.0 });
            }
        }
        Ok(())
    }

    /// Whether a body that turns has a torsional support.
    fn turning_support(&self) -> bool {
        self.layout.parts.bodies.iter().any(|(_, body)| !body.held && body.support != [0.0; 2])
    }

    /// The shape with all names, and the values of its constants.
    fn finish(self, speed: f64) -> Result<(TrainShape<N>, Vec<f64>), TrainError> {
        let turning_support = self.turning_support();
        let mut shape = self.shape;
        if let Some((dropped, _)) = &self.dropped {
            let part = [
                (self.layout.parts.rotating.is_some(), "a rotating frame"),
                (!shape.motors.is_empty(), "a motor"),
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
        if self.dropped.is_none() {
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
            let of = |carrier: usize| {
                let all = self.layout.planets.iter().enumerate();
                all.filter_map(|(body, planet)| Some((body, planet.as_ref()?)))
                    .filter(|(_, planet)| planet.carrier == carrier)
                    .map(place)
                    .collect()
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
        let two = |spring: &Spring| spring.levers == [1.0, -1.0];
        shape.plain = shape.springs.iter().all(two)
            && shape.rests.iter().all(|rest| rest.more_levers.is_empty() && rest.more_pulls.is_empty())
            && shape.rests.iter().all(|rest| rest.mesh.contact_damping() == ContactDamping::Always)
            && shape.row_springs.is_empty()
            && shape.rotating.is_empty()
            && shape.frictions.is_empty()
            && shape.journals.is_empty()
            && shape.motors.is_empty()
            && shape.torque_waves.is_empty();
        Ok((shape, values))
    }
}

/// A row of at most two coordinates as ends, levers and pulls.
fn pair(levers: &[Entry], pulls: &[Entry]) -> Option<([usize; 2], [[f64; 2]; 2])> {
    let mut ends: Vec<usize> = levers.iter().chain(pulls).map(|entry| entry.at).collect();
    let mut seen = Vec::new();
    ends.retain(|at| !seen.contains(at) && { seen.push(*at); true });
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

/// Entries at two places, and all others.
fn split(at: [usize; 2], entries: &[Entry]) -> [Vec<Entry>; 2] {
    let (two, more) = entries.iter().partition(|entry| at.contains(&entry.at));
    [two, more]
}

/// The only wave, or a combination of several.
fn one_of(mut waves: Vec<Wave>, combined: impl Fn(Vec<Wave>) -> Wave) -> Wave {
    if waves.len() > 1 { combined(waves) } else { waves.remove(0) }
}

/// The place of a wave in a list that holds each once.
fn once(list: &mut Vec<Wave>, wave: Wave) -> usize {
    list.iter().position(|known| *known == wave).unwrap_or_else(|| {
        list.push(wave);
        list.len() - 1
    })
}
