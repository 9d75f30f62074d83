//! Jacobian of a balance: Toeplitz plus Hankel matrices of the Fourier coefficients of the slopes.

use crate::model::structure::couplings::{Coupling, Couplings, Slope};
use crate::model::structure::drifts::Drifts;
use crate::periodic::balance::series::harmonics::Harmonics;
use crate::periodic::balance::series::spectra::{Spectra, add_mean};
use crate::roots::Matrix;

/// Order of the unknowns of a balance, and assembly of its Jacobian.
///
/// The unknowns are the coefficients of every coordinate over its scale, then one for each drift: the mean
/// acceleration of a rigid motion, the mean speed along a direction of which only the velocity acts.
pub(crate) struct JacobianLayout {
    pub(crate) harmonics: Harmonics,
    pub(crate) dof: usize,
    pub(crate) omega: f64,
    /// Scales: q_j = scale_j x_j; equation i is divided by scale_i.
    pub(crate) scales: Vec<f64>,
    /// Directions along which the orbit drifts, one entry per coordinate. The rigid motions come first; the
    /// directions with a mean speed follow.
    pub(crate) drifts: Vec<Vec<f64>>,
    /// Number of rigid motions.
    pub(crate) rigid: usize,
    /// Scale of the mean accelerations α.
    pub(crate) rigid_scale: f64,
    /// For each drift, the coordinate whose mean is prescribed as zero.
    pub(crate) fixed: Vec<usize>,
    /// Whether the Jacobian is stored in blocks.
    sparse: bool,
}

impl JacobianLayout {
    pub(crate) fn new(
        harmonics: &Harmonics,
        omega: f64,
        scales: Vec<f64>,
        drifts: &Drifts,
        couplings: &Couplings,
    ) -> Self {
        let dof = scales.len();
        let varying = couplings.list.iter().filter(|c| is_varying(c.q) || is_varying(c.v)).count();
        let directions = [drifts.speeds.clone(), drifts.held()].concat();
        let directions = if harmonics.has_mean() { directions } else { Vec::new() };
        let fixed = fixed_coordinates(&directions, dof);
        JacobianLayout {
            harmonics: harmonics.clone(),
            dof,
            omega,
            sparse: dof >= 4 && 3 * varying < dof * dof && (fixed.is_empty() || fixed == [dof - 1]),
            rigid: drifts.speeds.len().min(directions.len()),
            drifts: directions,
            fixed,
            rigid_scale: scales[0] * couplings.stiffest.max(omega * omega),
            scales,
        }
    }

    /// Stores the Jacobian in one dense matrix, without drifts that have a mean speed.
    pub(crate) fn make_dense(&mut self) {
        self.sparse = false;
        self.drifts.truncate(self.rigid);
        self.fixed.truncate(self.rigid);
    }

    /// Scale of the unknown of drift k.
    pub(crate) fn drift_scale(&self, k: usize) -> f64 {
        if k < self.rigid { self.rigid_scale } else { self.scales[0] * self.omega }
    }

    pub(crate) fn size(&self) -> usize {
        self.dof * self.harmonics.unknowns() + self.drifts.len()
    }

    /// Upper bound of the number of entries that the Jacobian stores.
    pub(crate) fn entries(&self, couplings: &Couplings) -> usize {
        let height = self.harmonics.unknowns() + self.drifts.len();
        let blocks = if self.sparse { couplings.list.len() + self.dof } else { self.dof * self.dof };
        blocks.saturating_mul(height.saturating_mul(height))
    }

    /// An empty Jacobian: blocks in the order of the couplings, or one dense matrix if there are few
    /// coordinates or many full blocks.
    pub(crate) fn matrix(&self, couplings: &Couplings) -> Matrix {
        if !self.sparse {
            return Matrix::dense(self.size());
        }
        let mut heights = vec![self.harmonics.unknowns(); self.dof];
        // The unknowns of drifts belong to the block of the coordinate whose mean is prescribed.
        heights[self.dof - 1] += self.drifts.len();
        let mut matrix = Matrix::of_heights(&heights);
        matrix.eliminate_last(self.dof - 1);
        let mut last_column = vec![false; self.dof];
        for c in &couplings.list {
            let at_border = !self.drifts.is_empty() && (c.i == self.dof - 1 || c.j == self.dof - 1);
            matrix.add_part(c.i, c.j, !(at_border || is_varying(c.q) || is_varying(c.v)));
            last_column[c.i] |= c.j == self.dof - 1;
        }
        if !self.drifts.is_empty() {
            (0..self.dof).filter(|&i| !last_column[i]).for_each(|i| matrix.add_part(i, self.dof - 1, false));
        }
        matrix
    }

    /// Computes ∂R/∂x of R = q'' - a, with equations and unknowns in their scales.
    pub(crate) fn fill(&self, couplings: &Couplings, spectra: &Spectra, out: &mut Matrix) {
        let (width, size) = (self.harmonics.unknowns(), self.size());
        let heights: Vec<usize> = (0..out.block_rows()).map(|i| out.height(i)).collect();
        for part in out.parts_mut() {
            part.values.fill(0.0);
        }
        for (number, c) in couplings.list.iter().enumerate() {
            let (part, view) = if self.sparse {
                let part = &mut out.parts_mut()[number];
                let view =
                    View { first: 0, stride: if part.pairs { 2 } else { heights[c.i] }, pairs: part.pairs };
                (part, view)
            } else {
                (
                    &mut out.parts_mut()[0],
                    View { first: c.j * width * size + c.i * width, stride: size, pairs: false },
                )
            };
            self.fill_block(c, spectra, &view, &mut part.values);
        }
        self.fill_border(couplings, spectra, out);
    }

