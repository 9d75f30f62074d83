//! The order in which a tape is evaluated, and the columns of its numbers.

use crate::contact::Piece;
use crate::contact::edge::Edge;
use crate::contact::piece::alternative;
use crate::ode::taylor::expansion::degrees::high_products;
use crate::ode::taylor::expansion::dependence::{TimeSum, dependants_of_powers, levels, time_sums, uses};
use crate::ode::taylor::expansion::functions::{Function, Grid, Placed};
use crate::ode::taylor::expansion::products::{BATCH, Products};
use crate::ode::taylor::expansion::rows::{Block, EIGHT, Eight, Places, Rows};
use crate::tape::form::Form;
use crate::tape::operations::{FormId, Guard, Op, Tape};
use std::collections::HashMap;
use std::ops::Range;

/// Operations whose operands are known once all levels before are evaluated.
#[derive(Debug, Default)]
pub(crate) struct Level {
    /// Operands that are sums, with the block of the first one.
    pub(crate) rows: Rows,
    first_row: usize,
    row_forms: Vec<FormId>,
    choices: Vec<Choice>,
    products: Vec<Products>,
    pub(crate) functions: Vec<Placed>,
}

/// An edge of a contact and its distance from it, positive in the gap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EdgeColumn {
    pub(crate) contact: usize,
    pub(crate) edge: Edge,
    /// Column of the distance, counted from the block of the first distance.
    pub(crate) column: usize,
    /// 1, or -1 if the column holds the distance with reversed sign.
    pub(crate) sign: f64,
}

impl EdgeColumn {
    /// Whether both are edges of the same gap.
    pub(crate) fn is_opposite(&self, other: &EdgeColumn) -> bool {
        self.contact == other.contact && self.edge != other.edge
    }
}

/// One of several columns, by the pieces of contacts.
#[derive(Debug)]
pub(crate) struct Choice {
    contact: usize,
    count: usize,
    columns: Vec<u32>,
    out: u32,
}

/// A tape with a column for every number, in blocks of eight columns. The order of the columns is:
/// coordinates, velocities, all other numbers, and distances that no other number depends on.
#[derive(Debug)]
pub(crate) struct Plan {
    pub(crate) dof: usize,
    /// Number of blocks of columns.
    pub(crate) width: usize,
    /// Number of blocks of the coordinates, and of the velocities.
    pub(crate) half: usize,
    /// Column of the number 1.
    pub(crate) one: usize,
    /// Drives that are needed, with their columns, which are neighbours.
    pub(crate) drives: Vec<(usize, usize)>,
    /// Number of drives that vary: the first ones.
    pub(crate) moving: usize,
    pub(crate) levels: Vec<Level>,
    pub(crate) accelerations: Rows,
    /// The distances, unless they are operands.
    pub(crate) own_distances: Rows,
    /// First block of the distances.
    pub(crate) distances: usize,
    /// Number of blocks of the distances.
    pub(crate) distance_blocks: usize,
    /// The column that holds the numbers of each column on the present pieces.
    actual: Vec<u32>,
    pub(crate) edges: Vec<EdgeColumn>,
    /// Number of levels that the distances need.
    pub(crate) levels_of_distances: usize,
    /// Columns of the products of high degree.
    pub(crate) high_products: Vec<u32>,
    /// Sums of columns that vary with the time alone.
    pub(crate) time_sums: Vec<TimeSum>,
}

/// Number of blocks of the columns of a small plan. Plans have at least this number.
pub(crate) const SMALL: usize = 8;

/// The plan of a model with few meshes and few coordinates. It has one block of operands, one batch of
/// products and one block of accelerations. Fixed numbers of blocks save most of the time of its orders.
pub(crate) struct Small<'p> {
    pub(crate) operands: &'p Block,
    pub(crate) products: &'p mut Products,
    pub(crate) accelerations: &'p Block,
}

