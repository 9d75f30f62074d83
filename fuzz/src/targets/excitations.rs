//! Excitations: every constructor, nested, in any wave; values, derivatives and edges.

use crate::case::{Case, Run, Stop, all_finite, finite, holds};

use gear_dynamics::Wave;
use gear_dynamics::excitation::{
    Angle, Excitation, Fourier, Function, InstantCentre, Jet, Product, RectangularWave, Scaled, Side, Sum,
    Table,
};
use std::f64::consts::TAU;

/// A wave near a mean, nested up to `levels` deep.
pub fn wave(case: &mut Case, levels: usize, mean: f64) -> Result<Wave, Stop> {
    let kinds = if levels == 0 { 9 } else { 12 };
    let wave = match case.below(kinds) {
        0 => Wave::constant(case.number(mean))?,
        1 => {
            let (mean, pairs) = (case.number(mean), case.pairs(4, 0.2 * mean));
            Wave::new(Fourier::new(mean, &pairs)?)
        }
        2 => {
            let (mean, pairs) = (case.number(mean), case.pairs(3, 0.2 * mean));
            Wave::new(Fourier::of_amplitudes(mean, &pairs)?)
        }
        3 => Wave::new(RectangularWave::new(case.number(0.5 * mean), case.number(mean), case.number(0.4))?),
        4 => {
            let (ratio, low, high) = (case.number(1.5), case.number(0.5 * mean), case.number(mean));
            let rectangle = RectangularWave::of_contact_ratio(ratio, low, high)?;
            finite("mean of a wave", rectangle.mean())?;
            if case.chance(0.5) { Wave::new(rectangle) } else { Wave::new(rectangle.series(case.count(5))?) }
        }
        5 => {
            let centre = InstantCentre::new(case.number(0.2))?;
            finite("beta", centre.beta())?;
            Wave::new(match case.below(4) {
                0 => centre.radius(case.number(mean))?,
                1 => centre.ratio(case.number(mean))?,
                2 => centre.rotation(),
                _ => centre.rotation_series(case.count(4))?,
            })
        }
        6 => Wave::new(Table::new(&case.list(12, mean))?),
        7 => Wave::new(RectangularWave::sign()),
        8 => {
            let (scale, order) = (case.quantity(mean), case.pick(&[1.0, 2.0, 0.5]));
            let function = Function::new(move |angle: Jet| (angle * order).sin() * scale);
            if case.chance(0.5) {
                Wave::new(function)
            } else {
                Wave::new(function.with_edges(&angles(case))?)
            }
        }
        9 => Wave::new(Sum::new(some(case, levels, mean)?)),
        10 => Wave::new(Product::new(some(case, levels, mean)?)),
        _ => {
            let factor = case.number(1.0);
            Wave::new(Scaled::new(factor, wave(case, levels - 1, mean)?)?)
        }
    };
    turned(case, wave)
}

/// The same wave with any order and phase.
fn turned(case: &mut Case, wave: Wave) -> Result<Wave, Stop> {
    let order = if case.hostile() { case.count(3) as u32 } else { case.pick(&[1, 1, 2, 30]) };
    let wave = if case.chance(0.5) { wave.per_turn(order)? } else { wave };
    Ok(if case.chance(0.5) { wave.with_phase(case.number(1.0) * case.signed())? } else { wave })
}

/// Angles at which a function may jump: within a turn, or anywhere.
pub fn angles(case: &mut Case) -> Vec<f64> {
    (0..case.below(4)).map(|_| if case.hostile() { case.number(1.0) } else { TAU * case.unit() }).collect()
}

fn some(case: &mut Case, levels: usize, mean: f64) -> Result<Vec<Wave>, Stop> {
    let count = if case.hostile() { 0 } else { 1 + case.below(3) };
    (0..count).map(|_| wave(case, levels - 1, mean)).collect()
}

/// A user's excitation with any edges.
#[derive(Debug, PartialEq)]
struct Own {
    edges: Vec<f64>,
}

