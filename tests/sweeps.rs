//! Sweeps: the same bits however they are run, the answers of the accurate engine, and bad input by name.

#[path = "../benches/common/mod.rs"]
mod common;

use common::Pair;
use gear_dynamics::*;


const STEPS: usize = 63 * 16;

fn pair(p: &Point<'_>) -> Result<Pair, ParameterError> {
    Ok(Pair::at(p["we"]))
}
fn rest(_: &Point<'_>, _: &Pair) -> Result<State, ParameterError> {
    Ok(Pair::start())
}
fn frequencies(count: usize) -> Points {
    Points::along(Axis::linear("we", 0.15, 0.36, count).unwrap())
}
fn sweep(count: usize) -> Sweep {
    Sweep::over(frequencies(count)).settle(2).measure(3).channels(&["q1", "v1"]).rattle().strobe(2)
}
fn hash(sweep: &Sweep, engine: &impl SweepEngine<Pair>) -> u64 {
    sweep.run(engine, pair, rest).unwrap().fingerprint()
}

/// The bits are a function of the points alone: any number of lanes, any instructions, any threads, in order or not, chunked or whole.
#[test]
fn the_same_bits_however_it_is_run() {
    let sweep = sweep(75);
    let expected = hash(&sweep, &LaneRk4::<16>::new(STEPS));
    assert_eq!(expected, hash(&sweep, &LaneRk4::<4>::new(STEPS)));
    assert_eq!(expected, hash(&sweep, &LaneRk4::<8>::new(STEPS)));
    assert_eq!(expected, hash(&sweep, &LaneRk4::<24>::new(STEPS)));
    assert_eq!(expected, hash(&sweep, &LaneRk4::<32>::new(STEPS)));
    for set in InstructionSet::available() {
        assert_eq!(expected, hash(&sweep, &LaneRk4::<16>::new(STEPS).instructions(set)), "{set:?}");
    }
    for threads in [1, 2, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert_eq!(expected, pool.install(|| hash(&sweep, &LaneRk4::<16>::new(STEPS))), "{threads} threads");
    }
    for chunks in [2, 3, 7] {
        let mut parts: Vec<Rows> = (0..chunks)
            .map(|i| sweep.run_chunk(i, chunks, &LaneRk4::<16>::new(STEPS), pair, rest, &Watch::new()).unwrap())
            .collect();
        parts.reverse();
        assert_eq!(expected, Rows::merge(parts).unwrap().fingerprint(), "{chunks} chunks");
    }
    // Backwards, and one at a time: a run alone is made without lanes, over the same table.
    let rows = sweep.run(&LaneRk4::<16>::new(STEPS), pair, rest).unwrap();
    for i in [0, 17, 74] {
        let value = rows.points().point(i)["we"];
        let alone = Sweep::over(Points::along(Axis::list("we", &[value]).unwrap()));
        let alone = alone.settle(2).measure(3).channels(&["q1", "v1"]).rattle().strobe(2);
        let alone = alone.run(&LaneRk4::<16>::new(STEPS), pair, rest).unwrap();
        let (a, b) = (alone.iter().next().unwrap(), rows.row(i).unwrap().unwrap());
        assert_eq!(a.channel("q1"), b.channel("q1"));
        assert_eq!(a.contact(0), b.contact(0));
        assert!(a.strobes().eq(b.strobes()));
        assert_eq!(alone.alone(), 1);
    }
    assert_eq!(rows.alone(), 0);
}

/// The bits of one sweep, written down: they may only change with an entry under "Numerics" of the change log.
#[test]
fn the_bits_are_pinned() {
    assert_eq!(format!("{:016x}", hash(&sweep(20), &LaneRk4::<16>::new(STEPS))), "3be117e26ed6dffd");
}
