//! Sweeps in chunks, cancelled and resumed; checks, points that fail, progress and monitors; sizes of tables.

use crate::api::*;
use crate::common::stored;
use std::f64::consts::TAU;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// q'' = pull cos φ - w² q - 0.1 q', period 2 in most tests, with one drive edge of height zero in each
/// period. It counts the evaluations and may cancel the sweep.
struct Swing {
    /// Place of the drive edge as a share of the period.
    edge: f64,
    count: Option<Arc<Count>>,
}

/// A shape that counts equals no other shape.
impl PartialEq for Swing {
    fn eq(&self, other: &Self) -> bool {
        self.edge == other.edge && self.count.is_none() && other.count.is_none()
    }
}

/// Number of evaluations of drives and of accelerations. The sweep is cancelled when one of them reaches its
/// `last`.
struct Count {
    drives: AtomicUsize,
    accelerations: AtomicUsize,
    last: [usize; 2],
    stop: Arc<AtomicBool>,
}

impl Swing {
    fn made(edge: f64, count: Option<&Arc<Count>>, pull: f64, frequency: f64, period: f64) -> Made {
        Machine::of_constants(
            Swing { edge, count: count.cloned() },
            &[("speed", TAU / period), ("pull", pull), ("frequency", frequency)],
        )
    }
    fn with_edge(edge: f64, frequency: f64) -> Made {
        Swing::made(edge, None, 1.0, frequency, 2.0)
    }
}

impl Count {
    fn new(last: [usize; 2]) -> Self {
        Count {
            drives: AtomicUsize::new(0),
            accelerations: AtomicUsize::new(0),
            last,
            stop: Arc::new(AtomicBool::new(false)),
        }
    }
    fn one(&self, which: usize) {
        let counter = [&self.drives, &self.accelerations][which];
        if counter.fetch_add(1, Relaxed) + 1 == self.last[which] {
            self.stop.store(true, Relaxed);
        }
    }
}

