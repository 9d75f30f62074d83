//! Which orders a balance keeps.

use crate::error::{ParameterError, check};

/// The orders of a truncated Fourier series, q(t) = Σ_k c_k cos(k ω t) + s_k sin(k ω t), ω = 2π/(p T).
///
/// Coefficients of one coordinate stand in the order [mean, c_k, s_k, ...] with increasing k; without order 0 there is no mean.
///
/// ```
/// use gear_dynamics::Harmonics;
/// assert_eq!(Harmonics::up_to(2).unknowns(), 5);
/// let paper = Harmonics::bands(63, 1, 2)?; // the 15 unknowns of Liu 2021
/// assert_eq!(paper.orders(), [0, 1, 2, 61, 62, 63, 64, 65]);
/// assert_eq!(paper.unknowns(), 15);
/// assert!(Harmonics::bands(usize::MAX, 1, 2).is_err());
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Harmonics {
    orders: Vec<usize>,
    periods: usize,
    /// The highest order asked for.
    asked: usize,
}

impl Harmonics {
    /// The highest order that is kept.
    pub const HIGHEST: usize = 65_536;
    /// The most periods of the model in one of the base frequency.
    pub const MOST_PERIODS: usize = 32_768;

    /// 0, 1, ..., H. Above [`HIGHEST`](Harmonics::HIGHEST) the list ends there, and balances and orbits refuse it with
    /// [`ParameterError::TooMany`].
    pub fn up_to(highest: usize) -> Self {
        Harmonics { orders: (0..=highest.min(Self::HIGHEST)).collect(), periods: 1, asked: highest }
    }

    /// Whether all orders asked for are kept.
    pub(crate) fn check(&self) -> Result<(), ParameterError> {
        check::count("highest order", &[self.asked], Self::HIGHEST).map(|_| ())
    }

    /// Any orders.
    ///
    /// # Errors
    /// An empty list, an order twice, or one above [`HIGHEST`](Harmonics::HIGHEST).
    pub fn list(orders: &[usize]) -> Result<Self, ParameterError> {
        let mut orders = orders.to_vec();
        orders.sort_unstable();
        if orders.is_empty() {
            return Err(ParameterError::Empty { name: "orders".into(), least: 1 });
        }
        let asked = check::count("highest order", &[orders[orders.len() - 1]], Self::HIGHEST)?;
        match orders.windows(2).find(|w| w[0] == w[1]) {
            Some(twice) => Err(ParameterError::OutOfRange {
                name: "repeated order".into(),
                value: twice[0] as f64,
                allowed: "the list once",
            }),
            None => Ok(Harmonics { orders, periods: 1, asked }),
        }
    }

    /// Bands K Z ± J around the first `count` mesh orders, with the mean: {|K Z + j| : K = 0..count, j = -J..J}.
    ///
    /// # Errors
    /// A mesh order of zero; a highest order above [`HIGHEST`](Harmonics::HIGHEST).
    pub fn bands(mesh_order: usize, count: usize, half_width: usize) -> Result<Self, ParameterError> {
        if mesh_order == 0 {
            return Err(ParameterError::TooFew { name: "mesh order".into(), value: 0, least: 1 });
        }
        let asked = count.saturating_mul(mesh_order).saturating_add(half_width);
        check::count("highest order", &[asked], Self::HIGHEST)?;
        let band = |k: usize| (0..=2 * half_width).map(move |j| (k * mesh_order + j).abs_diff(half_width));
        let mut orders: Vec<usize> = (0..=count).flat_map(band).collect();
        orders.sort_unstable();
        orders.dedup();
        Ok(Harmonics { orders, periods: 1, asked })
    }

    /// Orders of 1/p of the frequency of the model: for orbits that repeat after p periods.
    ///
    /// # Errors
    /// p = 0, or above [`MOST_PERIODS`](Harmonics::MOST_PERIODS).
    pub fn over_periods(self, periods: usize) -> Result<Self, ParameterError> {
        if periods == 0 {
            return Err(ParameterError::TooFew { name: "periods".into(), value: 0, least: 1 });
        }
        check::count("periods", &[periods], Self::MOST_PERIODS)?;
        Ok(Harmonics { periods, ..self })
    }

    /// The orders, increasing.
    pub fn orders(&self) -> &[usize] {
        &self.orders
    }
    /// Periods of the model in one of the base frequency.
    pub fn periods(&self) -> usize {
        self.periods
    }
    /// The highest order.
    pub fn highest(&self) -> usize {
        self.orders[self.orders.len() - 1]
    }
    /// Whether there is a mean.
    pub fn has_mean(&self) -> bool {
        self.orders[0] == 0
    }
    /// Unknowns of one coordinate.
    pub fn unknowns(&self) -> usize {
        2 * self.orders.len() - usize::from(self.has_mean())
    }

    /// Where the coefficients of the i-th order begin.
    #[inline]
    pub(crate) fn place(&self, i: usize) -> usize {
        if self.has_mean() { (2 * i).saturating_sub(1) } else { 2 * i }
    }

    /// Where the cosine of order k stands, the sine behind it.
    pub(crate) fn place_of(&self, order: usize) -> Option<usize> {
        self.orders.binary_search(&order).ok().map(|i| self.place(i))
    }

    /// Every order up to 1.3 times the highest, so that gaps of a list show too; two orders of the model at least, for symmetric orbits have every
    /// other one.
    pub(crate) fn extended(&self) -> Self {
        let highest = self.highest();
        let further = highest + (3 * highest).div_ceil(10).max(2 * self.periods);
        Harmonics { periods: self.periods, ..Harmonics::up_to(further) }
    }
}
