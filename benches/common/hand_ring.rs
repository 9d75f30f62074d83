//! The ring of workloads B3 and B16 written by hand for G equal gears: RK4, and DOP853 with located edges, on
//! arrays of fixed length N = 4 G + 2 with coordinates before velocities. Each evaluation computes one sine
//! and one cosine.

use super::RING_OMEGA;
use super::hand_dop853::{A, A_DENSE, B, C, D, E3, E5};

/// The constants in this order: inertias J_M, J, J_L [kg m²]; base radius R; mesh stiffness k [N/m] and
/// damping c [N s/m]; half backlash b; amplitude of the error e; shaft stiffness k_s and damping c_s; load
/// torque T_L [N m].
const MOTOR: f64 = 0.03;
const GEAR: f64 = 1.5e-3;
const LOAD: f64 = 1e-2;
const RADIUS: f64 = 0.0564;
const STIFFNESS: f64 = 1e8;
const DAMPING: f64 = 2000.0;
const EDGE: f64 = 2.65e-5;
const ERROR: f64 = 1e-5;
const SHAFT: f64 = 3e5;
const SHAFT_DAMPING: f64 = 1.0;
const TORQUE: f64 = 20.0;

/// Stiffness k, error e and its rate e' at one instant.
#[derive(Clone, Copy)]
pub struct Drives {
    k: f64,
    e: f64,
    rate: f64,
}

#[inline(always)]
pub fn drives(t: f64) -> Drives {
    let (s, c) = libm::sincos(RING_OMEGA * t);
    Drives { k: STIFFNESS * (1.0 + 0.2 * c), e: ERROR * s, rate: ERROR * RING_OMEGA * c }
}

/// The derivatives (q', v'); `force` is the dead zone of mesh i.
#[inline(always)]
fn rates<const G: usize, const N: usize>(
    u: Drives,
    y: &[f64; N],
    force: impl Fn(usize, f64) -> f64,
) -> [f64; N] {
    let (q, v) = y.split_at(2 * G + 1);
    let mut out = [0.0; N];
    out[..2 * G + 1].copy_from_slice(v);
    let a = &mut out[2 * G + 1..];
    let mesh = |i: usize| {
        let (g, next) = (1 + 2 * i, if i + 1 == G { 1 } else { 3 + 2 * i });
        let d = RADIUS * (q[g] - q[next]) - u.e;
        u.k * force(i, d) + DAMPING * (RADIUS * (v[g] - v[next]) - u.rate)
    };
    let motor = SHAFT * (q[0] - q[1]) + SHAFT_DAMPING * (v[0] - v[1]);
    a[0] = (TORQUE * G as f64 - motor) * (1.0 / MOTOR);
    let mut before = mesh(G - 1);
    for i in 0..G {
        let (g, l) = (1 + 2 * i, 2 + 2 * i);
        let w = mesh(i);
        let shaft = SHAFT * (q[g] - q[l]) + SHAFT_DAMPING * (v[g] - v[l]);
        let torque = if i == 0 { motor } else { 0.0 };
        a[g] = (torque - shaft - RADIUS * (w - before)) * (1.0 / GEAR);
        a[l] = (shaft - TORQUE) * (1.0 / LOAD);
        before = w;
    }
    out
}

/// The derivatives with the dead zones themselves.
#[inline(always)]
pub fn plain<const G: usize, const N: usize>(u: Drives, y: &[f64; N]) -> [f64; N] {
    rates::<G, N>(u, y, |_, d| d - d.clamp(-EDGE, EDGE))
}

/// The derivatives with every mesh on a given piece: -1, 0 or 1.
#[inline(always)]
fn held<const G: usize, const N: usize>(u: Drives, pieces: &[i32; G], y: &[f64; N]) -> [f64; N] {
    rates::<G, N>(u, y, |i, d| match pieces[i] {
        -1 => d + EDGE,
        0 => 0.0,
        _ => d - EDGE,
    })
}

/// RK4 on f(t, y) without further care.
pub fn rk4<const G: usize, const N: usize>(h: f64, steps: usize) -> [f64; N] {
    let f = |t: f64, y: &[f64; N]| plain::<G, N>(drives(t), y);
    let along = |y: &[f64; N], a: f64, k: &[f64; N]| std::array::from_fn(|j| y[j] + a * k[j]);
    let mut y = [0.0; N];
    for i in 0..steps {
        let t = i as f64 * h;
        let k1 = f(t, &y);
        let k2 = f(t + 0.5 * h, &along(&y, 0.5 * h, &k1));
        let k3 = f(t + 0.5 * h, &along(&y, 0.5 * h, &k2));
        let k4 = f(t + h, &along(&y, h, &k3));
        for j in 0..N {
            y[j] += h / 6.0 * (k1[j] + 2.0 * k2[j] + 2.0 * k3[j] + k4[j]);
        }
    }
    y
}

