//! The contacts at the ends of a step and inside it.

use crate::excitation::side::Side;
use crate::model::equations::Model;
use crate::ode::integrate_error::IntegrateError;
use crate::ode::stepping::dense::interpolate;
use crate::ode::stepping::engine::{Engine, Tableau, halves};
use crate::ode::stepping::vector::Vector;

impl<M: Model + ?Sized, V: Vector> Engine<'_, M, V> {
    /// Computes the contacts at θ of the step from the dense output, in `self.contacts`.
    pub(crate) fn contacts_inside<T: Tableau>(&mut self, theta: f64) {
        interpolate::<T, V>(&self.dense, theta, self.look.slice_mut());
        self.drive(theta);
        let (q, v) = halves(&self.look);
        self.model.contact(&self.u_stage, q, v, &mut self.contacts);
    }

    /// Computes the contacts at θ of the step in `self.contacts`, with the coordinates from the cubic through
    /// the coordinates and velocities at both ends.
    ///
    /// No acceleration is evaluated. Terms that depend on the drives alone are exact.
    pub(crate) fn contacts_on_cubic(&mut self, theta: f64) {
        self.drive(theta);
        self.look_on_cubic(theta);
        let (q, v) = halves(&self.look);
        self.model.contact(&self.u_stage, q, v, &mut self.contacts);
    }

    /// [`contacts_on_cubic`](Engine::contacts_on_cubic) at the node `PROBE`. Returns this node.
    #[inline]
    pub(crate) fn contacts_at_probe<T: Tableau>(&mut self) -> f64 {
        let theta = T::NODES[T::PROBE];
        self.look_on_cubic(theta);
        let (q, v) = halves(&self.look);
        self.model.contact(self.nodes.at(T::PROBE), q, v, &mut self.contacts);
        theta
    }

    /// The state at θ on the cubic through the coordinates and velocities at both ends, in `self.look`.
    #[inline(always)]
    fn look_on_cubic(&mut self, theta: f64) {
        let (h, n) = (self.h, self.model.dof());
        let (rest, wave) = (1.0 - theta, 6.0 * theta * (1.0 - theta) / h);
        let [a, b, c] =
            [theta * theta * (3.0 - 2.0 * theta), h * theta * rest * rest, h * theta * theta * rest];
        let [d, e] = [rest * (1.0 - 3.0 * theta), theta * (3.0 * theta - 2.0)];
        // Halves of one length, so that bounds are checked once.
        let ((q0, v0), (q1, v1)) = (self.y.slice().split_at(n), self.y1.slice().split_at(n));
        let (q, v) = self.look.slice_mut().split_at_mut(n);
        let (v0, v1, v) = (&v0[..n], &v1[..n], &mut v[..n]);
        for j in 0..n {
            let rise = q1[j] - q0[j];
            q[j] = q0[j] + a * rise + b * v0[j] - c * v1[j];
            v[j] = wave * rise + d * v0[j] + e * v1[j];
        }
    }

    /// Computes in `noise` the effect of rounding of the coordinates and velocities on each deflection: the
    /// largest change when every one of them changes by its last bit, up or down.
    pub(crate) fn rounding_of_contacts(&mut self, noise: &mut [f64]) {
        noise.fill(0.0);
        self.contacts_at_start();
        // The direction of component j is a bit of j: any two components change in opposite directions at
        // least once.
        let patterns = usize::BITS - self.y.slice().len().leading_zeros();
        for pattern in 0..patterns {
            for (j, (out, y)) in self.look.slice_mut().iter_mut().zip(self.y.slice()).enumerate() {
                let up = (j >> pattern) & 1 == 0;
                *out = if up { y * (1.0 + f64::EPSILON) } else { y * (1.0 - f64::EPSILON) };
            }
            let (q, v) = halves(&self.look);
            self.model.contact(&self.u_stage, q, v, &mut self.shaken);
            for (noise, (a, b)) in noise.iter_mut().zip(self.contacts.iter().zip(&self.shaken)) {
                *noise = noise.max((a.deflection - b.deflection).abs());
            }
        }
    }

    /// Computes the contacts at the end of the step in `self.contacts`, before a jump of the drives there.
    #[inline(always)]
    pub(crate) fn contacts_at_end(&mut self) {
        let (q, v) = halves(&self.y1);
        self.model.contact(self.nodes.end(), q, v, &mut self.contacts);
    }

    /// Computes the contacts at the start of the step in `self.contacts`, after a jump of the drives there.
    pub(crate) fn contacts_at_start(&mut self) {
        self.model.redrive(self.t, Side::After, &mut self.u_stage);
        let (q, v) = halves(&self.y);
        self.model.contact(&self.u_stage, q, v, &mut self.contacts);
    }

    /// Checks that no gap of the last evaluation is negative. In a negative gap, the acceleration on fixed
    /// pieces and the acceleration of the model itself would differ.
    #[inline(always)]
    pub(crate) fn check_gaps(&self, t: f64) -> Result<(), IntegrateError> {
        for (contact, c) in self.contacts.iter().enumerate() {
            if c.lower > c.upper {
                return Err(IntegrateError::NegativeGap { t, contact, lower: c.lower, upper: c.upper });
            }
        }
        Ok(())
    }
}
