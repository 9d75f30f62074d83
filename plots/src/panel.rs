//! A panel: axes and what is drawn between them.

use crate::draw::colours::Ink;
use crate::draw::layers::{Bar, Curve, Entry, Layer, Mark, Swatch, THIN};
use crate::error::{PlotError, finite};

/// An axis: name, unit, and what of it is shown.
#[derive(Clone, Debug, Default)]
pub(crate) struct Axis {
    pub(crate) name: String,
    pub(crate) unit: String,
    pub(crate) logarithmic: bool,
    pub(crate) range: Option<[f64; 2]>,
    /// Values with a name: an order, a speed.
    pub(crate) named: Vec<(f64, String)>,
}

impl Axis {
    pub(crate) fn new(text: &str) -> Result<Self, PlotError> {
        let [name, unit] = name_and_unit(text)?;
        Ok(Axis { name, unit, ..Axis::default() })
    }
}

/// The name and the unit of a text "name [unit]".
pub(crate) fn name_and_unit(text: &str) -> Result<[String; 2], PlotError> {
    let parts = text.strip_suffix(']').and_then(|text| text.rsplit_once('['));
    match parts {
        Some((name, unit)) if !unit.trim().is_empty() => Ok([name.trim().into(), unit.trim().into()]),
        _ => Err(PlotError::NoUnit { axis: text.into() }),
    }
}

/// Axes with units, and the series between them.
///
/// Every picture of this crate is a panel: one call makes it from a result, and [`series`](Panel::series) adds series
/// to it. A text of an axis has the form `name [unit]`, `name [1]` without dimension. Numbers are in this unit; the
/// axis shows them with a prefix where that is shorter, such as μm for 10⁻⁶ m.
///
/// ```
/// use gear_dynamics_plots::{Picture, Mark, Panel};
/// let swing = |k: u32| (0.1 * f64::from(k), 3e-5 * (0.1 * f64::from(k)).sin());
/// let panel = Panel::new("free swing", "time [s]", "deflection [m]")?.series("mesh 1", Mark::Line, (0..100).map(swing))?;
/// let svg = Picture::from(panel.note((1.6, 3e-5), "largest")?).to_svg();
/// assert!(svg.contains("deflection [μm]") && svg.contains(">largest</text>"));
/// # Ok::<(), gear_dynamics_plots::PlotError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Panel {
    pub(crate) title: String,
    pub(crate) x: Axis,
    pub(crate) y: Axis,
    pub(crate) layers: Vec<Layer>,
    pub(crate) legend: Vec<Entry>,
    pub(crate) bar: Option<Bar>,
    /// Names of the parameters along x and y of a map.
    pub(crate) parameters: Option<[String; 2]>,
    /// Whether both axes have one scale.
    pub(crate) equal: bool,
    /// Labels of the series so far; the place is the number of the series.
    labels: Vec<String>,
}

