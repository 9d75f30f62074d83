//! d
use gear_dynamics::analysis::Probe;
use gear_dynamics::branches::*;
use gear_dynamics::trains::SpurPair;
use gear_dynamics::*;
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let a: Vec<f64> = std::env::args().skip(1).map(|x| x.parse().unwrap()).collect();
    let (z, f, k, e) = (a[0], a[1], [a[2], a[3]], [a[4], a[5]]);
    let (lo, hi, step) = (a[6], a[7], a[8]);
    let pair = SpurPair::of_numbers(z, f, &k, &e)?.parts()?.build("driver", 0.5)?;
    let family = ByConstant::new(&pair, "speed")?;
    let settle = Settle::new().tolerance(1e-8).max_periods(600);
    let st = settle.run(&Dop853::new().rtol(1e-10).atol(1e-16), &pair, &State::at_rest(pair.dof()))?;
    let c = Continuation::new(0.5, 2.4)
        .max_step(step)
        .max_points(20000)
        .shooting(Shooting::new().multiple(st.period_multiple));
    let b = c.run(&family, &[st.state.clone()])?;
    for p in b.points() {
        if p.parameter < lo || p.parameter > hi {
            continue;
        }
        let m = family.at(p.parameter)?;
        let probe = Probe::new(&*m);
        let names: Vec<String> = probe.channels().iter().map(|c| c.name.clone()).collect();
        let _ = names;
        // sampled local extremes of the deflection
        let n = 500;
        let s0 = &p.orbit.states()[0];
        let end = s0.t + p.orbit.period();
        let mut ys = vec![];
        let mut at = s0.clone();
        for i in 0..n {
            let t = s0.t + (end - s0.t) * (i as f64) / n as f64;
            if i > 0 {
                at = p.orbit.at(&&*m, t)?;
            }
            ys.push(at.q.clone());
        }
        let idx = 0;
        if lo > 1.5 {
            println!(
                "{:.6} s{:.4} {:?} {}",
                p.parameter,
                p.arclength,
                p.multipliers.values().iter().map(|m| format!("{m:.4}")).collect::<Vec<_>>(),
                p.kind.as_ref().map_or("", |k| k.name())
            );
            continue;
        }
        let mut line = String::new();
        for i in 0..n {
            let (u, v, w) = (ys[(i + n - 1) % n][idx], ys[i][idx], ys[(i + 1) % n][idx]);
            if (v - u) * (w - v) < 0.0 {
                line += &format!(" {}{:.4}@{:.3}", if v > u { "^" } else { "v" }, v, i as f64 / n as f64);
            }
        }
        println!("{:?}", p.multipliers.values().iter().map(|m| format!("{m:.4}")).collect::<Vec<_>>());
        println!(
            "{:.6} s{:.4} {:?} {} |{line}",
            p.parameter,
            p.arclength,
            p.crossings,
            p.kind.as_ref().map_or("", |k| k.name())
        );
    }
    Ok(())
}
