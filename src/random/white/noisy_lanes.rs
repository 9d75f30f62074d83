//! Members side by side: the step of a model under white noise in lanes.

use crate::contact::{ByDeflection, Contact};
use crate::model::{Drives, Machine, Shape};
use crate::random::white::noise::{Source, WhiteNoise};
use crate::random::white::normal::{key, normal_pairs};
use crate::scalar::keep_rolled;
use crate::sweep::lanes::drive_table::DriveTable;
use crate::sweep::lanes::instructions::InstructionSet;
use crate::sweep::lanes::number::Lanes;
use crate::sweep::lanes::stages::{Acceleration, Stages};

/// W members of one machine under white noise. A step of length h is
///
/// N₁(h/2) ... N_d(h/2) · R(h) · N_d(h/2) ... N₁(h/2)
///
/// R is a step of the classical Runge-Kutta method without noise. N_j is the flow of source j alone: of a
/// bath exact, of noise on drives v' = (g(v)) √D ∘ξ, the flow of the field g over the time √(D h/2) Z with a
/// normal number Z. The product is symmetric: its weak order is 2.   Source: Ninomiya and Victoir 2008 (Appl.
/// Math. Finance 15, 107); Bou-Rabee and Owhadi 2010 (SIAM J. Numer. Anal. 48, 278).
pub(crate) struct NoisyLanes<'m, G, const W: usize> {
    shape: &'m G,
    pub(crate) table: &'m DriveTable,
    sources: Vec<Source>,
    /// Length of a step.
    pub(crate) h: f64,
    pub(crate) q: Vec<Lanes<W>>,
    pub(crate) v: Vec<Lanes<W>>,
    /// Number of steps since time 0 in each lane: the time, the row of the table and the number of the random
    /// pair.
    pub(crate) number: [u64; W],
    /// The keys of the random numbers: for each source, of each lane.
    keys: Vec<[u64; W]>,
    seed: u64,
    work: Work<W>,
}

/// Working vectors: the drives; the drives with noise; q and v at the start of R; q and v of a stage, its
/// acceleration, a₁ and a₂ + a₃; v at the end of R; the normal numbers of the second half of the step, for
/// each source.
#[derive(Clone)]
struct Work<const W: usize> {
    u: Vec<Lanes<W>>,
    noisy: Vec<Lanes<W>>,
    q0: Vec<Lanes<W>>,
    v0: Vec<Lanes<W>>,
    qs: Vec<Lanes<W>>,
    vs: Vec<Lanes<W>>,
    a: Vec<Lanes<W>>,
    first: Vec<Lanes<W>>,
    inner: Vec<Lanes<W>>,
    v1: Vec<Lanes<W>>,
    second: Vec<[f64; W]>,
}

/// What is measured or watched after each step.
pub(crate) trait Gauge<G, const W: usize> {
    /// Reads a step. Returns whether the steps shall go on.
    fn look(&mut self, step: &Look<'_, G, W>) -> bool;
}

/// A step that was made.
pub(crate) struct Look<'s, G, const W: usize> {
    pub(crate) shape: &'s G,
    table: &'s DriveTable,
    /// Number of steps up to the end of this one, in each lane.
    pub(crate) number: &'s [u64; W],
    pub(crate) h: f64,
    /// Drives at the end.
    pub(crate) u: &'s [Lanes<W>],
    /// State at the end.
    pub(crate) q: &'s [Lanes<W>],
    pub(crate) v: &'s [Lanes<W>],
    /// State at the start of R, and velocities at its end. The coordinates at its end are `q`.
    pub(crate) q0: &'s [Lanes<W>],
    pub(crate) v0: &'s [Lanes<W>],
    pub(crate) v1: &'s [Lanes<W>],
}

impl<G: Shape, const W: usize> Look<'_, G, W> {
    /// Contact `i` at the end of the step.
    #[inline(always)]
    pub(crate) fn contact(&self, i: usize) -> Contact<Lanes<W>> {
        self.contact_under(i, self.u)
    }
    /// Whether the drives jump at the end of the step. If they do, writes those behind the jump to `u`. All
    /// lanes must have made the same number of steps.
    #[inline(always)]
    pub(crate) fn jumps(&self, u: &mut Vec<Lanes<W>>) -> bool {
        let jumps = self.table.jumps_before((self.number[0] % self.table.steps() as u64) as usize);
        if jumps {
            u.clear();
            u.extend_from_slice(self.u);
            fill(self.table, self.number, 0, u);
        }
        jumps
    }
    /// Contact `i` at the end of the step under other drives.
    #[inline(always)]
    pub(crate) fn contact_under(&self, i: usize, u: &[Lanes<W>]) -> Contact<Lanes<W>> {
        self.shape.contact(&ByDeflection, i, Drives::new(self.shape.size().waves, u), self.q, self.v)
    }
    /// Contact `i` at the start and at the end of R. `u`: memory for the drives.
    #[inline(never)]
    pub(crate) fn arc(&self, i: usize, u: &mut Vec<Lanes<W>>) -> [Contact<Lanes<W>>; 2] {
        let waves = self.shape.size().waves;
        let end = self.shape.contact(&ByDeflection, i, Drives::new(waves, self.u), self.q, self.v1);
        u.clear();
        u.extend_from_slice(self.u);
        fill(self.table, &self.number.map(|n| n - 1), 0, u);
        [self.shape.contact(&ByDeflection, i, Drives::new(waves, u), self.q0, self.v0), end]
    }
}

