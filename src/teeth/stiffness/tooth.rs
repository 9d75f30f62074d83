//! The compliance of one tooth by its strain energy.

use crate::error::ParameterError;
use crate::teeth::error::{TeethError, method_range};
use crate::teeth::geometry::gear::InvoluteGear;
use crate::teeth::geometry::involute::involute;
use crate::teeth::stiffness::quadrature::integrals;
use std::f64::consts::FRAC_PI_2;

/// How the geometry of Ma et al. 2014 is read.
///
/// ```
/// use gear_dynamics::teeth::{PotentialEnergy, Reading};
/// assert_eq!(PotentialEnergy::tian_2004().reading(Reading::Exact), PotentialEnergy::tian_2004());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reading {
    /// The exact geometry. The tangent of the pressure angle grows in proportion to the rotation. Contact
    /// begins at the tip of the driven gear. The root angle is that of the transition curve. The foundation
    /// is loaded where the line of action crosses the centre line of the tooth.
    Exact,
    /// As the code of ROSS 2 ([errata](crate::guide::errata)): the pressure angle itself grows in proportion
    /// to the rotation, from the start of the involute of the driving gear to its tip and, on the driven
    /// gear, downwards from the tip; the root angle takes the addendum for the dedendum; the
    /// foundation is loaded at the height of the point of contact.
    Ross,
}

/// The shape of a tooth below its involute.
///
/// ```
/// use gear_dynamics::teeth::{PotentialEnergy, ToothModel};
/// let method = PotentialEnergy::tian_2004();
/// assert_eq!(method.tooth_model(ToothModel::FromBaseCircle), method);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ToothModel {
    /// The tooth is an involute cantilever clamped at the base circle, whatever the root circle is.
    /// Source: Tian 2004; Wu, Zuo & Parey 2008.
    FromBaseCircle,
    /// The involute is followed by the transition curve that the rounded tip of a rack makes, down to the
    /// root circle.   Source: Ma et al. 2014.
    WithTransition,
}

/// Stiffnesses of one tooth at one place of contact, along the line of action `[N/m]`. Infinite if a
/// part is left out.
///
/// ```
/// use gear_dynamics::teeth::{InvoluteGear, PotentialEnergy};
/// let gear = InvoluteGear::external(62, 0.002)?.with_face_width(0.02)?;
/// let tooth = PotentialEnergy::tian_2004().tooth(&gear, 20f64.to_radians())?;
/// let parts = 1.0 / tooth.bending + 1.0 / tooth.shear + 1.0 / tooth.axial;
/// assert!((tooth.total() * parts - 1.0).abs() < 1e-15 && tooth.foundation.is_infinite());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ToothStiffness {
    /// Bending.
    pub bending: f64,
    /// Shear.
    pub shear: f64,
    /// Axial compression.
    pub axial: f64,
    /// Fillet foundation, the elastic body below the tooth.
    pub foundation: f64,
    /// Estimated relative error of the integrals `[1]`.
    pub error: f64,
}

impl ToothStiffness {
    /// All parts in series `[N/m]`.
    pub fn total(&self) -> f64 {
        1.0 / (1.0 / self.foundation + self.flexibility())
    }
    /// Compliance without the foundation `[m/N]`.
    pub(crate) fn flexibility(&self) -> f64 {
        1.0 / self.bending + 1.0 / self.shear + 1.0 / self.axial
    }
}

/// Tolerance of the integrals, as a share of them `[1]`.
const TOLERANCE: f64 = 1e-13;

/// The profile of one tooth in its own axes: y along its centre line from the axis of the gear, x half its
/// thickness `[m]`.
#[derive(Clone, Debug)]
pub(crate) struct Profile {
    base: f64,
    half_base_angle: f64,
    /// Angle τ at which the involute begins `[rad]`.
    start: f64,
    transition: Option<Transition>,
    root: f64,
    curve: RootCurve,
}

/// The transition curve of a tooth, which the rounded tip of a rack makes.
///
/// ```
/// use gear_dynamics::teeth::{InvoluteGear, PotentialEnergy};
/// let curve = PotentialEnergy::ma_2014([0.035; 2])?.root_curve(&InvoluteGear::external(62, 0.002)?)?;
/// assert!((curve.depth - 0.0017400983177096314).abs() < 1e-15);
/// assert!((curve.half_root_angle - curve.distance / 0.062).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RootCurve {
    /// Depth of the centre of the tip round below the rolling line, a = (h_fP - x) m - ρ_fP `[m]`.
    pub depth: f64,
    /// Distance of this centre from the centre line of the tooth,
    /// b = π m/4 + (h_fP m - ρ_fP (1 - sin α)) tan α + ρ_fP cos α `[m]`.
    pub distance: f64,
    /// Half the angle of the tooth at the root circle `[rad]`: b/r, or as ROSS computes it.
    pub half_root_angle: f64,
}

