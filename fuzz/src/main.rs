//! Fuzzing: calls every public constructor and setting of the crate with extreme values, then makes short
//! runs with what was accepted.
//!
//! `cargo run --release -p fuzz -- SEED SECONDS` prints for every target how many cases ended with finite
//! numbers, a typed error, a panic, a number that is not finite, a hang, an abort or a broken promise, and
//! names each bad case. The exit code is 1 if there is one. Options:
//!
//! - `--case TARGET:INDEX` runs one case again and prints its values;
//! - `--only TARGET` restricts the run to one target;
//! - `--limit S` sets the seconds after which a case counts as a hang. Default: 10.
//!
//! A case is a function of seed, target and index alone. Cases run in child processes: a case that hangs or
//! aborts ends its child, and a new child continues with the next case.

mod any;
mod case;
mod models;
mod solvers;
mod supervisor;
mod targets;
mod worker;

use std::collections::BTreeMap;
use std::process::ExitCode;
use std::sync::Mutex;
use std::time::{Duration, Instant};
use supervisor::{Seen, Share};
use targets::TARGETS;
use worker::{Order, Place};

/// The ways in which a case may end; the first two are good.
const KINDS: [&str; 7] = ["finite", "typed", "panic", "non-finite", "hang", "abort", "broken"];

/// Maximum number of bad cases that are named, for each target and way of ending.
const NAMED: u64 = 12;

fn number<T: std::str::FromStr>(arguments: &[String], i: usize) -> Option<T> {
    arguments.get(i)?.parse().ok()
}

fn option<'a>(arguments: &'a [String], name: &str) -> Option<&'a str> {
    let at = arguments.iter().position(|argument| argument == name)?;
    arguments.get(at + 1).map(String::as_str)
}

/// Counts of all cases. Bad cases are printed as they occur.
#[derive(Default)]
struct Table {
    counts: BTreeMap<(usize, usize), u64>,
    slowest: BTreeMap<usize, (Duration, u64)>,
}

impl Table {
    fn add(&mut self, seed: u64, seconds: f64, seen: &Seen) {
        let Seen { place, kind, text, time } = seen;
        let kind = KINDS.iter().position(|name| name == kind).unwrap_or(KINDS.len() - 1);
        let count = self.counts.entry((place.target, kind)).or_default();
        *count += 1;
        if kind >= 2 && *count <= NAMED {
            let name = TARGETS[place.target].name;
            println!("{}: -- {seed} {seconds} --case {name}:{}   {text}", KINDS[kind], place.index);
        }
        let slowest = self.slowest.entry(place.target).or_default();
        *slowest = (*slowest).max((*time, place.index));
    }

    fn bad(&self) -> u64 {
        self.counts.iter().filter(|((_, kind), _)| *kind >= 2).map(|(_, count)| count).sum()
    }

    fn print(&self) {
        println!("{:16}{}   slowest", "target", KINDS.map(|kind| format!("{kind:>11}")).concat());
        for (i, target) in TARGETS.iter().enumerate() {
            let count = |kind| self.counts.get(&(i, kind)).copied().unwrap_or(0);
            let counts: String = (0..KINDS.len()).map(|kind| format!("{:11}", count(kind))).collect();
            let (time, index) = self.slowest.get(&i).copied().unwrap_or_default();
            println!("{:16}{counts}   {:.2} s, case {index}", target.name, time.as_secs_f64());
        }
        let total = |kind| self.counts.iter().filter(|((_, k), _)| *k == kind).map(|(_, n)| n).sum::<u64>();
        println!(
            "{:16}{}",
            "all",
            (0..KINDS.len()).map(|kind| format!("{:11}", total(kind))).collect::<String>()
        );
    }
}

fn run(arguments: &[String]) -> Result<ExitCode, String> {
    let said = |error: std::io::Error| error.to_string();
    match arguments.first().map(String::as_str) {
        Some("--child") => {
            let [seed, first, stride, skip] = [1, 3, 4, 5].map(|i| number(arguments, i).unwrap_or(1));
            let order = Order { only: number(arguments, 2) };
            return worker::work(seed, order, first, stride, skip).map(|()| ExitCode::SUCCESS).map_err(said);
        }
        Some("--single") => {
            let [seed, target, index] = [1, 2, 3].map(|i| number(arguments, i).unwrap_or(0));
            return worker::single(seed, Place { target: target as usize, index })
                .map(|()| ExitCode::SUCCESS)
                .map_err(said);
        }
        _ => {}
    }
    let usage = "fuzz SEED SECONDS [--case TARGET:INDEX] [--only TARGET] [--limit SECONDS]";
    let (Some(seed), Some(seconds)) = (number::<u64>(arguments, 0), number::<f64>(arguments, 1)) else {
        return Err(usage.into());
    };
    let limit =
        Duration::from_secs_f64(option(arguments, "--limit").and_then(|s| s.parse().ok()).unwrap_or(10.0));
    let find = |name: &str| {
        TARGETS.iter().position(|target| target.name == name).ok_or_else(|| format!("no target {name}"))
    };
    let table = Mutex::new(Table::default());
    let add = |seen: Seen| {
        if let Ok(mut table) = table.lock() {
            table.add(seed, seconds, &seen);
        }
    };

    if let Some(case) = option(arguments, "--case") {
        let (name, index) = case.split_once(':').ok_or(usage)?;
        let place = Place { target: find(name)?, index: index.parse().map_err(|_| usage)? };
        let show = &mut |seen: Seen| {
            println!("{} {} ({:.3} s)", seen.kind, seen.text, seen.time.as_secs_f64());
            add(seen);
        };
        supervisor::again(seed, place, limit, show).map_err(said)?;
    } else {
        let deadline = Instant::now() + Duration::from_secs_f64(seconds);
        let only = option(arguments, "--only").map(find).transpose()?;
        let shares = std::thread::available_parallelism().map_or(1, |n| n.get() as u64);
        std::thread::scope(|scope| {
            for number in 0..shares {
                let add = &add;
                let share = Share { seed, order: Order { only }, number, of: shares };
                scope.spawn(move || supervisor::run(share, limit, deadline, &mut |seen| add(seen)));
            }
        });
    }
    let table = table.into_inner().map_err(|error| error.to_string())?;
    table.print();
    Ok(if table.bad() == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    run(&arguments).unwrap_or_else(|error| {
        eprintln!("{error}");
        ExitCode::from(2)
    })
}
