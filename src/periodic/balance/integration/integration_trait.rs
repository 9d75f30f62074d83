//! The interface between the equations of a balance and a way of integrating the accelerations.

use crate::model::structure::couplings::Couplings;
use crate::model::structure::slopes::Slopes;
use crate::periodic::balance::crossings::instants::Crossings;
use crate::periodic::balance::integrals::Integrals;
use crate::periodic::balance::series::assembly::JacobianLayout;
use crate::periodic::balance::series::grid::Grid;
use crate::periodic::balance::series::spectra::Spectra;
use crate::roots::Matrix;

/// The motion along which the integrals are taken.
pub(crate) struct Motion<'a, 'm> {
    /// Drives, coordinates and velocities at uniform samples.
    pub(crate) grid: &'a mut Grid<'m>,
    /// Crossings of the motion. They are located only if [`Integration::follows_crossings`] is `true`.
    pub(crate) crossings: &'a Crossings,
    /// Pattern of the Jacobian of the accelerations.
    pub(crate) couplings: &'a Couplings,
    /// Fourier coefficients of the coordinates, one list after the other.
    pub(crate) coefficients: &'a [f64],
    /// Mean velocity of each coordinate. It is 0 unless the orbit drifts.
    pub(crate) speeds: &'a [f64],
}

/// Check whether the integrals are fine enough.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Check {
    /// No check: the integrals are exact, or another note reports their error.
    Unnecessary,
    /// Compares the accelerations between the samples with their interpolation. If they differ, compares the
    /// integrals with those of twice as many samples.
    BetweenSamples,
    /// Compares the integrals with integrals twice as fine.
    Finer,
}

/// A way of integration: computes the Fourier coefficients of the accelerations along a motion, and those of
/// their slopes.
///
/// c_k - i s_k = (2/(pT)) ∫ a(u(t), q(t), q'(t)) e^{-ikωt} dt over the period pT of the orbit. The mean c_0
/// is half of this.
pub(crate) trait Integration {
    /// The public name of this way of integration, on a grid of `samples` samples.
    fn integrals(&self, samples: usize) -> Integrals;

    /// Whether crossings must be located before each evaluation. Default: yes.
    fn follows_crossings(&self) -> bool {
        true
    }

    /// The check of the resolution.
    fn check(&self) -> Check;

    /// The accelerations at the uniform samples (coordinate x sample), if the integrals are sums over these
    /// alone. Default: `None`.
    fn plain_samples(&self) -> Option<&[Vec<f64>]> {
        None
    }

    /// Writes the coefficients of the accelerations.
    fn accelerations(&mut self, motion: &mut Motion<'_, '_>, out: &mut Spectra);

    /// Writes the coefficients of the periodic slopes, and the jumps at crossings. The caller has called
    /// `accelerations` for the same motion before.
    fn slopes(&mut self, motion: &mut Motion<'_, '_>, slopes: &mut Slopes<'_>, out: &mut Spectra);

    /// Whether the periodic slopes and the pattern of the couplings are used. Default: yes.
    fn needs_slopes(&self) -> bool {
        true
    }

    /// Follows a model with another parameter, of which the grid has the drives. `false` if it cannot.
    /// Default: nothing depends on the model.
    fn adapt<'m>(&mut self, _grid: &Grid<'m>, _couplings: &Couplings, _slopes: &mut Slopes<'m>) -> bool {
        true
    }

    /// A copy for another model, if results of this model are kept. Default: `None`, one integration serves
    /// any model.
    fn twin(&self) -> Option<Box<dyn Integration>> {
        None
    }

    /// Adds to the Jacobian the terms that do not follow from the periodic slopes. Default: none.
    fn add_jacobian(&self, _layout: &JacobianLayout, _out: &mut Matrix) {}
}
