//! Tables of results: read back bit for bit by the crates `csv` and `npyz`.

use crate::api::*;
use crate::common::{FreeDeadZone, Impact as Rattling};
use proptest::prelude::*;
use std::io::{Error, Write};

fn columns(names: &[(&str, &str)]) -> Vec<Channel> {
    names.iter().map(|(name, unit)| Channel::new(*name, *unit)).collect()
}

/// Names and numbers of a table that was written as CSV.
fn read_csv(table: &ResultTable) -> (Vec<String>, Vec<f64>) {
    let mut bytes = Vec::new();
    table.write_csv(&mut bytes).unwrap();
    let mut reader = csv::Reader::from_reader(bytes.as_slice());
    let names = reader.headers().unwrap().iter().map(str::to_owned).collect();
    let numbers = reader
        .records()
        .flat_map(|record| record.unwrap().iter().map(|field| field.parse().unwrap()).collect::<Vec<f64>>())
        .collect();
    (names, numbers)
}

/// Shape and numbers of a table that was written as NPY.
fn read_npy(table: &ResultTable) -> (Vec<u64>, Vec<f64>) {
    let mut bytes = Vec::new();
    table.write_npy(&mut bytes).unwrap();
    let file = npyz::NpyFile::new(bytes.as_slice()).unwrap();
    let shape = file.shape().to_vec();
    assert_eq!(file.order(), npyz::Order::C);
    (shape, file.into_vec().unwrap())
}

/// Every bit, the sign of zero included. All NaN are one: CSV has only one.
fn bits(numbers: &[f64]) -> Vec<u64> {
    numbers.iter().map(|x| if x.is_nan() { f64::NAN.to_bits() } else { x.to_bits() }).collect()
}

fn check(table: &ResultTable) {
    let (names, numbers) = read_csv(table);
    let known: Vec<String> = table.columns().iter().map(ToString::to_string).collect();
    assert_eq!((names, bits(&numbers)), (known, bits(table.numbers())));
    let (shape, numbers) = read_npy(table);
    assert_eq!(shape, [table.len() as u64, table.columns().len() as u64]);
    assert_eq!(bits(&numbers), bits(table.numbers()));
}

proptest! {
    /// Any bits, subnormal numbers, infinities and NaN among them.
    #[test]
    fn numbers_return_bit_for_bit(rows in prop::collection::vec(any::<[u64; 3]>(), 0..20)) {
        let mut table = ResultTable::new(columns(&[("t", "s"), ("a", ""), ("b", "1")])).unwrap();
        for row in rows {
            table.push(&row.map(f64::from_bits)).unwrap();
        }
        check(&table);
    }

    /// Any names, commas, quotation marks and line breaks among them.
    #[test]
    fn names_return(names in prop::collection::hash_set("[ -~,\"\n\r]{0,8}", 1..5), unit in "[ -~]{0,3}") {
        let columns = names.iter().map(|name| Channel::new(name, &unit)).collect();
        let mut table = ResultTable::new(columns).unwrap();
        table.push(&vec![1.0; names.len()]).unwrap();
        check(&table);
    }
}

/// The numbers at the limits of the format, and the text itself.
#[test]
fn text_of_a_table() {
    let mut table = ResultTable::new(columns(&[("a, \"b\"", "N"), ("c", "")])).unwrap();
    for row in [[0.1, -0.0], [f64::MAX, f64::MIN_POSITIVE], [5e-324, f64::INFINITY], [f64::NAN, 1.0]] {
        table.push(&row).unwrap();
    }
    let mut text = Vec::new();
    table.write_csv(&mut text).unwrap();
    let expected = "\"a, \"\"b\"\" [N]\",c\n0.1,-0.0\n1.7976931348623157e308,2.2250738585072014e-308\n\
                    5e-324,inf\nNaN,1.0\n";
    assert_eq!(String::from_utf8(text).unwrap(), expected);
    check(&table);
    assert_eq!(table.column("c").unwrap()[3], 1.0);
    assert_eq!((table.len(), table.is_empty(), table.rows().count()), (4, false, 4));
}

