//! The equations of a balance, for any root finder.

use crate::contact::Piece;
use crate::error::check;
use crate::model::Periodic;
use crate::model::structure::couplings::Couplings;
use crate::model::structure::slopes::Slopes;
use crate::ode::budget::Meter;
use crate::periodic::balance::admission::{admit_drifts, drifts};
use crate::periodic::balance::amplitudes::sizes_apart;
use crate::periodic::balance::balance_error::BalanceError;
use crate::periodic::balance::crossings::instants::Crossings;
use crate::periodic::balance::fourier_orbit::FourierOrbit;
use crate::periodic::balance::integrals::Integrals;
use crate::periodic::balance::integration::choice::Demand;
use crate::periodic::balance::integration::integration_trait::{Integration, Motion};
use crate::periodic::balance::integration::sampled::Sampled;
use crate::periodic::balance::integration::truncated::Truncated;
use crate::periodic::balance::note::BalanceNote;
use crate::periodic::balance::series::assembly::JacobianLayout;
use crate::periodic::balance::series::grid::Grid;
use crate::periodic::balance::series::harmonics::Harmonics;
use crate::periodic::balance::series::spectra::{Samples, Spectra};
use crate::roots::matrix::MAX_ENTRIES;
use crate::roots::{Matrix, Residual};
use std::fmt;

/// R(x) = coefficients of q'' - a(u(t), q, q') at the kept orders: the equations of a balance.
///
/// The unknowns x are the coefficients of every coordinate over its scale; equation i is divided by the scale
/// of coordinate i. If order 0 is kept, each rigid motion adds one unknown, its mean acceleration, and one
/// equation, the prescribed mean of one coordinate. A direction of which only the velocity acts adds its mean
/// speed and the same equation.
///
/// The equations are a [`Residual`], for your own root finders and for path following.
///
/// ```
/// use gear_dynamics::{Balance, Harmonics, NfgPair, NfgParams, contact::Piece};
/// use gear_dynamics::roots::{Newton, RootFinder};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let balance = Balance::new(Harmonics::up_to(70));
/// let start = balance.linearised(&pair, Piece::Lower)?;
/// let mut equations = balance.equations(&pair, &start)?;
/// let x = equations.unknowns(&start);
/// let root = Newton::new().solve(&mut equations, &x)?;
/// let orbit = equations.orbit(&root.x);
/// assert!(orbit.distance(&start) < 1e-9); // no contact loss at 100 rad/s: the linearised orbit is exact
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct BalanceEquations<'m> {
    pub(crate) grid: Grid<'m>,
    pub(crate) slopes: Slopes<'m>,
    pub(crate) work: Workspace,
}

impl fmt::Debug for BalanceEquations<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("BalanceEquations").finish_non_exhaustive()
    }
}

/// What the equations of a balance hold besides their model.
pub(crate) struct Workspace {
    pub(crate) layout: JacobianLayout,
    pub(crate) couplings: Couplings,
    pub(crate) spectra: Spectra,
    pub(crate) crossings: Crossings,
    pub(crate) integration: Box<dyn Integration>,
    pub(crate) coefficients: Vec<f64>,
    /// Mean velocity of each coordinate. It is 0 unless the orbit drifts.
    pub(crate) speeds: Vec<f64>,
    /// Unknowns at which `spectra` and `crossings` were evaluated last; empty before the first evaluation.
    pub(crate) evaluated: Vec<f64>,
    /// Whether the last evaluation included the slopes.
    pub(crate) has_slopes: bool,
}

