//! Splines through samples of a period, alone or with a rectangular wave, stated twice: as a wave and as a
//! plain function.

use crate::draw::Draw;
use crate::reference::wrapped;
use gear_dynamics::excitation::{Product, RectangularWave, Sum, Table};
use gear_dynamics::{ParameterError, Wave};
use std::f64::consts::{PI, TAU};

/// How a rectangular wave joins the spline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Join {
    /// There is no rectangular wave.
    None,
    /// The sum of both.
    Sum,
    /// The product of both.
    Product,
}

/// f(n φ + ψ) with the periodic spline through samples and a rectangular wave of its own order within f.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Samples of a period, the first at 0.
    pub samples: Vec<f64>,
    /// The rectangular wave: its place.
    pub join: Join,
    /// Share of its period with the high value, and both values.
    pub rectangle: [f64; 3],
    /// Its order within f.
    pub inner: u32,
    /// Order n.
    pub order: u32,
    /// Phase ψ `[rad]`.
    pub phase: f64,
}

impl Curve {
    /// Draws a curve within some 2.5 times `size` of `middle`. Half of the tables jump between two
    /// neighbouring samples.
    pub fn draw(draw: &mut Draw, middle: f64, size: f64) -> Self {
        let n = 4 + draw.below(21);
        let jump = draw.below(2) == 0;
        let at = 1 + draw.below(n - 1);
        let mut sample = |i: usize| match (jump, i < at) {
            (true, true) => middle + 0.5 * size + draw.within(-0.05, 0.05) * size,
            (true, false) => middle - 0.5 * size + draw.within(-0.05, 0.05) * size,
            (false, _) => middle + draw.within(-0.5, 0.5) * size,
        };
        let samples = (0..n).map(&mut sample).collect();
        let join = draw.one_of(&[Join::None, Join::Sum, Join::Product]);
        let rectangle = match join {
            Join::Sum => [draw.within(0.1, 0.9), draw.within(-0.5, 0.0) * size, draw.within(0.0, 0.5) * size],
            _ => [draw.within(0.1, 0.9), draw.within(0.6, 1.0), draw.within(1.0, 1.4)],
        };
        let (inner, order) = (1 + draw.below(2) as u32, 1 + draw.below(3) as u32);
        let phase = if draw.below(3) == 0 { 0.0 } else { draw.within(-PI, PI) };
        Curve { samples, join, rectangle, inner, order, phase }
    }

    /// The wave.
    ///
    /// # Errors
    /// Parameters that the library refuses.
    pub fn wave(&self) -> Result<Wave, ParameterError> {
        let table = Wave::new(Table::new(&self.samples)?);
        let [duty, low, high] = self.rectangle;
        let steps = || Wave::new(RectangularWave::new(low, high, duty)?).per_turn(self.inner);
        let wave = match self.join {
            Join::None => table,
            Join::Sum => Wave::new(Sum::new(vec![table, steps()?])),
            Join::Product => Wave::new(Product::new(vec![table, steps()?])),
        };
        wave.per_turn(self.order)?.with_phase(self.phase)
    }

    /// Second derivatives at the samples in units of the spacing: M = 6 G y'' with the inverse of the
    /// circulant matrix of (1, 4, 1), G_d = (z^d + z^(n-d))/((1 - z^n) (4 + 2z)) with z = √3 - 2.
    fn moments(&self) -> Vec<f64> {
        let (y, n) = (&self.samples, self.samples.len());
        let z = 3f64.sqrt() - 2.0;
        let inverse = |d: usize| {
            (z.powi(d as i32) + z.powi((n - d) as i32)) / (1.0 - z.powi(n as i32)) / (4.0 + 2.0 * z)
        };
        let bend = |i: usize| y[(i + n - 1) % n] - 2.0 * y[i] + y[(i + 1) % n];
        (0..n).map(|i| (0..n).map(|j| 6.0 * inverse(i.abs_diff(j)) * bend(j)).sum()).collect()
    }

    /// The plain function of φ.
    pub fn plain(&self) -> impl Fn(f64) -> f64 + use<> {
        let (moments, curve, n) = (self.moments(), self.clone(), self.samples.len());
        move |phi| {
            let angle = f64::from(curve.order) * phi + curve.phase;
            let x = (angle / TAU).rem_euclid(1.0) * n as f64;
            let (i, s) = ((x as usize).min(n - 1), x - x.floor());
            let (j, r) = ((i + 1) % n, 1.0 - s);
            let bend = (r * r * r - r) * moments[i] + (s * s * s - s) * moments[j];
            let spline = r * curve.samples[i] + s * curve.samples[j] + bend / 6.0;
            let [duty, low, high] = curve.rectangle;
            let is_high = wrapped(f64::from(curve.inner) * angle).abs() < PI * duty;
            let step = if is_high { high } else { low };
            match curve.join {
                Join::None => spline,
                Join::Sum => spline + step,
                Join::Product => spline * step,
            }
        }
    }

    /// The angles φ in one turn at which the function or one of its derivatives jumps.
    pub fn places(&self) -> Vec<f64> {
        let n = self.samples.len();
        let mut inside: Vec<f64> = (0..n).map(|k| TAU * k as f64 / n as f64).collect();
        if self.join != Join::None {
            let inner = f64::from(self.inner);
            for k in 0..self.inner {
                let middle = TAU * f64::from(k) / inner;
                inside.extend([-1.0, 1.0].map(|side| middle + side * PI * self.rectangle[0] / inner));
            }
        }
        let order = f64::from(self.order);
        let turns = |k: u32| move |x: &f64| (x - self.phase + TAU * f64::from(k)) / order;
        (0..self.order).flat_map(|k| inside.iter().map(turns(k)).collect::<Vec<f64>>()).collect()
    }
}
