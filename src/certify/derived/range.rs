//! Orbits proved for all values of a constant in a range.

use crate::certify::certificate::Certificate;
use crate::certify::derived::course::{BoxCourse, state_at};
use crate::certify::unproved::Unproved;
use crate::error::check;
use crate::interval::number::Interval;
use crate::model::Periodic;
use crate::model::recording::Constants;
use crate::periodic::{Shooting, ShootingOrbit};

/// What is proved of a branch of orbits over a range of a constant. See
/// [`ShootingOrbit::certify_over`](crate::periodic::ShootingOrbit::certify_over).
///
/// ```
/// use gear_dynamics::{certify::Interval, trains::SpurPair, Shooting, State};
/// let pair = SpurPair::of_numbers(0.05, 0.1, &[-0.2], &[])?.parts()?.build("driver", 0.7)?;
/// let orbit = Shooting::new().solve(&pair, &State::new(0.0, &[1.1], &[0.0]))?;
/// let proved = orbit.certify_over(&pair, "speed", Interval::new(0.7, 0.7001)?, 1e-5)?;
/// assert!(proved.open.is_empty()); // one orbit for each of these speeds
/// assert!(proved.parts.iter().all(|(_, certificate)| certificate.crossings().is_empty())); // and no rattle
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct CertifiedRange {
    /// Values of the constant, increasing, with the certificate of the orbits for all of them. Where two
    /// parts meet, the orbit of one is proved to be that of the other, unless `open` has the value.
    pub parts: Vec<(Interval, Certificate)>,
    /// Values that are left open, increasing, and why.
    pub open: Vec<(Interval, Unproved)>,
}

impl ShootingOrbit {
    /// Proves the orbits for all values of the constant `name` in a range: by
    /// [`certify_with`](ShootingOrbit::certify_with) on parts of the range, bisected until each is proved or
    /// not wider than `least`. Each part begins with shooting at its middle, from the orbit of the part
    /// before.
    ///
    /// Neighbouring parts are joined by a certificate at their common value c: if the course of its orbit
    /// passes through all boxes of both, it is the only orbit at c in each of them. Parts that are all joined
    /// therefore prove one branch; if none of them has a crossing, no contact is lost on it for any value.
    ///
    /// The [budget](ShootingOrbit::budget) of the orbit holds for each part.
    ///
    /// # Errors
    /// [`Unproved::Parameter`]: a constant that the model does not have; a range that is not finite; a least
    /// width that is not positive. What could not be proved is no error, but is left
    /// [open](CertifiedRange::open).
    pub fn certify_over(
        &self,
        model: &dyn Periodic,
        name: &str,
        range: Interval,
        least: f64,
    ) -> Result<CertifiedRange, Unproved> {
        check::positive("least width of a part", least)?;
        check::finite("lower end of the range", range.low())?;
        check::finite("upper end of the range", range.high())?;
        let constants = model.offers().named()?;
        let family = Values { constants, index: constants.index(name)?, name, orbit: self };
        let mut parts: Vec<(Interval, Certificate)> = Vec::new();
        let mut open: Vec<(Interval, Unproved)> = Vec::new();
        let mut near = self.clone();
        let mut left = vec![range];
        while let Some(part) = left.pop() {
            let middle = part.middle();
            match family.proved(&near, middle, part) {
                Ok((orbit, certificate)) => {
                    near = orbit;
                    let joint = parts.last().filter(|(before, _)| before.high() == part.low());
                    if let Some(error) =
                        joint.and_then(|before| family.join(&near, &before.1, &certificate, part))
                    {
                        open.push((Interval::from(part.low()), error));
                    }
                    parts.push((part, certificate));
                }
                Err(error) => {
                    let small = part.width() <= least || middle <= part.low() || middle >= part.high();
                    if small || matches!(error, Unproved::Exhausted { .. }) {
                        open.push((part, error));
                        continue;
                    }
                    left.push(Interval::of_ends(middle, part.high()));
                    left.push(Interval::of_ends(part.low(), middle));
                }
            }
        }
        Ok(CertifiedRange { parts, open })
    }
}

/// The models with other values of a constant.
struct Values<'m> {
    constants: &'m dyn Constants,
    index: usize,
    name: &'m str,
    orbit: &'m ShootingOrbit,
}

impl Values<'_> {
    /// The orbit at a value, and its certificate for a part around it.
    fn proved(
        &self,
        near: &ShootingOrbit,
        value: f64,
        part: Interval,
    ) -> Result<(ShootingOrbit, Certificate), Unproved> {
        let model = self.constants.with_values(&[(self.index, value)])?;
        let shooting =
            Shooting::new().period_multiple(near.period_multiple()).budget(self.orbit.budget.clone());
        let orbit = shooting.solve(&*model, &near.states()[..1]).map_err(Box::new)?;
        let certificate = orbit.certify_with(&*model, &[(self.name, part)])?;
        Ok((orbit, certificate))
    }

    /// Proves that the orbits of two parts are the same at the value where `right` begins. Otherwise: why
    /// not.
    fn join(
        &self,
        near: &ShootingOrbit,
        before: &Certificate,
        after: &Certificate,
        right: Interval,
    ) -> Option<Unproved> {
        let passes = || {
            let value = right.low();
            let model = self.constants.with_values(&[(self.index, value)])?;
            let (_, joint) = self.proved(near, value, Interval::from(value))?;
            let mut courses = Vec::new();
            joint.prove(&*model, &joint.field(&*model)?, &mut |part| {
                courses.push(BoxCourse::new(part));
            })?;
            let inside = |certificate: &Certificate| {
                certificate.proposal.legs.iter().zip(certificate.states()).all(|(leg, around)| {
                    let state = state_at(&courses, joint.period(), leg.start).unwrap_or_default();
                    state.len() == around.len() && state.iter().zip(around).all(|(x, of)| x.lies_in(of))
                })
            };
            match inside(before) && inside(after) {
                true => Ok(()),
                false => Err(Unproved::Differs { what: "the orbits of neighbouring parts".into() }),
            }
        };
        passes().err()
    }
}
