//! Meshes, couplings and bearings of a train.

use crate::contact::laws::backlash::Backlash;
use crate::contact::laws::nonlinearity::Nonlinearity;
use crate::contact::mesh::Mesh;
use crate::excitation::angle::Constant;
use crate::excitation::combine::{Product, Sum};
use crate::excitation::wave::Wave;
use crate::model::channel::Channel;
use crate::trains::assembly::assemble::{Assembly, once};
use crate::trains::assembly::rows::Row;
use crate::trains::plan::fraction::Fraction;
use crate::trains::plan::phases::phases;
use crate::trains::shape::elements::{Entry, Friction, Journal, Rotating, Tooth, ToothRest};
use crate::trains::train_error::TrainError;
use std::f64::consts::TAU;
use std::ops::Range;

impl<N: Nonlinearity + Clone> Assembly<'_, N> {
    /// Meshes, then shafts with a clearance.
    pub(crate) fn meshes(&mut self) -> Result<(), TrainError> {
        let parts = self.layout.parts;
        let phases = phases(parts, self.names, self.layout.kinematics, self.layout.planets)?;
        for ((name, ends, part), ahead) in parts.meshes.iter().zip(phases) {
            let bodies = self.names.pair(name, ends)?;
            let [mut row, friction] = self.layout.mesh(name, bodies, part)?;
            let varying = self.levers_that_vary(name, bodies, part, &mut row)?;
            self.teeth_turn_evenly(name, bodies, part)?;
            let carrier = self.names.carrier_of(parts, name, bodies)?;
            let relative =
                |gear: usize| self.layout.kinematics.relative(bodies[gear], carrier).map(Fraction::abs);
            let relative_speed = |gear: usize| {
                self.layout.kinematics.relative(bodies[gear], carrier).map_or(0.0, Fraction::value)
            };
            let tooth = relative(0).and_then(|speed| speed.times(Fraction::whole(part.teeth[0].into())));
            let tooth_order = self.orders.order(tooth);
            self.shape.fastest = self.shape.fastest.max(tooth_order.unwrap_or(1));
            let along = |wave: &Wave| -> Result<Wave, TrainError> {
                if Wave::divisor_of_orders([wave]) == 0 {
                    return Ok(wave.clone());
                }
                let shifted = wave.clone().with_phase(TAU * ahead * f64::from(wave.order()))?;
                self.orders.wave(name, &shifted, tooth)
            };
            if part.law.moves() {
                if ahead != 0.0 {
                    return Err(TrainError::MovingEdges { mesh: name.clone() });
                }
                if tooth_order.is_none() {
                    return Err(TrainError::AtRest { part: name.clone() });
                }
            }
            // A tooth of a central gear reaches the planets one after the other.
            let turning = |gear: usize, wave: &Wave| -> Result<Wave, TrainError> {
                let place = self.layout.planets[bodies[1 - gear]].as_ref();
                let central = place.filter(|_| self.layout.planets[bodies[gear]].is_none());
                let way = if relative_speed(gear) >= 0.0 { -1.0 } else { 1.0 };
                let shift = central.map_or(0.0, |planet| way * planet.angle * f64::from(wave.order()));
                self.orders.wave(name, &wave.clone().with_phase(shift)?, relative(gear))
            };
            let (mut stiffness, mut error) = (vec![along(&part.stiffness)?], vec![along(&part.error)?]);
            for gear in [0, 1] {
                if part.faults[gear].is_some() || part.runout[gear].is_some() {
                    self.follows(name, bodies[gear])?;
                }
                if let Some(wave) = &part.faults[gear] {
                    stiffness.push(turning(gear, wave)?);
                }
                if let Some(wave) = &part.runout[gear] {
                    error.push(turning(gear, wave)?);
                }
            }
            let stiffness = one_of(stiffness, |waves| Wave::new(Product::new(waves)));
            let error = one_of(error, |waves| Wave::new(Sum::new(waves)));
            let mesh = Mesh::new(Wave::new(Constant::zero()), Wave::new(Constant::zero()), part.law.clone())
                .with_contact_damping(part.contact_damping)
                .per_turn(tooth_order.unwrap_or(1))?;
            self.tooth(&row, varying, [stiffness, error], mesh);
            self.shape.contact_names.push(Channel::new(name, "m"));
            self.dampings.push((Channel::new(format!("{name} damping"), "N s/m"), part.damping));
            if N::HALF_WIDTH {
                self.halves.push((Channel::new(format!("{name} half backlash"), "m"), part.half_backlash));
            }
            if let Some(part) = &part.friction {
                let pulls = self.pulls(&friction);
                let pulls = self.kept(&pulls);
                let sign = part.sign.clone().with_phase(TAU * ahead * f64::from(part.sign.order()))?;
                let sign = self.orders.wave(name, &sign, tooth)?;
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
            self.tooth(&row, 0..0, waves, mesh);
            self.shape.contact_names.push(Channel::new(&shaft.name, "rad"));
            self.dampings.push((Channel::new(format!("{} damping", shaft.name), "N m s/rad"), shaft.damping));
            self.halves.push((Channel::new(format!("{} half backlash", shaft.name), "rad"), half));
        }
        Ok(())
    }
    fn tooth(&mut self, row: &Row, varying: Range<usize>, [stiffness, error]: [Wave; 2], mesh: Mesh<N>) {
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
        let error = once(&mut self.shape.jets, error);
        let (at, law) = (at.map(|at| at as u32), mesh.law().clone());
        let [stiffness, error] = [stiffness, error].map(|place| place as u32);
        self.shape.teeth.push(Tooth { at, stiffness, error, levers, pulls, law });
        self.shape.rests.push(ToothRest { more_levers, more_pulls, varying, mesh });
    }

    pub(crate) fn bearings(&mut self) -> Result<(), TrainError> {
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
            let [levers, pulls] =
                [rows.each_ref().map(|row| self.levers(row)), rows.map(|row| self.pulls(&row))];
            let levers = levers.map(|entries| self.kept(&entries));
            let pulls = pulls.map(|entries| self.kept(&entries));
            let law = Backlash::new(0.0)?;
            let least = (1e-9 * bearing.clearance).powi(2);
            let stiffness = bearing.stiffness[0];
            self.shape.journals.push(Journal { levers, pulls, stiffness, least, law });
            self.shape.contact_names.push(Channel::new(format!("{name} bearing"), "m"));
            self.dampings
                .push((Channel::new(format!("{name} bearing damping"), "N s/m"), bearing.damping[0]));
            self.halves
                .push((Channel::new(format!("{name} bearing half clearance"), "m"), bearing.clearance));
        }
        Ok(())
    }

    /// Gyroscopic and centripetal terms of all masses, and bearing dampers at rest, seen from a rotating frame.
    pub(crate) fn rotating(&mut self) -> Result<(), TrainError> {
        let parts = self.layout.parts;
        let Some(carrier) = &parts.rotating else { return Ok(()) };
        let carrier = self.names.place("the rotating frame", carrier)?;
        self.follows("the rotating frame", carrier)?;
        for (name, ends, _) in &parts.meshes {
            let pair = self.names.pair(name, ends)?;
            let moves = pair.iter().any(|&body| parts.bodies[body].1.bearing.is_some());
            if moves && self.names.carrier_of(parts, name, pair)? != Some(carrier) {
                let why = "its line of action stands still";
                return Err(TrainError::NotRotating { part: name.clone(), why });
            }
        }
        // x and y are counterclockwise from each other; the frame turns with the sense of the carrier.
        self.shape.frame_ratio = self.layout.kinematics.speeds[carrier].value() / self.orders.ratio;
        for (body, (name, part)) in parts.bodies.iter().enumerate() {
            let (Some(bearing), [x, Some(y)]) = (part.bearing, self.layout.centre[body]) else { continue };
            let planet = self.layout.planets[body].is_some();
            if bearing.clearance > 0.0 && !planet {
                let why = "a damper with a clearance has no term for the rotation";
                return Err(TrainError::NotRotating { part: name.clone(), why });
            }
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
                self.shape.rotating.push(Rotating {
                    i,
                    j: i,
                    damping: 0.0,
                    gyroscopic: 0.0,
                    centripetal: -1.0,
                });
            }
        }
        Ok(())
    }
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
