//! Motions that rest on the edge of a gap without width: an unloaded train without backlash is a spring.

use crate::api::*;
use gear_dynamics::linear::Modes;
use gear_dynamics::models::Oscillator;
use std::f64::consts::TAU;

#[test]
fn an_unloaded_contact_without_backlash_is_a_spring() {
    let (speed, damping, stiffness): (f64, f64, f64) = (0.7, 0.1, 2.0);
    let constants = [
        ("speed", speed),
        ("damping", damping),
        ("mesh stiffness", stiffness),
        ("half backlash", 0.0),
        ("force", 0.0),
    ];
    let model = Oscillator::new(&constants).unwrap();
    // λ² + cλ + s = 0.
    let frequency = (stiffness - 0.25 * damping * damping).sqrt();
    let turn = TAU / speed;
    let expected = num_complex::Complex64::from_polar((-0.5 * damping * turn).exp(), frequency * turn);
    let close = |found: &Multipliers| {
        for z in found.values() {
            let off = (z - expected).norm().min((z - expected.conj()).norm());
            assert!(off < 1e-9, "{z} for {expected}");
        }
    };
    let rest = State::at_rest(1);
    close(Shooting::new().solve(&model, &rest).unwrap().multipliers());
    let balance = Balance::new(Harmonics::up_to(5));
    let orbit = FourierOrbit::new(balance.harmonics(), model.period(), &[vec![0.0; 11]]).unwrap();
    close(&balance.multipliers(&model, &orbit).unwrap());
    let modes = Modes::about(&model, &rest, None).unwrap();
    assert!((modes.all()[0].square() - stiffness).abs() < 1e-12);
    let exponents = Lyapunov::new().settle(0).align(5).measure(20).run(&model, &rest).unwrap();
    // Their sum is the divergence, at any length of the run.
    assert!((exponents.values().iter().sum::<f64>() + damping).abs() < 1e-9);
}
