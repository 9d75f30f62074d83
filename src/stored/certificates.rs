//! The stored form of certificates.

use crate::certify::chain::proposal::Proposal;
use crate::certify::{Certificate, CertifiedCrossing, Disc, Interval};
use crate::error::{ParameterError, check};
use serde::de::{Deserialize, Deserializer, Error};

#[derive(serde::Deserialize)]
#[serde(rename = "Certificate")]
struct StoredCertificate {
    proposal: Proposal,
    radii: Vec<Vec<f64>>,
    constants: Vec<(String, Interval)>,
    period: Interval,
    crossings: Vec<CertifiedCrossing>,
    multipliers: Vec<Disc>,
}

impl<'de> Deserialize<'de> for Certificate {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let stored = StoredCertificate::deserialize(deserializer)?;
        stored.check().map_err(D::Error::custom)?;
        let StoredCertificate { proposal, radii, constants, period, crossings, multipliers } = stored;
        Ok(Certificate { proposal, radii, constants, period, crossings, multipliers })
    }
}

impl StoredCertificate {
    /// Whether all parts fit together. [`Certificate::check`] compares them with a model.
    fn check(&self) -> Result<(), ParameterError> {
        let Proposal { legs, nodes, relative_to } = &self.proposal;
        let Some((first, node)) = legs.first().zip(nodes.first()) else {
            return Err(ParameterError::Empty { name: "legs of the certificate".into(), min: 1 });
        };
        let (contacts, width) = (first.pieces.len(), node.len());
        check::length("nodes of the certificate", nodes.len(), legs.len())?;
        check::length("half widths of the boxes", self.radii.len(), legs.len())?;
        for (node, radii) in nodes.iter().zip(&self.radii) {
            check::length("coordinates and velocities of a node", node.len(), width)?;
            check::length("half widths of a box", radii.len(), width)?;
            check::all_finite("node", node)?;
            radii
                .iter()
                .try_for_each(|radius| check::above_zero("half width of a box", *radius).map(drop))?;
        }
        let crossed = legs.iter().flat_map(|leg| leg.crossings.iter().map(|crossing| crossing.contact));
        let crossings = self.crossings.iter().map(|crossing| crossing.contact);
        for contact in crossed.chain(crossings) {
            if contact >= contacts {
                return Err(ParameterError::NoSuchContact { contact, contacts });
            }
        }
        for leg in legs {
            check::length("pieces of a leg", leg.pieces.len(), contacts)?;
        }
        let bounds = |interval: Interval| [interval.low(), interval.high()];
        for interval in legs.iter().flat_map(|leg| [leg.start, leg.end]).chain([self.period]) {
            check::all_finite("time of the certificate", &bounds(interval))?;
        }
        check::scale("period of the certificate", self.period.low())?;
        // Relative coordinates leave one out.
        let most = if relative_to.is_some() { width / 2 } else { 0 };
        check::count("coordinate to which others are relative", &[relative_to.unwrap_or(0)], most)?;
        if !self.multipliers.is_empty() {
            check::length("discs of the multipliers", self.multipliers.len(), width)?;
        }
        Ok(())
    }
}
