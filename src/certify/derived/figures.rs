//! Figures of certified orbits.

use crate::certify::certificate::Certificate;
use crate::certify::derived::course::{BoxCourse, peak_to_peak};
use crate::certify::flow::algebra::Algebra;
use crate::certify::flow::field::Field;
use crate::certify::flow::part::Part;
use crate::certify::unproved::Unproved;
use crate::contact::Piece;
use crate::interval::number::Interval;
use crate::model::Periodic;
use crate::tape::operations::Tape;

/// Figures of a certified orbit, each as an interval that contains the exact value. See
/// [`Certificate::figures`].
///
/// ```
/// use gear_dynamics::{trains::SpurPair, Shooting, State};
/// let pair = SpurPair::of_numbers(0.05, 0.1, &[-0.2], &[])?.parts()?.build("driver", 0.85)?;
/// let orbit = Shooting::new().solve(&pair, &State::new(0.0, &[1.17], &[0.017]))?;
/// let figures = orbit.certify(&pair)?.figures(&pair)?;
/// assert!(figures.peak_to_peak[0].width() < 1e-11);
/// assert!(figures.contacts[0].mean_force.contains(0.1)); // the load
/// assert_eq!(figures.contacts[0].loss_fraction.high(), 0.0); // always in contact
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct CertifiedFigures {
    /// Largest minus least value of each coordinate, then of each velocity, over a period of the orbit, in
    /// the units of the model.
    pub peak_to_peak: Vec<Interval>,
    /// Figures of each contact.
    pub contacts: Vec<CertifiedContact>,
}

/// Figures of a contact over a period of a certified orbit.
///
/// ```
/// use gear_dynamics::certify::{CertifiedContact, Interval};
/// let contact =
///     CertifiedContact { mean_force: Interval::new(0.9, 1.1)?, loss_fraction: Interval::new(0.2, 0.3)? };
/// assert!(contact.mean_force.contains(1.0) && contact.loss_fraction.low() > 0.0);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct CertifiedContact {
    /// Mean of the contact force, [`Contact::force`](crate::contact::Contact::force), without the impulses of
    /// a rigid stop.
    pub mean_force: Interval,
    /// Share of the time in the gap `[1]`.
    pub loss_fraction: Interval,
}

impl Certificate {
    /// Bounds of figures of the orbit: peak-to-peak values, mean forces, shares of time out of contact. The
    /// certificate is [checked](Certificate::check) on the way.
    ///
    /// Extremes by bisection of the enclosed polynomials of the motion, means by their integrals.
    ///
    /// # Errors
    /// As [`check`](Certificate::check); a contact force without a series.
    pub fn figures(&self, model: &dyn Periodic) -> Result<CertifiedFigures, Unproved> {
        let field = self.field(model)?;
        let tape = &field.motion.tape;
        let gaps: Vec<bool> = tape.distances.iter().map(|both| both.iter().any(Option::is_some)).collect();
        let forces = forces(&field)?;
        let (mut courses, mut impulses, mut flights) =
            (Vec::new(), vec![Interval::ZERO; gaps.len()], vec![Interval::ZERO; gaps.len()]);
        self.prove(model, &field, &mut |part: &dyn Part| {
            let until = part.until();
            courses.push(BoxCourse::new(part));
            for (impulse, force) in impulses.iter_mut().zip(part.series_of(&forces)) {
                *impulse = *impulse + integral(&force, until);
            }
            for (i, flight) in flights.iter_mut().enumerate().filter(|(i, _)| gaps[*i]) {
                *flight = match part.pieces(i).map(|piece| piece == Piece::Gap) {
                    [true, true] => *flight + until,
                    [false, false] => *flight,
                    _ => *flight + Interval::ZERO.hull(until),
                };
            }
        })?;
        let whole = Interval::of_ends(0.0, 1.0);
        let contacts = impulses.into_iter().zip(flights).map(|(impulse, flight)| CertifiedContact {
            mean_force: impulse / self.period,
            loss_fraction: (flight / self.period).common(whole).unwrap_or(whole),
        });
        let peak_to_peak = (0..2 * field.n).map(|i| peak_to_peak(&courses, i)).collect();
        Ok(CertifiedFigures { peak_to_peak, contacts: contacts.collect() })
    }
}

/// The tape of the motion with the contact forces in place of the distances.
fn forces(field: &Field<'_>) -> Result<Algebra, Unproved> {
    if !field.keeps_forces {
        return Err(Unproved::NoEnclosure { what: "a contact force that the rigid motion changes".into() });
    }
    let tape = &field.motion.tape;
    let distances = tape.measured.iter().map(|&[_, force]| [Some(force), None]).collect();
    let tape = Tape { distances, ..tape.clone() };
    match tape.kink() {
        Some((_, what)) => Err(Unproved::NoEnclosure { what: format!("{what}, in a contact force") }),
        None => Ok(Algebra::new(tape)),
    }
}

/// The integral of a polynomial from 0 to `until`.
fn integral(series: &[Interval], until: Interval) -> Interval {
    let terms = series.iter().enumerate().rev();
    terms.fold(Interval::ZERO, |sum, (k, c)| sum * until + *c / Interval::from((k + 1) as f64)) * until
}
