//! Bifurcations beside grazings of a branch.

use gear_dynamics::branches::{Branch, BranchEnd, Continuation, Family, PointKind};
use gear_dynamics::trains::SpurPair;
use gear_dynamics::{Dop853, Model, Settle, Shooting, State};

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// The branch of a dimensionless pair over the speeds 0.5 to 2.4, from its settled orbit.
fn branch(zeta: f64, load: f64, waves: [&[f64]; 2], continuation: Continuation) -> Result<Branch> {
    let pair = SpurPair::of_numbers(zeta, load, waves[0], waves[1])?.parts()?.build("driver", 0.5)?;
    let settle = Settle::new().tolerance(1e-8).max_periods(600);
    let start = State::at_rest(pair.dof());
    let steady = settle.run(&Dop853::new().rtol(1e-10).atol(1e-16), &pair, &start)?;
    let family = Family::over(&pair, ["speed"])?;
    let shooting = Shooting::new().period_multiple(steady.period_multiple);
    Ok(continuation.shooting(shooting).run(&family, &[steady.state])?)
}

/// The parameters of the located points of one kind up to a bound.
fn located(branch: &Branch, kind: PointKind, below: f64) -> Vec<f64> {
    let all = branch.of_kind(kind).into_iter().map(|point| point.parameter);
    all.filter(|p| *p < below).collect()
}

#[test]
fn both_doublings_around_a_grazing() -> Result<()> {
    let waves: [&[f64]; 2] = [
        &[0.022_014_925_184_180_745, -0.148_500_473_565_412_9],
        &[0.113_047_327_857_357_94, 0.280_493_118_552_031_8],
    ];
    let (zeta, load) = (0.071_807_248_218_562_23, 0.315_488_532_783_552_54);
    let long = branch(zeta, load, waves, Continuation::new(0.5, 2.4))?;
    let short = Continuation::new(0.5, 0.6).first_step(1e-3).max_step(5e-3);
    let short = branch(zeta, load, waves, short)?;
    let [grazings, doublings] =
        [PointKind::Grazing, PointKind::PeriodDoubling].map(|kind| located(&long, kind, 0.6));
    // The window of doubled orbits contains the grazing, where the multiplier is -1.4492.
    assert_eq!(doublings.len(), 2, "{long}");
    assert!(grazings.iter().any(|p| doublings[0] < *p && *p < doublings[1]), "{long}");
    let expected = located(&short, PointKind::PeriodDoubling, 0.6);
    assert_eq!(expected.len(), 2, "{short}");
    for (p, expected) in doublings.iter().zip(&expected) {
        assert!((p - expected).abs() < 1e-8, "{doublings:?} {expected:?}");
    }
    for point in long.of_kind(PointKind::PeriodDoubling) {
        let nearest =
            point.multipliers.values().iter().map(|m| (m + 1.0).norm()).fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-5, "{nearest}");
    }
    Ok(())
}

#[test]
fn two_different_extremes_pass_the_edge_within_one_step() -> Result<()> {
    // A maximum reaches the upper edge, then the minimum after it: as many crossings before as behind.
    let waves: [&[f64]; 2] = [
        &[-0.207_615_271_888_213_6, 0.098_545_364_615_013_68],
        &[0.027_315_071_566_342_33, -0.233_002_950_512_781_7],
    ];
    let (zeta, load) = (0.070_022_157_987_620_63, 0.459_723_566_287_956_5);
    let branch = branch(zeta, load, waves, Continuation::new(0.5, 2.4))?;
    let found = located(&branch, PointKind::Grazing, 1.2);
    for expected in [1.070_517_192_054, 1.082_305_138_649] {
        assert!(found.iter().any(|p| (p - expected).abs() < 1e-9), "{expected} {found:?}");
    }
    Ok(())
}

