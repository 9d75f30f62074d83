//! Varying speed: run-up, coast-down and fluctuation.

use crate::drives::wrapped::{DriveRule, Wrapped};
use crate::error::{ParameterError, check};
use crate::excitation::Side;
use crate::excitation::earliest::earlier;
use crate::model::shapes::compiled::Code;
use crate::model::{Machine, Shape};
use crate::numeric::search::bracket::{Bracket, rounding};
use crate::scalar::Scalar;
use crate::series::Series;

/// A law of the speed of a body: its angle φ(t) `[rad]` with φ(0) = 0 and its speed φ'(t) > 0, over the time
/// of the model. [`VaryingSpeed`] states the body.
///
/// ```
/// use gear_dynamics::drives::SpeedLaw;
/// let run_up = SpeedLaw::ramp(10.0, 30.0, 4.0)?; // [rad/s] over 4 s, then constant
/// assert_eq!((run_up.speed(2.0), run_up.angle(4.0), run_up.angle(5.0)), (20.0, 80.0, 110.0));
/// assert!((run_up.time(35.0) - 2.242_640_687).abs() < 1e-8);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SpeedLaw {
    /// Time, speed and angle of each knot. The speed is linear between knots and constant outside.
    knots: Vec<[f64; 3]>,
    /// Amplitude of an added sinusoidal fluctuation, relative to the mean speed, and its angular frequency.
    swing: f64,
    frequency: f64,
}

impl SpeedLaw {
    /// Constant speed ω: φ = ωt.
    ///
    /// # Errors
    /// A speed outside 1e-50 .. 1e50.
    pub fn constant(speed: f64) -> Result<Self, ParameterError> {
        SpeedLaw::table(&[0.0], &[speed])
    }

    /// A run-up or coast-down: the speed changes linearly within `duration` and is constant afterwards.
    ///
    /// # Errors
    /// A speed or a duration outside 1e-50 .. 1e50.
    pub fn ramp(from: f64, to: f64, duration: f64) -> Result<Self, ParameterError> {
        check::scale("duration of the ramp", duration)?;
        SpeedLaw::table(&[0.0, duration], &[from, to])
    }

    /// A sinusoidal fluctuation: φ' = ω (1 + a cos ft), φ = ω (t + a sin(ft)/f), with the mean speed ω, the
    /// relative amplitude a `[1]` in [0, 1) and the angular frequency f.
    ///
    /// # Errors
    /// A speed or a frequency outside 1e-50 .. 1e50; an amplitude outside [0, 1).
    pub fn fluctuation(speed: f64, amplitude: f64, frequency: f64) -> Result<Self, ParameterError> {
        let swing = check::fraction("amplitude of the fluctuation", amplitude)?;
        let frequency = check::scale("frequency of the fluctuation", frequency)?;
        Ok(SpeedLaw { swing, frequency, ..SpeedLaw::constant(speed)? })
    }

    /// Given speeds at increasing times, the first of which is 0. The speed is linear between them and
    /// constant afterwards.
    ///
    /// # Errors
    /// Lists of different lengths; empty lists; a first time other than 0; times that do not increase by
    /// 1e-50 .. 1e50; a speed outside 1e-50 .. 1e50.
    pub fn table(times: &[f64], speeds: &[f64]) -> Result<Self, ParameterError> {
        check::length("speeds of the speed law", speeds.len(), times.len())?;
        if times.is_empty() {
            return Err(ParameterError::Empty { name: "times of the speed law".into(), min: 1 });
        }
        check::quantities("times of the speed law", times)?;
        let mut knots: Vec<[f64; 3]> = Vec::with_capacity(times.len());
        for (i, (&t, &speed)) in times.iter().zip(speeds).enumerate() {
            let speed = check::scale(format!("speeds[{i}] of the speed law"), speed)?;
            match knots.last() {
                None if t != 0.0 => {
                    return Err(ParameterError::Wrong {
                        name: "times[0] of the speed law".into(),
                        value: t,
                        must: "be 0, where the law starts".into(),
                    });
                }
                None => knots.push([0.0, speed, 0.0]),
                Some(&[before, last, angle]) => {
                    let after =
                        check::scale(format!("interval before times[{i}] of the speed law"), t - before)?;
                    knots.push([t, speed, angle + 0.5 * after * (last + speed)]);
                }
            }
        }
        Ok(SpeedLaw { knots, swing: 0.0, frequency: 1.0 })
    }

