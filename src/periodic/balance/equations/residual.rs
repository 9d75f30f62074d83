//! The equations of a balance, ready for any root finder.

use crate::contact::piece::Piece;
use crate::error::check;
use crate::model::equations::{Model, Periodic};
use crate::model::machine::Machine;
use crate::model::shape::Shape;
use crate::model::slopes::Slopes;
use crate::periodic::balance::admission::{free_motions, refuse_stops};
use crate::periodic::balance::amplitudes::sizes_apart;
use crate::periodic::balance::error::BalanceError;
use crate::periodic::balance::integrals::Integrals;
use crate::periodic::balance::note::BalanceNote;
use crate::periodic::balance::orbit::FourierOrbit;
use crate::periodic::balance::quadrature::closed::Closed;
use crate::periodic::balance::quadrature::gauss::any_edges;
use crate::periodic::balance::quadrature::kinks::Kinks;
use crate::periodic::balance::quadrature::panels::Panels;
use crate::periodic::balance::quadrature::pulses::pulses;
use crate::periodic::balance::quadrature::resolution::{Drives, Signals, samples_following};
use crate::periodic::balance::quadrature::truncated::{Forces, Truncated};
use crate::periodic::balance::series::assembly::Layout;
use crate::periodic::balance::series::couplings::{Couplings, holds_pieces};
use crate::periodic::balance::series::grid::Grid;
use crate::periodic::balance::series::harmonics::Harmonics;
use crate::periodic::balance::series::spectra::{Samples, Spectra};
use crate::periodic::balance::switching::instants::Switching;
use crate::periodic::balance::switching::stencil::{NODES, Stencil};
use crate::roots::matrix::Matrix;
use crate::roots::residual::Residual;

/// R(x) = coefficients of q'' - a(u(t), q, q'), every coordinate over its scale; with rigid motions, their mean accelerations are
/// unknowns too and the mean position along them is fixed.
///
/// It is a [`Residual`], so that root finders of one's own and path following can use it.
///
/// ```
/// use gear_dynamics::{Balance, Harmonics, NfgPair, NfgParams, roots::Newton, contact::Piece};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let balance = Balance::new(Harmonics::up_to(70));
/// let start = balance.linearised(&pair, Piece::Lower)?;
/// let mut equations = balance.equations(&pair, &start)?;
/// let x = equations.unknowns(&start);
/// let root = Newton::new().solve(&mut equations, &x)?;
/// let orbit = equations.orbit(&root.x);
/// assert!(orbit.distance(&start) < 1e-9); // contact is not lost at 100 rad/s: the linear orbit is the orbit
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct BalanceEquations<'m, M: Periodic + ?Sized> {
    pub(crate) layout: Layout,
    pub(crate) couplings: Couplings,
    pub(crate) grid: Grid<'m, M>,
    pub(crate) slopes: Slopes<'m, M>,
    pub(crate) spectra: Spectra,
    pub(crate) stencil: &'static Stencil,
    pub(crate) switching: Switching,
    kinks: Kinks,
    pub(crate) method: Method<'m, M>,
    coefficients: Vec<f64>,
    /// What `spectra` and `switching` belong to.
    seen: Vec<f64>,
    slopes_seen: bool,
}

/// Samples of all coordinates at most: over a gigabyte, with their transforms.
const MOST_SAMPLES: usize = 1 << 23;

/// Stored entries of a Jacobian at most: two gigabytes.
const MOST_ENTRIES: usize = 1 << 28;

/// How the integrals are taken.
pub(crate) enum Method<'m, M: ?Sized> {
    Sampled(Samples),
    Held(Samples, Vec<Piece>),
    Kinks(Samples),
    Panels(Panels),
    Closed(Closed),
    Truncated(Samples, Box<dyn Truncated<M> + 'm>),
}

