//! The stored form of why a branch ends.

use crate::branches::branch::BranchEnd;

/// Ends with an error or a limit are stored as their text.
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "BranchEnd")]
pub(crate) enum StoredEnd {
    Open,
    Bound,
    Closed,
    Stop { contact: usize },
    Points { limit: usize },
    Other { reason: String },
}

impl From<BranchEnd> for StoredEnd {
    fn from(end: BranchEnd) -> Self {
        match end {
            BranchEnd::Open => StoredEnd::Open,
            BranchEnd::Bound => StoredEnd::Bound,
            BranchEnd::Closed => StoredEnd::Closed,
            BranchEnd::Stop { contact } => StoredEnd::Stop { contact },
            BranchEnd::Points { limit } => StoredEnd::Points { limit },
            other => StoredEnd::Other { reason: other.to_string() },
        }
    }
}

impl From<StoredEnd> for BranchEnd {
    fn from(end: StoredEnd) -> Self {
        match end {
            StoredEnd::Open => BranchEnd::Open,
            StoredEnd::Bound => BranchEnd::Bound,
            StoredEnd::Closed => BranchEnd::Closed,
            StoredEnd::Stop { contact } => BranchEnd::Stop { contact },
            StoredEnd::Points { limit } => BranchEnd::Points { limit },
            StoredEnd::Other { reason } => BranchEnd::Stored { reason },
        }
    }
}
