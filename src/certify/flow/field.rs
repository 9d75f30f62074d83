//! The equations of a model on intervals.

use crate::certify::flow::algebra::Algebra;
use crate::certify::rigid::Relative;
use crate::certify::slots::with_inputs;
use crate::certify::square::Square;
use crate::certify::unproved::Unproved;
use crate::contact::Piece;
use crate::contact::edge::Edge;
use crate::interval::number::Interval;
use crate::model::recording::Enclosed;
use crate::periodic::flow::tangent_tape::tangent;
use crate::series::PowerSeries;
use crate::tape::operations::{FormId, Tape};
use std::cell::{OnceCell, RefCell};
use std::collections::HashMap;
use std::rc::Rc;

/// Series of all drives after a time.
pub(crate) type Drives = Rc<[PowerSeries<Interval>]>;

/// The equations of a model on intervals, with what is recorded of them when it is first asked for.
pub(crate) struct Field<'m> {
    /// Number of degrees of freedom.
    pub(crate) n: usize,
    pub(crate) motion: Algebra,
    /// The motion with its derivatives with respect to the 2n initial values.
    pub(crate) tangent: Algebra,
    pub(crate) drives: Box<dyn Enclosed + 'm>,
    /// The rigid motion that is left out.
    pub(crate) relative: Option<Relative>,
    /// Whether it leaves the contact forces unchanged.
    pub(crate) keeps_forces: bool,
    /// Order of the remainder.
    pub(crate) order: usize,
    /// The derivative of each distance.
    edge_slopes: Vec<[OnceCell<Algebra>; 2]>,
    /// The velocities after an impact on each side.
    impacts: Vec<[OnceCell<Result<ImpactForms, Unproved>>; 2]>,
    /// Series by their time and length: boxes of other widths need them again.
    kept: RefCell<HashMap<[u64; 4], Drives>>,
}

/// The velocities after an impact, with their differences, in place of accelerations.
struct ImpactForms {
    algebra: Algebra,
    /// Drives that are read: they are coordinates here, which follow those of the model.
    read: Vec<usize>,
}

/// Velocities after an impact, and their differences by columns.
pub(crate) struct Rebound {
    pub(crate) velocities: Vec<Interval>,
    differences: Vec<Interval>,
}

impl Rebound {
    /// The difference `column` of velocity `i`.
    pub(crate) fn difference(&self, i: usize, column: usize) -> Interval {
        self.differences[column * self.velocities.len() + i]
    }
}

impl<'m> Field<'m> {
    /// `relative`: without the rigid motion of the model.
    pub(crate) fn new(
        tape: Tape,
        drives: Box<dyn Enclosed + 'm>,
        order: usize,
        relative: bool,
    ) -> Result<Self, Unproved> {
        let of = |tape: &Tape| {
            let relative = Relative::of(tape)?;
            let keeps_forces = relative.keeps_forces(tape);
            Some((relative.tape(tape, false)?, relative, keeps_forces))
        };
        let (tape, relative, keeps_forces) = match relative {
            false => (tape, None, true),
            true => of(&tape)
                .map(|(tape, rigid, keeps)| (tape, Some(rigid), keeps))
                .ok_or(Unproved::RigidMotion)?,
        };
        let (n, contacts) = (tape.dof, tape.distances.len());
        Ok(Field {
            n,
            tangent: Algebra::new(tangent(&tape, 2 * n, &[])),
            motion: Algebra::new(tape),
            drives,
            relative,
            keeps_forces,
            order,
            edge_slopes: (0..contacts).map(|_| Default::default()).collect(),
            impacts: (0..contacts).map(|_| Default::default()).collect(),
            kept: RefCell::default(),
        })
    }

    pub(crate) fn drive_series(&self, time: Interval, inside: f64, coefficients: usize) -> Drives {
        let mut u = vec![PowerSeries::from(0.0); self.motion.tape.drives];
        let of_model = u.len() - self.relative.iter().flat_map(Relative::others).count();
        self.drives.drives(time, inside, coefficients.max(2), &mut u[..of_model]);
        if let Some(relative) = &self.relative {
            let ratios = relative.others().map(|i| PowerSeries::constant(relative.ratios[i]));
            u[of_model..].iter_mut().zip(ratios).for_each(|(u, ratio)| *u = ratio);
        }
        u.into()
    }
    /// [`drive_series`](Field::drive_series), kept for the next call at the same time.
    pub(crate) fn kept_drives(&self, time: Interval, inside: f64, coefficients: usize) -> Drives {
        let key = [time.low().to_bits(), time.high().to_bits(), inside.to_bits(), coefficients as u64];
        let found = self.kept.borrow().get(&key).cloned();
        found.unwrap_or_else(|| {
            let series = self.drive_series(time, inside, coefficients);
            self.kept.borrow_mut().insert(key, series.clone());
            series
        })
    }