impl<'m, M: Periodic + ?Sized> BalanceEquations<'m, M> {
    /// `finer`: factor on the number of samples, or on that of the panels, that the orders ask for.
    pub(crate) fn new(
        model: &'m M,
        harmonics: &Harmonics,
        integrals: Integrals,
        near: &FourierOrbit,
        finer: usize,
    ) -> Result<Self, BalanceError> {
        let n = model.dof();
        refuse_stops(model)?;
        check::scale("period of the model", model.period())?;
        harmonics.check()?;
        if near.dof() != n || n == 0 {
            return Err(BalanceError::Coordinates { expected: n, found: near.dof() });
        }
        // A single coordinate turns freely only if nothing holds it, which the Jacobian tells.
        let rigid = if n == 1 { Vec::new() } else { free_motions(model)? };
        let (size, highest) = (sizes_apart(near, &rigid), harmonics.highest());
        let omega = std::f64::consts::TAU / (model.period() * harmonics.periods() as f64);
        let fastest = omega * highest.max(1) as f64;
        let rates: Vec<f64> = size.iter().map(|s| s * fastest).collect();
        let mut slopes = Slopes::new(model, [&size[..], &rates].concat(), 0.0);
        let contacts = model.contacts();
        let holds = contacts > 0 && holds_pieces(model);
        let couplings = Couplings::find(&mut slopes, holds);
        let edges = any_edges(model, model.period() * harmonics.periods() as f64)?;
        let by_panels = integrals == Integrals::Panels
            || (integrals == Integrals::Exact && (edges || (contacts > 0 && !holds)));
        let ways = match holds {
            false => vec![None],
            true => {
                [Piece::Gap, Piece::Lower, Piece::Upper].map(|piece| Some(vec![piece; contacts])).to_vec()
            }
        };
        let mut drives = Drives::new(model, [&size, &rates], ways);
        let samples = match integrals {
            Integrals::Closed | Integrals::Kinks if edges || !holds => {
                return Err(BalanceError::NotOffered { integrals });
            }
            Integrals::Sampled { samples } if samples <= 2 * highest || samples < NODES => {
                return Err(BalanceError::Samples { samples, highest });
            }
            Integrals::Sampled { samples } => samples,
            // Without contacts a smooth force has few orders more than motion and drives.
            Integrals::Exact if contacts == 0 => (6 * highest).next_power_of_two().max(64),
            // Panels follow the drives themselves; their samples only have to show where the tooth edges are.
            _ => samples_following(
                &mut drives,
                if by_panels { Signals::Edges } else { Signals::All },
                harmonics,
            ),
        };
        let fits =
            |samples: usize| check::count("samples of the balance", &[finer, samples, n], MOST_SAMPLES);
        fits(samples)?;
        let mut grid = Grid::new(model, harmonics, finer * samples);
        if integrals == Integrals::Exact && contacts == 0 && !by_panels {
            let needed = drives
                .orders(Signals::All, Some(&grid))
                .map_or(0, |orders| 3 * orders.highest * harmonics.periods());
            if needed > samples {
                fits(needed.next_power_of_two())?;
                grid = Grid::new(model, harmonics, finer * needed.next_power_of_two());
            }
        }
        let (samples, varying) = (grid.samples(), couplings.varying.len());
        let sampled = || Samples::new(n, varying, samples);
        let method = match integrals {
            _ if by_panels => {
                let pulses =
                    if integrals == Integrals::Panels { pulses(model, near, harmonics) } else { Vec::new() };
                Method::Panels(Panels::new(&grid, varying, &mut drives, finer, &pulses))
            }
            Integrals::Sampled { .. } => Method::Sampled(sampled()),
            Integrals::Exact if contacts == 0 => Method::Sampled(sampled()),
            Integrals::Kinks => Method::Kinks(sampled()),
            _ => match Closed::find(model, harmonics, &couplings, &mut slopes) {
                Some(closed) => Method::Closed(closed),
                None if integrals == Integrals::Closed => return Err(BalanceError::NotOffered { integrals }),
                None => Method::Kinks(sampled()),
            },
        };
        let layout = Layout::new(harmonics, omega, size, rigid, &couplings);
        check::count("entries of the Jacobian", &[layout.entries(&couplings)], MOST_ENTRIES)?;
        Ok(BalanceEquations {
            spectra: Spectra::new(n, varying, harmonics),
            stencil: Stencil::get(),
            switching: Switching::new(contacts, samples),
            kinks: Kinks::new(n, contacts),
            coefficients: vec![0.0; n * harmonics.unknowns()],
            seen: Vec::new(),
            slopes_seen: false,
            layout,
            couplings,
            grid,
            slopes,
            method,
        })
    }

    /// The same equations with every contact held on given pieces.
    pub(crate) fn held(mut self, pieces: &[Piece]) -> Self {
        let (n, varying, m) = (self.layout.dof, self.couplings.varying.len(), self.grid.samples());
        self.method = Method::Held(Samples::new(n, varying, m), pieces.to_vec());
        self.seen.clear();
        self
    }

    /// The unknowns of an orbit.
    pub fn unknowns(&self, orbit: &FourierOrbit) -> Vec<f64> {
        let on = orbit.on(&self.layout.harmonics);
        let width = self.layout.harmonics.unknowns();
        let mut x = on.all_coefficients().to_vec();
        for (part, scale) in x.chunks_exact_mut(width).zip(&self.layout.scales) {
            part.iter_mut().for_each(|x| *x /= scale);
        }
        for rigid in &self.layout.rigid {
            let along: f64 = rigid.iter().map(|r| r * r).sum();
            let alpha: f64 =
                rigid.iter().zip(on.mean_acceleration()).map(|(r, a)| r * a).sum::<f64>() / along;
            x.push(alpha / self.layout.rigid_scale);
        }
        // The position along a rigid motion is held by one mean, which is zero: the guess has to stand there.
        for (rigid, &fixed) in self.layout.rigid.iter().zip(&self.layout.fixed) {
            let share = x[fixed * width] * self.layout.scales[fixed] / rigid[fixed];
            for (j, r) in rigid.iter().enumerate() {
                x[j * width] -= share * r / self.layout.scales[j];
            }
        }
        x
    }

