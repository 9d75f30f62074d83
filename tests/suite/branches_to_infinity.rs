//! Branches and lines that run to infinity at the border of parametric instability.

use crate::common::family::oscillator;
use gear_dynamics::branches::{
    Beyond, Branch, BranchEnd, BranchError, BranchPoint, Continuation, Family, PointKind,
};
use gear_dynamics::contact::Piece;
use gear_dynamics::trains::{SpurPair, Train};
use gear_dynamics::{Balance, Dop853, Harmonics, Model, Settle, State};
use std::f64::consts::TAU;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Damping ratio and stiffness waves of q'' + 2 ζ q' + (1 + κ1 cos Wt + κ2 cos 2Wt) q = 0: a pair without gap.
struct Hill {
    zeta: f64,
    waves: [f64; 2],
}

impl Hill {
    /// det(M - 1) over a period 2π/W, by the classical Runge-Kutta method.
    fn determinant(&self, w: f64) -> f64 {
        const STEPS: usize = 4000;
        let h = TAU / w / STEPS as f64;
        let slope = |t: f64, [q, v]: [f64; 2]| {
            let k = 1.0 + self.waves[0] * (w * t).cos() + self.waves[1] * (2.0 * w * t).cos();
            [v, -2.0 * self.zeta * v - k * q]
        };
        let along = |y: [f64; 2], k: [f64; 2], h: f64| [y[0] + h * k[0], y[1] + h * k[1]];
        let columns = [[1.0, 0.0], [0.0, 1.0]].map(|mut y| {
            for i in 0..STEPS {
                let t = h * i as f64;
                let a = slope(t, y);
                let b = slope(t + 0.5 * h, along(y, a, 0.5 * h));
                let c = slope(t + 0.5 * h, along(y, b, 0.5 * h));
                let d = slope(t + h, along(y, c, h));
                for k in 0..2 {
                    y[k] += h / 6.0 * (a[k] + 2.0 * b[k] + 2.0 * c[k] + d[k]);
                }
            }
            y
        });
        (columns[0][0] - 1.0) * (columns[1][1] - 1.0) - columns[1][0] * columns[0][1]
    }

    /// The root next to `w`, by secants.
    fn border(&self, w: f64) -> f64 {
        let (mut a, mut b) = (w * (1.0 - 1e-5), w * (1.0 + 1e-5));
        let mut at_a = self.determinant(a);
        for _ in 0..30 {
            let at_b = self.determinant(b);
            if at_a == at_b || (b - a).abs() < 1e-13 {
                break;
            }
            let next = b - at_b * (b - a) / (at_b - at_a);
            (a, at_a, b) = (b, at_b, next);
        }
        b
    }
}

fn settled(train: &Train) -> Result<State> {
    let settle = Settle::new().tolerance(1e-8).max_periods(600);
    let steady = settle.run(&Dop853::new().rtol(1e-10).atol(1e-16), train, &State::at_rest(train.dof()))?;
    assert_eq!(steady.period_multiple, 1);
    Ok(steady.state)
}

/// A pair whose branch runs to infinity at the first border of the instability near the speed 1.
fn pair() -> Result<(Train, Hill)> {
    let hill = Hill { zeta: 0.025, waves: [-0.18, 0.24] };
    let pair = SpurPair::of_numbers(hill.zeta, 0.52, &hill.waves, &[0.0, -0.075])?;
    Ok((pair.parts()?.build("driver", 0.5)?, hill))
}

fn largest(branch: &Branch) -> f64 {
    branch.points().iter().map(|point| point.peak_to_peak()).fold(0.0, f64::max)
}

#[test]
fn a_branch_ends_at_the_border_of_the_linear_system() -> Result<()> {
    let (train, hill) = pair()?;
    let (family, start) = (Family::over(&train, ["speed"])?, settled(&train)?);
    let branch = Continuation::new(0.5, 2.4).run(&family, &start)?;
    let BranchEnd::Unbounded { motion, border: Some(border) } = *branch.end() else {
        panic!("{branch}");
    };
    let exact = hill.border(border);
    assert!((border - exact).abs() < 1e-8, "{border} {exact}");
    // It ends after a few points: 20 times the gap of 2 and more.
    assert!(motion > 5000.0 && branch.points().iter().filter(|p| p.peak_to_peak() > 40.0).count() < 40);
    assert!(branch.end().to_string().contains("grows without bound towards the border"), "{}", branch.end());
    // A lower limit ends it earlier, at the same border.
    let early = Continuation::new(0.5, 2.4).max_motion(300.0).run(&family, &[start])?;
    let BranchEnd::Unbounded { motion, border: Some(same) } = *early.end() else {
        panic!("{early}");
    };
    assert!(motion > 300.0 && largest(&early) < 0.3 * largest(&branch) && (same - border).abs() < 1e-12);
    Ok(())
}

