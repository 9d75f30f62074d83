//! The closed-loop gear ring of Yao 2020.

pub mod forces;
pub mod ring;
