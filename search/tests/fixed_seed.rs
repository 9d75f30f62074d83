//! Some hundred random cases with a fixed seed: none fails.

use search::Outcome;
use search::checks::all;

const SEED: u64 = 7;

/// Numbers of cases, many of the fast checks. The slow ones run by the command of the crate alone.
const CASES: [(&str, u64); 50] = [
    ("integrators-of-pairs", 10),
    ("integrators-of-stages", 4),
    ("integrators-of-chains", 3),
    ("slopes-of-chains", 20),
    ("flow-of-chains", 3),
    ("lanes-of-chains", 2),
    ("lanes-of-pairs", 2),
    ("lanes-of-sets", 1),
    ("lanes-of-stages", 1),
    ("closing-of-pairs", 12),
    ("closing-of-sets", 1),
    ("derivatives-of-pairs", 5),
    ("derivatives-of-stages", 2),
    ("balance-of-pairs", 5),
    ("conserved", 10),
    ("cuts-of-lines", 1),
    ("symmetric-coordinates", 3),
    ("symmetric-solvers", 2),
    ("symmetric-methods", 1),
    ("stability-of-pairs", 3),
    ("stability-of-stages", 1),
    ("infinity-of-pairs", 3),
    ("infinity-of-lines", 1),
    ("reference-of-engines", 6),
    ("reference-of-forms", 6),
    ("reference-of-drives", 10),
    ("reference-of-stops", 5),
    ("steep-forces", 2),
    ("powers-from-rest", 4),
    ("powers-as-drives", 10),
    ("cancelling-waves", 10),
    ("reference-of-wide-gaps", 2),
    ("closed-far-flanks", 2),
    ("closed-stiffness", 20),
    ("closed-densities", 1),
    ("closed-rows-of-balls", 10),
    ("closed-late-times", 8),
    ("closed-tori", 5),
    ("closed-run-ups", 10),
    ("closed-wound-chains", 4),
    ("settled-flights", 10),
    ("reference-of-ensembles", 5),
    ("reference-of-processes", 5),
    ("reference-of-tables", 5),
    ("reference-of-waterfalls", 5),
    ("closed-noisy-ends", 1),
    ("closed-normal-processes", 20),
    ("closed-jittered-orders", 10),
    ("closed-shot-noise", 10),
    ("closed-spectra", 20),
];

/// Makes the cases of every second check.
fn none_fails(part: usize) {
    for (name, cases) in CASES.into_iter().skip(part).step_by(2) {
        let check = all().find(|check| check.name == name);
        let check = check.unwrap_or_else(|| panic!("there is no check {name}"));
        for index in 0..cases {
            let (outcome, again) = check.case(SEED, index, false);
            assert_eq!(outcome, Outcome::Agrees, "{name}:{index}, drawn again: {again:?}");
        }
    }
}

#[test]
fn no_case_of_the_first_checks_fails() {
    none_fails(0);
}

#[test]
fn no_case_of_the_other_checks_fails() {
    none_fails(1);
}

/// Cases of other seeds that have failed: two period doublings within a twentieth of a step that begins with a grazing; a
/// motion of 3e-11 rad about 4e-4 rad, in which corrections are rounding; a branch that passes beside its first point after a
/// fold; an exponential that overflows in lanes; a dimple of a motion within a part of a step that grazes an edge with both
/// of its extremes; a fold 4e-5 rad/s beside a crossing of branches; branches of doubled orbits that turn back at a crossing;
/// two grazings between which another contact sequence begins; a power of 0.22 whose argument is a rounding error at the end of
/// a step of `Taylor`; a window of stability within a step; a step that ends on the edge of a power of 1.93; motions that just
/// touch an edge and a stop; branches that cross the orbits with equal planets; large motions that come close to a symmetry
/// in time; folds beside a crossing at which a branch is almost vertical; a transient that turns slowly from period to period; a
/// swing of rounding errors of the coordinates; a hump of a high power that begins with zero, and one beside a saddle.
#[test]
fn cases_that_failed_agree() {
    let cases = [
        (900412, "short-steps-of-stages", 53),
        (900412, "symmetric-methods", 58),
        (20261127, "short-steps-of-pairs", 23),
        (20261127, "steep-forces", 45),
        (20262001, "short-steps-of-pairs", 61),
        (20262004, "short-steps-of-sets", 16),
        (20262102, "short-steps-of-pairs", 569),
        (20262211, "integrators-of-chains", 61),
        (20262342, "short-steps-of-pairs", 558),
        (20262322, "infinity-of-pairs", 43),
        (20262342, "reference-of-engines", 242),
        (20262342, "stability-of-sets", 738),
        (20262362, "integrators-of-chains", 293),
        (20262362, "reference-of-stops", 110),
        (20262362, "stability-of-sets", 129),
        (20262372, "infinity-of-pairs", 0),
        (20262372, "short-steps-of-pairs", 235),
        (20262372, "short-steps-of-stages", 243),
        (20262381, "closed-wound-chains", 415),
        (20262381, "symmetric-methods", 196),
        (20262382, "reference-of-forms", 290),
        (20262391, "short-steps-of-pairs", 296),
        (20262422, "short-steps-of-stages", 281),
        (20262431, "stability-of-stages", 75),
        (20262451, "powers-from-rest", 45),
        (20262452, "short-steps-of-stages", 148),
        (20262461, "powers-from-rest", 18),
        (20262491, "integrators-of-chains", 11),
        (20262492, "integrators-of-chains", 144),
        (7771, "short-steps-of-pairs", 159),
        (7771, "short-steps-of-pairs", 1737),
        (7771, "short-steps-of-pairs", 4681),
        (7771, "short-steps-of-pairs", 4722),
        (9991, "short-steps-of-pairs", 713),
        (9992, "short-steps-of-pairs", 4),
        (9992, "short-steps-of-pairs", 649),
    ];
    for (seed, name, index) in cases {
        let case = all().find(|check| check.name == name).map(|check| check.case(seed, index, false));
        assert_eq!(case.map(|(outcome, _)| outcome), Some(Outcome::Agrees), "{name}:{index}");
    }
}