impl<'m> BalanceEquations<'m> {
    /// `finer`: factor on the number of samples, or on the number of panels, that the orders require.
    pub(crate) fn new(
        model: &'m dyn Periodic,
        harmonics: &Harmonics,
        integrals: Integrals,
        near: &FourierOrbit,
        finer: usize,
        meter: &Meter<'_>,
    ) -> Result<Self, BalanceError> {
        let n = model.dof();
        // A Fourier series cannot represent velocities that jump.
        model.offers().refuse_stops(|contact| BalanceError::RigidStop { contact })?;
        check::scale("period of the model", model.period())?;
        harmonics.check()?;
        check::length("coordinates of the orbit", near.dof(), n)?;
        check::at_least("coordinates of the model", n, 1)?;
        let drifts = drifts(model);
        admit_drifts(&drifts)?;
        let (size, highest) = (sizes_apart(near, &drifts.places), harmonics.highest());
        let omega = std::f64::consts::TAU / (model.period() * harmonics.period_multiple() as f64);
        let fastest = omega * highest.max(1) as f64;
        let rates: Vec<f64> = size.iter().map(|s| s * fastest).collect();
        let mut slopes = Slopes::new(model, [&size[..], &rates].concat(), 0.0);
        let contacts = model.contacts();
        let has_fixed_pieces = contacts > 0 && model.offers().pieces;
        let couplings = Couplings::find(model, &mut slopes, has_fixed_pieces);
        let (size, rates) = (&size[..], &rates[..]);
        let demand =
            Demand { model, harmonics, integrals, near, finer, size, rates, has_fixed_pieces, meter };
        let (grid, integration) = demand.choose(&couplings, &mut slopes)?;
        if let Some(exhausted) = meter.exhausted() {
            return Err(BalanceError::Exhausted { exhausted, last: Box::new(near.clone()) });
        }
        let (samples, varying) = (grid.samples(), couplings.varying.len());
        let layout = JacobianLayout::new(harmonics, omega, size.to_vec(), &drifts, &couplings);
        check::count("entries of the Jacobian", &[layout.entries(&couplings)], MAX_ENTRIES)?;
        let work = Workspace {
            spectra: Spectra::new(n, varying, harmonics),
            crossings: Crossings::new(contacts, samples),
            coefficients: vec![0.0; n * harmonics.unknowns()],
            speeds: vec![0.0; n],
            evaluated: Vec::new(),
            has_slopes: false,
            layout,
            couplings,
            integration,
        };
        Ok(BalanceEquations { grid, slopes, work })
    }

    /// The same equations with every contact on a fixed piece.
    pub(crate) fn on_fixed_pieces(mut self, pieces: &[Piece]) -> Self {
        let (n, varying, m) = (self.work.layout.dof, self.work.couplings.varying.len(), self.grid.samples());
        let samples = Samples::new(n, varying, m);
        self.work.integration = Box::new(Sampled::on_pieces(samples, pieces));
        self.work.evaluated.clear();
        self
    }

    /// The unknowns of an orbit. Its mean position along drifts is moved to the prescribed one.
    pub fn unknowns(&self, orbit: &FourierOrbit) -> Vec<f64> {
        let layout = &self.work.layout;
        let on = orbit.on(&layout.harmonics);
        let width = layout.harmonics.unknowns();
        let mut x = on.all_coefficients().to_vec();
        for (part, scale) in x.chunks_exact_mut(width).zip(&layout.scales) {
            part.iter_mut().for_each(|x| *x /= scale);
        }
        for (k, drift) in layout.drifts.iter().enumerate() {
            let mean = if k < layout.rigid { on.mean_acceleration() } else { on.mean_velocity() };
            let along: f64 = drift.iter().map(|r| r * r).sum();
            let share: f64 = drift.iter().zip(mean).map(|(r, mean)| r * mean).sum::<f64>() / along;
            x.push(share / layout.drift_scale(k));
        }
        // For each drift the mean of one coordinate is prescribed as zero: the orbit is moved there.
        for (drift, &fixed) in layout.drifts.iter().zip(&layout.fixed) {
            let share = x[fixed * width] * layout.scales[fixed] / drift[fixed];
            for (j, r) in drift.iter().enumerate() {
                x[j * width] -= share * r / layout.scales[j];
            }
        }
        x
    }

