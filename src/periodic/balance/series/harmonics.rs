//! The orders that a balance keeps.

use crate::error::{ParameterError, check};

/// The orders of a truncated Fourier series.
///
/// q(t) = Σ_k c_k cos(k ω t) + s_k sin(k ω t), ω = 2π/(p T).
///
/// T is the period of the model and p the number of periods in one base period. The coefficients of one
/// coordinate are [mean, c_k, s_k, ...] with increasing k; without order 0 there is no mean.
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
    period_multiple: usize,
    /// Highest order that was requested.
    asked: usize,
}

impl Harmonics {
    /// Highest allowed order.
    pub const HIGHEST: usize = 65_536;
    /// Maximum number of periods of the model in one base period.
    pub const MAX_PERIOD_MULTIPLE: usize = 32_768;

    /// Orders 0, 1, ..., H.
    ///
    /// If H exceeds [`HIGHEST`](Harmonics::HIGHEST), balances and orbits with these orders return
    /// [`ParameterError::TooMany`].
    pub fn up_to(highest: usize) -> Self {
        Harmonics { orders: (0..=highest.min(Self::HIGHEST)).collect(), period_multiple: 1, asked: highest }
    }

    /// Error if an order above [`HIGHEST`](Harmonics::HIGHEST) was requested.
    pub(crate) fn check(&self) -> Result<(), ParameterError> {
        check::count("highest order", &[self.asked], Self::HIGHEST).map(|_| ())
    }

    /// The orders of a list, in any sequence.
    ///
    /// # Errors
    /// [`ParameterError`] for an empty list, a repeated order, or an order above
    /// [`HIGHEST`](Harmonics::HIGHEST).
    pub fn of_orders(orders: &[usize]) -> Result<Self, ParameterError> {
        let mut orders = orders.to_vec();
        orders.sort_unstable();
        if orders.is_empty() {
            return Err(ParameterError::Empty { name: "orders".into(), min: 1 });
        }
        let asked = check::count("highest order", &[orders[orders.len() - 1]], Self::HIGHEST)?;
        match orders.windows(2).find(|w| w[0] == w[1]) {
            Some(twice) => Err(ParameterError::Wrong {
                name: "an order of the list".into(),
                value: twice[0] as f64,
                must: "be listed once".into(),
            }),
            None => Ok(Harmonics { orders, period_multiple: 1, asked }),
        }
    }

    /// {|K Z + j| : K = 0 .. count, j = -J .. J}: bands around the first `count` multiples of the mesh order
    /// Z, and around the mean. J is the half width.
    ///
    /// # Errors
    /// [`ParameterError`] for mesh order 0, or a highest order above [`HIGHEST`](Harmonics::HIGHEST).
    pub fn bands(mesh_order: usize, count: usize, half_width: usize) -> Result<Self, ParameterError> {
        check::at_least("mesh order", mesh_order, 1)?;
        let asked = count.saturating_mul(mesh_order).saturating_add(half_width);
        check::count("highest order", &[asked], Self::HIGHEST)?;
        let band = |k: usize| (0..=2 * half_width).map(move |j| (k * mesh_order + j).abs_diff(half_width));
        let mut orders: Vec<usize> = (0..=count).flat_map(band).collect();
        orders.sort_unstable();
        orders.dedup();
        Ok(Harmonics { orders, period_multiple: 1, asked })
    }

    /// The same orders of 1/p of the frequency of the model, for orbits that repeat after p periods. Default:
    /// p = 1.
    ///
    /// # Errors
    /// [`ParameterError`] for p = 0, or p above [`MAX_PERIOD_MULTIPLE`](Harmonics::MAX_PERIOD_MULTIPLE).
    pub fn with_period_multiple(self, period_multiple: usize) -> Result<Self, ParameterError> {
        check::at_least("period_multiple", period_multiple, 1)?;
        check::count("period_multiple", &[period_multiple], Self::MAX_PERIOD_MULTIPLE)?;
        Ok(Harmonics { period_multiple, ..self })
    }

    /// The orders, in increasing sequence.
    pub fn orders(&self) -> &[usize] {
        &self.orders
    }
    /// Number p of periods of the model in one base period.
    pub fn period_multiple(&self) -> usize {
        self.period_multiple
    }
    /// Highest order.
    pub fn highest(&self) -> usize {
        self.orders[self.orders.len() - 1]
    }
    /// Whether order 0, the mean, is kept.
    pub fn has_mean(&self) -> bool {
        self.orders[0] == 0
    }
    /// Number of unknowns of one coordinate.
    pub fn unknowns(&self) -> usize {
        2 * self.orders.len() - usize::from(self.has_mean())
    }

    /// Index of the first coefficient of the i-th order.
    #[inline]
    pub(crate) fn place(&self, i: usize) -> usize {
        if self.has_mean() { (2 * i).saturating_sub(1) } else { 2 * i }
    }

    /// Index of the cosine coefficient of order k, or of the mean; the sine coefficient follows. `None` if
    /// the order is not kept.
    pub(crate) fn place_of(&self, order: usize) -> Option<usize> {
        self.orders.binary_search(&order).ok().map(|i| self.place(i))
    }

    /// All orders up to 1.3 times the highest. The gaps of a list are filled, and at least two orders of the
    /// model are added, since every second order of a symmetric orbit is zero.
    pub(crate) fn extended(&self) -> Self {
        let highest = self.highest();
        let further = highest + (3 * highest).div_ceil(10).max(2 * self.period_multiple);
        Harmonics { period_multiple: self.period_multiple, ..Harmonics::up_to(further) }
    }
}
