//! What the motion of a lane is for.

pub(crate) mod row_task;
pub(crate) mod task;
