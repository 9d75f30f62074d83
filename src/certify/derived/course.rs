//! The course of a certified orbit: enclosed polynomials over its stretches.

use crate::certify::flow::part::Part;
use crate::interval::number::Interval;

/// A stretch of the orbit: coordinates, then velocities, as enclosed polynomials in the time after its start.
pub(crate) struct BoxCourse {
    pub(crate) start: Interval,
    /// The time after the start at which the stretch ends.
    pub(crate) until: Interval,
    series: Vec<Vec<Interval>>,
}

impl BoxCourse {
    pub(crate) fn new(part: &dyn Part) -> Self {
        BoxCourse { start: part.start(), until: part.until(), series: part.series() }
    }
    /// A component at the time s after the start.
    fn value(&self, component: usize, s: Interval) -> Interval {
        self.series[component].iter().rev().fold(Interval::ZERO, |sum, c| sum * s + *c)
    }
    fn rate(&self, component: usize, s: Interval) -> Interval {
        let terms = self.series[component].iter().enumerate().skip(1).rev();
        terms.fold(Interval::ZERO, |sum, (k, c)| sum * s + *c * k as f64)
    }
}

/// Largest minus least value of a component over all stretches.
pub(crate) fn peak_to_peak(courses: &[BoxCourse], component: usize) -> Interval {
    let [most, least] = [1.0, -1.0].map(|sign| largest(courses, component, sign));
    most + least
}

/// The largest value of a component multiplied by `sign`, by bisection of all parts in which it may lie.
fn largest(courses: &[BoxCourse], component: usize, sign: f64) -> Interval {
    let value = |course: &BoxCourse, s: Interval| course.value(component, s) * sign;
    let reached = courses.iter().map(|course| value(course, Interval::ZERO).low());
    let mut low = reached.fold(f64::NEG_INFINITY, f64::max);
    let mut high = low;
    let mut open: Vec<(&BoxCourse, f64, f64)> =
        courses.iter().map(|course| (course, 0.0, course.until.high())).collect();
    while let Some((course, a, b)) = open.pop() {
        let part = Interval::of_ends(a, b);
        let middle = part.middle();
        let at = value(course, Interval::from(middle));
        let rate = course.rate(component, part) * sign;
        let around = at + rate * (part - Interval::from(middle));
        let upper = around.high().min(value(course, part).high());
        if upper <= low {
            continue;
        }
        if middle <= course.until.low() {
            low = low.max(at.low());
        }
        // Smaller parts bring no more than the width at one instant.
        let excess = upper - at.high();
        if excess.is_nan() || excess <= at.width() || middle <= a || middle >= b {
            high = high.max(upper);
            continue;
        }
        open.push((course, a, middle));
        open.push((course, middle, b));
    }
    Interval::of_ends(low, high.max(low))
}

/// The state at a time, from all stretches that may contain it; `None` if there is none.
pub(crate) fn state_at(courses: &[BoxCourse], period: Interval, t: Interval) -> Option<Vec<Interval>> {
    let from = courses.first()?.start;
    let turns = ((t - from) / period).middle().floor();
    let mut all: Option<Vec<Interval>> = None;
    // At an end of the turn rounding may move the time to the turn before or after.
    for turn in [turns - 1.0, turns, turns + 1.0] {
        let inside = t - period * turn;
        for course in courses {
            let since = Interval::of_ends(0.0, course.until.high());
            let Some(s) = (inside - course.start).common(since) else { continue };
            let here = (0..course.series.len()).map(|i| course.value(i, s));
            all = Some(match all {
                None => here.collect(),
                Some(all) => all.into_iter().zip(here).map(|(x, here)| x.hull(here)).collect(),
            });
        }
    }
    all
}
