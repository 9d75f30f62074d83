//! Serialisation by `serde` of types whose parts must fit together: a stored form, checked when it is read.

pub(crate) mod branch_end;
pub(crate) mod certificates;
pub(crate) mod figures;
pub(crate) mod lines;
pub(crate) mod orbit_series;
pub(crate) mod row_figures;
pub(crate) mod rows;
pub(crate) mod shooting;
pub(crate) mod sweep_points;
