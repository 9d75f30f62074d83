//! Parameters, rows and orbits that are stored by `serde` and read again: the same values to the bit, from
//! text and from bytes;
//! stored forms whose parts do not fit together are errors.

use crate::api::*;
use crate::common::stored;
use gear_dynamics::branches::{BranchPoint, Continuation, Family};
use serde_json::{Value, json};

/// Rattle map of the pair: three speeds by two loads, with checks, strobed states and exponents.
fn sweep() -> Sweep {
    let axes = vec![
        Axis::linear("speed", 120.0, 180.0, 3).unwrap(),
        Axis::of_values("load", &[20.0, 40.0]).unwrap(),
    ];
    let sweep = Sweep::new(Points::grid(axes).unwrap()).settle(2).measure(1).channels(&["q0", "deflection"]);
    sweep.rattle().strobe(1).check_every(2)
}

fn pair(p: &Point<'_>) -> Result<NfgPair, String> {
    if p.index() == 4 {
        return Err("left out".into());
    }
    let params = NfgParams { speed: p["speed"], load_torque: p["load"], ..NfgParams::table1() };
    NfgPair::new(&params).map_err(|error| error.to_string())
}

fn rows() -> Rows {
    let engine = LaneRk4::new(63 * 16).lanes::<4>();
    sweep().of(&engine, pair).start(|_, pair| pair.on_drive_flank()).run().unwrap()
}

/// The files of both versions of the stored form, each written by
/// `cargo test --test suite stored_results::writes_the_row_file -- --ignored`.
const FILES: [&str; 2] = [
    concat!(env!("CARGO_MANIFEST_DIR"), "/../data/rows.json"),
    concat!(env!("CARGO_MANIFEST_DIR"), "/../data/rows_from_0.json"),
];

#[test]
#[ignore = "writes tests/data/rows_from_0.json: only for a new version of the stored form"]
fn writes_the_row_file() {
    std::fs::write(FILES[1], serde_json::to_string(&rows()).unwrap() + "\n").unwrap();
}

#[test]
fn row_files_of_the_repository_are_read() {
    let fresh = rows();
    FILES.iter().for_each(|file| is_read(file, &fresh));
}

fn is_read(file: &str, fresh: &Rows) {
    let read: Rows = serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    assert_eq!(read.fingerprint(), fresh.fingerprint());
    assert_eq!(read.points(), fresh.points());
    let row = read.get(3).unwrap();
    assert_eq!(row.contacts()[0].rattle_state(), fresh.get(3).unwrap().contacts()[0].rattle_state());
    assert_eq!(row.channel("q0").unwrap().mean, fresh.get(3).unwrap().channel("q0").unwrap().mean);
    assert_eq!(read.get(4).unwrap_err().to_string(), "no model: left out");
    // Rows that were read can be resumed by the same sweep.
    let (sweep, engine) = (sweep(), LaneRk4::new(63 * 16).lanes::<4>());
    let runner = sweep.of(&engine, pair).start(|_, pair| pair.on_drive_flank());
    assert_eq!(runner.resume(read).unwrap().fingerprint(), fresh.fingerprint());
}

#[test]
fn rows_keep_their_bits() {
    let rows = rows();
    let read = stored(&rows);
    assert!(!rows.errors().is_empty() && read == rows);
    assert_eq!(read.fingerprint(), rows.fingerprint());
    for (a, b) in read.iter().zip(rows.iter()) {
        assert_eq!(a.channel("deflection").unwrap(), b.channel("deflection").unwrap());
        assert_eq!((a.step_error("q0"), a.is_sensitive()), (b.step_error("q0"), b.is_sensitive()));
        assert_eq!(a.strobes().collect::<Vec<_>>(), b.strobes().collect::<Vec<_>>());
    }
    let list = Points::of_rows(&["a", "b"], &[vec![1.0, -2.5], vec![0.1, 1e-300]]).unwrap();
    assert_eq!(stored(&list), list);
    let sweep = Sweep::new(list)
        .lyapunov(Lyapunov::new().measure(7))
        .repeat_tolerance(1e-4)
        .warm_start(WarmStart::Up);
    assert_eq!(stored(&sweep), sweep);
}

