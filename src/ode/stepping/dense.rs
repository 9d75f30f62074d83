//! Dense output of one step.

use crate::ode::stepping::ends::LARGEST;
use crate::ode::stepping::engine::{DENSE, Engine, Tableau};
use crate::ode::stepping::tableau_row::TableauRow;
use crate::ode::stepping::vector::Vector;

impl<V: Vector> Engine<'_, V> {
    /// Computes the dense output of the step, unless it is computed already.
    pub(crate) fn prepare_dense<T: Tableau>(&mut self) {
        if self.ready.dense {
            return;
        }
        self.derivative_at_end_of::<T>();
        if self.on_fixed_pieces {
            T::dense::<V, true>(self)
        } else {
            T::dense::<V, false>(self)
        }
        self.evaluations += T::DENSE_EVALUATIONS;
        let (ends, h, m) = (&self.ends, self.ends.h, self.ends.y.slice().len());
        let [first, rise, bend, twist, ..] = &mut self.dense;
        let [first, rise] = [first, rise].map(|column| &mut column.slice_mut()[..m]);
        let [bend, twist] = [bend, twist].map(|column| &mut column.slice_mut()[..m]);
        let [y, y1, k0, k1] = [&ends.y, &ends.y1, &self.k[0], &self.k[T::END]].map(|x| &x.slice()[..m]);
        for j in 0..m {
            let dy = y1[j] - y[j];
            first[j] = y[j];
            rise[j] = dy;
            if T::HERMITE {
                bend[j] = h * k0[j] - dy;
                twist[j] = 2.0 * dy - h * (k0[j] + k1[j]);
            }
        }
        // Coefficients overflow in an accepted step only if the tolerance exceeds the motion. Without them
        // the dense output still agrees with both ends of the step.
        for column in &mut self.dense {
            if column.size() <= LARGEST {
                continue;
            }
            for coefficient in column.slice_mut() {
                if coefficient.is_nan() || coefficient.abs() > LARGEST {
                    *coefficient = 0.0;
                }
            }
        }
        self.ready.dense = true;
    }

    /// Computes the contacts at θ of the step from the dense output, in `ends.contacts`.
    pub(crate) fn contacts_inside<T: Tableau>(&mut self, theta: f64) {
        let ends = &mut self.ends;
        interpolate::<T, V>(&self.dense, theta, ends.look.slice_mut());
        ends.drive(theta);
        ends.contacts_at_look(theta);
    }

    /// Dense coefficient F_c = h Σ d_l k_l; c ≥ 3 after those of Hermite's cubic.
    pub(crate) fn dense_row<const L: usize>(&mut self, c: usize, row: &TableauRow<L>) {
        V::weigh(&mut self.dense[c + 1], &self.k, self.ends.h, row);
    }

    /// y(t + θ h) = y0 + θ (F0 + (1-θ) (F1 + θ (F2 + (1-θ) (F3 + ...)))).
    #[inline]
    pub(crate) fn interpolate<T: Tableau>(&self, theta: f64, out: &mut [f64]) {
        interpolate::<T, V>(&self.dense, theta, out);
    }
}

/// The dense output at θ from its coefficients; see [`Engine::interpolate`].
pub(crate) fn interpolate<T: Tableau, V: Vector>(dense: &[V; DENSE], theta: f64, out: &mut [f64]) {
    let columns: [&[f64]; DENSE] =
        std::array::from_fn(|c| if c <= T::DENSE { dense[c].slice() } else { &[][..] });
    // Eight components at a time: the operations of one component depend on each other and cannot run in
    // parallel.
    let whole = out.len() - out.len() % 8;
    for j in (0..whole).step_by(8) {
        horner::<8>(&columns[..=T::DENSE], j, theta, out);
    }
    for j in whole..out.len() {
        horner::<1>(&columns[..=T::DENSE], j, theta, out);
    }
}

/// The dense output at θ for W components from `j` on.
#[inline(always)]
fn horner<const W: usize>(columns: &[&[f64]], j: usize, theta: f64, out: &mut [f64]) {
    let mut sum = [0.0; W];
    for (c, column) in columns.iter().enumerate().skip(1).rev() {
        let (factor, column) = (if c % 2 == 1 { theta } else { 1.0 - theta }, &column[j..][..W]);
        for i in 0..W {
            sum[i] = (sum[i] + column[i]) * factor;
        }
    }
    let (out, start) = (&mut out[j..][..W], &columns[0][j..][..W]);
    for i in 0..W {
        out[i] = start[i] + sum[i];
    }
}
