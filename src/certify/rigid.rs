//! Motions apart from a rigid motion: relative coordinates in place of all coordinates.

use crate::certify::slots::with_inputs;
use crate::interval::number::Interval;
use crate::numeric::norms::decomposition;
use crate::tape::form::Form;
use crate::tape::operations::{FormId, Op, Tape};
use nalgebra::DMatrix;

/// Relative coordinates z_i = q_i - ρ_i q_r of a model that is unchanged by q + s ρ and v + w ρ, ρ_r = 1.
///
/// Because nothing but q_r and v_r depends on the rigid motion, z'' = a - ρ a_r at q_r = 0 and v_r = 0.
#[derive(Clone, Debug)]
pub(crate) struct Relative {
    /// The coordinate r.
    pub(crate) root: usize,
    /// ρ_i of all coordinates.
    pub(crate) ratios: Vec<Interval>,
}

/// Largest singular value of a direction that changes nothing, as a share of the largest one `[1]`.
const UNCHANGED: f64 = 1e-12;

/// Roundings of the ratios and of the sums of recorded coefficients `[1]`.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

impl Relative {
    /// The rigid motion of a recorded model; `None` if there is none, or more than one.
    pub(crate) fn of(tape: &Tape) -> Option<Self> {
        let n = tape.dof;
        let mut rows: Vec<Vec<f64>> = Vec::new();
        for form in operands(tape).chain(tape.accelerations.iter().copied()) {
            for half in parts(tape, form) {
                let largest = half.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
                if largest > 0.0 && largest.is_finite() {
                    rows.push(half.iter().map(|x| x / largest).collect());
                }
            }
        }
        // Coordinates may be angles and lengths: each is measured by its largest coefficient.
        let unit = |j: usize| rows.iter().fold(0.0, |most: f64, row| most.max(row[j].abs()));
        let units: Vec<f64> = (0..n).map(|j| Some(unit(j)).filter(|x| *x > 0.0).unwrap_or(1.0)).collect();
        let matrix =
            DMatrix::from_fn(rows.len().max(n), n, |i, j| rows.get(i).map_or(0.0, |row| row[j] / units[j]));
        let svd = decomposition(matrix, false)?;
        let values = &svd.singular_values;
        let zero: Vec<usize> = (0..n).filter(|&k| values[k] <= UNCHANGED * values.max()).collect();
        let [k] = zero[..] else { return None };
        let direction = svd.v_t?.row(k).transpose();
        let motion: Vec<f64> = (0..n).map(|j| direction[j] / units[j]).collect();
        let root = (0..n).max_by(|&i, &j| direction[i].abs().total_cmp(&direction[j].abs()))?;
        let ratio = |(j, x): (usize, &f64)| match j == root {
            true => Interval::ONE,
            // The direction is of length 1 and its entries have errors of roundings.
            false => {
                let error = ROUNDING / (units[j] * motion[root].abs());
                Interval::from(x / motion[root]) + Interval::symmetric(error)
            }
        };
        let ratios: Vec<Interval> = motion.iter().enumerate().map(ratio).collect();
        ratios.iter().all(|ratio| ratio.is_bounded()).then_some(Relative { root, ratios })
    }

    /// The recorded equations in relative coordinates, with the ratios as further drives; `None` if the rigid
    /// motion changes a recorded sum. `moved`: the outputs are velocities, which move with it.
    pub(crate) fn tape(&self, tape: &Tape, moved: bool) -> Option<Tape> {
        let (n, root) = (tape.dof, self.root);
        if self.ratios.len() != n {
            return None;
        }
        let still = operands(tape).all(|form| parts(tape, form).iter().all(|half| self.moves(half, 0.0)));
        let outputs = tape.accelerations.iter().zip(&self.ratios).all(|(form, ratio)| {
            let [q, v] = parts(tape, *form);
            self.moves(&q, 0.0) && self.moves(&v, if moved { ratio.middle() } else { 0.0 })
        });
        if !(still && outputs) {
            return None;
        }
        let (dof, drives) = (n - 1, tape.drives + n - 1);
        let below = |i: usize| i - usize::from(i > root);
        let mut relative = with_inputs(tape, [dof, drives], |slot| match slot {
            _ if slot % n == root && slot < 2 * n => None,
            _ if slot < n => Some(below(slot)),
            _ if slot < 2 * n => Some(dof + below(slot - n)),
            _ => Some(slot - 2),
        });
        let of_root = tape.accelerations[root];
        relative.accelerations = self.others().map(|i| tape.accelerations[i]).collect();
        for j in 0..dof {
            let ratio = (2 * dof + tape.drives + j) as u32;
            relative.forms.push(Form::slot(ratio));
            let slot = relative.inputs() + relative.ops.len();
            relative.ops.push((Op::Product(relative.forms.len() - 1, of_root), None));
            let own = relative.forms[relative.accelerations[j]].plus(&Form::slot(slot as u32), -1.0);
            relative.forms.push(own);
            relative.accelerations[j] = relative.forms.len() - 1;
        }
        Some(relative)
    }

