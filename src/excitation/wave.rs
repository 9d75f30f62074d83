//! Waves: excitations on a shaft.

use crate::error::{ParameterError, check};
use crate::excitation::any_excitation::AnyExcitation;
use crate::excitation::enclosed_angle::EnclosedAngle;
use crate::excitation::fourier::Fourier;
use crate::excitation::jet::Jet;
use crate::excitation::side::Side;
use crate::interval::number::Interval;
use crate::numeric::gauss;
use crate::series::{PowerSeries, Series};
use std::f64::consts::TAU;
use std::sync::Arc;

/// A wave f(n φ + ψ) of the angle φ of a shaft.
///
/// f is an [`Excitation`](crate::excitation::Excitation), n the whole order and ψ the phase. Copies
/// share the function.
///
/// Two waves are equal if their orders and phases are equal and they share the function or have equal ones.
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
    excitation: Arc<dyn AnyExcitation>,
    /// Order n.
    order: u32,
    /// Phase ψ in [0, 2π).
    phase: f64,
    /// Edges of the excitation in [0, 2π), increasing.
    edges: Arc<[f64]>,
    /// Knots of the excitation in [0, 2π), increasing.
    knots: Arc<[f64]>,
    /// Whether the excitation is no constant.
    varies: bool,
}

/// Rounding of n φ + ψ, as a share of it. If n φ + ψ is within its rounding of an edge of the excitation (a
/// jump of f or of a derivative), it lies on that edge.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Lower bound of that rounding `[rad]`.
const NEAR: f64 = 1e-13;

/// Distance from an edge within which an angle lies on it: its rounding and that of the edge.
///
/// One rule decides for an angle and an edge, in [`Wave::jet`] and in [`Wave::next_edge`], with the same
/// numbers: if edge - (n φ + ψ) <= near, the values after the angle are those beyond the edge; otherwise the
/// edge is announced. So no distance falls between the two cases. Several edges on one angle are all behind
/// the side `After` and all ahead of the side `Before`.
fn near(far: f64) -> f64 {
    2.0 * NEAR.max(ROUNDING * far.abs())
}

/// Distance from an edge at which the values before and after it are evaluated `[rad]`.
const ASIDE: f64 = 1e-12;

/// Edges with a smaller distance from each other count as one `[rad]`. The values after the first one are
/// evaluated beyond all of them.
const APART: f64 = 0.5 * ASIDE;

/// Largest |n φ + ψ| `[rad]` at which edges are announced. The resolution of `f64` is too coarse beyond it.
const FARTHEST: f64 = 1e12;

/// Maximum number of edges in a turn of the shaft.
const MAX_EDGES: usize = 1 << 20;

impl Wave {
    /// The wave of an excitation with these edges and knots: order 1, phase 0.
    pub(crate) fn of_any(excitation: Arc<dyn AnyExcitation>, edges: &[f64], knots: &[f64]) -> Self {
        let [edges, knots] = [edges, knots].map(in_order);
        let varies = excitation.pairs().is_none_or(|(_, pairs)| pairs.iter().any(|pair| *pair != [0.0; 2]));
        Wave { excitation, order: 1, phase: 0.0, edges: edges.into(), knots: knots.into(), varies }
    }

    /// The same wave, repeated `order` times as often in a turn of the shaft, for example once for each
    /// tooth of a gear or each blade of a wheel. Orders of repeated calls are multiplied.
    ///
    /// # Errors
    /// An order of 0; a product of the orders above 1 000 000; more than 2²⁰ edges in a turn.
    pub fn per_turn(self, order: u32) -> Result<Self, ParameterError> {
        if order == 0 {
            return Err(ParameterError::TooFew { name: "order of a wave".into(), value: 0, min: 1 });
        }
        let orders = [self.order as usize, order as usize];
        let order = check::count("order of a wave", &orders, check::TEETH)? as u32;
        check::count("edges of a wave in a turn", &[order as usize, self.edges.len()], MAX_EDGES)?;
        Ok(Wave { order, ..self })
    }

    /// The same wave with its order divided by a common order of several waves; a constant stays as it is.
    pub(crate) fn slower(self, common: u32) -> Self {
        if self.order.is_multiple_of(common) { Wave { order: self.order / common, ..self } } else { self }
    }

    /// The same wave with a phase `[rad]` added to ψ: f(n φ + ψ). 2π is one period of the excitation, not
    /// one turn of the shaft.
    ///
    /// # Errors
    /// A phase beyond ±1e50.
    pub fn with_phase(self, phase: f64) -> Result<Self, ParameterError> {
        let phase = (self.phase + check::quantity("phase of a wave", phase)?).rem_euclid(TAU) % TAU;
        Ok(Wave { phase, ..self })
    }

    /// Order n: the number of repetitions in a turn of the shaft.
    pub fn order(&self) -> u32 {
        self.order
    }
    /// Number of edges in a turn of the shaft.
    pub(crate) fn edges_per_turn(&self) -> usize {
        self.order as usize * self.edges.len()
    }
    /// Phase ψ `[rad]` in [0, 2π).
    pub fn phase(&self) -> f64 {
        self.phase
    }

