//! The classical Runge-Kutta method over a drive table, for all lanes at once.

use crate::contact::Contact;
use crate::sweep::lanes::algebra::Algebra;
use crate::sweep::lanes::drive_table::{DriveTable, WHOLE};
use crate::sweep::lanes::instructions::InstructionSet;
use crate::sweep::lanes::meter::Meters;
use crate::sweep::lanes::number::Number;
use crate::sweep::lanes::stages::{Acceleration, Stages};
use std::ops::Range;

/// The data of all lanes: states, steps, drives and meters.
#[derive(Clone, Debug)]
pub(crate) struct Bundle<S: Number> {
    pub(crate) q: Vec<S>,
    pub(crate) v: Vec<S>,
    /// Step h of each lane, in the time unit of its model.
    pub(crate) step: S,
    /// All drives. Each step overwrites those that are [`varying`](DriveTable::varying) columns of the table.
    pub(crate) u: Vec<S>,
    /// Whether the steps are measured.
    pub(crate) metered: bool,
    pub(crate) meters: Meters<S>,
    scratch: Vec<S>,
    contacts: Vec<Contact<S>>,
}

impl<S: Number> Bundle<S> {
    /// States and steps of zero; the drives at the start of the period.
    pub(crate) fn new(sizes: Sizes, table: &DriveTable, meters: Meters<S>) -> Self {
        let zero = S::from(0.0);
        let (n, drives) = (sizes.dof, sizes.drives);
        let mut u = vec![zero; drives];
        for (u, &x) in u.iter_mut().zip(table.start()) {
            *u = x.into();
        }
        let room = if sizes.is_small() { 0 } else { STATES * spread::<S>(n) + spread::<S>(drives) };
        Bundle {
            q: vec![zero; n],
            v: vec![zero; n],
            step: zero,
            u,
            metered: false,
            meters,
            scratch: vec![zero; room],
            contacts: vec![Contact::default(); sizes.contacts],
        }
    }
}

/// A range of steps of one period, made in all lanes: [`Stages::step`] with the drives of the table at t,
/// t + h/2 and t + h.
pub(crate) struct Kernel<'a, A, S: Number> {
    pub(crate) algebra: &'a A,
    pub(crate) table: &'a DriveTable,
    /// The steps of the period, counted from 0.
    pub(crate) steps: Range<usize>,
    pub(crate) bundle: &'a mut Bundle<S>,
}

/// Maximum number of drives of a model whose stages stay in registers.
const DRIVES: usize = WHOLE;

/// Maximum number of contacts of a model whose stages stay in registers.
const CONTACTS: usize = 2;

/// Number of vectors of [`Stages`], with one element for each degree of freedom.
const STATES: usize = 7;

/// Numbers of coordinates, drives and contacts of a model.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sizes {
    dof: usize,
    drives: usize,
    contacts: usize,
}

impl Sizes {
    #[inline(always)]
    pub(crate) fn of<S, A: Algebra<S>>(algebra: &A) -> Self {
        Sizes { dof: algebra.dof(), drives: algebra.drives(), contacts: algebra.contacts() }
    }
    /// Whether the stages of a step stay in registers.
    #[inline(always)]
    fn is_small(self) -> bool {
        (1..=2).contains(&self.dof) && self.drives <= DRIVES && self.contacts <= CONTACTS
    }
}

/// Distance from the start of a working vector of `len` numbers to the start of the next one, in numbers. It
/// is 576 bytes more than a whole number of pages of 4 KiB.
///
/// This avoids 4K aliasing: a processor treats a load as dependent on a recent store if their addresses
/// differ by a multiple of 4 KiB. In vectors that are accessed at the same index this would happen in every
/// step.
fn spread<S>(len: usize) -> usize {
    const PAGE: usize = 4096;
    const APART: usize = 576;
    let bytes = (len * size_of::<S>()).saturating_sub(APART).next_multiple_of(PAGE) + APART;
    bytes.div_ceil(size_of::<S>())
}