impl Shape for Swing {
    fn size(&self) -> Size {
        Size { dof: 1, waves: 1, constants: 3, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        ["speed", "pull", "frequency"].map(|name| Channel::new(name, "1")).into()
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        if let Some(count) = &self.count {
            count.one(1);
        }
        let ([wave], [pull, frequency]) = (u.waves(), u.constants());
        a[0] = wave * pull - frequency * frequency * q[0] - v[0] * 0.1;
    }
    fn waves<A: Angle>(&self, angle: A, _: Side, u: &mut [A::Number]) {
        if let Some(count) = &self.count {
            count.one(0);
        }
        u[0] = angle.number().cos();
    }
    fn next_edge(&self, angle: f64) -> Option<f64> {
        let whole = (angle / TAU - self.edge).floor() + 1.0;
        [whole, whole + 1.0]
            .map(|k| (k + self.edge) * TAU)
            .into_iter()
            .find(|edge| *edge > angle * (1.0 + 1e-15))
    }
}

type Made = Result<Machine<Swing>, ParameterError>;

fn swing(p: &Point<'_>) -> Made {
    Swing::with_edge(0.5, p["w"])
}
fn rest<M>(_: &Point<'_>, _: &M) -> Result<State, ParameterError> {
    Ok(State::at_rest(1))
}
fn along(count: usize) -> Sweep {
    Sweep::new(Axis::linear("w", 1.0, 3.0, count).unwrap()).settle(2).measure(2).channels(&["q0"]).strobe(1)
}
fn chunks(sweep: &Sweep, count: usize) -> Vec<Rows> {
    (0..count)
        .map(|i| sweep.of(&LaneRk4::new(16).lanes::<4>(), swing).start(rest).chunk(i, count).unwrap())
        .collect()
}
fn pool(threads: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap()
}

/// The choice of checked points is counted from the start of the sweep: merged chunks equal the whole sweep,
/// with checks and error estimates.
#[test]
fn chunks_check_the_points_that_the_whole_checks() {
    let grid = Points::grid(vec![
        Axis::linear("w", 1.0, 3.0, 10).unwrap(),
        Axis::of_values("x", &[1.0, 2.0]).unwrap(),
    ])
    .unwrap();
    let lines = Sweep::new(grid).settle(1).measure(1).channels(&["q0"]).warm_start(WarmStart::Up);
    for sweep in [along(10).check_every(4), lines.check_every(4)] {
        let whole = sweep.of(&LaneRk4::new(16).lanes::<4>(), swing).start(rest).run().unwrap();
        let checked: Vec<usize> =
            whole.iter().filter(|row| row.checked().is_some()).map(|row| row.index()).collect();
        assert_eq!(
            checked,
            if whole.points().len() == 10 { vec![0, 4, 8] } else { vec![0, 1, 8, 9, 16, 17] }
        );
        for count in [2, 3, 7] {
            let merged = Rows::merge(chunks(&sweep, count)).unwrap();
            assert_eq!((&merged, merged.fingerprint()), (&whole, whole.fingerprint()), "{count} chunks");
            for (a, b) in merged.iter().zip(whole.iter()) {
                assert_eq!((a.step_error("q0"), a.is_sensitive()), (b.step_error("q0"), b.is_sensitive()));
            }
        }
        let (one, other) = (sweep.clone().check_every(0), sweep.check_every(3));
        let prints = [one, other].map(|sweep| {
            sweep.of(&LaneRk4::new(16).lanes::<4>(), swing).start(rest).run().unwrap().fingerprint()
        });
        assert!(prints[0] != prints[1] && !prints.contains(&whole.fingerprint()));
    }
}

/// A sweep with warm starts continues after a point that fails. After an error of the engine the next point
/// begins at its own start; past a point without a model it begins at the last state.
#[test]
fn a_line_goes_on_after_a_point_that_fails() {
    fn run<E: SweepEngine<Machine<Swing>>>(
        points: Points,
        warm_start: WarmStart,
        engine: &E,
        family: impl Fn(&Point<'_>) -> Made + Sync,
    ) -> Rows {
        Sweep::new(points)
            .settle(2)
            .measure(2)
            .channels(&["q0"])
            .strobe(1)
            .warm_start(warm_start)
            .of(engine, family)
            .start(rest)
            .run()
            .unwrap()
    }
    fn check<E: SweepEngine<Machine<Swing>>>(
        engine: &E,
        family: impl Fn(&Point<'_>) -> Made + Sync,
        bad: usize,
        warm_start: WarmStart,
        anew: bool,
    ) {
        let all = along(9);
        let rows = run(all.points().clone(), warm_start, engine, family);
        assert!(rows.is_complete());
        assert_eq!(rows.errors().keys().copied().collect::<Vec<_>>(), [bad]);
        let (before, after): (Vec<usize>, Vec<usize>) = (0..9).filter(|i| *i != bad).partition(|i| *i < bad);
        let parts = if anew { vec![before, after] } else { vec![[before, after].concat()] };
        for part in parts.into_iter().filter(|part| !part.is_empty()) {
            let points: Vec<Vec<f64>> =
                part.iter().map(|i| all.points().point(*i).values().to_vec()).collect();
            let alone = run(Points::of_rows(&["w"], &points).unwrap(), warm_start, engine, swing);
            for (row, index) in alone.iter().zip(part) {
                assert_eq!(row.channel("q0"), rows.get(index).unwrap().channel("q0"), "{index}");
            }
        }
    }
    for warm_start in [WarmStart::Up, WarmStart::Down] {
        for bad in [0, 3, 8] {
            let off = |p: &Point<'_>| Swing::with_edge(if p.index() == bad { 0.501 } else { 0.5 }, p["w"]);
            check(&LaneRk4::new(16).lanes::<4>(), off, bad, warm_start, true);
            check(&TableRk4::new(16), off, bad, warm_start, true);
            let pulled = |p: &Point<'_>| {
                Swing::made(0.5, None, if p.index() == bad { f64::NAN } else { 1.0 }, p["w"], 2.0)
            };
            check(&LaneRk4::new(16).lanes::<4>(), pulled, bad, warm_start, false);
            check(&Located(Rk4::new(0.1)), pulled, bad, warm_start, false);
        }
    }
}

/// q'' = pull - q: a model with a given period and a constant drive.
struct Bare {
    period: f64,
    pull: f64,
}

impl Model for Bare {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) {
        a[0] = u[0] - q[0];
    }
    fn drive(&self, _: f64, _: Side, u: &mut [f64]) {
        u[0] = self.pull;
    }
}

impl Periodic for Bare {
    fn period(&self) -> f64 {
        self.period
    }
}

/// A model without a valid period or with drives that are not finite is refused. The constants of a machine
/// are checked by its constructor.
#[test]
fn periods_and_constants_that_are_none() {
    fn errors<E: SweepEngine<Bare>>(engine: &E, change: &(dyn Fn(&mut Bare) + Sync)) -> Vec<PointError> {
        let family = |p: &Point<'_>| {
            let mut bare = Bare { period: 2.0, pull: p["w"] };
            if [0, 2, 7].contains(&p.index()) {
                change(&mut bare);
            }
            Ok::<_, ParameterError>(bare)
        };
        let rows = along(8).of(engine, family).start(rest).run().unwrap();
        assert_eq!(
            (rows.errors().keys().copied().collect::<Vec<_>>(), rows.iter().count()),
            (vec![0, 2, 7], 5)
        );
        rows.errors().values().cloned().collect()
    }
    for period in [0.0, -2.0, f64::INFINITY, f64::NAN] {
        let change = |bare: &mut Bare| bare.period = period;
        for found in [errors(&TableRk4::new(16), &change), errors(&Located(Rk4::new(0.1)), &change)] {
            assert!(
                found.iter().all(
                    |e| matches!(e, PointError::Period { period: p } if p.to_bits() == period.to_bits())
                ),
                "{found:?}"
            );
        }
        assert!(Swing::made(0.5, None, 1.0, 1.0, period).is_err());
    }
    for pull in [f64::NAN, f64::INFINITY] {
        let change = |bare: &mut Bare| bare.pull = pull;
        let found = errors(&TableRk4::new(16), &change);
        assert!(
            found.iter().all(|e| matches!(e, PointError::Table(TableError::NotFinite { drive: 0, .. }))),
            "{found:?}"
        );
        assert!(matches!(
            Swing::made(0.5, None, pull, 1.0, 2.0),
            Err(ParameterError::NotFinite { name, .. }) if name == "pull"
        ));
    }
}