    /// The mean over a period, (1/T) ∫ f dx, by Gauss quadrature on 64 panels between the edges. Its error is
    /// rounding for functions that a polynomial of degree 7 follows on a panel.
    ///
    /// ```
    /// use gear_dynamics::{excitation::Fourier, Wave};
    /// let wave = Wave::new(Fourier::new(3.0, &[[0.2, 0.1]])?).per_turn(30)?;
    /// assert!((wave.mean() - 3.0).abs() < 1e-14);
    /// # Ok::<(), gear_dynamics::ParameterError>(())
    /// ```
    pub fn mean(&self) -> f64 {
        const PANELS: usize = 64;
        let period = TAU / f64::from(self.order);
        let (mut sum, mut angle) = (0.0, 0.0);
        while angle < period {
            let end = self.next_edge(angle).map_or(period, |edge| edge.min(period));
            for i in 0..PANELS {
                let h = (end - angle) / PANELS as f64;
                let middle = angle + (i as f64 + 0.5) * h;
                sum += gauss::integral(middle - 0.5 * h, middle + 0.5 * h, |x| self.value_at(x, Side::After));
            }
            angle = end;
        }
        sum / period
    }

    #[inline]
    pub(crate) fn jet_at(&self, angle: f64, side: Side) -> Jet {
        let n = f64::from(self.order);
        let Jet { value, rate, second } = self.excitation.jet_at(self.own(angle, side));
        Jet { value, rate: n * rate, second: n * n * second }
    }
    #[inline]
    pub(crate) fn value_at(&self, angle: f64, side: Side) -> f64 {
        self.excitation.value_at(self.own(angle, side))
    }

    /// The excitation, and its own angle n φ + ψ as a series of time.
    pub(crate) fn own_series(&self, angle: Series, side: Side) -> (&dyn AnyExcitation, Series) {
        let own = self.own(angle.at(0.0), side);
        (&*self.excitation, (angle * f64::from(self.order)).moved_to(own))
    }

    /// The enclosure of the excitation at its own angle n φ + ψ.
    pub(crate) fn enclosure(&self, own: EnclosedAngle) -> Jet<PowerSeries<Interval>> {
        self.excitation.jet_enclosure(own)
    }

    /// The wave as a finite Fourier series over the angle of the shaft, if it is one.
    pub(crate) fn fourier(&self) -> Option<Fourier> {
        if !self.edges.is_empty() {
            return None;
        }
        let (mean, pairs) = self.excitation.pairs()?;
        Fourier::new(mean, &pairs).ok()?.repeated(self.order, self.phase)
    }

    /// n φ + ψ in [0, 2π), moved to one side of an edge on which it lies.
    #[inline]
    fn own(&self, angle: f64, side: Side) -> f64 {
        let far = f64::from(self.order) * angle + self.phase;
        let own = reduced(far);
        if self.edges.is_empty() { own } else { self.aside(own, far, side) }
    }

    /// An angle in [0, 2π), moved to one side of an edge on which it lies. `far`: n φ + ψ, whose rounding
    /// counts.
    fn aside(&self, own: f64, far: f64, side: Side) -> f64 {
        let near = near(far);
        let [before, after] = match side {
            Side::Before => self.neighbours(self.edges.partition_point(|edge| own - *edge > near)),
            Side::After => self.neighbours(self.edges.partition_point(|edge| *edge - own <= near)),
        };
        // At the ends of a turn both neighbours may lie on the angle.
        let [met_before, met_after] = [own - before <= near, after - own <= near];
        match side {
            Side::Before if met_before => reduced(before - ASIDE),
            Side::Before if met_after => reduced(after - ASIDE),
            Side::After if met_after => reduced(after + ASIDE),
            Side::After if met_before => reduced(before + ASIDE),
            _ => own,
        }
    }

    /// The edges at the places `next` - 1 and `next`, continued periodically at both ends of the list.
    fn neighbours(&self, next: usize) -> [f64; 2] {
        let last = self.edges[self.edges.len() - 1];
        let before = if next == 0 { last - TAU } else { self.edges[next - 1] };
        let after = self.edges.get(next).copied().unwrap_or(self.edges[0] + TAU);
        [before, after]
    }

    /// The first angle of the shaft after `angle` at which the wave or a derivative jumps. `None` if there
    /// are no edges or |n φ + ψ| is above 1e12 rad.
    pub fn next_edge(&self, angle: f64) -> Option<f64> {
        self.next_of(&self.edges, angle)
    }

