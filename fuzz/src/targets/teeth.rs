//! Teeth: gears, pairs, mesh stiffness, deviations.

use crate::case::{Case, Run, Stop, all_finite, finite, holds};
use gear_dynamics::excitation::{Excitation, Side};
use gear_dynamics::teeth::{
    Foundation, GearPair, InvoluteGear, LossShape, MethodB, PotentialEnergy, QualityGrade, Reading,
    TipRelief, ToothDeviations, ToothLoss, ToothModel, TransmissionError,
};
use gear_dynamics::trains::SpurPair;
use gear_dynamics::{Model, ParameterError, Wave};
use std::f64::consts::TAU;

fn gear(case: &mut Case, internal: bool, module: f64, helix: f64) -> Result<InvoluteGear, Stop> {
    let teeth = (case.count(if internal { 60 } else { 25 }) as u32).saturating_add(12);
    let gear = if internal {
        InvoluteGear::internal(teeth, module)?
    } else {
        InvoluteGear::external(teeth, module)?
    };
    let mut gear = gear.with_helix_angle(helix)?.with_face_width(case.number(0.03))?;
    if case.chance(0.5) {
        gear = gear.with_profile_shift(case.number(0.3) * case.signed())?;
    }
    if case.chance(0.3) {
        gear = gear.with_addendum(case.number(0.8))?.with_dedendum(case.number(1.2))?;
    }
    if case.chance(0.2) {
        gear = gear.with_fillet_radius(case.number(0.2))?.with_tip_alteration(-case.number(0.1 * module))?;
    }
    Ok(if case.chance(0.5) { gear.allow_undercut() } else { gear })
}

fn pair(case: &mut Case) -> Result<GearPair, Stop> {
    let module = case.number(0.003);
    let helix = if case.chance(0.3) { case.number(0.2) } else { 0.0 };
    let internal = case.chance(0.3);
    let (a, b) = (gear(case, false, module, helix)?, gear(case, internal, module, helix)?);
    let (a, b) = if case.chance(0.3) { (b, a) } else { (a, b) };
    let (ra, rb) = (a.reference_radius(), b.reference_radius());
    let sum = if internal { (ra - rb).abs() } else { ra + rb };
    Ok(match case.below(3) {
        0 => GearPair::new(&a, &b)?,
        1 => GearPair::shortened(&a, &b)?,
        _ => GearPair::at_centre_distance(&a, &b, case.number(sum).clamp(0.95 * sum, 1.05 * sum))?,
    })
}

/// The figures of an accepted pair.
pub fn geometry(case: &mut Case) -> Run {
    let pair = pair(case)?;
    case.note(|| format!("{pair:?}"));
    holds(pair.contact_ratio() >= 1.0, || format!("contact ratio {}", pair.contact_ratio()))?;
    let figures =
        [pair.working_pressure_angle(), pair.centre_distance(), pair.backlash(), pair.total_contact_ratio()];
    all_finite("geometry", &figures)?;
    for i in 0..2 {
        all_finite("line of contact", &pair.line_of_contact(i))?;
        all_finite("active profile", &pair.active_profile(i))?;
    }
    let phases = [pair.pitch_point(), pair.end_of_double_contact()];
    holds(phases.iter().all(|phase| (0.0..TAU).contains(phase)), || format!("phases {phases:?}"))?;
    let gear = &pair.gears()[0];
    let blank = gear.blank(case.number(gear.reference_radius()), case.number(7800.0))?;
    all_finite("blank", &[blank.mass, blank.polar_inertia, blank.transverse_inertia])?;
    finite("thickness", gear.tooth_thickness(case.number(gear.tip_radius()))?)
}

/// Mesh stiffness of an accepted pair.
pub fn stiffness(case: &mut Case) -> Run {
    let pair = pair(case)?;
    case.note(|| format!("{pair:?}"));
    if case.chance(0.2) {
        return train(case, &pair);
    }
    if case.chance(0.5) {
        let mut method = MethodB::new().young([case.number(2e11), case.number(2e11)])?;
        if case.chance(0.5) {
            method = method.web(case.number(0.3), case.number(3.0))?.line_load(case.number(1e5))?;
        }
        let found = method.stiffness(&pair)?;
        all_finite("method B", &[found.single, found.mesh, found.mean_stiffness])?;
        if pair.gears()[0].helix_angle() == 0.0 {
            let mean = found.rectangular()?.mean();
            holds((mean / found.mean_stiffness - 1.0).abs() < 1e-9, || format!("mean {mean} of {found:?}"))?;
        }
        return finite("resonance", found.resonance_speed(case.count(20) as u32, case.number(1.0))?);
    }
    let bores = [case.number(0.02), case.number(0.02)];
    let method = PotentialEnergy::ma_2014(bores)?.material(case.number(2e11), case.number(0.2))?;
    let foundation = case.pick(&[Foundation::None, Foundation::PerPair(bores), Foundation::PerBody(bores)]);
    let method = method.foundation(foundation)?.extrapolated();
    let method = method.tooth_model(case.pick(&[ToothModel::FromBaseCircle, ToothModel::WithTransition]));
    let method = method.reading(case.pick(&[Reading::Exact, Reading::Ross]));
    finite("pair of teeth", method.pair(&pair, case.number(0.5))?.total())?;
    let stiffness = method.wave(&pair)?;
    all_finite("stiffness", &[stiffness.mean(), stiffness.error(), method.mesh(&pair, case.number(1.0))?])?;
    finite("series", stiffness.fourier_series(case.count(4))?.mean())?;
    all_finite("wave", &[stiffness.jet(0.0).second, stiffness.jet(6.0).rate])
}