#[test]
fn extremes_that_vanish_beside_an_edge_have_grazed_it() -> Result<()> {
    let waves: [&[f64]; 2] = [
        &[0.028_128_307_200_428_804, -0.042_166_705_099_328_516],
        &[-0.087_462_527_618_252_99, 0.178_677_258_400_857_13],
    ];
    let (zeta, load) = (0.040_489_276_399_906_814, 0.362_363_099_471_127_2);
    let branch = branch(zeta, load, waves, Continuation::new(0.5, 2.4))?;
    let found = located(&branch, PointKind::Grazing, 1.0);
    for expected in [0.987_520_449_326_5, 0.987_625_224_355_2] {
        assert!(found.iter().any(|p| (p - expected).abs() < 1e-9), "{expected} {found:?}");
    }
    Ok(())
}

#[test]
fn orbits_of_two_periods_end_at_their_parent() -> Result<()> {
    // The branch of doubled orbits turns back where it meets orbits of one period. A step across its tip would go on
    // along those.
    let waves: [&[f64]; 2] = [
        &[-0.043_301_650_909_085_89, 0.225_933_739_783_953_65],
        &[-0.119_383_923_928_911_23, -0.226_810_760_112_280_19],
    ];
    let (zeta, load) = (0.085_906_944_054_188_87, 0.099_596_889_837_665_11);
    let branch = branch(zeta, load, waves, Continuation::new(0.5, 2.4))?;
    assert_eq!(branch.points()[0].orbit.period_multiple(), 2);
    let tips = located(&branch, PointKind::Branch, 2.4);
    assert!(tips.len() == 1 && (tips[0] - 0.723_198_955_02).abs() < 1e-9, "{branch}");
    // It returns through the same points, which are no folds.
    let doublings = located(&branch, PointKind::PeriodDoubling, 2.4);
    assert_eq!(doublings.len() % 2, 0, "{branch}");
    for k in 0..doublings.len() / 2 {
        assert!((doublings[k] - doublings[doublings.len() - 1 - k]).abs() < 1e-8, "{doublings:?}");
    }
    assert_eq!(located(&branch, PointKind::Fold, 2.4).len(), 0, "{branch}");
    Ok(())
}

#[test]
fn a_line_that_passes_beside_its_first_point_is_not_closed() -> Result<()> {
    // Beyond the fold the branch comes back beside its first point, with other motions: it ends at the bound.
    let waves: [&[f64]; 2] = [
        &[0.214_705_574_489_662_38, -0.222_423_319_865_678_1],
        &[-0.053_329_346_611_013_684, 0.015_152_051_878_228_712],
    ];
    let (zeta, load) = (0.021_344_592_098_428_334, 0.180_550_597_584_572_04);
    let branch = branch(zeta, load, waves, Continuation::new(0.5, 2.4))?;
    assert_eq!(branch.end(), &BranchEnd::Bound);
    let [first, last] =
        [branch.points().first(), branch.points().last()].map(|p| p.map(|p| p.peak_to_peak()));
    assert!(last > first.map(|first| 1.5 * first), "{branch}");
    let grazings = located(&branch, PointKind::Grazing, 2.4);
    for expected in [0.521_620_306_03, 0.528_143_331_8] {
        assert!(grazings.iter().any(|p| (p - expected).abs() < 1e-9), "{expected} {grazings:?}");
    }
    Ok(())
}

/// The multiplier of doubled orbits passes -1 in 2.4e-6 of the speed before they meet their parent, in the step across
/// this crossing, and once more on the way back.
#[test]
fn doublings_beside_the_crossing_at_which_a_branch_turns_back() -> Result<()> {
    let waves: [&[f64]; 2] = [
        &[0.027_076_490_738_295_544, 0.088_984_873_751_102_87],
        &[0.177_900_029_113_077_5, -0.115_342_378_655_698_35],
    ];
    let (zeta, load) = (0.089_758_071_421_813_48, 0.035_485_684_133_547_406);
    let branch = branch(zeta, load, waves, Continuation::new(0.5, 2.4))?;
    let turns: Vec<f64> = located(&branch, PointKind::Branch, 2.4);
    assert!(turns.len() == 1 && (turns[0] - 0.533_982_487_17).abs() < 1e-9, "{branch}");
    let doublings = located(&branch, PointKind::PeriodDoubling, 2.4);
    let beside: Vec<f64> = doublings.into_iter().filter(|p| (p - 0.533_980_128_129).abs() < 1e-9).collect();
    assert_eq!(beside.len(), 2, "{branch}");
    Ok(())
}