    /// The last knot (time, speed, angle) at or before `t` and the acceleration after it, without the
    /// fluctuation.
    fn piece(&self, t: f64) -> ([f64; 3], f64) {
        self.piece_before(self.knots.partition_point(|knot| knot[0] <= t))
    }

    /// The knot before knot `next` and the acceleration between the two. The acceleration outside all knots
    /// is 0.
    fn piece_before(&self, next: usize) -> ([f64; 3], f64) {
        let knot = self.knots[next.saturating_sub(1)];
        let slope = match self.knots.get(next) {
            Some(after) if next > 0 => (after[1] - knot[1]) / (after[0] - knot[0]),
            _ => 0.0,
        };
        (knot, slope)
    }

    /// φ, φ' and φ'' after the instant at which `t` begins, as series over time.
    fn expanded(&self, t: Series) -> [Series; 3] {
        let ([t0, speed, angle], slope) = self.piece(t.at(0.0));
        let (dt, [angle, speed, slope]) = (t - t0.into(), [angle, speed, slope].map(Series::from));
        let even = [angle + dt * (speed + dt * slope * 0.5), speed + dt * slope, slope];
        if self.swing == 0.0 {
            return even;
        }
        let (sin, cos) = (t * self.frequency).sin_cos();
        let swing = speed * self.swing;
        [
            even[0] + swing * sin * (1.0 / self.frequency),
            even[1] + swing * cos,
            even[2] - swing * sin * self.frequency,
        ]
    }

    /// Angle φ(t) `[rad]`.
    pub fn angle(&self, t: f64) -> f64 {
        let ([t0, speed, angle], slope) = self.piece(t);
        let dt = t - t0;
        angle
            + dt * (speed + 0.5 * slope * dt)
            + speed * self.swing * libm::sin(self.frequency * t) / self.frequency
    }
    /// Speed φ'(t).
    pub fn speed(&self, t: f64) -> f64 {
        let ([t0, speed, _], slope) = self.piece(t);
        speed + slope * (t - t0) + speed * self.swing * libm::cos(self.frequency * t)
    }
    /// Acceleration φ''(t). `side`: before or after a jump at `t`.
    pub fn acceleration(&self, t: f64, side: Side) -> f64 {
        let at = |next: usize| {
            let ([_, speed, _], slope) = self.piece_before(next);
            slope - speed * self.swing * self.frequency * libm::sin(self.frequency * t)
        };
        match side {
            Side::Before => at(self.knots.partition_point(|knot| knot[0] < t)),
            Side::After => at(self.knots.partition_point(|knot| knot[0] <= t)),
        }
    }
    /// The time t at which φ(t) = `angle` `[rad]`.
    ///
    /// Between two knots δ = ω dt + α dt²/2 is solved for dt = 2 δ/(ω + √(ω² + 2 α δ)). With a fluctuation
    /// the equation is solved by Newton's method with bisection as a safeguard.
    pub fn time(&self, angle: f64) -> f64 {
        if self.swing > 0.0 {
            return self.time_in_fluctuation(angle);
        }
        let ([t0, speed, reached], slope) =
            self.piece_before(self.knots.partition_point(|knot| knot[2] <= angle));
        let ahead = angle - reached;
        // In this form of the root no digits cancel.
        t0 + 2.0 * ahead / (speed + (speed * speed + 2.0 * slope * ahead).max(0.0).sqrt())
    }

    /// Solves x + a sin x = y for x = ft, with y = fφ/ω. For y > 0 the root lies between max(y - a, y/(1 +
    /// a)) and y + a. A Newton step x ← x - (x + a sin x - y)/(1 + a cos x) that leaves these bounds is
    /// replaced by their mean.
    fn time_in_fluctuation(&self, angle: f64) -> f64 {
        let target = self.frequency * angle.abs() / self.knots[0][1];
        let lo = (target - self.swing).max(target / (1.0 + self.swing));
        let x = Bracket { lo, hi: target + self.swing }.solve(lo, true, rounding, |x| {
            let (sine, cosine) = libm::sincos(x);
            (x + self.swing * sine - target, 1.0 + self.swing * cosine)
        });
        (x / self.frequency).copysign(angle)
    }
    /// The time of the first knot after `t`.
    fn next_corner(&self, t: f64) -> Option<f64> {
        self.knots.iter().map(|knot| knot[0]).find(|knot| *knot > t)
    }
}

