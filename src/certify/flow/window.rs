//! The motion over several crossings in an unknown order.

use crate::certify::flow::algebra::{Algebra, Coefficients, On};
use crate::certify::flow::continuity::is_continuous;
use crate::certify::flow::field::{Drives, Field};
use crate::certify::flow::leg::{Image, Leg};
use crate::certify::flow::part::{Part, Seen};
use crate::certify::flow::signs::{EdgeForm, edges, instant, keeps_sign, keeps_sign_up_to, stays};
use crate::certify::flow::stretch::{Stretch, Until};
use crate::certify::square::Square;
use crate::certify::unproved::Unproved;
use crate::contact::Piece;
use crate::interval::number::Interval;

/// Margins of a window on both sides in its attempts, as shares of its width on the pieces before `[1]`.
const MARGINS: [f64; 4] = [0.5, 4.0, 64.0, 1024.0];

/// Width that is added to a window, as a share of the leg `[1]`.
const LEAST: f64 = 1e-13;

/// The enclosure of a window grows by this share of its size from one attempt to the next `[1]`.
const INFLATION: f64 = 0.1;
const ATTEMPTS: usize = 6;

/// The motion from a box over a short time, with contacts on either of two pieces and its derivatives.
///
/// Every acceleration and every slope is the hull over both pieces. The motion lies in B if X + [0, w] F(B) ⊂
/// B, and at the end in q + w v + w²/2 A(B), v + w A(B).
struct Window<'f, 'm> {
    field: &'f Field<'m>,
    on: On<'f>,
    time: Interval,
    inside: f64,
    start: Vec<Interval>,
    width: Interval,
    /// Coefficients of orders 0 and 1 over the enclosure of the whole window.
    during: Coefficients,
}

impl<'f, 'm> Window<'f, 'm> {
    fn new(
        field: &'f Field<'m>,
        on: On<'f>,
        (time, inside): (Interval, f64),
        x: &[Interval],
        width: Interval,
    ) -> Option<Self> {
        let start = field.with_columns(x, &Square::identity(2 * field.n));
        let span = Interval::of_ends(0.0, width.high());
        let u = drives(field, (time, inside), width);
        let mut guess = start.clone();
        for _ in 0..ATTEMPTS {
            if !guess.iter().all(|x| x.is_bounded()) {
                return None;
            }
            let during = field.tangent.expand(on, &guess, &u, 1);
            let whole = start.iter().enumerate().map(|(i, x)| *x + span * during.slot(i, 1));
            let whole: Vec<Interval> = whole.collect();
            if whole.iter().zip(&guess).all(|(x, guess)| x.lies_in(*guess)) {
                return Some(Window { field, on, time, inside, start, width, during });
            }
            let room = |(x, start): (Interval, &Interval)| {
                let moved = (x.high() - start.high()).abs().max((start.low() - x.low()).abs());
                x + Interval::symmetric(INFLATION * moved + f64::EPSILON * x.magnitude() + f64::MIN_POSITIVE)
            };
            guess = whole.into_iter().zip(&start).map(room).collect();
        }
        None
    }

    /// Coordinates and velocities over the whole window.
    fn box_of_all(&self) -> Vec<Interval> {
        (0..2 * self.field.n).map(|i| self.during.slot(self.field.place(i, 0), 0)).collect()
    }

    /// What becomes of a number in the slot of a coordinate or velocity of the tangent tape that starts with
    /// the value `x` and, for a coordinate, the rate `v`.
    fn end(&self, slot: usize, x: Interval, v: Interval) -> Interval {
        let (all, w) = (self.field.tangent.tape.dof, self.width);
        match slot < all {
            true => x + v * w + self.during.slot(all + slot, 1) * (w * w * 0.5),
            false => x + self.during.slot(slot, 1) * w,
        }
    }
    /// The states at the end from narrower ones at the start.
    fn state(&self, x: &[Interval]) -> Vec<Interval> {
        let n = self.field.n;
        let rate = |i: usize| if i < n { x[n + i] } else { Interval::ZERO };
        (0..2 * n).map(|i| self.end(self.field.place(i, 0), x[i], rate(i))).collect()
    }
    /// The derivative of the end with respect to the start.
    fn slope(&self) -> Square {
        let n = self.field.n;
        Square::from_fn(2 * n, |i, j| {
            let of = |i: usize| self.start[self.field.place(i, 1 + j)];
            let rate = if i < n { of(n + i) } else { Interval::ZERO };
            self.end(self.field.place(i, 1 + j), of(i), rate)
        })
    }
}

impl Part for Window<'_, '_> {
    fn start(&self) -> Interval {
        self.time
    }
    fn until(&self) -> Interval {
        self.width
    }
    fn pieces(&self, contact: usize) -> [Piece; 2] {
        self.on.pieces(contact)
    }
    fn series(&self) -> Vec<Vec<Interval>> {
        self.box_of_all().into_iter().map(|x| vec![x]).collect()
    }
    fn series_of(&self, other: &Algebra) -> Vec<Vec<Interval>> {
        let u = drives(self.field, (self.time, self.inside), self.width);
        let c = other.expand(self.on, &self.box_of_all(), &u, 0);
        other.tape.distances.iter().filter_map(|both| both[0]).map(|form| vec![c.form(form, 0)]).collect()
    }
}

/// The drives over a window.
fn drives(field: &Field<'_>, (time, inside): (Interval, f64), width: Interval) -> Drives {
    let span = Interval::of_ends(0.0, width.high());
    field.drive_series(time + span, inside, 3)
}

