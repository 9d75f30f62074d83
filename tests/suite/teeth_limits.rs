//! Teeth, gears and methods that are refused.

use crate::api::*;
use crate::teeth::{external, pair_19_48};
use gear_dynamics::ParameterError as P;

fn out_of_range(name: &str, value: f64, allowed: &'static str) -> P {
    P::OutOfRange { name: name.into(), value, allowed }
}

#[test]
fn values_outside_their_range() {
    let gear = external(20, 0.0, 0.003);
    assert_eq!(
        InvoluteGear::external(4, 0.003).unwrap_err(),
        P::TooFew { name: "teeth".into(), value: 4, min: 5 }
    );
    assert_eq!(
        InvoluteGear::internal(200_000, 0.003).unwrap_err(),
        P::TooMany { name: "teeth".into(), value: 200_000, max: 100_000 }
    );
    assert_eq!(InvoluteGear::external(20, 4.0).unwrap_err(), out_of_range("module", 4.0, "[1e-5, 0.2] m"));
    assert_eq!(
        gear.with_pressure_angle(20.0).unwrap_err(),
        out_of_range("normal pressure angle", 20.0, "[0.1, 0.7] rad")
    );
    assert_eq!(gear.with_helix_angle(-0.1).unwrap_err(), out_of_range("helix angle", -0.1, "[0, 0.8] rad"));
    assert_eq!(gear.with_profile_shift(3.5).unwrap_err(), out_of_range("profile shift", 3.5, "[-3, 3]"));
    assert_eq!(gear.with_addendum(0.0).unwrap_err(), out_of_range("addendum factor", 0.0, "[0.1, 3]"));
    assert_eq!(gear.with_dedendum(5.0).unwrap_err(), out_of_range("dedendum factor", 5.0, "[0.1, 4]"));
    assert_eq!(
        gear.with_fillet_radius(-0.1).unwrap_err(),
        out_of_range("fillet radius factor", -0.1, "[0, 1]")
    );
    assert_eq!(gear.with_tip_alteration(2.0).unwrap_err(), out_of_range("tip alteration", 2.0, "[-1, 1] m"));
    assert_eq!(gear.with_face_width(20.0).unwrap_err(), out_of_range("face width", 20.0, "[1e-6, 10] m"));
    assert_eq!(gear.blank(0.1, 7800.0).unwrap_err(), out_of_range("bore", 0.1, "[0, reference diameter]"));
    assert_eq!(gear.blank(0.01, 0.0).unwrap_err(), out_of_range("density", 0.0, "[1, 1e5] kg/m³"));
    let ring = InvoluteGear::internal(60, 0.003).unwrap();
    assert_eq!(
        ring.blank(0.1, 7800.0).unwrap_err(),
        out_of_range("outer diameter", 0.1, "[reference diameter, 100 m]")
    );
    assert_eq!(gear.tooth_thickness(0.01).unwrap_err(), out_of_range("radius", 0.01, "[base radius, 1e3 m]"));
    let method = PotentialEnergy::tian_2004();
    assert_eq!(
        method.material(2.1e5, 0.3).unwrap_err(),
        out_of_range("Young's modulus", 2.1e5, "[1e6, 1e13] N/m²")
    );
    assert_eq!(method.material(2.1e11, 0.6).unwrap_err(), out_of_range("Poisson ratio", 0.6, "[0, 0.5]"));
    assert_eq!(PotentialEnergy::ma_2014([0.0; 2]).unwrap_err(), out_of_range("bore", 0.0, "[1e-6, 100] m"));
    assert_eq!(
        MethodB::new().web(0.0, 3.0).unwrap_err(),
        out_of_range("web thickness b_s/b", 0.0, "[0.01, 10]")
    );
    assert_eq!(
        MethodB::new().web(0.5, 0.0).unwrap_err(),
        out_of_range("rim thickness s_R/m_n", 0.0, "[0.01, 1000]")
    );
    assert_eq!(MethodB::new().line_load(0.0).unwrap_err(), out_of_range("line load", 0.0, "[1, 1e9] N/m"));
    assert!(MethodB::new().young([206e9, 0.0]).is_err());
    assert_eq!(
        TipRelief::new([1.0, 0.0], [1.0; 2]).unwrap_err(),
        out_of_range("amount of relief of gear 0", 1.0, "[0, 0.01] m")
    );
    assert_eq!(
        TipRelief::new([0.0; 2], [1.0, 0.0]).unwrap_err(),
        out_of_range("length of relief of gear 1", 0.0, "[1e-9, 1] m")
    );
    assert_eq!(ToothLoss::new(20, 0, 1.5).unwrap_err(), out_of_range("loss of stiffness", 1.5, "[0, 1]"));
    assert!(matches!(ToothLoss::new(0, 0, 0.1), Err(P::TooFew { .. })));
    assert!(matches!(ToothLoss::new(20, 20, 0.1), Err(P::TooMany { value: 20, max: 19, .. })));
    assert!(matches!(QualityGrade::new(0), Err(P::TooFew { .. })));
    assert!(matches!(QualityGrade::new(12), Err(P::TooMany { .. })));
    let harmonics = TransmissionError::of_harmonics(&[]).unwrap();
    assert!(harmonics.with_eccentricity([0.0, 1.0], [0.0; 2]).is_err());
    assert!(TransmissionError::of_harmonics(&[[f64::NAN, 0.0]]).is_err());
    let ok = |_: f64, _: f64| Ok::<f64, P>(1.0);
    assert_eq!(Piecewise::fit(&[], 1e-9, ok).unwrap_err(), P::Empty { name: "edges".into(), min: 1 });
    assert!(matches!(Piecewise::fit(&[2.0, 1.0], 1e-9, ok), Err(P::Wrong { value: 1.0, .. })));
    assert!(matches!(Piecewise::fit(&[-1.0], 1e-9, ok), Err(P::OutOfRange { .. })));
    assert!(matches!(Piecewise::fit(&[0.0], 1e-9, |_, _| Ok(f64::NAN)), Err(P::NotFinite { .. })));
    assert!(Piecewise::fit(&[0.0], 1e-9, ok).unwrap().fourier_series(1001).is_err());
    let pair = pair_19_48();
    assert!(matches!(method.pair(&pair, 1.7), Err(TeethError::Parameter(P::OutOfRange { value: 1.7, .. }))));
    assert!(method.mesh(&pair, -0.1).is_err() && method.tooth(&gear, 2.0).is_err());
    assert!(pair.rectangular(1.0, f64::INFINITY).is_err());
    let long = TipRelief::new([0.0; 2], [1.0; 2]).unwrap();
    assert!(long.unloaded_error(&pair).is_err() && long.at(&pair, -1.0).is_err());
    let found = MethodB::new().stiffness(&pair).unwrap();
    assert!(found.resonance_speed(0, 1.0).is_err() && found.resonance_speed(19, 0.0).is_err());
    for wild in [f64::NAN, f64::INFINITY] {
        for result in [
            InvoluteGear::external(20, wild),
            gear.with_pressure_angle(wild),
            gear.with_helix_angle(wild),
            gear.with_profile_shift(wild),
            gear.with_addendum(wild),
            gear.with_dedendum(wild),
            gear.with_fillet_radius(wild),
            gear.with_tip_alteration(wild),
            gear.with_face_width(wild),
        ] {
            assert!(matches!(result, Err(P::NotFinite { .. })));
        }
        assert!(matches!(
            GearPair::at_centre_distance(&gear, &gear, wild),
            Err(TeethError::Parameter(P::NotFinite { .. }))
        ));
        assert!(
            gear.blank(wild, 1e3).is_err()
                && gear.blank(0.0, wild).is_err()
                && gear.tooth_thickness(wild).is_err()
        );
        assert!(method.material(wild, 0.3).is_err() && method.material(2e11, wild).is_err());
        assert!(method.pair(&pair, wild).is_err() && method.mesh(&pair, wild).is_err());
        assert!(TipRelief::new([wild, 0.0], [1e-3; 2]).is_err() && ToothLoss::new(5, 1, wild).is_err());
        assert!(MethodB::new().web(wild, 1.0).is_err() && MethodB::new().line_load(wild).is_err());
    }
}

