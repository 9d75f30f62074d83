//! A sweep on several computers: the ranks of an MPI job compute its chunks, rank 0 too. The program prints
//! the fingerprint of the rows.
//!
//! ```text
//! sudo apt-get install libopenmpi-dev openmpi-bin libclang-dev clang
//! cargo build --release -p sweep-mpi
//! mpirun -n 4 target/release/sweep-mpi
//! ```
//!
//! Rank 0 assigns the numbers of the chunks and computes on another thread. A rank that is ready sends the
//! rows of its last chunk and asks for the next one. Rows are functions of their points alone, so that the
//! fingerprint does not depend on the number of ranks: `examples/mpi/check.sh` compares runs on 1, 2 and 3
//! ranks with a run without MPI (`--serial`). If a rank fails, the job ends. `--channel NAME` measures
//! another channel than `q0`.

use gear_dynamics::sweep::{Axis, LaneRk4, Point, Points, Rows, SweepError};
use gear_dynamics::{NfgPair, NfgParams, ParameterError, State, Sweep};
use mpi::Threading;
use mpi::point_to_point::{Destination, Source};
use mpi::topology::{Communicator, SimpleCommunicator};
use std::error::Error;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

const CHUNKS: u64 = 24;
/// Number that means: no more chunks.
const NO_MORE: u64 = u64::MAX;

fn sweep(channel: &str) -> Result<Sweep, ParameterError> {
    let points =
        Points::grid(vec![Axis::linear("speed", 100.0, 250.0, 24)?, Axis::linear("load", 10.0, 50.0, 16)?])?;
    Ok(Sweep::new(points).settle(4).measure(2).channels(&[channel]).rattle())
}

fn compute(sweep: &Sweep, chunk: u64, chunks: u64) -> Result<Rows, SweepError> {
    let pair = |p: &Point<'_>| {
        NfgPair::new(&NfgParams { speed: p["speed"], load_torque: p["load"], ..NfgParams::table1() })
    };
    let start = |_: &Point<'_>, pair: &NfgPair| -> Result<State, ParameterError> { pair.on_drive_flank() };
    sweep.of(&LaneRk4::new(63 * 64), pair).start(start).chunk(chunk as usize, chunks as usize)
}

/// Rank 0: assigns chunks on this thread and computes on another one. Returns the merged rows.
fn lead(world: &SimpleCommunicator, sweep: &Sweep) -> Result<Rows, Box<dyn Error>> {
    let next = AtomicU64::new(0);
    let take = || Some(next.fetch_add(1, Ordering::Relaxed)).filter(|chunk| *chunk < CHUNKS);
    let mut parts = Vec::new();
    let own = std::thread::scope(|scope| {
        let own = scope.spawn(|| {
            let mut parts = Vec::new();
            while let Some(chunk) = take() {
                parts.push(compute(sweep, chunk, CHUNKS)?);
            }
            Ok::<_, SweepError>(parts)
        });
        let mut others = world.size() - 1;
        while others > 0 {
            if world.any_process().immediate_probe().is_none() {
                std::thread::sleep(Duration::from_millis(1));
                continue;
            }
            let (rows, status) = world.any_process().receive_vec::<u8>();
            if !rows.is_empty() {
                parts.push(postcard::from_bytes(&rows)?);
            }
            let chunk = take();
            others -= i32::from(chunk.is_none());
            world.process_at_rank(status.source_rank()).send(&chunk.unwrap_or(NO_MORE));
        }
        match own.join() {
            Ok(parts) => parts.map_err(Box::<dyn Error>::from),
            Err(_) => Err("the computing thread of rank 0 panicked".into()),
        }
    })?;
    parts.extend(own);
    Ok(Rows::merge(parts)?)
}

/// Any other rank: asks for chunks, computes them and sends their rows.
fn follow(world: &SimpleCommunicator, sweep: &Sweep) -> Result<(), Box<dyn Error>> {
    let leader = world.process_at_rank(0);
    let mut rows = Vec::new();
    loop {
        leader.send(&rows[..]);
        let (chunk, _) = leader.receive::<u64>();
        if chunk == NO_MORE {
            return Ok(());
        }
        rows = postcard::to_stdvec(&compute(sweep, chunk, CHUNKS)?)?;
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let channel =
        arguments.iter().position(|argument| argument == "--channel").and_then(|i| arguments.get(i + 1));
    let sweep = sweep(channel.map_or("q0", String::as_str))?;
    if arguments.iter().any(|argument| argument == "--serial") {
        println!("{:016x}", compute(&sweep, 0, 1)?.fingerprint());
        return Ok(());
    }
    let (universe, _) =
        mpi::initialize_with_threading(Threading::Funneled).ok_or("MPI cannot be initialised")?;
    let world = universe.world();
    let work = || -> Result<(), Box<dyn Error>> {
        if world.rank() > 0 {
            return follow(&world, &sweep);
        }
        let rows = lead(&world, &sweep)?;
        println!("{:016x}", rows.fingerprint());
        eprintln!("{} points on {} ranks, {} errors", rows.iter().count(), world.size(), rows.errors().len());
        Ok(())
    };
    if let Err(error) = work() {
        eprintln!("rank {}: {error}", world.rank());
        world.abort(1);
    }
    Ok(())
}
