//! What a proof begins with: a closed chain of legs along an orbit, in plain numbers.

pub(crate) mod marks;
pub(crate) mod proposal;
pub(crate) mod walk;
