//! Mesh stiffness by the potential-energy method.

use crate::error::ParameterError;
use crate::teeth::error::{TeethError, within};
use crate::teeth::geometry::gear::InvoluteGear;
use crate::teeth::geometry::pair::GearPair;
use crate::teeth::stiffness::piecewise::Piecewise;
use crate::teeth::stiffness::tooth::{
    Hub, Profile, Reading, RootCurve, ToothModel, ToothStiffness, check_poisson,
};
use std::f64::consts::{PI, TAU};

/// Where the elastic gear bodies below the teeth count, with the bores of both gears `[m]`.
///
/// ```
/// use gear_dynamics::teeth::{Foundation, PotentialEnergy};
/// let method = PotentialEnergy::ma_2014([0.035; 2])?;
/// assert_eq!(method.foundation(Foundation::PerPair([0.035; 2]))?, method);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Foundation {
    /// The gear bodies are rigid.
    None,
    /// Each pair of teeth has foundations of its own: k = Σ_i 1/(1/k_i + 1/k_f0i + 1/k_f1i). In double
    /// contact a force on one tooth does not move its neighbour, which makes the mesh too stiff.
    PerPair([f64; 2]),
    /// Each body counts once, under the sum of the forces: k = 1/(1/Σ_i k_i + Σ_i s_i (1/k_f0i + 1/k_f1i))
    /// with the shares s_i = k_i/Σ k_i of the load. In double contact a force on one tooth moves its
    /// neighbour as much as itself, which makes the mesh too compliant.
    PerBody([f64; 2]),
}

impl Foundation {
    fn bores(self) -> Option<[f64; 2]> {
        match self {
            Foundation::None => None,
            Foundation::PerPair(bores) | Foundation::PerBody(bores) => Some(bores),
        }
    }
}

/// Stiffness of one pair of teeth in contact `[N/m]`.
///
/// ```
/// use gear_dynamics::teeth::{InvoluteGear, GearPair, PotentialEnergy};
/// let gear = InvoluteGear::external(62, 0.002)?.with_face_width(0.02)?;
/// let pair = PotentialEnergy::tian_2004().pair(&GearPair::new(&gear, &gear)?, 0.9)?;
/// // π E b/(4 (1 - ν²)) with E = 206.8 GPa.
/// assert!((pair.hertz / 3.5696778064e+09 - 1.0).abs() < 1e-10);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PairStiffness {
    /// Contact of two cylinders, linearised: π E b/(4 (1 - ν²)).   Source: Yang & Sun 1985.
    pub hertz: f64,
    /// The teeth of both gears.
    pub teeth: [ToothStiffness; 2],
}

impl PairStiffness {
    /// All parts in series `[N/m]`.
    pub fn total(&self) -> f64 {
        1.0 / (1.0 / self.hertz + 1.0 / self.teeth[0].total() + 1.0 / self.teeth[1].total())
    }
    /// All parts but the foundations in series `[N/m]`.
    fn without_foundation(&self) -> f64 {
        1.0 / (1.0 / self.hertz + self.teeth[0].flexibility() + self.teeth[1].flexibility())
    }
    /// Compliance of both foundations `[m/N]`.
    fn foundations(&self) -> f64 {
        1.0 / self.teeth[0].foundation + 1.0 / self.teeth[1].foundation
    }
}

/// The potential-energy method: the compliances of bending, shear and axial compression of both teeth, of
/// their contact and of the gear bodies add up. It applies to external spur gears.
///
/// ```
/// use gear_dynamics::{Wave, excitation::Side, teeth::{InvoluteGear, GearPair, PotentialEnergy}};
/// let gear = |z| InvoluteGear::external(z, 0.003175)?.with_face_width(0.016);
/// let pair = GearPair::new(&gear(19)?, &gear(48)?)?;
/// let stiffness = PotentialEnergy::tian_2004().wave(&pair)?;
/// assert!((stiffness.mean() / 885392670.289 - 1.0).abs() < 1e-9);
/// let mesh = Wave::new(stiffness).per_turn(19)?; // on the shaft of gear 0
/// assert!((mesh.value(0.0, Side::After) / 951124498.4529462 - 1.0).abs() < 1e-8);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use = "a setting returns a new value"]
pub struct PotentialEnergy {
    young: f64,
    poisson: f64,
    model: ToothModel,
    foundation: Foundation,
    reading: Reading,
    extrapolated: bool,
}