/// Writes the drives of the table at the start (`half` = 0) or the middle (1) of a step to all lanes.
#[inline(always)]
fn fill<const W: usize>(table: &DriveTable, number: &[u64; W], half: usize, u: &mut [Lanes<W>]) {
    let steps = table.steps() as u64;
    let row = |lane: usize| table.row(2 * (number[lane] % steps) as usize + half);
    write(table, number, row, u);
}

/// Writes the drives of the table at the end of a step to all lanes.
#[inline(always)]
fn fill_end<const W: usize>(table: &DriveTable, number: &[u64; W], u: &mut [Lanes<W>]) {
    let steps = table.steps() as u64;
    write(table, number, |lane| table.row(table.end((number[lane] % steps) as usize).0), u);
}

#[inline(always)]
fn write<'t, const W: usize>(
    table: &DriveTable,
    number: &[u64; W],
    row: impl Fn(usize) -> &'t [f64],
    u: &mut [Lanes<W>],
) {
    if number.iter().all(|n| *n == number[0]) {
        for (&column, &x) in table.varying().iter().zip(row(0)) {
            u[column] = x.into();
        }
    } else {
        for lane in 0..W {
            for (&column, &x) in table.varying().iter().zip(row(lane)) {
                u[column].0[lane] = x;
            }
        }
    }
}

impl<'m, G: Shape, const W: usize> NoisyLanes<'m, G, W> {
    /// Lanes without members, at rest.
    pub(crate) fn new(
        machine: &'m Machine<G>,
        table: &'m DriveTable,
        noise: &[(WhiteNoise, bool)],
        h: f64,
        seed: u64,
    ) -> Self {
        let zero = Lanes([0.0; W]);
        let (n, waves) = (machine.size().dof, machine.size().waves);
        let mut u = vec![zero; machine.size().drives()];
        u.iter_mut().zip(table.start()).for_each(|(u, x)| *u = (*x).into());
        let constants = machine.prepared_constants();
        u[waves] = machine.speed().into();
        u[waves + 2..].iter_mut().zip(&constants[1..]).for_each(|(u, x)| *u = (*x).into());
        let state = vec![zero; n];
        let work = Work {
            noisy: u.clone(),
            u,
            q0: state.clone(),
            v0: state.clone(),
            qs: state.clone(),
            vs: state.clone(),
            a: state.clone(),
            first: state.clone(),
            inner: state.clone(),
            v1: state.clone(),
            second: vec![[0.0; W]; noise.len()],
        };
        NoisyLanes {
            shape: machine.shape(),
            table,
            sources: noise
                .iter()
                .map(|(noise, follows_velocity)| Source::new(noise, h, *follows_velocity))
                .collect(),
            h,
            q: state.clone(),
            v: state,
            number: [0; W],
            keys: vec![[0; W]; noise.len()],
            seed,
            work,
        }
    }

    /// Puts a member with its state after `number` steps into a lane. The member determines the random
    /// numbers.
    pub(crate) fn load(&mut self, lane: usize, member: u64, number: u64, q: &[f64], v: &[f64]) {
        self.q.iter_mut().zip(q).for_each(|(to, q)| to.0[lane] = *q);
        self.v.iter_mut().zip(v).for_each(|(to, v)| to.0[lane] = *v);
        self.number[lane] = number;
        for (stream, keys) in self.keys.iter_mut().enumerate() {
            keys[lane] = key(self.seed, member, stream as u64);
        }
    }

    /// Whether the state of a lane is finite.
    pub(crate) fn is_finite(&self, lane: usize) -> bool {
        self.q.iter().chain(&self.v).all(|x| x.0[lane].is_finite())
    }

    /// Makes `steps` steps, or fewer if the gauge ends them.
    pub(crate) fn run<T: Gauge<G, W>>(&mut self, steps: u64, set: InstructionSet, gauge: &mut T) {
        set.run(Steps { lanes: self, steps, gauge });
    }

    #[inline(always)]
    fn step(&mut self) {
        let n = self.shape.size().dof;
        let w = &mut self.work;
        let (q, v, vs) = (&mut self.q[..n], &mut self.v[..n], &mut w.vs[..n]);
        let (a, first, inner) = (&mut w.a[..n], &mut w.first[..n], &mut w.inner[..n]);
        let u = &mut w.u[..];
        let (shape, table, number) = (self.shape, self.table, &self.number);
        fill(table, number, 0, u);
        for ((source, keys), second) in self.sources.iter().zip(&self.keys).zip(&mut w.second) {
            let pair = normal_pairs(keys, number);
            *second = pair[1];
            let scratch = [&mut *vs, &mut *a, &mut *first, &mut *inner];
            kick(shape, source, Lanes(pair[0]), [&mut *u, &mut w.noisy], q, v, scratch);
        }
        w.q0.copy_from_slice(q);
        w.v0.copy_from_slice(v);
        let mut stages = Stages {
            q: &mut *q,
            v: &mut *v,
            qs: &mut w.qs[..n],
            vs: &mut *vs,
            a: &mut *a,
            first: &mut *first,
            inner: &mut *inner,
        };
        stages.step::<false>(n, self.h.into(), &mut OfTable { shape, table, number, u });
        w.v1.copy_from_slice(v);
        for (source, second) in self.sources.iter().zip(&w.second).rev() {
            let scratch = [&mut *vs, &mut *a, &mut *first, &mut *inner];
            kick(shape, source, Lanes(*second), [&mut *u, &mut w.noisy], q, v, scratch);
        }
        for number in &mut self.number {
            *number += 1;
        }
    }
}

