//! The fixed point of a map of densities.
//!
//! The map is repeated; after each m repetitions the next start is the combination Σ γ_k x_{k+1}, Σ γ_k = 1,
//! whose change |Σ γ_k (x_{k+1} - x_k)| is smallest (reduced rank extrapolation).   Source: Sidi, Ford and
//! Smith 1986.

/// Repetitions between two extrapolations.
const REPETITIONS: usize = 8;

/// When an iteration ends.
pub(crate) struct Iteration {
    /// Largest change in one repetition, in the norm of the caller.
    pub(crate) tolerance: f64,
    /// Maximum number of repetitions.
    pub(crate) limit: usize,
}

/// Where an iteration ended.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arrived {
    /// The last change, and whether it is below the tolerance.
    pub(crate) change: f64,
    pub(crate) converged: bool,
    /// The largest observed ratio of a change to the one before it.
    pub(crate) ratio: f64,
    /// Number of repetitions.
    pub(crate) repetitions: usize,
}

impl Iteration {
    /// Replaces `p` by the fixed point of `map`. `size` is a norm.
    pub(crate) fn run<E>(
        &self,
        p: &mut Vec<f64>,
        mut map: impl FnMut(&[f64]) -> Result<Vec<f64>, E>,
        size: impl Fn(&[f64]) -> f64,
        mut progress: impl FnMut(usize, f64),
    ) -> Result<Arrived, E> {
        let mut arrived = Arrived { change: f64::INFINITY, converged: false, ratio: 0.0, repetitions: 0 };
        while arrived.repetitions < self.limit {
            let (mut images, mut changes): (Vec<Vec<f64>>, Vec<Vec<f64>>) = (Vec::new(), Vec::new());
            let mut before = f64::INFINITY;
            for _ in 0..REPETITIONS {
                let from = images.last().unwrap_or(p);
                let to = map(from)?;
                let change: Vec<f64> = to.iter().zip(from).map(|(to, from)| to - from).collect();
                let now = size(&change);
                arrived.change = now;
                arrived.repetitions += 1;
                progress(arrived.repetitions, now);
                // An extrapolation brings in fast modes, which decay within the first half of a cycle.
                if changes.len() >= REPETITIONS / 2 && now > 10.0 * self.tolerance {
                    arrived.ratio = f64::max(arrived.ratio, now / before);
                }
                before = now;
                images.push(to);
                changes.push(change);
                if now <= self.tolerance || now.is_nan() {
                    break;
                }
            }
            if arrived.change.is_nan() {
                return Ok(arrived);
            }
            if arrived.change <= self.tolerance {
                arrived.converged = true;
                *p = images.pop().unwrap_or_default();
                return Ok(arrived);
            }
            let weights = smallest_combination(&changes);
            p.fill(0.0);
            for (image, weight) in images.iter().zip(weights) {
                p.iter_mut().zip(image).for_each(|(p, x)| *p += weight * x);
            }
        }
        Ok(arrived)
    }
}

/// Weights γ with the sum 1 that make |Σ γ_k d_k| smallest: D = QR, RᵀR c = 1, γ = c/Σ c.
fn smallest_combination(changes: &[Vec<f64>]) -> Vec<f64> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (mut q, mut r): (Vec<Vec<f64>>, Vec<Vec<f64>>) = (Vec::new(), Vec::new());
    // The last change first: it is the smallest, and what does not differ from it is left out.
    for change in changes.iter().rev() {
        let (mut rest, mut column) = (change.clone(), Vec::new());
        let length = dot(change, change).sqrt();
        for _ in 0..2 {
            for (i, q) in q.iter().enumerate() {
                let part = dot(q, &rest);
                if column.len() <= i {
                    column.push(part)
                } else {
                    column[i] += part
                }
                rest.iter_mut().zip(q).for_each(|(x, q)| *x -= part * q);
            }
        }
        let left = dot(&rest, &rest).sqrt();
        if left <= 1e-10 * length {
            break;
        }
        rest.iter_mut().for_each(|x| *x /= left);
        column.push(left);
        q.push(rest);
        r.push(column);
    }
    let n = r.len();
    if n == 0 {
        return (1..=changes.len()).map(|k| if k == changes.len() { 1.0 } else { 0.0 }).collect();
    }
    // Rᵀ y = 1, R c = y; column j of R is r[j].
    let mut c = vec![1.0; n];
    for j in 0..n {
        let sum: f64 = (0..j).map(|i| r[j][i] * c[i]).sum();
        c[j] = (1.0 - sum) / r[j][j];
    }
    for j in (0..n).rev() {
        let sum: f64 = (j + 1..n).map(|k| r[k][j] * c[k]).sum();
        c[j] = (c[j] - sum) / r[j][j];
    }
    let total: f64 = c.iter().sum();
    let mut weights = vec![0.0; changes.len()];
    for (k, c) in c.iter().enumerate() {
        weights[changes.len() - 1 - k] = c / total;
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A linear map with the eigenvalues 0.999, 0.9 ± 0.3i and 0.5.
    #[test]
    fn slow_modes_are_found_in_few_repetitions() {
        let map = |x: &[f64]| {
            let y = [0.999 * x[0], 0.9 * x[1] - 0.3 * x[2], 0.3 * x[1] + 0.9 * x[2], 0.5 * x[3]];
            Ok::<_, ()>(y.iter().zip([0.001, 0.4, -0.2, 0.5]).map(|(y, b)| y + b).collect())
        };
        let mut p = vec![0.0; 4];
        let iteration = Iteration { tolerance: 1e-12, limit: 60 };
        let size = |x: &[f64]| x.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let arrived = iteration.run(&mut p, map, size, |_, _| ()).unwrap();
        assert!(arrived.converged, "{arrived:?}");
        // (1 - A) p = b: p = (1, ?, ?, 1), the middle block [0.1, 0.3; -0.3, 0.1] p = (0.4, -0.2).
        for (p, exact) in p.iter().zip([1.0, 1.0, 1.0, 1.0]) {
            assert!((p - exact).abs() < 1e-8, "{p} {exact}");
        }
    }
}