    /// The orbit with the unknowns `x`.
    pub fn orbit(&self, x: &[f64]) -> FourierOrbit {
        let layout = &self.work.layout;
        let (n, width) = (layout.dof, layout.harmonics.unknowns());
        let mut coefficients = x[..n * width].to_vec();
        for (part, scale) in coefficients.chunks_exact_mut(width).zip(&layout.scales) {
            part.iter_mut().for_each(|x| *x *= scale);
        }
        let mut orbit = FourierOrbit::of(&layout.harmonics, self.grid.span(), coefficients, n);
        for (k, (drift, share)) in layout.drifts.iter().zip(&x[n * width..]).enumerate() {
            let mean = if k < layout.rigid { &mut orbit.mean_acceleration } else { &mut orbit.mean_velocity };
            mean.iter_mut().zip(drift).for_each(|(mean, r)| *mean += r * share * layout.drift_scale(k));
        }
        orbit
    }

    /// The way of integration in use.
    pub fn integrals(&self) -> Integrals {
        self.work.integration.integrals(self.grid.samples())
    }

    /// Evaluates `spectra` and `crossings` at the unknowns x, the slopes only if `slopes_too`. Results of the
    /// last evaluation at the same unknowns are kept.
    pub(crate) fn evaluate(&mut self, x: &[f64], slopes_too: bool) {
        let (grid, work) = (&mut self.grid, &mut self.work);
        let known = work.evaluated == x;
        if known && (work.has_slopes || !slopes_too) {
            return;
        }
        if !known {
            let width = work.layout.harmonics.unknowns();
            let parts = work.coefficients.chunks_exact_mut(width).zip(x.chunks_exact(width));
            for ((part, x), scale) in parts.zip(&work.layout.scales) {
                part.iter_mut().zip(x).for_each(|(c, x)| *c = x * scale);
            }
            work.speeds.fill(0.0);
            let drifts = work.layout.drifts.iter().enumerate().zip(&x[work.coefficients.len()..]);
            for ((k, drift), share) in drifts.filter(|((k, _), _)| *k >= work.layout.rigid) {
                let speed = share * work.layout.drift_scale(k);
                work.speeds.iter_mut().zip(drift).for_each(|(sum, r)| *sum += r * speed);
            }
            grid.set(&work.coefficients, &work.speeds);
            if work.integration.follows_crossings() {
                work.crossings.locate(grid);
            }
            work.evaluated.clear();
            work.evaluated.extend_from_slice(x);
        }
        work.has_slopes = slopes_too;
        let Workspace { spectra, crossings, couplings, coefficients, speeds, integration, .. } = work;
        let mut motion = Motion { grid, crossings, couplings, coefficients, speeds };
        if !known {
            integration.accelerations(&mut motion, spectra);
        }
        if slopes_too {
            integration.slopes(&mut motion, &mut self.slopes, spectra);
        }
    }

    /// The first contact that stays in its gap along the orbit, if also nothing else restores the mean;
    /// otherwise `None`.
    pub(crate) fn floating_contact(&mut self, x: &[f64]) -> Option<usize> {
        if !self.work.layout.harmonics.has_mean() {
            return None;
        }
        self.evaluate(x, false);
        if !self.work.integration.follows_crossings() {
            if !self.grid.any_floats() {
                return None;
            }
            self.work.crossings.locate(&mut self.grid);
        }
        let model = self.grid.model;
        let touching = model.offers().touching(model.contacts());
        let contact = (0..touching).find(|&c| self.work.crossings.floats(c))?;
        let layout = &self.work.layout;
        let n = layout.dof;
        // Sum of ∂a/∂q over a coarse grid, bordered by the drifts. Unit: the largest |∂a_i/∂q_i|, or
        // ω² if that is larger.
        let r = layout.drifts.len();
        let mut mean = nalgebra::DMatrix::zeros(n + r, n + r);
        let (mut q, mut v) = (vec![0.0; n], vec![0.0; n]);
        let stride = (self.grid.samples() / 64).max(1);
        for s in (0..self.grid.samples()).step_by(stride) {
            self.grid.state(s, &mut q, &mut v);
            self.slopes.at(None, self.grid.drives(s), &q, &v);
            for i in 0..n {
                for j in 0..n {
                    mean[(i, j)] += self.slopes.jacobian.q[(i, j)] / (layout.rigid_scale / layout.scales[0]);
                }
            }
        }
        for (k, drift) in layout.drifts.iter().enumerate() {
            for i in 0..n {
                mean[(n + k, i)] = drift[i];
                mean[(i, n + k)] = drift[i];
            }
        }
        let samples = self.grid.samples().div_ceil(stride) as f64;
        if mean.iter().any(|x| !x.is_finite()) {
            return None; // the solve then reports the equation or the slope that is not finite
        }
        (mean.singular_values().min() <= 1e-9 * samples).then_some(contact)
    }