/// Takes a working vector of `n` numbers from the start of `rest`.
#[inline(always)]
fn cut<'a, S>(rest: &mut &'a mut [S], n: usize) -> &'a mut [S] {
    let (vector, others) = std::mem::take(rest).split_at_mut(spread::<S>(n));
    *rest = others;
    &mut vector[..n]
}

/// The working vectors of a step, the drives of a stage, the contacts.
struct LaneWork<'w, S> {
    stages: Stages<'w, S>,
    u: &'w mut [S],
    contacts: &'w mut [Contact<S>],
}

impl<A: Algebra<S>, S: Number> Kernel<'_, A, S> {
    /// Makes the steps with an instruction set. It is not inlined: each instruction set is compiled once.
    #[inline(never)]
    pub(crate) fn run(self, set: InstructionSet) {
        S::run(set, self);
    }

    #[inline(always)]
    fn dispatch(mut self) {
        match (self.algebra.dof(), Sizes::of(self.algebra).is_small()) {
            (1, true) => self.small::<1>(),
            (2, true) => self.small::<2>(),
            _ => self.large(),
        }
    }

    /// Makes the steps on arrays of known length. The stages stay in registers. `black_box` forces q and v
    /// through memory once per step: the compiler forms vector instructions well from values in memory, and
    /// badly from values that a loop keeps in registers.
    #[inline(always)]
    fn small<const N: usize>(&mut self) {
        let zero = S::from(0.0);
        let mut states = [[zero; N]; 2];
        std::hint::black_box(&mut states);
        let [q, v] = &mut states;
        let [mut qs, mut vs, mut a, mut first, mut inner] = [[zero; N]; 5];
        let (qs, vs, a, first, inner) = (&mut qs, &mut vs, &mut a, &mut first, &mut inner);
        let mut u = [zero; DRIVES];
        let mut contacts = [Contact::default(); CONTACTS];
        let (drives, touching) = (self.algebra.drives(), self.algebra.contacts());
        q.copy_from_slice(&self.bundle.q);
        v.copy_from_slice(&self.bundle.v);
        u[..drives].copy_from_slice(&self.bundle.u);
        let mut work = LaneWork {
            stages: Stages { q, v, qs, vs, a, first, inner },
            u: &mut u[..drives],
            contacts: &mut contacts[..touching],
        };
        self.advance::<true>(N, &mut work);
        self.bundle.q.copy_from_slice(work.stages.q);
        self.bundle.v.copy_from_slice(work.stages.v);
    }

    /// Makes the steps on vectors in memory.
    #[inline(always)]
    fn large(&mut self) {
        let (n, drives) = (self.algebra.dof(), self.algebra.drives());
        let mut scratch = std::mem::take(&mut self.bundle.scratch);
        let mut contacts = std::mem::take(&mut self.bundle.contacts);
        let mut rest = &mut scratch[..];
        let mut work = LaneWork {
            stages: Stages {
                q: cut(&mut rest, n),
                v: cut(&mut rest, n),
                qs: cut(&mut rest, n),
                vs: cut(&mut rest, n),
                a: cut(&mut rest, n),
                first: cut(&mut rest, n),
                inner: cut(&mut rest, n),
            },
            u: cut(&mut rest, drives),
            contacts: &mut contacts,
        };
        work.stages.q.copy_from_slice(&self.bundle.q);
        work.stages.v.copy_from_slice(&self.bundle.v);
        work.u.copy_from_slice(&self.bundle.u);
        self.advance::<false>(n, &mut work);
        self.bundle.q.copy_from_slice(work.stages.q);
        self.bundle.v.copy_from_slice(work.stages.v);
        self.bundle.scratch = scratch;
        self.bundle.contacts = contacts;
    }

    // Not inlined without optimisation: it is then compiled once, instead of once for each instruction set.
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance<const SMALL: bool>(&mut self, n: usize, w: &mut LaneWork<'_, S>) {
        let s = &mut w.stages.cut(n);
        let (u, touching) = (&mut *w.u, &mut *w.contacts);
        let (algebra, table, h, columns) =
            (self.algebra, self.table, self.bundle.step, self.algebra.columns());
        let (metered, contacts) = (self.bundle.metered, self.bundle.meters.contacts());
        // Whether the drives at the start of the step are not in `u` yet.
        let mut fresh = true;
        for step in self.steps.clone() {
            if fresh || SMALL {
                fill::<S, SMALL>(table, 2 * step, columns, u);
            }
            if metered {
                if fresh && table.jumps_before(step) {
                    self.bundle.meters.halve_next();
                }
                if !contacts.is_empty() {
                    algebra.contact(contacts.clone(), u, s.q, s.v, touching);
                }
                self.bundle.meters.sample(s.q, s.v, touching);
            }
            let (end, shared) = table.end(step);
            let rows = [2 * step + 1, end];
            s.step::<SMALL>(n, h, &mut OfTable::<_, _, SMALL> { algebra, table, rows, u });
            if SMALL {
                std::hint::black_box(());
            }
            fresh = !shared;
            if metered && fresh {
                let Bundle { q, v, u: before, contacts, meters, .. } = &mut *self.bundle;
                q.copy_from_slice(s.q);
                v.copy_from_slice(s.v);
                before.copy_from_slice(u);
                sample_before_jump(algebra, meters, [q, v, before], if SMALL { contacts } else { touching });
            }
        }
        if metered {
            self.bundle.meters.finish();
        }
    }
}

