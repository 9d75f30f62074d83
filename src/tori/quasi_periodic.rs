//! Models whose drives are functions of several angles.

use crate::error::{ParameterError, check};
use crate::excitation::Side;
use crate::model::Model;
use crate::model::reference::Pointer;
use crate::numeric::spread::golden;
use std::f64::consts::TAU;
use thiserror::Error;

/// u(t) = U(ω_1 t, ..., ω_D t), U of period 2π in each angle: a model with several base frequencies, for
/// example those of several shafts.
///
/// [`drive`](Model::drive) at t and [`drive_at`](QuasiPeriodic::drive_at) at the angles ω t must agree. The
/// solvers check this.
///
/// ```
/// use gear_dynamics::{Model, excitation::Side, tori::QuasiPeriodic};
/// struct TwoTones; // q'' + 0.1 q' + q = cos t√2 + cos t√3
/// impl Model for TwoTones {
///     fn dof(&self) -> usize { 1 }
///     fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) { a[0] = u[0] - 0.1 * v[0] - q[0]; }
///     fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
///         self.drive_at(&[2f64.sqrt() * t, 3f64.sqrt() * t], side, u);
///     }
/// }
/// impl QuasiPeriodic for TwoTones {
///     fn frequencies(&self) -> Vec<f64> { vec![2f64.sqrt(), 3f64.sqrt()] }
///     fn drive_at(&self, angles: &[f64], _: Side, u: &mut [f64]) {
///         u[0] = angles[0].cos() + angles[1].cos();
///     }
/// }
/// let mut u = [0.0];
/// TwoTones.drive_at(&[0.0, std::f64::consts::PI], Side::After, &mut u);
/// assert_eq!(u[0], 0.0);
/// ```
pub trait QuasiPeriodic: Model {
    /// Base frequencies ω_1 ... ω_D, positive, in rad per time unit of the model. No whole multiples of them
    /// should add up to zero.
    fn frequencies(&self) -> Vec<f64>;
    /// Writes the drives at the given angles `[rad]`, one for each base frequency, to `u`. `side`: before or
    /// after a jump at these angles.
    fn drive_at(&self, angles: &[f64], side: Side, u: &mut [f64]);
    /// Returns the time from the given angles to the first jump or kink of a drive, as
    /// [`next_edge`](Model::next_edge) does for time. Default: `None`.
    fn edge_after(&self, angles: &[f64]) -> Option<f64> {
        let _ = angles;
        None
    }
}

impl<P: Pointer<Target: QuasiPeriodic>> QuasiPeriodic for P {
    fn frequencies(&self) -> Vec<f64> {
        (**self).frequencies()
    }
    fn drive_at(&self, angles: &[f64], side: Side, u: &mut [f64]) {
        (**self).drive_at(angles, side, u);
    }
    fn edge_after(&self, angles: &[f64]) -> Option<f64> {
        (**self).edge_after(angles)
    }
}

/// The reasons why the drives of a model are not functions of its angles.
///
/// ```
/// use gear_dynamics::{Model, excitation::Side, tori::{QuasiPeriodic, TorusBalance, TorusError}};
/// use gear_dynamics::tori::{QuasiPeriodicError, WaveVectors};
/// struct Forgetful; // `drive` is the default one: u[0] = t
/// impl Model for Forgetful {
///     fn dof(&self) -> usize { 1 }
///     fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) { a[0] = u[0] - 0.1 * v[0] - q[0]; }
/// }
/// impl QuasiPeriodic for Forgetful {
///     fn frequencies(&self) -> Vec<f64> { vec![1.0, 3f64.sqrt()] }
///     fn drive_at(&self, angles: &[f64], _: Side, u: &mut [f64]) {
///         u[0] = angles[0].cos() + angles[1].cos();
///     }
/// }
/// let error = TorusBalance::new(WaveVectors::within(&[3, 3])?).at_rest(&Forgetful, &[0.0]).unwrap_err();
/// assert!(matches!(
///     error,
///     TorusError::Drives(QuasiPeriodicError::DriveMismatch { drive: 0, by_time, .. }) if by_time > 1.0
/// ));
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum QuasiPeriodicError {
    /// A base frequency is not valid, or there is none.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// `drive` and `drive_at` differ.
    #[error(
        "drive {drive} at time {t:?} is {by_time:?} by Model::drive and {by_angles:?} by QuasiPeriodic::drive_at: \
         both must be equal"
    )]
    DriveMismatch {
        /// Index of the drive, from 0.
        drive: usize,
        /// Time of the comparison.
        t: f64,
        /// Value of `drive`.
        by_time: f64,
        /// Value of `drive_at`.
        by_angles: f64,
    },
    /// A drive does not repeat after 2π of an angle.
    #[error(
        "drive {drive} changes by {change:?} when angle {angle} increases by 2π: it must repeat after 2π of \
         every angle"
    )]
    NotPeriodic {
        /// Index of the drive, from 0.
        drive: usize,
        /// Index of the angle, from 0.
        angle: usize,
        /// Change of the drive over 2π.
        change: f64,
    },
    /// `next_edge` reports drive edges and `edge_after` none.
    #[error(
        "Model::next_edge reports a drive edge at time {edge:?} and QuasiPeriodic::edge_after reports none: \
         implement edge_after"
    )]
    EdgeNotAtAngles {
        /// The first drive edge after time 0.
        edge: f64,
    },
}

