//! The choice of a way of integration and of its samples.

use crate::contact::Piece;
use crate::error::check;
use crate::model::Periodic;
use crate::model::structure::couplings::Couplings;
use crate::model::structure::slopes::Slopes;
use crate::ode::budget::Meter;
use crate::periodic::balance::balance_error::BalanceError;
use crate::periodic::balance::crossings::stencil::NODES;
use crate::periodic::balance::fourier_orbit::FourierOrbit;
use crate::periodic::balance::integrals::Integrals;
use crate::periodic::balance::integration::closed::Closed;
use crate::periodic::balance::integration::integration_trait::Integration;
use crate::periodic::balance::integration::kinks::Kinks;
use crate::periodic::balance::integration::panels::Panels;
use crate::periodic::balance::integration::sampled::Sampled;
use crate::periodic::balance::quadrature::panel_points::any_edges;
use crate::periodic::balance::quadrature::pulses::pulses;
use crate::periodic::balance::quadrature::resolution::{DriveSampler, Signals, samples_following};
use crate::periodic::balance::series::grid::Grid;
use crate::periodic::balance::series::harmonics::Harmonics;
use crate::periodic::balance::series::spectra::Samples;

/// Maximum number of samples of all coordinates together. With their transforms they take more than 1 GB.
const MAX_SAMPLES: usize = 1 << 23;

/// A grid of samples and the way of integration on it.
pub(crate) type Choice<'m> = (Grid<'m>, Box<dyn Integration>);

/// Input of the choice.
pub(crate) struct Demand<'a, 'm> {
    pub(crate) model: &'m dyn Periodic,
    pub(crate) harmonics: &'a Harmonics,
    pub(crate) integrals: Integrals,
    /// The orbit from which the balance starts.
    pub(crate) near: &'a FourierOrbit,
    /// Factor on the number of samples, or on the number of panels.
    pub(crate) finer: usize,
    /// Size of every coordinate.
    pub(crate) size: &'a [f64],
    /// Size of every velocity.
    pub(crate) rates: &'a [f64],
    /// Whether the model has contacts and evaluates them on fixed pieces.
    pub(crate) has_fixed_pieces: bool,
    pub(crate) meter: &'a Meter<'a>,
}

impl<'m> Demand<'_, 'm> {
    /// Chooses the grid and the way of integration.
    ///
    /// # Errors
    /// Too few samples, too many samples, too many drive edges, or a way of integration that is not available
    /// for the model.
    pub(crate) fn choose(
        &self,
        couplings: &Couplings,
        slopes: &mut Slopes<'m>,
    ) -> Result<Choice<'m>, BalanceError> {
        let Demand { model, harmonics, integrals, finer, .. } = *self;
        let (n, contacts, varying) = (model.dof(), model.contacts(), couplings.varying.len());
        let edges = any_edges(model, model.period() * harmonics.period_multiple() as f64)?;
        let by_panels = integrals == Integrals::Panels
            || (integrals == Integrals::Exact && (edges || (contacts > 0 && !self.has_fixed_pieces)));
        let mut drives = DriveSampler::new(model, [self.size, self.rates], self.pieces(), Some(self.meter));
        let samples = match integrals {
            Integrals::Closed | Integrals::Kinks if edges || !self.has_fixed_pieces => {
                return Err(BalanceError::NotAvailable { integrals });
            }
            Integrals::Sampled { samples } if samples <= 2 * harmonics.highest() || samples < NODES => {
                return Err(BalanceError::Samples { samples, highest: harmonics.highest() });
            }
            Integrals::Sampled { samples } => samples,
            // Without contacts the accelerations contain few orders above those of the motion and the drives.
            Integrals::Exact if contacts == 0 => (6 * harmonics.highest()).next_power_of_two().max(64),
            // Panels evaluate the drives at their own nodes. The samples serve only to locate crossings.
            _ if by_panels => samples_following(&mut drives, Signals::Edges, harmonics),
            _ => samples_following(&mut drives, Signals::All, harmonics),
        };
        let fits = |samples: usize| check::count("samples of the balance", &[finer, samples, n], MAX_SAMPLES);
        fits(samples)?;
        let mut grid = Grid::new(model, harmonics, finer * samples);
        if integrals == Integrals::Exact && contacts == 0 && !by_panels {
            let needed = drives
                .orders(Signals::All, Some(&grid))
                .map_or(0, |orders| 3 * orders.highest * harmonics.period_multiple());
            if needed > samples {
                fits(needed.next_power_of_two())?;
                grid = Grid::new(model, harmonics, finer * needed.next_power_of_two());
            }
        }
        let sampled = || Samples::new(n, varying, grid.samples());
        let integration: Box<dyn Integration> = match integrals {
            Integrals::Panels => {
                let pulses = pulses(model, self.near, harmonics, self.meter);
                Box::new(Panels::new(&grid, varying, &mut drives, finer, &pulses))
            }
            _ if by_panels => Box::new(Panels::new(&grid, varying, &mut drives, finer, &[])),
            Integrals::Sampled { .. } => Box::new(Sampled::new(sampled(), contacts)),
            Integrals::Exact if contacts == 0 => Box::new(Sampled::new(sampled(), contacts)),
            Integrals::Kinks => Box::new(Kinks::new(sampled(), contacts)),
            Integrals::Exact | Integrals::Closed => match Closed::find(model, harmonics, couplings, slopes) {
                Some(closed) => Box::new(closed),
                None if integrals == Integrals::Closed => {
                    return Err(BalanceError::NotAvailable { integrals });
                }
                None => Box::new(Kinks::new(sampled(), contacts)),
            },
        };
        Ok((grid, integration))
    }

    /// The fixed pieces on which the accelerations are sampled, one entry for each evaluation. A model
    /// without fixed pieces is evaluated by deflection (`None`).
    fn pieces(&self) -> Vec<Option<Vec<Piece>>> {
        if !self.has_fixed_pieces {
            return vec![None];
        }
        let all = |piece| Some(vec![piece; self.model.contacts()]);
        [Piece::Gap, Piece::Lower, Piece::Upper].map(all).to_vec()
    }
}