#[test]
fn parameters_and_orbits_keep_their_bits() {
    let params = NfgParams { speed: 100.0, error_harmonics: vec![[0.1, -1e-5]], ..NfgParams::table1() };
    assert_eq!(stored(&params), params);
    assert_eq!(stored(&NfgReading::published()), NfgReading::published());
    let set = RingSet { error: 5e-6, ..RingSet::set_a(4, 12_000.0) };
    assert_eq!(stored(&set), set);
    let pair = NfgPair::new(&params).unwrap();
    let start = pair.on_drive_flank().unwrap();
    assert_eq!(stored(&start), start);

    let balance = Balance::new(Harmonics::up_to(70));
    let orbit = balance.solve(&pair, &balance.linearised(&pair, Piece::Lower).unwrap()).unwrap();
    let read = stored(&orbit);
    assert_eq!(read.coefficients(0), orbit.coefficients(0));
    assert_eq!((read.notes(), read.residual()), (orbit.notes(), orbit.residual()));
    let shot = Shooting::new().solve_from(&pair, &orbit).unwrap();
    let read = stored(&shot);
    assert_eq!(read.states(), shot.states());
    assert_eq!((read.monodromy(), read.multipliers()), (shot.monodromy(), shot.multipliers()));
    // The orbit is whole: it can be integrated.
    let t = shot.states()[0].t + 0.3 * shot.period();
    assert_eq!(read.at(&pair, t).unwrap(), shot.at(&pair, t).unwrap());
}

/// Chunks are stored one by one and merged after reading. No point of the second chunk has a row.
#[test]
fn stored_chunks_are_merged() {
    let third = |p: &Point<'_>| if (2..4).contains(&p.index()) { Err("left out".into()) } else { pair(p) };
    let (sweep, engine) = (sweep().check_every(0), LaneRk4::new(63 * 16).lanes::<4>());
    let runner = sweep.of(&engine, third).start(|_, pair| pair.on_drive_flank());
    let parts = |read: fn(Rows) -> Rows| (0..3).map(|i| read(runner.chunk(i, 3).unwrap())).collect();
    let whole = runner.run().unwrap();
    let merged = Rows::merge(parts(|rows| stored(&rows))).unwrap();
    assert_eq!((&merged, merged.fingerprint()), (&whole, whole.fingerprint()));
    assert_eq!(merged.get(5).unwrap().channel("q0").unwrap(), whole.get(5).unwrap().channel("q0").unwrap());
    assert_eq!(stored(&merged), Rows::merge(parts(|rows| rows)).unwrap());
}

/// Numbers that are not finite have names in text.
#[test]
fn infinity_is_stored() {
    let multipliers = Multipliers::new(vec![num_complex::Complex64::new(0.5, 0.0)], f64::INFINITY);
    assert_eq!(stored(&multipliers), multipliers);
    assert!(serde_json::to_string(&multipliers).unwrap().contains("\"inf\""));
}

/// Each change makes the stored form contradict itself; the error names the contradiction.
#[test]
fn stored_forms_that_contradict_themselves_are_refused() {
    let whole = serde_json::to_value(rows()).unwrap();
    type Change = fn(&mut Value);
    let changes: [(&str, Change); 13] = [
        ("version 3", |v| v["version"] = json!(3)),
        ("6 rows from point 3", |v| v["first"] = json!(3)),
        ("has 1 values", |v| v["rows"][0] = json!([1.0])),
        ("layout of the rows", |v| v["layout"]["channels"] = json!(7)),
        ("point 0 does not fit", |v| v["errors"][0][0] = json!(0)),
        ("point 9 does not fit", |v| v["checks"][0][0] = json!(9)),
        ("measure", |v| v["sweep"]["measure"] = json!(0)),
        ("unknown field", |v| v["sweep"]["mesure"] = json!(0)),
        ("empty", |v| v["sweep"]["points"]["grid"] = json!([])),
        ("whole lines of 2", |v| {
            v["sweep"]["warm_start"] = json!("Up");
            v["rows"].as_array_mut().unwrap().pop();
        }),
        ("layout of the rows", |v| v["layout"]["strobes"] = json!(u64::MAX)),
        ("layout of the rows", |v| v["layout"]["exponents"] = json!(u64::MAX)),
        ("at most 268435456", |v| v["layout"]["dof"] = json!(u64::MAX)),
    ];
    for (text, change) in changes {
        let mut changed = whole.clone();
        change(&mut changed);
        let error = serde_json::from_value::<Rows>(changed).unwrap_err().to_string();
        assert!(error.contains(text), "{text}: {error}");
    }
    let misspelt = json!({ "t": 0.0, "q": [1.0], "v": [0.0], "w": 1 });
    assert!(serde_json::from_value::<State>(misspelt).unwrap_err().to_string().contains("unknown field"));
    let orders = json!({ "orders": [1, 1], "periods": 1 });
    assert!(serde_json::from_value::<Harmonics>(orders).unwrap_err().to_string().contains("order"));
}

