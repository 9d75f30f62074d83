//! Requirements of a balance on its model.

use crate::model::Periodic;
use crate::model::equations::lacks_pieces;
use crate::model::structure::rigid::rigid_motions;
use crate::periodic::balance::balance_error::BalanceError;

/// Rigid motions of a model.
///
/// Error: differences cannot decide whether a motion is rigid.
pub(crate) fn free_motions(model: &dyn Periodic) -> Result<Vec<Vec<f64>>, BalanceError> {
    let rigid = rigid_motions(model, model.period());
    rigid.doubtful.map_or(Ok(rigid.modes), |share| Err(BalanceError::BarelySupported { share }))
}

/// Error if the contacts of the model cannot be fixed on pieces, or are rigid stops.
pub(crate) fn admit_on_pieces(model: &dyn Periodic) -> Result<(), BalanceError> {
    model.offers().refuse_stops(|contact| BalanceError::RigidStop { contact })?;
    if lacks_pieces(model) { Err(BalanceError::NoPieces) } else { Ok(()) }
}
