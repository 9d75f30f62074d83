//! Random search: random models of the crate, each with an independent check of an answer of the crate.
//!
//! `cargo run --release -p search -- SEED SECONDS` draws models for the given time. It prints every case in
//! which an answer and its check disagree, with the command that repeats it, and a table of counts. The exit
//! code is 1 if there is such a case. Options:
//!
//! - `--only CHECK` restricts the run to one check;
//! - `--cases N` makes N cases of each check, whatever time that takes;
//! - `--case CHECK:INDEX` makes one case again and prints its values.
//!
//! A case that runs for more than ten minutes counts as a hang and ends the search.
//!
//! A model without what the check compares is drawn again. The column `of models %` is the share of such
//! models. The exit code is 1, too, if more than 5 % of the cases of a check find no model in 16 draws, or if
//! fewer than one model in four has what the check compares, by more than chance.
//!
//! A case is a function of seed, check and index alone.

pub mod checks;
pub mod draw;
pub mod models;
pub mod reference;

use draw::Draw;

/// How a case ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// The answer and its check agree.
    Agrees,
    /// There was nothing to compare, with the reason: for example, the motion does not settle.
    Skipped(&'static str),
    /// The answer and its check disagree, or an answer was refused.
    Fails(String),
}

/// Fails with a text that is only made when it is needed.
pub fn agree(holds: bool, what: impl FnOnce() -> String) -> Outcome {
    if holds { Outcome::Agrees } else { Outcome::Fails(what()) }
}

/// One kind of check.
pub struct Check {
    /// Its name.
    pub name: &'static str,
    /// Draws a model and compares an answer of the crate with its check.
    pub run: fn(&mut Draw) -> Outcome,
}

/// Number of models that a case draws until one has what the check compares.
const DRAWS: usize = 16;

impl Check {
    /// Makes case `index`, and the reasons for which models of it were drawn again. A panic is a failure.
    pub fn case(&self, seed: u64, index: u64, verbose: bool) -> (Outcome, Vec<&'static str>) {
        let mut draw = Draw::new(seed, self.name, index, verbose);
        let mut again = Vec::new();
        loop {
            match self.drawn(&mut draw) {
                Outcome::Skipped(why) if again.len() + 1 < DRAWS => again.push(why),
                outcome => return (outcome, again),
            }
        }
    }
    /// The next model of a case.
    fn drawn(&self, draw: &mut Draw) -> Outcome {
        let made = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| (self.run)(draw)));
        made.unwrap_or_else(|panic| {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            let text = text.or(panic.downcast_ref::<&str>().copied()).unwrap_or("no text");
            Outcome::Fails(format!("panic: {text}"))
        })
    }
}