/// Columns that are handed out one after the other.
struct Columns {
    next: usize,
    of_slot: Vec<u32>,
    of_form: HashMap<FormId, u32>,
    still: Range<u32>,
    one: u32,
    zero: u32,
}

/// No column yet.
const NO_COLUMN: u32 = u32::MAX;

impl Columns {
    fn places(&self) -> Places<'_> {
        let Columns { of_slot, one, still, .. } = self;
        Places { of_slot, one: *one, still }
    }
    /// Takes whole blocks for `count` numbers and returns their first column.
    fn take_blocks(&mut self, count: usize) -> usize {
        self.next = self.next.next_multiple_of(EIGHT);
        self.take(count.next_multiple_of(EIGHT))
    }
    fn take(&mut self, count: usize) -> usize {
        self.next += count;
        self.next - count
    }
}

impl Plan {
    /// `still`: whether a drive is constant between two drive edges, so that its orders above 0 are 0.
    pub(crate) fn new(tape: &Tape, still: impl Fn(usize) -> bool) -> Self {
        let (inputs, n) = (tape.inputs(), tape.dof);
        let needed = tape.needed();
        let mut columns = Columns {
            next: 0,
            of_slot: vec![NO_COLUMN; inputs + tape.ops.len()],
            of_form: HashMap::new(),
            still: 0..0,
            one: 0,
            zero: 0,
        };
        for slots in [0..n, n..2 * n] {
            let first = columns.take_blocks(n);
            slots.enumerate().for_each(|(i, slot)| columns.of_slot[slot] = (first + i) as u32);
        }
        // Drives that are used alike stand side by side, the constant ones last.
        let mut order: Vec<usize> = (0..tape.drives).filter(|d| needed[2 * n + d]).collect();
        let uses = uses(tape);
        order.sort_by_key(|&d| (still(d), uses[2 * n + d]));
        let mut drives = Vec::new();
        let moving = order.iter().filter(|&&d| !still(d)).count();
        let first_still = columns.next + moving;
        for d in order {
            let column = columns.take(1);
            columns.of_slot[2 * n + d] = column as u32;
            drives.push((d, column));
        }
        (columns.one, columns.zero) = (columns.take(1) as u32, columns.take(1) as u32);
        columns.still = first_still as u32..columns.next as u32;
        let level_of = levels(tape, &needed);
        let of_power = dependants_of_powers(tape);
        let count = level_of.iter().copied().max().unwrap_or(0);
        let mut made = Vec::with_capacity(count);
        for level in 1..=count {
            let ops: Vec<usize> = (0..tape.ops.len())
                .filter(|&i| needed[inputs + i] && level_of[inputs + i] == level)
                .collect();
            made.push(Level::new(tape, &ops, &of_power, &mut columns));
        }
        let accelerations: Vec<Option<&Form>> =
            tape.accelerations.iter().map(|&a| Some(&tape.forms[a])).collect();
        let half = n.div_ceil(EIGHT);
        let forms: Vec<(usize, Edge, &Form)> = tape
            .distances
            .iter()
            .enumerate()
            .flat_map(|(contact, both)| {
                let both = Edge::BOTH.into_iter().zip(both);
                both.filter_map(move |(edge, form)| Some((contact, edge, &tape.forms[(*form)?])))
            })
            .collect();
        // If all distances are operands of the first level, they are computed there.
        let operands: Option<Vec<EdgeColumn>> =
            forms.iter().map(|form| made.first()?.edge(tape, *form)).collect();
        let own = operands.is_none() || forms.is_empty();
        let level = |slot: u32| level_of[slot as usize];
        let deepest = forms.iter().flat_map(|(.., form)| &form.terms).map(|&(slot, _)| level(slot)).max();
        let edges = operands.unwrap_or_else(|| {
            let edge = |(column, &(contact, edge, _))| EdgeColumn { contact, edge, column, sign: 1.0 };
            forms.iter().enumerate().map(edge).collect()
        });
        let own_forms: Vec<Option<&Form>> = forms.iter().filter(|_| own).map(|(.., f)| Some(*f)).collect();
        let first = columns.take_blocks(own_forms.len()) / EIGHT;
        let sums = time_sums(tape, still).into_iter();
        Plan {
            dof: n,
            width: (columns.next / EIGHT).max(SMALL),
            half,
            actual: (0..columns.next as u32).collect(),
            one: columns.one as usize,
            drives,
            moving,
            accelerations: Rows::new(&accelerations, &columns.places(), 0),
            own_distances: Rows::new(&own_forms, &columns.places(), first),
            distances: if own { first } else { made[0].first_row },
            distance_blocks: edges.iter().map(|edge| edge.column / EIGHT + 1).max().unwrap_or(0),
            levels_of_distances: if own { deepest.unwrap_or(0) } else { 1 },
            time_sums: sums.map(|sum| sum.of_columns(|slot| columns.of_slot[slot as usize])).collect(),
            high_products: high_products(tape).into_iter().map(|slot| columns.of_slot[slot]).collect(),
            levels: made,
            edges,
        }
    }

