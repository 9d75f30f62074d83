//! Which acceleration reads which coordinate, and columns of a Jacobian that one derivative holds together.

use crate::tape::form::Form;
use crate::tape::operations::{Op, Tape};

/// Columns of a Jacobian in groups. No acceleration reads two columns of one group: the derivative along the
/// sum of their directions has the entries of each column.   Source: Curtis, Powell and Reid, IMA Journal of
/// Applied Mathematics 13 (1974).
#[derive(Debug)]
pub(crate) struct Columns {
    pub(crate) groups: Vec<Vec<Column>>,
}

/// A column of ∂a/∂(q, v).
#[derive(Debug)]
pub(crate) struct Column {
    /// Index of a coordinate. The index of a velocity is that of its coordinate plus the number of degrees of
    /// freedom.
    pub(crate) index: usize,
    /// The accelerations that read it.
    pub(crate) rows: Vec<u32>,
}

impl Columns {
    /// The columns in few groups, each in the first one whose accelerations it does not share. `None`: an
    /// operation was not recorded.
    pub(crate) fn of(tape: &Tape) -> Option<Self> {
        let mut groups: Vec<(Vec<Column>, Vec<bool>)> = Vec::new();
        for (index, rows) in tape.readers()?.into_iter().enumerate() {
            if rows.is_empty() {
                continue;
            }
            let is_free = |taken: &[bool]| rows.iter().all(|&row| !taken[row as usize]);
            let place = groups.iter().position(|(_, taken)| is_free(taken)).unwrap_or(groups.len());
            if place == groups.len() {
                groups.push((Vec::new(), vec![false; tape.dof]));
            }
            let (columns, taken) = &mut groups[place];
            rows.iter().for_each(|&row| taken[row as usize] = true);
            columns.push(Column { index, rows });
        }
        Some(Columns { groups: groups.into_iter().map(|(columns, _)| columns).collect() })
    }
}

impl Tape {
    /// The accelerations that read each coordinate and velocity, on any pieces. `None`: an operation was not
    /// recorded.
    fn readers(&self) -> Option<Vec<Vec<u32>>> {
        let states = 2 * self.dof;
        let mut reads: Vec<Vec<u32>> = (0..self.inputs())
            .map(|slot| if slot < states { vec![slot as u32] } else { Vec::new() })
            .collect();
        let add = |reads: &[Vec<u32>], form: &Form, all: &mut Vec<u32>| {
            form.terms.iter().for_each(|&(slot, _)| all.extend(&reads[slot as usize]));
        };
        for (op, _) in &self.ops {
            let mut all = match op {
                Op::Kink(_) => return None,
                Op::Cos => reads.last().cloned().unwrap_or_default(),
                _ => Vec::new(),
            };
            op.operands().into_iter().for_each(|operand| add(&reads, &self.forms[operand], &mut all));
            all.sort_unstable();
            all.dedup();
            reads.push(all);
        }
        let mut readers = vec![Vec::new(); states];
        for (row, &acceleration) in self.accelerations.iter().enumerate() {
            let mut all = Vec::new();
            add(&reads, &self.forms[acceleration], &mut all);
            for slot in all {
                let rows: &mut Vec<u32> = &mut readers[slot as usize];
                if rows.last() != Some(&(row as u32)) {
                    rows.push(row as u32);
                }
            }
        }
        Some(readers)
    }
}
