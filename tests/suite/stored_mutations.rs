//! Stored forms that were changed at random: they are refused with an error that names what is wrong, or they
//! are used without a panic and within a budget.

use crate::api::*;
use gear_dynamics::branches::{BoundaryLine, Branch, Continuation, Family, PointKind, Sensitivity};
use gear_dynamics::certify::Certificate;
use gear_dynamics::trains::{SpurPair, Train};
use serde::de::DeserializeOwned;
use serde_json::{Map, Value, json};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

fn train(speed: f64) -> Train {
    let pair = SpurPair::of_numbers(0.05, 0.1, &[], &[0.05]).unwrap().parts().unwrap();
    pair.build("driver", speed).unwrap()
}

fn orbit() -> ShootingOrbit {
    Shooting::new().solve(&train(0.7), &State::new(0.0, &[1.1], &[0.0])).unwrap()
}

/// A branch to a grazing, and its boundary over the damping.
fn branch() -> (Branch, BoundaryLine) {
    let pair = train(0.7);
    let family = Family::over(&pair, ["speed"]).unwrap();
    let settings = Continuation::new(0.7, 0.85).channels(&["deflection"]);
    let branch = settings.run(&family, &State::new(0.0, &[1.1], &[0.0])).unwrap();
    let plane = Family::over(&pair, ["speed", "mesh damping"]).unwrap();
    let line = Continuation::new(0.1, 0.12).run(&plane, branch.of_kind(PointKind::Grazing)[0]).unwrap();
    (branch, line)
}

/// The reason for which a changed form is refused.
fn refusal<T: DeserializeOwned>(value: Value) -> String {
    match serde_json::from_value::<T>(value.clone()) {
        Ok(_) => panic!("accepted: {value}"),
        Err(error) => error.to_string(),
    }
}

fn changed(whole: &Value, path: &str, to: Value) -> Value {
    let mut changed = whole.clone();
    *changed.pointer_mut(path).unwrap_or_else(|| panic!("{path} in {whole}")) = to;
    changed
}

#[test]
fn branches_that_contradict_themselves_are_refused() {
    let (branch, line) = branch();
    let (whole, boundary) = (serde_json::to_value(&branch).unwrap(), serde_json::to_value(&line).unwrap());
    assert_eq!(serde_json::from_value::<Branch>(whole.clone()).unwrap().points(), branch.points());
    let summary = &whole["points"][0]["summaries"][0];
    let located = branch.points().iter().position(|point| point.located.is_some()).unwrap();
    let kind = format!("/points/{located}/located");
    let cases = [
        ("/points", json!([]), "points of the line is empty"),
        (
            "/points/1/summaries",
            json!([summary, summary]),
            "summaries of a point has 2 entries: 1 are needed",
        ),
        ("/points/1/summaries", json!([]), "has 0 entries: 1 are needed"),
        ("/points/1/rattle", json!([]), "rattle states of a point has 0 entries: 1 are needed"),
        (
            "/points/1/crossings",
            json!(vec![[0, 0]; 101]),
            "crossings of a point has 101 entries: 1 are needed",
        ),
        ("/points/1/arclength", json!(-1.0), "arclength of point 1 is -1.0: it must be at least 0.0"),
        ("/points/1/summaries/0/min", json!(1e9), "min of channel 0"),
        ("/points/1/summaries/0/rms", json!(1e9), "rms of channel 0 is 1000000000.0: it must be"),
        ("/points/1/summaries/0/deviation", json!(-1.0), "deviation of channel 0 is -1.0"),
        (&kind, json!({ "Bifurcation": "Grazing" }), "the contact of a grazing is not set"),
        (
            &kind,
            json!({ "Grazing": { "contact": 7, "flank": "Upper", "rattle": ["None", "None"] } }),
            "contact 7 does not exist",
        ),
        ("/points/1/multipliers/values", json!([]), "multipliers is empty"),
        (
            "/points/1/multipliers/values",
            json!([[0.5, 0.0], [0.25, 0.0]]),
            "distance of a multiplier of a point from that of its orbit",
        ),
        ("/points/1/multipliers/error", json!(0.25), "error of the multipliers of a point is 0.25"),
        ("/points/1/orbit/multiple", json!(9_007_199_254_740_993u64), "at most 1000000 are allowed"),
    ];
    for (path, to, text) in cases {
        let error = refusal::<Branch>(changed(&whole, path, to));
        assert!(error.contains(text), "{path}: {error}");
    }
    let error = refusal::<BoundaryLine>(changed(&boundary, "/points/1/arclength", json!(-1.0)));
    assert!(error.contains("arclength of point 1"), "{error}");
    assert!(refusal::<BoundaryLine>(changed(&boundary, "/points", json!([]))).contains("is empty"));
    let forged = changed(&boundary, "/points/1/multipliers/values", json!([[0.5, 0.0], [0.25, 0.0]]));
    assert!(refusal::<BoundaryLine>(forged).contains("from that of its orbit"));
    assert!(
        refusal::<BoundaryLine>(changed(&boundary, "/head/across", json!([1.0, 0.0]))).contains("bounds")
    );
}

