//! The cubic through values and rates at both ends of a stretch: cheap, and good enough to say where to look.

/// The distance of a contact from one edge of its piece, positive inside, with its rate per unit of θ.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Distance {
    pub(crate) value: f64,
    pub(crate) rate: f64,
}

/// An extremum this close to an edge, measured by its own rise, is looked at closely.
const NEAR: f64 = 0.25;

/// With both ends this far from the edge, in units of their rates, there is no dip: a cubic dips at most 4/27 of them.
const FAR: f64 = 0.2;

/// d(σ), σ from 0 to 1 over the stretch.
pub(crate) struct Hermite {
    value: f64,
    /// σ, σ², σ³.
    powers: [f64; 3],
}

impl Hermite {
    #[inline]
    pub(crate) fn new(d0: Distance, d1: Distance) -> Self {
        let rise = d1.value - d0.value;
        Hermite {
            value: d0.value,
            powers: [d0.rate, 3.0 * rise - 2.0 * d0.rate - d1.rate, d0.rate + d1.rate - 2.0 * rise],
        }
    }

    /// Whether the ends alone say that the cubic has no dip and stays above `floor`: it lies between control points a third of a rate off.
    #[inline]
    pub(crate) fn is_clear(d0: Distance, d1: Distance, floor: f64) -> bool {
        let (ends, rates) = (d0.value.min(d1.value), d0.rate.abs() + d1.rate.abs());
        ends > FAR * rates && ends - rates / 3.0 > floor
    }

    /// Over a stretch of θ of this width.
    pub(crate) fn over(width: f64, d0: Distance, d1: Distance) -> Self {
        let scaled = |d: Distance| Distance { rate: width * d.rate, ..d };
        Hermite::new(scaled(d0), scaled(d1))
    }

    #[inline]
    pub(crate) fn at(&self, sigma: f64) -> f64 {
        let [a, b, c] = self.powers;
        self.value + sigma * (a + sigma * (b + sigma * c))
    }

    /// Its slope over σ.
    pub(crate) fn slope(&self, sigma: f64) -> f64 {
        let [a, b, c] = self.powers;
        a + sigma * (2.0 * b + sigma * 3.0 * c)
    }

    /// Its extrema inside the stretch, in order.
    pub(crate) fn extrema(&self) -> [Option<f64>; 2] {
        let [a, b, c] = self.powers;
        let disc = b * b - 3.0 * a * c;
        if disc <= 0.0 {
            return [None; 2];
        }
        // a + 2 b σ + 3 c σ² = 0 without cancellation.
        let s = -(b + disc.sqrt().copysign(b));
        let (r1, r2) = (s / (3.0 * c), a / s);
        let inside = |r: f64| (r > 0.0 && r < 1.0).then_some(r);
        let (first, second) = if r1 < r2 { (r1, r2) } else { (r2, r1) };
        [inside(first), inside(second)]
    }

    /// Where it is lowest inside the stretch.
    pub(crate) fn lowest(&self) -> Option<f64> {
        match self.extrema() {
            [Some(first), Some(second)] => {
                Some(if self.at(second).total_cmp(&self.at(first)).is_lt() { second } else { first })
            }
            [first, second] => first.or(second),
        }
    }

    /// Its least value on the stretch, the ends included.
    pub(crate) fn least(&self) -> f64 {
        let ends = self.value.min(self.at(1.0));
        self.lowest().map_or(ends, |sigma| ends.min(self.at(sigma)))
    }

    /// Whether its least value is above `floor`: said by its control points, which it lies between, where they tell.
    #[inline]
    pub(crate) fn stays_above(&self, floor: f64) -> bool {
        let [a, b, c] = self.powers;
        let (third, inner) = (self.value + a / 3.0, self.value + (2.0 * a + b) / 3.0);
        let points = self.value.min(third).min(inner.min(self.value + (a + b + c)));
        points > floor || self.least() > floor
    }

    /// Whether it comes so close to zero inside the stretch that the dense output has to be asked.
    #[inline]
    pub(crate) fn may_dip(&self, d0: Distance, d1: Distance) -> bool {
        // With both ends moving away from a dip there is none, and a cubic dips at most 4/27 of its end rates.
        let ends = d0.value.min(d1.value);
        if (d0.rate >= 0.0 && d1.rate <= 0.0) || ends > FAR * (d0.rate.abs() + d1.rate.abs()) {
            return false;
        }
        self.lowest().is_some_and(|sigma| {
            let bottom = self.at(sigma);
            bottom < NEAR * (ends - bottom)
        })
    }
}