/// The curve that the rounded tip of a rack makes, over the angle γ of the contact normal `[rad]`.
#[derive(Clone, Copy, Debug)]
struct Transition {
    pitch: f64,
    /// Depth of the centre of the tip round below the rolling line `[m]`.
    a: f64,
    /// Distance of this centre from the centre line of the tooth `[m]`.
    b: f64,
    round: f64,
    end: f64,
}

impl Transition {
    /// x, y and dy/dγ.   Source: Ma et al. 2014, Appendix.
    fn point(&self, gamma: f64) -> [f64; 3] {
        let (sin, cos) = libm::sincos(gamma);
        let phi = (self.a * cos / sin + self.b) / self.pitch;
        let dphi = -self.a / (self.pitch * sin * sin);
        let reach = self.a / sin + self.round;
        let dreach = -self.a * cos / (sin * sin);
        let (s, c) = libm::sincos(gamma - phi);
        let (sp, cp) = libm::sincos(phi);
        let slope = -self.pitch * sp * dphi - dreach * s - reach * c * (1.0 - dphi);
        [self.pitch * sp - reach * c, self.pitch * cp - reach * s, slope]
    }
}

/// The body below a tooth.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hub {
    /// Bore `[m]`.
    pub(crate) bore: f64,
    pub(crate) reading: Reading,
    pub(crate) extrapolated: bool,
}

impl Profile {
    pub(crate) fn new(gear: &InvoluteGear, model: ToothModel, reading: Reading) -> Result<Self, TeethError> {
        let method = "the potential-energy method";
        if gear.is_internal() {
            return Err(TeethError::NotApplicable { method, teeth: "internal" });
        }
        if gear.helix_angle() != 0.0 {
            return Err(TeethError::NotApplicable { method, teeth: "helical" });
        }
        let (base, pitch, module) = (gear.base_radius(), gear.reference_radius(), gear.module());
        let angle = gear.transverse_pressure_angle();
        let half_base_angle = gear.half_base_angle();
        let (tan, cos) = (libm::tan(angle), libm::cos(angle));
        let round = module * gear.fillet_radius();
        // Distance of the centre of the rounded tip from the centre line of the tooth.
        let b = FRAC_PI_2 * 0.5 * module + gear.straight_dedendum() * tan + round * cos;
        // ROSS computes the angle of the root with the addendum in place of the dedendum.
        let printed = FRAC_PI_2 * 0.5 * module + (gear.addendum() * module - round) * tan + round / cos;
        let root_angle = if reading == Reading::Ross { printed } else { b } / pitch;
        let (start, transition) = match model {
            ToothModel::FromBaseCircle => (-half_base_angle, None),
            ToothModel::WithTransition => {
                if gear.least_shift().is_some_and(|least| gear.profile_shift() < least - 1e-12) {
                    return Err(TeethError::NotApplicable {
                        method: "the transition curve",
                        teeth: "undercut",
                    });
                }
                if round <= 0.0 || b >= FRAC_PI_2 * module {
                    // The tip round must exist and fit into the tip of the rack.
                    let widest = (FRAC_PI_2 * 0.5 * module - gear.dedendum() * module * tan) * cos;
                    let widest = widest / (1.0 - libm::sin(angle)) / module;
                    return Err(TeethError::OutsideMethod {
                        method: "the transition curve",
                        name: "fillet radius of the rack, in modules",
                        value: round / module,
                        allowed: if widest > 0.0 {
                            "(0, the full round of its tip)"
                        } else {
                            "none: the rack is pointed"
                        },
                    });
                }
                let a = gear.dedendum() * module - round - gear.profile_shift() * module;
                let form = gear.form_radius();
                let tangent = libm::sqrt((form - base).max(0.0) * (form + base)) / base;
                (tangent - half_base_angle, Some(Transition { pitch, a, b, round, end: angle }))
            }
        };
        let depth = (gear.dedendum() - gear.profile_shift()) * module - round;
        let curve = RootCurve { depth, distance: b, half_root_angle: root_angle };
        Ok(Profile { base, half_base_angle, start, transition, root: gear.root_radius(), curve })
    }

    pub(crate) fn curve(&self) -> RootCurve {
        self.curve
    }

    /// Angle τ of the load to the normal of the centre line for a pressure angle: τ = tan α - θ_b.
    fn load_angle(&self, pressure: f64) -> f64 {
        pressure + involute(pressure) - self.half_base_angle
    }

    /// x, y and dy/dτ of the involute.
    fn involute(&self, tau: f64) -> [f64; 3] {
        let (s, c) = libm::sincos(tau);
        let roll = tau + self.half_base_angle;
        [self.base * (roll * c - s), self.base * (roll * s + c), self.base * roll * c]
    }

