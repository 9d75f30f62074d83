//! Contact laws: pieces and edges against the law itself, impacts in closed form, every edge of a law with
//! inner kinks.

use crate::api::*;
use approx::assert_relative_eq;
use std::f64::consts::PI;
use std::ops::ControlFlow;

use crate::data;

/// m x'' = -k f(x, x'): a mass on a contact law. Each inner kink of the law is a contact after the first one.
struct Mass<N> {
    law: N,
    mass: f64,
    stiffness: f64,
}

impl<N: Nonlinearity> Mass<N> {
    fn edges(&self) -> Edges {
        self.law.edges(0.0, Side::After)
    }
}

impl<N: Nonlinearity> Mass<N> {
    /// Writes the contact, then one for each inner kink.
    fn tell(&self, x: f64, rate: f64, out: &mut [Contact]) {
        let Edges { lower, upper, .. } = self.edges();
        let force = self.stiffness * self.law.force(self.edges().at(x, rate));
        out[0] = Contact { deflection: x, rate, lower, upper, force, ..Contact::default() };
        for k in 0..self.law.kinks() {
            out[1 + k] = Contact { deflection: self.law.kink(k, x, rate), ..out[0] };
        }
    }
}

impl<N: Nonlinearity> Model for Mass<N> {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, _: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = -self.stiffness / self.mass * self.law.force(self.edges().at(q[0], v[0]));
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: true, kinks: self.law.kinks(), ..Offers::default() }
    }
    fn contacts(&self) -> usize {
        1 + self.law.kinks()
    }
    fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        self.tell(q[0], v[0], out);
    }
    fn accel_on_pieces(&self, pieces: &[Piece], _: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let force = self.law.force_on(pieces[0], &pieces[1..], self.edges().at(q[0], v[0]));
        a[0] = -self.stiffness / self.mass * force;
    }
}

/// The crossings until `end`, with the states at them.
fn crossings<N: Nonlinearity>(
    solver: &impl Integrator,
    model: &Mass<N>,
    start: &State,
    end: f64,
) -> Vec<(Crossing, State)> {
    let mut seen = Vec::new();
    let mut watch = |step: &mut Step<'_>| {
        let state = State::new(step.t1(), step.q1(), step.v1());
        seen.extend(step.crossings().iter().map(|c| (*c, state.clone())));
        ControlFlow::Continue(())
    };
    solver.run(model, start, end, &mut watch).unwrap();
    seen
}

/// A solver of tight tolerance.
fn fine() -> Dop853 {
    Dop853::new().rtol(1e-13).atol(1e-13)
}

/// The speed of a mass after an impact on the upper flank at `speed`, and the duration of the contact.
fn impact<N: Nonlinearity>(law: N, mass: f64, stiffness: f64, speed: f64, long: f64) -> (f64, f64) {
    let model = Mass { law, mass, stiffness };
    let upper = model.edges().upper;
    let seen = crossings(&fine(), &model, &State::new(0.0, &[upper - 0.1], &[speed]), 0.1 / speed + long);
    let touches: Vec<&State> = seen.iter().filter(|(c, _)| c.contact == 0).map(|(_, s)| s).collect();
    assert_relative_eq!(touches[0].t, 0.1 / speed, epsilon = 1e-11);
    (-touches[1].v[0], touches[1].t - touches[0].t)
}

#[test]
fn elastic_impacts_on_powers() {
    // Exponent p: depth d = (m v² (p + 1)/(2 k))^(1/(p + 1)), duration 2 d/v ∫ du/√(1 - u^(p + 1)).
    let (mass, stiffness, speed) = (1.3, 20.0, 0.7);
    for p in [1.0, 10.0 / 9.0, 1.5, 2.0, 3.0] {
        for reference in [1.0, 0.25] {
            let n = p + 1.0;
            let per_power = stiffness * reference * f64::powf(reference, -p);
            let depth = (mass * speed * speed * n / (2.0 * per_power)).powf(1.0 / n);
            let time =
                2.0 * depth / speed * PI.sqrt() * libm::tgamma(1.0 + 1.0 / n) / libm::tgamma(0.5 + 1.0 / n);
            let (away, took) = impact(PowerLaw::new(0.2, p, reference).unwrap(), mass, stiffness, speed, 3.0);
            assert_relative_eq!(away, speed, max_relative = 1e-10);
            assert_relative_eq!(took, time, max_relative = 1e-10);
        }
    }
}

