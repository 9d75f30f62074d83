//! Branches and boundaries of an oscillator with a rigid stop, in closed form.

use crate::api::*;
use crate::data::read;
use crate::impacts::Oscillator;
use gear_dynamics::branches::{Branch, BranchEnd, ByConstant, ByConstants, Continuation};
use gear_dynamics::contact::PieceChoice;
use gear_dynamics::excitation::{Angle, Fourier};
use gear_dynamics::model::{Drives, Size};

/// x'' + c x' + x = A cos φ with a rigid stop at x = d above.
#[derive(PartialEq)]
struct Stop {
    cos: Wave,
    restitution: Restitution,
}

impl Shape for Stop {
    #[inline(always)]
    fn size(&self) -> Size {
        Size { dof: 1, waves: 1, contacts: 1, constants: 4 }
    }
    fn constants(&self) -> Vec<Channel> {
        ["speed", "amplitude", "damping", "stop"].map(|name| Channel::new(name, "1")).into()
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        u[0] = self.cos.value(angle, side);
    }
    fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        _: &L,
        _: usize,
        u: Drives<'_, S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let [_, _, upper] = u.constants();
        let lower = S::from(f64::NEG_INFINITY);
        Contact { deflection: q[0], rate: v[0], lower, upper, ..Contact::default() }
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let ([cos], [amplitude, damping, _]) = (u.waves(), u.constants());
        a[0] = amplitude * cos - damping * v[0] - q[0];
    }
    fn impact(&self, _: usize, on: Piece, _: Drives<'_, f64>, _: &[f64], v: &mut [f64]) -> bool {
        if on == Piece::Upper {
            v[0] = self.restitution.rebound(v[0], 0.0);
        }
        on == Piece::Upper
    }
}

const DAMPING: f64 = 0.1;

fn stop(speed: f64, amplitude: f64) -> Machine<Stop> {
    let (force, restitution) = (Fourier::new(0.0, &[[1.0, 0.0]]).unwrap(), Restitution::new(0.8).unwrap());
    let shape = Stop { cos: Wave::new(force), restitution };
    let constants = [("speed", speed), ("amplitude", amplitude), ("damping", DAMPING), ("stop", 1.0)];
    Machine::with_constants(shape, &constants).unwrap()
}

/// The amplitude at which orbits without impacts graze the stop.
fn grazing(speed: f64) -> f64 {
    (1.0 - speed * speed).hypot(DAMPING * speed)
}

/// The branch of orbits with one impact, from the amplitude 1 downwards. `v`: velocity after the impact there.
fn impacting(speed: f64, v: f64) -> Branch {
    let model = stop(speed, 1.0);
    let family = ByConstant::new(&model, "amplitude").unwrap();
    let start = Oscillator::new(DAMPING, speed, 1.0).guess(1, v);
    Continuation::new(1.0, 0.1).bounds(0.05, 1.1).run(&family, &[start]).unwrap()
}

/// Both branches end at the grazing, from the side with impacts as well: on a smooth side of the stop, and where the
/// orbits with impacts turn back. On the way the impact passes the phase of the first node.
#[test]
fn branches_with_impacts_end_at_the_grazing() {
    let data = read("impacts.json");
    for case in data["impact_oscillator"]["values"].as_array().unwrap() {
        let number = |key: &str| case[key].as_f64();
        let branch = impacting(number("w").unwrap(), number("v_at_A_1").unwrap());
        println!("{branch}");
        assert_eq!(branch.end(), &BranchEnd::Stop { contact: 0 });
        assert!(branch.notes().is_empty() && branch.points().len() < 100);
        for (kind, key) in
            [("period-doubling", "A_period_doubling"), ("fold", "A_fold"), ("grazing", "A_graze")]
        {
            let found = branch.of_kind(kind);
            assert_eq!(found.len(), usize::from(number(key).is_some()), "{kind}");
            if let Some(exact) = number(key) {
                println!("{kind} {:.1e}", found[0].parameter - exact);
                assert!((found[0].parameter - exact).abs() < 1e-11);
            }
        }
    }
}

/// The grazing over speed and amplitude, through the resonance at the speed 1.
#[test]
fn the_grazing_of_a_stop_passes_its_resonances() {
    let model = stop(0.6, 0.05);
    let family = ByConstant::new(&model, "amplitude").unwrap();
    let branch = Continuation::new(0.05, 1.0).run(&family, &[State::at_rest(1)]).unwrap();
    let plane = ByConstants::new(&model, ["amplitude", "speed"]).unwrap();
    let range = Continuation::new(0.6, 2.2).bounds_across(0.0, 5.0);
    let line = range.boundary(&plane, branch.of_kind("grazing")[0]).unwrap();
    println!("{line}");
    assert_eq!(line.end(), &BranchEnd::Bound);
    for point in line.points() {
        let [amplitude, speed] = point.parameters;
        assert!((amplitude - grazing(speed)).abs() < 1e-11, "{speed} {amplitude}");
    }
    assert!(line.points().len() > 50);
}

/// The folds of orbits with one impact lie between two resonant grazings, at which the speed of the impact vanishes.
/// Closed form: the least amplitude A(v) of the orbits with the velocity v after the impact.
#[test]
fn folds_with_impacts_lie_between_resonant_grazings() {
    let branch = impacting(1.2, -1.618_119_618_100_248_4);
    let model = stop(1.2, 1.0);
    let plane = ByConstants::new(&model, ["amplitude", "speed"]).unwrap();
    for end in [0.9, 2.6] {
        let range = Continuation::new(1.2, end).max_step(0.1).bounds_across(0.0, 5.0);
        let line = range.boundary(&plane, branch.of_kind("fold")[0]).unwrap();
        println!("{line}");
        assert_eq!(line.end(), &BranchEnd::Stop { contact: 0 });
        for point in line.points() {
            let [amplitude, speed] = point.parameters;
            let closed = Oscillator::new(DAMPING, speed, amplitude);
            let mut v = [-6.0, -1e-6];
            for _ in 0..60 {
                let inner = [0.381_966_011_25, 0.618_033_988_75].map(|share| v[0] + share * (v[1] - v[0]));
                let [a, b] = inner.map(|v| closed.closed(1, v).1);
                v = if a < b { [v[0], inner[1]] } else { [inner[0], v[1]] };
            }
            let exact = closed.closed(1, 0.5 * (v[0] + v[1])).1;
            assert!((amplitude - exact).abs() < 1e-11, "{speed} {amplitude} {exact}");
        }
        let [amplitude, speed] = line.points().last().unwrap().parameters;
        assert!((amplitude - grazing(speed)).abs() < 1e-5);
    }
}
