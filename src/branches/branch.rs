//! A branch of periodic orbits.

use crate::branches::line::{Line, LinePoint};
use crate::branches::points::branch_point::BranchPoint;
use crate::branches::points::kind::{PointKind, SpecialPoint};
use crate::error::{ParameterError, check};
use crate::export::ResultTable;
use crate::model::Channel;
use crate::periodic::{ShootingOrbit, Stability};
use std::fmt;

/// A curve of periodic orbits over a parameter: its points in order, the located ones among them.
///
/// ```
/// use gear_dynamics::{State, branches::{BranchEnd, Continuation, Family}, trains::SpurPair};
/// let pair = SpurPair::of_numbers(0.05, 0.1, &[-0.2], &[])?.parts()?.build("driver", 0.6)?;
/// let family = Family::over(&pair, ["speed"])?;
/// let branch = Continuation::new(0.6, 0.65).run(&family, &State::new(0.0, &[1.1], &[0.0]))?;
/// assert_eq!(branch.end(), &BranchEnd::Bound);
/// assert_eq!(branch.located().count(), 0);
/// let text = branch.to_string(); // a table: the first point and the located ones
/// assert!(text.contains("peak-to-peak deflection  stability after  point"), "{text}");
/// assert!(text.lines().nth(2).is_some_and(|line| line.ends_with("stable           first")), "{text}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type Branch<O = ShootingOrbit> = Line<BranchPoint<O>>;

/// What is common to the points of a branch.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BranchHead {
    pub(crate) parameter: Channel,
    pub(crate) channels: Vec<Channel>,
}

impl<O> LinePoint for BranchPoint<O> {
    type Head = BranchHead;

    fn parameters(&self) -> &[f64] {
        std::slice::from_ref(&self.parameter)
    }
    fn arclength(&self) -> f64 {
        self.arclength
    }
    fn set_arclength(&mut self, arclength: f64) {
        self.arclength = arclength;
    }
    fn check_head(_: &BranchHead) -> Result<(), ParameterError> {
        Ok(())
    }
    fn check(&self, head: &BranchHead, first: &Self) -> Result<(), ParameterError> {
        check::length("summaries of a point", self.summaries.len(), head.channels.len())?;
        self.summaries
            .iter()
            .enumerate()
            .try_for_each(|(i, summary)| summary.check(&format!("channel {i}")))?;
        check::length("rattle states of a point", self.rattle.len(), first.rattle.len())?;
        check::length("pairs of crossings of a point", self.crossings.len(), self.rattle.len())?;
        let [own, of_first] = [self, first].map(|point| point.multipliers.values().len());
        check::length("multipliers of a point", own, of_first)?;
        self.located.map_or(Ok(()), |what| what.check(self.rattle.len()))
    }
    fn reverse(&mut self) {
        if let Some(SpecialPoint::Grazing { rattle, .. }) = &mut self.located {
            rattle.reverse();
        }
    }
    fn summarise(line: &Branch<O>, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [low, high] = line.range(0);
        writeln!(f, "{} points, {} = {low} .. {high}", line.points.len(), line.parameter())?;
        let figure = line.channels().first().map(|channel| format!("peak-to-peak {channel}"));
        let parameter = line.parameter().to_string();
        let [left, right] = [parameter.len().max(18), figure.as_ref().map_or(0, String::len)];
        let figure = figure.unwrap_or_default();
        writeln!(f, "  {parameter:>left$}  {figure:>right$}  stability after  point")?;
        for (at, point) in line.points.iter().enumerate() {
            let what = match &point.located {
                Some(what) => what.to_string(),
                None if at == 0 => "first".into(),
                None => continue,
            };
            let value = if right > 0 { format!("{:.6e}", point.peak_to_peak()) } else { String::new() };
            let stability = line.stability_after(at);
            writeln!(f, "  {:>left$.12}  {value:>right$}  {stability:<15}  {what}", point.parameter)?;
        }
        Ok(())
    }
}

