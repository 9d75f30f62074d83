//! What a model offers besides its accelerations.

use crate::model::equations::Constants;
use crate::model::expansion::expand::Expand;
use crate::model::laws::Laws;
use crate::model::terms::Terms;
use std::fmt;

/// The optional parts that a model implements. Default: none.
///
/// Solvers call [`accel_on_pieces`](crate::Model::accel_on_pieces), [`jacobian`](crate::Model::jacobian) and
/// [`impact`](crate::Model::impact) only where they are declared.
/// [`check_model`](crate::check::check_model) reports a part that is declared and not implemented, or
/// implemented and not declared.
///
/// ```
/// use gear_dynamics::{model::Offers, Model, NfgPair, NfgParams};
/// let pair = NfgPair::new(&NfgParams::table1())?; // a machine offers all but rigid stops
/// assert_eq!(pair.offers().constants.ok_or("constants")?.values()[0], 160.0); // the speed
/// assert!(pair.offers().pieces && pair.offers().stops.is_empty());
/// let floor = Offers { stops: &[[true, false]], ..Offers::default() };
/// assert!(!floor.pieces && floor.stops[0] == [true, false]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Default)]
pub struct Offers<'m> {
    /// The accelerations on fixed pieces: [`Model::accel_on_pieces`](crate::Model::accel_on_pieces). Without
    /// them solvers locate edges by repeating steps.
    pub pieces: bool,
    /// The Jacobian: [`Model::jacobian`](crate::Model::jacobian). Without it differences are used.
    pub jacobian: bool,
    /// Whether the lower and the upper edge of each contact are rigid stops:
    /// [`Model::impact`](crate::Model::impact). Contacts past the end of the list have no stop.
    pub stops: &'m [[bool; 2]],
    /// Number of contacts that are inner kinks of contact laws
    /// ([`Nonlinearity::kinks`](crate::contact::Nonlinearity::kinks)): the last ones. Their deflection is the
    /// value of the kink; their rate and force are not read. Solvers locate them like edges, and analysis
    /// leaves them out.
    pub kinks: usize,
    /// The model as one with named constants, for exact derivatives with respect to them.
    pub constants: Option<&'m dyn Constants>,
    /// The model as one that can be expanded into Taylor series, for [`Taylor`](crate::Taylor).
    pub expansion: Option<&'m dyn Expand>,
    /// The model as one that knows the terms of its accelerations, and with them its rounding errors. Without
    /// it they are estimated from slopes, in which terms may have cancelled.
    pub terms: Option<&'m dyn Terms>,
    /// The model as one that evaluates its contact laws apart from its accelerations, for
    /// [`Balance::truncated_forces`](crate::Balance::truncated_forces).
    pub laws: Option<&'m dyn Laws>,
}

impl fmt::Debug for Offers<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Offers")
            .field("pieces", &self.pieces)
            .field("jacobian", &self.jacobian)
            .field("stops", &self.stops)
            .field("kinks", &self.kinks)
            .field("constants", &self.constants.is_some())
            .field("expansion", &self.expansion.is_some())
            .field("terms", &self.terms.is_some())
            .field("laws", &self.laws.is_some())
            .finish()
    }
}

impl Offers<'_> {
    /// [`stops`](Offers::stops) with one entry for each of `contacts` contacts; empty without a stop.
    pub(crate) fn rigid_edges(&self, contacts: usize) -> Vec<[bool; 2]> {
        let stop = |i: usize| self.stops.get(i).copied().unwrap_or_default();
        if self.first_stop().is_some() { (0..contacts).map(stop).collect() } else { Vec::new() }
    }

    /// Number of contacts at which teeth may touch, the first ones of `contacts`.
    pub(crate) fn touching(&self, contacts: usize) -> usize {
        contacts.saturating_sub(self.kinks)
    }

    /// The first contact with a rigid stop. Methods that do not locate edges reject such a model.
    pub(crate) fn first_stop(&self) -> Option<usize> {
        self.stops.iter().position(|rigid| *rigid != [false; 2])
    }
}

#[cfg(test)]
mod tests {
    use crate::model::offers::Offers;

    #[test]
    fn stops_are_listed_for_all_contacts_or_for_none() {
        let stops = Offers { stops: &[[false; 2], [true, false]], ..Offers::default() };
        assert_eq!(stops.rigid_edges(3), [[false; 2], [true, false], [false; 2]]);
        assert_eq!(stops.first_stop(), Some(1));
        let none = Offers { stops: &[[false; 2]; 2], ..Offers::default() };
        assert!(none.rigid_edges(2).is_empty() && none.first_stop().is_none());
    }
}