    /// The plan as a small one; `None` if it is larger.
    #[inline(always)]
    pub(crate) fn small(&mut self) -> Option<Small<'_>> {
        let ([level], SMALL) = (&mut self.levels[..], self.width) else { return None };
        if !self.own_distances.blocks().is_empty() || !level.functions.is_empty() {
            return None;
        }
        match (level.rows.blocks(), &mut level.products[..], self.accelerations.blocks()) {
            ([operands], [products], [accelerations]) => Some(Small { operands, products, accelerations }),
            _ => None,
        }
    }

    /// Sets the pieces on which all choices and functions are evaluated.
    pub(crate) fn set_pieces(&mut self, pieces: &[Piece]) {
        // A choice is not copied: what reads it reads the chosen column.
        for level in &mut self.levels {
            for choice in &level.choices {
                let chosen = choice.columns[alternative(pieces, choice.contact, choice.count)];
                self.actual[choice.out as usize] = self.actual[chosen as usize];
            }
            level.rows.redirect(&self.actual);
            level.products.iter_mut().for_each(|products| products.redirect(&self.actual));
            for function in &mut level.functions {
                function.function = function.source.redirected(&self.actual);
                let stands =
                    |guard: Guard| alternative(pieces, guard.contact, guard.count) == guard.alternative;
                function.active = function.guard.is_none_or(stands);
            }
        }
        self.accelerations.redirect(&self.actual);
        self.own_distances.redirect(&self.actual);
    }

    /// The active functions.
    pub(crate) fn functions(&self) -> impl Iterator<Item = &Placed> {
        self.levels.iter().flat_map(|level| &level.functions).filter(|function| function.active)
    }
}

impl Level {
    /// Evaluates order n of all operations. `FIRST`: whether n is 0. `x`: the numbers of all orders, `width`
    /// blocks for each.
    #[inline(always)]
    pub(crate) fn order<const FIRST: bool>(&mut self, n: usize, x: &mut [Eight], width: usize, frozen: bool) {
        let row = &mut x[n * width..][..width];
        self.rows.apply::<FIRST>(row);
        for products in &mut self.products {
            products.order::<FIRST>(n, row.as_flattened_mut());
            if frozen && !FIRST {
                products.freeze(row.as_flattened_mut());
            }
        }
        for function in &self.functions {
            function.order(n, &mut Grid { x: x.as_flattened_mut(), width: width * EIGHT }, frozen);
        }
    }

    /// Returns the column of a distance that this level computes as an operand; `None` if it does not.
    fn edge(&self, tape: &Tape, (contact, edge, form): (usize, Edge, &Form)) -> Option<EdgeColumn> {
        let reversed = form.times(-1.0);
        self.row_forms.iter().enumerate().find_map(|(column, &row)| {
            let row = &tape.forms[row];
            let sign = if row == form { 1.0 } else { -1.0 };
            (row == form || *row == reversed).then_some(EdgeColumn { contact, edge, column, sign })
        })
    }