/// Instants of the comparison of `drive` with `drive_at`.
const INSTANTS: usize = 24;

/// Slow periods over which the instants are spread `[1]`.
const PERIODS: f64 = 4.0;

/// Accepted difference of two values of a drive, as a share of its largest value `[1]`.
const SAME: f64 = 1e-8;

/// The base frequencies, after a check of them and of the drives.
pub(crate) fn checked_frequencies(model: &dyn QuasiPeriodic) -> Result<Vec<f64>, QuasiPeriodicError> {
    let frequencies = model.frequencies();
    if frequencies.is_empty() {
        return Err(ParameterError::Empty { name: "frequencies".into(), min: 1 }.into());
    }
    for (d, omega) in frequencies.iter().enumerate() {
        check::scale(format!("frequencies[{d}]"), *omega)?;
    }
    let (slowest, fastest) =
        frequencies.iter().fold((f64::INFINITY, 0.0f64), |(low, high), w| (low.min(*w), high.max(*w)));
    let span = PERIODS * TAU / slowest;
    let count = model.drives();
    let mut rows: Vec<[Vec<f64>; 2]> = Vec::with_capacity(INSTANTS);
    let (mut size, mut angles) = (vec![0.0f64; count], vec![0.0; frequencies.len()]);
    let times: Vec<f64> = (1..=INSTANTS).map(|i| span * golden(i as f64)).collect();
    for t in &times {
        let mut row = [vec![0.0; count], vec![0.0; count]];
        model.drive(*t, Side::After, &mut row[0]);
        angles.iter_mut().zip(&frequencies).for_each(|(angle, omega)| *angle = omega * t);
        model.drive_at(&angles, Side::After, &mut row[1]);
        size.iter_mut().zip(&row[1]).for_each(|(size, u)| *size = size.max(u.abs()));
        rows.push(row);
    }
    // The angles carry a rounding error of fastest·t.
    let share = SAME + 64.0 * f64::EPSILON * fastest * span;
    let differs = |a: f64, b: f64, size: f64| {
        let close = (a - b).abs() <= share * size;
        !close
    };
    for (t, [by_time, by_angles]) in times.iter().zip(&rows) {
        if let Some(drive) = (0..count).find(|&k| differs(by_time[k], by_angles[k], size[k])) {
            let (by_time, by_angles) = (by_time[drive], by_angles[drive]);
            return Err(QuasiPeriodicError::DriveMismatch { drive, t: *t, by_time, by_angles });
        }
    }
    let mut turned = vec![0.0; count];
    for (t, [_, by_angles]) in times.iter().zip(&rows) {
        for angle in 0..frequencies.len() {
            angles.iter_mut().zip(&frequencies).for_each(|(angle, omega)| *angle = omega * t);
            angles[angle] += TAU;
            model.drive_at(&angles, Side::After, &mut turned);
            if let Some(drive) = (0..count).find(|&k| differs(turned[k], by_angles[k], size[k])) {
                let change = turned[drive] - by_angles[drive];
                return Err(QuasiPeriodicError::NotPeriodic { drive, angle, change });
            }
        }
    }
    match (model.next_edge(0.0), model.edge_after(&vec![0.0; frequencies.len()])) {
        (Some(edge), None) => Err(QuasiPeriodicError::EdgeNotAtAngles { edge }),
        _ => Ok(frequencies),
    }
}
