//! Maps over two parameters.

use crate::draw::colours::Ink;
use crate::draw::layers::{Bar, Layer, Mark, Raster, Swatch};
use crate::error::PlotError;
use crate::panel::{Panel, name_and_unit};
use crate::pictures::spectra::borders;
use gear_dynamics::branches::BoundaryLine;
use gear_dynamics::sweep::{Row, Rows};

/// A quantity of each row as colour over the two parameters of a sweep, with a bar of colours. Rows without result and
/// quantities that are NaN are grey, with an entry in the legend.
///
/// `axes`: texts with units of the first and the second parameter. `value`: text with unit of the quantity `of` a row.
///
/// ```
/// use gear_dynamics::sweep::{Axis, LaneRk4, Points};
/// use gear_dynamics::{Sweep, models::Oscillator};
/// use gear_dynamics_plots::{Picture, map};
/// let swing = Oscillator::new(&[("speed", 1.0), ("damping", 0.2), ("linear stiffness", 2.0), ("force", 0.1)])?;
/// let axes = vec![Axis::linear("speed", 0.5, 1.0, 3)?, Axis::linear("force", 0.1, 0.2, 2)?];
/// let rows = Sweep::new(Points::grid(axes)?).settle(20).measure(1).channels(&["q0"]).over(&LaneRk4::new(64), &swing)?.run()?;
/// let swing = |row: &gear_dynamics::sweep::Row<'_>| row.channel("q0").map_or(f64::NAN, |q| q.peak_to_peak());
/// let panel = map(&rows, ["speed Ω [1]", "force [1]"], "peak-to-peak of q [1]", swing)?;
/// assert!(Picture::from(panel).to_svg().contains("peak-to-peak of q [1]"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`PlotError::NoGrid`] for points that are no grid over two parameters; [`PlotError::Empty`] if no row has a
/// result; [`PlotError::NotFinite`] for an infinite quantity; [`PlotError::NoUnit`].
pub fn map(
    rows: &Rows,
    axes: [&str; 2],
    value: &str,
    of: impl Fn(&Row<'_>) -> f64,
) -> Result<Panel, PlotError> {
    let [name, unit] = name_and_unit(value)?;
    let (mut panel, raster) = grid(rows, axes, &name, of, Vec::new())?;
    let known = || raster.values.iter().copied().filter(|value| !value.is_nan());
    let [low, high] =
        known().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
    let high = if high > low { high } else { low + low.abs().max(1.0) };
    panel.bar = Some(Bar { name, unit, range: [low, high], logarithmic: false });
    panel.layers.push(Layer::Raster(raster));
    Ok(panel)
}

/// Rattle states over the two parameters of a sweep, as areas of four colours. `contact`: the number of a contact, from
/// 0; `None`: the worst state of all contacts, in the order of the legend. A train has a contact for each mesh. The title
/// states what is shown if there are several.
///
/// ```
/// use gear_dynamics::sweep::{Axis, LaneRk4, Points};
/// use gear_dynamics::{Sweep, models::Oscillator};
/// use gear_dynamics_plots::{Picture, rattle_map};
/// let pair = Oscillator::new(&[
///     ("speed", 1.0), ("damping", 0.1), ("mesh stiffness", 1.0), ("mean force", 0.25), ("force", 0.25),
///     ("half backlash", 1.0),
/// ])?;
/// let axes = vec![Axis::linear("speed", 0.5, 1.0, 3)?, Axis::linear("force", 0.01, 0.25, 2)?];
/// let rows = Sweep::new(Points::grid(axes)?).settle(40).measure(2).rattle().over(&LaneRk4::new(64), &pair)?.run()?;
/// let svg = Picture::from(rattle_map(&rows, ["speed Ω [1]", "force [1]"], None)?).to_svg();
/// assert!(svg.contains("rattle: none"));
/// let refused = rattle_map(&rows, ["speed Ω [1]", "force [1]"], 1).unwrap_err();
/// assert_eq!(refused.to_string(), "contacts of the rows: there is no number 1, there are 1");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`map`]; [`PlotError::NoSuch`] for a contact that the rows do not have, [`PlotError::Empty`] for rows without
/// rattle states.
pub fn rattle_map(
    rows: &Rows,
    axes: [&str; 2],
    contact: impl Into<Option<usize>>,
) -> Result<Panel, PlotError> {
    let names = ["rattle: none", "rattle: unilateral", "rattle: bilateral", "rattle: floating"];
    let count = rows.iter().next().map_or(0, |row| row.contacts().len());
    let (shown, title) = match contact.into() {
        _ if count == 0 => return Err(PlotError::Empty { what: "contacts of the rows".into() }),
        Some(index) if index >= count => {
            return Err(PlotError::NoSuch { what: "contacts of the rows".into(), index, count });
        }
        Some(index) => (index..index + 1, format!("contact {index}")),
        None => (0..count, format!("worst of {count} contacts")),
    };
    let worst =
        |row: &Row<'_>| shown.clone().map(|i| usize::from(row.contacts()[i].rattle_state().rsv())).max();
    let panel = category_map(rows, axes, &names, worst)?;
    Ok(if count > 1 { panel.title(title) } else { panel })
}

/// A kind of each row, by its number among `names`, as areas over the two parameters of a sweep: an attractor, a
/// state. `None`: no result, drawn grey.
///
/// ```
/// use gear_dynamics::sweep::{Axis, LaneRk4, Points};
/// use gear_dynamics::{Sweep, models::Oscillator};
/// use gear_dynamics_plots::{Picture, category_map};
/// let swing = Oscillator::new(&[("speed", 1.0), ("damping", 0.2), ("linear stiffness", 2.0), ("force", 0.1)])?;
/// let axes = vec![Axis::linear("speed", 0.5, 1.0, 3)?, Axis::linear("force", 0.1, 0.2, 2)?];
/// let rows = Sweep::new(Points::grid(axes)?).settle(20).measure(1).over(&LaneRk4::new(64), &swing)?.run()?;
/// let slow = |row: &gear_dynamics::sweep::Row<'_>| Some(usize::from(row.point()["speed"] > 0.6));
/// let panel = category_map(&rows, ["speed Ω [1]", "force [1]"], &["slow", "fast"], slow)?;
/// assert!(Picture::from(panel).to_svg().contains(">fast</text>"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`map`]; [`PlotError::NoSuch`] for a number without a name.
pub fn category_map(
    rows: &Rows,
    axes: [&str; 2],
    names: &[&str],
    of: impl Fn(&Row<'_>) -> Option<usize>,
) -> Result<Panel, PlotError> {
    // The first kind is the lightest: usually the quiet one.
    let last = (names.len().max(2) - 1) as f64;
    let inks: Vec<Ink> = (0..names.len()).map(|i| Ink::Map(0.96 - 0.88 * i as f64 / last)).collect();
    let number = |row: &Row<'_>| of(row).map_or(f64::NAN, |number| number as f64);
    let (mut panel, raster) = grid(rows, axes, "kinds of the map", number, inks.clone())?;
    let largest = raster.values.iter().filter(|x| !x.is_nan()).fold(0.0f64, |most, x| most.max(*x)) as usize;
    if largest >= names.len() {
        let what = "names of the map".into();
        return Err(PlotError::NoSuch { what, index: largest, count: names.len() });
    }
    for (i, (name, ink)) in names.iter().zip(inks).enumerate() {
        if raster.values.contains(&(i as f64)) {
            panel.entry(name, Swatch::Field { ink, opacity: 1.0 });
        }
    }
    panel.layers.push(Layer::Raster(raster));
    Ok(panel)
}

/// The grid of the points with the values of the rows.
fn grid(
    rows: &Rows,
    axes: [&str; 2],
    what: &str,
    of: impl Fn(&Row<'_>) -> f64,
    inks: Vec<Ink>,
) -> Result<(Panel, Raster), PlotError> {
    let mut panel = Panel::new("", axes[0], axes[1])?;
    let points = rows.points();
    let found = points.len();
    let of_parameter = |k: usize| -> Vec<f64> {
        let mut values: Vec<f64> =
            (0..found).filter_map(|i| points.point(i).values().get(k).copied()).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    };
    let sides = [of_parameter(0), of_parameter(1)];
    let [columns, lines] = [sides[0].len(), sides[1].len()];
    if points.names().len() != 2 || found == 0 || columns * lines != found {
        return Err(PlotError::NoGrid { what: what.into(), found, columns, rows: lines });
    }
    let mut values = vec![f64::NAN; found];
    for row in rows.iter() {
        let point = row.point();
        let at = |k: usize| sides[k].partition_point(|side| *side < point.values()[k]);
        let value = of(&row);
        if value.is_infinite() {
            return Err(PlotError::NotFinite { what: what.into(), index: row.index(), value });
        }
        values[at(0) * lines + at(1)] = value;
    }
    let missing = values.iter().filter(|value| value.is_nan()).count();
    if missing == found {
        return Err(PlotError::Empty { what: what.into() });
    }
    if missing > 0 {
        panel.entry("no result", Swatch::Field { ink: Ink::Missing, opacity: 1.0 });
    }
    panel.parameters = Some([points.names()[0].clone(), points.names()[1].clone()]);
    Ok((panel, Raster { borders: [borders(&sides[0]), borders(&sides[1])], values, inks }))
}

impl Panel {
    /// The same map with a located boundary on it. A boundary over the parameters of the map in the other order is
    /// turned.
    ///
    /// ```
    /// use gear_dynamics::branches::{Continuation, Family, PointKind};
    /// use gear_dynamics::trains::SpurPair;
    /// use gear_dynamics_plots::{Picture, Panel};
    /// let pair = SpurPair::of_numbers(0.05, 0.1, &[0.2], &[0.05])?.parts()?.build("driver", 0.8)?;
    /// let branch = Continuation::new(0.8, 0.9).run(&Family::over(&pair, ["speed"])?, None)?;
    /// let plane = Family::over(&pair, ["speed", "mesh damping"])?;
    /// let line = Continuation::new(0.1, 0.12).run(&plane, branch.of_kind(PointKind::Grazing)[0])?;
    /// let panel = Panel::new("", "speed Ω [1]", "damping [1]")?.boundary("onset of contact loss", &line)?;
    /// assert!(Picture::from(panel).to_svg().contains("onset of contact loss"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`PlotError::Empty`], [`PlotError::NotFinite`].
    pub fn boundary(self, label: &str, line: &BoundaryLine) -> Result<Self, PlotError> {
        let [first, second] = line.parameters().each_ref().map(|channel| &channel.name);
        let turned = self.parameters.as_ref().is_some_and(|[x, y]| x == second && y == first);
        let points: Vec<_> = line.points().iter().map(|point| point.parameters).collect();
        self.series(label, Mark::Line, points.into_iter().map(|[p, q]| if turned { (q, p) } else { (p, q) }))
    }
    /// The same map with a dot at each row of a kind, for example at those that [are
    /// sensitive](Row::is_sensitive). If there is none, nothing is added.
    ///
    /// ```
    /// use gear_dynamics::sweep::{Axis, LaneRk4, Points};
    /// use gear_dynamics::{Sweep, models::Oscillator};
    /// use gear_dynamics_plots::{Picture, rattle_map};
    /// let pair = Oscillator::new(&[
    ///     ("speed", 1.0), ("damping", 0.1), ("mesh stiffness", 1.0), ("mean force", 0.25), ("force", 0.25),
    ///     ("half backlash", 1.0),
    /// ])?;
    /// let axes = vec![Axis::linear("speed", 0.5, 1.0, 3)?, Axis::linear("force", 0.01, 0.25, 2)?];
    /// let rows = Sweep::new(Points::grid(axes)?).settle(2).measure(2).rattle().over(&LaneRk4::new(64), &pair)?.run()?;
    /// let panel = rattle_map(&rows, ["speed Ω [1]", "force [1]"], None)?;
    /// let panel = panel.mark_rows("sensitive", &rows, |row| row.is_sensitive())?;
    /// assert!(Picture::from(panel).to_svg().contains(">sensitive</text>"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`PlotError::Empty`] for a panel that is no map, and for rows without its parameters.
    pub fn mark_rows(
        self,
        label: &str,
        rows: &Rows,
        is: impl Fn(&Row<'_>) -> bool,
    ) -> Result<Self, PlotError> {
        let empty = |what: String| PlotError::Empty { what };
        let names = self.parameters.as_ref().ok_or_else(|| empty(format!("map under {label}")))?;
        let column = |name: &String| rows.points().names().iter().position(|known| known == name);
        let [Some(x), Some(y)] = names.each_ref().map(column) else {
            return Err(empty(format!("rows over {} and {}", names[0], names[1])));
        };
        let at = |row: Row<'_>| (row.point().values()[x], row.point().values()[y]);
        let found: Vec<(f64, f64)> = rows.iter().filter(is).map(at).collect();
        if found.is_empty() { Ok(self) } else { self.series(label, Mark::Specks, found) }
    }
    /// The same map with a logarithmic scale of its colours.
    ///
    /// # Errors
    /// [`PlotError::NotPositive`] if a value is not positive; [`PlotError::Empty`] for a panel without a scale of
    /// colours.
    pub fn logarithmic_colours(mut self) -> Result<Self, PlotError> {
        let Some(bar) = &mut self.bar else {
            return Err(PlotError::Empty { what: "scale of colours".into() });
        };
        if bar.range[0] <= 0.0 {
            return Err(PlotError::NotPositive { what: bar.name.clone(), value: bar.range[0] });
        }
        bar.logarithmic = true;
        Ok(self)
    }
}
