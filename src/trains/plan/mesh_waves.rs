//! The waves of a mesh over the common angle.

use crate::contact::Nonlinearity;
use crate::excitation::{Product, Sum, Wave};
use crate::trains::plan::topology::Gearing;
use crate::trains::plan::train_plan::Plan;
use crate::trains::plan::turning::fraction::Fraction;
use crate::trains::plan::turning::orders::{follows_teeth, varies};
use crate::trains::train_error::TrainError;
use std::f64::consts::TAU;

/// The waves of a mesh over the common angle φ.
pub(crate) struct MeshWaves {
    /// Stiffness times the factors of the faults.
    pub(crate) stiffness: Wave,
    /// Static transmission error and runout.
    pub(crate) error: Wave,
    /// Sign of the tooth friction.
    pub(crate) sign: Option<Wave>,
    /// Teeth in a turn of φ; `None` if nothing follows them or the mesh is at rest.
    pub(crate) order: Option<u32>,
}

impl<N: Nonlinearity> Plan<'_, N> {
    /// The waves of a mesh of the given phase, in mesh cycles.
    pub(crate) fn waves(&self, mesh: &Gearing<N>, phase: f64) -> Result<MeshWaves, TrainError> {
        let (name, part) = (mesh.name, mesh.part);
        self.teeth_turn_evenly(mesh)?;
        let teeth = self.kinematics.of_teeth(mesh).map(Fraction::abs);
        let order = self.orders.order(teeth);
        if mesh.law.moves() {
            if phase != 0.0 {
                return Err(TrainError::MovingEdges { mesh: name.into() });
            }
            if order.is_none() {
                return Err(TrainError::AtRest { part: name.into() });
            }
        }
        let over_teeth = |wave: &Wave| -> Result<Wave, TrainError> {
            if !varies(wave) {
                return Ok(wave.clone());
            }
            let shifted = wave.clone().with_phase(TAU * phase * f64::from(wave.order()))?;
            self.orders.wave(name, &shifted, teeth)
        };
        let (mut stiffness, mut error) = (vec![over_teeth(&part.stiffness)?], vec![over_teeth(&part.error)?]);
        for gear in [0, 1] {
            for (waves, own) in [(&mut stiffness, &part.stiffness_of_turn), (&mut error, &part.error_of_turn)]
            {
                if let Some(wave) = &own[gear] {
                    waves.push(self.over_turns(mesh, gear, wave)?);
                }
            }
        }
        Ok(MeshWaves {
            stiffness: one_of(stiffness, |waves| Wave::new(Product::new(waves))),
            error: one_of(error, |waves| Wave::new(Sum::new(waves))),
            sign: part.friction.as_ref().map(|friction| over_teeth(&friction.sign)).transpose()?,
            order,
        })
    }

    /// Refuses waves over the teeth of a mesh without a round gear that turns evenly.
    fn teeth_turn_evenly(&self, mesh: &Gearing<N>) -> Result<(), TrainError> {
        let even = |gear: usize| self.rotations[mesh.ends[gear]].is_none();
        let round = |gear: usize| mesh.part.radius_of_turn[gear].is_none();
        if !follows_teeth(mesh) || [0, 1].into_iter().any(|gear| round(gear) && even(gear)) {
            return Ok(());
        }
        let body = self.topology.name(mesh.ends[usize::from(even(0))]);
        Err(TrainError::Uneven { part: mesh.name.into(), body })
    }

    /// A wave over the turns of a gear. A tooth of a central gear reaches the planets one after the other.
    fn over_turns(&self, mesh: &Gearing<N>, gear: usize, wave: &Wave) -> Result<Wave, TrainError> {
        let [own, other] = [mesh.ends[gear], mesh.ends[1 - gear]];
        self.turns_evenly(mesh.name, own)?;
        let speed = self.kinematics.of_gear(mesh, gear);
        let way = if speed.is_none_or(|speed| speed.value() >= 0.0) { -1.0 } else { 1.0 };
        let planet = self.planets[other].as_ref().filter(|_| self.planets[own].is_none());
        let shift = planet.map_or(0.0, |planet| way * planet.angle * f64::from(wave.order()));
        self.orders.wave(mesh.name, &wave.clone().with_phase(shift)?, speed.map(Fraction::abs))
    }
}

/// The only wave, or a combination of several.
fn one_of(mut waves: Vec<Wave>, combined: impl Fn(Vec<Wave>) -> Wave) -> Wave {
    if waves.len() > 1 { combined(waves) } else { waves.remove(0) }
}
