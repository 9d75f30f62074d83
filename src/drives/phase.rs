//! Running up, coasting down and speed that fluctuates: a phase that is not ωt.

use crate::drives::wrapped::{DriveRule, Wrapped};
use crate::error::{ParameterError, check};
use crate::excitation::angle::earlier;
use crate::excitation::side::Side;
use crate::model::machine::Machine;
use crate::model::shape::Shape;

/// How the phase φ of the drives runs: its speed φ'(t) > 0 over the model's time, and φ(0) = 0.
///
/// ```
/// use gear_dynamics::drives::PhaseLaw;
/// let run_up = PhaseLaw::ramp(10.0, 30.0, 4.0)?; // [rad/s] over 4 s, then constant
/// assert_eq!((run_up.speed(2.0), run_up.phase(4.0), run_up.phase(5.0)), (20.0, 80.0, 110.0));
/// assert!((run_up.time(35.0) - 2.242_640_687).abs() < 1e-8);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct PhaseLaw {
    /// Times, speeds and phases at the knots; the speed is linear between them and constant outside.
    knots: Vec<[f64; 3]>,
    /// Amplitude over the mean speed and frequency of a sinusoidal fluctuation on top.
    swing: f64,
    frequency: f64,
}

impl PhaseLaw {
    /// φ = ωt.
    ///
    /// # Errors
    /// A speed outside 1e-50 .. 1e50.
    pub fn constant(speed: f64) -> Result<Self, ParameterError> {
        PhaseLaw::table(&[0.0], &[speed])
    }

    /// From one speed to another within a time: run-up or coast-down.
    ///
    /// # Errors
    /// Speeds or a duration outside 1e-50 .. 1e50.
    pub fn ramp(from: f64, to: f64, duration: f64) -> Result<Self, ParameterError> {
        check::scale("duration of the ramp", duration)?;
        PhaseLaw::table(&[0.0, duration], &[from, to])
    }

    /// φ' = ω (1 + a cos ft), φ = ω (t + a sin(ft)/f): the amplitude a in [0, 1).
    ///
    /// # Errors
    /// A speed or frequency outside 1e-50 .. 1e50, an amplitude outside [0, 1).
    pub fn fluctuation(speed: f64, amplitude: f64, frequency: f64) -> Result<Self, ParameterError> {
        let swing = check::fraction("amplitude of the fluctuation", amplitude)?;
        let frequency = check::scale("frequency of the fluctuation", frequency)?;
        Ok(PhaseLaw { swing, frequency, ..PhaseLaw::constant(speed)? })
    }

    /// Speeds at increasing times, the first of which is 0; linear between them, constant afterwards.
    ///
    /// # Errors
    /// Lists of different lengths or empty ones; times out of order, or not 1e-50 .. 1e50 apart; speeds outside 1e-50 .. 1e50.
    pub fn table(times: &[f64], speeds: &[f64]) -> Result<Self, ParameterError> {
        check::length("speeds of the phase law", speeds.len(), times.len())?;
        if times.is_empty() {
            return Err(ParameterError::Empty { name: "times of the phase law".into(), least: 1 });
        }
        check::quantities("times of the phase law", times)?;
        let mut knots: Vec<[f64; 3]> = Vec::with_capacity(times.len());
        for (i, (&t, &speed)) in times.iter().zip(speeds).enumerate() {
            let speed = check::scale(format!("speeds[{i}] of the phase law"), speed)?;
            match knots.last() {
                None if t != 0.0 => {
                    return Err(ParameterError::OutOfRange {
                        name: "times[0] of the phase law".into(),
                        value: t,
                        allowed: "0",
                    });
                }
                None => knots.push([0.0, speed, 0.0]),
                Some(&[before, last, phase]) => {
                    let after = check::scale(
                        format!("times[{i}] less the one before it, of the phase law"),
                        t - before,
                    )?;
                    knots.push([t, speed, phase + 0.5 * after * (last + speed)]);
                }
            }
        }
        Ok(PhaseLaw { knots, swing: 0.0, frequency: 1.0 })
    }

    /// The last knot at or before `t`, and the acceleration after it.
    fn piece(&self, t: f64) -> ([f64; 3], f64) {
        self.piece_before(self.knots.partition_point(|knot| knot[0] <= t))
    }

    /// The knot before knot `next`, and the acceleration between the two; there is none outside all knots.
    fn piece_before(&self, next: usize) -> ([f64; 3], f64) {
        let knot = self.knots[next.saturating_sub(1)];
        let slope = match self.knots.get(next) {
            Some(after) if next > 0 => (after[1] - knot[1]) / (after[0] - knot[0]),
            _ => 0.0,
        };
        (knot, slope)
    }