    /// Notes that apply to every orbit of these equations.
    pub(crate) fn notes(&self) -> Vec<BalanceNote> {
        if self.slopes.differenced { vec![BalanceNote::Differences] } else { Vec::new() }
    }
}

impl BalanceEquations<'_> {
    /// The same equations with truncated contact forces, see
    /// [`Balance::truncated_forces`](crate::Balance::truncated_forces). `None` if the integrals are panels,
    /// or the model does not evaluate its laws.
    pub(crate) fn with_truncated_forces(mut self) -> Option<Self> {
        if self.integrals() == Integrals::Panels || self.grid.model.offers().laws.is_none() {
            return None;
        }
        let (n, m, contacts) = (self.work.layout.dof, self.grid.samples(), self.grid.model.contacts());
        let drives = self.grid.model.drives();
        let exact = matches!(self.integrals(), Integrals::Closed | Integrals::Kinks);
        self.work.integration =
            Box::new(Truncated::new(n, drives, contacts, &self.work.layout.harmonics, m, exact));
        self.work.couplings = self.work.couplings.without_slopes();
        self.work.spectra = Spectra::new(n, 0, &self.work.layout.harmonics);
        self.work.layout.make_dense();
        Some(self)
    }
}

impl Residual for BalanceEquations<'_> {
    fn size(&self) -> usize {
        self.work.layout.size()
    }

    fn residual(&mut self, x: &[f64], r: &mut [f64]) {
        self.evaluate(x, false);
        let Workspace { layout, spectra, coefficients, .. } = &self.work;
        let (harmonics, width) = (&layout.harmonics, layout.harmonics.unknowns());
        for (i, a) in spectra.accelerations.iter().enumerate() {
            let (part, scale) = (&coefficients[i * width..(i + 1) * width], layout.scales[i]);
            let rows = &mut r[i * width..(i + 1) * width];
            for (at, &order) in harmonics.orders().iter().enumerate() {
                let (at, rate) = (harmonics.place(at), order as f64 * layout.omega);
                rows[at] = (-rate * rate * part[at] - a[at]) / scale;
                if order > 0 {
                    rows[at + 1] = (-rate * rate * part[at + 1] - a[at + 1]) / scale;
                }
            }
        }
        let n = layout.dof;
        for (k, drift) in layout.drifts.iter().enumerate() {
            let alpha = if k < layout.rigid { x[n * width + k] * layout.rigid_scale } else { 0.0 };
            for (i, share) in drift.iter().enumerate() {
                r[i * width] += alpha * share / layout.scales[i];
            }
            r[n * width + k] = x[layout.fixed[k] * width];
        }
    }

    fn matrix(&self) -> Matrix {
        self.work.layout.matrix(&self.work.couplings)
    }

    fn jacobian(&mut self, x: &[f64], out: &mut Matrix) {
        self.evaluate(x, true);
        self.work.layout.fill(&self.work.couplings, &self.work.spectra, out);
        self.work.integration.add_jacobian(&self.work.layout, out);
    }
}