#[test]
fn hunt_and_crossley_restitution_is_that_of_its_first_integral() {
    // λ v - ln(1 + λ v) has equal values at the start and, with v reversed, at the end of the contact, for
    // any exponent. For small λ v it gives 1 - e = 2 λ v/3.
    for (p, loss, speed) in [(1.0, 0.3, 0.8), (1.5, 0.3, 0.8), (1.5, 2.0, 1.0), (10.0 / 9.0, 1e-3, 1.0)] {
        let law = Damped::by_force(PowerLaw::new(0.1, p, 1.0).unwrap(), loss).unwrap();
        let (away, _) = impact(law, 2.0, 50.0, speed, 3.0);
        let integral = |v: f64| loss * v - (loss * v).ln_1p();
        assert_relative_eq!(integral(speed), integral(-away), max_relative = 1e-9, epsilon = 1e-15);
        if loss * speed < 0.01 {
            // The next term is λ v/9.
            assert_relative_eq!(1.0 - away / speed, 2.0 / 3.0 * loss * speed, max_relative = 2e-3);
        }
    }
}

#[test]
fn damping_by_stiffness_has_the_restitution_of_a_damped_half_wave() {
    let (mass, stiffness, time, speed) = (2.0, 50.0, 0.04, 0.8);
    let omega = f64::sqrt(stiffness / mass);
    let zeta = 0.5 * time * omega;
    let nu = (1.0 - zeta * zeta).sqrt();
    let law = Damped::by_stiffness(Backlash::new(0.1).unwrap(), time).unwrap();
    let (away, took) = impact(law, mass, stiffness, speed, 3.0);
    assert_relative_eq!(away, speed * (-PI * zeta / nu).exp(), max_relative = 1e-10);
    assert_relative_eq!(took, PI / (omega * nu), max_relative = 1e-10);
    // A stop on one side has the same law.
    let stop = Damped::by_stiffness(AsymmetricBacklash::stop_above(0.1).unwrap(), time).unwrap();
    assert_relative_eq!(impact(stop, mass, stiffness, speed, 3.0).0, away, max_relative = 1e-12);
    let mirrored = Mass {
        law: Damped::by_stiffness(AsymmetricBacklash::stop_below(-0.1).unwrap(), time).unwrap(),
        mass,
        stiffness,
    };
    let seen = crossings(&fine(), &mirrored, &State::new(0.0, &[0.4], &[-speed]), 3.0);
    assert_relative_eq!(seen[1].1.v[0], away, max_relative = 1e-10);
}

/// The piece on which a law stands, and those of its inner kinks.
fn pieces<N: Nonlinearity>(law: &N, x: f64, rate: f64) -> (Piece, Vec<Piece>) {
    let Edges { lower, upper, .. } = law.edges(0.0, Side::After);
    let piece = |deflection| Contact { deflection, lower, upper, ..Contact::default() }.piece();
    (piece(x), (0..law.kinks()).map(|k| piece(law.kink(k, x, rate))).collect())
}

/// Checks that a law on its own pieces equals the law, that each piece continues smoothly past its edges, and
/// that lanes give the same bits.
fn fits_together<N: Nonlinearity>(law: &N) {
    let edges @ Edges { lower, upper, .. } = law.edges(0.0, Side::After);
    let middle = [lower, upper].into_iter().filter(|e| e.is_finite()).sum::<f64>() / 2.0;
    let grid = |i: usize| 0.37 * (i as f64 - 20.0) + 1e-3;
    for (x, rate) in (0..1681).map(|i| (middle + grid(i / 41), grid(i % 41))) {
        let (piece, kinks) = pieces(law, x, rate);
        let (held, free) = (law.force_on(piece, &kinks, edges.at(x, rate)), law.force(edges.at(x, rate)));
        assert!((held - free).abs() <= 1e-14 * free.abs(), "{x} {rate}: {held} {free}");
        let lanes = |x: f64| Lanes([x, -x, 0.5 * x]);
        let plain = [1.0, -1.0, 0.5].map(|s| law.force(edges.at(s * x, s * rate)));
        assert_eq!(
            law.force(Edges::at_rest(lower, upper).at(lanes(x), lanes(rate))).0.map(f64::to_bits),
            plain.map(f64::to_bits)
        );
    }
    for edge in [lower, upper].into_iter().filter(|edge| edge.is_finite()) {
        for piece in [Piece::Lower, Piece::Gap, Piece::Upper] {
            let kinks = vec![piece; law.kinks()];
            let force = |x: f64| law.force_on(piece, &kinks, edges.at(x, 0.3));
            let [left, right] = [-1e-7, 1e-7].map(|h| (force(edge + h) - force(edge)) / h);
            // A kink of the dead zone would give a difference of 1.
            assert!((left - right).abs() < 1e-2, "{piece:?} {left} {right}");
            // For y^(10/9) one-sided differences still contain (1e-7)^(1/9) = 0.17.
            let dual = Edges::at_rest(lower, upper).at(Dual::variable(edge), 0.3.into());
            let slope = law.force_on(piece, &kinks, dual).slope[0];
            assert!(slope.is_finite() && (slope - left).abs() < 0.2);
        }
    }
}

