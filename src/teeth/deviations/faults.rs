//! Faults of single teeth.

use crate::error::{ParameterError, check};
use crate::excitation::{Angle, Excitation, Jet, Product, Wave};
use crate::scalar::Scalar;
use crate::teeth::error::within;
use std::f64::consts::TAU;

/// The course of a loss of stiffness over the mesh cycle of its tooth.
///
/// ```
/// use gear_dynamics::{excitation::Excitation, teeth::{LossShape, ToothLoss}};
/// let crack = ToothLoss::new(20, 0, 0.3)?.shape(LossShape::Cosine);
/// assert!((crack.value(0.5 * std::f64::consts::TAU / 20.0) - 0.7).abs() < 1e-15); // the middle
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LossShape {
    /// The whole loss during the mesh cycle: a crack at the root, which weakens the whole tooth.
    Step,
    /// The loss grows and decreases as a raised cosine: a spall, whose load enters and leaves it.
    Cosine,
}

/// The loss of mesh stiffness over the mesh cycle of one tooth, by a crack or a spall: a factor of order 1 on
/// the shaft of the gear, 1 - s on the mesh cycle of the tooth and 1 elsewhere.
///
/// A wave of the mesh stiffness k(z φ) is multiplied by it ([`times`](ToothLoss::times)). The tooth meets
/// another tooth of the other gear in every turn.   Source: Chaari et al. 2009 for the loss as a share of the
/// mesh stiffness.
///
/// ```
/// use gear_dynamics::{excitation::{Fourier, Side}, teeth::ToothLoss, Wave};
/// let mesh = Wave::new(Fourier::new(3e8, &[[1e8, 0.0]])?).per_turn(20)?;
/// let cracked = Wave::new(ToothLoss::new(20, 7, 0.2)?.times(mesh.clone()));
/// let on_tooth = 7.5 * std::f64::consts::TAU / 20.0;
/// let (with, without) = (cracked.value(on_tooth, Side::After), mesh.value(on_tooth, Side::After));
/// assert!((with / without - 0.8).abs() < 1e-14);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use = "a setting returns a new value"]
pub struct ToothLoss {
    teeth: u32,
    tooth: u32,
    loss: f64,
    shape: LossShape,
}

impl ToothLoss {
    /// The loss s `[1]` of a tooth, counted from 0, of a gear with a number of teeth. Tooth 0 has its mesh
    /// cycle from φ = 0 to 2π/z of the shaft. Default shape: [`LossShape::Step`].
    ///
    /// # Errors
    /// No teeth or more than 100 000; a tooth that does not exist; a loss outside 0 .. 1.
    pub fn new(teeth: u32, tooth: u32, loss: f64) -> Result<Self, ParameterError> {
        check::at_least("teeth", teeth as usize, 1)?;
        check::count("teeth", &[teeth as usize], 100_000)?;
        check::count("tooth, counted from 0,", &[tooth as usize], teeth as usize - 1)?;
        let loss = within("loss of stiffness", loss, [0.0, 1.0], "[0, 1]")?;
        Ok(ToothLoss { teeth, tooth, loss, shape: LossShape::Step })
    }
    /// The same loss with another course.
    pub fn shape(self, shape: LossShape) -> Self {
        ToothLoss { shape, ..self }
    }
    /// The product of a wave of the mesh stiffness on the shaft of the gear and this factor.
    pub fn times(self, mesh: Wave) -> Product {
        Product::new(vec![mesh, Wave::new(self)])
    }

    fn inside(&self, angle: f64) -> bool {
        (angle * f64::from(self.teeth) / TAU).floor() == f64::from(self.tooth)
    }
    fn factor<S: Scalar>(&self, angle: S, inside: bool) -> Jet<S> {
        match (inside, self.shape) {
            (false, _) => Jet::constant(S::from(1.0)),
            (true, LossShape::Step) => Jet::constant(S::from(1.0 - self.loss)),
            (true, LossShape::Cosine) => {
                let wave = (Jet::variable(angle) * f64::from(self.teeth)).cos();
                wave * (0.5 * self.loss) + (1.0 - 0.5 * self.loss)
            }
        }
    }
}

impl Excitation for ToothLoss {
    fn jet<A: Angle>(&self, angle: A) -> Jet<A::Number> {
        angle.by_pieces(|inside, angle| self.factor(angle, self.inside(inside)))
    }
    fn edges(&self) -> Vec<f64> {
        if self.loss == 0.0 || self.teeth == 1 && self.shape == LossShape::Cosine {
            return Vec::new();
        }
        let at = |tooth: u32| TAU * f64::from(tooth % self.teeth) / f64::from(self.teeth);
        vec![at(self.tooth), at(self.tooth + 1)]
    }
}