impl PotentialEnergy {
    /// Teeth clamped at the base circle, rigid bodies, steel of 206.8 GPa and ν = 0.3.   Source: Tian 2004;
    /// Wu, Zuo & Parey 2008; Liang, Zuo & Pandey 2014.
    pub fn tian_2004() -> Self {
        PotentialEnergy {
            young: 206.8e9,
            poisson: 0.3,
            model: ToothModel::FromBaseCircle,
            foundation: Foundation::None,
            reading: Reading::Exact,
            extrapolated: false,
        }
    }

    /// Teeth with transition curves, a foundation for each pair, bores of both gears `[m]`, steel of 206 GPa
    /// and ν = 0.3.   Source: Ma et al. 2014; Sainsot et al. 2004.
    ///
    /// # Errors
    /// A bore outside 1e-6 .. 100 m.
    pub fn ma_2014(bores: [f64; 2]) -> Result<Self, ParameterError> {
        let method = PotentialEnergy { young: 206e9, model: ToothModel::WithTransition, ..Self::tian_2004() };
        method.foundation(Foundation::PerPair(bores))
    }

    /// The same method for a material with Young's modulus E `[N/m²]` and Poisson ratio ν `[1]`, of both
    /// gears.
    ///
    /// # Errors
    /// A modulus outside 1e6 .. 1e13 N/m²; a ratio outside 0 .. 0.5.
    pub fn material(self, young: f64, poisson: f64) -> Result<Self, ParameterError> {
        let young = within("Young's modulus", young, [1e6, 1e13], "[1e6, 1e13] N/m²")?;
        Ok(PotentialEnergy { young, poisson: check_poisson(poisson)?, ..self })
    }
    /// The same method with another shape of the tooth below its involute.
    pub fn tooth_model(self, model: ToothModel) -> Self {
        PotentialEnergy { model, ..self }
    }
    /// The same method with another foundation.
    ///
    /// # Errors
    /// A bore outside 1e-6 .. 100 m.
    pub fn foundation(self, foundation: Foundation) -> Result<Self, ParameterError> {
        for bore in foundation.bores().into_iter().flatten() {
            within("bore", bore, [1e-6, 100.0], "[1e-6, 100] m")?;
        }
        Ok(PotentialEnergy { foundation, ..self })
    }
    /// The same method, also where the foundation lies outside the range of Sainsot et al.: a root radius of
    /// 1.4 .. 7 bore radii, half a root angle of 0.01 .. 0.12 rad (about 26 teeth or more). Their polynomials
    /// are then extrapolated, as most authors do for small pinions.
    pub fn extrapolated(self) -> Self {
        PotentialEnergy { extrapolated: true, ..self }
    }
    /// The same method with another reading of the geometry.
    pub fn reading(self, reading: Reading) -> Self {
        PotentialEnergy { reading, ..self }
    }

    /// Stiffness of one tooth of a gear, loaded at a transverse pressure angle `[rad]`. The bore of the
    /// foundation is that of gear 0.
    ///
    /// # Errors
    /// An internal or helical gear; an angle outside 0 .. 1.4 rad or below the start of the involute; a
    /// foundation outside the range of Sainsot et al.
    pub fn tooth(&self, gear: &InvoluteGear, pressure: f64) -> Result<ToothStiffness, TeethError> {
        let pressure = within("pressure angle", pressure, [0.0, 1.4], "[0, 1.4] rad")?;
        let profile = Profile::new(gear, self.model, self.reading)?;
        self.of_profile(&profile, pressure, gear.face_width(), 0)
    }

    /// The transition curve of a gear as this method reads it.
    ///
    /// # Errors
    /// An internal or helical gear; with [`ToothModel::WithTransition`] an undercut gear and a rack without a
    /// round tip.
    pub fn root_curve(&self, gear: &InvoluteGear) -> Result<RootCurve, TeethError> {
        Ok(Profile::new(gear, self.model, self.reading)?.curve())
    }

    fn of_profile(
        &self,
        profile: &Profile,
        angle: f64,
        width: f64,
        gear: usize,
    ) -> Result<ToothStiffness, TeethError> {
        let hub = |bores: [f64; 2]| Hub {
            bore: bores[gear],
            reading: self.reading,
            extrapolated: self.extrapolated,
        };
        let hub = self.foundation.bores().map(hub);
        let stiffness = profile.stiffness(angle, width, [self.young, self.poisson], hub);
        stiffness.map_err(|error| match error {
            TeethError::Interference { contact, involute, .. } => {
                TeethError::Interference { gear, contact, involute }
            }
            error => error,
        })
    }