/// A point that diverges gives no error estimate for its neighbours, although its check with a quarter of the
/// step succeeds.
#[test]
fn a_check_counts_only_beside_its_row() {
    // RK4 is stable up to w h = 2.83. At w = 40 a step of 1/8 is too long; a quarter of it is not.
    let points = Points::from(Axis::of_values("w", &[1.0, 1.1, 40.0, 1.2]).unwrap());
    let sweep = Sweep::new(points).settle(60).measure(1).channels(&["q0"]).check_every(2);
    let kicked = |_: &Point<'_>, _: &Machine<Swing>| Ok::<_, ParameterError>(State::new(0.0, &[1.0], &[0.0]));
    let rows = sweep.of(&LaneRk4::new(16).lanes::<4>(), swing).start(kicked).run().unwrap();
    assert!(matches!(rows.get(2), Err(PointError::Diverged { .. })));
    let [first, next, last] = [0, 1, 3].map(|i| rows.get(i).unwrap());
    // The estimate is a few per cent of the range, since 16 samples in a period may miss (π/16)²/2 of each
    // extreme. It must not contain the missing row.
    let q1 = first.channel("q0").unwrap();
    assert!(first.step_error("q0").unwrap() < 0.1 * q1.peak_to_peak(), "{:?} {q1:?}", first.step_error("q0"));
    assert_eq!(
        (next.step_error("q0"), last.step_error("q0")),
        (first.step_error("q0"), first.step_error("q0"))
    );
}

