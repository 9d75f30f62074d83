//! The command line of the random search; see the documentation of the library.

use search::checks::all;
use search::{Check, Outcome};
use std::collections::BTreeMap;
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

const USAGE: &str = "search SEED SECONDS [--only CHECK] [--cases N] [--case CHECK:INDEX]";

/// Time after which a case counts as a hang.
const LIMIT: Duration = Duration::from_secs(600);

/// Counts of one check.
#[derive(Default)]
struct Count {
    agree: u64,
    fail: u64,
    skipped: u64,
    /// Models that had nothing to compare, by the reason: those drawn again, and the last one of a skipped
    /// case.
    without: BTreeMap<&'static str, u64>,
    time: Duration,
}

impl Count {
    fn cases(&self) -> u64 {
        self.agree + self.fail + self.skipped
    }
    /// Number of models with and without what the check compares.
    fn models(&self) -> [u64; 2] {
        [self.agree + self.fail, self.without.values().sum()]
    }
    /// Whether more than 5 % of the cases are skipped.
    fn skips(&self) -> bool {
        self.skipped * 20 > self.cases()
    }
    /// Whether fewer than one model in four has what the check compares, by more than three standard
    /// deviations of chance, or none of 16.
    fn seldom_finds(&self) -> bool {
        let [with, without] = self.models();
        let all = (with + without) as f64;
        (with == 0 && without >= 16) || (with as f64) < 0.25 * all - 3.0 * (0.25 * 0.75 * all).sqrt()
    }
}

fn option<'a>(arguments: &'a [String], name: &str) -> Option<&'a str> {
    let at = arguments.iter().position(|argument| argument == name)?;
    arguments.get(at + 1).map(String::as_str)
}

fn print(counts: &BTreeMap<&str, Count>) {
    println!(
        "{:24}{:>9}{:>9}{:>9}{:>14}{:>12}",
        "check", "agree", "fail", "skipped", "of models %", "ms a case"
    );
    for (name, count) in counts {
        let each = count.time.as_secs_f64() * 1e3 / count.cases() as f64;
        let [with, without] = count.models();
        let share = 100.0 * without as f64 / (with + without) as f64;
        let [agree, fail, skipped] = [count.agree, count.fail, count.skipped];
        println!("{name:24}{agree:9}{fail:9}{skipped:9}{share:14.1}{each:12.1}");
        count.without.iter().for_each(|(why, n)| println!("{n:>33} models without: {why}"));
    }
}

fn find(name: &str) -> Result<&'static Check, String> {
    all().find(|check| check.name == name).ok_or_else(|| format!("no check {name}"))
}

fn run(arguments: &[String]) -> Result<bool, String> {
    let seed: u64 = arguments.first().and_then(|s| s.parse().ok()).ok_or(USAGE)?;
    let seconds: f64 = arguments.get(1).and_then(|s| s.parse().ok()).ok_or(USAGE)?;
    if let Some(case) = option(arguments, "--case") {
        let (name, index) = case.split_once(':').ok_or(USAGE)?;
        let (outcome, again) = find(name)?.case(seed, index.parse().map_err(|_| USAGE)?, true);
        again.iter().for_each(|why| println!("drawn again: {why}"));
        println!("{outcome:?}");
        return Ok(!matches!(outcome, Outcome::Fails(_)));
    }
    let only = option(arguments, "--only").map(find).transpose()?;
    let cases: Option<u64> = option(arguments, "--cases").and_then(|n| n.parse().ok());
    let checks: Vec<&Check> = match only {
        Some(only) => vec![only],
        None => all().collect(),
    };
    if checks.is_empty() {
        return Err("there is no check".into());
    }
    let deadline = Instant::now() + Duration::from_secs_f64(seconds);
    let next = AtomicU64::new(0);
    let counts: Mutex<BTreeMap<&str, Count>> = Mutex::default();
    let running: Mutex<BTreeMap<u64, (String, Instant)>> = Mutex::default();
    let work = || loop {
        // The checks take turns, so that a slow one does not take the time of the others.
        let turn = next.fetch_add(1, Ordering::Relaxed);
        let (check, index) = (checks[(turn % checks.len() as u64) as usize], turn / checks.len() as u64);
        if cases.map_or(Instant::now() >= deadline, |cases| index >= cases) {
            break;
        }
        let begin = Instant::now();
        if let Ok(mut running) = running.lock() {
            running.insert(turn, (format!("{}:{index}", check.name), begin));
        }
        let (outcome, again) = check.case(seed, index, false);
        if let Ok(mut running) = running.lock() {
            running.remove(&turn);
        }
        let Ok(mut counts) = counts.lock() else { break };
        let count = counts.entry(check.name).or_default();
        count.time += begin.elapsed();
        again.into_iter().for_each(|why| *count.without.entry(why).or_default() += 1);
        match outcome {
            Outcome::Agrees => count.agree += 1,
            Outcome::Skipped(why) => {
                count.skipped += 1;
                *count.without.entry(why).or_default() += 1;
            }
            Outcome::Fails(what) => {
                count.fail += 1;
                println!("-- {seed} {seconds} --case {}:{index}   {what}", check.name);
            }
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        // A case that hangs is reported, and ends the search.
        while workers.iter().any(|worker| !worker.is_finished()) {
            std::thread::sleep(Duration::from_millis(100));
            let Ok(running) = running.lock() else { continue };
            if let Some((case, _)) = running.values().find(|(_, begin)| begin.elapsed() > LIMIT) {
                println!(
                    "-- {seed} {seconds} --case {case}   hangs: it runs for more than {} s",
                    LIMIT.as_secs()
                );
                if let Ok(counts) = counts.lock() {
                    print(&counts);
                }
                std::process::exit(1);
            }
        }
    });
    let counts = counts.into_inner().map_err(|error| error.to_string())?;
    print(&counts);
    // A check that seldom finds what it looks for checks little.
    for (name, _) in counts.iter().filter(|(_, count)| count.skips()) {
        println!("{name}: more than 5 % of its cases are skipped");
    }
    for (name, _) in counts.iter().filter(|(_, count)| count.seldom_finds()) {
        println!("{name}: fewer than one model in four has what it compares");
    }
    Ok(counts.values().all(|count| count.fail == 0 && !count.skips() && !count.seldom_finds()))
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    // A panic is reported as a failing case.
    std::panic::set_hook(Box::new(|_| {}));
    match run(&arguments) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}
