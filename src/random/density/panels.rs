//! One axis of a grid: panels with Gauss-Lobatto nodes.
//!
//! A function is a polynomial of degree N - 1 in each panel, given by its values at N nodes, and continuous
//! at the borders, which are nodes of both neighbours. Its derivatives may jump there. The integral over a
//! panel is the sum of weights times values, exact to degree 2N - 3.   Source: Abramowitz & Stegun, 25.4.32.

/// Panels that cover an interval, with N nodes each.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Panels<const N: usize> {
    borders: Vec<f64>,
    /// Nodes and weights of all panels; those of a border are shared.
    pub(crate) nodes: Vec<f64>,
    pub(crate) weights: Vec<f64>,
    /// Nodes on [-1, 1].
    reference: [f64; N],
    /// 1/Π (s_i - s_j) over j ≠ i.
    scales: [f64; N],
}

impl<const N: usize> Panels<N> {
    /// About `count` panels from `low` to `high`, with borders at the values `inner` that lie between them.
    /// Each interval between such values has panels of equal length, at least one.
    pub(crate) fn new([low, high]: [f64; 2], inner: &[f64], count: usize) -> Self {
        let mut ends: Vec<f64> = inner.iter().copied().filter(|x| low < *x && *x < high).collect();
        ends.extend([low, high]);
        ends.sort_by(f64::total_cmp);
        ends.dedup_by(|a, b| (*a - *b).abs() < 1e-9 * (high - low));
        let mut borders = vec![low];
        for pair in ends.windows(2) {
            let [from, to] = [pair[0], pair[1]];
            let panels = (count as f64 * (to - from) / (high - low)).round().max(1.0) as usize;
            let length = (to - from) / panels as f64;
            borders.extend((1..panels).map(|i| from + length * i as f64));
            borders.push(to);
        }
        let (reference, rule) = lobatto::<N>();
        let scales = std::array::from_fn(|i| {
            1.0 / (0..N).filter(|j| *j != i).map(|j| reference[i] - reference[j]).product::<f64>()
        });
        let last = borders.len() - 1;
        let (mut nodes, mut weights) = (vec![low; last * (N - 1) + 1], vec![0.0; last * (N - 1) + 1]);
        for (panel, ends) in borders.windows(2).enumerate() {
            let (middle, half) = (0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0]));
            for i in 0..N {
                let at = panel * (N - 1) + i;
                // The borders are exact: an edge of a contact is a node.
                nodes[at] = if i == N - 1 {
                    ends[1]
                } else if i == 0 {
                    ends[0]
                } else {
                    middle + half * reference[i]
                };
                weights[at] += half * rule[i];
            }
        }
        Panels { borders, nodes, weights, reference, scales }
    }

    /// Borders of the panels.
    pub(crate) fn borders(&self) -> &[f64] {
        &self.borders
    }

    /// Number of nodes.
    pub(crate) fn len(&self) -> usize {
        self.nodes.len()
    }

    /// The first node of the panel that contains `x`, with the values of its Lagrange polynomials at x.
    /// `None` outside.
    #[inline]
    pub(crate) fn stencil(&self, x: f64) -> Option<(usize, [f64; N])> {
        let last = self.borders.len() - 1;
        if !(self.borders[0] <= x && x <= self.borders[last]) {
            return None;
        }
        let panel = self.borders[1..last].partition_point(|border| *border < x);
        let (low, high) = (self.borders[panel], self.borders[panel + 1]);
        let s = (2.0 * x - low - high) / (high - low);
        let mut values = self.scales;
        let mut before = 1.0;
        for (value, node) in values.iter_mut().zip(&self.reference) {
            *value *= before;
            before *= s - node;
        }
        let mut after = 1.0;
        for (value, node) in values.iter_mut().zip(&self.reference).rev() {
            *value *= after;
            after *= s - node;
        }
        Some((panel * (N - 1), values))
    }
}

/// Nodes and weights on [-1, 1]: the ends and the roots of P'_{N-1}; w_i = 2/(N (N-1) P_{N-1}(s_i)²).
fn lobatto<const N: usize>() -> ([f64; N], [f64; N]) {
    let degree = N - 1;
    // P_degree and P_{degree-1} at s.
    let legendre = |s: f64| {
        (1..degree).fold((s, 1.0), |(p, before), n| {
            let n = n as f64;
            (((2.0 * n + 1.0) * s * p - n * before) / (n + 1.0), p)
        })
    };
    let nodes: [f64; N] = std::array::from_fn(|i| {
        let mut s = -(std::f64::consts::PI * i as f64 / degree as f64).cos();
        if i > 0 && i < degree {
            for _ in 0..50 {
                let (p, before) = legendre(s);
                // Newton's step for (1 - s²) P' = degree (P_{degree-1} - s P), whose derivative is -degree
                // (degree+1) P.
                s += (before - s * p) / (N as f64 * p);
            }
        }
        s
    });
    let weights = std::array::from_fn(|i| 2.0 / ((N * degree) as f64 * legendre(nodes[i]).0.powi(2)));
    (nodes, weights)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_are_reproduced_and_integrated() {
        let axis = Panels::<9>::new([-2.0, 3.0], &[0.5], 4);
        assert!(axis.borders().contains(&0.5) && axis.nodes.contains(&0.5));
        let f = |x: f64| x.powi(8) - 3.0 * x.powi(5) + 1.0;
        let integral: f64 = axis.nodes.iter().zip(&axis.weights).map(|(x, w)| w * f(*x)).sum();
        let exact = |x: f64| x.powi(9) / 9.0 - 0.5 * x.powi(6) + x;
        assert!((integral - (exact(3.0) - exact(-2.0))).abs() < 1e-10);
        for x in [-2.0, -0.3, 0.5, 2.9, 3.0] {
            let (first, values) = axis.stencil(x).unwrap();
            let sum: f64 = values.iter().zip(&axis.nodes[first..]).map(|(l, node)| l * f(*node)).sum();
            assert!((sum - f(x)).abs() < 1e-9, "{x}: {sum} {}", f(x));
        }
        assert!(axis.stencil(3.1).is_none() && axis.stencil(f64::NAN).is_none());
    }
}