/// If the check of a point fails, the row contains the error, counts as sensitive and has no estimate of its
/// own.
#[test]
fn a_check_that_fails_is_told() {
    // The edge lies on a whole step of a table of 16 steps within the tolerance of 1e-6, but not of one of
    // 64.
    let family = |p: &Point<'_>| -> Made {
        Swing::with_edge(0.5 + if p.index() == 2 { 6e-7 / 16.0 } else { 0.0 }, p["w"])
    };
    let sweep = along(5).settle(100).check_every(2);
    let rows = sweep.of(&LaneRk4::new(16).lanes::<4>(), family).start(rest).run().unwrap();
    let row = rows.get(2).unwrap();
    assert!(matches!(row.checked(), Some(Err(PointError::Table(TableError::EdgeOffGrid { .. })))));
    assert!(row.is_sensitive() && row.step_error("q0").is_none());
    let [one, two, three, five] = [0, 1, 3, 4].map(|i| rows.get(i).unwrap());
    assert!(!one.is_sensitive() && !two.is_sensitive());
    let most = one.step_error("q0").unwrap().max(five.step_error("q0").unwrap());
    assert_eq!((two.step_error("q0"), three.step_error("q0")), (Some(most), Some(most)));
    let back = stored(&rows);
    assert_eq!(back.fingerprint(), rows.fingerprint());
    let (told, error) = (back.get(2).unwrap(), row.checked().unwrap().unwrap_err());
    assert_eq!(told.checked().unwrap().unwrap_err().to_string(), error.to_string());
}

/// Rows do not depend on the number of threads, but the number of points that ran alone does.
#[test]
fn rows_are_equal_whatever_ran_alone() {
    let sweep = along(145);
    let run = |threads: usize| {
        pool(threads).install(|| sweep.of(&LaneRk4::new(16), swing).start(rest).run()).unwrap()
    };
    let (one, two) = (run(1), run(2));
    assert_eq!(one, two);
    // A chunk of one point has no neighbour for the lanes.
    let chunk = |point| sweep.of(&LaneRk4::new(16), swing).start(rest).chunk(point, 145).unwrap();
    let single = Rows::merge((0..145).map(chunk).collect()).unwrap();
    assert_eq!((one.alone(), single.alone()), (0, 145));
    assert_eq!(one, single);
    // With warm starts every point of a line runs alone.
    assert_eq!(
        along(9).warm_start(WarmStart::Up).of(&LaneRk4::new(16), swing).start(rest).run().unwrap().alone(),
        9
    );
}

/// More chunks than points, merged in any order.
#[test]
fn empty_parts_in_any_order() {
    let sweep = along(3);
    let whole = sweep.of(&LaneRk4::new(16).lanes::<4>(), swing).start(rest).run().unwrap();
    for turn in 0..7 {
        let mut parts = chunks(&sweep, 7);
        parts.rotate_left(turn);
        assert_eq!(Rows::merge(parts.clone()).unwrap(), whole);
        parts.reverse();
        assert_eq!(Rows::merge(parts).unwrap(), whole);
    }
}

/// Rows contain their sweep: a sweep with other points or settings can neither resume nor merge them.
#[test]
fn rows_of_another_sweep_are_refused() {
    let sweep = along(8);
    let wider =
        Sweep::new(Axis::linear("w", 1.0, 3.5, 8).unwrap()).settle(2).measure(2).channels(&["q0"]).strobe(1);
    let renamed =
        Sweep::new(Axis::linear("v", 1.0, 3.0, 8).unwrap()).settle(2).measure(2).channels(&["q0"]).strobe(1);
    let of = |change: fn(Sweep) -> Sweep| change(sweep.clone());
    let others = [
        wider,
        renamed,
        of(|s| s.settle(3)),
        of(|s| s.measure(3)),
        of(|s| s.channels(&["v0"])),
        of(|s| s.strobe(2)),
        of(|s| s.rattle()),
        of(|s| s.warm_start(WarmStart::Up)),
        of(|s| s.check_every(2)),
        of(|s| s.periodic_tolerance(1e-5)),
        of(|s| s.repeat_tolerance(1e-5)),
        of(|s| s.lyapunov(Lyapunov::new())),
    ];
    let parts = chunks(&sweep, 2);
    for other in others {
        let resumed = other.of(&LaneRk4::new(16).lanes::<4>(), swing).start(rest).resume(stored(&parts[0]));
        assert!(matches!(resumed, Err(RowsError { error: SweepError::Parts { row: 0 }, .. })), "{other:?}");
        if other.points().names() == ["w"] {
            let second = other.of(&LaneRk4::new(16).lanes::<4>(), swing).start(rest).chunk(1, 2).unwrap();
            assert_eq!(
                Rows::merge(vec![parts[0].clone(), second]).map_err(|refused| refused.error),
                Err(SweepError::Parts { row: 4 })
            );
        }
    }
}

