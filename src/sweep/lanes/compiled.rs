//! The steps of a model in lanes as compiled code that is called through a pointer.

use crate::contact::Backlash;
use crate::model::Shape;
use crate::sweep::lanes::algebra::{Algebra, Shared};
use crate::sweep::lanes::drive_table::DriveTable;
use crate::sweep::lanes::instructions::InstructionSet;
use crate::sweep::lanes::kernel::{Bundle, Kernel, Sizes};
use crate::sweep::lanes::number::{Lanes, Number};
use crate::trains::TrainShape;
use std::any::Any;
use std::ops::Range;

/// The steps of a model with numbers `S`.
pub(crate) trait Advance<S: Number> {
    fn sizes(&self) -> Sizes;
    /// Makes steps of a period, counted from 0.
    fn advance(&self, table: &DriveTable, steps: Range<usize>, bundle: &mut Bundle<S>, set: InstructionSet);
}

/// An algebra, compiled where it is named.
pub(crate) struct Here<A>(pub(crate) A);

impl<S: Number, A: Algebra<S>> Advance<S> for Here<A> {
    fn sizes(&self) -> Sizes {
        Sizes::of(&self.0)
    }
    fn advance(&self, table: &DriveTable, steps: Range<usize>, bundle: &mut Bundle<S>, set: InstructionSet) {
        Kernel { algebra: &self.0, table, steps, bundle }.run(set);
    }
}

/// The steps of a shape, which is passed to them.
type Steps<S> = fn(&dyn Any, &DriveTable, Range<usize>, &mut Bundle<S>, InstructionSet);

/// Numbers for which the library may contain the steps of a shape
/// (`Shape::LANES`).
pub(crate) trait LaneNumber: Number {
    /// Whether it contains them.
    const IN_LIBRARY: bool;
    /// The steps of trains with backlash; `None` if the library does not contain them.
    fn steps_of_trains() -> Option<Steps<Self>>;
}

impl LaneNumber for f64 {
    const IN_LIBRARY: bool = true;
    fn steps_of_trains() -> Option<Steps<Self>> {
        Some(trains_alone())
    }
}

/// 16 lanes, the default, are in the library.
impl<const W: usize> LaneNumber for Lanes<W> {
    const IN_LIBRARY: bool = W == 16;
    fn steps_of_trains() -> Option<Steps<Self>> {
        // Of one type, if W is 16.
        (&trains_in_lanes() as &dyn Any).downcast_ref::<Steps<Self>>().copied()
    }
}

// They are not generic: their code stands in the library.
#[inline(never)]
fn trains_alone() -> Steps<f64> {
    steps::<TrainShape<Backlash>, f64>
}

#[inline(never)]
fn trains_in_lanes() -> Steps<Lanes<16>> {
    steps::<TrainShape<Backlash>, Lanes<16>>
}

fn steps<G: Shape, S: Number>(
    shape: &dyn Any,
    table: &DriveTable,
    steps: Range<usize>,
    bundle: &mut Bundle<S>,
    set: InstructionSet,
) {
    if let Some(shape) = shape.downcast_ref::<G>() {
        Kernel { algebra: &Shared(shape), table, steps, bundle }.run(set);
    }
}

/// A shape with its compiled steps.
pub(crate) struct Compiled<'m, G, S: Number> {
    shape: &'m G,
    steps: Steps<S>,
}

impl<'m, G: Shape, S: LaneNumber> Compiled<'m, G, S> {
    /// The steps of a shape: those in the library, if it contains them, else compiled here, in the program of
    /// the user. The condition is a constant, so that nothing is compiled twice.
    pub(crate) fn of(shape: &'m G) -> Self {
        let in_library =
            if const { G::LANES.is_library && S::IN_LIBRARY } { S::steps_of_trains() } else { None };
        let here = if const { G::LANES.is_library && S::IN_LIBRARY } { stay } else { steps::<G, S> };
        Compiled { shape, steps: in_library.unwrap_or(here) }
    }
}

/// Stands where the library contains the steps.
fn stay<S: Number>(_: &dyn Any, _: &DriveTable, _: Range<usize>, _: &mut Bundle<S>, _: InstructionSet) {}

impl<G: Shape, S: Number> Advance<S> for Compiled<'_, G, S> {
    fn sizes(&self) -> Sizes {
        Sizes::of::<S, _>(&Shared(self.shape))
    }
    fn advance(&self, table: &DriveTable, steps: Range<usize>, bundle: &mut Bundle<S>, set: InstructionSet) {
        (self.steps)(self.shape, table, steps, bundle, set);
    }
}
