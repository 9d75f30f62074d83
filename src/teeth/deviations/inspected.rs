//! Deviations from tooth to tooth: measured, or drawn within a quality grade.

use crate::error::{ParameterError, check};
use crate::excitation::Fourier;
use crate::numeric::norms::largest;
use crate::numeric::search::bracket::Bracket;
use crate::numeric::split_mix::CounterRng;
use crate::teeth::deviations::grade::QualityGrade;
use crate::teeth::error::TeethError;
use crate::teeth::geometry::gear::InvoluteGear;
use rand_distr::{Distribution, StandardNormal, StandardUniform};
use std::f64::consts::{FRAC_1_SQRT_2, TAU};

/// The deviations of all teeth of one gear along the line of action `[m]`: those of an inspection report, or
/// drawn within a quality grade.
///
/// Each tooth k = 0 .. z - 1 has a cumulative pitch deviation p_k and a profile slope deviation h_k. They are
/// one wave over a turn of the gear,
///
/// e(φ) = P(φ) + 1/2 H(φ) sin(z φ),
///
/// P and H the trigonometric polynomials of the lowest orders through p_k and h_k in the middle of the mesh
/// cycle of tooth k, φ = 2π (k + 1/2)/z. The orders are 0 to z/2 (run-out and pitch) and z/2 to 3z/2 (the
/// mesh cycle with its sidebands): a finite series, under which every solver locates edges. That the profile
/// acts as a sine, and that tooth pairs take over from each other smoothly, are assumptions.
///
/// ```
/// use gear_dynamics::excitation::Excitation;
/// use gear_dynamics::teeth::{InvoluteGear, QualityGrade, ToothDeviations};
/// let gear = InvoluteGear::external(20, 0.003)?;
/// let grade = QualityGrade::new(6)?;
/// let teeth = ToothDeviations::draw(&gear, grade, 7, 0, 0)?; // seed 7, gear 0 of gearbox 0
/// let limits = grade.tolerances(&gear)?;
/// assert!(teeth.single_pitch() <= limits.single_pitch && teeth.cumulative_pitch() <= limits.cumulative_pitch);
/// let middle = 3.5 * std::f64::consts::TAU / 20.0; // of tooth 3
/// assert!((teeth.wave()?.value(middle) - teeth.pitch()[3]).abs() < 1e-18);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ToothDeviations {
    pitch: Vec<f64>,
    profile: Vec<f64>,
}

/// Maximum number of teeth: the wave has 3z/2 orders.
const MOST_TEETH: usize = 1000;

/// Scatter of the profile slopes from tooth to tooth over the scatter of their mean from gear to gear `[1]`.
const PROFILE_SCATTER: f64 = 0.3;

impl ToothDeviations {
    /// The deviations of an inspection report: cumulative pitch p_k and profile slope h_k of every tooth
    /// `[m]`, in the order in which the teeth mesh. A positive deviation is material that pushes ahead.
    ///
    /// # Errors
    /// Fewer than 3 teeth or more than 1000; lists of different lengths; a deviation beyond ±1e50.
    pub fn measured(pitch: &[f64], profile: &[f64]) -> Result<Self, ParameterError> {
        check::at_least("teeth", pitch.len(), 3)?;
        check::count("teeth", &[pitch.len()], MOST_TEETH)?;
        if profile.len() != pitch.len() {
            return Err(ParameterError::Length {
                name: "profile slope deviations".into(),
                expected: pitch.len(),
                found: profile.len(),
            });
        }
        check::quantities("pitch deviations", pitch)?;
        check::quantities("profile slope deviations", profile)?;
        Ok(ToothDeviations { pitch: pitch.to_vec(), profile: profile.to_vec() })
    }

    /// The deviations of one gear of a population, drawn so that they satisfy the grade. The cumulative pitch
    /// deviation exceeds the limit of the next finer grade unless the single pitch deviation reaches its own
    /// limit first.
    ///
    /// - Pitch: independent normal deviations of the teeth, scaled to the single pitch deviation r_1 f_pT,
    ///   then a run-out cos(φ - ψ) of random direction, as large as the cumulative deviation r_2 F_pT
    ///   permits.
    /// - Profile: a mean of the gear and a scatter of the teeth of 0.3 times its size, scaled so that the
    ///   largest slope is r_3 f_HαT.
    /// - The r_i are uniform on (1/√2, 1), since classes differ by the factor √2. All is then reduced by the
    ///   least factor, at most 1, with which both pitch limits hold.
    ///
    /// The standard states limits and no distribution: this one is a convention. Equal numbers give equal
    /// deviations: `seed` of the experiment, `member` of the population, `gear` within the gearbox.
    ///
    /// # Errors
    /// A gear to which ISO 1328-1 does not apply.
    pub fn draw(
        gear: &InvoluteGear,
        grade: QualityGrade,
        seed: u64,
        member: u64,
        gear_number: u64,
    ) -> Result<Self, TeethError> {
        let limits = grade.tolerances(gear)?;
        // The streams of a gear follow those of random parameters, which begin at 2³².
        let stream = (1u64 << 33).wrapping_add(gear_number.wrapping_mul(2));
        let mut rng = CounterRng::new(seed, member, stream, 0);
        let z = gear.teeth() as usize;
        let mut uniform = |low: f64, high: f64| {
            let share: f64 = StandardUniform.sample(&mut rng);
            low + (high - low) * share
        };
        let share: [f64; 3] = std::array::from_fn(|_| uniform(FRAC_1_SQRT_2, 1.0));
        let direction = uniform(0.0, TAU);
        let mut rng = CounterRng::new(seed, member, stream + 1, 0);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };

