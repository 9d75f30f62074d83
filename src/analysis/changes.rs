//! Changes of the state from period to period: whether they shrink, how fast, and what is left of them.

/// Number of changes in a window. The largest change of the last window is compared with that of the window
/// before.
const RECENT: usize = 4;

/// Largest ratio of these two for a change that shrinks: 0.9 a period. Changes that are made of rounding
/// errors reach it by chance now and then, and the run takes a further period.
const SHRINKS: f64 = 0.65;

/// Number of changes in each of the two windows that show a slow decay. As many changes lie between them.
/// With [`SHRINKS`] they show a decay of up to 0.97 a period.
const SLOW: usize = 8;

/// Whether the change from period to period shrinks. The first entry of `changes` is that of the last period.
///
/// Near a resonance the change oscillates while it decays. The short windows then miss the decay, and the
/// long ones show it.
pub(crate) fn shrinks(changes: &[f64]) -> bool {
    let largest = |changes: &[f64]| changes.iter().copied().fold(0.0, f64::max);
    let recent = &changes[..changes.len().min(2 * RECENT)];
    let (late, early) = recent.split_at(recent.len() / 2);
    let slowly = changes
        .get(2 * SLOW..3 * SLOW)
        .is_some_and(|early| largest(&changes[..SLOW]) < SHRINKS * largest(early));
    slowly || largest(late) < SHRINKS * largest(early)
}

/// The mean factor from one change to the next one: from the largest of the last four to the largest of the
/// four before, or of the last eight of which it is below 1, since changes that are made of rounding errors
/// shrink and grow. Of a transient that beats, single changes are small by chance; the largest are not.
///
/// The factor is at least the mean factor over the last 24 changes: from the largest of the first eight to
/// the largest of the last eight. A transient that turns slowly from period to period shrinks faster than it
/// decays for some periods.
pub(crate) fn contraction(changes: &[f64]) -> f64 {
    let largest = |changes: &[f64]| changes.iter().copied().fold(0.0, f64::max);
    let window = RECENT.min(changes.len() / 2).max(1);
    let of = |j: usize| largest(&changes[j..j + window]);
    let mut factors = (0..(changes.len() + 1).saturating_sub(2 * window))
        .map(|j| (of(j) / of(j + window)).powf(1.0 / window as f64));
    let last = factors.next().unwrap_or(f64::NAN);
    let last = if last < 1.0 { last } else { factors.find(|factor| *factor < 1.0).unwrap_or(last) };
    let slow = changes
        .get(2 * SLOW..3 * SLOW)
        .map(|early| (largest(&changes[..SLOW]) / largest(early)).powf(0.5 / SLOW as f64));
    slow.filter(|slow| *slow < 1.0).map_or(last, |slow| last.max(slow))
}

/// The last change, or what is left of a change before it that shrinks with the factor `contraction`, if
/// that is larger. Of a transient that beats, the last change is small by chance.
pub(crate) fn envelope(changes: &[f64], contraction: f64) -> f64 {
    let left = changes.iter().take(RECENT).zip(0..).map(|(change, j)| change * contraction.min(1.0).powi(j));
    left.fold(0.0, f64::max)
}

/// Estimate of the distance from the orbit from the last change and the factor from one change to the next.
pub(crate) fn distance(change: f64, contraction: f64) -> f64 {
    match (change, contraction) {
        (0.0, _) => 0.0,
        (change, mu) if mu < 1.0 => change * mu / (1.0 - mu),
        _ => f64::INFINITY,
    }
}