/// A trajectory: the channels with their units, at drive edges and at the start as `channel` reads them.
#[test]
fn trajectories() {
    let pair = NfgPair::new(&NfgParams { speed: 180.0, ..NfgParams::table1() }).unwrap();
    let run = Dop853::new().trajectory(&pair, &pair.on_drive_flank().unwrap(), 2e-3).unwrap();
    let table = run.table(&pair, &["mesh force", "q0"]).unwrap();
    assert_eq!(
        table.columns().iter().map(|c| c.name.as_str()).collect::<Vec<_>>(),
        ["t", "mesh force", "q0"]
    );
    assert_eq!((table.column("t").unwrap(), table.len()), (run.times().to_vec(), run.len()));
    assert_eq!(table.column("mesh force").unwrap(), run.channel(&pair, "mesh force").unwrap());
    check(&table);
    let all = run.table(&pair, &[]).unwrap();
    assert_eq!(all.columns().len(), 1 + Probe::new(&pair).channels().len());
    check(&all);
    assert!(matches!(run.table(&pair, &["q6"]), Err(ParameterError::NoSuchChannel { .. })));
    assert_eq!(run.table(&pair, &["q0", "q0"]), Err(ParameterError::Twice { name: "q0".into() }));
    struct Two;
    impl Model for Two {
        fn dof(&self) -> usize {
            2
        }
        fn accel(&self, _: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) {
            a.fill(0.0);
        }
    }
    assert!(matches!(run.table(&Two, &["q0"]), Err(ParameterError::Length { .. })));
}

