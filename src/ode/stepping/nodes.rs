//! The drives at the nodes of a step.

/// The drives at the nodes of a step, one row for each. The last node is the end of the step, where the
/// drives are those before a jump.
///
/// The rows may belong to several consecutive steps. Sines and cosines of many instants at once take hardly
/// longer than those of one instant.
pub(crate) struct Nodes {
    rows: Vec<f64>,
    drives: usize,
    /// Number of nodes in a step.
    nodes: usize,
    /// The instants of all rows; NaN for rows without a meaning.
    times: Vec<f64>,
    /// First row of the current step.
    first: usize,
}

impl Nodes {
    /// Drives `u` at each of `nodes` nodes of a step, with room for `steps` steps.
    pub(super) fn new(u: &[f64], nodes: usize, steps: usize) -> Self {
        let rows = steps * nodes;
        Nodes { rows: u.repeat(rows), drives: u.len(), nodes, times: vec![f64::NAN; rows], first: 0 }
    }
    /// Drives at a node.
    #[inline(always)]
    pub(crate) fn at(&self, node: usize) -> &[f64] {
        &self.rows[self.drives * (self.first + node)..][..self.drives]
    }
    /// Drives at the end of the step, before a jump there.
    #[inline(always)]
    pub(crate) fn end(&self) -> &[f64] {
        self.at(self.nodes - 1)
    }
    /// Drives at the end of the step, mutable. The rows of later steps lose their meaning.
    pub(super) fn end_mut(&mut self) -> &mut [f64] {
        self.times.fill(f64::NAN);
        &mut self.rows[self.drives * (self.first + self.nodes - 1)..][..self.drives]
    }
    /// Whether the rows of the current step, or those after them, have these instants. They then are the rows
    /// of the current step.
    #[inline(always)]
    pub(super) fn select(&mut self, times: &[f64]) -> bool {
        for first in [self.first, self.first + self.nodes] {
            if self.times.get(first..first + self.nodes).is_some_and(|known| known == times) {
                self.first = first;
                return true;
            }
        }
        false
    }
    /// All rows, for the instants of one step that no other step shares.
    #[inline(always)]
    pub(super) fn rows_mut(&mut self) -> &mut [f64] {
        &mut self.rows
    }
    /// Whether the drives of the step after the current one are known.
    #[inline(always)]
    pub(super) fn has_next(&self) -> bool {
        self.times.get(self.first + self.nodes).is_some_and(|time| !time.is_nan())
    }
    /// The rows for these instants, a whole number of steps. The first step becomes the current one.
    #[inline(always)]
    pub(super) fn fill(&mut self, times: &[f64]) -> &mut [f64] {
        self.first = 0;
        self.times[..times.len()].copy_from_slice(times);
        self.times[times.len()..].fill(f64::NAN);
        &mut self.rows[..self.drives * times.len()]
    }
}
