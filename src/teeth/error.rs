//! Errors of teeth that cannot be made or cannot mesh.

use crate::error::ParameterError;
use thiserror::Error;

/// The reason why teeth cannot be made, cannot mesh, or lie outside the range of a method.
///
/// `gear` is the place of a gear in its pair, 0 or 1. Lengths are in metres.
///
/// ```
/// use gear_dynamics::teeth::{InvoluteGear, GearPair, TeethError};
/// let gear = |z| InvoluteGear::external(z, 0.003);
/// let error = GearPair::new(&gear(12)?, &gear(40)?).unwrap_err();
/// assert!(matches!(error, TeethError::Undercut { gear: 0, shift: 0.0, least, .. } if least > 0.29));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum TeethError {
    /// A value is outside its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// The rack that makes the gear cuts into the involute.
    #[error(
        "gear {gear} with {teeth} teeth is undercut: its profile shift is {shift:?}, at least {least:?} is needed \
         (InvoluteGear::allow_undercut accepts it)"
    )]
    Undercut {
        /// Place of the gear.
        gear: usize,
        /// Number of teeth.
        teeth: u32,
        /// Profile shift `[1]`.
        shift: f64,
        /// Least profile shift without undercut `[1]`.
        least: f64,
    },
    /// The flanks of a tooth meet below its tip circle.
    #[error(
        "the teeth of gear {gear} are pointed: their thickness at the tip is {thickness:?} m, it must be positive"
    )]
    Pointed {
        /// Place of the gear.
        gear: usize,
        /// Thickness at the tip circle `[m]`.
        thickness: f64,
    },
    /// The tip circle of a gear does not lie outside its base circle, where the involute begins.
    #[error("the tip radius of gear {gear} is {tip:?} m: it must exceed the base radius {base:?} m")]
    TipBelowBase {
        /// Place of the gear.
        gear: usize,
        /// Tip radius `[m]`.
        tip: f64,
        /// Base radius `[m]`.
        base: f64,
    },
    /// The root circle does not lie below the tip circle (external) or beyond it (internal).
    #[error("the teeth of gear {gear} have the height {height:?} m: it must be positive")]
    NoTooth {
        /// Place of the gear.
        gear: usize,
        /// Tooth height `[m]`.
        height: f64,
    },
    /// The transverse contact ratio is below one: no pair of teeth is in contact at times.
    #[error("the transverse contact ratio is {value:?}: at least 1 is needed")]
    ContactRatio {
        /// Transverse contact ratio `[1]`.
        value: f64,
    },
    /// Contact would extend past the point at which the line of action touches the base circle of a gear:
    /// there is no involute.
    #[error(
        "the mesh undercuts gear {gear}: its partner reaches past the point where the line of action touches \
         the base circle of gear {gear}, within which there is no involute; more teeth, a shorter addendum of \
         the partner or a profile shift of gear {gear} avoid it"
    )]
    BeyondBaseCircle {
        /// Place of the gear.
        gear: usize,
    },
    /// Contact would extend beyond the involute of a gear, into its fillet.
    #[error(
        "the mesh interferes with the root of gear {gear}: contact extends to the radius {contact:?} m, \
         the involute that a rack makes to {involute:?} m (InvoluteGear::allow_undercut accepts another tool)"
    )]
    Interference {
        /// Place of the gear.
        gear: usize,
        /// Radius nearest to the root at which contact occurs `[m]`.
        contact: f64,
        /// Radius at which the involute ends at the root `[m]`.
        involute: f64,
    },
    /// The tips of the pinion and of the internal gear meet outside the path of contact.
    #[error(
        "the tips of the pinion and of the internal gear overlap by {overlap:?} rad: use a larger difference of \
         tooth numbers or shorter teeth"
    )]
    TipInterference {
        /// Overlap as an angle of the internal gear `[rad]`.
        overlap: f64,
    },
    /// The tip of one gear touches the root of the other one.
    #[error(
        "the clearance between the tip of gear {gear} and the root of the other one is {clearance:?} m: it must be \
         positive"
    )]
    NoClearance {
        /// Place of the gear whose tip touches.
        gear: usize,
        /// Clearance `[m]`.
        clearance: f64,
    },
    /// The centre distance is too small (external) or too large (internal) for the profile shifts.
    #[error("the teeth jam: the profile shifts and the centre distance leave a backlash of {backlash:?} m")]
    NoBacklash {
        /// Circumferential backlash at the working circle `[m]`.
        backlash: f64,
    },
    /// The centre distance or the profile shifts have no working pressure angle.
    #[error("there is no working pressure angle: {name} is {value:?}, the limit is {limit:?}")]
    NoWorkingAngle {
        /// "centre distance" `[m]` or "sum of profile shifts" `[1]`.
        name: &'static str,
        /// The value given.
        value: f64,
        /// The limit.
        limit: f64,
    },
    /// The two gears have different modules, pressure angles or helix angles.
    #[error("{name} of the two gears must be equal: {first:?} and {second:?}")]
    Different {
        /// Name of the quantity.
        name: &'static str,
        /// Value of gear 0.
        first: f64,
        /// Value of gear 1.
        second: f64,
    },
    /// Both gears are internal.
    #[error("two internal gears cannot mesh")]
    TwoInternal,
    /// An internal gear has too few teeth for its pinion.
    #[error("the internal gear has {internal} teeth: it needs more than its pinion with {external}")]
    InternalTooSmall {
        /// Teeth of the internal gear.
        internal: u32,
        /// Teeth of the pinion.
        external: u32,
    },
    /// A method does not apply to the kind of teeth.
    #[error("{method} does not apply to {teeth} teeth")]
    NotApplicable {
        /// Name of the method.
        method: &'static str,
        /// "helical" or "internal" or "undercut".
        teeth: &'static str,
    },
    /// A wave over the mesh cycle of one transverse section is asked of helical teeth.
    #[error(
        "the mesh cycle of one transverse section is not that of helical teeth, and the helix angle is {angle:?} rad: \
         combine the sections across the face width, which extends over GearPair::overlap_ratio mesh cycles, into a Table; \
         of a stiffness the mean alone may do"
    )]
    Helical {
        /// Helix angle `[rad]`.
        angle: f64,
    },
    /// A value is outside the range for which a method is stated.
    #[error("{method} is not stated for {name} = {value:?}: the range is {allowed}")]
    OutsideMethod {
        /// Name of the method.
        method: &'static str,
        /// Name of the quantity.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The range of the method.
        allowed: &'static str,
    },
}

/// A value in a closed range; a typed error otherwise.
pub(crate) fn within(
    name: &str,
    value: f64,
    range: [f64; 2],
    allowed: &'static str,
) -> Result<f64, ParameterError> {
    if !value.is_finite() {
        return Err(ParameterError::NotFinite { name: name.into(), value });
    }
    if (range[0]..=range[1]).contains(&value) {
        return Ok(value);
    }
    Err(ParameterError::OutOfRange { name: name.into(), value, allowed })
}

/// An error for helical teeth, of which one transverse section is not the whole mesh.
pub(crate) fn check_spur(helix_angle: f64) -> Result<(), TeethError> {
    if helix_angle == 0.0 { Ok(()) } else { Err(TeethError::Helical { angle: helix_angle }) }
}

/// A value in the closed range of a method; a typed error otherwise.
pub(crate) fn method_range(
    method: &'static str,
    name: &'static str,
    value: f64,
    range: [f64; 2],
    allowed: &'static str,
) -> Result<f64, TeethError> {
    if (range[0]..=range[1]).contains(&value) {
        return Ok(value);
    }
    Err(TeethError::OutsideMethod { method, name, value, allowed })
}