/// Rows: a line for each point, NaN for a point that failed.
#[test]
fn rows_of_a_sweep() {
    let pair = NfgPair::new(&NfgParams::table1()).unwrap();
    let points = Points::grid(vec![
        Axis::of_values("speed", &[180.0, -1.0, 100.0]).unwrap(),
        Axis::of_values("load torque", &[20.0, 30.0]).unwrap(),
    ])
    .unwrap();
    let rows = Sweep::new(points)
        .settle(2)
        .measure(2)
        .channels(&["q0", "mesh force"])
        .rattle()
        .of(&LaneRk4::new(63 * 32).lanes::<4>(), |p| {
            pair.with("speed", p["speed"])?.with("load torque", p["load torque"])
        })
        .start(|_, pair| pair.on_drive_flank())
        .run()
        .unwrap();
    let table = rows.table().unwrap();
    check(&table);
    assert_eq!((table.len(), rows.errors().len()), (6, 2));
    assert_eq!(table.column("speed").unwrap(), [180.0, 180.0, -1.0, -1.0, 100.0, 100.0]);
    assert_eq!(table.column("point").unwrap(), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
    for (index, line) in table.rows().enumerate() {
        let find = |name: &str| line[table.columns().iter().position(|c| c.name == name).unwrap()];
        let Ok(row) = rows.get(index) else {
            assert!(line[3..].iter().all(|x| x.is_nan()) && line[..3].iter().all(|x| x.is_finite()));
            continue;
        };
        let force = row.channel("mesh force").unwrap();
        assert_eq!([find("rms mesh force"), find("max mesh force")], [force.rms, force.max]);
        assert_eq!(find("deviation q0"), row.channel("q0").unwrap().deviation);
        assert_eq!(find("gap 0"), row.contacts()[0].time[1]);
        assert_eq!(find("impacts upper 0"), row.contacts()[0].impacts[1] as f64);
        assert_eq!(find("rattle state 0"), f64::from(row.contacts()[0].rattle_state().rsv()));
        assert_eq!([find("change"), find("scatter")], [row.change(), row.scatter()]);
    }
    // A parameter with the name of a result.
    let clash = Points::from(Axis::of_values("scatter", &[100.0]).unwrap());
    let rows = Sweep::new(clash)
        .settle(0)
        .measure(1)
        .of(&LaneRk4::new(63 * 16).lanes::<4>(), |_| pair.with("speed", 100.0))
        .start(|_, pair| pair.on_drive_flank())
        .run()
        .unwrap();
    assert_eq!(rows.table(), Err(ParameterError::Twice { name: "scatter".into() }));
}

/// Spectra, densities and impacts.
#[test]
fn other_results() {
    let x: Vec<f64> = (0..32).map(|i| (f64::from(i) * 0.7).sin()).collect();
    let spectrum = Spectrum::new(&x, 0.01, Window::Hann).unwrap();
    let table = spectrum.table();
    check(&table);
    assert_eq!(table.column("frequency").unwrap(), spectrum.frequencies());
    assert_eq!(table.column("amplitude").unwrap(), spectrum.amplitudes());
    assert_eq!(table.column("phase").unwrap(), spectrum.phases());
    let density = Welch::new(8).density(&x, 0.01).unwrap();
    let table = density.table();
    check(&table);
    assert_eq!(table.column("density").unwrap(), density.values());
    assert_eq!(table.column("amplitude").unwrap(), density.amplitudes());
    let model = FreeDeadZone { b: 1.0 };
    let mut impacts = Impacts::new(&model);
    Dop853::new().run(&model, &State::new(0.0, &[0.0], &[1.0]), 7.0, &mut impacts).unwrap();
    let table = impacts.table();
    check(&table);
    assert_eq!(table.column("flank").unwrap(), [1.0, -1.0]);
    assert_eq!(table.column("t").unwrap(), [impacts.all()[0].t, impacts.all()[1].t]);
    assert!(table.column("flight").unwrap()[0].is_nan() && table.column("left").unwrap()[1].is_nan());
    let run = Rk4::new(0.1).trajectory(&Rattling, &Rattling::start(), 1.0).unwrap();
    check(&run.table(&Rattling, &["q0", "contact"]).unwrap());
}

#[test]
fn refused_input() {
    assert!(matches!(ResultTable::new(Vec::new()), Err(ParameterError::Empty { .. })));
    let twice = ResultTable::new(columns(&[("a", "N"), ("a", "m")]));
    assert_eq!(twice, Err(ParameterError::Twice { name: "a".into() }));
    let mut table = ResultTable::new(columns(&[("a", ""), ("b", "")])).unwrap();
    for wrong in [&[][..], &[1.0], &[1.0; 3]] {
        assert!(matches!(table.push(wrong), Err(ParameterError::Length { expected: 2, .. })));
    }
    assert!(matches!(table.column("c"), Err(ParameterError::NoSuchChannel { .. })));
    let kind = |result: std::io::Result<()>| result.unwrap_err().kind();
    let invalid = std::io::ErrorKind::InvalidInput;
    assert_eq!(kind(Csv::new(Vec::new(), &[""; 0]).map(drop)), invalid);
    let mut csv = Csv::new(Vec::new(), &["a", "b"]).unwrap();
    assert_eq!(kind(csv.row(&[&1])), invalid);
    assert_eq!(kind(csv.numbers(&[1.0; 3])), invalid);
    csv.row(&[&"x\ny", &1.5]).unwrap();
    assert_eq!(csv.finish().unwrap(), b"a,b\n\"x\ny\",1.5\n");
}

/// A writer that is full ends the export with its own error.
#[test]
fn errors_of_the_writer_are_passed_on() {
    struct Full(usize);
    impl Write for Full {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            if bytes.len() > self.0 {
                return Err(Error::from(std::io::ErrorKind::StorageFull));
            }
            self.0 -= bytes.len();
            Ok(bytes.len())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }
    let mut table = ResultTable::new(columns(&[("a", "")])).unwrap();
    table.push(&[1.0]).unwrap();
    for room in [0, 1, 3, 130] {
        let error = table.write_npy(Full(room)).unwrap_err();
        assert_eq!(error.kind(), std::io::ErrorKind::StorageFull);
    }
    for room in [0, 1, 4] {
        assert_eq!(table.write_csv(Full(room)).unwrap_err().kind(), std::io::ErrorKind::StorageFull);
    }
}
