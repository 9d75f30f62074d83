//! Elements of SVG, widths of text, small pictures of cells.

pub(crate) mod png;
pub(crate) mod text;
pub(crate) mod writer;
