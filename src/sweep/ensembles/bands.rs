//! The results of an ensemble.

use crate::analysis::RattleState;
use crate::error::{ParameterError, check};
use crate::sweep::ensembles::confidence::Proportion;
use crate::sweep::ensembles::distribution::Distribution;
use crate::sweep::sweep_error::PointError;

/// Results of one member: channel values (time by time), peaks, and the number of impacts of each contact.
pub(crate) struct MemberResults {
    pub(crate) values: Vec<f64>,
    pub(crate) peaks: Vec<f64>,
    pub(crate) impacts: Vec<f64>,
    pub(crate) states: Vec<RattleState>,
}

/// The results of an ensemble: the distribution of every channel at every time, of peaks and of impact
/// counts.
///
/// ```
/// use gear_dynamics::{sweep::Ensemble, ParameterError, Rk4, State, model::from_fn};
/// let family = |g: u64| {
///     let fall = from_fn(1, move |_, _, _, a| a[0] = -(g as f64))?;
///     Ok::<_, ParameterError>((fall, State::at_rest(1)))
/// };
/// let bands = Ensemble::new(5, 2.0, 2)?.channels(&["q0"]).run(&Rk4::new(0.5), family)?;
/// // q = -g t²/2 with g = 0 .. 4: RK4 is exact on a parabola.
/// assert_eq!(
///     (bands.times()[2], bands.at("q0", 2)?.min(), bands.at("q0", 2)?.mean()),
///     (2.0, -8.0, -4.0)
/// );
/// assert!((bands.band("q0", 0.5)?[1] + 1.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Bands {
    times: Vec<f64>,
    names: Vec<String>,
    /// The channels at the first time, then at the next time, and so on.
    values: Vec<Distribution>,
    peak_names: Vec<String>,
    peaks: Vec<Distribution>,
    impacts: Vec<Distribution>,
    /// For each contact: the members by their rattle state, by its number.
    states: Vec<[u64; 4]>,
    /// For each number of added members that is a power of two: the mean of each peak.
    convergence: Vec<Vec<MeanAfter>>,
    pub(crate) members: u64,
    pub(crate) failed: u64,
    pub(crate) first_failure: Option<FailedMember>,
}

/// The mean of a distribution after the first members of an ensemble, as given by [`Bands::convergence`].
///
/// ```
/// use gear_dynamics::{ParameterError, State, Dop853, model::from_fn, sweep::Ensemble};
/// let push = |member: u64| {
///     let model = from_fn(1, move |_, _, _, a| a[0] = 2.0 * member as f64)?;
///     Ok::<_, ParameterError>((model, State::at_rest(1)))
/// };
/// let ensemble = Ensemble::new(4, 1.0, 1)?.peaks(&["v0"]); // v(1) = 0, 2, 4, 6
/// let bands = ensemble.run(&Dop853::new(), push)?;
/// let last = bands.convergence("v0")?[2];
/// assert!(last.members == 4 && (last.mean - 3.0).abs() < 1e-12);
/// assert!((last.standard_error - (5.0f64 / 3.0).sqrt()).abs() < 1e-12); // √(20/3)/√4
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct MeanAfter {
    /// Number of members that were averaged.
    pub members: u64,
    /// Their mean.
    pub mean: f64,
    /// Standard error of the mean.
    pub standard_error: f64,
}

/// A member of an ensemble that failed, as given by [`Bands::first_failure`].
///
/// ```
/// use gear_dynamics::{Rk4, State, model::from_fn, sweep::Ensemble};
/// let ensemble = Ensemble::new(3, 1.0, 1)?.channels(&["q0"]);
/// let rest = from_fn(1, |_, _, _, a| a[0] = 0.0)?;
/// let member = |i: u64| if i == 1 { Err("broken") } else { Ok((&rest, State::at_rest(1))) };
/// let bands = ensemble.run(&Rk4::new(0.1), member)?;
/// assert_eq!((bands.failed(), bands.first_failure().map(|failed| failed.member)), (1, Some(1)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct FailedMember {
    /// Its number, from 0.
    pub member: u64,
    /// Its error.
    pub error: PointError,
}

impl Bands {
    pub(crate) fn new(times: &[f64], channels: &[String], peaks: &[String]) -> Self {
        Bands {
            times: times.to_vec(),
            names: channels.to_vec(),
            values: vec![Distribution::new(); channels.len() * times.len()],
            peak_names: peaks.to_vec(),
            peaks: vec![Distribution::new(); peaks.len()],
            impacts: Vec::new(),
            states: Vec::new(),
            convergence: Vec::new(),
            members: 0,
            failed: 0,
            first_failure: None,
        }
    }

