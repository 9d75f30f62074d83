//! Pairs of bifurcations within one step of a branch, and notes of steps within which a branch turns back.

use gear_dynamics::branches::{Continuation, Family, PointKind};
use gear_dynamics::excitation::Fourier;
use gear_dynamics::model::from_fn;
use gear_dynamics::trains::{
    Body, Coordinates, Members, MeshPart, Planetary, ShaftPart, SpurPair, Train, two_stage,
};
use gear_dynamics::{Dop853, Model, Settle, Shooting, State, Wave};
use std::f64::consts::TAU;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// The points of a branch over the speed from `speed` to its double, by steps of the default length and by short ones.
fn located_by_both(train: &Train, speed: f64, kind: PointKind) -> Result<[Vec<f64>; 2]> {
    let settle = Settle::new().tolerance(1e-8).max_periods(600);
    let steady = settle.run(&Dop853::new().rtol(1e-10).atol(1e-16), train, &State::at_rest(train.dof()))?;
    let (family, mut found) = (Family::over(train, ["speed"])?, [Vec::new(), Vec::new()]);
    let long = Continuation::new(speed, 2.0 * speed);
    for (steps, found) in
        [long.clone(), long.first_step(0.001).max_step(0.005).max_points(2000)].iter().zip(&mut found)
    {
        let shooting = Shooting::new().period_multiple(steady.period_multiple);
        let branch = steps.clone().shooting(shooting).run(&family, &steady.state)?;
        *found = branch.of_kind(kind).iter().map(|point| point.parameter).collect();
        found.sort_by(f64::total_cmp);
    }
    Ok(found)
}

/// The multipliers of three equal planets pass 1 together and come back within one step. The determinant keeps its sign.
#[test]
fn equal_members_lose_and_regain_stability_within_one_step() -> Result<()> {
    let wave = |k: f64, share: f64| Fourier::new(k, &[[share * k, 0.0]]).map(Wave::new);
    let members = Members {
        sun: (36, Body::new(1e-3)),
        planet: (24, Body::new(1e-3)),
        ring: (84, Body::new(5e-2).locked()),
        carrier: Body::new(3e-2),
    };
    let waves = [wave(318_711_311.038_558_6, 0.266_259_015)?, wave(187_607_993.587, 0.202_560_532)?];
    let set = Planetary::new(3, 0.03, members, waves)?.damping(549.210_749_8).half_backlash(1.295_070_5e-5);
    let mut parts = set.parts();
    let torque = 13.824_536_3;
    parts.torque("drive", "sun", torque).torque("load", "carrier", -(1.0 + 84.0 / 36.0) * torque);
    let speed = 228.343_336_6;
    let train = parts.coordinates(Coordinates::Relative).build("sun", speed)?;
    let [long, short] = located_by_both(&train, speed, PointKind::Branch)?;
    assert_eq!(long.len(), 4, "{long:?} {short:?}");
    assert!(long.iter().zip(&short).all(|(a, b)| (a / b - 1.0).abs() < 1e-8), "{long:?} {short:?}");
    Ok(())
}

/// A complex pair leaves the unit circle and comes back within one step. The parabola through the middle of the step
/// stays above 0.
#[test]
fn a_complex_pair_leaves_the_circle_and_comes_back_within_one_step() -> Result<()> {
    let mesh = |teeth: [u32; 2], mean: f64, share: f64| -> Result<MeshPart> {
        let wave = Wave::new(Fourier::new(mean, &[[share * mean, 0.0]])?);
        let part = MeshPart::external(teeth, teeth.map(|z| 1e-3 * f64::from(z)), wave);
        Ok(part.damping(554.766_922_967_831_4).half_backlash(1.995_428_538_846_601_5e-5))
    };
    let inertias = [
        0.001_196_711_823_731_293_3,
        0.000_433_905_705_333_017_6,
        0.000_482_672_687_754_835_3,
        0.002_493_568_510_499_767_3,
    ];
    let meshes = [
        mesh([30, 45], 364_340_913.754_632_96, 0.177_647_956_862_103_02)?,
        mesh([30, 40], 177_941_142.154_337_02, 0.275_015_010_674_350_75)?,
    ];
    let mut parts = two_stage(inertias, ShaftPart::new(274_676.795_257_368).damping(1.0), meshes);
    let torque = 25.328_306_318_447_46;
    parts.torque("drive", "pinion 1", torque).torque("load", "wheel 2", -2.0 * torque);
    let speed = 314.777_093_720_706_3;
    let train = parts.coordinates(Coordinates::Relative).build("pinion 1", speed)?;
    let [long, short] = located_by_both(&train, speed, PointKind::NeimarkSacker)?;
    let pair = [460.717_250, 462.929_476];
    for found in [&long, &short] {
        let near = |at: &f64| found.iter().any(|x| (x / at - 1.0).abs() < 1e-8);
        assert!(pair.iter().all(near), "{long:?} {short:?}");
    }
    assert_eq!(long.len(), short.len(), "{long:?} {short:?}");
    Ok(())
}