/// The acceleration in a step without noise, with the drives of the table.
struct OfTable<'a, G, const W: usize> {
    shape: &'a G,
    table: &'a DriveTable,
    number: &'a [u64; W],
    u: &'a mut [Lanes<W>],
}

impl<G: Shape, const W: usize> Acceleration<Lanes<W>> for OfTable<'_, G, W> {
    #[inline(always)]
    fn accel(&mut self, stage: usize, q: &[Lanes<W>], v: &[Lanes<W>], a: &mut [Lanes<W>]) {
        match stage {
            1 => fill(self.table, self.number, 1, self.u),
            3 => fill_end(self.table, self.number, self.u),
            _ => {}
        }
        self.shape.accel(&ByDeflection, Drives::new(self.shape.size().waves, self.u), q, v, a);
    }
}

/// The flow of one source over half a step, with the normal numbers z. `scratch`: memory for four vectors.
#[inline(always)]
fn kick<G: Shape, const W: usize>(
    shape: &G,
    source: &Source,
    z: Lanes<W>,
    [u, noisy]: [&mut [Lanes<W>]; 2],
    q: &[Lanes<W>],
    v: &mut [Lanes<W>],
    scratch: [&mut [Lanes<W>]; 4],
) {
    match source {
        Source::Bath { coordinate, decay, spread } => {
            v[*coordinate] = v[*coordinate] * *decay + z * *spread;
        }
        Source::Drives { slots, follows_velocity } => {
            noisy.copy_from_slice(u);
            for &(slot, gain) in slots {
                noisy[slot] = noisy[slot] + z * gain;
            }
            kick_drives(shape, *follows_velocity, [u, noisy], q, v, scratch);
        }
    }
}

/// The flow v' = g(v) over the time 1 with g(v) = a(u₁, q, v) - a(u₀, q, v), the drives with and without
/// noise; q stands still. One step of Euler if g does not depend on v, else a step of the classical
/// Runge-Kutta method, whose error of order 5 in z has the mean 0.
fn kick_drives<G: Shape, const W: usize>(
    shape: &G,
    follows_velocity: bool,
    u: [&[Lanes<W>]; 2],
    q: &[Lanes<W>],
    v: &mut [Lanes<W>],
    [vs, a, g, sum]: [&mut [Lanes<W>]; 4],
) {
    let n = v.len();
    let waves = shape.size().waves;
    let field = |v: &[Lanes<W>], a: &mut [Lanes<W>], g: &mut [Lanes<W>]| {
        shape.accel(&ByDeflection, Drives::new(waves, u[0]), q, v, a);
        shape.accel(&ByDeflection, Drives::new(waves, u[1]), q, v, g);
        for i in 0..n {
            let i = keep_rolled(i);
            g[i] = g[i] - a[i];
        }
    };
    field(v, a, g);
    if !follows_velocity {
        for i in 0..n {
            let i = keep_rolled(i);
            v[i] = v[i] + g[i];
        }
        return;
    }
    sum.copy_from_slice(g);
    for (weight, reach) in [(2.0, 0.5), (2.0, 0.5), (1.0, 1.0)] {
        for i in 0..n {
            let i = keep_rolled(i);
            vs[i] = v[i] + g[i] * reach;
        }
        field(vs, a, g);
        for i in 0..n {
            let i = keep_rolled(i);
            sum[i] = sum[i] + g[i] * weight;
        }
    }
    for i in 0..n {
        let i = keep_rolled(i);
        v[i] = v[i] + sum[i] * (1.0 / 6.0);
    }
}

struct Steps<'a, 'm, G, T, const W: usize> {
    lanes: &'a mut NoisyLanes<'m, G, W>,
    steps: u64,
    gauge: &'a mut T,
}

impl<G: Shape, T: Gauge<G, W>, const W: usize> pulp::WithSimd for Steps<'_, '_, G, T, W> {
    type Output = ();
    #[inline(always)]
    fn with_simd<I: pulp::Simd>(self, _: I) {
        for _ in 0..self.steps {
            self.lanes.step();
            let NoisyLanes { shape, table, number, h, q, v, work, .. } = &*self.lanes;
            let Work { u, q0, v0, v1, .. } = work;
            if !self.gauge.look(&Look { shape, table, number, h: *h, u, q, v, q0, v0, v1 }) {
                return;
            }
        }
    }
}