#[test]
fn a_resumed_branch_ends_where_the_whole_one_ends() -> Result<()> {
    let (train, _) = pair()?;
    let family = Family::over(&train, ["speed"])?;
    let range = Continuation::new(0.5, 2.4);
    let mut following = range.begin(&family, &[settled(&train)?])?;
    // Stopped at a motion that is large already.
    let large = |point: &BranchPoint| point.peak_to_peak() > 200.0;
    following.by_ref().find(large).ok_or("a large motion")?;
    let first = following.into_line();
    let rest = range.resume(&family, &first)?.finish();
    let whole = range.run(&family, &[settled(&train)?])?;
    let [BranchEnd::Unbounded { border: Some(a), motion }, BranchEnd::Unbounded { border: Some(b), .. }] =
        [rest.end(), whole.end()]
    else {
        panic!("{rest} {whole}");
    };
    assert!((a - b).abs() < 1e-8 && *motion < 1e5, "{a} {b} {motion}");
    Ok(())
}

/// A load that grows by a factor of 10⁵ along the branch moves a pair of little backlash by as much: the branch goes on.
#[test]
fn a_motion_that_grows_with_the_load_does_not_end_a_branch() -> Result<()> {
    let constants = [("speed", 0.6), ("damping", 0.1), ("mesh stiffness", 1.0), ("stiffness variation", 0.2)];
    let pair = oscillator(&[&constants[..], &[("mean force", 1e-5), ("half backlash", 1e-6)]].concat());
    let family = Family::over(&pair, ["mean force"])?;
    let guess = [State::new(0.0, &[1.1e-5], &[0.0])];
    let branch = Continuation::new(1e-5, 1.0).max_motion(50.0).run(&family, &guess)?;
    assert_eq!(branch.end(), &BranchEnd::Bound, "{branch}");
    Ok(())
}

#[test]
fn a_branch_comes_back_from_infinity() -> Result<()> {
    let (train, hill) = pair()?;
    let family = Family::over(&train, ["speed"])?;
    let branch = Continuation::new(0.5, 2.4).run(&family, &[settled(&train)?])?;
    let continuation = Continuation::new(0.5, 2.4).max_points(60);
    let BranchEnd::Unbounded { border: Some(border), .. } = *branch.end() else {
        panic!("{branch}");
    };
    let back = continuation.begin(&family, Beyond(&branch))?.finish();
    let [end, first] = [branch.points().last(), back.points().first()].map(|point| point.cloned());
    let (end, first) = (end.ok_or("a point")?, first.ok_or("a point")?);
    // It starts with large motions of the opposite sign at the same distance from the border, which become smaller.
    let near = (first.parameter - border).abs() / (end.parameter - border).abs();
    assert!((near - 1.0).abs() < 1e-6, "{near}");
    let opposite: f64 = end.orbit.states()[0].q[0] * first.orbit.states()[0].q[0];
    assert!(opposite < 0.0, "{opposite}");
    let least = back.points().iter().map(|point| point.peak_to_peak()).fold(f64::INFINITY, f64::min);
    assert!(least < 0.01 * first.peak_to_peak(), "{least}");
    assert!((hill.border(border) - border).abs() < 1e-8);
    // A branch with another end has no way back.
    let short = Continuation::new(0.5, 0.55).run(&family, &[settled(&train)?])?;
    let refused = continuation.begin(&family, Beyond(&short)).err().ok_or("an error")?;
    assert!(matches!(refused, BranchError::NoBorder { .. }), "{refused}");
    Ok(())
}

#[test]
fn a_branch_by_balance_ends_alike() -> Result<()> {
    let (train, hill) = pair()?;
    let family = Family::over(&train, ["speed"])?;
    let balance = Balance::new(Harmonics::up_to(24));
    let at = Continuation::new(0.8, 1.4).bounds(0.55, 1.4);
    let guess = balance.linearised(&train.with("speed", 0.8)?, Piece::Upper)?;
    let branch = at.balance(balance).run(&family, &guess)?;
    let BranchEnd::Unbounded { border: Some(border), .. } = *branch.end() else {
        panic!("{branch}");
    };
    assert!((border - hill.border(border)).abs() < 1e-8, "{border}");
    Ok(())
}

