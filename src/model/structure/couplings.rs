//! Couplings of a model: the dependence of its accelerations on its coordinates and velocities.

use crate::contact::Piece;
use crate::excitation::Side;
use crate::model::equations::Periodic;
use crate::model::jacobian::Jacobian;
use crate::model::structure::slopes::Slopes;
use crate::numeric::spread::weyl;

/// Dependence of one acceleration on one coordinate or velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Slope {
    Constant(f64),
    /// Index of the periodic slope in [`Couplings::varying`].
    Periodic(usize),
}

/// ∂a_i/∂q_j and ∂a_i/∂v_j, for i = j and for slopes that are not always zero.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coupling {
    pub(crate) i: usize,
    pub(crate) j: usize,
    pub(crate) q: Slope,
    pub(crate) v: Slope,
}

/// Couplings of a model, found from Jacobians at several instants and states.
#[derive(Clone, Debug)]
pub(crate) struct Couplings {
    /// Sorted by column j, then by row i.
    pub(crate) list: Vec<Coupling>,
    /// Every periodic slope as (i, j, whether it is ∂a_i/∂v_j).
    pub(crate) varying: Vec<(usize, usize, bool)>,
    /// Largest |∂a_i/∂q_i| found.
    pub(crate) stiffest: f64,
}

impl Couplings {
    /// Calls `add` with every ∂a_i/∂v_j and the speed of coordinate j, without those at rest.
    pub(crate) fn each_by_speed(&self, i: usize, speeds: &[f64], mut add: impl FnMut(Slope, f64)) {
        let of_row = self.list.iter().filter(|c| c.i == i && speeds[c.j] != 0.0);
        of_row.for_each(|c| add(c.v, speeds[c.j]));
    }
}

/// Number of instants at which the Jacobian is evaluated.
const INSTANTS: usize = 16;

/// Dependence of an entry of the Jacobian on the samples so far.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Zero,
    Constant,
    Varying,
}

/// A sample of drives, coordinates and velocities.
struct Sample {
    u: Vec<f64>,
    /// Coordinates, then velocities.
    state: Vec<f64>,
}

impl Sample {
    fn of(model: &dyn Periodic) -> Self {
        Sample { u: vec![0.0; model.drives()], state: vec![0.0; 2 * model.dof()] }
    }
    /// Moves on to sample `instant`: the drives at that instant, a state of `size` times the scale.
    fn take(&mut self, model: &dyn Periodic, scale: &[f64], size: f64, instant: usize) {
        let n = model.dof();
        model.drive(model.period() * weyl(instant, 0), Side::After, &mut self.u);
        for (i, (x, scale)) in self.state.iter_mut().zip(scale).enumerate() {
            *x = size * scale * (2.0 * weyl(instant, 1 + 2 * (i % n) + i / n) - 1.0);
        }
    }
}

impl Couplings {
    /// Finds the couplings from Jacobians at `INSTANTS` instants, in states of three sizes.
    /// `has_fixed_pieces`: the Jacobians are evaluated with all contacts in the gap, on the lower and on
    /// the upper flank; otherwise by deflection.
    pub(crate) fn find(model: &dyn Periodic, slopes: &mut Slopes<'_>, has_fixed_pieces: bool) -> Self {
        let n = model.dof();
        let mut first: Option<Jacobian> = None;
        // If the pieces cannot be fixed, the samples may miss couplings: all slopes then count as varying, if
        // the Jacobian comes from differences or the model is small.
        let hidden = !has_fixed_pieces && (slopes.differenced || n <= 4);
        let least = if hidden { Kind::Varying } else { Kind::Zero };
        let mut kind = [vec![least; n * n], vec![least; n * n]];
        let mut sample = Sample::of(model);
        let mut stiffest = 0.0f64;
        let fixed: Vec<Vec<Piece>> =
            [Piece::Gap, Piece::Lower, Piece::Upper].map(|p| vec![p; model.contacts()]).to_vec();
        let ways: Vec<Option<&[Piece]>> =
            if has_fixed_pieces { fixed.iter().map(|p| Some(&p[..])).collect() } else { vec![None] };
        for instant in 0..INSTANTS {
            sample.take(model, &slopes.scale, [0.1, 1.0, 3.0][instant % 3], instant);
            let (q, v) = sample.state.split_at(n);
            for &pieces in &ways {
                slopes.at(pieces, &sample.u, q, v);
                let reference = first.get_or_insert_with(|| slopes.jacobian.clone());
                for (kind, (now, then)) in kind
                    .iter_mut()
                    .zip([(&slopes.jacobian.q, &reference.q), (&slopes.jacobian.v, &reference.v)])
                {
                    for ((kind, now), then) in kind.iter_mut().zip(now).zip(then) {
                        let same = (now - then).abs() <= 1e-13 * then.abs();
                        *kind = (*kind).max(match (same, *now == 0.0) {
                            (false, _) => Kind::Varying,
                            (true, false) => Kind::Constant,
                            (true, true) => Kind::Zero,
                        });
                    }
                }
                stiffest = (0..n).fold(stiffest, |m, i| m.max(slopes.jacobian.q[(i, i)].abs()));
            }
        }
        let mut varying = Vec::new();
        let mut slope = |kind: Kind, i: usize, j: usize, velocity: bool| match (kind, &first) {
            (Kind::Varying, _) => {
                varying.push((i, j, velocity));
                Slope::Periodic(varying.len() - 1)
            }
            (_, Some(first)) => Slope::Constant(if velocity { first.v[(i, j)] } else { first.q[(i, j)] }),
            _ => Slope::Constant(0.0),
        };
        let mut list = Vec::new();
        for j in 0..n {
            for i in 0..n {
                let (of_q, of_v) = (kind[0][j * n + i], kind[1][j * n + i]);
                if of_q > Kind::Zero || of_v > Kind::Zero || i == j {
                    list.push(Coupling { i, j, q: slope(of_q, i, j, false), v: slope(of_v, i, j, true) });
                }
            }
        }
        Couplings { list, varying, stiffest }
    }
}