/// Two period doublings lie within a step whose ends are as far from a doubling as the point before it. The point after it
/// shows them.
#[test]
fn two_doublings_that_only_the_next_point_shows() -> Result<()> {
    let mesh = |teeth: [u32; 2], mean: f64, share: f64| -> Result<MeshPart> {
        let wave = Wave::new(Fourier::new(mean, &[[share * mean, 0.0]])?);
        let part = MeshPart::external(teeth, teeth.map(|z| 1e-3 * f64::from(z)), wave);
        Ok(part.damping(876.411_039_023_094).half_backlash(1.102_666_218_330_342e-6))
    };
    let inertias = [
        0.000_433_776_334_060_300_3,
        0.000_616_538_201_353_107_4,
        0.000_335_742_681_393_088_6,
        0.001_318_365_569_955_301_6,
    ];
    let meshes = [
        mesh([20, 40], 332_500_970.256_119_67, 0.142_778_193_663_599_3)?,
        mesh([20, 30], 147_288_268.268_676_6, 0.290_240_000_572_774_55)?,
    ];
    let mut parts = two_stage(inertias, ShaftPart::new(214_184.016_131_123_3).damping(1.0), meshes);
    let torque = 23.205_547_352_792_23;
    parts.torque("drive", "pinion 1", torque).torque("load", "wheel 2", -3.0 * torque);
    let speed = 513.622_177_450_774_2;
    let train = parts.coordinates(Coordinates::Relative).build("pinion 1", speed)?;
    let [long, short] = located_by_both(&train, speed, PointKind::PeriodDoubling)?;
    let near = |at: f64| long.iter().any(|x| (x / at - 1.0).abs() < 1e-8);
    assert!([995.563_035_7, 996.962_576_7].into_iter().all(near), "{long:?} {short:?}");
    assert_eq!(long.len(), short.len(), "{long:?} {short:?}");
    assert!(long.iter().zip(&short).all(|(a, b)| (a / b - 1.0).abs() < 1e-8), "{long:?} {short:?}");
    Ok(())
}

/// A complex pair leaves the unit circle 0.06 rad/s behind a period doubling and comes back 0.03 rad/s before a grazing: the
/// stretch between these two is searched by its middle.
#[test]
fn two_tori_between_a_doubling_and_a_grazing() -> Result<()> {
    let mesh = |teeth: [u32; 2], mean: f64, share: f64| -> Result<MeshPart> {
        let wave = Wave::new(Fourier::new(mean, &[[share * mean, 0.0]])?);
        let part = MeshPart::external(teeth, teeth.map(|z| 1e-3 * f64::from(z)), wave);
        Ok(part.damping(520.623_466_615_433_1).half_backlash(2.049_021_116_642_111_6e-6))
    };
    let inertias = [
        0.001_648_940_256_610_444_7,
        0.000_860_793_384_309_358_6,
        0.002_624_928_513_319_037,
        0.001_406_092_816_347_859_2,
    ];
    let meshes = [
        mesh([20, 40], 322_736_890.101_293_5, 0.075_915_548_577_712_97)?,
        mesh([20, 30], 104_824_585.552_739_2, 0.259_068_569_271_097_8)?,
    ];
    let mut parts = two_stage(inertias, ShaftPart::new(113_243.816_746_330_86).damping(1.0), meshes);
    let torque = 18.978_539_119_476_952;
    parts.torque("drive", "pinion 1", torque).torque("load", "wheel 2", -3.0 * torque);
    let speed = 510.086_365_406_851_3;
    let train = parts.coordinates(Coordinates::Relative).build("pinion 1", speed)?;
    let [long, short] = located_by_both(&train, speed, PointKind::NeimarkSacker)?;
    let near = |at: f64| long.iter().any(|x| (x / at - 1.0).abs() < 1e-8);
    assert!([984.991_876_03, 985.173_899_70].into_iter().all(near), "{long:?} {short:?}");
    assert_eq!(long.len(), short.len(), "{long:?} {short:?}");
    Ok(())
}