#[test]
fn a_line_of_folds_ends_alike() -> Result<()> {
    let hill =
        Hill { zeta: 0.029_865_120_849_967_487, waves: [0.254_298_298_956_628_1, 0.151_528_332_222_672_3] };
    let error = [-0.293_776_607_099_700_5, 0.032_412_285_849_265_64];
    let pair = SpurPair::of_numbers(hill.zeta, 0.029_876_038_345_986_632, &hill.waves, &error)?;
    let train = pair.parts()?.build("driver", 0.5)?;
    let family = Family::over(&train, ["speed"])?;
    let branch = Continuation::new(0.5, 2.4).run(&family, &[settled(&train)?])?;
    let plane = Family::over(&train, ["speed", "mesh damping"])?;
    let mut ends = 0;
    for fold in branch.of_kind(PointKind::Fold) {
        assert_eq!(fold.kind(), Some(PointKind::Fold));
        let line = Continuation::new(2.0 * hill.zeta, 0.4 * hill.zeta).max_points(100).run(&plane, fold)?;
        if let BranchEnd::Unbounded { border: Some(border), .. } = *line.end() {
            let [_, damping] = line.points().last().ok_or("a point")?.parameters;
            let damped = Hill { zeta: 0.5 * damping, ..hill };
            assert!((border - damped.border(border)).abs() < 1e-8, "{border}");
            ends += 1;
        }
    }
    assert!(ends > 0, "{branch}");
    Ok(())
}

/// The damping falls to that of the tip of a tongue, from outside: no border lies at the damping of the last point.
#[test]
fn a_line_of_folds_ends_at_the_tip_of_a_tongue() -> Result<()> {
    let hill =
        Hill { zeta: 0.065_833_862_998_399_98, waves: [0.026_029_083_933_464_252, 0.248_916_044_145_362_5] };
    let error = [0.188_235_640_176_846_63, -0.056_036_244_129_522_93];
    let pair = SpurPair::of_numbers(hill.zeta, 0.518_452_058_636_989_6, &hill.waves, &error)?;
    let train = pair.parts()?.build("driver", 0.6)?;
    let family = Family::over(&train, ["speed"])?;
    let branch = Continuation::new(0.6, 1.4).run(&family, &[settled(&train)?])?;
    let plane = Family::over(&train, ["speed", "mesh damping"])?;
    let mut ends = 0;
    for fold in branch.of_kind(PointKind::Fold) {
        let line = Continuation::new(2.0 * hill.zeta, 0.4 * hill.zeta).max_points(300).run(&plane, fold)?;
        if let BranchEnd::Unbounded { border, motion } = *line.end() {
            let border = border.ok_or_else(|| format!("no border at {motion}"))?;
            let [speed, damping] = line.points().last().ok_or("a point")?.parameters;
            let damped = Hill { zeta: 0.5 * damping, ..hill };
            // The parabola of the determinant around the tip: it comes to 0 without a change of its sign.
            let h = 3e-5;
            let [a, b, c] = [border - h, border, border + h].map(|w| damped.determinant(w));
            let bend = a - 2.0 * b + c;
            assert!(a > 0.0 && b > 0.0 && c > 0.0 && bend > 0.0, "{a} {b} {c}");
            let tip = border + 0.5 * h * (a - c) / bend;
            assert!((border - tip).abs() < 1e-7 && (border - speed).abs() < 1e-4, "{border} {tip} {speed}");
            ends += 1;
        }
    }
    assert!(ends > 0, "{branch}");
    Ok(())
}

/// The last point of the line lies 5e-5 beside two borders that are 2e-5 apart, close to the tip of a tongue.
#[test]
fn a_line_of_folds_ends_at_the_two_borders_beside_a_tip() -> Result<()> {
    let hill = Hill {
        zeta: 0.042_979_313_671_473_784,
        waves: [-0.079_246_127_784_807_23, 0.147_415_645_002_456_96],
    };
    let error = [-0.148_355_296_593_821_85, -0.090_526_831_762_659_08];
    let pair = SpurPair::of_numbers(hill.zeta, 0.567_008_318_158_591_7, &hill.waves, &error)?;
    let train = pair.parts()?.build("driver", 0.6)?;
    let family = Family::over(&train, ["speed"])?;
    let branch = Continuation::new(0.6, 1.4).run(&family, &[settled(&train)?])?;
    let plane = Family::over(&train, ["speed", "mesh damping"])?;
    let mut ends = 0;
    for fold in branch.of_kind(PointKind::Fold) {
        let line = Continuation::new(2.0 * hill.zeta, 0.4 * hill.zeta).max_points(300).run(&plane, fold);
        let Ok(line) = line else { continue };
        if let BranchEnd::Unbounded { border, motion } = *line.end() {
            let border = border.ok_or_else(|| format!("no border at {motion}"))?;
            let [speed, damping] = line.points().last().ok_or("a point")?.parameters;
            let damped = Hill { zeta: 0.5 * damping, ..hill };
            // Secants may find the other border.
            assert!(damped.determinant(border - 1e-7) * damped.determinant(border + 1e-7) < 0.0, "{border}");
            assert!((border - speed).abs() < 1e-4, "{border} {speed}");
            ends += 1;
        }
    }
    assert!(ends > 0, "{branch}");
    Ok(())
}
