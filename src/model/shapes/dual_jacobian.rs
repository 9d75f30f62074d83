//! Jacobians by dual numbers.

use crate::contact::{ByDeflection, FixedPieces, Piece, PieceChoice};
use crate::dual::Dual;
use crate::model::jacobian::Jacobian;
use crate::model::shapes::shape::{Drives, Shape, Size};
use crate::tape::columns::Columns;

/// Writes the Jacobian of a shape by dual numbers, exact to rounding: by deflection or on given pieces.
/// `columns`: those that one dual number holds together; `None`: each is alone.
pub(crate) fn dual_jacobian<G: Shape>(
    shape: &G,
    columns: Option<&Columns>,
    pieces: Option<&[Piece]>,
    u: &[f64],
    q: &[f64],
    v: &[f64],
    out: &mut Jacobian,
) {
    let Some(columns) = columns else {
        return slopes(shape, pieces, u, q, v, Way::Alone(out));
    };
    let n = q.len();
    out.q.fill(0.0);
    out.v.fill(0.0);
    let mut write = |i: usize, j: usize, slope: f64| match j.checked_sub(n) {
        None => out.q[(i, j)] = slope,
        Some(j) => out.v[(i, j)] = slope,
    };
    slopes(shape, pieces, u, q, v, Way::Grouped(columns, &mut write));
}

/// How the columns of a Jacobian are made, and where they go.
pub(crate) enum Way<'a> {
    /// One by one.
    Alone(&'a mut Jacobian),
    /// In groups: row, column and value of each entry that is not always 0. The columns of the velocities
    /// follow those of the coordinates.
    Grouped(&'a Columns, &'a mut dyn FnMut(usize, usize, f64)),
}

/// Writes Σ_k ∂a/∂u_k w_k by dual numbers, exact to rounding: by deflection or on given pieces.
pub(crate) fn slope_along<G: Shape>(
    shape: &G,
    along: &[f64],
    pieces: Option<&[Piece]>,
    u: &[f64],
    q: &[f64],
    v: &[f64],
    out: &mut [f64],
) {
    with_numbers(u.len() + 3 * shape.size().dof, |numbers: &mut [Dual]| match pieces {
        None => slope_along_in(numbers, shape, &ByDeflection, along, u, q, v, out),
        Some(pieces) => slope_along_in(numbers, shape, &FixedPieces(pieces), along, u, q, v, out),
    });
}

#[allow(clippy::too_many_arguments, reason = "the arguments of an acceleration, a direction and scratch")]
fn slope_along_in<G: Shape, L: PieceChoice<Dual>>(
    numbers: &mut [Dual],
    shape: &G,
    law: &L,
    along: &[f64],
    u: &[f64],
    q: &[f64],
    v: &[f64],
    out: &mut [f64],
) {
    let Size { dof: n, waves, .. } = shape.size();
    for (number, &x) in numbers.iter_mut().zip(u.iter().chain(q).chain(v)) {
        *number = x.into();
    }
    numbers.iter_mut().zip(along).for_each(|(number, slope)| number.slope = [*slope]);
    let (u, rest) = numbers.split_at_mut(u.len());
    let (y, a) = rest.split_at_mut(2 * n);
    shape.accel(law, Drives::new(waves, u), &y[..n], &y[n..], a);
    out.iter_mut().zip(a).for_each(|(out, a)| *out = a.slope[0]);
}

/// Calls `write` with `needed` numbers. Up to 512 stand on the stack, in an array that is not much longer: it
/// is set to zero in each call.
#[inline(always)]
fn with_numbers<const N: usize>(needed: usize, mut write: impl FnMut(&mut [Dual<N>])) {
    let zero = Dual::from(0.0);
    match needed {
        0..=32 => write(&mut [zero; 32][..needed]),
        33..=64 => write(&mut [zero; 64][..needed]),
        65..=128 => write(&mut [zero; 128][..needed]),
        129..=256 => write(&mut [zero; 256][..needed]),
        257..=512 => write(&mut [zero; 512][..needed]),
        _ => write(&mut vec![zero; needed]),
    }
}

/// Number of slopes of a dual number, each for a group of columns.
const SLOPES: usize = 4;

/// Number of columns that are worth a search for groups.
pub(crate) const GROUPED_FROM: usize = 2 * SLOPES + 1;

/// The entries of the Jacobian: by deflection or on given pieces.
pub(crate) fn slopes<G: Shape>(
    shape: &G,
    pieces: Option<&[Piece]>,
    u: &[f64],
    q: &[f64],
    v: &[f64],
    way: Way<'_>,
) {
    match pieces {
        None => slopes_by(shape, &ByDeflection, u, q, v, way),
        Some(pieces) => slopes_by(shape, &FixedPieces(pieces), u, q, v, way),
    }
}