    fn fill_block(&self, c: &Coupling, spectra: &Spectra, view: &View, values: &mut [f64]) {
        let (width, tables) = (self.harmonics.unknowns(), &spectra.slopes);
        let scale = -self.scales[c.j] / self.scales[c.i];
        for (index, &order) in self.harmonics.orders().iter().enumerate() {
            let (at, rate) = (self.harmonics.place(index), order as f64 * self.omega);
            for parity in 0..if order == 0 { 1 } else { 2 } {
                let start = view.first + (at + parity) * view.stride;
                let (length, diagonal) = if view.pairs { (2, 0) } else { (width, at) };
                let block = &mut values[start..start + length];
                // The velocity of c cos kωt is -kω c sin kωt; the velocity of s sin kωt is kω s cos kωt.
                let turned = scale * if parity == 0 { -rate } else { rate };
                match c.q {
                    Slope::Constant(a) => block[diagonal + parity] += scale * a,
                    Slope::Periodic(number) => {
                        tables[number].add(block, &self.harmonics, order, parity == 1, scale)
                    }
                }
                match c.v {
                    _ if order == 0 => {}
                    Slope::Constant(b) => block[diagonal + 1 - parity] += turned * b,
                    Slope::Periodic(number) => {
                        tables[number].add(block, &self.harmonics, order, parity == 0, turned)
                    }
                }
                if c.i == c.j {
                    block[diagonal + parity] -= rate * rate;
                }
                for jump in spectra
                    .jumps
                    .iter()
                    .filter(|jump| !view.pairs && jump.row[c.j] != 0.0 && jump.size[c.i] != 0.0)
                {
                    let (sin, cos) = libm::sincos(jump.phase * order as f64);
                    let moved = jump.row[c.j] * if parity == 0 { cos } else { sin };
                    jump.add(block, &self.harmonics, scale * moved * jump.size[c.i]);
                }
            }
        }
    }

    /// Fills the columns of the drifts and the rows of the prescribed means.
    fn fill_border(&self, couplings: &Couplings, spectra: &Spectra, out: &mut Matrix) {
        let (width, size, n) = (self.harmonics.unknowns(), self.size(), self.dof);
        let (last, sparse) = (n - 1, self.sparse);
        let height = width + self.drifts.len();
        for (r, direction) in self.drifts.iter().enumerate() {
            let fixed = self.fixed[r];
            // The equations of coordinate i.
            let fill = |i: usize, column: &mut [f64]| {
                let scale = self.drift_scale(r) / self.scales[i];
                if r < self.rigid {
                    column[0] = scale * direction[i];
                } else {
                    couplings.each_by_speed(i, direction, |slope, speed| {
                        add_mean(&spectra.slopes, slope, &self.harmonics, -scale * speed, column);
                    });
                }
            };
            for part in out.parts_mut() {
                if !sparse {
                    part.values[fixed * width * size + n * width + r] = 1.0;
                    for i in 0..n {
                        fill(i, &mut part.values[(n * width + r) * size + i * width..][..width]);
                    }
                } else if part.j == last {
                    let stride = if part.i == last { height } else { width };
                    fill(part.i, &mut part.values[(width + r) * stride..][..width]);
                    if part.i == last {
                        part.values[width + r] = 1.0;
                    }
                }
            }
        }
    }

    /// Coordinate to which an unknown belongs. The unknown of a drift belongs to the last coordinate.
    pub(crate) fn coordinate(&self, unknown: usize) -> usize {
        (unknown / self.harmonics.unknowns()).min(self.dof - 1)
    }

    /// Order to which an unknown belongs. The unknown of a drift has order 0.
    pub(crate) fn order(&self, unknown: usize) -> usize {
        let (width, orders) = (self.harmonics.unknowns(), self.harmonics.orders());
        if unknown >= self.dof * width {
            return 0;
        }
        let mut places = orders.iter().enumerate().rev();
        let at = places.find(|(i, _)| self.harmonics.place(*i) <= unknown % width);
        at.map_or(0, |(_, order)| *order)
    }
}

/// Place of a block in an array of values.
struct View {
    first: usize,
    /// Distance from column to column.
    stride: usize,
    /// Whether the block stores its diagonal pairs alone.
    pairs: bool,
}

/// For each drift, the last coordinate whose share exceeds 1 % of the largest share, after the earlier
/// motions have been eliminated with their coordinates.
fn fixed_coordinates(drifts: &[Vec<f64>], dof: usize) -> Vec<usize> {
    let mut reduced = drifts.to_vec();
    let mut fixed = Vec::new();
    for r in 0..reduced.len() {
        let largest = reduced[r].iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let pivot = (0..dof).rev().find(|&j| reduced[r][j].abs() > 0.01 * largest).unwrap_or(dof - 1);
        let (done, rest) = reduced.split_at_mut(r + 1);
        for other in rest {
            let share = other[pivot] / done[r][pivot];
            other.iter_mut().zip(&done[r]).for_each(|(x, y)| *x -= share * y);
        }
        fixed.push(pivot);
    }
    fixed
}

pub(crate) fn is_varying(slope: Slope) -> bool {
    matches!(slope, Slope::Periodic(_))
}