impl Panel {
    /// A panel without series.
    ///
    /// # Errors
    /// [`PlotError::NoUnit`] for an axis without unit.
    pub fn new(title: impl Into<String>, x: &str, y: &str) -> Result<Self, PlotError> {
        Ok(Panel {
            title: title.into(),
            x: Axis::new(x)?,
            y: Axis::new(y)?,
            layers: Vec::new(),
            legend: Vec::new(),
            bar: None,
            parameters: None,
            equal: false,
            labels: Vec::new(),
        })
    }
    /// The same panel with another title.
    pub fn title(self, title: impl Into<String>) -> Self {
        Panel { title: title.into(), ..self }
    }
    /// The same panel with another text of the x axis: of a model in a time unit of its own, for example.
    ///
    /// # Errors
    /// [`PlotError::NoUnit`].
    pub fn x(mut self, text: &str) -> Result<Self, PlotError> {
        [self.x.name, self.x.unit] = name_and_unit(text)?;
        Ok(self)
    }
    /// The same panel with another text of the y axis.
    ///
    /// # Errors
    /// [`PlotError::NoUnit`].
    pub fn y(mut self, text: &str) -> Result<Self, PlotError> {
        [self.y.name, self.y.unit] = name_and_unit(text)?;
        Ok(self)
    }
    /// The same panel with one more series of points. A label that the panel has already continues its series: pieces
    /// of one curve are added one by one. An empty label has no entry in the legend.
    ///
    /// # Errors
    /// [`PlotError::Empty`], [`PlotError::NotFinite`]; [`PlotError::NotPositive`] on a logarithmic axis.
    pub fn series(
        mut self,
        label: &str,
        mark: Mark,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Result<Self, PlotError> {
        let number = self.number(label);
        let style = if mark == Mark::Dashed { THIN } else { number };
        let width = match mark {
            Mark::Line | Mark::Directed => 1.5,
            Mark::Specks => 1.6,
            Mark::Bars => 2.0,
            _ => 1.2,
        };
        let points = points.into_iter().map(|(x, y)| [x, y]).collect();
        self.curve(label, Curve { mark, ink: Ink::Series(number), style, width, points })?;
        Ok(self)
    }
    /// The same panel with its last series below all others.
    pub fn below(mut self) -> Self {
        let last = self.layers.pop();
        self.layers.splice(..0, last);
        self
    }
    /// The same panel with its last series in black, so that its colour stands for nothing.
    pub fn black(self) -> Self {
        self.inked(Ink::Text)
    }
    /// The same panel with its last series in grey.
    pub fn grey(self) -> Self {
        self.inked(Ink::Grey)
    }
    fn inked(mut self, ink: Ink) -> Self {
        if let Some(Layer::Curve(curve)) = self.layers.last_mut() {
            curve.ink = ink;
        }
        if let Some(entry) = self.legend.last_mut() {
            entry.swatch = entry.swatch.inked(ink);
        }
        self
    }
    /// The same panel with a text beside a point, on the side where it covers least.
    ///
    /// # Errors
    /// [`PlotError::NotFinite`]; [`PlotError::NotPositive`] on a logarithmic axis.
    pub fn note(mut self, at: (f64, f64), text: &str) -> Result<Self, PlotError> {
        finite(text, [&at.0, &at.1])?;
        let (at, text) = ([at.0, at.1], text.to_owned());
        for (axis, value) in [&self.x, &self.y].into_iter().zip(at) {
            if axis.logarithmic && value <= 0.0 {
                return Err(PlotError::NotPositive { what: text, value });
            }
        }
        self.layers.push(Layer::Note { places: vec![at], text });
        Ok(self)
    }
    /// The number of a series: that of its label, or the next one.
    pub(crate) fn number(&mut self, label: &str) -> usize {
        let known = self.labels.iter().position(|known| !label.is_empty() && known == label);
        known.unwrap_or_else(|| {
            self.labels.push(label.into());
            self.labels.len() - 1
        })
    }
    /// Adds a curve of given colour.
    pub(crate) fn curve(&mut self, label: &str, curve: Curve) -> Result<(), PlotError> {
        let what = if label.is_empty() { &self.y.name } else { label };
        if curve.points.is_empty() {
            return Err(PlotError::Empty { what: what.into() });
        }
        for (index, point) in curve.points.iter().enumerate() {
            if let Some(&value) = point.iter().find(|value| !value.is_finite()) {
                return Err(PlotError::NotFinite { what: what.into(), index, value });
            }
        }
        for (axis, at) in [(&self.x, 0), (&self.y, 1)] {
            let wrong = curve.points.iter().map(|point| point[at]).find(|value| *value <= 0.0);
            if let (true, Some(value)) = (axis.logarithmic, wrong) {
                return Err(PlotError::NotPositive { what: what.into(), value });
            }
        }
        let Curve { mark, ink, style, width, .. } = curve;
        let cased = self.layers.iter().any(|layer| matches!(layer, Layer::Raster(_)));
        self.entry(
            label,
            match mark {
                Mark::Line | Mark::Dashed | Mark::Bars => Swatch::Line { ink, style, width, cased },
                Mark::Directed => Swatch::Directed { ink },
                Mark::Dots => Swatch::Dot { ink: if cased { Ink::Text } else { ink }, style },
                Mark::Rings => Swatch::Ring { ink, style },
                Mark::Joined => Swatch::Joined { ink, style },
                Mark::Specks => Swatch::Speck { ink: if cased { Ink::Text } else { ink }, cased },
                Mark::Area => Swatch::Field { ink, opacity: 0.28 },
            },
        );
        self.layers.push(Layer::Curve(curve));
        Ok(())
    }
    /// Adds an entry to the legend, once for each label.
    pub(crate) fn entry(&mut self, label: &str, swatch: Swatch) {
        if !label.is_empty() && self.legend.iter().all(|entry| entry.label != label) {
            self.legend.push(Entry { label: label.into(), swatch });
        }
    }
    /// The same panel with a logarithmic x axis.
    ///
    /// # Errors
    /// [`PlotError::NotPositive`] if a number of a series or the range is not positive.
    pub fn logarithmic_x(mut self) -> Result<Self, PlotError> {
        self.x.logarithmic = true;
        self.positive(0)
    }
    /// The same panel with a logarithmic y axis.
    ///
    /// # Errors
    /// [`PlotError::NotPositive`] if a number of a series or the range is not positive.
    pub fn logarithmic_y(mut self) -> Result<Self, PlotError> {
        self.y.logarithmic = true;
        self.positive(1)
    }
    fn positive(self, at: usize) -> Result<Self, PlotError> {
        let curves = self.layers.iter().filter_map(|layer| match layer {
            Layer::Curve(curve) => Some(curve),
            _ => None,
        });
        let wrong = curves.flat_map(|c| &c.points).map(|p| p[at]).find(|value| *value <= 0.0);
        let axis = if at == 0 { &self.x } else { &self.y };
        let wrong = wrong.or(axis.range.map(|[low, _]| low).filter(|low| *low <= 0.0));
        match wrong {
            Some(value) => Err(PlotError::NotPositive { what: axis.name.clone(), value }),
            None => Ok(self),
        }
    }
    /// The same panel with a part of the x axis.
    ///
    /// # Errors
    /// [`PlotError::Range`].
    pub fn x_range(mut self, low: f64, high: f64) -> Result<Self, PlotError> {
        self.x.range = Some(range(&self.x, low, high)?);
        Ok(self)
    }
    /// The same panel with a part of the y axis.
    ///
    /// # Errors
    /// [`PlotError::Range`].
    pub fn y_range(mut self, low: f64, high: f64) -> Result<Self, PlotError> {
        self.y.range = Some(range(&self.y, low, high)?);
        Ok(self)
    }
    /// The same panel with named values of x, such as orders of meshes: a dotted line with a name above the panel.
    ///
    /// # Errors
    /// [`PlotError::NotFinite`].
    pub fn name_x(mut self, names: &[(f64, &str)]) -> Result<Self, PlotError> {
        self.x.named.extend(named(&self.x, names)?);
        Ok(self)
    }
    /// The same panel with named values of y: a dotted line with a name beside the panel.
    ///
    /// # Errors
    /// [`PlotError::NotFinite`].
    pub fn name_y(mut self, names: &[(f64, &str)]) -> Result<Self, PlotError> {
        self.y.named.extend(named(&self.y, names)?);
        Ok(self)
    }
}

fn range(axis: &Axis, low: f64, high: f64) -> Result<[f64; 2], PlotError> {
    let positive = !axis.logarithmic || low > 0.0;
    if low.is_finite() && high.is_finite() && low < high && positive {
        return Ok([low, high]);
    }
    Err(PlotError::Range { what: format!("range of {}", axis.name), range: [low, high] })
}

fn named(axis: &Axis, names: &[(f64, &str)]) -> Result<Vec<(f64, String)>, PlotError> {
    if !names.is_empty() {
        finite(&format!("named values of {}", axis.name), names.iter().map(|(value, _)| value))?;
    }
    Ok(names.iter().map(|(value, name)| (*value, (*name).to_owned())).collect())
}