/// Figures of a row that contradict one another are refused: the error names the point, the figure, its value
/// and what is allowed. Places of the row: head 0 to 4, channels from 5 and 10, the contact from 15, then the
/// strobed period.
#[test]
fn figures_of_a_row_that_contradict_themselves_are_refused() {
    let whole = serde_json::to_value(rows()).unwrap();
    let cases = [
        (0, json!(0.5), "period multiple is 0.5: it must be a whole number"),
        (0, json!(-1.0), "period multiple is -1.0: it must not be negative"),
        (1, json!("NaN"), "change is NaN"),
        (2, json!("inf"), "number of settling periods is inf"),
        (3, json!(-0.1), "margin to grazing is -0.1: it must not be negative"),
        (4, json!("NaN"), "scatter is NaN"),
        (5, json!(1e9), "mean of channel 0 is 1000000000.0: it must be within"),
        (5, json!("NaN"), "figures of channel 0[0] is NaN"),
        (6, json!(0.0), "rms of channel 0 is 0.0: it must be"),
        (7, json!(1e9), "min of channel 0 is 1000000000.0: it must be at most"),
        (9, json!(-1.0), "deviation of channel 0 is -1.0: it must not be negative"),
        (10, json!(-1e9), "mean of channel 1 is -1000000000.0: it must be within"),
        (15, json!(-0.25), "share of time on the lower flank of contact 0 is -0.25: it must lie in [0, 1]"),
        (16, json!(1.5), "share of time in the gap of contact 0 is 1.5: it must lie in [0, 1]"),
        (17, json!("NaN"), "share of time on the upper flank of contact 0 is NaN"),
        (18, json!(-1.0), "number of impacts on the lower flank of contact 0 is -1.0"),
        (
            19,
            json!(1.5),
            "number of impacts on the upper flank of contact 0 is 1.5: it must be a whole number",
        ),
        (20, json!(1e9), "minimum of channel 0 in strobed period 0 is 1000000000.0: it must be at most"),
        (24, json!("NaN"), "strobed state[0] is NaN"),
    ];
    for (place, value, text) in cases {
        let mut changed = whole.clone();
        changed["rows"][1][place] = value.clone();
        let error = serde_json::from_value::<Rows>(changed).unwrap_err().to_string();
        assert!(error.contains("row of point 1: ") && error.contains(text), "{text}: {error}");
        let mut changed = whole.clone();
        let (index, of) = (changed["checks"][0][0].clone(), &mut changed["checks"][0][1]["Ok"]);
        of[place] = value;
        let error = serde_json::from_value::<Rows>(changed).unwrap_err().to_string();
        assert!(error.contains(&format!("check of point {index}: ")) && error.contains(text), "{error}");
    }
    // Each time is a share, and together they are not 1.
    let mut changed = whole;
    [0.5, 0.25, 0.5].iter().enumerate().for_each(|(i, time)| changed["rows"][1][15 + i] = json!(time));
    let error = serde_json::from_value::<Rows>(changed).unwrap_err().to_string();
    assert!(error.contains("sum of the shares of time of contact 0 is 1.25: it must be 1.0"), "{error}");
}