    /// Bending, shear and axial stiffness of a tooth of a width `[m]` loaded at a pressure angle:
    /// 1/k_b = ∫ (cos τ (y_c - y) - x_c sin τ)²/(E I) dy, 1/k_s = ∫ 1.2 cos² τ/(G A) dy,
    /// 1/k_a = ∫ sin² τ/(E A) dy, A = 2 x b, I = 2/3 x³ b.
    pub(crate) fn stiffness(
        &self,
        pressure: f64,
        width: f64,
        [young, poisson]: [f64; 2],
        hub: Option<Hub>,
    ) -> Result<ToothStiffness, TeethError> {
        let load = self.load_angle(pressure);
        if load <= self.start {
            let contact = self.base / libm::cos(pressure);
            let involute = self.base * libm::hypot(1.0, self.start + self.half_base_angle);
            return Err(TeethError::Interference { gear: 0, contact, involute });
        }
        let (sin, cos) = libm::sincos(load);
        let [xc, yc, _] = self.involute(load);
        let shear_modulus = young / (2.0 * (1.0 + poisson));
        let parts = |[x, y, slope]: [f64; 3]| {
            let (area, inertia) = (2.0 * x * width, 2.0 / 3.0 * x * x * x * width);
            let arm = cos * (yc - y) - xc * sin;
            [
                arm * arm / (young * inertia) * slope,
                1.2 * cos * cos / (shear_modulus * area) * slope,
                sin * sin / (young * area) * slope,
            ]
        };
        let (mut sum, mut error) = integrals(self.start, load, TOLERANCE, |tau| parts(self.involute(tau)));
        if let Some(curve) = &self.transition {
            let (root, more) = integrals(FRAC_PI_2, curve.end, TOLERANCE, |gamma| parts(curve.point(gamma)));
            sum.iter_mut().zip(root).for_each(|(sum, root)| *sum += root);
            error = error.max(more);
        }
        let foundation = hub.map_or(Ok(f64::INFINITY), |hub| {
            let reach = match hub.reading {
                Reading::Exact => self.base / cos,
                Reading::Ross => yc,
            };
            let compliance = self.foundation(hub, reach - self.root, cos, sin / cos)?;
            Ok::<f64, TeethError>(young * width / compliance)
        })?;
        let [bending, shear, axial] = sum.map(|compliance| 1.0 / compliance);
        Ok(ToothStiffness { bending, shear, axial, foundation, error })
    }

    /// E b/k_f = cos² τ (L (u/S)² + M u/S + P (1 + Q tan² τ)), S = 2 r_f θ_f.   Source: Sainsot et al. 2004.
    fn foundation(&self, hub: Hub, u: f64, cos: f64, tan: f64) -> Result<f64, TeethError> {
        let (h, angle) = (self.root / (0.5 * hub.bore), self.curve.half_root_angle);
        if !hub.extrapolated {
            let method = "the fillet foundation of Sainsot";
            method_range(
                method,
                "root radius/bore radius",
                h,
                [1.4, 7.0],
                "[1.4, 7]; PotentialEnergy::extrapolated goes beyond",
            )?;
            method_range(
                method,
                "half root angle",
                angle,
                [0.01, 0.12],
                "[0.01, 0.12] rad; PotentialEnergy::extrapolated goes beyond",
            )?;
        }
        let [l, m, p, q] = SAINSOT.map(|[a, b, c, d, e, f]| {
            a / (angle * angle) + b * h * h + c * h / angle + d / angle + e * h + f
        });
        let share = u / (2.0 * self.root * angle);
        Ok(cos * cos * (l * share * share + m * share + p * (1.0 + q * tan * tan)))
    }
}

/// Coefficients A to F of L, M, P and Q: A/θ² + B h² + C h/θ + D/θ + E h + F.   Source: Sainsot et al. 2004,
/// Table 1.
#[rustfmt::skip]
const SAINSOT: [[f64; 6]; 4] = [
    [-5.574e-5,  -1.9986e-3, -2.3015e-4,  4.7702e-3, 0.0271,  6.8045],
    [60.111e-5,  28.100e-3,  -83.431e-4, -9.9256e-3, 0.1624,  0.9086],
    [-50.952e-5, 185.50e-3,   0.0538e-4, 53.300e-3,  0.2895,  0.9236],
    [-6.2042e-5,  9.0889e-3, -4.0964e-4,  7.8297e-3, -0.1472, 0.6904],
];

/// Whether a Poisson ratio lies between those of known materials.
pub(crate) fn check_poisson(poisson: f64) -> Result<f64, ParameterError> {
    crate::teeth::error::within("Poisson ratio", poisson, [0.0, 0.5], "[0, 0.5]")
}