    /// φ(t) `[rad]`.
    pub fn phase(&self, t: f64) -> f64 {
        let ([t0, speed, phase], slope) = self.piece(t);
        let dt = t - t0;
        phase
            + dt * (speed + 0.5 * slope * dt)
            + speed * self.swing * libm::sin(self.frequency * t) / self.frequency
    }
    /// φ'(t).
    pub fn speed(&self, t: f64) -> f64 {
        let ([t0, speed, _], slope) = self.piece(t);
        speed + slope * (t - t0) + speed * self.swing * libm::cos(self.frequency * t)
    }
    /// φ''(t), seen from one side.
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
    /// When the phase is reached.
    ///
    /// Between two knots δ = ω dt + α dt²/2 is solved for dt; with a fluctuation the phase is met by Newton steps.
    pub fn time(&self, phase: f64) -> f64 {
        if self.swing > 0.0 {
            return self.time_in_fluctuation(phase);
        }
        let ([t0, speed, reached], slope) =
            self.piece_before(self.knots.partition_point(|knot| knot[2] <= phase));
        let ahead = phase - reached;
        // The form of the root that does not cancel.
        t0 + 2.0 * ahead / (speed + (speed * speed + 2.0 * slope * ahead).max(0.0).sqrt())
    }

    /// The root x = ft of x + a sin x = y with y = fφ/ω. For y > 0 it lies between max(y - a, y/(1 + a)) and y + a.
    fn time_in_fluctuation(&self, phase: f64) -> f64 {
        let target = self.frequency * phase.abs() / self.knots[0][1];
        let (mut lo, mut hi) = ((target - self.swing).max(target / (1.0 + self.swing)), target + self.swing);
        let mut x = lo;
        for _ in 0..200 {
            let (sine, cosine) = libm::sincos(x);
            let off = x + self.swing * sine - target;
            if off == 0.0 {
                break;
            }
            if off > 0.0 {
                hi = x
            } else {
                lo = x
            }
            let newton = x - off / (1.0 + self.swing * cosine);
            let next = if newton > lo && newton < hi { newton } else { 0.5 * (lo + hi) };
            let step = (next - x).abs();
            x = next;
            if step <= 2.0 * f64::EPSILON * x || hi <= lo {
                break;
            }
        }
        (x / self.frequency).copysign(phase)
    }
    fn next_knot(&self, t: f64) -> Option<f64> {
        self.knots.iter().map(|knot| knot[0]).find(|knot| *knot > t)
    }
}

/// A [`Machine`] whose angle follows a phase law in place of constant speed.
///
/// Its waves are those of the angle φ(t); φ' and φ'' are those of the law, so that second derivatives of excitations are exact:
/// d²e/dt² = e'' φ'² + e' φ''.
///
/// ```
/// use gear_dynamics::{Dop853, Integrator, NfgPair, NfgParams, drives::{PhaseLaw, VaryingSpeed}};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let (start, speed) = (pair.static_start()?, pair.centre_frequency());
/// let run_up = VaryingSpeed::new(pair, PhaseLaw::ramp(speed, 1.2 * speed, 20_000.0)?);
/// let end = Dop853::new().rtol(1e-8).atol(1e-14).end(&run_up, &start, 1000.0)?;
/// assert!((-1.2e-3..-4e-4).contains(&end.q[0])); // on the drive flank
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type VaryingSpeed<G> = Wrapped<Machine<G>, PhaseLaw>;

impl<G: Shape> VaryingSpeed<G> {
    /// The same machine with its angle following a law.
    pub fn new(model: Machine<G>, law: PhaseLaw) -> Self {
        Wrapped::by_rule(model, law)
    }
    /// The law.
    pub fn law(&self) -> &PhaseLaw {
        self.rule()
    }
}

/// How near to an edge counts as on it, and how far from it its sides are looked at `[rad]`: 1e-9, or what rounding leaves of a large phase.
fn aside(phase: f64) -> f64 {
    (16.0 * f64::EPSILON * phase.abs()).max(1e-9)
}

impl<G: Shape> DriveRule<Machine<G>> for PhaseLaw {
    fn drive(&self, model: &Machine<G>, t: f64, side: Side, u: &mut [f64]) {
        let phase = self.phase(t);
        // Where an edge is, by rounding, its side is looked at.
        let near = aside(phase);
        let phase = match model.shape().next_edge(phase - near).filter(|edge| *edge <= phase + near) {
            Some(edge) if side == Side::Before => edge - near,
            Some(edge) => edge + near,
            None => phase,
        };
        model.drive_at(phase, side, self.speed(t), self.acceleration(t, side), u);
    }
    fn next_edge(&self, model: &Machine<G>, t: f64) -> Option<f64> {
        let phase = self.phase(t);
        let edge = model.shape().next_edge(phase + 2.0 * aside(phase)).map(|edge| self.time(edge));
        earlier(edge.filter(|edge| *edge > t), self.next_knot(t))
    }
}
