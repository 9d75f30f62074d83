//! s
use gear_dynamics::*;
fn main() {
    let mesh = |damping| {
        let set = RingSet { half_backlash: 1e-5, motor_torque: 8.0, ..RingSet::a(4, 3000.0) };
        let mut params = set.params().unwrap();
        params.meshes = params.meshes.into_iter().map(|mesh| mesh.with_contact_damping(damping)).collect();
        Ring::new(&params).unwrap().in_frame(Frame::Rigid)
    };
    for d in [ContactDamping::Always, ContactDamping::InContact] {
    let m = mesh(d);
    for end in [0.002, 0.005, 0.01, 0.02] {
        let run = |r: f64| Dop853::new().rtol(r).atol_each(&[vec![1e-5*r; 9], vec![1e-1*r; 9]].concat()).trajectory(&m, &State::at_rest(9), end).unwrap();
        let truth = run(1e-13);
        print!("{d:?} {end} {:?}: ", truth.stats());
        for r in [1e-8, 1e-9, 1e-10, 1e-11, 1e-12] {
            let x = run(r);
            let e = x.last().unwrap().v.iter().zip(&truth.last().unwrap().v).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
            print!("{e:.1e} ({}) ", x.stats().crossings);
        }
        println!();
    } }
}
