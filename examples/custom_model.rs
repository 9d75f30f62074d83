//! A model, a nonlinearity and an excitation of one's own: an idler that rattles under a torque ripple.
//!
//! `cargo run --release --example custom_model`
use gear_dynamics::*;

/// Hertzian contact: force ~ p^1.5, p the penetration past the half backlash.
struct Hertz;
impl Nonlinearity for Hertz {
    fn force<S: Scalar>(&self, x: S, _rate: S, lower: S, upper: S) -> S {
        let push = |depth: S| depth.max(S::from(0.0)) * depth.max(S::from(0.0)).sqrt();
        push(x - upper) - push(lower - x)
    }
}
/// A sharpened torque ripple.
#[derive(Debug)]
struct Ripple(f64);
impl Excitation for Ripple {
    fn jet(&self, t: f64, _: Side) -> Jet {
        let wave = (Jet::time(t) * self.0).sin();
        wave + wave * wave * wave * 0.5
    }
}
struct Idler(Ripple);
impl Model for Idler {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = 0.2 + 0.4 * self.0.value(u[0], Side::After) - 0.3 * v[0] - Hertz.force(q[0], v[0], -1.0, 1.0);
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        let force = Hertz.force(q[0], v[0], -1.0, 1.0);
        out[0] = Contact { deflection: q[0], rate: v[0], lower: -1.0, upper: 1.0, force, ..Contact::default() };
    }
}
impl Periodic for Idler {
    fn period(&self) -> f64 {
        std::f64::consts::TAU / self.0.0
    }
}
fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("{:>9} {:>11} {:>12} {:>8} {:>7}", "frequency", "state", "peak-to-peak", "apart", "period");
    for omega in [0.3, 0.6, 1.2, 2.4] {
        let idler = Idler(Ripple(omega));
        let steady = Settle::new().run(&Dop853::new(), &idler, &State::new(0.0, &[1.2], &[0.0]))?;
        let (mut rattle, mut statistics) = (Rattle::new(&idler), Statistics::new(&idler, &["deflection"])?);
        let end = steady.state.t + steady.period_multiple as f64 * idler.period();
        Dop853::new().run(&idler, &steady.state, end, &mut (&mut rattle, &mut statistics))?;
        let (contact, d) = (rattle.contact(0), statistics.summary("deflection")?);
        let (state, apart) = (contact.state().to_string(), 100.0 * contact.loss_fraction());
        println!("{omega:9} {state:>11} {:12.4} {apart:7.1}% {:7}", d.peak_to_peak(), steady.period_multiple);
    }
    Ok(())
}
