//! The classical Runge-Kutta method over a drive table, for all lanes at once.

use crate::contact::Contact;
use crate::scalar::keep_rolled;
use crate::sweep::lanes::algebra::Algebra;
use crate::sweep::lanes::drive_table::{DriveTable, WHOLE};
use crate::sweep::lanes::instructions::InstructionSet;
use crate::sweep::lanes::meter::Meters;
use crate::sweep::lanes::number::Number;
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

/// A range of steps of one period, made in all lanes with the classical Runge-Kutta method.
///
/// With a(t, q, v) the acceleration, and the drives from the table at t, t + h/2 and t + h:
///
/// a₁ = a(t, q, v)
///
/// a₂ = a(t + h/2, q + h/2 v, v₂),   v₂ = v + h/2 a₁
///
/// a₃ = a(t + h/2, q + h/2 v₂, v₃),   v₃ = v + h/2 a₂
///
/// a₄ = a(t + h, q + h v₃, v + h a₃)
///
/// q ← q + h (v + h/6 (a₁ + a₂ + a₃)),   v ← v + h/6 (a₁ + 2 a₂ + 2 a₃ + a₄)
///
/// Source: Hairer, Nørsett & Wanner I, Table II.1.2.
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

/// Number of vectors in [`LaneWork`] with one element for each degree of freedom.
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

/// The working vectors of a step: q and v, q and v of a stage, the acceleration of a stage, a₁ (`first`), a₂
/// and then a₂ + a₃ (`inner`), the drives of the stage, the contacts.
struct LaneWork<'w, S> {
    q: &'w mut [S],
    v: &'w mut [S],
    qs: &'w mut [S],
    vs: &'w mut [S],
    a: &'w mut [S],
    first: &'w mut [S],
    inner: &'w mut [S],
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
            q,
            v,
            qs,
            vs,
            a,
            first,
            inner,
            u: &mut u[..drives],
            contacts: &mut contacts[..touching],
        };
        self.advance::<true>(N, &mut work);
        self.bundle.q.copy_from_slice(work.q);
        self.bundle.v.copy_from_slice(work.v);
    }

    /// Makes the steps on vectors in memory.
    #[inline(always)]
    fn large(&mut self) {
        let (n, drives) = (self.algebra.dof(), self.algebra.drives());
        let mut scratch = std::mem::take(&mut self.bundle.scratch);
        let mut contacts = std::mem::take(&mut self.bundle.contacts);
        let mut rest = &mut scratch[..];
        let mut work = LaneWork {
            q: cut(&mut rest, n),
            v: cut(&mut rest, n),
            qs: cut(&mut rest, n),
            vs: cut(&mut rest, n),
            a: cut(&mut rest, n),
            first: cut(&mut rest, n),
            inner: cut(&mut rest, n),
            u: cut(&mut rest, drives),
            contacts: &mut contacts,
        };
        work.q.copy_from_slice(&self.bundle.q);
        work.v.copy_from_slice(&self.bundle.v);
        work.u.copy_from_slice(&self.bundle.u);
        self.advance::<false>(n, &mut work);
        self.bundle.q.copy_from_slice(work.q);
        self.bundle.v.copy_from_slice(work.v);
        self.bundle.scratch = scratch;
        self.bundle.contacts = contacts;
    }

    // Not inlined without optimisation: it is then compiled once, instead of once for each instruction set.
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance<const SMALL: bool>(&mut self, n: usize, w: &mut LaneWork<'_, S>) {
        let w = &mut LaneWork {
            q: &mut w.q[..n],
            v: &mut w.v[..n],
            qs: &mut w.qs[..n],
            vs: &mut w.vs[..n],
            a: &mut w.a[..n],
            first: &mut w.first[..n],
            inner: &mut w.inner[..n],
            u: &mut *w.u,
            contacts: &mut *w.contacts,
        };
        let (algebra, table, h) = (self.algebra, self.table, self.bundle.step);
        let (half, sixth, columns) = (h * 0.5, h * (1.0 / 6.0), algebra.columns());
        let (metered, contacts) = (self.bundle.metered, self.bundle.meters.contacts());
        let rolled = |i: usize| if SMALL { i } else { keep_rolled(i) };
        // Whether the drives at the start of the step are not in `u` yet.
        let mut fresh = true;
        for step in self.steps.clone() {
            if fresh || SMALL {
                fill::<S, SMALL>(table, 2 * step, columns, w.u);
            }
            if metered {
                if fresh && table.jumps_before(step) {
                    self.bundle.meters.halve_next();
                }
                if !contacts.is_empty() {
                    algebra.contact(contacts.clone(), w.u, w.q, w.v, w.contacts);
                }
                self.bundle.meters.sample(w.q, w.v, w.contacts);
            }
            let (end, shared) = table.end(step);
            for i in 0..n {
                let i = rolled(i);
                (w.qs[i], w.vs[i]) = (w.q[i], w.v[i]);
            }
            // One loop over the stages has one copy of the algebra, where it is large.
            for stage in 0..4 {
                let stage = rolled(stage);
                match stage {
                    0 => {}
                    3 => fill::<S, SMALL>(table, end, columns, w.u),
                    _ if stage == 1 || SMALL => fill::<S, SMALL>(table, 2 * step + 1, columns, w.u),
                    _ => {}
                }
                algebra.accel(w.u, w.qs, w.vs, w.a);
                let ahead = if stage == 2 { h } else { half };
                match stage {
                    0 => {
                        for i in 0..n {
                            let i = rolled(i);
                            w.first[i] = w.a[i];
                        }
                    }
                    1 => {
                        for i in 0..n {
                            let i = rolled(i);
                            w.inner[i] = w.a[i];
                        }
                    }
                    2 => {
                        for i in 0..n {
                            let i = rolled(i);
                            w.inner[i] = w.inner[i] + w.a[i];
                        }
                    }
                    _ => break,
                }
                for i in 0..n {
                    let i = rolled(i);
                    w.qs[i] = w.q[i] + ahead * w.vs[i];
                    w.vs[i] = w.v[i] + ahead * w.a[i];
                }
            }
            for i in 0..n {
                let i = rolled(i);
                w.q[i] = w.q[i] + h * (w.v[i] + sixth * (w.first[i] + w.inner[i]));
                w.v[i] = w.v[i] + sixth * (w.first[i] + w.inner[i] + w.inner[i] + w.a[i]);
            }
            if SMALL {
                std::hint::black_box(());
            }
            fresh = !shared;
            if metered && fresh {
                let Bundle { q, v, u, contacts, meters, .. } = &mut *self.bundle;
                q.copy_from_slice(w.q);
                v.copy_from_slice(w.v);
                u.copy_from_slice(w.u);
                sample_before_jump(algebra, meters, [q, v, u], if SMALL { contacts } else { w.contacts });
            }
        }
        if metered {
            self.bundle.meters.finish();
        }
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