    /// The orbit of unknowns.
    pub fn orbit(&self, x: &[f64]) -> FourierOrbit {
        let n = self.layout.dof;
        let width = self.layout.harmonics.unknowns();
        let mut coefficients = x[..n * width].to_vec();
        for (part, scale) in coefficients.chunks_exact_mut(width).zip(&self.layout.scales) {
            part.iter_mut().for_each(|x| *x *= scale);
        }
        let mut orbit = FourierOrbit::of(&self.layout.harmonics, self.grid.span(), coefficients, n);
        for (rigid, alpha) in self.layout.rigid.iter().zip(&x[n * width..]) {
            orbit
                .mean_acceleration
                .iter_mut()
                .zip(rigid)
                .for_each(|(a, r)| *a += r * alpha * self.layout.rigid_scale);
        }
        orbit
    }

    /// How the integrals are taken.
    pub fn integrals(&self) -> Integrals {
        match self.method {
            Method::Sampled(_) | Method::Held(..) | Method::Truncated(..) => {
                Integrals::Sampled { samples: self.grid.samples() }
            }
            Method::Kinks(_) => Integrals::Kinks,
            Method::Panels(_) => Integrals::Panels,
            Method::Closed(_) => Integrals::Closed,
        }
    }

    /// Whether switches are known wherever the equations were evaluated.
    fn is_located(&self) -> bool {
        !matches!(self.method, Method::Sampled(_) | Method::Held(..) | Method::Truncated(..))
    }

    /// Makes `spectra` belong to x.
    fn look(&mut self, x: &[f64], slopes_too: bool) {
        let known = self.seen == x;
        if known && (self.slopes_seen || !slopes_too) {
            return;
        }
        let width = self.layout.harmonics.unknowns();
        if !known {
            for ((part, x), scale) in
                self.coefficients.chunks_exact_mut(width).zip(x.chunks_exact(width)).zip(&self.layout.scales)
            {
                part.iter_mut().zip(x).for_each(|(c, x)| *c = x * scale);
            }
            self.grid.set(&self.coefficients);
            if self.is_located() {
                self.switching.locate(&mut self.grid, self.stencil);
            }
            self.seen.clear();
            self.seen.extend_from_slice(x);
        }
        self.slopes_seen = slopes_too;
        let (grid, kinks, out) = (&mut self.grid, &mut self.kinks, &mut self.spectra);
        match &mut self.method {
            Method::Sampled(samples) => {
                if !known {
                    samples.forces(grid, None);
                    samples.transform_forces(grid, out);
                }
                if slopes_too {
                    samples.slopes(grid, None, &mut self.slopes, &self.couplings);
                    samples.transform_slopes(grid, out);
                }
            }
            Method::Held(samples, pieces) => {
                samples.forces(grid, Some(pieces));
                samples.transform_forces(grid, out);
                samples.slopes(grid, Some(pieces), &mut self.slopes, &self.couplings);
                samples.transform_slopes(grid, out);
            }
            Method::Kinks(samples) => {
                if !known {
                    samples.forces(grid, None);
                    kinks.correct_forces(grid, self.stencil, &self.switching, samples);
                    samples.transform_forces(grid, out);
                }
                if slopes_too {
                    samples.slopes(grid, None, &mut self.slopes, &self.couplings);
                    kinks.correct_slopes(
                        grid,
                        self.stencil,
                        &self.switching,
                        &mut self.slopes,
                        &self.couplings,
                        samples,
                    );
                    samples.transform_slopes(grid, out);
                    kinks.jumps(grid, self.stencil, &self.switching, out);
                }
            }
            Method::Panels(panels) => {
                let wanted = slopes_too.then_some((&mut self.slopes, &self.couplings));
                panels.evaluate(grid, &self.switching, &self.coefficients, wanted, out);
                if slopes_too {
                    kinks.jumps(grid, self.stencil, &self.switching, out);
                }
            }
            Method::Closed(closed) => {
                if !known {
                    closed.evaluate(grid, &self.switching, &self.couplings, &self.coefficients, out);
                }
                if slopes_too {
                    kinks.jumps(grid, self.stencil, &self.switching, out);
                }
            }
            Method::Truncated(samples, split) => {
                if !known {
                    split.accelerations(grid, &mut samples.force);
                    samples.transform_forces(grid, out);
                }
                if slopes_too {
                    split.slopes(grid);
                }
            }
        }
    }

