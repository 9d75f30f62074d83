//! Names and units.

use crate::error::ParameterError;

/// A quantity with a name and a unit that can be read from a model. Unit: `1` if dimensionless, empty if it
/// depends on the units of the model.
///
/// ```
/// let channel = gear_dynamics::model::Channel::new("mesh force", "N");
/// assert_eq!(channel.to_string(), "mesh force [N]");
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Channel {
    /// Name.
    pub name: String,
    /// Unit.
    pub unit: String,
}

impl Channel {
    /// A channel with the given name and unit.
    pub fn new(name: impl Into<String>, unit: impl Into<String>) -> Self {
        Channel { name: name.into(), unit: unit.into() }
    }
}

impl std::fmt::Display for Channel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.unit.is_empty() {
            f.write_str(&self.name)
        } else {
            write!(f, "{} [{}]", self.name, self.unit)
        }
    }
}

/// Index of a name in a list of constants.
pub(crate) fn index_of(names: &[Channel], name: &str) -> Result<usize, ParameterError> {
    names.iter().position(|channel| channel.name == name).ok_or_else(|| {
        let known: Vec<&str> = names.iter().map(|channel| channel.name.as_str()).collect();
        ParameterError::NoSuchConstant { name: name.into(), known: known.join(", ") }
    })
}