#[test]
fn teeth_that_cannot_be_made() {
    let good = external(40, 0.0, 0.003);
    let with = |gear: InvoluteGear| GearPair::new(&good, &gear).unwrap_err();
    assert!(matches!(
        with(external(12, 0.0, 0.003)),
        TeethError::Undercut { gear: 1, teeth: 12, shift: 0.0, least } if (least - (1.0 - 6.0 * 20f64.to_radians().sin().powi(2))).abs() < 1e-12
    ));
    assert!(
        matches!(with(external(10, 1.2, 0.003)), TeethError::Pointed { gear: 1, thickness } if thickness < 0.0)
    );
    let ring = InvoluteGear::internal(42, 0.003).unwrap().with_addendum(2.0).unwrap();
    assert!(matches!(
        GearPair::new(&external(20, 0.0, 0.003), &ring).unwrap_err(),
        TeethError::TipBelowBase { gear: 1, .. }
    ));
    let flat = good.with_addendum(0.1).unwrap().with_tip_alteration(-0.006).unwrap();
    assert!(matches!(with(flat), TeethError::TipBelowBase { gear: 1, tip, base } if tip < base));
    let many = external(400, 0.0, 0.003).with_addendum(0.1).unwrap();
    let many = many.with_tip_alteration(-0.0045).unwrap();
    assert!(
        matches!(with(many), TeethError::NoTooth { gear: 1, height } if height < 0.0),
        "{:?}",
        with(many)
    );
}

