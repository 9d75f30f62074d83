//! Roots of a function of one variable without derivatives.

/// Brent's method: inverse quadratic interpolation and secants within a bracket, with bisection where they
/// are slow.   Source: Brent, Algorithms for Minimization without Derivatives, Ch. 4.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Brent {
    a: f64,
    fa: f64,
    b: f64,
    fb: f64,
    c: f64,
    fc: f64,
    step: f64,
    before: f64,
    tolerance: f64,
}

impl Brent {
    /// A bracket with values of different signs at its ends.
    pub(crate) fn new([a, fa]: [f64; 2], [b, fb]: [f64; 2], tolerance: f64) -> Self {
        let step = b - a;
        Brent { a, fa, b, fb, c: a, fc: fa, step, before: step, tolerance }
    }

    /// The best abscissa so far.
    pub(crate) fn best(&self) -> f64 {
        self.b
    }

    /// The next abscissa; `None` if the root is found.
    pub(crate) fn next(&mut self) -> Option<f64> {
        if self.fc.abs() < self.fb.abs() {
            (self.a, self.b, self.c) = (self.b, self.c, self.b);
            (self.fa, self.fb, self.fc) = (self.fb, self.fc, self.fb);
        }
        let least = 2.0 * f64::EPSILON * self.b.abs() + 0.5 * self.tolerance;
        let half = 0.5 * (self.c - self.b);
        if half.abs() <= least || self.fb == 0.0 {
            return None;
        }
        if self.before.abs() < least || self.fa.abs() <= self.fb.abs() {
            (self.step, self.before) = (half, half);
        } else {
            let s = self.fb / self.fa;
            let (mut p, mut q) = if self.a == self.c {
                (2.0 * half * s, 1.0 - s)
            } else {
                let (q, r) = (self.fa / self.fc, self.fb / self.fc);
                let p = s * (2.0 * half * q * (q - r) - (self.b - self.a) * (r - 1.0));
                (p, (q - 1.0) * (r - 1.0) * (s - 1.0))
            };
            if p > 0.0 {
                q = -q;
            }
            p = p.abs();
            let limit = (3.0 * half * q - (least * q).abs()).min((self.before * q).abs());
            if 2.0 * p < limit {
                (self.before, self.step) = (self.step, p / q);
            } else {
                (self.step, self.before) = (half, half);
            }
        }
        (self.a, self.fa) = (self.b, self.fb);
        let moved = if self.step.abs() > least { self.step } else { least.copysign(half) };
        Some(self.b + moved)
    }

    /// Takes the value at the abscissa from [`next`](Brent::next).
    pub(crate) fn take(&mut self, x: f64, f: f64) {
        (self.b, self.fb) = (x, f);
        if (self.fb > 0.0) == (self.fc > 0.0) {
            (self.c, self.fc) = (self.a, self.fa);
            (self.step, self.before) = (self.b - self.a, self.b - self.a);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::numeric::search::brent::Brent;

    /// Simple, multiple and steep roots, with the accuracy that they allow and the number of evaluations.
    #[test]
    fn roots_are_found() {
        type Case = (fn(f64) -> f64, [f64; 2], f64, f64, usize);
        let cases: [Case; 4] = [
            (|x| x * x * x - 2.0 * x - 5.0, [0.0, 10.0], 2.094_551_481_542_326_5, 1e-13, 20),
            (|x| x.atan(), [-3.0, 7.0], 0.0, 1e-13, 20),
            (|x| (x - 0.3).powi(3), [-1.0, 2.0], 0.3, 1e-5, 150),
            (|x| if x < 0.7 { -(0.7 - x).sqrt() } else { x - 0.7 }, [0.0, 1.0], 0.7, 1e-13, 60),
        ];
        for (f, [a, b], root, accuracy, most) in cases {
            let mut brent = Brent::new([a, f(a)], [b, f(b)], 1e-14);
            let mut count = 0;
            while let Some(x) = brent.next() {
                brent.take(x, f(x));
                count += 1;
                assert!(count <= most, "{root}: {count} evaluations");
            }
            assert!((brent.best() - root).abs() <= accuracy, "{} {root}", brent.best());
        }
    }
}