/// NaN stands for an exponent that was not computed; its error says why. Without an error it is refused.
#[test]
fn exponents_and_multipliers_of_rows_are_checked() {
    let sweep = Sweep::new(Axis::of_values("speed", &[100.0]).unwrap()).settle(40).measure(2);
    let sweep = sweep.lyapunov(Lyapunov::new().measure(2)).multipliers(Shooting::new());
    let pair = |p: &Point<'_>| NfgPair::new(&NfgParams { speed: p["speed"], ..NfgParams::table1() });
    let engine = LaneTaylor::new(Taylor::new());
    let rows = sweep.of(&engine, pair).start(|_, pair| pair.on_drive_flank()).run().unwrap();
    assert_eq!(stored(&rows), rows);
    assert!(rows.exponent_errors().is_empty());
    let whole = serde_json::to_value(&rows).unwrap();
    // The head, exponent, standard error, parts of two multipliers, their error.
    for (place, value, text) in [
        (5, json!("NaN"), "row of point 0: Lyapunov exponent is NaN"),
        (6, json!(-1.0), "standard error of the Lyapunov exponent is -1.0: it must not be negative"),
        (7, json!("inf"), "real part of multiplier 0 is inf"),
        (11, json!(-1.0), "error of the multipliers is -1.0: it must not be negative"),
    ] {
        let mut changed = whole.clone();
        changed["rows"][0][place] = value;
        let error = serde_json::from_value::<Rows>(changed).unwrap_err().to_string();
        assert!(error.contains(text), "{text}: {error}");
    }
    let mut failed = whole;
    failed["rows"][0][5] = json!("NaN");
    failed["exponent_errors"] = json!([[0, "the integration failed"]]);
    assert_eq!(serde_json::from_value::<Rows>(failed).unwrap().get(0).unwrap().lyapunov(), None);
}

/// Bytes that are cut off are an error. Bytes with a changed bit are an error or rows that can be read from
/// end to end.
#[test]
fn damaged_bytes_never_panic() {
    let bytes = postcard::to_stdvec(&rows()).unwrap();
    for place in 0..bytes.len() {
        assert!(postcard::from_bytes::<Rows>(&bytes[..place]).is_err(), "{place}");
        for bit in [0x01, 0x80, 0xff] {
            let mut bad = bytes.clone();
            bad[place] ^= bit;
            let Ok(rows) = postcard::from_bytes::<Rows>(&bad) else { continue };
            for row in rows.iter() {
                let _ = (row.step_error("q0"), row.is_sensitive(), row.strobes().count());
                assert!(row.channel("q0").is_ok() || !rows.points().is_empty());
            }
            let _ = (Attractors::find(&rows, 1e-3), postcard::to_stdvec(&rows).unwrap());
            let _ = Rows::merge(vec![rows.clone(), rows]);
        }
    }
}

/// The method of a flow is stored as before; an integrator of one's own is an error, not the default.
#[test]
fn settings_with_an_integrator_of_ones_own_are_not_stored() {
    for shooting in [Shooting::new(), Shooting::new().flow_method(FlowMethod::Dop853)] {
        let stored = serde_json::to_value(&shooting).unwrap();
        let again = serde_json::from_value::<Shooting>(stored.clone()).unwrap();
        assert_eq!(serde_json::to_value(again).unwrap(), stored);
    }
    assert_eq!(serde_json::to_value(Shooting::new()).unwrap()["method"], Value::Null);
    let own = Shooting::new().integrator(Rk4::new(0.1));
    let error = serde_json::to_value(&own).unwrap_err().to_string();
    assert_eq!(error, "an integrator of one's own cannot be stored");
    assert!(own == own.clone() && own != Shooting::new().integrator(Rk4::new(0.1)));
}