/// At a crossing the branch turns back within a step. The note tells how far it reaches.
#[test]
fn a_note_reaches_as_far_as_the_branch() -> Result<()> {
    let stiffness = [-0.009_284_487_830_699_906, -0.247_148_306_488_064_07];
    let error = [0.123_903_713_529_665_06, -0.169_521_568_598_138_22];
    let pair = SpurPair::of_numbers(0.033_425_226_585_401_98, 0.053_184_661_962_062_244, &stiffness, &error)?;
    let train = pair.parts()?.build("driver", 0.5)?;
    let settle = Settle::new().tolerance(1e-8).max_periods(600);
    let steady = settle.run(&Dop853::new().rtol(1e-10).atol(1e-16), &train, &State::at_rest(1))?;
    let family = Family::over(&train, ["speed"])?;
    let shooting = Shooting::new().period_multiple(steady.period_multiple);
    let long = Continuation::new(0.5, 2.4).shooting(shooting);
    let short = long.clone().first_step(0.001).max_step(0.005);
    let [long, short] = [long.run(&family, &steady.state)?, short.run(&family, &steady.state)?];
    let crossing = short.of_kind(PointKind::Branch);
    let at = crossing.first().ok_or("a crossing")?.parameter;
    let told = |branch: &gear_dynamics::branches::Branch| {
        let noted = branch.notes().iter().any(|note| {
            let [from, to] = note.parameters;
            from.min(to) <= at && at <= from.max(to)
        });
        noted
            || branch.of_kind(PointKind::Branch).iter().any(|point| (point.parameter / at - 1.0).abs() < 1e-8)
    };
    assert!(told(&long), "{at} {long}");
    Ok(())
}

/// A spur pair at the speed 0.5, and the multiple of its settled motion.
fn settled_pair(zeta: f64, load: f64, stiffness: [f64; 2], error: [f64; 2]) -> Result<(Train, State, usize)> {
    let train = SpurPair::of_numbers(zeta, load, &stiffness, &error)?.parts()?.build("driver", 0.5)?;
    let settle = Settle::new().tolerance(1e-8).max_periods(600);
    let steady = settle.run(&Dop853::new().rtol(1e-10).atol(1e-16), &train, &State::at_rest(1))?;
    Ok((train, steady.state, steady.period_multiple))
}

/// A maximum of the deflection and a minimum beside it pass the edge one after the other; both vanish before the end of
/// the step. Another minimum in the same tenth of the period is not one of them.
#[test]
fn two_extremes_that_pass_an_edge_and_vanish_within_one_step() -> Result<()> {
    let (stiffness, error) = ([0.178_276_584_2, 0.208_627_505_3], [0.062_412_359_9, 0.231_879_431_6]);
    let (train, start, multiple) = settled_pair(0.010_491_092_16, 0.190_817_156_2, stiffness, error)?;
    let (family, mut found) = (Family::over(&train, ["speed"])?, Vec::new());
    let long = Continuation::new(0.5, 2.4);
    for steps in [long.clone(), long.clone().first_step(0.001).max_step(0.005), long.max_step(0.0005)] {
        let shooting = Shooting::new().period_multiple(multiple);
        let branch = steps.max_points(2000).shooting(shooting).run(&family, &start)?;
        let grazings = branch.of_kind(PointKind::Grazing);
        found.push(grazings.iter().map(|point| point.parameter).collect::<Vec<f64>>());
    }
    let [a, b] = found[0][..] else { return Err(format!("{found:?}").into()) };
    assert!((a - b - 1.18e-5).abs() < 1e-7, "{found:?}");
    let same = |x: &Vec<f64>| x.len() == 2 && (x[0] / a - 1.0).abs().max((x[1] / b - 1.0).abs()) < 1e-8;
    assert!(found.iter().all(same), "{found:?}");
    Ok(())
}

