//! Solution of a harmonic balance.

use crate::contact::Piece;
use crate::linear::static_state;
use crate::model::Periodic;
use crate::model::period::check_period;
use crate::ode::budget::Meter;
use crate::periodic::balance::admission::admit_on_pieces;
use crate::periodic::balance::balance_error::BalanceError;
use crate::periodic::balance::equations::balance_equations::BalanceEquations;
use crate::periodic::balance::equations::resonance::Resonance;
use crate::periodic::balance::fourier_orbit::FourierOrbit;
use crate::periodic::balance::quality::coarseness::{COARSE, MORE, correction};
use crate::periodic::balance::quality::notes::notes;
use crate::periodic::balance::settings::Balance;
use crate::periodic::metered::{Metered, RootFailure};
use crate::roots::root_finder::confirmed;
use crate::roots::{FirstJacobian, Newton, Residual, Root, RootError, RootFinder};

impl Balance {
    /// The equations of the balance. Their unknowns are scaled by the sizes of the coordinates of `near`.
    ///
    /// # Errors
    /// [`BalanceError`] for too few samples, a way of integration that is not available for the model, an
    /// orbit that does not fit the model, or a call that exceeds its time or is cancelled.
    pub fn equations<'m>(
        &self,
        model: &'m dyn Periodic,
        near: &FourierOrbit,
    ) -> Result<BalanceEquations<'m>, BalanceError> {
        self.set_up(model, near, 1, &self.budget.begin())
    }

    /// [`equations`](Balance::equations) with the rest of a budget. `finer`: factor on the number of samples,
    /// or on the number of panels.
    pub(crate) fn set_up<'m>(
        &self,
        model: &'m dyn Periodic,
        near: &FourierOrbit,
        finer: usize,
        meter: &Meter<'_>,
    ) -> Result<BalanceEquations<'m>, BalanceError> {
        let equations = self.with_whole_forces(model, near, finer, meter)?;
        if !self.truncated_forces {
            return Ok(equations);
        }
        equations.with_truncated_forces().ok_or(BalanceError::NoLaws { integrals: self.integrals })
    }

    /// The equations without truncation of the contact forces.
    fn with_whole_forces<'m>(
        &self,
        model: &'m dyn Periodic,
        near: &FourierOrbit,
        finer: usize,
        meter: &Meter<'_>,
    ) -> Result<BalanceEquations<'m>, BalanceError> {
        BalanceEquations::new(model, &self.harmonics, self.integrals, near, finer, meter)
    }

    /// The orbit with every contact fixed on one piece: the usual guess for [`solve`](Balance::solve). It is
    /// not checked and has no warnings.
    ///
    /// # Errors
    /// [`BalanceError`]: the linear system is singular, for example with contacts fixed in their gap, or the
    /// model does not evaluate its laws on fixed pieces.
    pub fn linearised(&self, model: &dyn Periodic, flank: Piece) -> Result<FourierOrbit, BalanceError> {
        self.linearised_on(model, &vec![flank; model.contacts()])
    }

    /// [`linearised`](Balance::linearised) with one piece for each contact.
    ///
    /// # Errors
    /// As [`linearised`](Balance::linearised); also a wrong number of pieces.
    pub fn linearised_on(
        &self,
        model: &dyn Periodic,
        pieces: &[Piece],
    ) -> Result<FourierOrbit, BalanceError> {
        self.linearised_within(model, pieces, &self.budget.begin())
    }

    /// [`linearised_on`](Balance::linearised_on) with the rest of a budget.
    fn linearised_within(
        &self,
        model: &dyn Periodic,
        pieces: &[Piece],
        meter: &Meter<'_>,
    ) -> Result<FourierOrbit, BalanceError> {
        crate::error::check::length("pieces", pieces.len(), model.contacts())?;
        admit_on_pieces(model)?;
        let width = self.harmonics.unknowns();
        let rest = FourierOrbit::of(
            &self.harmonics,
            model.period() * self.harmonics.period_multiple() as f64,
            vec![0.0; model.dof() * width],
            model.dof(),
        );
        let mut equations = self.with_whole_forces(model, &rest, 1, meter)?.on_fixed_pieces(pieces);
        let x = equations.unknowns(&rest);
        let root = Newton::new().solve(&mut Metered { equations: &mut equations, meter }, &x);
        self.finish(&mut equations, &x, root, meter, pieces.iter().position(|&p| p == Piece::Gap))
    }

    /// Finds an orbit from a guess: a linearised or projected orbit, or the orbit of a neighbouring model.
    /// `None`: from the orbit [linearised on](Balance::linearised_on) the pieces of the
    /// [static state](crate::linear::static_state).
    ///
    /// # Errors
    /// [`BalanceError`]; the errors of the root finder contain the last iterate.
    pub fn solve<'g>(
        &self,
        model: &dyn Periodic,
        guess: impl Into<Option<&'g FourierOrbit>>,
    ) -> Result<FourierOrbit, BalanceError> {
        let meter = self.budget.begin();
        match guess.into() {
            Some(guess) => self.find(model, guess, &meter),
            None => {
                let at_rest = static_state(model, None).map_err(BalanceError::NoStaticState)?;
                self.find(model, &self.linearised_within(model, &at_rest.pieces, &meter)?, &meter)
            }
        }
    }

    /// [`solve`](Balance::solve) with the rest of a budget.
    pub(crate) fn find(
        &self,
        model: &dyn Periodic,
        guess: &FourierOrbit,
        meter: &Meter<'_>,
    ) -> Result<FourierOrbit, BalanceError> {
        let mut equations = self.set_up(model, guess, 1, meter)?;
        let x = equations.unknowns(guess);
        if let Some(contact) = equations.floating_contact(&x) {
            return Err(BalanceError::StartInGap { contact });
        }
        check_period(model, &guess.at(0.0))?;
        let mut metered = Metered { equations: &mut equations, meter };
        let (mut root, is_own) = (self.root_finder.solve(&mut metered, &x), !self.root_finder.is_of_crate());
        if is_own {
            root = confirmed(&mut metered, root);
        }
        let mut orbit = self.finish(&mut equations, &x, root, meter, None)?;
        if is_own {
            let moved = correction(&mut equations, &orbit);
            if moved.is_nan() || moved > COARSE {
                let residuals = vec![orbit.residual];
                return Err(BalanceError::NotConverged { last: Box::new(orbit), residuals });
            }
        }
        if let Some((coordinate, gain)) = equations.accelerating(&orbit) {
            return Err(BalanceError::Accelerates { coordinate, gain, last: Box::new(orbit) });
        }
        orbit.notes.extend(notes(&mut equations, &orbit, |orbit| self.set_up(model, orbit, MORE, meter)));
        Ok(orbit)
    }

    /// Jacobian at `near` with every contact fixed on one flank, for
    /// [`Broyden::first`](crate::roots::Broyden::first).
    ///
    /// Its unknowns are scaled by `near`, and those of a solve by the guess: `near` must be that guess.
    ///
    /// # Errors
    /// [`BalanceError`] if the model does not evaluate its laws on fixed pieces, or as for
    /// [`equations`](Balance::equations).
    pub fn flank_jacobian(
        &self,
        model: &dyn Periodic,
        flank: Piece,
        near: &FourierOrbit,
    ) -> Result<FirstJacobian, BalanceError> {
        admit_on_pieces(model)?;
        let equations = self.with_whole_forces(model, near, 1, &self.budget.begin())?;
        let mut equations = equations.on_fixed_pieces(&vec![flank; model.contacts()]);
        let mut matrix = equations.matrix();
        let x = equations.unknowns(near);
        equations.jacobian(&x, &mut matrix);
        Ok(FirstJacobian::Given(matrix))
    }

    /// The orbit of a root, or the reason why none was found from the unknowns `guess`.
    fn finish(
        &self,
        equations: &mut BalanceEquations<'_>,
        guess: &[f64],
        root: Result<Root, RootError>,
        meter: &Meter<'_>,
        start_in_gap: Option<usize>,
    ) -> Result<FourierOrbit, BalanceError> {
        let orbit = |root: &Root| {
            let mut orbit = equations.orbit(&root.x);
            (orbit.iterations, orbit.evaluations, orbit.residual) =
                (root.iterations, root.evaluations, root.residual);
            orbit.notes = equations.notes();
            orbit
        };
        let error = match root {
            Ok(root) => return Ok(orbit(&root)),
            Err(error) => error,
        };
        let (failure, root) = RootFailure::of(error, meter)?;
        let last = Box::new(orbit(&root));
        // With rounding errors in the Jacobian a resonance need not be singular, but gives no convergence.
        let may_resonate = matches!(failure, RootFailure::Singular { .. } | RootFailure::NotConverged);
        if may_resonate
            && start_in_gap.is_none()
            && let Some(Resonance { coordinate, order }) = equations.resonance(guess, meter)
        {
            return Err(BalanceError::Singular { coordinate, order, last });
        }
        let coordinate = |unknown| equations.work.layout.coordinate(unknown);
        Err(match failure {
            RootFailure::Exhausted(exhausted) => BalanceError::Exhausted { exhausted, last },
            RootFailure::Slope { equation, unknown } => BalanceError::Slope {
                acceleration: coordinate(equation),
                coordinate: coordinate(unknown),
                last,
            },
            RootFailure::Singular { unknown } => match start_in_gap {
                Some(contact) => BalanceError::StartInGap { contact },
                None => {
                    let order = equations.work.layout.order(unknown);
                    BalanceError::Singular { coordinate: coordinate(unknown), order, last }
                }
            },
            RootFailure::NotConverged => BalanceError::NotConverged { last, residuals: root.residuals },
            RootFailure::NotFinite => BalanceError::NotFinite { last },
        })
    }
}