fn slopes_by<G: Shape, L: PieceChoice<Dual<SLOPES>>>(
    shape: &G,
    law: &L,
    u: &[f64],
    q: &[f64],
    v: &[f64],
    mut way: Way<'_>,
) {
    let (n, waves) = (shape.size().dof, shape.size().waves);
    with_numbers(u.len() + 3 * n, |numbers| {
        for (number, &x) in numbers.iter_mut().zip(u.iter().chain(q).chain(v)) {
            *number = x.into();
        }
        let (u, rest) = numbers.split_at_mut(u.len());
        let (y, a) = rest.split_at_mut(2 * n);
        let mut accel = |y: &[Dual<SLOPES>], a: &mut [Dual<SLOPES>]| {
            shape.accel(law, Drives::new(waves, u), &y[..n], &y[n..], a);
        };
        match &mut way {
            Way::Grouped(columns, entry) => in_groups(columns, &mut accel, y, a, entry),
            Way::Alone(out) => one_by_one(&mut accel, y, a, out),
        }
    });
}

/// Writes the accelerations of coordinates and velocities.
type Accel<'a> = &'a mut dyn FnMut(&[Dual<SLOPES>], &mut [Dual<SLOPES>]);

/// The columns one by one, four at a time.
fn one_by_one(accel: Accel<'_>, y: &mut [Dual<SLOPES>], a: &mut [Dual<SLOPES>], out: &mut Jacobian) {
    let n = a.len();
    for first in (0..2 * n).step_by(SLOPES) {
        let columns = first..(first + SLOPES).min(2 * n);
        columns.clone().for_each(|j| y[j] = Dual::along(y[j].value, j - first));
        accel(y, a);
        for j in columns {
            y[j] = y[j].value.into();
            let (half, column) = if j < n { (&mut out.q, j) } else { (&mut out.v, j - n) };
            for (i, a) in a.iter().enumerate() {
                half[(i, column)] = a.slope[j - first];
            }
        }
    }
}

/// The columns in groups, four groups at a time.
fn in_groups(
    columns: &Columns,
    accel: Accel<'_>,
    y: &mut [Dual<SLOPES>],
    a: &mut [Dual<SLOPES>],
    entry: &mut dyn FnMut(usize, usize, f64),
) {
    for groups in columns.groups.chunks(SLOPES) {
        let columns = || groups.iter().enumerate().flat_map(|(k, group)| group.iter().map(move |c| (k, c)));
        columns().for_each(|(k, c)| y[c.index] = Dual::along(y[c.index].value, k));
        accel(y, a);
        for (k, c) in columns() {
            y[c.index] = y[c.index].value.into();
            c.rows.iter().for_each(|&i| entry(i as usize, c.index, a[i as usize].slope[k]));
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::contact::Piece;
    use crate::error::ParameterError;
    use crate::excitation::Side;
    use crate::model::Model;
    use crate::model::jacobian::Jacobian;
    use crate::model::shapes::dual_jacobian::dual_jacobian;
    use crate::models::ring::{Frame, Ring, RingSet};
    use crate::numeric::spread::golden;
    use crate::tape::columns::Columns;

    /// A gear of a ring is read by itself, its two neighbours and its shafts: the number of groups does not
    /// grow with the ring. Grouped columns have the bits of columns made one by one.
    #[test]
    fn columns_in_groups() -> Result<(), ParameterError> {
        for (gears, frame, most) in
            [(5, Frame::Inertial, 12), (40, Frame::Inertial, 12), (7, Frame::Rigid, 20)]
        {
            let ring = Ring::as_printed(&RingSet::set_a(gears, 900.0).params()?)?.with_frame(frame);
            let (n, columns) = (ring.dof(), Columns::of(&ring.record_shape().0).expect("all is recorded"));
            assert!(columns.groups.len() <= most, "{gears} gears: {} groups", columns.groups.len());
            let mut u = vec![0.0; ring.drives()];
            ring.drive(0.3 * 0.01, Side::After, &mut u);
            let state = |k: usize| (0..n).map(|i| 1e-4 * (golden((k + i) as f64) - 0.5)).collect::<Vec<_>>();
            let (q, v, upper) = (state(0), state(n), vec![Piece::Upper; ring.contacts()]);
            for pieces in [None, Some(&upper[..])] {
                let (mut grouped, mut alone) = (Jacobian::new(n), Jacobian::new(n));
                grouped.q.fill(7.0);
                dual_jacobian(ring.shape(), Some(&columns), pieces, &u, &q, &v, &mut grouped);
                dual_jacobian(ring.shape(), None, pieces, &u, &q, &v, &mut alone);
                let filled = alone.q.iter().filter(|x| **x != 0.0).count();
                assert!(pieces.is_none() || filled >= 3 * (n - 2), "{filled} of {n}");
                assert_eq!(grouped, alone);
            }
        }
        Ok(())
    }
}