#[test]
fn pieces_fit_together() {
    let gap = Backlash::new(0.8).unwrap();
    fits_together(&gap);
    fits_together(&AsymmetricBacklash::stop_above(0.4).unwrap());
    fits_together(&AsymmetricBacklash::stop_below(-0.4).unwrap());
    for p in [1.0, 10.0 / 9.0, 1.5, 2.5] {
        let power = PowerLaw::new(0.8, p, 1.6).unwrap();
        fits_together(&power);
        fits_together(&power.with_edges(f64::NEG_INFINITY, 0.7).unwrap());
        fits_together(&power.with_edges(-0.2, f64::INFINITY).unwrap());
        fits_together(&Damped::by_force(power, 0.2).unwrap());
        fits_together(&MixedLaw::<Linear>::Power(power));
    }
    fits_together(&Damped::by_stiffness(gap, 0.3).unwrap());
    fits_together(&Damped::by_stiffness_always(gap, 0.3).unwrap());
    fits_together(&Damped::by_stiffness(Linear, 0.3).unwrap());
    let no_pull = NoPullBacklash::new(0.8, 0.3).unwrap();
    assert_eq!(no_pull.kinks(), 2);
    fits_together(&MixedLaw::<Linear>::NoPull(no_pull));
    fits_together(&Damped::by_force(no_pull, 0.2).unwrap());
}

#[test]
fn no_pull_backlash_to_its_exact_times() {
    let reference = &data::read("trains.json")["no_pull_backlash"];
    let [inertia, stiffness, damping, width, phi0] =
        ["J", "c", "d", "b_total", "phi0"].map(|name| reference["params"][name].as_f64().unwrap());
    let exact = |name: &str| reference["exact"][name].as_f64().unwrap();
    let model = Mass {
        law: NoPullBacklash::new(0.5 * width, damping / stiffness).unwrap(),
        mass: inertia,
        stiffness,
    };
    let start = State::new(0.0, &[phi0], &[0.0]);
    for solver in [Dop853::new().rtol(1e-12).atol(1e-12), fine()] {
        let seen = crossings(&solver, &model, &start, 0.11);
        let met = |contact: usize, from: Piece, to: Piece| {
            &seen.iter().find(|(c, _)| *c == Crossing { contact, from, to, rebounds: false }).unwrap().1
        };
        let (touch, ends, limited) = (0, 1, 2);
        use Piece::{Gap, Lower, Upper};
        for (name, state) in [
            ("t_torque_zero", met(ends, Upper, Gap)),
            ("t_leave", met(touch, Upper, Gap)),
            ("t_back_contact", met(touch, Gap, Lower)),
            ("t_damping_limit_ends", met(limited, Gap, Lower)),
            ("t_torque_zero_back", met(ends, Lower, Gap)),
            ("t_leave_back", met(touch, Lower, Gap)),
            ("t_front_again", met(touch, Gap, Upper)),
        ] {
            assert!((state.t - exact(name)).abs() < 1e-12, "{name}: {} {}", state.t, exact(name));
        }
        assert_relative_eq!(met(ends, Upper, Gap).q[0], exact("phi_torque_zero"), epsilon = 1e-10);
        assert_relative_eq!(met(ends, Upper, Gap).v[0], exact("w_gap"), epsilon = 1e-9);
        assert_relative_eq!(met(ends, Lower, Gap).v[0], exact("w_gap_2"), epsilon = 1e-9);
        // The turning point, by Newton's method on the velocity.
        let mut turn = 0.06;
        for _ in 0..6 {
            let (state, mut a) = (solver.end(&model, &start, turn).unwrap(), [0.0]);
            model.accel(&[turn], &state.q, &state.v, &mut a);
            turn -= state.v[0] / a[0];
        }
        assert!((turn - exact("t_phi_min")).abs() < 1e-12, "{turn}");
        assert_relative_eq!(
            solver.end(&model, &start, turn).unwrap().q[0],
            exact("phi_min"),
            epsilon = 1e-10
        );
    }
}

