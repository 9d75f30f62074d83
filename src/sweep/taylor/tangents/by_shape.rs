//! Jobs in lanes, for one shape of machines after the other.

use crate::model::{Machine, Model, Shape};
use crate::periodic::flow::tangent_tape::tangent;
use crate::sweep::taylor::program::Program;

/// Finds something for each job. Machines of equal shapes share lanes: `in_lanes` finds the entries of their
/// jobs, given by their indices. `one`: what finds the entry of a job that lanes do not run. `count`: number
/// of differences that the flow carries, from the number of degrees of freedom.
pub(crate) fn by_shape<'j, J, G: Shape + 'j, R>(
    jobs: &'j [J],
    machine: impl Fn(&'j J) -> &'j Machine<G>,
    count: impl Fn(usize) -> usize,
    mut in_lanes: impl FnMut(&Program, &[usize], &mut [Option<R>]),
    one: impl Fn(&J) -> Option<R>,
) -> Vec<Option<R>> {
    let mut found: Vec<Option<R>> = jobs.iter().map(|_| None).collect();
    let mut open: Vec<usize> = (0..jobs.len()).collect();
    while let Some(&first) = open.first() {
        let leader = machine(&jobs[first]);
        let (equal, others): (Vec<usize>, _) =
            open.iter().partition(|i| leader.shares_lanes_with(machine(&jobs[**i])));
        open = others;
        let tape = tangent(&leader.record_shape().0, count(leader.dof()), &[]);
        match Program::new(&tape, leader.size().waves, &[]) {
            Ok(program) => in_lanes(&program, &equal, &mut found),
            Err(_) => equal.into_iter().for_each(|i| found[i] = one(&jobs[i])),
        }
    }
    found
}