impl Excitation for Own {
    fn jet<A: Angle>(&self, angle: A) -> Jet<A::Number> {
        (Jet::variable(angle.number()) * 0.5).cos()
    }
    fn edges(&self) -> Vec<f64> {
        self.edges.clone()
    }
}

/// Checks an accepted wave at any angle.
pub fn any(case: &mut Case) -> Run {
    let scale = case.number(1.0);
    let one = if case.chance(0.9) {
        wave(case, 2, scale)?
    } else {
        let mut edges = angles(case);
        edges.extend(case.chance(0.2).then_some(case.number(10.0)));
        turned(case, Wave::new(Own { edges }))?
    };
    case.note(|| format!("{one:?}"));
    let mut angle = case.number(1.0) * case.signed();
    for _ in 0..20 {
        // Beyond this angle the resolution of numbers is too coarse.
        if angle.is_nan() || angle.abs() > 1e12 {
            break;
        }
        for side in [Side::Before, Side::After] {
            let (jet, value) = (one.jet(angle, side), one.value(angle, side));
            all_finite(
                format_args!("value and derivatives at {angle:e}"),
                &[jet.value, jet.rate, jet.second],
            )?;
            holds(
                value.to_bits() == jet.value.to_bits()
                    || (value - jet.value).abs() <= 1e-9 * value.abs().max(1e-300),
                || format!("value({angle:e}) is {value:e}, that of the jet {:e}", jet.value),
            )?;
        }
        let edge = one.next_edge(angle);
        holds(
            edge.is_none_or(|edge| edge > angle && edge <= angle + 1.1 * TAU + 1e-9 * angle.abs()),
            || format!("next_edge({angle:e}) is {edge:?}"),
        )?;
        angle = match edge {
            Some(edge) if case.chance(0.5) => edge,
            _ => angle + case.number(1.0) * case.signed(),
        };
    }
    holds(one == one.clone(), || "a copy is another wave".into())?;
    let other = wave(case, 1, scale)?;
    let (a, b) = (Wave::common_order([&one, &other]), Wave::common_order([&other, &one]));
    holds(a == b && a > 0, || format!("common order {a} or {b} of {} and {}", one.order(), other.order()))
}

/// Samples and their fits.
pub fn tables(case: &mut Case) -> Run {
    let (length, scale) = (4 + case.below(40), case.number(1.0));
    let samples = case.list(length, scale);
    case.note(|| format!("samples {samples:?}"));
    if let Some(table) = case.accept(Table::new(&samples)) {
        let table = Wave::new(table);
        for _ in 0..8 {
            let t = case.number(1.0);
            if t.abs() < 1e12 {
                let jet = table.jet(t, Side::After);
                all_finite(format_args!("table at {t:e}"), &[jet.value, jet.rate, jet.second])?;
            }
        }
    }
    let fit = Fourier::fit(&samples, case.count(3))?;
    case.note(|| format!("{fit:?}"));
    finite("mean of a fit", fit.mean())?;
    fit.pairs().iter().try_for_each(|pair| all_finite("amplitudes of a fit", pair))?;
    finite("value of a fit", fit.value(TAU * case.unit()))
}

/// Arithmetic of jets near sensible values.
pub fn jets(case: &mut Case) -> Run {
    let mut jet = Jet::new(1.0 + case.unit(), case.signed(), case.signed());
    for _ in 0..6 {
        let other = Jet::new(1.0 + case.unit(), case.signed(), case.signed());
        jet = match case.below(8) {
            0 => jet + other,
            1 => jet * other,
            2 => jet / other,
            3 => (jet * jet + 1.0).sqrt(),
            4 => jet.sin(),
            5 => jet.cos() * 0.5,
            6 => (-(jet * jet)).exp(),
            _ => jet - Jet::constant(case.signed()),
        };
        all_finite("jet", &[jet.value, jet.rate, jet.second])?;
    }
    let zero = (Jet::variable(0.0) * Jet::variable(0.0)).sqrt();
    finite("sqrt of t² at 0", zero.value)
}