#[test]
fn orbits_and_certificates_that_contradict_themselves_are_refused() {
    let orbit = orbit();
    let whole = serde_json::to_value(&orbit).unwrap();
    let cases = [
        ("/multipliers/values", json!([[0.5, 0.0]]), "multipliers of the orbit has 1 entries: 2 are needed"),
        ("/multipliers/values", json!([]), "multipliers is empty"),
        ("/multipliers/values", json!([[0.5, 0.0], [0.5, 0.0]]), "sum of the multipliers"),
        ("/multipliers/values", json!([[0.5, 0.1], [0.5, 0.2]]), "pair of conjugates"),
        ("/multipliers/error", json!(-1.0), "error of the multipliers is -1.0"),
        ("/multiple", json!(9_007_199_254_740_993u64), "period_multiple is 9007199254740993: at most"),
        ("/least", json!(3), "least_period_multiple is 3.0: it must divide 1"),
        ("/end", json!(0.0), "end of the orbit"),
        ("/range/0", json!(-1.0), "range is -1.0"),
        ("/corrections/0", json!(-1.0), "correction is -1.0"),
    ];
    for (path, to, text) in cases {
        let error = refusal::<ShootingOrbit>(changed(&whole, path, to));
        assert!(error.contains(text), "{path}: {error}");
    }
    // Multipliers that were not computed have no values and an infinite error.
    let none = Multipliers::new(Vec::new(), f64::INFINITY);
    assert_eq!(crate::common::stored(&none), none);
    let certificate = orbit.certify(&train(0.7)).unwrap();
    let whole = serde_json::to_value(&certificate).unwrap();
    let cases = [
        ("/radii/0/0", json!(-1.0), "half width of a box is -1.0"),
        ("/radii/0", json!([]), "half widths of a box has 0 entries"),
        ("/proposal/legs", json!([]), "legs of the certificate is empty"),
        ("/proposal/nodes/0", json!([0.0]), "has 2 entries: 1 are needed"),
        ("/multipliers/0/radius", json!(-1.0), "radius of a disc is -1.0"),
        (
            "/crossings",
            json!([{ "contact": 9, "to": "Gap", "time": [0.0, 1.0] }]),
            "contact 9 does not exist",
        ),
    ];
    for (path, to, text) in cases {
        let error = refusal::<Certificate>(changed(&whole, path, to));
        assert!(error.contains(text), "{path}: {error}");
    }
}

