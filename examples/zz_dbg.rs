//! d
use gear_dynamics::analysis::Probe;
use gear_dynamics::branches::*;
use gear_dynamics::excitation::Side;
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
    println!("{b}");
    for p in b.points() {
        if p.parameter < lo || p.parameter > hi {
            continue;
        }
        let m = family.at(p.parameter)?;
        let mut probe = Probe::new(&*m);
        let n = 400;
        let s0 = &p.orbit.states()[0];
        let end = s0.t + p.orbit.period();
        let mut ys = vec![];
        for i in 0..n {
            let t = s0.t + (end - s0.t) * (i as f64) / n as f64;
            let at = p.orbit.at(&&*m, t)?;
            let c = probe.read_contacts(t, Side::After, &at.q, &at.v)[0];
            ys.push([c.deflection - c.upper, c.rate]);
        }
        let mut line = String::new();
        for i in 0..n {
            let (u, v, w) = (ys[(i + n - 1) % n], ys[i], ys[(i + 1) % n]);
            if (v[0] - u[0]) * (w[0] - v[0]) < 0.0 {
                line += &format!(
                    " {}{:.4}@{:.3}",
                    if v[0] > u[0] { "^" } else { "v" },
                    v[0],
                    i as f64 / n as f64
                );
            }
            if v[1].abs() < u[1].abs() && v[1].abs() < w[1].abs() && u[1] * v[1] > 0.0 && v[1] * w[1] > 0.0 {
                line += &format!(" [{:.4}, {:.4}]@{:.3}", v[0], v[1], i as f64 / n as f64);
            }
        }
        println!(
            "{:.13} s{:.9} {:?} {} |{line}",
            p.parameter,
            p.arclength,
            p.crossings,
            p.kind.as_ref().map_or("", |k| k.name())
        );
    }
    Ok(())
}
