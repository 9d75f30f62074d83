//! The parent process: starts the child that runs cases, limits their time, and continues with a new child
//! after a hang or an abort.

use crate::worker::{Order, Place};
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

/// A case and its result.
#[derive(Debug)]
pub struct Seen {
    pub place: Place,
    pub kind: String,
    pub text: String,
    pub time: Duration,
}

/// Address space of a child `[KiB]`: a larger allocation fails and aborts the child instead of exhausting the
/// memory of the machine.
const MEMORY: &str = "6000000";

fn start(arguments: &[String]) -> std::io::Result<Child> {
    let own = std::env::current_exe()?;
    let mut command = if cfg!(unix) {
        let mut shell = Command::new("sh");
        shell.arg("-c").arg(format!("ulimit -v {MEMORY}; exec \"$0\" \"$@\"")).arg(own);
        shell
    } else {
        Command::new(own)
    };
    command.args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()
}

/// The lines that the child prints. The channel closes when the child ends.
fn lines(child: &mut Child) -> Receiver<String> {
    let (send, receive) = channel();
    if let Some(out) = child.stdout.take() {
        thread::spawn(move || {
            BufReader::new(out).lines().map_while(Result::ok).try_for_each(|line| send.send(line))
        });
    }
    receive
}

/// The standard error of the child, read on a separate thread so that the child never blocks.
fn errors(child: &mut Child) -> thread::JoinHandle<String> {
    let err = child.stderr.take();
    thread::spawn(move || {
        let mut text = Vec::new();
        if let Some(mut err) = err {
            let _ = err.read_to_end(&mut text);
        }
        String::from_utf8_lossy(&text).trim().replace('\n', " | ")
    })
}

/// Receives the results of a child until the deadline, a hang or the end of the child. Returns the number of
/// cases that began.
fn follow(
    child: &mut Child,
    limit: Duration,
    deadline: Option<Instant>,
    report: &mut dyn FnMut(Seen),
) -> u64 {
    let receive = lines(child);
    let errors = errors(child);
    let (mut begun, mut current): (u64, Option<(Place, Instant)>) = (0, None);
    while current.is_some() || deadline.is_none_or(|deadline| Instant::now() < deadline) {
        let wait = current.map_or(limit, |(_, since)| limit.saturating_sub(since.elapsed()));
        let line = match receive.recv_timeout(wait) {
            Ok(line) => line,
            Err(RecvTimeoutError::Disconnected) => break,
            Err(RecvTimeoutError::Timeout) => {
                if let Some((place, since)) = current.take() {
                    report(Seen {
                        place,
                        kind: "hang".into(),
                        text: format!("not done in {limit:?}"),
                        time: since.elapsed(),
                    });
                }
                break;
            }
        };
        let mut words = line.splitn(3, ' ');
        let [first, second, third] =
            [words.next(), words.next(), words.next()].map(|word| word.unwrap_or_default());
        match (first, current) {
            ("B", _) => {
                begun += 1;
                let place = Place { target: second.parse().unwrap_or(0), index: third.parse().unwrap_or(0) };
                current = Some((place, Instant::now()));
            }
            ("E", Some((place, since))) => {
                report(Seen { place, kind: second.into(), text: third.into(), time: since.elapsed() });
                current = None;
            }
            _ => {}
        }
    }
    let _ = child.kill();
    let status = child.wait().map_or_else(|error| error.to_string(), |status| status.to_string());
    let said = errors.join().unwrap_or_default();
    match current {
        Some((place, since)) => report(Seen {
            place,
            kind: "abort".into(),
            text: format!("{status}: {said}"),
            time: since.elapsed(),
        }),
        None if said.is_empty() => {}
        None => eprintln!("{said}"),
    }
    begun
}

/// The part of all cases that one sequence of children runs.
#[derive(Clone, Copy, Debug)]
pub struct Share {
    pub seed: u64,
    pub order: Order,
    pub number: u64,
    pub of: u64,
}

/// Runs a share of all cases until the deadline.
pub fn run(
    share: Share,
    limit: Duration,
    deadline: Instant,
    report: &mut dyn FnMut(Seen),
) -> std::io::Result<()> {
    let Share { seed, order, number, of } = share;
    let (mut block, mut done) = (number, 0);
    while Instant::now() < deadline {
        let only = order.only.map_or_else(|| "-".into(), |target| target.to_string());
        let arguments =
            ["--child".into(), seed.to_string(), only, block.to_string(), of.to_string(), done.to_string()];
        done += follow(&mut start(&arguments)?, limit, Some(deadline), report);
        while done >= order.batch(block) {
            done -= order.batch(block);
            block += of;
        }
    }
    Ok(())
}

/// Runs one case by name; the child prints its values.
pub fn again(seed: u64, place: Place, limit: Duration, report: &mut dyn FnMut(Seen)) -> std::io::Result<()> {
    let arguments = ["--single".into(), seed.to_string(), place.target.to_string(), place.index.to_string()];
    follow(&mut start(&arguments)?, limit, None, report);
    Ok(())
}