    /// The slot of a coordinate or velocity of the tangent tape (`part` 0) or of its derivative with respect
    /// to component `part` - 1 of the start.
    pub(crate) fn place(&self, i: usize, part: usize) -> usize {
        let (n, all) = (self.n, self.tangent.tape.dof);
        if i < n { n * part + i } else { all + n * part + i - n }
    }
    /// The box with its derivatives: coordinates, velocities and the columns of a matrix, as the tape of the
    /// tangent reads them.
    pub(crate) fn with_columns(&self, x: &[Interval], columns: &Square) -> Vec<Interval> {
        let d = 2 * self.n;
        let mut all = vec![Interval::ZERO; d * (1 + d)];
        for (i, x) in x.iter().enumerate() {
            all[self.place(i, 0)] = *x;
            (0..d).for_each(|k| all[self.place(i, 1 + k)] = columns.at(i, k));
        }
        all
    }

    /// The derivatives of a distance along the columns of a matrix.
    pub(crate) fn edge_slope(
        &self,
        (contact, edge): (usize, Edge),
        pieces: &[Piece],
        columns: &[Interval],
        u: &Drives,
    ) -> Option<Vec<Interval>> {
        let (n, own) = (self.n, self.motion.tape.distances[contact][edge as usize]?);
        let algebra = self.edge_slopes[contact][edge as usize].get_or_init(|| {
            // A tape whose accelerations k n are the distance (k = 0) and its differences.
            let tape = Tape { accelerations: vec![own; n], ..self.motion.tape.clone() };
            Algebra::new(tangent(&tape, 2 * n, &[]))
        });
        let c = algebra.expand(pieces.into(), columns, u, 0);
        let form = |k: usize| -> FormId { algebra.tape.accelerations[n * (1 + k)] };
        Some((0..2 * n).map(|k| c.form(form(k), 0)).collect())
    }

    /// The velocities after an impact from the box `x`, with their derivatives along the columns of a matrix,
    /// whose impact is at the later times `delays`.
    pub(crate) fn rebound(
        &self,
        (contact, on): (usize, Piece),
        pieces: &[Piece],
        x: &[Interval],
        (columns, delays): (&Square, &[Interval]),
        u: &Drives,
    ) -> Result<Rebound, Unproved> {
        let cell = &self.impacts[contact][Edge::between(Piece::Gap, on) as usize];
        let ImpactForms { algebra, read } = match cell.get_or_init(|| self.impact(contact, on)) {
            Ok(impact) => impact,
            Err(error) => return Err(error.clone()),
        };
        let (n, own, all) = (self.n, self.n + read.len(), algebra.tape.dof);
        let mut start = vec![Interval::ZERO; 2 * all];
        for part in 0..=columns.size {
            let of = |i: usize| if part == 0 { x[i] } else { columns.at(i, part - 1) };
            for i in 0..n {
                start[part * own + i] = of(i);
                start[all + part * own + i] = of(n + i);
            }
            for (m, &d) in read.iter().enumerate() {
                let series = u[d].coefficients();
                let rate = series.get(1).copied().unwrap_or(Interval::ZERO);
                start[part * own + n + m] = if part == 0 { series[0] } else { rate * delays[part - 1] };
            }
        }
        let c = algebra.expand(pieces.into(), &start, u, 0);
        let of = |part: usize| (0..n).map(move |i| algebra.tape.accelerations[part * own + i]);
        Ok(Rebound {
            velocities: of(0).map(|form| c.form(form, 0)).collect(),
            differences: (1..=columns.size).flat_map(of).map(|form| c.form(form, 0)).collect(),
        })
    }

    fn impact(&self, contact: usize, on: Piece) -> Result<ImpactForms, Unproved> {
        let none =
            |what: &str| Unproved::NoEnclosure { what: format!("the impact of contact {contact}, {what}") };
        let mut tape = self.drives.impact(contact, on).0;
        if tape.kink().is_some() {
            return Err(none("which has no series"));
        }
        if let Some(relative) = &self.relative {
            tape = relative.tape(&tape, true).ok_or(none("which the rigid motion changes"))?;
        }
        let (n, drives, needed) = (tape.dof, tape.drives, tape.needed());
        let read: Vec<usize> = (0..drives).filter(|d| needed[2 * n + d]).collect();
        let all = n + read.len();
        let tape = with_inputs(&tape, [all, drives], |slot| match slot {
            _ if slot < n => Some(slot),
            _ if slot < 2 * n => Some(all + slot - n),
            _ => match read.iter().position(|d| 2 * n + d == slot) {
                Some(m) => Some(n + m),
                None => Some(slot + 2 * read.len()),
            },
        });
        Ok(ImpactForms { algebra: Algebra::new(tangent(&tape, 2 * self.n, &[])), read })
    }
}
