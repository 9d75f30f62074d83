//! The grid of deflections and velocities.

use crate::random::density::panels::Panels;

/// A grid of deflections x and velocities v. Values are stored row by row: all velocities of the first
/// deflection, then those of the next.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Grid<const N: usize> {
    pub(crate) x: Panels<N>,
    pub(crate) v: Panels<N>,
}

impl<const N: usize> Grid<N> {
    /// Number of nodes.
    pub(crate) fn len(&self) -> usize {
        self.x.len() * self.v.len()
    }

    /// Deflection, velocity and weight of each node.
    pub(crate) fn nodes(&self) -> impl Iterator<Item = ([f64; 2], f64)> + '_ {
        let rows = self.x.nodes.iter().zip(&self.x.weights);
        rows.flat_map(|(x, wx)| {
            self.v.nodes.iter().zip(&self.v.weights).map(move |(v, wv)| ([*x, *v], wx * wv))
        })
    }

    /// ∫∫ f p dx dv, p by its values at the nodes.
    pub(crate) fn integral(&self, p: &[f64], mut f: impl FnMut([f64; 2]) -> f64) -> f64 {
        self.nodes().zip(p).map(|((at, weight), p)| weight * p * f(at)).sum()
    }

    /// ∫∫ |p| dx dv.
    pub(crate) fn size(&self, p: &[f64]) -> f64 {
        self.nodes().zip(p).map(|((_, weight), p)| weight * p.abs()).sum()
    }

    /// ∫∫ |p - r| dx dv.
    pub(crate) fn distance(&self, p: &[f64], r: &[f64]) -> f64 {
        self.nodes().zip(p.iter().zip(r)).map(|((_, weight), (p, r))| weight * (p - r).abs()).sum()
    }

    /// The interpolated value of p at a state; 0 outside of the grid.
    #[inline]
    pub(crate) fn value(&self, p: &[f64], x: f64, v: f64) -> f64 {
        let (Some((row, lx)), Some((column, lv))) = (self.x.stencil(x), self.v.stencil(v)) else {
            return 0.0;
        };
        let width = self.v.len();
        let mut sum = 0.0;
        for (i, lx) in lx.iter().enumerate() {
            let line = &p[(row + i) * width + column..][..N];
            sum += lx * line.iter().zip(&lv).map(|(p, l)| p * l).sum::<f64>();
        }
        sum
    }

    /// The values at the nodes of a function that is given by its values on another grid.
    pub(crate) fn values_of<const K: usize>(&self, from: &Grid<K>, p: &[f64]) -> Vec<f64> {
        self.nodes().map(|([x, v], _)| from.value(p, x, v)).collect()
    }

    /// An estimate of the probability outside of the grid. At each side the density p of one coordinate
    /// falls from p1 to p0 over the outermost panel of length w; an exponential that continues it has p0
    /// w/ln(p1/p0) outside. It is doubled, since nothing enters from outside.
    pub(crate) fn outside(&self, p: &[f64]) -> f64 {
        let width = self.v.len();
        let row =
            |i: usize| p[i * width..][..width].iter().zip(&self.v.weights).map(|(p, w)| w * p).sum::<f64>();
        let column =
            |i: usize| p[i..].iter().step_by(width).zip(&self.x.weights).map(|(p, w)| w * p).sum::<f64>();
        let side = |axis: &Panels<N>, of: &dyn Fn(usize) -> f64, end: usize, inner: usize| {
            let ([p0, p1], length) =
                ([of(end).abs(), of(inner).abs()], (axis.nodes[end] - axis.nodes[inner]).abs());
            // A density that hardly falls is no tail: the estimate is that of a fall by 5 %.
            if p0 == 0.0 { 0.0 } else { p0 * length / (p1 / p0).max(1.05).ln() }
        };
        let sides = |axis: &Panels<N>, of: &dyn Fn(usize) -> f64| {
            let last = axis.len() - 1;
            side(axis, of, 0, N - 1) + side(axis, of, last, last - (N - 1))
        };
        2.0 * (sides(&self.x, &row) + sides(&self.v, &column))
    }
}