/// The image of a box over several crossings that are not ordered, all within one window [a, b].
///
/// Each of these contacts is before its edge at a and beyond it at b, and its rate excludes 0 in the window:
/// it crosses once. Since the forces are continuous at these edges, the flow is differentiable whatever the
/// order of the crossings is, and its derivative is the solution of the variational equation on the pieces
/// of each instant.
pub(crate) fn together(
    field: &Field<'_>,
    leg: &Leg,
    x: &[Interval],
    m: &[Interval],
    seen: &mut Seen<'_>,
) -> Result<Image, Unproved> {
    let (start, after) = (leg.start.middle(), leg.pieces_after());
    let length = (leg.end - leg.start).high();
    let abouts = || leg.crossings.iter().map(|crossing| crossing.near - start);
    let (first, last) = (abouts().fold(f64::INFINITY, f64::min), abouts().fold(f64::NEG_INFINITY, f64::max));
    let unordered = Unproved::Together { t: start + first, after: start + last };
    let repeated = (1..leg.crossings.len())
        .any(|i| leg.crossings[..i].iter().any(|crossing| crossing.contact == leg.crossings[i].contact));
    let inside = leg
        .crossings
        .iter()
        .all(|crossing| leg.start.high() < crossing.near && crossing.near < leg.end.low());
    if !inside || repeated || leg.crossings.iter().any(|crossing| crossing.rebounds) {
        return Err(unordered);
    }
    let on = On::either(&leg.pieces, &after);
    let reach = last + 0.5 * first.min(length - last);
    let before = Stretch::new(field, &leg.pieces, (leg.start, leg.inside()), x, reach)?;
    let mut crossed: Vec<EdgeForm> = Vec::new();
    let mut window: Option<Interval> = None;
    for crossing in &leg.crossings {
        let grazing = Unproved::NearGrazing { contact: crossing.contact, t: crossing.near };
        let edge = EdgeForm::of(field, &leg.pieces, crossing).ok_or(grazing.clone())?;
        let own = field.motion.tape.distances[crossing.contact][edge.edge as usize].ok_or(grazing.clone())?;
        if !is_continuous(&field.motion.tape, on, crossing.contact, own) {
            return Err(Unproved::Jumps { contact: crossing.contact, t: crossing.near });
        }
        let (_, at) = instant(&before, &edge, crossing.near - start).ok_or(grazing)?;
        window = Some(window.map_or(at, |window| window.hull(at)));
        crossed.push(edge);
    }
    let Some(window) = window else { return Err(unordered) };
    let mut failure = unordered.clone();
    for margin in MARGINS {
        let room = margin * (window.width() + LEAST * length);
        let (a, b) = (window.low() - room, window.high() + room);
        if a <= 0.0 || b >= reach || (leg.end - (leg.start + Interval::from(b))).low() <= 0.0 {
            return Err(unordered);
        }
        match through(&before, leg, m, on, &crossed, [a, b], seen) {
            Ok(image) => return Ok(image),
            Err(error) => failure = error,
        }
    }
    Err(failure)
}

/// The image of a box by way of the window [a, b].
fn through(
    before: &Stretch<'_, '_>,
    leg: &Leg,
    m: &[Interval],
    on: On<'_>,
    crossed: &[EdgeForm],
    [a, b]: [f64; 2],
    seen: &mut Seen<'_>,
) -> Result<Image, Unproved> {
    let (field, after) = (before.field, leg.pieces_after());
    let others = |pieces| edges(field, pieces).filter(|edge| !crossed.iter().any(|own| own.is_on(edge)));
    crossed.iter().try_for_each(|edge| keeps_sign_up_to(before, edge, a))?;
    others(&leg.pieces).try_for_each(|edge| keeps_sign(before, &edge, 0.0, a))?;
    let [at, until] = [a, b].map(Interval::from);
    let (time, next, width) = (leg.start + at, leg.start + until, until - at);
    let wrapping = Unproved::Wrapping { t: time.middle(), length: width.high() };
    let state = before.state(at);
    let window = Window::new(field, on, (time, leg.inside()), &state, width).ok_or(wrapping)?;
    let grazing = |edge: &EdgeForm| Unproved::NearGrazing { contact: edge.contact, t: time.middle() };
    for edge in crossed {
        if (window.during.form(edge.form, 1) * edge.sign).high() >= 0.0 {
            return Err(grazing(edge));
        }
    }
    for edge in others(&leg.pieces).chain(others(&after)) {
        if (window.during.form(edge.form, 0) * edge.sign).low() <= 0.0 {
            return Err(Unproved::Leaves { contact: edge.contact, t: time.middle() });
        }
    }
    let second =
        Stretch::new(field, &after, (next, leg.inside()), &window.state(&state), (leg.end - next).high())?;
    for edge in crossed {
        if (second.distance(edge.form, Interval::ZERO) * edge.sign).high() >= 0.0 {
            return Err(grazing(edge));
        }
    }
    stays(&second, &after, second.length, crossed)?;
    let rest = leg.end - next;
    seen(&Until(before, at));
    seen(&window);
    seen(&Until(&second, rest));
    let middle = window.state(&before.narrow(leg.start, m).state(at));
    Ok(Image {
        middle: second.narrow(next, &middle).state(rest),
        slope: second.slope(rest).times(&window.slope().times(&before.slope(at))),
        crossing: Some(time.hull(next)),
    })
}
