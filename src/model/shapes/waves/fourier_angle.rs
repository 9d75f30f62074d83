//! The waves of a shape as finite Fourier series, by recording how they are computed.

use crate::error::check;
use crate::excitation::{Angle, Fourier, Jet, Side, Wave};
use crate::model::shapes::shape::Shape;
use crate::tape::form::Form;
use crate::tape::node::Node;
use crate::tape::operations::{Op, Tape};
use crate::tape::recording::Recording;

/// A finite Fourier series: mean, and order n, a and b of each term a cos nφ + b sin nφ, orders increasing.
pub(crate) type Harmonics = (f64, Vec<(usize, [f64; 2])>);

/// Slots of the recording before its operations: cos nφ at 2n - 2, sin nφ at 2n - 1.
const SLOTS: usize = 2 * check::ORDERS;

/// The waves of a shape without edges; `None` if one of them is no weighted sum of [`Wave`]s that are finite
/// Fourier series.
///
/// Products and functions of the angle in the shape itself are faster than their series and give `None`.
pub(crate) fn fourier_waves<G: Shape>(shape: &G) -> Option<Vec<Harmonics>> {
    if shape.next_edge(0.0).is_some() {
        return None;
    }
    let recording = Recording::new(0, SLOTS);
    let mut waves = vec![Node::from(0.0); shape.size().waves];
    shape.waves(FourierAngle { recording: &recording, times: 1.0 }, Side::After, &mut waves);
    let waves: Vec<_> = waves.into_iter().map(|wave| wave.form(&recording)).collect();
    let tape = recording.finish(Vec::new(), Vec::new());
    waves.into_iter().map(|wave| Some(harmonics(&whole_sum(&tape, &tape.forms[wave])?))).collect()
}

fn harmonics(form: &Form) -> Harmonics {
    let mut terms: Vec<(usize, [f64; 2])> = Vec::with_capacity(form.terms.len());
    for &(slot, weight) in &form.terms {
        let (order, part) = (slot as usize / 2 + 1, slot as usize % 2);
        if terms.last().is_none_or(|(last, _)| *last < order) {
            terms.push((order, [0.0; 2]));
        }
        if let Some((_, pair)) = terms.last_mut() {
            pair[part] = weight;
        }
    }
    (form.constant, terms)
}

/// A form without the slots of operations; `None` if one of them is no sum.
fn whole_sum(tape: &Tape, form: &Form) -> Option<Form> {
    if form.terms.iter().all(|(slot, _)| (*slot as usize) < SLOTS) {
        return Some(form.clone());
    }
    form.terms.iter().try_fold(Form::constant(form.constant), |sum, &(slot, weight)| {
        match (slot as usize).checked_sub(SLOTS).map(|op| &tape.ops[op].0) {
            None => Some(sum.plus(&Form::slot(slot), weight)),
            Some(Op::Sum(inner)) => Some(sum.plus(&whole_sum(tape, &tape.forms[*inner])?, weight)),
            Some(_) => None,
        }
    })
}

/// An angle φ multiplied by a factor, at which waves are recorded as sums of cos nφ and sin nφ.
#[derive(Clone, Copy, Debug)]
struct FourierAngle<'t> {
    recording: &'t Recording,
    times: f64,
}

impl<'t> FourierAngle<'t> {
    fn refused(self) -> Node<'t> {
        let kink = Op::Kink("an excitation without a finite Fourier series");
        Node::recorded(self.recording, self.recording.function(kink))
    }
    /// A series over the shaft angle, with the factors by which pairs (c_n, s_n) are multiplied.
    fn series(self, series: &Fourier, mean: f64, pair: impl Fn(f64, [f64; 2]) -> [f64; 2]) -> Node<'t> {
        let order = self.times as usize;
        if order as f64 != self.times || order == 0 || order * series.pairs().len() > check::ORDERS {
            return self.refused();
        }
        let pairs = (1..).zip(series.pairs()).flat_map(|(n, own)| {
            let place = 2 * (n * order - 1) as u32;
            [place, place + 1].into_iter().zip(pair(n as f64, *own))
        });
        let form = Form { constant: mean, terms: pairs.filter(|(_, weight)| *weight != 0.0).collect() };
        Node::recorded(self.recording, self.recording.keep(form))
    }
}

impl<'t> Angle for FourierAngle<'t> {
    type Number = Node<'t>;
    fn number(self) -> Node<'t> {
        self.refused()
    }
    fn times(self, factor: f64) -> Self {
        FourierAngle { times: factor * self.times, ..self }
    }
    fn by_function<const N: usize>(self, _: impl Fn(f64) -> [f64; N]) -> [Node<'t>; N] {
        [self.refused(); N]
    }
    fn by_pieces(self, _: impl Fn(f64, Node<'t>) -> Jet<Node<'t>>) -> Jet<Node<'t>> {
        Jet::constant(self.refused())
    }
    fn by_parts(self, _: usize, _: impl Fn(usize, Node<'t>) -> Jet<Node<'t>>) -> Jet<Node<'t>> {
        Jet::constant(self.refused())
    }
    fn value_of_fourier(self, of: &Fourier) -> Node<'t> {
        self.series(of, of.mean(), |_, pair| pair)
    }
    fn jet_of_fourier(self, of: &Fourier) -> Jet<Node<'t>> {
        Jet {
            value: self.series(of, of.mean(), |_, pair| pair),
            rate: self.series(of, 0.0, |n, [c, s]| [n * s, -n * c]),
            second: self.series(of, 0.0, |n, [c, s]| [-n * n * c, -n * n * s]),
        }
    }
    fn value_of(self, wave: &Wave, _: Side) -> Node<'t> {
        match wave.fourier() {
            Some(of) => self.value_of_fourier(&of),
            None => self.refused(),
        }
    }
    fn jet_of(self, wave: &Wave, _: Side) -> Jet<Node<'t>> {
        match wave.fourier() {
            Some(of) => self.jet_of_fourier(&of),
            None => Jet::constant(self.refused()),
        }
    }
}
