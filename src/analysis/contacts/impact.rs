//! One impact, and the figures of many.

use crate::contact::Piece;
use crate::error::{ParameterError, check};

/// One impact of a contact, from touching to separating. Speeds and times have the units of the model, SI in
/// the models of this crate.
///
/// ```
/// use gear_dynamics::{analysis::Impact, contact::Piece};
/// let touching = Impact {
///     contact: 0, flank: Piece::Upper, t: 2.0, speed: 0.5, flight: Some(1.5), left: None,
///     separation: None, impulse: Some(3.0),
/// };
/// assert_eq!(touching.duration(), None);
/// assert_eq!(Impact { left: Some(2.25), ..touching }.duration(), Some(0.25));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// Index of the contact, from 0.
    pub contact: usize,
    /// The flank that was hit: lower or upper.
    pub flank: Piece,
    /// Instant of touching, in the model's time unit.
    pub t: f64,
    /// Speed of approach: rate of the penetration at touching `[m/s]`. It is negative only if an edge jumped
    /// onto a contact that moves away.
    pub speed: f64,
    /// Time in the gap before touching; `None` if the contact has been in the gap since the start of the run.
    pub flight: Option<f64>,
    /// Instant of separation; `None` if the run ended before it. At a rigid stop, the instant of touching.
    pub left: Option<f64>,
    /// Speed of separation: rate of the penetration at separation, with the opposite sign `[m/s]`. `None` if
    /// the run ended before it.
    pub separation: Option<f64>,
    /// Impulse P = ∫ ±W dt over the contact time `[N s]`, with + on the upper and - on the lower flank: a
    /// force that presses the teeth together counts as positive. If the run ended in contact, up to the end.
    ///
    /// At a rigid stop P = m (speed + separation) with the
    /// [effective mass](crate::analysis::Impacts::effective_mass) m; `None` without it or without separation.
    pub impulse: Option<f64>,
}

impl Impact {
    /// Contact time; `None` if the run ended in contact.
    pub fn duration(&self) -> Option<f64> {
        self.left.map(|left| left - self.t)
    }
}

/// Figures of all impacts of one contact in an observed time T.
///
/// ```
/// use gear_dynamics::analysis::ImpactSummary;
/// // One impact a second carries the whole impulse of a mean force of 20 N:
/// let summary = ImpactSummary { count: 9, time: 9.0, rms_impulse: Some(20.0), ..ImpactSummary::default() };
/// assert!((summary.rattle_index(20.0, 1.0)? - 1.0).abs() < 1e-15);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImpactSummary {
    /// Number n of impacts.
    pub count: u64,
    /// Observed time T, in the model's time unit.
    pub time: f64,
    /// √(Σ v²/n) of the speeds of approach v `[m/s]`; 0 without impacts.
    pub rms_speed: f64,
    /// Maximum speed of approach `[m/s]`; 0 without impacts.
    pub max_speed: f64,
    /// √(Σ P²/n) of the impulses P `[N s]`; 0 without impacts. `None` if an impact on a rigid stop has no
    /// impulse. A rebound at the end of the run, whose speed of separation is not known, counts in n alone.
    pub rms_impulse: Option<f64>,
}

impl ImpactSummary {
    /// The figures of impacts in the time `time`.
    pub(crate) fn of<'i>(impacts: impl Iterator<Item = &'i Impact>, time: f64) -> Self {
        let mut sum = ImpactSummary { time, rms_impulse: Some(0.0), ..ImpactSummary::default() };
        for impact in impacts {
            sum.count += 1;
            // The norm of the list so far; `hypot` does not overflow.
            sum.rms_speed = sum.rms_speed.hypot(impact.speed);
            sum.max_speed = sum.max_speed.max(impact.speed);
            sum.rms_impulse = match (sum.rms_impulse, impact.impulse) {
                (Some(norm), Some(impulse)) => Some(norm.hypot(impulse)),
                (norm, None) if impact.separation.is_none() => norm,
                _ => None,
            };
        }
        let root = (sum.count.max(1) as f64).sqrt();
        sum.rms_speed /= root;
        sum.rms_impulse = sum.rms_impulse.map(|norm| norm / root);
        sum
    }

    /// Impacts per unit of time, n/T; 0 if nothing was observed.
    pub fn rate(&self) -> f64 {
        if self.time > 0.0 { self.count as f64 / self.time } else { 0.0 }
    }

    /// Rattle index R = √(Σ P²/(T τ))/F `[1]`: the RMS impulse of the impacts in a period τ, over the impulse
    /// F τ of the load. A definition of this crate.
    ///
    /// `force`: mean mesh force F without rattle, its magnitude `[N]`; `period`: τ, for example that of the
    /// mesh or of the drives, in the model's time unit.
    ///
    /// - R = 0: no impacts.
    /// - R = 1: one impact per period, on the flank that carries the load.
    /// - R = 1/√n: n equal impacts per period on this flank; R = √n: one impact in n periods.
    /// - R is larger than all of these if the back flank is hit too: the load flank then also returns the
    ///   impulse of the back flank.
    ///
    /// The squares stand for the vibration that impacts excite. Impacts that are short and not correlated
    /// give the mesh force the one-sided power density 2 Σ P²/T `[N²/Hz]` at all frequencies far below the
    /// inverse of their duration (Campbell's theorem). In decibels: 20 log10 R.
    ///
    /// # Errors
    /// [`ParameterError::NotSet`] if an impact on a rigid stop has no impulse; a force or a period
    /// outside 1e-50 .. 1e50; [`ParameterError::Overflow`].
    pub fn rattle_index(&self, force: f64, period: f64) -> Result<f64, ParameterError> {
        let (force, period) = (check::scale("mean mesh force", force)?, check::scale("period", period)?);
        let name = "effective mass of the contact with a rigid stop";
        let impulse = self.rms_impulse.ok_or(ParameterError::NotSet { name })?;
        let index = impulse * (self.rate() / period).sqrt() / force;
        check::representable("rattle index", index, &[impulse, self.rate()])
    }
}
