//! DOP853 with located edges for workload A, written by hand for this one equation; the general solver is
//! compared with it. Coefficients of the code of Hairer, Nørsett & Wanner.

use super::Pair;

#[rustfmt::skip]
pub(super) const A: [[f64; 12]; 12] = [
    [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [0.05260015195876773, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [0.0197250569845379, 0.0591751709536137, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [0.02958758547680685, 0.0, 0.08876275643042054, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [0.2413651341592667, 0.0, -0.8845494793282861, 0.924834003261792, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [0.037037037037037035, 0.0, 0.0, 0.17082860872947386, 0.12546768756682242, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
     0.0],
    [0.037109375, 0.0, 0.0, 0.17025221101954405, 0.06021653898045596, -0.017578125, 0.0, 0.0, 0.0, 0.0, 0.0,
     0.0],
    [0.03709200011850479, 0.0, 0.0, 0.17038392571223998, 0.10726203044637328, -0.015319437748624402,
     0.008273789163814023, 0.0, 0.0, 0.0, 0.0, 0.0],
    [0.6241109587160757, 0.0, 0.0, -3.3608926294469414, -0.868219346841726, 27.59209969944671,
     20.154067550477894, -43.48988418106996, 0.0, 0.0, 0.0, 0.0],
    [0.47766253643826434, 0.0, 0.0, -2.4881146199716677, -0.590290826836843, 21.230051448181193,
     15.279233632882423, -33.28821096898486, -0.020331201708508627, 0.0, 0.0, 0.0],
    [-0.9371424300859873, 0.0, 0.0, 5.186372428844064, 1.0914373489967295, -8.149787010746927,
     -18.52006565999696, 22.739487099350505, 2.4936055526796523, -3.0467644718982196, 0.0, 0.0],
    [2.273310147516538, 0.0, 0.0, -10.53449546673725, -2.0008720582248625, -17.9589318631188,
     27.94888452941996, -2.8589982771350235, -8.87285693353063, 12.360567175794303, 0.6433927460157636, 0.0],
];
#[rustfmt::skip]
pub(super) const A_DENSE: [[f64; 16]; 3] = [
    [0.056167502283047954, 0.0, 0.0, 0.0, 0.0, 0.0, 0.25350021021662483, -0.2462390374708025,
     -0.12419142326381637, 0.15329179827876568, 0.00820105229563469, 0.007567897660545699, -0.008298, 0.0,
     0.0, 0.0],
    [0.03183464816350214, 0.0, 0.0, 0.0, 0.0, 0.028300909672366776, 0.053541988307438566,
     -0.05492374857139099, 0.0, 0.0, -0.00010834732869724932, 0.0003825710908356584,
     -0.00034046500868740456, 0.1413124436746325, 0.0, 0.0],
    [-0.42889630158379194, 0.0, 0.0, 0.0, 0.0, -4.697621415361164, 7.683421196062599, 4.06898981839711,
     0.3567271874552811, 0.0, 0.0, 0.0, -0.0013990241651590145, 2.9475147891527724, -9.15095847217987, 0.0],
];
#[rustfmt::skip]
pub(super) const D: [[f64; 16]; 4] = [
    [-8.428938276109013, 0.0, 0.0, 0.0, 0.0, 0.5667149535193777, -3.0689499459498917, 2.38466765651207,
     2.117034582445028, -0.871391583777973, 2.2404374302607883, 0.6315787787694688, -0.08899033645133331,
     18.148505520854727, -9.194632392478356, -4.436036387594894],
    [10.427508642579134, 0.0, 0.0, 0.0, 0.0, 242.28349177525817, 165.20045171727028, -374.5467547226902,
     -22.113666853125306, 7.733432668472264, -30.674084731089398, -9.332130526430229, 15.697238121770845,
     -31.139403219565178, -9.35292435884448, 35.81684148639408],
    [19.985053242002433, 0.0, 0.0, 0.0, 0.0, -387.0373087493518, -189.17813819516758, 527.8081592054236,
     -11.57390253995963, 6.8812326946963, -1.0006050966910838, 0.7777137798053443, -2.778205752353508,
     -60.19669523126412, 84.32040550667716, 11.99229113618279],
    [-25.69393346270375, 0.0, 0.0, 0.0, 0.0, -154.18974869023643, -231.5293791760455, 357.6391179106141,
     93.40532418362432, -37.45832313645163, 104.0996495089623, 29.8402934266605, -43.53345659001114,
     96.32455395918828, -39.17726167561544, -149.72683625798564],
];
#[rustfmt::skip]
pub(super) const B: [f64; 12] = [
    0.054293734116568765, 0.0, 0.0, 0.0, 0.0, 4.450312892752409, 1.8915178993145003, -5.801203960010585,
    0.3111643669578199, -0.1521609496625161, 0.20136540080403034, 0.04471061572777259
];
#[rustfmt::skip]
pub(super) const C: [f64; 12] = [
    0.0, 0.05260015195876773, 0.0789002279381516, 0.1183503419072274, 0.2816496580927726,
    0.3333333333333333, 0.25, 0.3076923076923077, 0.6512820512820513, 0.6, 0.8571428571428571, 1.0
];
#[rustfmt::skip]
pub(super) const E3: [f64; 12] = [
    -0.18980075407240762, 0.0, 0.0, 0.0, 0.0, 4.450312892752409, 1.8915178993145003, -5.801203960010585,
    -0.4226823213237919, -0.1521609496625161, 0.20136540080403034, 0.02265179219836082
];
#[rustfmt::skip]
pub(super) const E5: [f64; 12] = [
    0.01312004499419488, 0.0, 0.0, 0.0, 0.0, -1.2251564463762044, -0.4957589496572502, 1.6643771824549864,
    -0.35032884874997366, 0.3341791187130175, 0.08192320648511571, -0.022355307863886294
];

const EDGE: f64 = Pair::HALF_BACKLASH;

struct Step {
    t: f64,
    h: f64,
    y: [f64; 2],
    y1: [f64; 2],
    k: [[f64; 2]; 16],
    dense: [[f64; 2]; 7],
}

/// Runs to `end` and returns the last state, the number of evaluations and that of crossings.
pub fn run(pair: &Pair, q: f64, v: f64, end: f64, rtol: f64, atol: f64) -> ([f64; 2], u64, u64) {
    let f = |[stiffness, forcing]: [f64; 2], piece: i32, y: [f64; 2]| {
        let force = if piece == 0 { 0.0 } else { y[0] - f64::from(piece) * EDGE };
        [y[1], forcing - 0.02 * y[1] - stiffness * force]
    };
    let mut s = Step { t: 0.0, h: 1.0, y: [q, v], y1: [q, v], k: [[0.0; 2]; 16], dense: [[0.0; 2]; 7] };
    let (mut piece, mut evaluations, mut crossings) =
        (if q < -EDGE { -1 } else { i32::from(q > EDGE) }, 1, 0);
    let (mut old, mut rejected) = (1e-4f64, false);
    s.k[0] = f(pair.drives(0.0), piece, s.y);
    while s.t < end {
        s.h = s.h.min(end - s.t);
        attempt(&mut s, pair, piece, &f);
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
        // The exits of the piece: sign, edge and next piece. The distance sign (y - edge) is positive on the
        // piece.
        let exits: &[(f64, f64, i32)] = match piece {
            -1 => &[(-1.0, -EDGE, 0)],
            0 => &[(1.0, -EDGE, -1), (-1.0, EDGE, 1)],
            _ => &[(1.0, EDGE, 0)],
        };
        let mut first: Option<(f64, i32)> = None;
        for &(sign, edge, to) in exits {
            let (g0, g1) = (sign * (s.y[0] - edge), sign * (s.y1[0] - edge));
            let (r0, r1) = (s.h * sign * s.y[1], s.h * sign * s.y1[1]);
            let dips = g1.min(g0) < 0.2 * (r0.abs() + r1.abs()) && r0 < 0.0 && r1 > 0.0;
            if g1 >= 0.0 && !dips {
                continue;
            }
            prepare(&mut s, pair, piece, &f);
            evaluations += 4;
            let look = |theta: f64| {
                let y = inside(&s, theta);
                (sign * (y[0] - edge), s.h * sign * y[1])
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
            }
            if first.is_none_or(|(other, _)| theta < other) {
                first = Some((theta, to));
            }
        }
        if let Some((theta, to)) = first {
            s.h *= theta;
            attempt(&mut s, pair, piece, &f);
            piece = to;
            evaluations += 11;
            crossings += 1;
        }
        s.t += s.h;
        s.y = s.y1;
        s.k[0] = f(pair.drives(s.t), piece, s.y);
        evaluations += 1;
        s.h = next;
    }
    (s.y, evaluations, crossings)
}

#[inline(always)]
fn attempt(s: &mut Step, pair: &Pair, piece: i32, f: &impl Fn([f64; 2], i32, [f64; 2]) -> [f64; 2]) {
    for i in 1..12 {
        let y = combine(s, &A[i], i);
        s.k[i] = f(pair.drives(s.t + C[i] * s.h), piece, y);
    }
    s.y1 = combine(s, &B, 12);
}

#[inline(always)]
fn combine<const L: usize>(s: &Step, row: &[f64; L], stages: usize) -> [f64; 2] {
    let mut sum = [0.0; 2];
    for (a, k) in row[..stages].iter().zip(&s.k) {
        if *a != 0.0 {
            sum = [sum[0] + a * k[0], sum[1] + a * k[1]];
        }
    }
    [s.y[0] + s.h * sum[0], s.y[1] + s.h * sum[1]]
}

#[inline(always)]
fn error(s: &Step, rtol: f64, atol: f64) -> f64 {
    let (mut e5, mut e3) = (0.0, 0.0);
    for c in 0..2 {
        let size = atol + rtol * s.y[c].abs().max(s.y1[c].abs());
        let (mut a, mut b) = (0.0, 0.0);
        for j in 0..12 {
            a += E5[j] * s.k[j][c];
            b += E3[j] * s.k[j][c];
        }
        e5 += (a / size) * (a / size);
        e3 += (b / size) * (b / size);
    }
    if e5 == 0.0 { 0.0 } else { s.h * e5 / ((e5 + 0.01 * e3) * 2.0).sqrt() }
}

fn prepare(s: &mut Step, pair: &Pair, piece: i32, f: &impl Fn([f64; 2], i32, [f64; 2]) -> [f64; 2]) {
    s.k[12] = f(pair.drives(s.t + s.h), piece, s.y1);
    for (i, c) in [0.1, 0.2, 7.0 / 9.0].into_iter().enumerate() {
        let y = combine(s, &A_DENSE[i], 13 + i);
        s.k[13 + i] = f(pair.drives(s.t + c * s.h), piece, y);
    }
    for c in 0..2 {
        let dy = s.y1[c] - s.y[c];
        s.dense[0][c] = dy;
        s.dense[1][c] = s.h * s.k[0][c] - dy;
        s.dense[2][c] = 2.0 * dy - s.h * (s.k[12][c] + s.k[0][c]);
        for (dense, row) in s.dense[3..].iter_mut().zip(&D) {
            dense[c] = s.h * row.iter().zip(&s.k).map(|(d, k)| d * k[c]).sum::<f64>();
        }
    }
}

fn inside(s: &Step, theta: f64) -> [f64; 2] {
    let mut y = [0.0; 2];
    for (c, y) in y.iter_mut().enumerate() {
        for i in (0..7).rev() {
            *y = (*y + s.dense[i][c]) * if i % 2 == 0 { theta } else { 1.0 - theta };
        }
        *y += s.y[c];
    }
    y
}
