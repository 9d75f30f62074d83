//! An excitation on a shaft.

use crate::error::{ParameterError, check};
use crate::excitation::angle::Excitation;
use crate::excitation::jet::Jet;
use crate::excitation::side::Side;
use std::any::Any;
use std::f64::consts::TAU;
use std::sync::Arc;

/// f(n φ + ψ): an [`Excitation`] f on a shaft of angle φ, n times a turn, ahead by the phase ψ. Copies share the function.
///
/// Two waves are equal if order and phase are and the function is the same one, or says that it is the same
/// ([`Excitation::same_as`]).
///
/// ```
/// use gear_dynamics::{excitation::{Fourier, Side}, Wave};
/// let teeth = Wave::new(Fourier::new(1.0, &[[0.2, 0.0]])?).per_turn(30)?; // 1 + 0.2 cos 30 φ
/// let jet = teeth.jet(0.1, Side::After);
/// assert!((jet.value - (1.0 + 0.2 * 3f64.cos())).abs() < 1e-15);
/// assert!((jet.rate + 6.0 * 3f64.sin()).abs() < 1e-14);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Wave {
    excitation: Arc<dyn Excitation>,
    /// n.
    order: u32,
    /// ψ in [0, 2π).
    ahead: f64,
    /// Edges of the excitation in [0, 2π), increasing.
    edges: Arc<[f64]>,
}

/// An angle this near to an edge lies on it: rounding of n φ, as a share of it, and at the least.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

const NEAR: f64 = 1e-13;

/// From how far the sides of an edge are seen `[rad]`.
const ASIDE: f64 = 1e-12;

/// Edges that are nearer to one another than this are one.
const APART: f64 = 4.0 * ASIDE;

/// Beyond this angle edges can no longer be told apart in floating point.
const FARTHEST: f64 = 1e12;

/// Most edges in a turn of the shaft.
const MOST_EDGES: usize = 1 << 20;

impl Wave {
    /// f(φ).
    pub fn new(excitation: impl Excitation) -> Self {
        let mut edges: Vec<f64> = excitation
            .edges()
            .iter()
            .filter(|edge| edge.is_finite())
            .map(|edge| edge.rem_euclid(TAU) % TAU)
            .collect();
        edges.sort_by(f64::total_cmp);
        edges.dedup_by(|next, edge| *next - *edge < APART);
        if let (Some(first), Some(last)) = (edges.first(), edges.last())
            && edges.len() > 1
            && first + TAU - last < APART
        {
            edges.pop();
        }
        Wave { excitation: Arc::new(excitation), order: 1, ahead: 0.0, edges: edges.into() }
    }

    /// A constant.
    ///
    /// # Errors
    /// A value beyond ±1e50.
    pub fn constant(value: f64) -> Result<Self, ParameterError> {
        Ok(Wave::new(crate::excitation::angle::Constant::new(value)?))
    }

    /// The same wave `order` times as often in a turn: teeth on a shaft, blades on a wheel.
    ///
    /// # Errors
    /// An order of 0; orders of more than a million together, or more than a million edges in a turn.
    pub fn per_turn(self, order: u32) -> Result<Self, ParameterError> {
        if order == 0 {
            return Err(ParameterError::TooFew { name: "order of a wave".into(), value: 0, least: 1 });
        }
        let orders = [self.order as usize, order as usize];
        let order = check::count("order of a wave", &orders, check::TEETH)? as u32;
        check::count("edges of a wave in a turn", &[order as usize, self.edges.len()], MOST_EDGES)?;
        Ok(Wave { order, ..self })
    }

    /// The same wave ahead by a phase `[rad]` of its own: f(n φ + ψ).
    ///
    /// # Errors
    /// A phase beyond ±1e50.
    pub fn ahead(self, phase: f64) -> Result<Self, ParameterError> {
        let ahead = (self.ahead + check::quantity("phase of a wave", phase)?).rem_euclid(TAU) % TAU;
        Ok(Wave { ahead, ..self })
    }

    /// n: how often it repeats in a turn of the shaft.
    pub fn order(&self) -> u32 {
        self.order
    }
    /// How many edges it has in a turn of the shaft.
    pub fn edges_per_turn(&self) -> usize {
        self.order as usize * self.edges.len()
    }
    /// ψ in [0, 2π).
    pub fn phase(&self) -> f64 {
        self.ahead
    }

    /// Value, first and second derivative over the angle of the shaft, at any angle, seen from one side.
    #[inline]
    pub fn jet(&self, angle: f64, side: Side) -> Jet {
        let n = f64::from(self.order);
        let Jet { value, rate, second } = self.excitation.jet(self.own(angle, side));
        Jet { value, rate: n * rate, second: n * n * second }
    }
    /// The value alone.
    #[inline]
    pub fn value(&self, angle: f64, side: Side) -> f64 {
        self.excitation.value(self.own(angle, side))
    }