    /// The first knot of the wave after `angle`, as an angle of the shaft. At a knot the value and the first
    /// two derivatives are continuous, and a higher derivative jumps. `None` as for
    /// [`next_edge`](Wave::next_edge).
    ///
    /// ```
    /// use gear_dynamics::{Wave, excitation::Table};
    /// let measured = Wave::new(Table::new(&[1.0, 1.2, 1.1, 0.9])?).per_turn(2)?;
    /// assert_eq!((measured.next_edge(0.1), measured.next_knot(0.1)), (None, Some(std::f64::consts::FRAC_PI_4)));
    /// # Ok::<(), gear_dynamics::ParameterError>(())
    /// ```
    pub fn next_knot(&self, angle: f64) -> Option<f64> {
        self.next_of(&self.knots, angle)
    }

    /// The first angle of the shaft after `angle` at one of these places of the excitation.
    fn next_of(&self, places: &[f64], angle: f64) -> Option<f64> {
        let n = f64::from(self.order);
        let far = n * angle + self.phase;
        if places.is_empty() || far.abs() > FARTHEST {
            return None;
        }
        // A place on which the angle lies, within rounding, is not after it.
        let (own, near) = (reduced(far), near(far));
        let turns = ((far - own) / TAU).round();
        // All places of two turns may lie on the angle, if there is one a turn.
        let edge = [0.0, TAU, 2.0 * TAU].into_iter().find_map(|turn| {
            let next = places.partition_point(|place| place + turn - own <= near);
            places.get(next).map(|place| place + turn)
        })?;
        let at = (turns * TAU + edge - self.phase) / n;
        (at > angle).then_some(at)
    }

    /// Number of times that all waves repeat in a turn of the shaft: the greatest common divisor of their
    /// orders, without constants; 1 if all are constants.
    ///
    /// ```
    /// use gear_dynamics::{excitation::Fourier, Wave};
    /// let wave = Wave::new(Fourier::new(1.0, &[[0.2, 0.0]])?);
    /// let (teeth, blades, mean) = (wave.clone().per_turn(30)?, wave.per_turn(12)?, Wave::constant(2.0)?);
    /// assert_eq!(Wave::common_order([&teeth, &blades, &mean]), 6);
    /// # Ok::<(), gear_dynamics::ParameterError>(())
    /// ```
    pub fn common_order<'w>(waves: impl IntoIterator<Item = &'w Wave>) -> u32 {
        Wave::gcd_of_orders(waves).max(1)
    }
    /// The same number, but 0 if all are constants.
    pub(crate) fn gcd_of_orders<'w>(waves: impl IntoIterator<Item = &'w Wave>) -> u32 {
        waves.into_iter().filter(|wave| wave.varies).fold(0, |common, wave| gcd(common, wave.order))
    }

    /// All edges in one turn of the shaft, as angles of the shaft in [0, 2π).
    pub(crate) fn edges_of_a_turn(&self) -> Vec<f64> {
        self.of_a_turn(&self.edges)
    }

    /// All knots in one turn of the shaft. The list is empty if there are more than 2²⁰ of them.
    pub(crate) fn knots_of_a_turn(&self) -> Vec<f64> {
        let few = self.knots.len() * self.order as usize <= MAX_EDGES;
        if few { self.of_a_turn(&self.knots) } else { Vec::new() }
    }

    fn of_a_turn(&self, places: &[f64]) -> Vec<f64> {
        let n = f64::from(self.order);
        let turns = |place: &f64| {
            let own = (place - self.phase).rem_euclid(TAU);
            (0..self.order).map(move |k| (own + TAU * f64::from(k)) / n)
        };
        places.iter().flat_map(turns).collect()
    }

    /// Whether both waves share one function object and have the same order and phase.
    pub(crate) fn is(&self, other: &Wave) -> bool {
        Arc::ptr_eq(&self.excitation, &other.excitation)
            && self.order == other.order
            && self.phase == other.phase
    }
}

/// The places in [0, 2π), in increasing order. Of places that count as one, the first remains.
fn in_order(places: &[f64]) -> Vec<f64> {
    let mut places: Vec<f64> =
        places.iter().filter(|place| place.is_finite()).map(|place| place.rem_euclid(TAU) % TAU).collect();
    places.sort_by(f64::total_cmp);
    places.dedup_by(|next, place| *next - *place < APART);
    if let (Some(first), Some(last)) = (places.first(), places.last())
        && places.len() > 1
        && first + TAU - last < APART
    {
        places.pop();
    }
    places
}

/// The greatest common divisor of a and b; a if b is 0.
pub(crate) fn gcd(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// An angle reduced to [0, 2π).
#[inline]
fn reduced(angle: f64) -> f64 {
    if (0.0..TAU).contains(&angle) {
        return angle;
    }
    // Whole turns by conversion to an integer: a call of `floor` takes longer than the rest of this function.
    let turns = (angle / TAU) as i64 as f64;
    let own = angle - TAU * turns;
    let own = if own < 0.0 { own + TAU } else { own };
    if (0.0..TAU).contains(&own) { own } else { 0.0 }
}

impl PartialEq for Wave {
    fn eq(&self, other: &Self) -> bool {
        self.is(other)
            || (self.order == other.order
                && self.phase == other.phase
                && self.excitation.equals(&*other.excitation))
    }
}
