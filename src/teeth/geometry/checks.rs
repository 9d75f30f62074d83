//! What makes teeth possible.

use crate::teeth::error::TeethError as E;
use crate::teeth::geometry::gear::InvoluteGear;

/// Whether two gears have the same basic rack and tooth numbers that can mesh.
pub(crate) fn match_gears(gears: &[InvoluteGear; 2]) -> Result<(), E> {
    let [a, b] = gears;
    let equal = |name, first: f64, second: f64| {
        if (first - second).abs() <= 1e-12 * first.abs().max(second.abs()) {
            return Ok(());
        }
        Err(E::Different { name, first, second })
    };
    equal("the modules", a.module(), b.module())?;
    equal("the pressure angles", a.pressure_angle(), b.pressure_angle())?;
    equal("the helix angles", a.helix_angle(), b.helix_angle())?;
    let (internal, external) = match (a.is_internal(), b.is_internal()) {
        (true, true) => return Err(E::TwoInternal),
        (false, false) => return Ok(()),
        (true, false) => (a.teeth(), b.teeth()),
        (false, true) => (b.teeth(), a.teeth()),
    };
    if internal > external { Ok(()) } else { Err(E::InternalTooSmall { internal, external }) }
}

/// Whether the teeth of both gears can be made.
pub(crate) fn teeth(gears: &[InvoluteGear; 2]) -> Result<(), E> {
    for (i, gear) in gears.iter().enumerate() {
        let (tip, base) = (gear.tip_radius(), gear.base_radius());
        if tip <= base {
            return Err(E::TipBelowBase { gear: i, tip, base });
        }
        let height = gear.sign() * (tip - gear.root_radius());
        if height <= 0.0 || gear.root_radius() <= 0.0 {
            return Err(E::NoTooth { gear: i, height });
        }
        let least = gear.least_shift().filter(|least| gear.profile_shift() < least - 1e-12);
        if let Some(least) = least
            && !gear.may_be_undercut()
        {
            return Err(E::Undercut { gear: i, teeth: gear.teeth(), shift: gear.profile_shift(), least });
        }
        let thickness = gear.tooth_thickness(tip)?;
        if thickness <= 0.0 {
            return Err(E::Pointed { gear: i, thickness });
        }
    }
    Ok(())
}
