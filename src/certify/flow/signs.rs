//! The signs of distances along a stretch: which contacts stay on their pieces, and when one leaves.

use crate::certify::flow::field::Field;
use crate::certify::flow::leg::LegCrossing;
use crate::certify::flow::stretch::Stretch;
use crate::certify::unproved::Unproved;
use crate::contact::Piece;
use crate::contact::edge::Edge;
use crate::interval::number::Interval;
use crate::tape::operations::FormId;

/// An edge at which a contact leaves its piece.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EdgeForm {
    pub(crate) contact: usize,
    pub(crate) edge: Edge,
    /// The distance in the tangent tape.
    pub(crate) form: FormId,
    /// Sign of the distance on the piece.
    pub(crate) sign: f64,
}

impl EdgeForm {
    /// The edge of a contact on the piece `from`; `None` if it is infinite.
    fn new(field: &Field<'_>, contact: usize, from: Piece, edge: Edge) -> Option<Self> {
        let form = field.tangent.tape.distances[contact][edge as usize]?;
        Some(EdgeForm { contact, edge, form, sign: from.gap_sign() })
    }
    /// The edge of a crossing: that of the flank which the contact leaves or enters.
    pub(crate) fn of(field: &Field<'_>, pieces: &[Piece], crossing: &LegCrossing) -> Option<Self> {
        let from = pieces[crossing.contact];
        EdgeForm::new(field, crossing.contact, from, Edge::between(from, crossing.to))
    }
    pub(crate) fn is_on(&self, other: &EdgeForm) -> bool {
        (self.contact, self.edge) == (other.contact, other.edge)
    }
}

/// Smallest part of a stretch in which a sign is decided `[1]`.
const SMALLEST_PART: f64 = 1e-7;

/// Number of spans that are tried around a crossing or beside one, each a quarter of the one before.
const SPANS: usize = 14;

/// Newton steps for the instant of a crossing.
const REFINEMENTS: usize = 6;

/// The edges at which contacts leave their pieces.
pub(crate) fn edges<'t>(field: &'t Field<'_>, pieces: &'t [Piece]) -> impl Iterator<Item = EdgeForm> + 't {
    pieces.iter().enumerate().flat_map(move |(contact, &piece)| {
        Edge::around(piece).iter().filter_map(move |&edge| EdgeForm::new(field, contact, piece, edge))
    })
}

/// Proves that a distance keeps its sign over the times [a, b] after the start.
pub(crate) fn keeps_sign(stretch: &Stretch<'_, '_>, edge: &EdgeForm, a: f64, b: f64) -> Result<(), Unproved> {
    let &EdgeForm { contact, form, sign, .. } = edge;
    let mut open = vec![(a, b)];
    while let Some((a, b)) = open.pop() {
        let part = Interval::of_ends(a, b);
        let middle = part.middle();
        let around = stretch.distance(form, Interval::from(middle))
            + stretch.rate(form, part) * (part - Interval::from(middle));
        let value = around.common(stretch.distance(form, part)).unwrap_or(around) * sign;
        if value.low() > 0.0 {
            continue;
        }
        // A part of two neighbouring numbers has no middle.
        if b - a <= SMALLEST_PART * stretch.length || middle <= a || middle >= b {
            return Err(Unproved::Leaves { contact, t: stretch.time.middle() + middle });
        }
        open.push((a, middle));
        open.push((middle, b));
    }
    Ok(())
}

/// Proves that all contacts stay on their pieces up to the time `until` after the start. `rising`: edges at
/// which contacts start, or a little beyond, and from which they move away.
pub(crate) fn stays(
    stretch: &Stretch<'_, '_>,
    pieces: &[Piece],
    until: f64,
    rising: &[EdgeForm],
) -> Result<(), Unproved> {
    for edge in edges(stretch.field, pieces) {
        let mut from = 0.0;
        if rising.iter().any(|other| other.is_on(&edge)) {
            let rises =
                |from: f64| (stretch.rate(edge.form, Interval::of_ends(0.0, from)) * edge.sign).low() > 0.0;
            let near = || {
                let t = stretch.time.middle();
                Unproved::NearGrazing { contact: edge.contact, t }
            };
            from = spans(until).find(|from| rises(*from)).ok_or_else(near)?;
        }
        keeps_sign(stretch, &edge, from, until)?;
    }
    Ok(())
}

/// Proves that a distance keeps its sign up to a time `until` at which it has it, near a crossing.
pub(crate) fn keeps_sign_up_to(
    stretch: &Stretch<'_, '_>,
    edge: &EdgeForm,
    until: f64,
) -> Result<(), Unproved> {
    let &EdgeForm { contact, form, sign, .. } = edge;
    let grazing = Unproved::NearGrazing { contact, t: stretch.time.middle() + until };
    let falls = |from: f64| (stretch.rate(form, Interval::of_ends(from, until)) * sign).high() < 0.0;
    let from = spans(until).map(|span| until - span).find(|from| falls(*from)).ok_or(grazing.clone())?;
    match (stretch.distance(form, Interval::from(until)) * sign).low() > 0.0 {
        true => keeps_sign(stretch, edge, 0.0, from),
        false => Err(grazing),
    }
}

/// Times within which the distance of a contact falls through 0, and the instant, for the motion on the
/// pieces before; `None` if it may graze its edge.
pub(crate) fn instant(
    stretch: &Stretch<'_, '_>,
    edge: &EdgeForm,
    about: f64,
) -> Option<(Interval, Interval)> {
    let &EdgeForm { form, sign, .. } = edge;
    let falls = |span: Interval| {
        (stretch.rate(form, span) * sign).high() < 0.0
            && (stretch.distance(form, Interval::from(span.low())) * sign).low() > 0.0
            && (stretch.distance(form, Interval::from(span.high())) * sign).high() < 0.0
    };
    let around = |half: f64| Interval::of_ends(about - half, about + half);
    let span = spans(0.5 * about.min(stretch.length - about)).map(around).find(|span| falls(*span))?;
    let distance = |s: Interval| stretch.distance(form, s);
    Some((span, refined(span, stretch.rate(form, span), distance)?))
}

/// The instant within a span at which a distance is 0, by the interval Newton method.
pub(crate) fn refined(
    span: Interval,
    rate: Interval,
    distance: impl Fn(Interval) -> Interval,
) -> Option<Interval> {
    (0..REFINEMENTS).try_fold(span, |at, _| {
        let middle = Interval::from(at.middle());
        at.common(middle - distance(middle) / rate)
    })
}

/// Spans from the largest one on, each a quarter of the one before.
fn spans(largest: f64) -> impl Iterator<Item = f64> {
    (0..SPANS).scan(largest, |span, _| Some(std::mem::replace(span, 0.25 * *span)))
}