/// The train of an accepted pair.
fn train(case: &mut Case, pair: &GearPair) -> Run {
    let (bores, grades) =
        ([case.number(0.02), case.number(0.02)], [case.count(6) as u32, case.count(6) as u32]);
    let spur = SpurPair::of_teeth(pair, bores, grades, case.count(4))?;
    let spur =
        spur.damping(case.number(2000.0)).half_backlash(case.number(4e-5)).drive_torque(case.quantity(300.0));
    let numbers = spur.dimensionless()?;
    all_finite("numbers", &[numbers.damping_ratio, numbers.natural_frequency, numbers.mass])?;
    let train = spur.parts()?.build("driver", case.number(300.0))?;
    let (mut u, mut a) = (vec![0.0; train.drives()], [0.0]);
    train.drive(case.unit(), Side::After, &mut u);
    train.accel(&u, &[case.unit()], &[case.unit()], &mut a);
    finite("acceleration", a[0])
}

/// Faults, reliefs, grades and errors.
pub fn deviations(case: &mut Case) -> Run {
    let pair = pair(case)?;
    match case.below(4) {
        0 => {
            let teeth = case.count(20) as u32;
            let loss = ToothLoss::new(teeth, case.count(5) as u32, case.number(0.2))?;
            let loss = loss.shape(case.pick(&[LossShape::Step, LossShape::Cosine]));
            let wave = Wave::new(loss.times(Wave::constant(1.0)?));
            let value = wave.value(case.quantity(1.0), Side::After);
            holds((0.0..=1.0).contains(&value), || format!("{loss:?} leaves {value}"))
        }
        1 => {
            let pitch = pair.base_pitch();
            let (amounts, lengths) = (
                [case.number(1e-5), case.number(1e-5)],
                [case.number(0.5 * pitch), case.number(0.5 * pitch)],
            );
            let relief = TipRelief::new(amounts, lengths)?;
            let relief = if case.chance(0.5) { relief.parabolic() } else { relief };
            finite("relief", relief.at(&pair, case.number(0.5))?)?;
            let wave = relief.unloaded_error(&pair)?;
            let value = wave.value(TAU * case.unit());
            holds(value >= -1e-12 && value <= amounts[0] + amounts[1], || format!("{relief:?}: {value}"))
        }
        2 => inspected(case, &pair.gears()[0]),
        _ => {
            let grades = [QualityGrade::new(case.count(6) as u32)?, QualityGrade::new(case.count(6) as u32)?];
            let error = TransmissionError::of_grade(&pair, grades)?;
            let (lengths, directions) =
                ([case.number(1e-5), case.number(1e-5)], [case.number(1.0), case.number(1.0)]);
            let error = error.with_eccentricity(lengths, directions)?;
            let whole: Result<_, ParameterError> = error.over_common_period(&pair);
            finite("error", whole?.value(TAU * case.unit()))
        }
    }
}

/// Deviations of every tooth, measured or drawn.
fn inspected(case: &mut Case, gear: &InvoluteGear) -> Run {
    let teeth = if case.chance(0.5) {
        let z = case.effort(30);
        let (pitch, profile) = (case.list(z, 1e-5), case.list(z, 1e-5));
        ToothDeviations::measured(&pitch, &profile)?
    } else {
        let grade = QualityGrade::new(case.count(6) as u32)?;
        let drawn = ToothDeviations::draw(gear, grade, case.seed(), case.seed(), case.seed())?;
        let (limits, within) = (grade.tolerances(gear)?, 1.0 + 1e-12);
        holds(drawn.single_pitch() <= within * limits.single_pitch, || "single pitch".into())?;
        holds(drawn.cumulative_pitch() <= within * limits.cumulative_pitch, || "cumulative pitch".into())?;
        holds(drawn.profile_slope() <= within * limits.profile_slope, || "profile slope".into())?;
        drawn
    };
    let (wave, middle) = (teeth.wave()?, TAU * 0.5 / teeth.pitch().len() as f64);
    let (value, scale) = (wave.jet(middle).value, teeth.cumulative_pitch() + teeth.profile_slope());
    finite("error in the middle of a tooth", value)?;
    let off = value - teeth.pitch()[0];
    holds(off.abs() <= 1e-9 * (scale + teeth.pitch()[0].abs()), || format!("{value:e}, off by {off:e}"))
}
