//! The reference data of tests/data.

use serde_json::Value;

/// Reads a file of tests/data.
pub fn read(file: &str) -> Value {
    let path = format!("{}/../data/{file}", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}