#[test]
fn gears_that_cannot_mesh() {
    let gear = |z| external(z, 0.0, 0.003);
    let ring = |z| InvoluteGear::internal(z, 0.003).unwrap();
    let new = |a: InvoluteGear, b: InvoluteGear| GearPair::new(&a, &b).unwrap_err();
    assert_eq!(
        new(gear(20), external(30, 0.0, 0.004)),
        TeethError::Different { name: "the modules", first: 0.003, second: 0.004 }
    );
    let steep = gear(30).with_pressure_angle(0.4).unwrap();
    assert!(matches!(new(gear(20), steep), TeethError::Different { name: "the pressure angles", .. }));
    let helical = gear(30).with_helix_angle(0.2).unwrap();
    assert!(matches!(new(gear(20), helical), TeethError::Different { name: "the helix angles", .. }));
    assert_eq!(new(ring(40), ring(60)), TeethError::TwoInternal);
    assert_eq!(new(ring(30), gear(30)), TeethError::InternalTooSmall { internal: 30, external: 30 });
    let short = gear(40).with_addendum(0.3).unwrap();
    assert!(matches!(new(short, short), TeethError::ContactRatio { value } if value < 1.0 && value > 0.0));
    let tall = gear(120).with_addendum(1.1).unwrap();
    // A pinion below the involute that a rack makes, accepted if another tool makes it.
    let inner = ring(100);
    assert!(matches!(new(gear(40), inner), TeethError::Interference { gear: 0, .. }));
    assert!(GearPair::new(&gear(40).allow_undercut(), &inner).is_ok());
    assert!(
        matches!(new(gear(18), tall), TeethError::Interference { gear: 0, contact, involute } if contact < involute)
    );
    // The partner reaches past the base circle: there is no radius of contact to report.
    let undercut = new(gear(9).allow_undercut(), gear(120));
    assert_eq!(undercut, TeethError::BeyondBaseCircle { gear: 0 });
    assert!(
        undercut.to_string().starts_with("the mesh undercuts gear 0")
            && !undercut.to_string().contains("0.0 m")
    );
    let close = GearPair::at_centre_distance(&gear(20), &gear(40), 0.0895).unwrap_err();
    assert!(matches!(close, TeethError::NoBacklash { backlash } if backlash < 0.0), "{close:?}");
    let far = GearPair::at_centre_distance(&gear(20), &gear(40), 0.08).unwrap_err();
    assert!(matches!(far, TeethError::NoWorkingAngle { name: "centre distance", value: 0.08, .. }));
    assert!(matches!(
        new(external(30, -0.9, 0.003).allow_undercut(), external(30, -0.9, 0.003).allow_undercut()),
        TeethError::NoWorkingAngle { name: "sum of profile shifts", limit, .. } if limit > -1.8
    ));
    let deep = external(40, 0.0, 0.003).with_addendum(1.3).unwrap();
    assert!(matches!(new(deep, gear(60)), TeethError::NoClearance { gear: 0, clearance } if clearance < 0.0));
    // At a pressure angle of 20° a ring needs about 8 teeth more than its pinion, or short teeth.
    let inner = |z| ring(z).with_addendum(0.8).unwrap();
    assert!(GearPair::new(&gear(60), &inner(68)).is_ok());
    let overlap = new(gear(60), inner(64));
    assert!(matches!(overlap, TeethError::TipInterference { overlap } if overlap > 0.0), "{overlap:?}");
    assert!(GearPair::shortened(&gear(20), &ring(60)).is_err());
    assert!(GearPair::shortened(&gear(20), &helical).is_err());
}