/// The same mass with excitation and damping: m x'' = -k f(x, x') - 0.05 x' + load + 1.5 cos 1.1 t, m = 1.
struct Driven {
    of: Mass<NoPullBacklash>,
    load: f64,
}

impl Driven {
    fn drive(&self, t: f64, v: f64) -> f64 {
        self.load + 1.5 * (1.1 * t).cos() - 0.05 * v
    }
}

impl Model for Driven {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.of.accel(u, q, v, a);
        a[0] += self.drive(u[0], v[0]);
    }
    fn offers(&self) -> Offers<'_> {
        self.of.offers()
    }
    fn contacts(&self) -> usize {
        self.of.contacts()
    }
    fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        self.of.tell(q[0], v[0], out);
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.of.accel_on_pieces(pieces, u, q, v, a);
        a[0] += self.drive(u[0], v[0]);
    }
}

impl Periodic for Driven {
    fn period(&self) -> f64 {
        2.0 * PI / 1.1
    }
}

#[test]
fn inner_kinks_serve_flows_and_shooting() {
    let law = NoPullBacklash::new(0.4, 0.15).unwrap();
    let model = Driven { of: Mass { law, mass: 1.0, stiffness: 6.0 }, load: 0.4 };
    for typical in
        [State::new(0.0, &[0.9], &[1.0]), State::new(0.0, &[0.9], &[-6.0]), State::new(0.0, &[-0.2], &[0.4])]
    {
        assert_eq!(check_periodic(&model, &typical), []);
    }
    // The derivative of the flow against differences of the flow (Richardson extrapolation).
    let (start, end) = (State::new(0.0, &[0.7], &[0.4]), 9.0);
    let flow = Variation::new().run(&model, &start, end).unwrap();
    assert!(flow.crossings >= 12, "{}", flow.crossings);
    for j in 0..2 {
        let moved = |h: f64| {
            let mut from = start.clone();
            *if j == 0 { &mut from.q[0] } else { &mut from.v[0] } += h;
            let end = fine().end(&model, &from, end).unwrap();
            [end.q[0], end.v[0]]
        };
        let [far, near] = [1e-4, 5e-5].map(|h| (moved(h), moved(-h), 2.0 * h));
        for i in 0..2 {
            let [far, near] = [far, near].map(|(above, below, width)| (above[i] - below[i]) / width);
            assert_relative_eq!((4.0 * near - far) / 3.0, flow.matrix[(i, j)], epsilon = 1e-8);
        }
    }
    // A periodic orbit, its crossings and its rattle state.
    let settled = fine().end(&model, &start, 60.0 * model.period()).unwrap();
    let orbit = Shooting::new().solve(&model, &[State { t: 0.0, ..settled }]).unwrap();
    let around = fine().end(&model, &orbit.states()[0], model.period()).unwrap();
    assert_relative_eq!(around.q[0], orbit.states()[0].q[0], epsilon = 1e-10);
    let mut rattle = Rattle::new(&model);
    fine().run(&model, &orbit.states()[0], model.period(), &mut rattle).unwrap();
    assert_eq!((orbit.crossing_count(), rattle.contacts()[0].rattle_state()), (12, RattleState::Bilateral));
    // The harmonic balance converges to this orbit.
    for integrals in [Integrals::Exact, Integrals::Kinks, Integrals::Panels] {
        let gap = [20, 40, 80].map(|orders| {
            let harmonics = Harmonics::up_to(orders);
            let guess = FourierOrbit::project(&fine(), &model, &orbit.states()[0], &harmonics).unwrap();
            let balanced = Balance::new(harmonics).integrals(integrals).solve(&model, &guess).unwrap();
            (balanced.at(0.0).q[0] - orbit.states()[0].q[0]).abs()
        });
        // The coefficients fall with the fourth power of the order, since the force has kinks.
        assert!(gap.windows(2).all(|g| g[1] < g[0] / 6.0) && gap[2] < 1e-6, "{integrals:?} {gap:?}");
    }
}

#[test]
fn no_pull_loses_what_viscous_damping_does_where_both_are_weak() {
    for time in [1e-3, 1e-4] {
        let (away, _) = impact(NoPullBacklash::new(0.1, time).unwrap(), 2.0, 50.0, 1.0, 3.0);
        // The next term is about 3 ζ, with ζ = 2.5 τ.
        assert_relative_eq!(1.0 - away, 0.5 * PI * time * 5.0, max_relative = 10.0 * time);
    }
}