/// The acceleration in a step with the drives of the rows at its middle and its end.
struct OfTable<'a, A, S, const SMALL: bool> {
    algebra: &'a A,
    table: &'a DriveTable,
    rows: [usize; 2],
    u: &'a mut [S],
}

impl<A: Algebra<S>, S: Number, const SMALL: bool> Acceleration<S> for OfTable<'_, A, S, SMALL> {
    #[inline(always)]
    fn accel(&mut self, stage: usize, q: &[S], v: &[S], a: &mut [S]) {
        let [middle, end] = self.rows;
        match stage {
            0 => {}
            3 => fill::<S, SMALL>(self.table, end, self.algebra.columns(), self.u),
            _ if stage == 1 || SMALL => fill::<S, SMALL>(self.table, middle, self.algebra.columns(), self.u),
            _ => {}
        }
        self.algebra.accel(self.u, q, v, a);
    }
}

/// Samples the end of a step, with the drives `u` before a jump there. A second copy of the sampling in the
/// loop over the steps would slow down all steps.
#[cold]
#[inline(never)]
fn sample_before_jump<A: Algebra<S>, S: Number>(
    algebra: &A,
    meters: &mut Meters<S>,
    [q, v, u]: [&[S]; 3],
    contacts: &mut [Contact<S>],
) {
    meters.halve_next();
    if !meters.contacts().is_empty() {
        algebra.contact(meters.contacts(), u, q, v, contacts);
    }
    meters.sample(q, v, contacts);
}

/// Writes the drives of row `row` to all lanes.
#[inline(always)]
fn fill<S: Number, const SMALL: bool>(table: &DriveTable, row: usize, columns: usize, u: &mut [S]) {
    let row = table.row(row);
    if SMALL {
        // A table of at most `WHOLE` columns contains all columns. The compiler knows their number here and
        // keeps the drives in registers.
        let (row, u) = (&row[..columns], &mut u[..columns]);
        for i in 0..columns {
            u[i] = S::from(row[i]);
        }
    } else {
        for (&i, &x) in table.varying().iter().zip(row) {
            u[i] = S::from(x);
        }
    }
}

impl<A: Algebra<S>, S: Number> pulp::WithSimd for Kernel<'_, A, S> {
    type Output = ();
    #[inline(always)]
    fn with_simd<I: pulp::Simd>(self, _: I) {
        self.dispatch();
    }
}