/// The progress counts the points of the chunk with their checks, also the points without a model.
#[test]
fn progress_ends_at_the_end() {
    let seen = |sweep: &Sweep,
                i: usize,
                n: usize,
                family: &(dyn Fn(&Point<'_>) -> Result<Machine<Swing>, &'static str> + Sync)| {
        let (last, calls) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let totals = std::sync::Mutex::new(std::collections::BTreeSet::new());
        let progress = |done: usize, total: usize| {
            calls.fetch_add(1, Relaxed);
            last.fetch_max(done, Relaxed);
            totals.lock().unwrap().insert(total);
        };
        sweep
            .of(&LaneRk4::new(16).lanes::<4>(), family)
            .start(rest)
            .watch(Watch::new().progress(progress))
            .chunk(i, n)
            .unwrap();
        (last.into_inner(), calls.into_inner(), totals.into_inner().unwrap().into_iter().collect::<Vec<_>>())
    };
    let swing = |p: &Point<'_>| swing(p).map_err(|_| "no swing");
    assert_eq!(seen(&along(100), 0, 4, &swing), (25, 25, vec![25]));
    assert_eq!(seen(&along(100).check_every(1), 1, 4, &swing), (50, 50, vec![50]));
    assert_eq!(seen(&along(100).check_every(10), 0, 4, &swing), (28, 28, vec![28]));
    let asked = AtomicUsize::new(0);
    let never = |_: &Point<'_>| {
        asked.fetch_add(1, Relaxed);
        Err("never")
    };
    assert_eq!(seen(&along(100), 3, 4, &never), (25, 25, vec![25]));
    assert_eq!(asked.into_inner(), 100); // the family is called once a point
    let late = |p: &Point<'_>| if p.index() < 7 { Err("early") } else { swing(p) };
    assert_eq!(seen(&along(100), 0, 4, &late), (25, 25, vec![25]));
    assert_eq!(seen(&along(10).warm_start(WarmStart::Up), 0, 1, &late), (10, 10, vec![10]));
}

#[test]
fn a_family_without_a_model_is_left_when_cancelled() {
    let (asked, stop) = (AtomicUsize::new(0), Arc::new(AtomicBool::new(false)));
    let never = |_: &Point<'_>| {
        stop.store(asked.fetch_add(1, Relaxed) + 1 == 10, Relaxed);
        Err::<Machine<Swing>, _>("never")
    };
    let rows = along(1000)
        .of(&LaneRk4::new(16).lanes::<4>(), never)
        .start(rest)
        .watch(Watch::new().cancel(stop.clone()))
        .run()
        .unwrap();
    assert_eq!((asked.into_inner(), rows.errors().len(), rows.is_complete()), (10, 10, false));
    let whole = along(1000).of(&LaneRk4::new(16).lanes::<4>(), swing).start(rest).resume(rows).unwrap();
    assert_eq!((whole.errors().len(), whole.iter().count()), (10, 990));
}