/// Forms of single figures that no computation yields, and an orbit with multipliers that are not those of its matrix.
#[test]
fn stored_figures_that_do_not_fit_together_are_refused() {
    fn refused<T: serde::de::DeserializeOwned>(value: Value, words: &str) {
        let text = value.to_string();
        let error = serde_json::from_value::<T>(value).err().map(|error| error.to_string());
        assert!(error.as_ref().is_some_and(|error| error.contains(words)), "{text}: {error:?}");
    }
    refused::<State>(json!({"t": 0.0, "q": [1.0, 2.0], "v": []}), "velocities of the state");
    refused::<gear_dynamics::analysis::ContactStatistics>(
        json!({"time": [-3.0, 1.0, 0.0], "impacts": [5, 0]}),
        "time of a contact",
    );
    refused::<gear_dynamics::certify::Disc>(
        json!({"re": 0.5, "im": 0.0, "radius": -1.0}),
        "radius of a disc",
    );
    let summary = json!({"mean": 0.0, "rms": 1.0, "min": 2.0, "max": -2.0, "deviation": 1.0});
    refused::<gear_dynamics::analysis::Summary>(
        summary,
        "min of the channel is 2.0: it must be at most -2.0, the max",
    );
    let index = json!({"name": "x", "first": 0.5, "first_error": 0.1, "total": -0.5, "total_error": "inf"});
    refused::<gear_dynamics::sweep::SobolIndex>(index.clone(), "total index");
    let mut index = index;
    index["total"] = json!(0.6);
    let read: gear_dynamics::sweep::SobolIndex = serde_json::from_value(index.clone()).unwrap();
    assert_eq!(serde_json::to_value(&read).unwrap(), index);
    for (multiple, states) in [(json!(2), json!([[0.0, 1.0]])), (json!(null), json!([[0.0, 1.0]]))] {
        let attractor = json!({"period_multiple": multiple, "states": states, "rows": 3});
        refused::<gear_dynamics::sweep::Attractor>(attractor, "strobed states of the attractor");
    }
    let contact = json!({"mean_force": [1.0, 1.1], "loss_fraction": [1.5, 1.6]});
    refused::<gear_dynamics::certify::CertifiedFigures>(
        json!({"peak_to_peak": [[1.0, 1.1], [2.0, 2.1]], "contacts": [contact]}),
        "share of the time in the gap is 1.5: it must lie in [0, 1]",
    );
    refused::<gear_dynamics::certify::CertifiedFigures>(
        json!({"peak_to_peak": [[-2.0, -1.0], [2.0, 2.1]], "contacts": []}),
        "peak-to-peak value",
    );

    let pair = gear_dynamics::trains::SpurPair::of_numbers(0.05, 0.1, &[], &[0.05]).unwrap();
    let pair = pair.parts().unwrap().build("driver", 0.7).unwrap();
    let orbit = Shooting::new().solve(&pair, &State::new(0.0, &[1.1], &[0.0])).unwrap();
    let stored = serde_json::to_value(&orbit).unwrap();
    let mean = orbit.multipliers().values()[0].re;
    for forged in [json!([[mean + 5.0, 0.0], [mean - 5.0, 0.0]]), json!([[mean, 7.0], [mean, -7.0]])] {
        let mut value = stored.clone();
        value["multipliers"]["values"] = forged;
        refused::<ShootingOrbit>(value, "an eigenvalue of the monodromy matrix");
    }
    // An entry beside the diagonal changes the eigenvalues and not their sum.
    for i in [1, 2] {
        for factor in [1e3, 1e6, 1e10, 1e20, 1e100, 1e200] {
            let mut value = stored.clone();
            let entry = value["monodromy"][i].as_f64().unwrap();
            value["monodromy"][i] = json!(entry * factor);
            refused::<ShootingOrbit>(value, "an eigenvalue of the monodromy matrix");
        }
    }
    // A double multiplier has a double conjugate.
    let double = [[0.5, 0.1], [0.5, 0.1], [0.5, -0.1], [0.5, -0.1]];
    let multipliers = |values: [[f64; 2]; 4]| json!({"values": values, "error": 1e-10});
    assert!(serde_json::from_value::<Multipliers>(multipliers(double)).is_ok());
    for forged in [[0.5, 0.0], [0.5, 0.1], [0.4, -0.1]] {
        let [a, b, c, _] = double;
        refused::<Multipliers>(multipliers([a, b, c, forged]), "belong to a pair of conjugates");
    }

    let balance = Balance::new(Harmonics::up_to(5));
    let series = balance.solve(&pair, &balance.linearised(&pair, Piece::Upper).unwrap()).unwrap();
    let mut value = serde_json::to_value(&series).unwrap();
    value["residual"] = json!(-1e-9);
    refused::<FourierOrbit>(value, "residual is -1e-9: it must not be negative");

    let family = Family::over(&pair, ["speed"]).unwrap();
    let branch = Continuation::new(0.7, 0.71).run(&family, &orbit).unwrap();
    let mut value = serde_json::to_value(&branch.points()[0]).unwrap();
    assert!(serde_json::from_value::<BranchPoint>(value.clone()).is_ok());
    value["crossings"] = json!([[1_000_000, 0]]);
    refused::<BranchPoint>(value, "crossings of a point is 1000000.0: it must be at most");
}
