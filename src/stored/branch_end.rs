//! The stored form of why a branch ends.

use crate::branches::BranchEnd;
use serde::de::{Deserialize, Deserializer};
use serde::ser::{Serialize, Serializer};

/// Ends with an error or a limit are stored as their text.
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "BranchEnd")]
enum StoredEnd {
    Open,
    Bound,
    Closed,
    Stop { contact: usize },
    SoftImpact { contact: usize },
    Unbounded { motion: f64, border: Option<f64> },
    Points { limit: usize },
    Other { reason: String },
}

impl Serialize for BranchEnd {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let stored = match *self {
            BranchEnd::Open => StoredEnd::Open,
            BranchEnd::Bound => StoredEnd::Bound,
            BranchEnd::Closed => StoredEnd::Closed,
            BranchEnd::Stop { contact } => StoredEnd::Stop { contact },
            BranchEnd::SoftImpact { contact } => StoredEnd::SoftImpact { contact },
            BranchEnd::Unbounded { motion, border } => StoredEnd::Unbounded { motion, border },
            BranchEnd::Points { limit } => StoredEnd::Points { limit },
            ref other => StoredEnd::Other { reason: other.to_string() },
        };
        stored.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for BranchEnd {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(match StoredEnd::deserialize(deserializer)? {
            StoredEnd::Open => BranchEnd::Open,
            StoredEnd::Bound => BranchEnd::Bound,
            StoredEnd::Closed => BranchEnd::Closed,
            StoredEnd::Stop { contact } => BranchEnd::Stop { contact },
            StoredEnd::SoftImpact { contact } => BranchEnd::SoftImpact { contact },
            StoredEnd::Unbounded { motion, border } => BranchEnd::Unbounded { motion, border },
            StoredEnd::Points { limit } => BranchEnd::Points { limit },
            StoredEnd::Other { reason } => BranchEnd::Stored { reason },
        })
    }
}