/// A function that receives rows may take its time and use threads: it blocks no other thread and may start parallel
/// work.
#[test]
fn two_threads_may_show_rows_at_once() {
    let (inside, together) = (AtomicUsize::new(0), AtomicBool::new(false));
    let rows = |row: &Row<'_>| {
        assert!(
            row.channel("q0").unwrap().max > 0.0 && row.point()["w"] >= 1.0 && row.strobes().count() == 1
        );
        if inside.fetch_add(1, Relaxed) > 0 {
            together.store(true, Relaxed);
        }
        // The first call waits until a second one is inside. The time limit ends the test if a lock excludes
        // the second call.
        let began = Instant::now();
        while !together.load(Relaxed) && began.elapsed() < Duration::from_secs(60) {
            std::thread::yield_now();
        }
        inside.fetch_sub(1, Relaxed);
    };
    let made = pool(2)
        .install(|| along(64).of(&LaneRk4::new(16).lanes::<4>(), swing).start(rest).row_callback(rows).run())
        .unwrap();
    assert!(together.into_inner() && made.iter().count() == 64);
    let busy = |_: &Row<'_>| assert_eq!(rayon::join(|| 1, || 2), (1, 2));
    let made = pool(2)
        .install(|| along(64).of(&LaneRk4::new(16).lanes::<4>(), swing).start(rest).row_callback(busy).run())
        .unwrap();
    assert_eq!(made.iter().count(), 64);
}

/// A cancelled run stops within 64 rows of a drive table, or within 64 steps of four accelerations. With 16
/// ns for each of 16 lanes this is 0.1 ms.
#[test]
fn a_cancel_is_seen_within_64_steps() {
    fn asked<E: SweepEngine<Machine<Swing>>>(engine: &E, last: [usize; 2]) -> [usize; 2] {
        let count = Arc::new(Count::new(last));
        // Evaluations by the constructor of the model do not count.
        let family = |p: &Point<'_>| {
            let made = Swing::made(0.5, Some(&count), 1.0, p["w"], 2.0);
            count.drives.store(0, Relaxed);
            count.accelerations.store(0, Relaxed);
            made
        };
        let rows = pool(1)
            .install(|| {
                along(8).of(engine, family).start(rest).watch(Watch::new().cancel(count.stop.clone())).run()
            })
            .unwrap();
        assert_eq!((rows.iter().count(), rows.errors().len()), (0, 0));
        [count.drives.load(Relaxed), count.accelerations.load(Relaxed)]
    }
    for last in [[100, 0], [5000, 0]] {
        for [drives, accelerations] in
            [asked(&LaneRk4::new(5000).lanes::<4>(), last), asked(&TableRk4::new(5000), last)]
        {
            // The period of each of four lanes is checked by 16 accelerations before.
            assert!(drives <= last[0] + 64 && accelerations <= 4 * 16, "{drives} after {}", last[0]);
        }
    }
    for [_, accelerations] in
        [asked(&LaneRk4::new(5000).lanes::<4>(), [0, 1001]), asked(&TableRk4::new(5000), [0, 1001])]
    {
        assert!(accelerations <= 1001 + 4 * 64, "{accelerations}");
    }
}

/// A drive table that exceeds the memory is refused before the sweep begins, also that of the checks.
#[test]
fn tables_have_a_size() {
    let run = |steps: usize, every: usize| {
        along(3).check_every(every).of(&LaneRk4::new(steps).lanes::<4>(), swing).start(rest).run().map(|_| ())
    };
    for steps in [0, 500_000_000, usize::MAX] {
        assert_eq!(run(steps, 0), Err(SweepError::Table(TableError::Size { steps, drives: 1 })));
        let scalar = along(3).of(&TableRk4::new(steps), swing).start(rest).run();
        assert_eq!(scalar.map(|_| ()), Err(SweepError::Table(TableError::Size { steps, drives: 5 })));
    }
    assert_eq!(run(10_000_000, 1), Err(SweepError::Table(TableError::Size { steps: 40_000_000, drives: 1 })));
    assert_eq!(
        run(usize::MAX / 2, 1),
        Err(SweepError::Table(TableError::Size { steps: usize::MAX / 2, drives: 1 }))
    );
}