/// Behind the fold at 0.6318 another branch comes close. A long step must not pass over the gap to it.
#[test]
fn a_step_does_not_jump_over_a_fold_to_another_branch() -> Result<()> {
    let (stiffness, error) = (
        [0.221_779_888_622_777_14, -0.245_211_315_750_884_48],
        [-0.052_062_097_943_859_686, -0.270_501_238_538_308_93],
    );
    let (train, state, multiple) =
        settled_pair(0.036_417_078_344_097_284, 0.344_803_306_884_980_6, stiffness, error)?;
    let family = Family::over(&train, ["speed"])?;
    let branch = Continuation::new(0.5, 2.4).shooting(Shooting::new().period_multiple(multiple));
    let branch = branch.run(&family, &state)?;
    let folds: Vec<f64> = branch.of_kind(PointKind::Fold).iter().map(|point| point.parameter).collect();
    assert!((folds[2] - 0.631_802_847_5).abs() < 1e-9, "{branch}");
    assert!(branch.points().iter().all(|point| point.parameter < 0.632), "{branch}");
    Ok(())
}

/// Two folds lie within one step whose ends both rise: the speed of its end is below that of its start.
#[test]
fn two_folds_within_one_step() -> Result<()> {
    let (stiffness, error) = (
        [0.113_294_198_307_560_38, -0.107_667_432_431_933_36],
        [0.130_353_886_448_434_76, -0.293_547_310_059_419_7],
    );
    let (train, state, multiple) =
        settled_pair(0.065_806_238_118_146_69, 0.202_078_659_259_439_24, stiffness, error)?;
    let family = Family::over(&train, ["speed"])?;
    let shooting = Shooting::new().period_multiple(multiple);
    let branch = Continuation::new(0.5, 2.4).shooting(shooting).run(&family, &state)?;
    let folds: Vec<f64> = branch.of_kind(PointKind::Fold).iter().map(|point| point.parameter).collect();
    let by_short_steps = [0.612_578_280_552, 0.519_929_657_745, 0.526_242_035_430, 0.524_861_181_745];
    assert_eq!(folds.len(), 4, "{branch}");
    assert!(folds.iter().zip(by_short_steps).all(|(a, b)| (a - b).abs() < 1e-9), "{branch}");
    Ok(())
}

/// A branch of doubled orbits begins on a bound of the speed and turns back 4e-5 behind it.
#[test]
fn a_branch_that_turns_back_beside_its_bound_has_the_turn() -> Result<()> {
    let (stiffness, error) = (
        [0.059_153_198_096_391_19, -0.279_573_092_208_865],
        [0.282_592_023_783_889_4, 0.100_084_970_306_403_9],
    );
    let (train, state, multiple) =
        settled_pair(0.027_343_232_817_235_71, 0.153_863_317_667_114_34, stiffness, error)?;
    let family = Family::over(&train, ["speed"])?;
    let branch = Continuation::new(0.5, 2.4).shooting(Shooting::new().period_multiple(multiple));
    let branch = branch.run(&family, &state)?;
    let crossings = branch.of_kind(PointKind::Branch);
    assert!((crossings[0].parameter - 0.500_040_113_2).abs() < 1e-9, "{branch}");
    Ok(())
}

/// A branch of doubled orbits turns back at a crossing. Rounding makes folds beside it with short steps.
#[test]
fn a_crossing_at_which_a_branch_turns_back_has_no_folds_beside_it() -> Result<()> {
    let (stiffness, error) = (
        [-0.020_245_522_180_293_296, -0.250_672_808_723_867_8],
        [-0.142_244_663_954_052_08, 0.074_182_738_987_090_49],
    );
    let (train, state, multiple) =
        settled_pair(0.097_115_266_538_785_01, 0.050_493_747_671_991_8, stiffness, error)?;
    let family = Family::over(&train, ["speed"])?;
    let short = Continuation::new(0.5, 2.4).first_step(0.001).max_step(0.005);
    let branch = short.shooting(Shooting::new().period_multiple(multiple)).run(&family, &state)?;
    assert_eq!(branch.of_kind(PointKind::Branch).len(), 1, "{branch}");
    assert_eq!(branch.of_kind(PointKind::Fold).len(), 2, "{branch}");
    Ok(())
}

