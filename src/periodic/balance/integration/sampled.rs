//! Uniform samples of the accelerations: the alternating frequency-time scheme.
//!
//! c_k - i s_k ≈ (2/M) Σ_n a(u(t_n), q(t_n), q'(t_n)) e^{-ikωt_n},   t_n = n pT/M. The mean c_0 is half of
//! this.

use crate::contact::Piece;
use crate::model::structure::slopes::Slopes;
use crate::periodic::balance::integrals::Integrals;
use crate::periodic::balance::integration::integration_trait::{Check, Integration, Motion};
use crate::periodic::balance::series::spectra::{Samples, Spectra};

/// Integration on uniform samples.
pub(crate) struct Sampled {
    samples: Samples,
    /// The piece on which each contact is fixed, for linearised orbits; `None`: by deflection.
    pieces: Option<Vec<Piece>>,
    check: Check,
}

impl Sampled {
    /// `contacts`: number of contacts. Samples of a contact law cause aliasing. The note `Aliased` reports
    /// it, so that no check of the resolution is needed.
    pub(crate) fn new(samples: Samples, contacts: usize) -> Self {
        let check = if contacts > 0 { Check::Unnecessary } else { Check::BetweenSamples };
        Sampled { samples, pieces: None, check }
    }

    /// With every contact on a fixed piece.
    pub(crate) fn on_pieces(samples: Samples, pieces: &[Piece]) -> Self {
        Sampled { samples, pieces: Some(pieces.to_vec()), check: Check::Unnecessary }
    }
}

impl Integration for Sampled {
    fn integrals(&self, samples: usize) -> Integrals {
        Integrals::Sampled { samples }
    }
    fn follows_crossings(&self) -> bool {
        false
    }
    fn check(&self) -> Check {
        self.check
    }
    fn plain_samples(&self) -> Option<&[Vec<f64>]> {
        self.pieces.is_none().then_some(&self.samples.accelerations[..])
    }
    fn accelerations(&mut self, motion: &mut Motion<'_, '_>, out: &mut Spectra) {
        self.samples.accelerate(motion.grid, self.pieces.as_deref());
        self.samples.transform_accelerations(motion.grid, out);
    }
    fn slopes(&mut self, motion: &mut Motion<'_, '_>, slopes: &mut Slopes<'_>, out: &mut Spectra) {
        self.samples.differentiate(motion.grid, self.pieces.as_deref(), slopes, motion.couplings);
        self.samples.transform_slopes(motion.grid, out);
    }
}