    /// The level of the given operations. Their operands get columns where they have none.
    fn new(tape: &Tape, ops: &[usize], of_power: &[bool], columns: &mut Columns) -> Self {
        let inputs = tape.inputs();
        // Operands that are sums become rows. A kept sum is the row of its form.
        let mut rows: Vec<FormId> = Vec::new();
        for &i in ops {
            for form in tape.ops[i].0.operands() {
                let sum = tape.forms[form].alone().is_none() && !tape.forms[form].is_zero();
                if (sum || matches!(tape.ops[i].0, Op::Sum(_))) && !columns.of_form.contains_key(&form) {
                    columns.of_form.insert(form, NO_COLUMN);
                    rows.push(form);
                }
            }
        }
        let first = columns.take_blocks(rows.len());
        for (r, form) in rows.iter().enumerate() {
            columns.of_form.insert(*form, (first + r) as u32);
        }
        let forms: Vec<Option<&Form>> = rows.iter().map(|&form| Some(&tape.forms[form])).collect();
        let (row_forms, first_row, zero) = (rows, first / EIGHT, columns.zero);
        let rows = Rows::new(&forms, &columns.places(), first_row);

        // A form without a row is one slot, or 0.
        let operand = |form: FormId, columns: &Columns| {
            let slot = || tape.forms[form].alone().map(|slot| columns.of_slot[slot as usize]);
            columns.of_form.get(&form).copied().or_else(slot).unwrap_or(zero)
        };
        let (mut choices, mut functions) = (Vec::new(), Vec::new());
        let (mut pairs, mut results) = (Vec::new(), Vec::new());
        for &i in ops {
            let (op, guard) = &tape.ops[i];
            let function = match op {
                Op::Sum(a) => {
                    columns.of_slot[inputs + i] = operand(*a, columns);
                    continue;
                }
                Op::Product(a, b) => {
                    pairs.push(([operand(*a, columns), operand(*b, columns)], of_power[inputs + i]));
                    results.push(inputs + i);
                    continue;
                }
                Op::Choice { contact, count, forms } => {
                    let alternatives: Vec<u32> = forms.iter().map(|&form| operand(form, columns)).collect();
                    let out = columns.take(1) as u32;
                    columns.of_slot[inputs + i] = out;
                    choices.push(Choice { contact: *contact, count: *count, columns: alternatives, out });
                    continue;
                }
                Op::Cos | Op::Kink(_) => continue,
                Op::Quotient(a, b) => Function::Quotient(operand(*a, columns), operand(*b, columns)),
                Op::Sqrt(a) => Function::Sqrt(operand(*a, columns)),
                Op::Power(a, p, parity) => Function::Power(operand(*a, columns), *p, *parity),
                Op::Exp(a) => Function::Exp(operand(*a, columns)),
                Op::Ln(a) => Function::Ln(operand(*a, columns)),
                Op::SinCos(a) => Function::SinCos(operand(*a, columns)),
            };
            let out = columns.take(if matches!(function, Function::SinCos(_)) { 2 } else { 1 });
            columns.of_slot[inputs + i] = out as u32;
            if let Function::SinCos(_) = function {
                columns.of_slot[inputs + i + 1] = out as u32 + 1;
            }
            let of_power = of_power[inputs + i];
            functions.push(Placed { source: function, function, guard: *guard, active: true, of_power, out });
        }
        let mut products = Vec::new();
        for (pairs, results) in pairs.chunks(BATCH).zip(results.chunks(BATCH)) {
            let out = columns.take(BATCH);
            for (l, &slot) in results.iter().enumerate() {
                columns.of_slot[slot] = (out + l) as u32;
            }
            products.push(Products::new(pairs, out));
        }
        Level { rows, first_row, row_forms, choices, products, functions }
    }
}