#[test]
fn methods_outside_their_range() {
    let (a, b) = (external(40, 0.0, 0.003), external(60, 0.0, 0.003));
    let method = PotentialEnergy::ma_2014([0.03; 2]).unwrap();
    let not = |teeth| TeethError::NotApplicable { method: "the potential-energy method", teeth };
    let helix = |gear: InvoluteGear, beta| gear.with_helix_angle(beta).unwrap();
    let helical = GearPair::new(&helix(a, 0.2), &helix(b, 0.2)).unwrap();
    assert_eq!(method.wave(&helical).unwrap_err(), not("helical"));
    let ring = InvoluteGear::internal(100, 0.003).unwrap().with_addendum(0.7).unwrap();
    assert_eq!(method.wave(&GearPair::new(&a, &ring).unwrap()).unwrap_err(), not("internal"));
    let sharp = a.with_fillet_radius(0.0).unwrap();
    let error = method.tooth(&sharp, 0.35).unwrap_err();
    assert!(matches!(error, TeethError::OutsideMethod { method: "the transition curve", value: 0.0, .. }));
    let undercut = external(12, 0.0, 0.003).allow_undercut();
    let error = method.tooth(&undercut, 0.35).unwrap_err();
    assert_eq!(error, TeethError::NotApplicable { method: "the transition curve", teeth: "undercut" });
    assert!(matches!(method.tooth(&a, 0.01), Err(TeethError::Interference { gear: 0, .. })));
    for bore in [0.001, 0.11] {
        let method = method.foundation(Foundation::PerPair([bore; 2])).unwrap();
        let error = method.wave(&GearPair::new(&a, &b).unwrap()).unwrap_err();
        assert!(matches!(
            error,
            TeethError::OutsideMethod { method: "the fillet foundation of Sainsot", .. }
        ));
        assert!(method.extrapolated().wave(&GearPair::new(&a, &b).unwrap()).is_ok());
    }
    let iso = |a: InvoluteGear, b: InvoluteGear| {
        MethodB::new().stiffness(&GearPair::new(&a, &b).unwrap()).unwrap_err().to_string()
    };
    let shifted = |gear: InvoluteGear, x| gear.with_profile_shift(x).unwrap();
    assert!(
        iso(shifted(external(90, 0.0, 0.003), -0.3), shifted(external(90, 0.0, 0.003), -0.3))
            .contains("the sum of profile shifts = -0.6")
    );
    assert!(iso(helix(a, 0.6), helix(b, 0.6)).contains("the helix angle in degrees = 34.3"));
    let tall = |gear: InvoluteGear| gear.with_addendum(1.6).unwrap().with_dedendum(1.85).unwrap();
    assert!(
        iso(tall(external(90, 0.0, 0.003)), tall(external(90, 0.0, 0.003)))
            .contains("the transverse contact ratio = 2.")
    );
    let grade = QualityGrade::new(6).unwrap();
    let error = grade.tolerances(&external(1200, 0.0, 0.003)).unwrap_err();
    assert!(matches!(error, TeethError::OutsideMethod { method: "ISO 1328-1", value: 1200.0, .. }));
    assert!(grade.tolerances(&external(20, 0.0, 0.0004)).is_err());
    assert!(grade.tolerances(&external(20, 0.0, 0.1)).is_err());
}

/// Section by section: the mesh cycle of one transverse section is refused for helical teeth. With the levels c' b and
/// 1.75 c' b it varies by 0.75/(0.75 ε_α + 0.25) of the mean; averaged over ε_β cycles of width, with the fraction f of
/// ε_β and the fraction a of ε_α, by 0.75 min(f, 1 - f, a, 1 - a)/ε_β of c' b, which is a third of it here.
#[test]
fn sections_of_helical_teeth_are_refused() {
    for (degrees, widest) in [(10.0f64, 0.19), (20.0, 0.17)] {
        let gear = |z| external(z, 0.0, 0.003).with_helix_angle(degrees.to_radians()).unwrap();
        let gear = |z| gear(z).with_face_width(0.04).unwrap();
        let pair = GearPair::new(&gear(25), &gear(50)).unwrap();
        let refused = TeethError::Helical { angle: degrees.to_radians() };
        let iso = MethodB::new().stiffness(&pair).unwrap();
        assert_eq!(iso.rectangular().unwrap_err(), refused);
        assert_eq!(pair.rectangular(1.0, 2.0).unwrap_err(), refused);
        let relief = TipRelief::new([1e-5; 2], [1e-3; 2]).unwrap();
        assert_eq!(relief.unloaded_error(&pair).unwrap_err(), refused);
        assert!(refused.to_string().contains("combine the sections across the face width"), "{refused}");
        // What the refusal prevents: the section varies by half of the mean, the mesh by less than a fifth.
        let (a, overlap) = (pair.contact_ratio().fract(), pair.overlap_ratio());
        let f = overlap.fract();
        let section = 0.75 / (0.75 * pair.contact_ratio() + 0.25);
        let mesh = section * f.min(1.0 - f).min(a).min(1.0 - a) / overlap;
        assert!(section > 0.49 && mesh < widest, "{degrees}: {section} {mesh}");
    }
    let pair = pair_19_48();
    assert!(
        pair.rectangular(1.0, 2.0).is_ok() && MethodB::new().stiffness(&pair).unwrap().rectangular().is_ok()
    );
}