impl Couplings {
    /// Reads the constant slopes of another model anew.
    ///
    /// `false` if they are not constant, to `tolerance`, at the instants, states and pieces that are looked
    /// at: the model has other couplings.
    pub(crate) fn reread(
        &mut self,
        model: &dyn Periodic,
        slopes: &mut Slopes<'_>,
        has_fixed_pieces: bool,
        tolerance: f64,
    ) -> bool {
        let n = model.dof();
        let varies = |c: &Coupling| matches!((c.q, c.v), (Slope::Periodic(_), Slope::Periodic(_)));
        if self.list.len() == n * n && self.list.iter().all(varies) {
            return true;
        }
        let mut sample = Sample::of(model);
        let mut pieces = vec![Piece::Gap; model.contacts()];
        for (instant, piece) in [Piece::Gap, Piece::Lower, Piece::Upper].into_iter().enumerate() {
            sample.take(model, &slopes.scale, 1.0, instant);
            let (q, v) = sample.state.split_at(n);
            pieces.fill(piece);
            slopes.at(has_fixed_pieces.then_some(&pieces[..]), &sample.u, q, v);
            let jacobian = &slopes.jacobian;
            let mut listed = self.list.iter().map(|c| c.j * n + c.i).peekable();
            for place in 0..n * n {
                let coupled = jacobian.q.as_slice()[place] != 0.0 || jacobian.v.as_slice()[place] != 0.0;
                if listed.next_if_eq(&place).is_none() && coupled {
                    return false;
                }
            }
            for c in &mut self.list {
                let here = [jacobian.q[(c.i, c.j)], jacobian.v[(c.i, c.j)]];
                for (slope, now) in [&mut c.q, &mut c.v].into_iter().zip(here) {
                    match slope {
                        Slope::Constant(a) if instant == 0 => *a = now,
                        Slope::Constant(a) if (now - *a).abs() > tolerance * a.abs() => return false,
                        _ => {}
                    }
                }
            }
        }
        true
    }

    /// The same couplings with all slopes zero.
    pub(crate) fn without_slopes(&self) -> Self {
        let none = Slope::Constant(0.0);
        let list = self.list.iter().map(|c| Coupling { q: none, v: none, ..*c }).collect();
        Couplings { list, varying: Vec::new(), stiffest: self.stiffest }
    }
}

/// Whether the accelerations on fixed pieces are linear in coordinates and velocities, and the contributions
/// of the contacts add up.
///
/// Both are tested to 1e-9 at `looks` instants, with pieces, coordinates and velocities that vary.
pub(crate) fn is_linear_on_pieces(model: &dyn Periodic, slopes: &mut Slopes<'_>, looks: usize) -> bool {
    let (n, contacts) = (model.dof(), model.contacts());
    let rest = vec![0.0; n];
    let mut u = vec![0.0; model.drives()];
    let mut a = [vec![0.0; n], vec![0.0; n], vec![0.0; n]];
    if !model.offers().pieces {
        return false;
    }
    for instant in 0..looks {
        let random = |direction: usize| weyl(instant, direction);
        model.drive(model.period() * random(0), Side::After, &mut u);
        let pieces: Vec<Piece> = (0..contacts)
            .map(|c| [Piece::Lower, Piece::Gap, Piece::Upper][(random(c + 1) * 2.999) as usize])
            .collect();
        let state = |half: usize| -> Vec<f64> {
            slopes.scale[half * n..][..n]
                .iter()
                .enumerate()
                .map(|(j, size)| size * (4.0 * random(2 * j + half + contacts) - 2.0))
                .collect()
        };
        let (q, v) = (state(0), state(1));
        model.accel_on_pieces(&pieces, &u, &q, &v, &mut a[0]);
        model.accel_on_pieces(&pieces, &u, &rest, &rest, &mut a[1]);
        slopes.at(Some(&pieces), &u, &rest, &rest);
        let (by_q, by_v) = (&slopes.jacobian.q, &slopes.jacobian.v);
        let at_rest = a[1].clone();
        let size = |i: usize| {
            (0..n).map(|j| (by_q[(i, j)] * q[j]).abs() + (by_v[(i, j)] * v[j]).abs()).sum::<f64>()
                + at_rest[i].abs()
        };
        let linear =
            |i: usize| at_rest[i] + (0..n).map(|j| by_q[(i, j)] * q[j] + by_v[(i, j)] * v[j]).sum::<f64>();
        let parts = |apart: f64, size: f64| apart.is_nan() || apart.abs() > 1e-9 * size;
        if (0..n).any(|i| parts(linear(i) - a[0][i], size(i))) {
            return false;
        }
        // The sum of the contributions of single contacts must give the same accelerations.
        let mut fixed = vec![Piece::Gap; contacts];
        model.accel_on_pieces(&fixed, &u, &q, &v, &mut a[1]);
        let (gap, mut sum) = (a[1].clone(), a[1].clone());
        for c in 0..contacts {
            fixed[c] = pieces[c];
            model.accel_on_pieces(&fixed, &u, &q, &v, &mut a[2]);
            fixed[c] = Piece::Gap;
            sum.iter_mut().zip(a[2].iter().zip(&gap)).for_each(|(sum, (on, gap))| *sum += on - gap);
        }
        if (0..n).any(|i| parts(sum[i] - a[0][i], size(i))) {
            return false;
        }
    }
    true
}