/// A budget of no steps ends the proof and the derivatives of an orbit, and a cancelled sweep ends its
/// exponents, also while the motion settles.
#[test]
fn proofs_derivatives_and_exponents_ask_their_budget_and_watch() {
    let (orbit, pair) = (orbit().budget(Budget::new().steps(3)), train(0.7));
    assert!(orbit.certify(&pair).unwrap_err().to_string().contains("budget of 3 steps"));
    let error = Sensitivity::of(&pair, &orbit, &["deflection"]).unwrap_err();
    assert!(error.to_string().contains("budget of 3 steps"), "{error}");
    let error = Sensitivity::of_largest_multiplier(&pair, &orbit).unwrap_err();
    assert!(error.to_string().contains("budget of 3 steps"), "{error}");

    let sweep = Sweep::new(Axis::of_values("speed", &[0.7]).unwrap()).settle(1).measure(1);
    let with_exponent = sweep.lyapunov(Lyapunov::new().measure(1));
    let mut value = serde_json::to_value(with_exponent).unwrap();
    value["lyapunov"]["settle"] = json!(4_294_967_296u64);
    let long: Sweep = serde_json::from_value(value).unwrap();
    let begun = Instant::now();
    for taylor in [true, false] {
        let cancel = Arc::new(AtomicBool::new(false));
        let flag = cancel.clone();
        let later = std::thread::spawn(move || {
            std::thread::sleep(Duration::from_millis(300));
            flag.store(true, Ordering::Relaxed);
        });
        let (watch, model) =
            (Watch::new().cancel(cancel), |p: &Point<'_>| Ok::<_, ParameterError>(train(p["speed"])));
        let rows = match taylor {
            true => long.of(&LaneTaylor::new(Taylor::new()), model).watch(watch).run().unwrap(),
            false => long.of(&Located(Dop853::new()), model).watch(watch).run().unwrap(),
        };
        later.join().unwrap();
        assert!(rows.get(0).is_err());
    }
    assert!(begun.elapsed() < Duration::from_secs(20));
}

/// Values that a damaged or edited file may hold.
fn odd(random: u64) -> Value {
    match random % 12 {
        0 => json!(0),
        1 => json!(-1),
        2 => json!(1e300),
        3 => json!(9_007_199_254_740_993u64),
        4 => Value::Null,
        5 => json!("NaN"),
        6 => json!(-1e-300),
        7 => json!(0.5),
        8 => json!(7),
        9 => json!("inf"),
        10 => json!(u64::MAX),
        _ => json!([]),
    }
}

/// A number of a reproducible sequence.
fn next(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let z = (*state ^ (*state >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    (z ^ (z >> 27)) >> 5
}

/// Changes one place of a form: a value, a list shortened or lengthened, a field removed.
fn mutate(value: &mut Value, state: &mut u64) {
    let leave = |fields: &Map<String, Value>, k: usize| fields.keys().nth(k % fields.len()).cloned();
    let random = next(state);
    match value {
        Value::Array(list) if !list.is_empty() => {
            let k = random as usize / 8 % list.len();
            match random % 8 {
                0 => drop(list.remove(k)),
                1 => list.push(list[k].clone()),
                2 => list.truncate(k),
                3 => list.reverse(),
                _ => mutate(&mut list[k], state),
            }
        }
        Value::Object(fields) if !fields.is_empty() => {
            let key = leave(fields, random as usize / 32).unwrap();
            match random % 32 {
                0 => drop(fields.remove(&key)),
                _ => mutate(&mut fields[&key], state),
            }
        }
        Value::Number(number) if random.is_multiple_of(3) => {
            let x = number.as_f64().unwrap();
            *value = json!(x * (0.5 + (random % 1000) as f64 / 1000.0));
        }
        other => *other = odd(random / 3),
    }
}

/// Reads `count` mutations of a form and uses those that are accepted. How many were.
fn survive<T: DeserializeOwned>(whole: &Value, seed: u64, count: usize, using: &dyn Fn(&T)) -> usize {
    let (mut state, mut accepted) = (seed, 0);
    for _ in 0..count {
        let mut value = whole.clone();
        for _ in 0..1 + next(&mut state) % 2 {
            mutate(&mut value, &mut state);
        }
        let Ok(read) = serde_json::from_value::<T>(value.clone()) else { continue };
        let begun = Instant::now();
        let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| using(&read)));
        assert!(result.is_ok(), "{value}");
        assert!(begun.elapsed() < Duration::from_secs(20), "{value}");
        accepted += 1;
    }
    accepted
}

fn small() -> Budget {
    Budget::new().steps(3000).time(Duration::from_millis(200))
}

fn use_orbit(orbit: &ShootingOrbit) {
    let (orbit, pair) = (orbit.clone().budget(small()), train(0.7));
    let _ = (orbit.period(), orbit.accuracy(), orbit.stability(), orbit.mean_acceleration(), orbit.drift());
    let _ = (orbit.multipliers().growth(orbit.period()), orbit.least_period_multiple());
    let _ = (orbit.at(&pair, 3.3), orbit.at(&pair, -1e9));
    let _ = Shooting::new().budget(small()).solve_from(&pair, &orbit);
    let _ = orbit.certify(&pair);
    let _ = Sensitivity::of(&pair, &orbit, &["deflection"]);
    let _ = serde_json::to_string(&orbit).unwrap();
}

fn mutations(count: usize, seed: u64) {
    let (branch, line) = branch();
    let form = |value: Result<Value, serde_json::Error>| value.unwrap();
    let pair = train(0.7);
    let of_orbit = survive(&form(serde_json::to_value(orbit())), seed, count, &use_orbit);
    let short = {
        let mut value = form(serde_json::to_value(&branch));
        value["points"].as_array_mut().unwrap().truncate(4);
        value
    };
    let of_branch = survive(&short, seed + 1, count, &|branch: &Branch| {
        let _ = (branch.to_string(), branch.table(), branch.near(0.75), branch.located().count());
        for point in branch.points() {
            let _ = (point.kind(), point.stability());
        }
        use_orbit(&branch.points()[0].orbit);
    });
    let _ = survive(&form(serde_json::to_value(&line)), seed + 2, count / 4, &|line: &BoundaryLine| {
        let _ = (line.to_string(), line.table(), line.turns().count());
    });
    let certificate = orbit().certify(&pair).unwrap();
    let of_certificate =
        survive(&form(serde_json::to_value(&certificate)), seed + 3, count, &|certificate: &Certificate| {
            let _ =
                (certificate.to_string(), certificate.times(), certificate.states(), certificate.radius());
            let _ = (certificate.check(&pair), certificate.figures(&pair));
        });
    let harmonics = Harmonics::up_to(5);
    let balance = Balance::new(harmonics);
    let series = balance.solve(&pair, &balance.linearised(&pair, Piece::Upper).unwrap()).unwrap();
    let of_series =
        survive(&form(serde_json::to_value(&series)), seed + 4, count, &|series: &FourierOrbit| {
            let _ = (series.period(), series.at(0.3), series.notes().len());
            let _ = Shooting::new().budget(small()).solve_from(&pair, series);
        });
    let sweep =
        Sweep::new(Axis::of_values("speed", &[0.7, 0.8]).unwrap()).settle(2).measure(2).strobe(1).rattle();
    let sweep = sweep.channels(&["deflection"]).multipliers(Shooting::new());
    let model = |p: &Point<'_>| Ok::<_, ParameterError>(train(p["speed"]));
    let rows = sweep.of(&LaneTaylor::new(Taylor::new()), model).run().unwrap();
    let of_rows = survive(&form(serde_json::to_value(&rows)), seed + 5, count, &|rows: &Rows| {
        for row in rows.iter() {
            let _ = (row.channel("deflection"), row.contacts(), row.period_multiple(), row.multipliers());
            let _ = (
                row.settled_after(),
                row.is_sensitive(),
                row.strobes().count(),
                row.step_error("deflection"),
            );
            for contact in row.contacts() {
                let _ = (contact.rattle_state(), contact.impact_count());
            }
        }
        let _ = (Attractors::find(rows, 1e-3), Rows::merge(vec![rows.clone(), rows.clone()]));
    });
    let params = NfgParams::table1();
    let _ = survive(&form(serde_json::to_value(params)), seed + 6, count, &|params: &NfgParams| {
        let _ = NfgPair::new(params);
    });
    let _ =
        survive(&form(serde_json::to_value(RingSet::set_a(4, 1000.0))), seed + 7, count, &|set: &RingSet| {
            let _ = set.params().and_then(|params| Ring::new(&params));
        });
    let settings = form(serde_json::to_value(Shooting::new().segments(3)));
    let of_settings = survive(&settings, seed + 8, count, &|shooting: &Shooting| {
        let _ = shooting.clone().budget(small()).solve(&pair, &State::new(0.0, &[1.1], &[0.0]));
    });
    let settings = form(serde_json::to_value(Lyapunov::new()));
    let _ = survive(&settings, seed + 9, count, &|lyapunov: &Lyapunov| {
        let _ = lyapunov.clone().budget(small()).run(&pair, &State::new(0.0, &[1.1], &[0.0]));
    });
    let contact = form(serde_json::to_value(ContactStatistics { time: [3.0, 1.0, 0.0], impacts: [5, 0] }));
    let _ = survive(&contact, seed + 10, count, &|contact: &ContactStatistics| {
        let _ = (contact.rattle_state(), contact.loss_fraction(), contact.impact_count());
    });
    let accepted = [of_orbit, of_branch, of_certificate, of_series, of_rows, of_settings];
    assert!(accepted.iter().all(|accepted| *accepted > 0 && *accepted < count), "{accepted:?}");
}

#[test]
fn changed_forms_are_refused_or_used() {
    mutations(60, 1);
}

#[test]
#[ignore = "thousands of changed forms: minutes"]
fn thousands_of_changed_forms_are_refused_or_used() {
    (0..8).for_each(|round| mutations(400, 1000 * (round + 1)));
}
