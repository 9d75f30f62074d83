//! What a model offers to [`Taylor`](crate::Taylor): its algebra as a tape, its drives as series.

pub(crate) mod every_piece;
pub(crate) mod expand;