    /// Whether, on this orbit, some contact never touches and nothing else holds the mean: then no mean is restored.
    pub(crate) fn floating_contact(&mut self, x: &[f64]) -> Option<usize> {
        if !self.layout.harmonics.has_mean() {
            return None;
        }
        self.look(x, false);
        if !self.is_located() {
            if !self.grid.any_floats() {
                return None;
            }
            self.switching.locate(&mut self.grid, self.stencil);
        }
        let contact = (0..self.grid.model.contacts()).find(|&c| self.switching.floats(c))?;
        let n = self.layout.dof;
        // Mean stiffness over a coarse grid, rigid motions bordered.
        let r = self.layout.rigid.len();
        let mut mean = nalgebra::DMatrix::zeros(n + r, n + r);
        let (mut q, mut v) = (vec![0.0; n], vec![0.0; n]);
        let stride = (self.grid.samples() / 64).max(1);
        for s in (0..self.grid.samples()).step_by(stride) {
            self.grid.state(s, &mut q, &mut v);
            self.slopes.at(None, self.grid.drives(s), &q, &v);
            for i in 0..n {
                for j in 0..n {
                    mean[(i, j)] +=
                        self.slopes.jacobian.q[(i, j)] / (self.layout.rigid_scale / self.layout.scales[0]);
                }
            }
        }
        for (k, rigid) in self.layout.rigid.iter().enumerate() {
            for i in 0..n {
                mean[(n + k, i)] = rigid[i];
                mean[(i, n + k)] = rigid[i];
            }
        }
        // In units of the stiffest coordinate.
        let samples = self.grid.samples().div_ceil(stride) as f64;
        if mean.iter().any(|x| !x.is_finite()) {
            return None; // the residual says where
        }
        (mean.singular_values().min() <= 1e-9 * samples).then_some(contact)
    }

    /// Notes that hold for any orbit of these equations.
    pub(crate) fn notes(&self) -> Vec<BalanceNote> {
        if self.slopes.differenced { vec![BalanceNote::Differences] } else { Vec::new() }
    }
}

impl<G: Shape> BalanceEquations<'_, Machine<G>> {
    /// The same equations with contact forces truncated to the kept orders before they meet the stiffness: sampled, as Liu 2021 does.
    pub fn truncating_forces(mut self) -> Self {
        let (n, m, contacts) = (self.layout.dof, self.grid.samples(), self.grid.model.contacts());
        let forces = Forces::new(n, self.grid.model.drives(), contacts, &self.layout.harmonics, m);
        self.method = Method::Truncated(Samples::new(n, 0, m), Box::new(forces));
        self.seen.clear();
        self.couplings = self.couplings.without_slopes();
        self.spectra = Spectra::new(n, 0, &self.layout.harmonics);
        self.layout.make_dense();
        self
    }
}

impl<M: Periodic + ?Sized> Residual for BalanceEquations<'_, M> {
    fn size(&self) -> usize {
        self.layout.size()
    }

    fn residual(&mut self, x: &[f64], r: &mut [f64]) {
        self.look(x, false);
        let (harmonics, width) = (&self.layout.harmonics, self.layout.harmonics.unknowns());
        for (i, force) in self.spectra.force.iter().enumerate() {
            let (part, scale) = (&self.coefficients[i * width..(i + 1) * width], self.layout.scales[i]);
            let rows = &mut r[i * width..(i + 1) * width];
            for (at, &order) in harmonics.orders().iter().enumerate() {
                let (at, rate) = (harmonics.place(at), order as f64 * self.layout.omega);
                rows[at] = (-rate * rate * part[at] - force[at]) / scale;
                if order > 0 {
                    rows[at + 1] = (-rate * rate * part[at + 1] - force[at + 1]) / scale;
                }
            }
        }
        let n = self.layout.dof;
        for (k, rigid) in self.layout.rigid.iter().enumerate() {
            let alpha = x[n * width + k] * self.layout.rigid_scale;
            for (i, share) in rigid.iter().enumerate() {
                r[i * width] += alpha * share / self.layout.scales[i];
            }
            r[n * width + k] = x[self.layout.fixed[k] * width];
        }
    }

    fn matrix(&self) -> Matrix {
        self.layout.matrix(&self.couplings)
    }

    fn jacobian(&mut self, x: &[f64], out: &mut Matrix) -> bool {
        self.look(x, true);
        self.layout.fill(&self.couplings, &self.spectra, out);
        if let Method::Truncated(_, split) = &mut self.method {
            split.add_jacobian(&self.layout, out);
        }
        true
    }
}