/// RK4 with the drives shared between stages and from step to step.
pub fn rk4_shared<const G: usize, const N: usize>(h: f64, steps: usize) -> [f64; N] {
    let along = |y: &[f64; N], a: f64, k: &[f64; N]| std::array::from_fn(|j| y[j] + a * k[j]);
    let (mut y, mut u0) = ([0.0; N], drives(0.0));
    for i in 0..steps {
        let t = i as f64 * h;
        let (middle, u1) = (drives(t + 0.5 * h), drives(t + h));
        let k1 = plain::<G, N>(u0, &y);
        let k2 = plain::<G, N>(middle, &along(&y, 0.5 * h, &k1));
        let k3 = plain::<G, N>(middle, &along(&y, 0.5 * h, &k2));
        let k4 = plain::<G, N>(u1, &along(&y, h, &k3));
        for j in 0..N {
            y[j] += h / 6.0 * (k1[j] + 2.0 * k2[j] + 2.0 * k3[j] + k4[j]);
        }
        u0 = u1;
    }
    y
}

struct Step<const N: usize> {
    t: f64,
    h: f64,
    y: [f64; N],
    y1: [f64; N],
    k: [[f64; N]; 16],
    dense: [[f64; N]; 7],
}

/// Deflection d and rate d' of mesh i.
#[inline(always)]
fn deflection<const G: usize, const N: usize>(u: Drives, y: &[f64; N], i: usize) -> [f64; 2] {
    let (g, next) = (1 + 2 * i, if i + 1 == G { 1 } else { 3 + 2 * i });
    let v = 2 * G + 1;
    [RADIUS * (y[g] - y[next]) - u.e, RADIUS * (y[v + g] - y[v + next]) - u.rate]
}

/// DOP853 from rest to `end`. Returns the last state, the number of evaluations and that of crossings. Every
/// contact is checked at the end of each step. An edge is located by Newton's method on the dense output
/// within a bracket.
pub fn dop853<const G: usize, const N: usize>(end: f64, rtol: f64, atol: f64) -> ([f64; N], u64, u64) {
    let mut s = Step { t: 0.0, h: 1e-7, y: [0.0; N], y1: [0.0; N], k: [[0.0; N]; 16], dense: [[0.0; N]; 7] };
    let mut pieces = [0; G];
    let (mut evaluations, mut crossings) = (1, 0);
    let (mut old, mut rejected) = (1e-4f64, false);
    let mut start: [[f64; 2]; G] = std::array::from_fn(|i| deflection::<G, N>(drives(0.0), &s.y, i));
    s.k[0] = held::<G, N>(drives(0.0), &pieces, &s.y);
    while s.t < end {
        s.h = s.h.min(end - s.t);
        attempt::<G, N>(&mut s, &pieces);
        evaluations += 11;
        let error = error(&s, rtol, atol);
        let raw = error.powf(1.0 / 8.0 - 0.75 * 0.03) / 0.9;
        if error > 1.0 {
            s.h /= raw.min(3.0);
            rejected = true;
            continue;
        }
        let next = s.h / (raw / old.powf(0.03)).clamp(if rejected { 1.0 } else { 1.0 / 6.0 }, 3.0);
        (old, rejected) = (error.max(1e-4), false);
        let u1 = drives(s.t + s.h);
        let mut at_end: [[f64; 2]; G] = std::array::from_fn(|i| deflection::<G, N>(u1, &s.y1, i));
        let mut first: Option<(f64, usize, i32)> = None;
        let mut ready = false;
        for i in 0..G {
            // The exits of the piece: sign, edge and next piece. The distance sign (d - edge) is positive on
            // the piece.
            let exits: &[(f64, f64, i32)] = match pieces[i] {
                -1 => &[(-1.0, -EDGE, 0)],
                0 => &[(1.0, -EDGE, -1), (-1.0, EDGE, 1)],
                _ => &[(1.0, EDGE, 0)],
            };
            for &(sign, edge, to) in exits {
                let (g0, g1) = (sign * (start[i][0] - edge), sign * (at_end[i][0] - edge));
                let (r0, r1) = (s.h * sign * start[i][1], s.h * sign * at_end[i][1]);
                let dips = g1.min(g0) < 0.2 * (r0.abs() + r1.abs()) && r0 < 0.0 && r1 > 0.0;
                if g1 >= 0.0 && !dips {
                    continue;
                }
                if !ready {
                    prepare::<G, N>(&mut s, u1, &pieces);
                    evaluations += 4;
                    ready = true;
                }
                let look = |theta: f64| {
                    let [d, rate] = deflection::<G, N>(drives(s.t + theta * s.h), &inside(&s, theta), i);
                    (sign * (d - edge), s.h * sign * rate)
                };
                let (mut lo, mut hi) = (0.0, 1.0);
                if g1 >= 0.0 {
                    // The minimum of the distance, which may be negative inside the step.
                    for _ in 0..40 {
                        let middle = 0.5 * (lo + hi);
                        if look(middle).1 < 0.0 { lo = middle } else { hi = middle }
                    }
                    if look(hi).0 >= 0.0 {
                        continue;
                    }
                    lo = 0.0;
                }
                let mut theta = if g0 > 1e-13 && g1 < 0.0 { g0 / (g0 - g1) } else { 0.5 * (lo + hi) };
                for _ in 0..60 {
                    let (g, rate) = look(theta);
                    if g.abs() < 1e-16 {
                        break;
                    }
                    if g > 0.0 {
                        lo = theta
                    } else {
                        hi = theta
                    }
                    let newton = theta - g / rate;
                    theta = if newton > lo && newton < hi { newton } else { 0.5 * (lo + hi) };
                    if hi - lo < 1e-14 {
                        break;
                    }
                }
                if first.is_none_or(|(other, ..)| theta < other) {
                    first = Some((theta, i, to));
                }
            }
        }
        let u1 = if let Some((theta, i, to)) = first {
            s.h *= theta;
            attempt::<G, N>(&mut s, &pieces);
            pieces[i] = to;
            evaluations += 11;
            crossings += 1;
            let u1 = drives(s.t + s.h);
            at_end = std::array::from_fn(|i| deflection::<G, N>(u1, &s.y1, i));
            u1
        } else {
            u1
        };
        s.t += s.h;
        s.y = s.y1;
        start = at_end;
        s.k[0] = held::<G, N>(u1, &pieces, &s.y);
        evaluations += 1;
        s.h = next;
    }
    (s.y, evaluations, crossings)
}

