//! The Jacobian of a balance: Toeplitz plus Hankel in the coefficients of the slopes.

use super::Harmonics;
use super::couplings::{Couplings, Slope};
use super::spectra::{Jump, Spectra};
use crate::error::ParameterError;
use crate::root::Matrix;
use std::ops::Range;

/// Where the unknowns of a balance stand, and how to fill its Jacobian.
///
/// Unknowns: coefficients of every coordinate over its scale, then the mean accelerations of the rigid motions.
pub(super) struct Layout {
    pub(super) harmonics: Harmonics,
    pub(super) dof: usize,
    pub(super) omega: f64,
    /// q_j = scale_j x_j, and equation i over scale_i.
    pub(super) scales: Vec<f64>,
    /// Free motions of the whole, one entry per coordinate.
    pub(super) rigid: Vec<Vec<f64>>,
    /// Unknown α over its scale.
    pub(super) rigid_scale: f64,
    sparse: bool,
}

impl Layout {
    pub(super) fn new(harmonics: &Harmonics, omega: f64, scales: Vec<f64>, rigid: Vec<Vec<f64>>, couplings: &Couplings) -> Self {
        let dof = scales.len();
        let varying = couplings.list.iter().filter(|c| is_varying(c.q) || is_varying(c.v)).count();
        Layout {
            harmonics: harmonics.clone(),
            dof,
            omega,
            rigid: if harmonics.has_mean() { rigid } else { Vec::new() },
            rigid_scale: scales[0] * couplings.stiffest.max(omega * omega),
            scales,
            sparse: dof >= 4 && 3 * varying < dof * dof,
        }
    }

    pub(super) fn make_dense(&mut self) {
        self.sparse = false;
    }

    pub(super) fn size(&self) -> usize {
        self.dof * self.harmonics.unknowns() + self.rigid.len()
    }

    /// An empty Jacobian.
    pub(super) fn matrix(&self, couplings: &Couplings) -> Result<Matrix, ParameterError> {
        if !self.sparse {
            return Ok(Matrix::dense(self.size()));
        }
        let width = self.harmonics.unknowns();
        let mut columns = vec![Vec::new(); self.size()];
        for c in &couplings.list {
            let whole = is_varying(c.q) || is_varying(c.v);
            for (i, &order) in self.harmonics.orders().iter().enumerate() {
                let own = self.rows_of(i, order);
                for column in own.clone() {
                    let rows = if whole { 0..width } else { own.clone() };
                    columns[c.j * width + column].extend(rows.map(|row| c.i * width + row));
                }
            }
        }
        for r in 0..self.rigid.len() {
            let border = self.dof * width + r;
            for j in 0..self.dof {
                columns[j * width].push(border);
                columns[border].push(j * width);
            }
        }
        Matrix::sparse(&columns)
    }

    /// The rows of one order inside a block.
    fn rows_of(&self, index: usize, order: usize) -> Range<usize> {
        let at = self.harmonics.place(index);
        if order == 0 { at..at + 1 } else { at..at + 2 }
    }

    /// ∂R/∂x of R = q'' - a, all over the scales.
    pub(super) fn fill(&self, couplings: &Couplings, spectra: &Spectra, out: &mut Matrix) {
        let width = self.harmonics.unknowns();
        let tables = &spectra.slopes;
        let mut list = couplings.list.iter().peekable();
        for j in 0..self.dof {
            let first = list.clone();
            let count = std::iter::from_fn(|| list.next_if(|c| c.j == j)).count();
            for (index, &order) in self.harmonics.orders().iter().enumerate() {
                let own = self.rows_of(index, order);
                let rate = order as f64 * self.omega;
                for (parity, column) in own.clone().enumerate() {
                    let entries = out.column_mut(j * width + column);
                    entries.fill(0.0);
                    let mut at = 0;
                    for c in first.clone().take(count) {
                        let whole = !self.sparse || is_varying(c.q) || is_varying(c.v);
                        if !self.sparse {
                            at = c.i * width;
                        }
                        let (length, diagonal) = if whole { (width, own.start) } else { (own.len(), 0) };
                        let block = &mut entries[at..at + length];
                        at += length;
                        // The velocity of c cos is -kω c sin, of s sin it is +kω s cos.
                        let turned = if parity == 0 { -rate } else { rate };
                        let scale = -self.scales[j] / self.scales[c.i];
                        match c.q {
                            Slope::Constant(a) => block[diagonal + parity] += scale * a,
                            Slope::Varying(number) => tables[number].add(block, &self.harmonics, order, parity == 1, scale),
                        }
                        match c.v {
                            _ if order == 0 => {}
                            Slope::Constant(b) => block[diagonal + 1 - parity] += scale * turned * b,
                            Slope::Varying(number) => tables[number].add(block, &self.harmonics, order, parity == 0, scale * turned),
                        }
                        if c.i == j {
                            block[diagonal + parity] -= rate * rate;
                        }
                    }
                    for jump in &spectra.jumps {
                        self.add_jump(jump, couplings, (j, order, parity), entries);
                    }
                    if order == 0 {
                        let end = entries.len();
                        for (r, rigid) in self.rigid.iter().enumerate() {
                            let place = if self.sparse { end - self.rigid.len() + r } else { self.dof * width + r };
                            entries[place] = self.scales[j] / self.scales[0] * rigid[j];
                        }
                    }
                }
            }
        }
        for (r, rigid) in self.rigid.iter().enumerate() {
            let entries = out.column_mut(self.dof * width + r);
            entries.fill(0.0);
            for (i, share) in rigid.iter().enumerate() {
                entries[if self.sparse { i } else { i * width }] = self.rigid_scale / self.scales[i] * share;
            }
        }
    }

    /// A force that jumps at a switch: the switch moves with the orbit.
    fn add_jump(&self, jump: &Jump, couplings: &Couplings, (j, order, parity): (usize, usize, usize), entries: &mut [f64]) {
        if jump.row[j] == 0.0 {
            return;
        }
        let (sin, cos) = libm::sincos(jump.phase * order as f64);
        let moved = jump.row[j] * if parity == 0 { cos } else { sin };
        let width = self.harmonics.unknowns();
        let mut at = 0;
        for c in couplings.list.iter().filter(|c| c.j == j) {
            let whole = !self.sparse || is_varying(c.q) || is_varying(c.v);
            if !self.sparse {
                at = c.i * width;
            }
            if whole {
                let share = -moved * jump.size[c.i] * self.scales[j] / self.scales[c.i];
                let block = &mut entries[at..at + width];
                for (index, &k) in self.harmonics.orders().iter().enumerate() {
                    let (sin, cos) = libm::sincos(jump.phase * k as f64);
                    let place = self.harmonics.place(index);
                    if k == 0 {
                        block[place] += share;
                    } else {
                        block[place] += 2.0 * cos * share;
                        block[place + 1] += 2.0 * sin * share;
                    }
                }
            }
            at += if whole { width } else { 1 + usize::from(order > 0) };
        }
    }

    /// Which coordinate an unknown belongs to.
    pub(super) fn coordinate(&self, unknown: usize) -> usize {
        (unknown / self.harmonics.unknowns()).min(self.dof - 1)
    }
}

pub(super) fn is_varying(slope: Slope) -> bool {
    matches!(slope, Slope::Varying(_))
}