/// A model with a drive edge at every step, or more often, still has a table.
#[test]
fn jumps_without_number() {
    struct Jumps(Machine<Swing>, f64);
    impl Model for Jumps {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
            self.0.accel(u, q, v, a);
        }
        fn drives(&self) -> usize {
            5
        }
        fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
            self.0.drive(t, side, u);
        }
        fn next_edge(&self, t: f64) -> Option<f64> {
            let k = (t / self.1).floor();
            [k + 1.0, k + 2.0].map(|k| k * self.1).into_iter().find(|edge| *edge > t)
        }
    }
    impl Periodic for Jumps {
        fn period(&self) -> f64 {
            2.0
        }
    }
    let run = |steps: usize, every: f64| {
        let family = |p: &Point<'_>| Ok::<_, ParameterError>(Jumps(swing(p)?, every));
        let points = Points::from(Axis::of_values("w", &[1.0]).unwrap());
        let sweep = Sweep::new(points).settle(0).measure(1).channels(&["q0"]);
        sweep.of(&TableRk4::new(steps), family).start(|_, _| State::at_rest(1)).run().unwrap()
    };
    // More than 10⁵ edges.
    let (often, once) = (run(1 << 18, 2.0 / f64::from(1 << 18)), run(1 << 18, 2.0));
    let [often, once] = [&often, &once].map(|rows| rows.get(0).unwrap().channel("q0").unwrap());
    // Drives at an edge are read 1e-6 of a step beside it.
    assert!((often.max - once.max).abs() < 1e-9 * once.max, "{often:?} {once:?}");
    assert!(matches!(run(16, 2.0 / 48.0).get(0), Err(PointError::Table(TableError::EdgeOffGrid { .. }))));
}

/// A cancelled sweep is resumed: the rows are those of an uninterrupted sweep, and finished points do not run
/// again.
#[test]
fn a_cancelled_run_is_resumed() {
    let grid = Points::grid(vec![
        Axis::linear("w", 1.0, 3.0, 40).unwrap(),
        Axis::of_values("x", &[1.0, 2.0, 3.0]).unwrap(),
    ])
    .unwrap();
    let lines = Sweep::new(grid).settle(1).measure(1).channels(&["q0"]).warm_start(WarmStart::Down);
    let engine = LaneRk4::new(16).lanes::<4>();
    for sweep in [along(120), along(120).check_every(3), lines.clone(), lines.check_every(3)] {
        let count = sweep.points().len();
        let whole = sweep.of(&engine, swing).start(rest).run().unwrap();
        for share in [1, 50, 119] {
            let stop = Arc::new(AtomicBool::new(false));
            let progress = |done: usize, _: usize| stop.store(done >= share, Relaxed);
            let part = pool(1).install(|| {
                let runner = || sweep.of(&engine, swing).start(rest);
                let watched = runner().watch(Watch::new().progress(progress).cancel(stop.clone()));
                let parts = [runner().chunk(0, 2).unwrap(), watched.chunk(1, 2).unwrap()];
                Rows::merge(parts.to_vec()).unwrap()
            });
            let (there, last) = (part.iter().count(), AtomicUsize::new(0));
            assert!(
                there > count / 2 && (share == 119 || there < count) && part != whole || part.is_complete()
            );
            let progress = |done: usize, total: usize| {
                assert!(done <= total && total <= 2 * (count - there) + count / 3 + 6, "{total}");
                last.fetch_max(done, Relaxed);
            };
            let read = stored(&part);
            let resumed = sweep
                .of(&engine, swing)
                .start(rest)
                .watch(Watch::new().progress(progress))
                .resume(read)
                .unwrap();
            assert_eq!((&resumed, resumed.fingerprint()), (&whole, whole.fingerprint()));
        }
    }
    // If nothing is missing, nothing runs.
    let whole = along(5).of(&engine, swing).start(rest).run().unwrap();
    let never = |_: &Point<'_>, _: &Machine<Swing>| Err::<State, _>("never");
    assert_eq!(along(5).of(&engine, swing).start(never).resume(whole.clone()).unwrap(), whole);
}
