//! The child process: runs cases one after the other and prints the result of each.

use crate::case::{Case, Stop};
use crate::targets::TARGETS;
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook};
use std::sync::Mutex;

static PANIC: Mutex<String> = Mutex::new(String::new());

/// The place of a case: its target and its index there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    pub target: usize,
    pub index: u64,
}

/// The order of the cases: blocks of consecutive cases of one target.
#[derive(Clone, Copy, Debug)]
pub struct Order {
    /// Only the cases of this target.
    pub only: Option<usize>,
}

impl Order {
    fn target(self, n: u64) -> usize {
        self.only.unwrap_or((n % TARGETS.len() as u64) as usize)
    }
    /// Number of cases in block `n`: larger for targets with short cases.
    pub fn batch(self, n: u64) -> u64 {
        TARGETS[self.target(n)].batch
    }
    /// The cases of block `n`. The blocks belong to the targets in turn.
    fn block(self, n: u64) -> impl Iterator<Item = Place> {
        let (target, batch) = (self.target(n), self.batch(n));
        let turn = if self.only.is_some() { n } else { n / TARGETS.len() as u64 };
        (turn * batch..(turn + 1) * batch).map(move |index| Place { target, index })
    }
}

/// Runs a case. Prints `B target index` before it and `E kind text` after it on standard output.
fn one(seed: u64, place: Place, verbose: bool) -> std::io::Result<()> {
    let target = &TARGETS[place.target];
    let mut out = std::io::stdout().lock();
    writeln!(out, "B {} {}", place.target, place.index)?;
    out.flush()?;
    let mut case = Case::new(seed, target.name, place.index, verbose);
    let (kind, text) = match catch_unwind(AssertUnwindSafe(|| (target.run)(&mut case))) {
        Ok(Ok(())) => case.refused().map_or(("finite", String::new()), |text| ("typed", text)),
        Ok(Err(Stop::Typed(text))) => ("typed", text),
        Ok(Err(Stop::NotFinite(text))) => ("non-finite", text),
        Ok(Err(Stop::Broken(text))) => ("broken", text),
        Err(_) => ("panic", PANIC.lock().map_or_else(|_| String::new(), |text| text.clone())),
    };
    let short: String = text.replace('\n', " ").chars().take(400).collect();
    writeln!(out, "E {kind} {short}")?;
    out.flush()
}

fn keep_panics() {
    set_hook(Box::new(|info| {
        if let Ok(mut text) = PANIC.lock() {
            *text = info.to_string();
        }
    }));
}

/// Runs every `stride`-th block from `first` on, without its first `skip` cases, until the parent ends this
/// process.
pub fn work(seed: u64, order: Order, first: u64, stride: u64, skip: u64) -> std::io::Result<()> {
    keep_panics();
    let mut skip = skip as usize;
    for n in (first..).step_by(stride as usize) {
        for place in order.block(n).skip(std::mem::take(&mut skip)) {
            one(seed, place, false)?;
        }
    }
    Ok(())
}

/// Runs one case by name and prints its values.
pub fn single(seed: u64, place: Place) -> std::io::Result<()> {
    keep_panics();
    one(seed, place, true)
}