    /// Whether the contact forces of the recorded model are unchanged, too.
    pub(crate) fn keeps_forces(&self, tape: &Tape) -> bool {
        let forces: Vec<FormId> = tape.measured.iter().map(|&[_, force]| force).collect();
        let needed = tape.needed_with(&forces);
        let ops = tape.ops.iter().enumerate().filter(|(i, _)| needed[tape.inputs() + i]);
        let read = ops.flat_map(|(_, (op, _))| op.operands());
        read.chain(forces.iter().copied())
            .all(|form| parts(tape, form).iter().all(|half| self.moves(half, 0.0)))
    }

    /// All coordinates but r.
    pub(crate) fn others(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.ratios.len()).filter(|i| *i != self.root)
    }
    /// The relative coordinates of all coordinates, in plain numbers.
    pub(crate) fn coordinates(&self, q: &[f64]) -> Vec<f64> {
        self.others().map(|i| q[i] - self.ratios[i].middle() * q[self.root]).collect()
    }
    /// Ranges of the relative coordinates from those of all coordinates.
    pub(crate) fn ranges(&self, range: &[f64]) -> Vec<f64> {
        self.others().map(|i| range[i] + self.ratios[i].magnitude() * range[self.root]).collect()
    }

    /// Whether Σ w_i ρ_i is a given number, but for the rounding of its terms.
    fn moves(&self, weights: &[f64], by: f64) -> bool {
        let terms = weights.iter().zip(&self.ratios).map(|(w, ratio)| w * ratio.middle());
        let (sum, size) = terms.fold((-by, by.abs()), |(sum, size), x| (sum + x, size + x.abs()));
        sum.abs() <= ROUNDING * size
    }
}

/// The forms that the needed operations read, and the distances.
fn operands(tape: &Tape) -> impl Iterator<Item = FormId> + '_ {
    let needed = tape.needed();
    let ops = tape.ops.iter().enumerate();
    let ops = ops.filter(move |(i, _)| needed[tape.inputs() + i]).flat_map(|(_, (op, _))| op.operands());
    ops.chain(tape.distances.iter().flatten().flatten().copied())
}

/// The weights of the coordinates and of the velocities in a form.
fn parts(tape: &Tape, form: FormId) -> [Vec<f64>; 2] {
    let mut parts = [vec![0.0; tape.dof], vec![0.0; tape.dof]];
    for &(slot, weight) in &tape.forms[form].terms {
        let slot = slot as usize;
        if slot < 2 * tape.dof {
            parts[slot / tape.dof][slot % tape.dof] = weight;
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use crate::certify::rigid::Relative;
    use crate::model::recording::{Node, Recorded};
    use crate::tape::operations::Tape;

    /// Two masses with levers 1 and 3, and a third one on a spring to the ground of this stiffness.
    fn masses(to_ground: f64) -> Tape {
        let recorded = Recorded::of(3, 0, &|_| None, |_, _, q, v, a| {
            let force = (q[0] - q[1] * 3.0) * 7.0 + (v[0] - v[1] * 3.0) * (q[0] - q[1] * 3.0);
            (a[0], a[1]) = (-force, force * 3.0);
            a[2] = q[2] * -to_ground + Node::from(1.0);
            Vec::new()
        });
        recorded.0
    }

    #[test]
    fn the_rigid_motion_is_found_and_leaves_the_equations() {
        let tape = masses(2.0);
        let relative = Relative::of(&tape).expect("one rigid motion");
        for (ratio, r) in relative.ratios.iter().zip([3.0, 1.0, 0.0]) {
            assert!(ratio.contains(r / [3.0, 1.0, 0.0][relative.root]) && ratio.width() < 1e-12, "{ratio}");
        }
        let reduced = relative.tape(&tape, false).expect("unchanged sums");
        assert_eq!((reduced.dof, reduced.drives), (2, 2));
        let ratios = relative.ratios.iter().enumerate().map(|(i, ratio)| *ratio * (1.0 + 1e-9 * i as f64));
        let other = Relative { ratios: ratios.collect(), ..relative };
        assert!(other.tape(&tape, false).is_none());
        // The third mass moves freely, too: two rigid motions.
        assert!(Relative::of(&masses(0.0)).is_none());
    }
}