/// A [`Machine`] whose reference body follows a [`SpeedLaw`] instead of turning at constant speed.
///
/// The reference body of a train is the one that [`Parts::build`](crate::trains::Parts::build) names; another
/// one is named here ([`of_body`](VaryingSpeed::of_body)). Shapes without bodies have the angle of their
/// waves ([`Shape::reference_ratio`]).
///
/// Waves are evaluated at their angle φ(t). φ' and φ'' follow from the law, so that second derivatives of
/// excitations are exact, d²e/dt² = e'' φ'² + e' φ'', and the inertia of the bodies acts against φ''
/// ([`Shape::inertia`]).
///
/// ```
/// use gear_dynamics::{Dop853, Integrator, NfgPair, NfgParams, drives::{SpeedLaw, VaryingSpeed}};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let (start, speed) = (pair.on_drive_flank()?, pair.speed());
/// let run_up = VaryingSpeed::new(pair, SpeedLaw::ramp(speed, 1.2 * speed, 20_000.0)?);
/// let end = Dop853::new().rtol(1e-8).atol(1e-14).end(&run_up, &start, 1000.0)?;
/// assert!((-1.2e-3..-4e-4).contains(&end.q[0])); // on the drive flank
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type VaryingSpeed<G> = Wrapped<Machine<G>, LawOfBody>;

