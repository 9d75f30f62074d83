//! The interface between the equations of a balance and a way of integrating the accelerations.

use crate::model::couplings::Couplings;
use crate::model::slopes::Slopes;
use crate::periodic::balance::integrals::Integrals;
use crate::periodic::balance::series::assembly::Layout;
use crate::periodic::balance::series::grid::Grid;
use crate::periodic::balance::series::spectra::Spectra;
use crate::periodic::balance::switching::instants::Switching;
use crate::roots::matrix::Matrix;

/// The motion along which the integrals are taken.
pub(crate) struct Motion<'a, 'm, M: ?Sized> {
    /// Drives, coordinates and velocities at uniform samples.
    pub(crate) grid: &'a mut Grid<'m, M>,
    /// Switches of the motion, located if the integration asks for them.
    pub(crate) switching: &'a Switching,
    /// Pattern of the Jacobian of the accelerations.
    pub(crate) couplings: &'a Couplings,
    /// Fourier coefficients of the coordinates, one list after the other.
    pub(crate) coefficients: &'a [f64],
}

/// How a balance finds out whether the integrals are fine enough.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Check {
    /// The integrals are exact, or other notes cover them.
    Unnecessary,
    /// By the accelerations between the samples, then by twice as many samples.
    BetweenSamples,
    /// By integrals twice as fine.
    Finer,
}

/// A way of integrating: gives the Fourier coefficients of the accelerations along a motion,
/// a_k = (2/T) ∫ a(u(t), q(t), q'(t)) e^{-ikωt} dt, and those of their slopes.
pub(crate) trait Integration<M: ?Sized> {
    /// The public name of this way, on a grid of so many samples.
    fn integrals(&self, samples: usize) -> Integrals;

    /// Whether switches must be located before each evaluation. Default: yes.
    fn follows_switches(&self) -> bool {
        true
    }

    /// How the resolution is checked.
    fn check(&self) -> Check;

    /// The accelerations at the uniform samples (coordinate x sample), if nothing but these is integrated.
    fn plain_samples(&self) -> Option<&[Vec<f64>]> {
        None
    }

    /// Writes the coefficients of the accelerations.
    fn accelerations(&mut self, motion: &mut Motion<'_, '_, M>, out: &mut Spectra);

    /// Writes the coefficients of the periodic slopes and the jumps at switches. `accelerations` was called for
    /// the same motion before.
    fn slopes(&mut self, motion: &mut Motion<'_, '_, M>, slopes: &mut Slopes<'_, M>, out: &mut Spectra);

    /// Adds to the Jacobian what the products of slopes do not contain. Default: nothing.
    fn add_jacobian(&self, _layout: &Layout, _out: &mut Matrix) {}
}