    /// The value of this wave and the jet of another one: one reduction of the angle where both are of one order and phase, and smooth.
    #[inline]
    pub(crate) fn value_beside(&self, other: &Wave, angle: f64, side: Side) -> (f64, Jet) {
        if self.order != other.order
            || self.ahead != other.ahead
            || !self.edges.is_empty()
            || !other.edges.is_empty()
        {
            return (self.value(angle, side), other.jet(angle, side));
        }
        let (own, n) = (self.own(angle, side), f64::from(self.order));
        let (value, Jet { value: other, rate, second }) =
            (self.excitation.value(own), other.excitation.jet(own));
        (value, Jet { value: other, rate: n * rate, second: n * n * second })
    }

    /// n φ + ψ in [0, 2π), aside where an edge is.
    #[inline]
    fn own(&self, angle: f64, side: Side) -> f64 {
        let far = f64::from(self.order) * angle + self.ahead;
        let own = reduced(far);
        if self.edges.is_empty() { own } else { self.aside(own, far, side) }
    }

    fn aside(&self, own: f64, far: f64, side: Side) -> f64 {
        let near = NEAR.max(ROUNDING * far.abs());
        let next = self.edges.partition_point(|edge| *edge < own);
        let [before, after] = self.neighbours(next);
        let edge = if (after - own).abs() <= (own - before).abs() { after } else { before };
        if (edge - own).abs() > near {
            return own;
        }
        reduced(edge + if side == Side::Before { -ASIDE } else { ASIDE })
    }

    /// The edges before and at place `next`, those of the turns before and after among them.
    fn neighbours(&self, next: usize) -> [f64; 2] {
        let last = self.edges[self.edges.len() - 1];
        let before = if next == 0 { last - TAU } else { self.edges[next - 1] };
        let after = self.edges.get(next).copied().unwrap_or(self.edges[0] + TAU);
        [before, after]
    }

    /// The first angle of the shaft after `angle` at which the wave or a derivative jumps.
    pub fn next_edge(&self, angle: f64) -> Option<f64> {
        let n = f64::from(self.order);
        let far = n * angle + self.ahead;
        if self.edges.is_empty() || far.abs() > FARTHEST {
            return None;
        }
        // An edge that the angle lies on, by rounding, is not after it.
        let near = NEAR.max(ROUNDING * far.abs());
        let turns = (far / TAU).floor();
        let own = far - turns * TAU + 2.0 * near;
        let next = self.edges.partition_point(|edge| *edge <= own);
        let edge = match self.edges.get(next) {
            Some(edge) => *edge,
            None => self.edges[0] + if self.edges[0] + TAU > own { TAU } else { 2.0 * TAU },
        };
        let at = (turns * TAU + edge - self.ahead) / n;
        (at > angle).then_some(at)
    }

    /// The greatest common divisor of the orders of waves, constants left out: how often they all repeat in a turn of the shaft.
    ///
    /// ```
    /// use gear_dynamics::{excitation::Fourier, Wave};
    /// let wave = Wave::new(Fourier::new(1.0, &[[0.2, 0.0]])?);
    /// let (teeth, blades, mean) = (wave.clone().per_turn(30)?, wave.per_turn(12)?, Wave::constant(2.0)?);
    /// assert_eq!(Wave::common_order([&teeth, &blades, &mean]), 6);
    /// # Ok::<(), gear_dynamics::ParameterError>(())
    /// ```
    pub fn common_order<'w>(waves: impl IntoIterator<Item = &'w Wave>) -> u32 {
        Wave::divisor_of_orders(waves).max(1)
    }
    /// The same, 0 if all are constants.
    pub(crate) fn divisor_of_orders<'w>(waves: impl IntoIterator<Item = &'w Wave>) -> u32 {
        let varies =
            |wave: &&Wave| !(&*wave.excitation as &dyn Any).is::<crate::excitation::angle::Constant>();
        waves.into_iter().filter(varies).fold(0, |common, wave| divisor(common, wave.order))
    }

    /// All edges in [0, 2π) of the shaft.
    pub(crate) fn edges_of_a_turn(&self) -> Vec<f64> {
        let n = f64::from(self.order);
        let turns = |edge: &f64| {
            let own = (edge - self.ahead).rem_euclid(TAU);
            (0..self.order).map(move |k| (own + TAU * f64::from(k)) / n)
        };
        self.edges.iter().flat_map(turns).collect()
    }

    /// Whether both hold one and the same function, not only an equal one.
    pub(crate) fn is(&self, other: &Wave) -> bool {
        Arc::ptr_eq(&self.excitation, &other.excitation)
            && self.order == other.order
            && self.ahead == other.ahead
    }
}

/// The greatest common divisor; that of a number and 0 is the number.
pub(crate) fn divisor(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { divisor(b, a % b) }
}

/// An angle within [0, 2π).
#[inline]
pub(crate) fn reduced(angle: f64) -> f64 {
    if (0.0..TAU).contains(&angle) {
        return angle;
    }
    // Whole turns by a conversion: a call of `floor` costs more than all the rest.
    let turns = (angle / TAU) as i64 as f64;
    let own = angle - TAU * turns;
    let own = if own < 0.0 { own + TAU } else { own };
    if (0.0..TAU).contains(&own) { own } else { 0.0 }
}

impl PartialEq for Wave {
    fn eq(&self, other: &Self) -> bool {
        self.is(other)
            || (self.order == other.order
                && self.ahead == other.ahead
                && self.excitation.same_as(&*other.excitation))
    }
}
