//! The drives at the nodes of a step.

/// The drives at the nodes of a step, one row for each. The last node is the end of the step, where the drives
/// are those before a jump.
pub(crate) struct Nodes {
    rows: Vec<f64>,
    drives: usize,
}

impl Nodes {
    /// Drives `u` at each of `nodes` nodes.
    pub(super) fn new(u: &[f64], nodes: usize) -> Self {
        Nodes { rows: u.repeat(nodes), drives: u.len() }
    }
    /// Drives at a node.
    #[inline(always)]
    pub(crate) fn at(&self, node: usize) -> &[f64] {
        &self.rows[self.drives * node..][..self.drives]
    }
    /// Drives at the end of the step, before a jump there.
    #[inline(always)]
    pub(crate) fn end(&self) -> &[f64] {
        &self.rows[self.rows.len() - self.drives..]
    }
    /// Drives at the end of the step, mutable.
    pub(super) fn end_mut(&mut self) -> &mut [f64] {
        let start = self.rows.len() - self.drives;
        &mut self.rows[start..]
    }
    /// The rows of all nodes.
    #[inline(always)]
    pub(super) fn rows_mut(&mut self) -> &mut [f64] {
        &mut self.rows
    }
}
