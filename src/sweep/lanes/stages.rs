//! A step of the classical Runge-Kutta method for all lanes at once.

use crate::scalar::{Scalar, keep_rolled};

/// The state and the working vectors of a step: q and v, q and v of a stage, the acceleration of a stage, a₁
/// (`first`), a₂ and then a₂ + a₃ (`inner`).
pub(crate) struct Stages<'w, S> {
    pub(crate) q: &'w mut [S],
    pub(crate) v: &'w mut [S],
    pub(crate) qs: &'w mut [S],
    pub(crate) vs: &'w mut [S],
    pub(crate) a: &'w mut [S],
    pub(crate) first: &'w mut [S],
    pub(crate) inner: &'w mut [S],
}

/// The acceleration in the stages of a step.
pub(crate) trait Acceleration<S> {
    /// Writes the acceleration of a stage, 0 to 3, to `a`. Stages 1 and 2 lie in the middle of the step.
    fn accel(&mut self, stage: usize, q: &[S], v: &[S], a: &mut [S]);
}

impl<S: Scalar> Stages<'_, S> {
    /// The first `n` elements of each vector. The compiler knows their number from here on.
    #[inline(always)]
    pub(crate) fn cut(&mut self, n: usize) -> Stages<'_, S> {
        Stages {
            q: &mut self.q[..n],
            v: &mut self.v[..n],
            qs: &mut self.qs[..n],
            vs: &mut self.vs[..n],
            a: &mut self.a[..n],
            first: &mut self.first[..n],
            inner: &mut self.inner[..n],
        }
    }

    /// Makes a step of length h on `n` coordinates.
    ///
    /// With a(t, q, v) the acceleration:
    ///
    /// a₁ = a(t, q, v)
    ///
    /// a₂ = a(t + h/2, q + h/2 v, v₂),   v₂ = v + h/2 a₁
    ///
    /// a₃ = a(t + h/2, q + h/2 v₂, v₃),   v₃ = v + h/2 a₂
    ///
    /// a₄ = a(t + h, q + h v₃, v + h a₃)
    ///
    /// q ← q + h (v + h/6 (a₁ + a₂ + a₃)),   v ← v + h/6 (a₁ + 2 a₂ + 2 a₃ + a₄)
    ///
    /// Source: Hairer, Nørsett & Wanner I, Table II.1.2.
    #[inline(always)]
    pub(crate) fn step<const SMALL: bool>(&mut self, n: usize, h: S, at: &mut impl Acceleration<S>) {
        let rolled = |i: usize| if SMALL { i } else { keep_rolled(i) };
        for i in 0..n {
            let i = rolled(i);
            (self.qs[i], self.vs[i]) = (self.q[i], self.v[i]);
        }
        if SMALL {
            self.stage::<SMALL>(n, h, 0, at);
            self.stage::<SMALL>(n, h, 1, at);
            self.stage::<SMALL>(n, h, 2, at);
            self.stage::<SMALL>(n, h, 3, at);
        } else {
            // One loop over the stages has one copy of the algebra, which is large.
            for stage in 0..4 {
                self.stage::<SMALL>(n, h, keep_rolled(stage), at);
            }
        }
        let sixth = h * (1.0 / 6.0);
        for i in 0..n {
            let i = rolled(i);
            self.q[i] = self.q[i] + h * (self.v[i] + sixth * (self.first[i] + self.inner[i]));
            self.v[i] = self.v[i] + sixth * (self.first[i] + self.inner[i] + self.inner[i] + self.a[i]);
        }
    }

    /// Evaluates a stage, adds its acceleration to the sums and goes to the next stage.
    #[inline(always)]
    fn stage<const SMALL: bool>(&mut self, n: usize, h: S, stage: usize, at: &mut impl Acceleration<S>) {
        let rolled = |i: usize| if SMALL { i } else { keep_rolled(i) };
        at.accel(stage, self.qs, self.vs, self.a);
        match stage {
            0 => {
                for i in 0..n {
                    let i = rolled(i);
                    self.first[i] = self.a[i];
                }
            }
            1 => {
                for i in 0..n {
                    let i = rolled(i);
                    self.inner[i] = self.a[i];
                }
            }
            2 => {
                for i in 0..n {
                    let i = rolled(i);
                    self.inner[i] = self.inner[i] + self.a[i];
                }
            }
            _ => return,
        }
        let ahead = if stage == 2 { h } else { h * 0.5 };
        for i in 0..n {
            let i = rolled(i);
            self.qs[i] = self.q[i] + ahead * self.vs[i];
            self.vs[i] = self.v[i] + ahead * self.a[i];
        }
    }
}
