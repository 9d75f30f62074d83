//! Requirements of a balance on its model.

use crate::model::Periodic;
use crate::model::equations::lacks_pieces;
use crate::model::structure::drifts::Drifts;
use crate::periodic::balance::balance_error::BalanceError;

/// Drifts of a model. One coordinate alone that nothing resists has none: its equations are singular.
pub(crate) fn drifts(model: &dyn Periodic) -> Drifts {
    let found = Drifts::of(model, model.period());
    if found.speeds.len() == 1 && model.dof() == 1 { Drifts::default() } else { found }
}

/// Error if differences cannot decide whether a motion is rigid.
pub(crate) fn admit_drifts(drifts: &Drifts) -> Result<(), BalanceError> {
    drifts.doubtful.map_or(Ok(()), |share| Err(BalanceError::BarelySupported { share }))
}

/// Error if the contacts of the model cannot be fixed on pieces, or are rigid stops.
pub(crate) fn admit_on_pieces(model: &dyn Periodic) -> Result<(), BalanceError> {
    model.offers().refuse_stops(|contact| BalanceError::RigidStop { contact })?;
    if lacks_pieces(model) { Err(BalanceError::NoPieces) } else { Ok(()) }
}