impl<O> Branch<O> {
    /// Name and unit of the parameter.
    pub fn parameter(&self) -> &Channel {
        &self.head.parameter
    }
    /// Names and units of the measured channels.
    pub fn channels(&self) -> &[Channel] {
        &self.head.channels
    }
    /// The located points with what they are.
    pub fn located(&self) -> impl Iterator<Item = (&SpecialPoint, &BranchPoint<O>)> {
        self.points.iter().filter_map(|point| point.located.as_ref().map(|what| (what, point)))
    }
    /// The located points of one kind: `branch.of_kind(PointKind::Fold)`.
    pub fn of_kind(&self, kind: PointKind) -> Vec<&BranchPoint<O>> {
        self.points.iter().filter(|point| point.kind() == Some(kind)).collect()
    }
    /// The stability of the points between point `at` and the next located one, in words: `stable`, or
    /// `stable, unstable` if it changes between them. After a bifurcation without such a point it is
    /// `undecided`.
    fn stability_after(&self, at: usize) -> String {
        let after = &self.points[at + 1..];
        let next = after.iter().position(|point| point.located.is_some()).unwrap_or(after.len());
        let located = self.points[at].located.as_ref();
        let is_critical = located.is_some_and(|what| !matches!(what, SpecialPoint::Grazing { .. }));
        if next == 0 && is_critical {
            // Its own multiplier lies on the unit circle.
            return Stability::Undecided.to_string();
        }
        let first = usize::from(located.is_some());
        let stretch = &self.points[at + first.min(next)..=at + next];
        let mut seen: Vec<Stability> = stretch.iter().map(BranchPoint::stability).collect();
        if seen.iter().any(|stability| *stability != Stability::Undecided) {
            seen.retain(|stability| *stability != Stability::Undecided);
        }
        seen.dedup();
        seen.iter().map(Stability::to_string).collect::<Vec<_>>().join(", ")
    }
    /// On each pass of the branch over `parameter`, the nearer of the two neighbouring points. Nothing is
    /// interpolated.
    pub fn near(&self, parameter: f64) -> Vec<&BranchPoint<O>> {
        let passes = self.points.windows(2).filter_map(|two| {
            let [a, b] = [two[0].parameter - parameter, two[1].parameter - parameter];
            (a * b <= 0.0).then(|| if a.abs() <= b.abs() { &two[0] } else { &two[1] })
        });
        let mut near: Vec<&BranchPoint<O>> = passes.collect();
        near.dedup_by(|a, b| std::ptr::eq(*a, *b));
        near
    }

    /// One row per point: the parameter, `arclength`, then
    ///
    /// - for each channel d `mean d`, `rms d` and `peak-to-peak d`, in its unit;
    /// - `multiplier i real` and `multiplier i imaginary`, by decreasing absolute value, and
    ///   `largest multiplier` |μ|;
    /// - `stability`: 1 stable, -1 unstable, 0 undecided;
    /// - for each contact `rattle state i`, and its sequence: the crossings of its edges in one
    ///   period, `crossings lower i` and `crossings upper i`;
    /// - `kind`: 0 for a regular point, otherwise the [code](PointKind::code) of the located one.
    ///
    /// # Errors
    /// [`ParameterError::Twice`] for a channel measured twice.
    pub fn table(&self) -> Result<ResultTable, ParameterError> {
        let mut columns = vec![self.head.parameter.clone(), Channel::new("arclength", "1")];
        let number = |name: String| Channel::new(name, "1");
        for Channel { name, unit } in &self.head.channels {
            let figures = ["mean", "rms", "peak-to-peak"];
            columns.extend(figures.map(|figure| Channel::new(format!("{figure} {name}"), unit.as_str())));
        }
        let first = self.points.first();
        let multipliers = first.map_or(0, |point| point.multipliers.values().len());
        for i in 0..multipliers {
            columns.extend(["real", "imaginary"].map(|part| number(format!("multiplier {i} {part}"))));
        }
        columns.extend(["largest multiplier", "stability"].map(|name| number(name.into())));
        for i in 0..first.map_or(0, |point| point.rattle.len()) {
            columns.extend(
                ["rattle state", "crossings lower", "crossings upper"].map(|n| number(format!("{n} {i}"))),
            );
        }
        columns.push(number("kind".into()));
        let mut table = ResultTable::new(columns)?;
        for point in &self.points {
            let mut row = vec![point.parameter, point.arclength];
            row.extend(point.summaries.iter().flat_map(|s| [s.mean, s.rms, s.peak_to_peak()]));
            row.extend(point.multipliers.values().iter().flat_map(|m| [m.re, m.im]));
            row.push(point.multipliers.largest());
            row.push(match point.stability() {
                Stability::Stable => 1.0,
                Stability::Unstable => -1.0,
                Stability::Undecided => 0.0,
            });
            for (rattle, [lower, upper]) in point.rattle.iter().zip(&point.crossings) {
                row.extend([f64::from(rattle.rsv()), f64::from(*lower), f64::from(*upper)]);
            }
            row.push(point.kind().map_or(0.0, |kind| f64::from(kind.code())));
            table.push(&row)?;
        }
        Ok(table)
    }
}
