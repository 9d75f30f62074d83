//! The image of a box after a leg.

use crate::certify::flow::crossing::across;
use crate::certify::flow::field::Field;
use crate::certify::flow::leg::{Image, Leg};
use crate::certify::flow::part::Seen;
use crate::certify::flow::signs::stays;
use crate::certify::flow::stretch::{Stretch, Until};
use crate::certify::flow::window::together;
use crate::certify::unproved::Unproved;
use crate::interval::number::Interval;

/// The image of the box `x` with the middle `m` after a leg, with every condition on its contacts proved.
/// `seen` receives the enclosed parts of the motion.
pub(crate) fn image(
    field: &Field<'_>,
    leg: &Leg,
    x: &[Interval],
    m: &[f64],
    seen: &mut Seen<'_>,
) -> Result<Image, Unproved> {
    let whole = leg.end - leg.start;
    if whole.low() <= 0.0 || !whole.is_bounded() {
        return Err(Unproved::Differs { what: "the times of the nodes".into() });
    }
    let m: Vec<Interval> = m.iter().map(|m| Interval::from(*m)).collect();
    match &leg.crossings[..] {
        [] => {
            let stretch = Stretch::new(field, &leg.pieces, (leg.start, leg.inside()), x, whole.high())?;
            stays(&stretch, &leg.pieces, whole.high(), &[])?;
            seen(&Until(&stretch, whole));
            let middle = stretch.narrow(leg.start, &m).state(whole);
            Ok(Image { middle, slope: stretch.slope(whole), crossing: None })
        }
        [crossing] => across(field, leg, crossing, x, &m, seen),
        _ => together(field, leg, x, &m, seen),
    }
}
