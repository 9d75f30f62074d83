//! Uniform samples of the accelerations on fixed pieces, for linearised orbits and their Jacobian.

use crate::contact::piece::Piece;
use crate::model::equations::Periodic;
use crate::model::slopes::Slopes;
use crate::periodic::balance::integrals::Integrals;
use crate::periodic::balance::integration::integration_trait::{Check, Integration, Motion};
use crate::periodic::balance::series::spectra::{Samples, Spectra};

/// Integration on uniform samples, with every contact on a fixed piece.
pub(crate) struct OnFixedPieces {
    pub(crate) samples: Samples,
    /// The piece of every contact.
    pub(crate) pieces: Vec<Piece>,
}

impl<M: Periodic + ?Sized> Integration<M> for OnFixedPieces {
    fn integrals(&self, samples: usize) -> Integrals {
        Integrals::Sampled { samples }
    }
    fn follows_switches(&self) -> bool {
        false
    }
    fn check(&self) -> Check {
        Check::Unnecessary
    }
    fn accelerations(&mut self, motion: &mut Motion<'_, '_, M>, out: &mut Spectra) {
        self.samples.accelerate(motion.grid, Some(&self.pieces));
        self.samples.transform_accelerations(motion.grid, out);
    }
    fn slopes(&mut self, motion: &mut Motion<'_, '_, M>, slopes: &mut Slopes<'_, M>, out: &mut Spectra) {
        self.samples.differentiate(motion.grid, Some(&self.pieces), slopes, motion.couplings);
        self.samples.transform_slopes(motion.grid, out);
    }
}