    /// Stiffness of one pair of teeth at the place `s` on its path of contact `[1]`: in base pitches from the
    /// start of contact, 0 .. ε_α.
    ///
    /// # Errors
    /// As [`tooth`](PotentialEnergy::tooth); a place outside 0 .. ε_α.
    pub fn pair(&self, pair: &GearPair, s: f64) -> Result<PairStiffness, TeethError> {
        within("place on the path of contact", s, [0.0, pair.contact_ratio()], "[0, contact ratio]")?;
        self.at(pair, &self.profiles(pair)?, s)
    }

    fn profiles(&self, pair: &GearPair) -> Result<[Profile; 2], TeethError> {
        let [a, b] = pair.gears();
        Ok([Profile::new(a, self.model, self.reading)?, Profile::new(b, self.model, self.reading)?])
    }

    fn at(&self, pair: &GearPair, profiles: &[Profile; 2], s: f64) -> Result<PairStiffness, TeethError> {
        let width = pair.face_width();
        let angles = match self.reading {
            Reading::Exact => [0, 1].map(|gear| libm::atan(pair.tangent_at(gear, s))),
            Reading::Ross => ross_angles(pair, s),
        };
        let hertz = PI * self.young * width / (4.0 * (1.0 - self.poisson * self.poisson));
        let teeth = [
            self.of_profile(&profiles[0], angles[0], width, 0)?,
            self.of_profile(&profiles[1], angles[1], width, 1)?,
        ];
        Ok(PairStiffness { hertz, teeth })
    }

    /// Mesh stiffness over the mesh cycle `[N/m]`, smooth between the angles at which pairs enter and leave
    /// contact, where it jumps. φ = 0: a pair enters contact. [`Piecewise::error`] measures how closely the
    /// pieces follow the method.
    ///
    /// # Errors
    /// As [`tooth`](PotentialEnergy::tooth).
    pub fn wave(&self, pair: &GearPair) -> Result<Piecewise, TeethError> {
        let profiles = self.profiles(pair)?;
        let end = pair.end_of_double_contact();
        Piecewise::fit(&[0.0, end], 1e-11, |middle, phi| self.of_pairs(pair, &profiles, phi, middle < end))
    }

    fn of_pairs(
        &self,
        pair: &GearPair,
        profiles: &[Profile; 2],
        phi: f64,
        more: bool,
    ) -> Result<f64, TeethError> {
        let (mut sum, mut bodies, mut with_bodies) = (0.0, 0.0, 0.0);
        for s in pair.places(phi, more) {
            let one = self.at(pair, profiles, s)?;
            let stiffness = one.without_foundation();
            sum += stiffness;
            bodies += stiffness * one.foundations();
            with_bodies += one.total();
        }
        Ok(match self.foundation {
            Foundation::PerBody(_) => 1.0 / (1.0 / sum + bodies / sum),
            _ => with_bodies,
        })
    }

    /// The stiffness at an angle in [0, 2π) of the mesh cycle, without the pieces of
    /// [`wave`](PotentialEnergy::wave) `[N/m]`.
    ///
    /// # Errors
    /// As [`tooth`](PotentialEnergy::tooth); an angle outside 0 .. 2π.
    pub fn mesh(&self, pair: &GearPair, angle: f64) -> Result<f64, TeethError> {
        let phi = within("angle of the mesh cycle", angle, [0.0, TAU], "[0, 2π]")?;
        self.of_pairs(pair, &self.profiles(pair)?, phi, phi < pair.end_of_double_contact())
    }
}

/// Pressure angles at both gears as ROSS 2 computes them.
fn ross_angles(pair: &GearPair, s: f64) -> [f64; 2] {
    let [a, b] = pair.gears();
    let angle = |gear: &InvoluteGear, radius: f64| libm::acos((gear.base_radius() / radius).min(1.0));
    let (start, tip) = (angle(a, a.form_radius()), angle(a, a.tip_radius()));
    let turned = (tip - start) * s / pair.contact_ratio();
    let ratio = f64::from(a.teeth()) / f64::from(b.teeth());
    [start + turned, angle(b, b.tip_radius()) - ratio * turned]
}