        let mut pitch: Vec<f64> = (0..z).map(|_| normal()).collect();
        let scale = share[0] * limits.single_pitch / largest_step(&pitch);
        let mean = pitch.iter().sum::<f64>() / z as f64;
        pitch.iter_mut().for_each(|p| *p = scale * (*p - mean));
        let course: Vec<f64> = (0..z).map(|k| libm::cos(TAU * k as f64 / z as f64 - direction)).collect();
        add_run_out(&mut pitch, &course, share[1] * limits.cumulative_pitch);
        let excess =
            (largest_step(&pitch) / limits.single_pitch).max(range(&pitch) / limits.cumulative_pitch);
        pitch.iter_mut().for_each(|p| *p /= excess.max(1.0));

        let mean = normal();
        let mut profile: Vec<f64> = (0..z).map(|_| mean + PROFILE_SCATTER * normal()).collect();
        let scale = share[2] * limits.profile_slope / largest(&profile);
        profile.iter_mut().for_each(|h| *h *= scale);
        Ok(ToothDeviations { pitch, profile })
    }

    /// Cumulative pitch deviations p_k `[m]`, tooth by tooth.
    pub fn pitch(&self) -> &[f64] {
        &self.pitch
    }
    /// Profile slope deviations h_k `[m]`, tooth by tooth.
    pub fn profile(&self) -> &[f64] {
        &self.profile
    }
    /// The largest single pitch deviation, max |p_(k+1) - p_k| `[m]`.
    pub fn single_pitch(&self) -> f64 {
        largest_step(&self.pitch)
    }
    /// The cumulative pitch deviation, max p_k - min p_k `[m]`.
    pub fn cumulative_pitch(&self) -> f64 {
        range(&self.pitch)
    }
    /// The largest profile slope deviation, max |h_k| `[m]`.
    pub fn profile_slope(&self) -> f64 {
        largest(&self.profile)
    }

    /// The error e(φ) over a turn of the gear `[m]`, for
    /// [`MeshPart::error_of_turn`](crate::trains::MeshPart::error_of_turn).
    ///
    /// # Errors
    /// A coefficient beyond ±1e50.
    pub fn wave(&self) -> Result<Fourier, ParameterError> {
        let z = self.pitch.len();
        let (mean, pitch) = through(&self.pitch);
        let (slope, sidebands) = through(&self.profile);
        let mut orders = vec![[0.0; 2]; z + z / 2];
        for (order, pair) in orders.iter_mut().zip(pitch) {
            *order = pair;
        }
        // sin zφ cos nφ and sin zφ sin nφ as orders z - n and z + n.
        orders[z - 1][1] += 0.5 * slope;
        for (n, [c, s]) in (1..).zip(sidebands) {
            for (order, sign) in [(z - n, 1.0), (z + n, -1.0)] {
                orders[order - 1][0] += 0.25 * sign * s;
                orders[order - 1][1] += 0.25 * c;
            }
        }
        Fourier::new(mean, &orders)
    }
}

/// Mean and pairs (c_n, s_n), n = 1 .. z/2, of the trigonometric polynomial through values at the angles
/// 2π (k + 1/2)/z. Of an even number of values, the order z/2 has a sine alone: its cosine is 0 at all
/// angles.
fn through(values: &[f64]) -> (f64, Vec<[f64; 2]>) {
    let z = values.len();
    let pair = |n: usize| {
        let weight = if 2 * n == z { 1.0 } else { 2.0 } / z as f64;
        let mut sums = [0.0; 2];
        for (k, value) in values.iter().enumerate() {
            // The angle is reduced in integers, so that high orders lose no digits.
            let half_steps = (n * (2 * k + 1)) % (2 * z);
            let (sin, cos) = libm::sincos(TAU * half_steps as f64 / (2 * z) as f64);
            sums[0] += weight * value * cos;
            sums[1] += weight * value * sin;
        }
        if 2 * n == z { [0.0, sums[1]] } else { sums }
    };
    (values.iter().sum::<f64>() / z as f64, (1..=z / 2).map(pair).collect())
}

/// Adds the multiple of a course with which the range becomes `wanted`; nothing if it is as large already.
fn add_run_out(pitch: &mut [f64], course: &[f64], wanted: f64) {
    let with =
        |factor: f64| range(&pitch.iter().zip(course).map(|(p, c)| p + factor * c).collect::<Vec<_>>());
    if with(0.0) >= wanted {
        return;
    }
    let mut hi = wanted;
    while with(hi) < wanted {
        hi *= 2.0;
    }
    // The range is convex in the factor: between a smaller and a larger range it passes `wanted` once.
    let factor = Bracket { lo: 0.0, hi }.bisect(0.0, |factor| with(factor) < wanted).lo;
    pitch.iter_mut().zip(course).for_each(|(p, c)| *p += factor * c);
}

/// max |x_(k+1) - x_k|, the first value after the last.
fn largest_step(values: &[f64]) -> f64 {
    let next = values.iter().cycle().skip(1);
    largest(&values.iter().zip(next).map(|(x, next)| next - x).collect::<Vec<_>>())
}

fn range(values: &[f64]) -> f64 {
    let most = values.iter().fold(f64::NEG_INFINITY, |most, x| x.max(most));
    most - values.iter().fold(f64::INFINITY, |least, x| x.min(least))
}