#[inline(always)]
fn attempt<const G: usize, const N: usize>(s: &mut Step<N>, pieces: &[i32; G]) {
    for i in 1..12 {
        let y = combine(s, &A[i], i);
        s.k[i] = held::<G, N>(drives(s.t + C[i] * s.h), pieces, &y);
    }
    s.y1 = combine(s, &B, 12);
}

#[inline(always)]
fn combine<const N: usize, const L: usize>(s: &Step<N>, row: &[f64; L], stages: usize) -> [f64; N] {
    let mut sum = [0.0; N];
    for (a, k) in row[..stages].iter().zip(&s.k) {
        if *a != 0.0 {
            for j in 0..N {
                sum[j] += a * k[j];
            }
        }
    }
    std::array::from_fn(|j| s.y[j] + s.h * sum[j])
}

#[inline(always)]
fn error<const N: usize>(s: &Step<N>, rtol: f64, atol: f64) -> f64 {
    let (mut e5, mut e3) = (0.0, 0.0);
    let (mut a, mut b) = ([0.0; N], [0.0; N]);
    for (i, k) in s.k[..12].iter().enumerate() {
        if E5[i] != 0.0 {
            for j in 0..N {
                a[j] += E5[i] * k[j];
                b[j] += E3[i] * k[j];
            }
        }
    }
    for j in 0..N {
        let per_size = 1.0 / (atol + rtol * s.y[j].abs().max(s.y1[j].abs()));
        e5 += (a[j] * per_size) * (a[j] * per_size);
        e3 += (b[j] * per_size) * (b[j] * per_size);
    }
    if e5 == 0.0 { 0.0 } else { s.h * e5 / ((e5 + 0.01 * e3) * N as f64).sqrt() }
}

fn prepare<const G: usize, const N: usize>(s: &mut Step<N>, u1: Drives, pieces: &[i32; G]) {
    s.k[12] = held::<G, N>(u1, pieces, &s.y1);
    for (i, c) in [0.1, 0.2, 7.0 / 9.0].into_iter().enumerate() {
        let y = combine(s, &A_DENSE[i], 13 + i);
        s.k[13 + i] = held::<G, N>(drives(s.t + c * s.h), pieces, &y);
    }
    for j in 0..N {
        let dy = s.y1[j] - s.y[j];
        s.dense[0][j] = dy;
        s.dense[1][j] = s.h * s.k[0][j] - dy;
        s.dense[2][j] = 2.0 * dy - s.h * (s.k[12][j] + s.k[0][j]);
        for (dense, row) in s.dense[3..].iter_mut().zip(&D) {
            dense[j] = s.h * row.iter().zip(&s.k).map(|(d, k)| d * k[j]).sum::<f64>();
        }
    }
}

fn inside<const N: usize>(s: &Step<N>, theta: f64) -> [f64; N] {
    std::array::from_fn(|j| {
        let mut y = 0.0;
        for i in (0..7).rev() {
            y = (y + s.dense[i][j]) * if i % 2 == 0 { theta } else { 1.0 - theta };
        }
        s.y[j] + y
    })
}