    pub(crate) fn add(&mut self, seen: &MemberResults) {
        let add = |all: &mut [Distribution], values: &[f64]| {
            all.iter_mut().zip(values).for_each(|(all, x)| all.add(*x))
        };
        self.impacts.resize(seen.impacts.len().max(self.impacts.len()), Distribution::new());
        add(&mut self.values, &seen.values);
        add(&mut self.peaks, &seen.peaks);
        add(&mut self.impacts, &seen.impacts);
        self.states.resize(seen.states.len().max(self.states.len()), [0; 4]);
        for (counts, state) in self.states.iter_mut().zip(&seen.states) {
            counts[usize::from(state.rsv())] += 1;
        }
        self.members += 1;
        if self.members.is_power_of_two() {
            let members = self.members;
            let after =
                |p: &Distribution| MeanAfter { members, mean: p.mean(), standard_error: p.standard_error() };
            self.convergence.push(self.peaks.iter().map(after).collect());
        }
    }

    pub(crate) fn fail(&mut self, member: u64, error: PointError) {
        self.failed += 1;
        self.first_failure.get_or_insert(FailedMember { member, error });
    }

    /// The times at which channels are sampled, in the model's time unit.
    pub fn times(&self) -> &[f64] {
        &self.times
    }
    /// The number of members that reached the end time.
    pub fn members(&self) -> u64 {
        self.members
    }
    /// The number of members that failed.
    pub fn failed(&self) -> u64 {
        self.failed
    }
    /// The first member that failed; `None` if all succeeded.
    pub fn first_failure(&self) -> Option<&FailedMember> {
        self.first_failure.as_ref()
    }

    /// The distribution of a channel at time `i`, counted from 0. At a jump of the channel it has the values
    /// before the jump, at the start those after it. The extremes of a run, on both sides of jumps, are its
    /// [`peak`](Bands::peak).
    ///
    /// # Errors
    /// [`ParameterError::NoSuchChannel`]; [`ParameterError::Length`] if there is no time `i`.
    pub fn at(&self, channel: &str, i: usize) -> Result<&Distribution, ParameterError> {
        let channel = check::channel_index(&self.names, channel)?;
        let at =
            i.checked_mul(self.names.len()).and_then(|first| self.values.get(first.checked_add(channel)?));
        at.ok_or_else(|| ParameterError::Length {
            name: "times".into(),
            expected: i.saturating_add(1),
            found: self.times.len(),
        })
    }
    /// Quantile `p` of a channel over time.
    ///
    /// # Errors
    /// As [`at`](Bands::at) and [`Distribution::quantile`].
    pub fn band(&self, channel: &str, p: f64) -> Result<Vec<f64>, ParameterError> {
        (0..self.times.len()).map(|i| self.at(channel, i)?.quantile(p)).collect()
    }
    /// Mean of a channel over time; NaN at a time without a finite value.
    ///
    /// # Errors
    /// [`ParameterError::NoSuchChannel`].
    pub fn mean(&self, channel: &str) -> Result<Vec<f64>, ParameterError> {
        (0..self.times.len()).map(|i| Ok(self.at(channel, i)?.mean())).collect()
    }
    /// The distribution of the peak of a channel: the maximum of |x| over a run.
    ///
    /// # Errors
    /// [`ParameterError::NoSuchChannel`] for a channel that was not requested by
    /// [`peaks`](crate::sweep::Ensemble::peaks).
    pub fn peak(&self, channel: &str) -> Result<&Distribution, ParameterError> {
        Ok(&self.peaks[check::channel_index(&self.peak_names, channel)?])
    }
    /// The distribution of the number of impacts of contact `i` in a run; `None` without
    /// [`rattle`](crate::sweep::Ensemble::rattle) or without such a contact.
    pub fn impacts(&self, i: usize) -> Option<&Distribution> {
        self.impacts.get(i)
    }
    /// The share of the members in which contact `i` had this rattle state over the whole run, with its
    /// [confidence interval](Proportion::confidence); `None` as for [`impacts`](Bands::impacts).
    pub fn rattle_share(&self, i: usize, state: RattleState) -> Option<Proportion> {
        let counts = self.states.get(i)?;
        Proportion::new(counts[usize::from(state.rsv())], counts.iter().sum()).ok()
    }
    /// Convergence of the mean [peak](Bands::peak) of a channel: its mean after 1, 2, 4, 8, ... successful
    /// members.
    ///
    /// # Errors
    /// As [`peak`](Bands::peak).
    pub fn convergence(&self, channel: &str) -> Result<Vec<MeanAfter>, ParameterError> {
        let i = check::channel_index(&self.peak_names, channel)?;
        Ok(self.convergence.iter().map(|peaks| peaks[i]).collect())
    }
}
