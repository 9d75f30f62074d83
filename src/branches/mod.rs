//! Branches of periodic orbits: continuation, located bifurcations.

pub(crate) mod balance_branches;
pub(crate) mod between;
pub(crate) mod beyond;
pub(crate) mod border;
pub(crate) mod boundary;
pub(crate) mod branch;
pub(crate) mod continuation;
pub(crate) mod curve;
pub(crate) mod design;
pub(crate) mod family;
pub(crate) mod following;
pub(crate) mod grazings;
pub(crate) mod orbits;
pub(crate) mod points;
pub(crate) mod sensitivity;
pub(crate) mod stability_method;
pub(crate) mod stops;
pub(crate) mod switching;
pub(crate) mod tracker;
pub(crate) mod within;

pub use crate::branches::boundary::boundary_line::{BoundaryLine, BoundaryPoint, Turn};
pub use crate::branches::boundary::following_boundary::FollowingBoundary;
pub use crate::branches::boundary::plane::{ByConstants, ByFunctionOfTwo, Plane};
pub use crate::branches::branch::{Branch, BranchEnd, BranchError, BranchNote};
pub use crate::branches::continuation::Continuation;
pub use crate::branches::curve::equations::CurveError;
pub use crate::branches::design::fit::Fit;
pub use crate::branches::design::least::{Least, Optimum};
pub use crate::branches::design::objective::{DesignError, Figure};
pub use crate::branches::family::{ByConstant, ByFunction, Family};
pub use crate::branches::following::Following;
pub use crate::branches::points::branch_point::BranchPoint;
pub use crate::branches::points::kind::PointKind;
pub use crate::branches::sensitivity::sensitivity_of_orbit::Sensitivity;
pub use crate::branches::stability_method::StabilityMethod;
