//! Some hundred random cases with a fixed seed: none fails.

use search::Outcome;
use search::checks::all;

const SEED: u64 = 7;

/// Numbers of cases, many of the fast checks. The slow ones run by the command of the crate alone.
const CASES: [(&str, u64); 14] = [
    ("integrators-of-pairs", 25),
    ("integrators-of-stages", 5),
    ("closing-of-pairs", 30),
    ("closing-of-sets", 1),
    ("derivatives-of-pairs", 12),
    ("derivatives-of-stages", 2),
    ("balance-of-pairs", 12),
    ("conserved", 25),
    ("cuts-of-lines", 1),
    ("symmetric-coordinates", 4),
    ("stability-of-pairs", 3),
    ("infinity-of-pairs", 3),
    ("stability-of-stages", 1),
    ("symmetric-solvers", 2),
];

/// Makes the cases of every second check.
fn none_fails(part: usize) {
    let mut agree = 0;
    for (name, cases) in CASES.into_iter().skip(part).step_by(2) {
        let check = all().find(|check| check.name == name);
        let check = check.unwrap_or_else(|| panic!("there is no check {name}"));
        for index in 0..cases {
            match check.case(SEED, index, false) {
                Outcome::Agrees => agree += 1,
                Outcome::Skipped(_) => {}
                Outcome::Fails(what) => panic!("{name}:{index} {what}"),
            }
        }
    }
    assert!(agree > 35, "{agree} cases agree");
}

#[test]
fn no_case_of_the_first_checks_fails() {
    none_fails(0);
}

#[test]
fn no_case_of_the_other_checks_fails() {
    none_fails(1);
}
