//! Branches of periodic orbits.

use crate::draw::colours::Ink;
use crate::draw::layers::{Curve, Mark, THIN};
use crate::error::PlotError;
use crate::panel::Panel;
use gear_dynamics::branches::{Branch, BranchPoint, PointKind};
use gear_dynamics::periodic::Stability;

/// The kinds of located points, with their names.
const KINDS: [(PointKind, &str); 6] = [
    (PointKind::Fold, "fold"),
    (PointKind::PeriodDoubling, "period doubling"),
    (PointKind::NeimarkSacker, "Neimark-Sacker"),
    (PointKind::Branch, "crossing of branches"),
    (PointKind::SymmetryBreaking, "symmetry breaking"),
    (PointKind::Grazing, "grazing"),
];

/// A quantity of the orbits over the parameter: stable ones solid, all others dashed, located points marked by kind.
///
/// `axes`: texts with units of the parameter and the quantity. `of`: the quantity, for example
/// [`BranchPoint::peak_to_peak`].
///
/// ```
/// use gear_dynamics::branches::{BranchPoint, Continuation, Family};
/// use gear_dynamics::trains::SpurPair;
/// use gear_dynamics_plots::{Picture, branch};
/// let pair = SpurPair::of_numbers(0.05, 0.1, &[0.2], &[0.05])?.parts()?.build("driver", 0.8)?;
/// let line = Continuation::new(0.8, 1.0).run(&Family::over(&pair, ["speed"])?, None)?;
/// let panel = branch(&[&line], ["speed Ω [1]", "peak-to-peak value [1]"], BranchPoint::peak_to_peak)?;
/// let svg = Picture::from(panel).to_svg();
/// assert!(svg.contains(">stable</text>") && svg.contains(">grazing</text>"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`PlotError::Empty`] for branches without two points, [`PlotError::NotFinite`], [`PlotError::NoUnit`].
pub fn branch<O>(
    branches: &[&Branch<O>],
    axes: [&str; 2],
    of: impl Fn(&BranchPoint<O>) -> f64,
) -> Result<Panel, PlotError> {
    let mut panel = Panel::new("", axes[0], axes[1])?;
    let place = |point: &BranchPoint<O>| [point.parameter, of(point)];
    if branches.iter().all(|branch| branch.points().len() < 2) {
        return Err(PlotError::Empty { what: "points of the branch".into() });
    }
    // Stability is undecided where a multiplier is 1 to its accuracy. That of a located point is meant to be.
    let mut points = branches.iter().flat_map(|branch| branch.points());
    let undecided = points.any(|point| point.located.is_none() && point.stability() == Stability::Undecided);
    let others = if undecided { "unstable or undecided" } else { "unstable" };
    // Series that are added later differ from both in colour.
    for label in ["stable", others] {
        panel.number(label);
    }
    for stable in [true, false] {
        for piece in branches.iter().flat_map(|branch| pieces(branch, stable)) {
            let points = piece.iter().map(place).collect();
            let (label, style, ink) =
                if stable { ("stable", 0, Ink::Series(0)) } else { (others, THIN, Ink::Series(1)) };
            panel.curve(label, Curve { mark: Mark::Line, ink, style, width: 1.7, points })?;
        }
    }
    // A bifurcation lies on the grazings beside it.
    for (style, (kind, name)) in KINDS.into_iter().enumerate().rev() {
        let found = branches.iter().flat_map(|branch| branch.of_kind(kind));
        let points: Vec<_> = found.map(place).collect();
        if !points.is_empty() {
            // Grazings are open: a fold shows inside.
            let (mark, style) =
                if kind == PointKind::Grazing { (Mark::Rings, 0) } else { (Mark::Dots, style) };
            panel.curve(name, Curve { mark, ink: Ink::Text, style, width: 1.0, points })?;
        }
    }
    Ok(panel)
}

/// The longest pieces of one stability. A located bifurcation is undecided: its neighbours decide.
fn pieces<O>(branch: &Branch<O>, stable: bool) -> Vec<&[BranchPoint<O>]> {
    let points = branch.points();
    let is_stable = |i: usize| {
        let two = &points[i..i + 2];
        let is = |stability: Stability| two.iter().any(|point| point.stability() == stability);
        is(Stability::Stable) && !is(Stability::Unstable)
    };
    let mut pieces = Vec::new();
    let mut start = 0;
    let spans = points.len().saturating_sub(1);
    for i in 0..spans {
        if i + 1 == spans || is_stable(i + 1) != is_stable(i) {
            if is_stable(i) == stable {
                pieces.push(&points[start..i + 2]);
            }
            start = i + 1;
        }
    }
    pieces
}