/// q = B(t) + x with x'' = (p - 3) x - x³ - 0.5 x': x = √(p - 3) turns back at the crossing with x = 0 at p = 3, beside a
/// motion that is twenty times as large.
#[test]
fn a_small_motion_that_branches_beside_a_large_one() -> Result<()> {
    for large in [5.0, 20.0] {
        let family = Family::of([("p", "1")], move |[p]: [f64; 1]| {
            let motion = move |t: f64, q: &[f64], v: &[f64], a: &mut [f64]| {
                let (one, two) = (t.sin_cos(), (2.0 * t).sin_cos());
                let x = q[0] - large * (one.1 + 0.3 * two.1);
                let dx = v[0] + large * (one.0 + 0.6 * two.0);
                a[0] = -large * (one.1 + 1.2 * two.1) + (p - 3.0) * x - x * x * x - 0.5 * dx;
            };
            from_fn(1, motion)?.with_period(TAU)
        });
        let start = State::new(0.0, &[1.0 + 1.3 * large], &[0.0]);
        let branch = Continuation::new(4.0, 2.0).bounds(2.0, 4.0).run(&family, &start)?;
        let at = branch.of_kind(PointKind::Branch);
        assert!(at.len() == 1 && (at[0].parameter - 3.0).abs() < 1e-8, "{branch}");
        assert!(
            branch.notes().is_empty() && branch.points().iter().all(|point| point.parameter > 3.0 - 1e-8)
        );
        // The other half: x = -√(p - 3).
        let end = &branch.points().last().unwrap().orbit.states()[0];
        assert!((end.q[0] - 1.3 * large + 1.0).abs() < 1e-6, "{end:?}");
    }
    Ok(())
}

/// q = cos t + x with x'' = (p - 3) x - x² - 0.5 x': at the transcritical crossing x = 0 the orbit has the symmetry
/// x(t + π) = -x(t), and the model does not. With x³ in place of x² both have it.
#[test]
fn a_symmetric_orbit_of_another_model_breaks_no_symmetry() -> Result<()> {
    for (power, kind) in [(2, PointKind::Branch), (3, PointKind::SymmetryBreaking)] {
        let family = Family::of([("p", "1")], move |[p]: [f64; 1]| {
            let motion = move |t: f64, q: &[f64], v: &[f64], a: &mut [f64]| {
                let (x, dx) = (q[0] - t.cos(), v[0] + t.sin());
                a[0] = -t.cos() + (p - 3.0) * x - x.powi(power) - 0.5 * dx;
            };
            from_fn(1, motion)?.with_period(TAU)
        });
        let start = State::new(0.0, &[2.0], &[0.0]);
        let branch = Continuation::new(4.0, 2.0).bounds(2.0, 4.0).run(&family, &start)?;
        let at = branch.of_kind(kind);
        assert!(at.len() == 1 && (at[0].parameter - 3.0).abs() < 1e-8, "{branch}");
    }
    Ok(())
}

/// A window of stability between two doublings, in one step, whose ends lie close to both: the product of the multipliers and 1
/// is -0.006 before, 0.003 inside and -0.007 behind it.
#[test]
fn a_window_of_stability_within_a_step_is_found() -> Result<()> {
    let (stiffness, error) = ([-0.299_491_025, 0.026_427_227], [0.002_090_09, -0.256_927_987]);
    let pair = SpurPair::of_numbers(0.019_991_792, 0.561_239_139, &stiffness, &error)?;
    let train = pair.parts()?.build("driver", 0.5)?;
    let steady = Settle::new().tolerance(1e-8).run(&Dop853::new(), &train, None)?;
    let family = Family::over(&train, ["speed"])?;
    let doublings = |continuation: Continuation| -> Result<Vec<f64>> {
        let branch = continuation.max_points(40).run(&family, &steady.state)?;
        let at = branch.of_kind(PointKind::PeriodDoubling);
        Ok(at.iter().map(|point| point.parameter).take_while(|p| *p < 0.64).collect())
    };
    let long = doublings(Continuation::new(0.5, 2.4))?;
    let short = doublings(Continuation::new(0.5, 0.64))?;
    assert_eq!((long.len(), short.len()), (3, 3), "{long:?} {short:?}");
    for (long, short) in long.iter().zip(&short) {
        assert!((long - short).abs() < 1e-9, "{long} {short}");
    }
    assert!((long[1] - 0.586_134).abs() < 1e-5 && (long[2] - 0.613_851).abs() < 1e-5, "{long:?}");
    Ok(())
}
