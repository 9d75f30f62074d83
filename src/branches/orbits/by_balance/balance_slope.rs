//! The derivative of the residual of a balance with respect to a named constant.

use crate::branches::orbits::by_balance::equations_over::Any;
use crate::model::structure::couplings::Couplings;
use crate::model::structure::no_model::NoModel;
use crate::model::structure::slopes::Slopes;
use crate::periodic::BalanceEquations;
use crate::periodic::balance::equations::balance_equations::Workspace;
use crate::periodic::balance::integration::integration_trait::{Integration, Motion};
use crate::periodic::balance::series::spectra::Spectra;
use nalgebra::DVector;

/// ∂R/∂c = -2 (kω)² σ q_k - (∂a/∂c)_k, at fixed Fourier coefficients q_k, with σ = (∂φ'/∂c)/φ'.
///
/// ∂a/∂c is a [model](crate::branches::orbits::by_balance::along_constant::AlongConstant), whose
/// accelerations are integrated in the same way as those of the model itself.
pub(crate) struct BalanceSlope {
    arrays: Option<Arrays>,
    /// The way of integration does not follow the derivative.
    unavailable: bool,
}

struct Arrays {
    couplings: Couplings,
    spectra: Spectra,
    /// Integration that holds results of the derivative; `None`: that of the equations serves.
    own: Option<Box<dyn Integration>>,
    slopes: Option<Slopes<'static>>,
}

/// Relative difference of two constant slopes that is rounding of differences.
const SAME_SLOPE: f64 = 1e-9;

impl BalanceSlope {
    pub(crate) fn new() -> Self {
        BalanceSlope { arrays: None, unavailable: false }
    }

    /// Whether derivatives were asked for and all of them were available.
    #[cfg(test)]
    pub(crate) fn has_served(&self) -> bool {
        self.arrays.is_some() && !self.unavailable
    }

    /// ∂R/∂c at the unknowns at which the equations were evaluated last. `None` if it is not available.
    pub(crate) fn at<'m, 'f>(
        &mut self,
        equations: &mut BalanceEquations<'m>,
        (slope, speed): (&'m Any<'f>, f64),
    ) -> Option<DVector<f64>> {
        if self.unavailable {
            return None;
        }
        let arrays = self.arrays.get_or_insert_with(|| Arrays {
            couplings: equations.work.couplings.clone(),
            spectra: Spectra::new(
                equations.work.layout.dof,
                equations.work.couplings.varying.len(),
                &equations.work.layout.harmonics,
            ),
            own: equations.work.integration.twin(),
            slopes: None,
        });
        let found = arrays.integrate(equations, slope);
        self.unavailable = !found;
        found.then(|| residual(equations, &arrays.spectra, speed))
    }
}

impl Arrays {
    /// Integrates the accelerations of `slope`. `false` if the way of integration does not follow it.
    fn integrate<'m, 'f>(&mut self, equations: &mut BalanceEquations<'m>, slope: &'m Any<'f>) -> bool {
        let model = std::mem::replace(&mut equations.grid.model, slope);
        let integrates = self.integrate_on_grid(equations, slope);
        equations.grid.model = model;
        integrates
    }

    /// [`integrate`](Arrays::integrate) with a grid that is bound to `slope`.
    fn integrate_on_grid<'m, 'f>(
        &mut self,
        equations: &mut BalanceEquations<'m>,
        slope: &'m Any<'f>,
    ) -> bool {
        let BalanceEquations { grid, slopes: bound, work } = equations;
        let Workspace { crossings, coefficients, speeds, integration, .. } = work;
        if let Some(own) = &mut self.own {
            let mut slopes = match self.slopes.take() {
                Some(slopes) => slopes.with_model(slope),
                None => Slopes::new(slope, bound.scale.clone(), 0.0),
            };
            let follows = self.couplings.reread(slope, &mut slopes, slope.contacts() > 0, SAME_SLOPE)
                && own.adapt(grid, &self.couplings, &mut slopes);
            self.slopes = Some(slopes.with_model(&NoModel));
            if !follows {
                return false;
            }
        }
        let mut motion = Motion { grid, crossings, couplings: &self.couplings, coefficients, speeds };
        self.own.as_mut().unwrap_or(integration).accelerations(&mut motion, &mut self.spectra);
        true
    }
}

fn residual(equations: &BalanceEquations<'_>, spectra: &Spectra, speed: f64) -> DVector<f64> {
    let layout = &equations.work.layout;
    let (harmonics, width) = (&layout.harmonics, layout.harmonics.unknowns());
    let mut by_c = DVector::zeros(layout.size());
    for (i, a) in spectra.accelerations.iter().enumerate() {
        let part = &equations.work.coefficients[i * width..(i + 1) * width];
        for (at, &order) in harmonics.orders().iter().enumerate() {
            let (at, rate) = (harmonics.place(at), order as f64 * layout.omega);
            for place in at..=at + usize::from(order > 0) {
                by_c[i * width + place] =
                    (-2.0 * speed * rate * rate * part[place] - a[place]) / layout.scales[i];
            }
        }
    }
    by_c
}
