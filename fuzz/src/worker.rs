//! The child process: runs cases one after the other and says what came of each.

use crate::case::{Case, Stop};
use crate::targets::TARGETS;
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook};
use std::sync::Mutex;

static PANIC: Mutex<String> = Mutex::new(String::new());

/// Where a case stands among all: its target and its index there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    pub target: usize,
    pub index: u64,
}

/// In which order cases come: block after block, each of one target.
#[derive(Clone, Copy, Debug)]
pub struct Order {
    /// Only the cases of this target.
    pub only: Option<usize>,
}

impl Order {
    fn target(self, n: u64) -> usize {
        self.only.unwrap_or((n % TARGETS.len() as u64) as usize)
    }
    /// How many cases block `n` has: a cheap target has many at a time.
    pub fn batch(self, n: u64) -> u64 {
        TARGETS[self.target(n)].batch
    }
    /// Targets take turns.
    fn block(self, n: u64) -> impl Iterator<Item = Place> {
        let (target, batch) = (self.target(n), self.batch(n));
        let turn = if self.only.is_some() { n } else { n / TARGETS.len() as u64 };
        (turn * batch..(turn + 1) * batch).map(move |index| Place { target, index })
    }
}

/// Says `B target index` before a case and `E kind text` after it, on standard output.
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

/// Every `stride`-th block from `first` on, less its first `skip` cases, until the parent ends this process.
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

/// One case by name, telling what it uses.
pub fn single(seed: u64, place: Place) -> std::io::Result<()> {
    keep_panics();
    one(seed, place, true)
}
