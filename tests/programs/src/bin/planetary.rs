//! A program of the pages.

include!(concat!(env!("OUT_DIR"), "/planetary.rs"));
