//! Branches of periodic orbits over a parameter.
//!
//! A [`Family`] says which constants vary, a [`Continuation`] how far and in which steps, a [`Start`] what
//! is followed. [`Branch`] is the result, with stability, folds and other bifurcations located
//! ([`PointKind`]); [`BoundaryLine`] is the line of one of them over two parameters. [`Switch`] goes to the
//! branch that crosses, [`Beyond`] to the one that returns from infinity. [`Sensitivity`] differentiates an
//! orbit by all constants; [`Fit`] finds constants from a measured response, [`Least`] those of the least
//! figure. The [guide page](crate::guide::branches) shows each.

pub(crate) mod border;
pub(crate) mod boundary;
pub(crate) mod branch;
pub(crate) mod branch_end;
pub(crate) mod branch_error;
pub(crate) mod continuation;
pub(crate) mod curve;
pub(crate) mod design;
pub(crate) mod family;
pub(crate) mod following;
pub(crate) mod line;
pub(crate) mod orbits;
pub(crate) mod points;
pub(crate) mod sensitivity;
pub(crate) mod stability_method;
pub(crate) mod starts;
pub(crate) mod steps;

pub use crate::branches::boundary::boundary_line::{BoundaryLine, BoundaryPoint, Turn};
pub use crate::branches::branch::Branch;
pub use crate::branches::branch_end::BranchEnd;
pub use crate::branches::branch_error::BranchError;
pub use crate::branches::continuation::Continuation;
pub use crate::branches::curve::equations::CurveError;
pub use crate::branches::design::fit::Fit;
pub use crate::branches::design::least::{Least, Optimum};
pub use crate::branches::design::objective::DesignError;
pub use crate::branches::design::search::Search;
pub use crate::branches::family::Family;
pub use crate::branches::following::Following;
pub use crate::branches::line::{BranchNote, Line};
pub use crate::branches::points::branch_point::BranchPoint;
pub use crate::branches::points::kind::{PointKind, SpecialPoint};
pub use crate::branches::sensitivity::figure::Figure;
pub use crate::branches::sensitivity::sensitivity_of_orbit::Sensitivity;
pub use crate::branches::stability_method::StabilityMethod;
pub use crate::branches::starts::beyond::Beyond;
pub use crate::branches::starts::start::Start;
pub use crate::branches::starts::switch::Switch;
