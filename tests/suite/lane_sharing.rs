//! Models that share lanes give the rows of single runs, for a change of any parameter.

use crate::api::*;

type Change = fn(&mut NfgParams, f64);

/// Every parameter of the pair, changed by a relative amount (the error by a multiple of 1e-5 m).
const CHANGES: [(&str, Change); 12] = [
    ("module", |p, by| p.module *= 1.0 + by),
    ("eccentric ratio", |p, by| p.eccentric_ratio *= 1.0 + by),
    ("pressure angle", |p, by| p.pressure_angle *= 1.0 + by),
    ("load torque", |p, by| p.load_torque *= 1.0 + by),
    ("inertia", |p, by| p.inertia *= 1.0 + by),
    ("stiffness", |p, by| p.stiffness *= 1.0 + by),
    ("stiffness harmonics", |p, by| p.stiffness_harmonics[0][0] *= 1.0 + by),
    ("damping ratio", |p, by| p.damping_ratio *= 1.0 + by),
    ("error", |p, by| p.error += 1e-5 * by),
    ("error harmonics", |p, by| p.error_harmonics[0][1] *= 1.0 + by),
    ("half backlash", |p, by| p.half_backlash *= 1.0 + by),
    ("speed", |p, by| p.speed *= 1.0 + by),
];

/// Runs four members of a family in lanes and each of them alone, and compares the rows to the bit.
fn each_alone<G: Shape + Send + Sync>(what: &str, family: impl Fn(f64) -> Machine<G> + Sync) {
    let sweep = |shares: &[f64]| {
        let points = Points::from(Axis::of_values("share", shares).unwrap());
        let sweep =
            Sweep::new(points).settle(1).measure(1).channels(&["q0", "deflection", "mesh force"]).rattle();
        let start = |_: &Point<'_>, model: &Machine<G>| -> Result<State, ParameterError> {
            let n = model.dof();
            Ok(State::new(0.0, &vec![-1.5e-3; n], &vec![0.0; n]))
        };
        let rows = sweep
            .of(&LaneRk4::new(63 * 16).lanes::<4>(), |p: &Point<'_>| {
                Ok::<_, ParameterError>(family(p["share"]))
            })
            .start(start)
            .run()
            .unwrap();
        assert!(rows.iter().count() == shares.len(), "{what}: {:?}", rows.errors().first_key_value());
        rows
    };
    let shares = [0.0, 0.01, 0.02, 0.03];
    let together = sweep(&shares);
    for (i, share) in shares.iter().enumerate() {
        let (alone, row) = (sweep(&[*share]), together.get(i).unwrap());
        let alone = alone.get(0).unwrap();
        for channel in ["q0", "deflection", "mesh force"] {
            assert_eq!(alone.channel(channel), row.channel(channel), "{what}, {channel}");
        }
        assert_eq!(alone.contacts()[0], row.contacts()[0], "{what}");
    }
    let force = |i: usize| together.get(i).unwrap().channel("mesh force").unwrap();
    assert_ne!(force(0), force(3), "{what} has no effect");
}

#[test]
fn pairs_of_one_degree_of_freedom() {
    for reading in [NfgReading::exact(), NfgReading::published()] {
        // In the published reading a constant error exerts no force, and the radius is that of the pitch
        // circle.
        let matters =
            |what: &str| reading == NfgReading::exact() || !["error", "pressure angle"].contains(&what);
        for (what, change) in CHANGES.iter().filter(|(what, _)| matters(what)) {
            each_alone(what, |by| {
                let mut params = NfgParams::table1();
                change(&mut params, by);
                NfgPair::of_reading(&params, reading).unwrap()
            });
        }
    }
}

#[test]
fn pairs_of_two_degrees_of_freedom() {
    // All parameters but the mean error, which only shifts the deflection by a constant.
    for (what, change) in CHANGES.iter().filter(|(what, _)| *what != "error") {
        each_alone(what, |by| {
            let mut params = NfgParams::table1();
            change(&mut params, by);
            NfgPair2::new(&params, 10.0).unwrap()
        });
    }
    each_alone("pinion inertia", |by| NfgPair2::new(&NfgParams::table1(), 10.0 * (1.0 + by)).unwrap());
}

/// The drawing of a train is no part of its shape: trains that differ in a stated centre alone share lanes.
#[test]
fn trains_that_are_drawn_elsewhere_share_lanes() {
    use gear_dynamics::trains::{Body, Parts, ShaftPart};
    let train = |x: f64| {
        let mut parts = Parts::new();
        parts.body("motor", Body::new(0.1)).body("brake", Body::new(0.2).centre([x, 0.0]));
        parts.shaft("shaft", "motor", "brake", ShaftPart::new(1e4).damping(1.0));
        parts.build("motor", 100.0).unwrap()
    };
    let (here, there) = (train(0.0), train(1.0));
    assert_ne!(here.shape().drawing(), there.shape().drawing());
    assert!(here.shares_lanes_with(&there));
}