impl<G: Shape> VaryingSpeed<G> {
    /// A machine whose reference body follows a speed law. The constant `speed` has no effect on it.
    pub fn new(model: Machine<G>, law: SpeedLaw) -> Self {
        let ratio = model.shape().reference_ratio();
        Wrapped::by_rule(model, LawOfBody { law, ratio })
    }
    /// A machine of which a named body follows a speed law.
    ///
    /// ```
    /// use gear_dynamics::{Model, Wave, drives::{SpeedLaw, VaryingSpeed}, excitation::Side};
    /// use gear_dynamics::trains::{Body, MeshPart, Parts};
    /// let mut parts = Parts::new();
    /// parts.body("pinion", Body::new(2e-3)).body("wheel", Body::new(8e-3));
    /// parts.mesh("mesh", "pinion", "wheel", MeshPart::external([20, 40], [0.03, 0.06], Wave::constant(2e8)?));
    /// let train = parts.build("pinion", 100.0)?;
    /// let run_up = VaryingSpeed::of_body(train, "wheel", SpeedLaw::ramp(10.0, 30.0, 4.0)?)?;
    /// let mut u = vec![0.0; run_up.drives()];
    /// run_up.drive(1.0, Side::After, &mut u);
    /// let speed = run_up.bare().size().waves; // φ' stands after the waves
    /// assert_eq!(u[speed..][..2], [30.0, 10.0]); // φ is the angle of the pinion
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ParameterError::NoSuchBody`] for a body that the machine does not have, that does not turn, or that
    /// turns unevenly.
    pub fn of_body(model: Machine<G>, body: &str, law: SpeedLaw) -> Result<Self, ParameterError> {
        let known = model.shape().bodies();
        let Some(&(_, ratio)) = known.iter().find(|(name, _)| *name == body) else {
            let names = known.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
            let none = "none, `VaryingSpeed::new` takes the law of the reference body";
            let known = if names.is_empty() { none.into() } else { names };
            return Err(ParameterError::NoSuchBody { body: body.into(), known });
        };
        Ok(Wrapped::by_rule(model, LawOfBody { law, ratio }))
    }
}

/// The rule of [`VaryingSpeed`]: the speed law of a body, and the angle of the waves over the angle of the
/// body.
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, drives::{SpeedLaw, VaryingSpeed}};
/// let law = SpeedLaw::constant(2.0)?;
/// let pair = VaryingSpeed::new(NfgPair::new(&NfgParams::table1())?, law.clone());
/// assert_eq!((pair.rule().law(), pair.rule().ratio()), (&law, 1.0));
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct LawOfBody {
    law: SpeedLaw,
    ratio: f64,
}

impl LawOfBody {
    /// The law of the body.
    pub fn law(&self) -> &SpeedLaw {
        &self.law
    }
    /// Angle of the waves over the angle of the body.
    pub fn ratio(&self) -> f64 {
        self.ratio
    }
    // The same functions as those of the law, for the angle of the waves.
    fn angle(&self, t: f64) -> f64 {
        self.ratio * self.law.angle(t)
    }
    fn speed(&self, t: f64) -> f64 {
        self.ratio * self.law.speed(t)
    }
    fn acceleration(&self, t: f64, side: Side) -> f64 {
        self.ratio * self.law.acceleration(t, side)
    }
    fn expanded(&self, t: Series) -> [Series; 3] {
        self.law.expanded(t).map(|of_body| of_body * self.ratio)
    }
    fn time(&self, angle: f64) -> f64 {
        self.law.time(angle / self.ratio)
    }
    fn next_corner(&self, t: f64) -> Option<f64> {
        self.law.next_corner(t)
    }
}

/// Two angles `[rad]`, one on each side of φ: φ ± max(1e-9, 64 ε |φ|, 64 ε |φ' t|) with ε = 2.2e-16. A drive
/// edge between these angles counts as a drive edge at φ. The second number exceeds the rounding error of φ.
/// The third number exceeds the angle through which the shaft turns in the rounding error of t. So the time
/// of the next edge is later than t.
///
/// One rule decides for an angle and an edge: the edges that the shape gives after the angle ahead are
/// announced, and where others lie between the two angles, the values after φ are those at the angle ahead.
/// Both ask the shape at the same number. So no distance falls between the two cases.
fn aside([angle, turned]: [f64; 2]) -> [f64; 2] {
    let near = (64.0 * f64::EPSILON * angle.abs().max(turned.abs())).max(1e-9);
    [angle - near, angle + near]
}

/// The angle φ of [φ, φ' t], or the angle aside if edges lie on it.
fn beside_edges(model: &dyn Code, place: [f64; 2], side: Side) -> f64 {
    let ([angle, _], [behind, ahead]) = (place, aside(place));
    let first = model.edge_after(behind);
    match side {
        _ if first.is_none() || first == model.edge_after(ahead) => angle,
        Side::Before => behind,
        Side::After => ahead,
    }
}

impl<G: Shape> DriveRule<Machine<G>> for LawOfBody {
    fn drive(&self, model: &Machine<G>, t: f64, side: Side, u: &mut [f64]) {
        let speed = self.speed(t);
        let angle = beside_edges(&**model, [self.angle(t), speed * t], side);
        model.drives_at(angle, side, [speed, self.acceleration(t, side)], u);
    }
    fn changes(&self, model: &Machine<G>, drive: usize) -> bool {
        let waves = model.size().waves;
        drive == waves || drive == waves + 1 // φ' and φ''
    }
    fn series(&self, model: &Machine<G>, t: f64, coefficients: usize, u: &mut [Series]) {
        let [angle, speed, acceleration] = self.expanded(Series::variable(t, 1.0, coefficients));
        let moved = beside_edges(&**model, [angle.at(0.0), speed.at(0.0) * t], Side::After);
        let ahead = (moved - angle.at(0.0)) / speed.at(0.0);
        model.drive_series_at([angle.moved_to(moved), speed, acceleration], u);
        if ahead != 0.0 {
            // Beside an edge the waves are those of a slightly later instant.
            u[..model.size().waves].iter_mut().for_each(|wave| *wave = wave.later(-ahead));
        }
    }
    fn next_edge(&self, model: &Machine<G>, t: f64) -> Option<f64> {
        let [_, ahead] = aside([self.angle(t), self.speed(t) * t]);
        let edge = model.edge_after(ahead).map(|edge| self.time(edge));
        earlier(edge, self.next_corner(t))
    }
    fn next_knot(&self, model: &Machine<G>, t: f64) -> Option<f64> {
        Some(self.time(model.knot_after(self.angle(t))?))
    }
}
