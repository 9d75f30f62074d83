//! An idler gear that rattles under a torque ripple, with a model, a contact law and an excitation of one's
//! own.
//!
//! The table states rattle state, peak-to-peak value of the deflection and contact loss at three frequencies
//! of the ripple. The picture shows the deflection over time with the gap shaded; `rattle.csv` contains the table.
//!
//! `cargo run --release -p examples --example custom_model`; everything is written to
//! target/gallery/custom_model/.

mod support;
use gear_dynamics::contact::{Contact, Deflection, Edges, Nonlinearity};
use gear_dynamics::excitation::{Angle, Excitation, Jet, Side};
use gear_dynamics::model::Scalar;
use gear_dynamics::ode::uniform_times;
use gear_dynamics::{Dop853, Integrator, Model, Rattle, State, Statistics, Wave};
use gear_dynamics_plots::{Picture, history};
use support::{Outcome, csv_file, gallery};

/// Hertzian contact: force p^1.5, with p the penetration past the half backlash.
#[derive(PartialEq)]
struct Hertz;
impl Nonlinearity for Hertz {
    fn force<S: Scalar>(&self, at: Deflection<S>) -> S {
        let push = |depth: S| depth.max(S::from(0.0)).powf(1.5);
        push(at.d - at.upper) - push(at.lower - at.d)
    }
}
/// A torque ripple with sharp peaks: s + s³/2 with s = sin φ.
#[derive(Debug, PartialEq)]
struct Ripple;
impl Excitation for Ripple {
    fn jet<A: Angle>(&self, angle: A) -> Jet<A::Number> {
        let wave = Jet::variable(angle.number()).sin();
        wave + wave * wave * wave * 0.5
    }
}
/// q'' = 0.2 + 0.4 r(ω t) - 0.3 q' - f(q), with the ripple r and half backlash 1.
struct Idler {
    ripple: Wave,
    omega: f64,
}
impl Model for Idler {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let ripple = self.ripple.value(self.omega * u[0], Side::After);
        a[0] = 0.2 + 0.4 * ripple - 0.3 * v[0] - Hertz.force(Edges::at_rest(-1.0, 1.0).at(q[0], v[0]));
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        let force = Hertz.force(Edges::at_rest(-1.0, 1.0).at(q[0], v[0]));
        out[0] =
            Contact { deflection: q[0], rate: v[0], lower: -1.0, upper: 1.0, force, ..Contact::default() };
    }
}
pub(crate) fn main() -> Outcome<()> {
    let folder = gallery("custom_model")?;
    let mut csv = csv_file(folder.join("rattle.csv"), "frequency,state,peak_to_peak,apart")?;
    let mut panels = Vec::new();
    for omega in [0.3, 0.6, 1.2] {
        let (idler, solver) = (Idler { ripple: Wave::new(Ripple), omega }, Dop853::new());
        let steady = solver.end(&idler, &State::new(0.0, &[1.2], &[0.0]), 300.0)?;
        let (mut rattle, mut statistics) = (Rattle::new(&idler), Statistics::new(&idler, &["deflection"])?);
        solver.run(&idler, &steady, 400.0, &mut (&mut rattle, &mut statistics))?;
        let (contact, d) = (rattle.contacts()[0], statistics.summary("deflection")?.peak_to_peak());
        let (state, apart) = (contact.rattle_state(), contact.loss_fraction());
        println!("frequency {omega}: {state}, peak-to-peak {d:.4}, contact loss {:.1}%", 100.0 * apart);
        csv.row(&[&omega, &state, &d, &apart])?;
        let run = solver.sample(&idler, &steady, &uniform_times(300.0, 340.0, 800)?)?;
        let panel = history(&idler, &run, "deflection [1]", 0)?.x("time t [1]")?;
        panels.push(panel.title(format!("ω = {omega}, rattle state: {state}")));
    }
    Ok(Picture::new(panels).panel_size(560.0, 220.0).save(folder.join("deflection.svg"))?)
}
