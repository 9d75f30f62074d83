//! The cell in which a path was read last.

use std::sync::Mutex;

/// What a path has drawn for the cell in which it was read last.
///
/// A run reads a cell at all nodes of a step, and often over several steps. What is kept changes no value: a
/// thread that finds it in use draws the cell itself.
pub(crate) struct LastCell<C>(Mutex<Option<(i64, C)>>);

impl<C: Copy> LastCell<C> {
    pub(crate) fn new() -> Self {
        LastCell(Mutex::new(None))
    }
    /// What `draw` returns for a cell.
    #[inline]
    pub(crate) fn of(&self, cell: i64, draw: impl FnOnce() -> C) -> C {
        let Ok(mut last) = self.0.try_lock() else { return draw() };
        match *last {
            Some((known, drawn)) if known == cell => drawn,
            _ => {
                let drawn = draw();
                *last = Some((cell, drawn));
                drawn
            }
        }
    }
}
