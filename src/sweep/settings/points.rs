//! The points of a sweep: axes, grids, lists.

use crate::error::{ParameterError, check};
use std::ops::Index;

/// The values of one parameter: equally spaced and increasing, or a list in any order.
///
/// ```
/// use gear_dynamics::sweep::Axis;
/// assert_eq!(Axis::linear("speed", 100.0, 250.0, 4)?.values(), [100.0, 150.0, 200.0, 250.0]);
/// assert!(Axis::linear("speed", 250.0, 100.0, 4).is_err());
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    name: String,
    values: Vec<f64>,
}

impl Axis {
    /// `count` equally spaced values x_i = from + (to - from) i/(count - 1), both ends included.
    ///
    /// # Errors
    /// An end that is not finite or outside ±1e50; `to` not above `from`, or more than 1e50 above it; fewer
    /// than 2 values or more than 2²⁶.
    pub fn linear(name: &str, from: f64, to: f64, count: usize) -> Result<Self, ParameterError> {
        check::quantity(format!("start of axis {name}"), from)?;
        check::quantity(format!("end of axis {name}"), to)?;
        check::positive(format!("length of axis {name} from {from:?} to {to:?}"), to - from)?;
        check::at_least(format!("values on axis {name}"), count, 2)?;
        check::count(format!("values on axis {name}"), &[count], check::NUMBERS)?;
        let last = (count - 1) as f64;
        let value = |i: usize| if i + 1 == count { to } else { from + (to - from) * (i as f64 / last) };
        Ok(Axis { name: name.into(), values: (0..count).map(value).collect() })
    }

    /// Given values in any order.
    ///
    /// # Errors
    /// An empty list, or values that are not finite.
    pub fn of_values(name: &str, values: &[f64]) -> Result<Self, ParameterError> {
        if values.is_empty() {
            return Err(ParameterError::Empty { name: format!("axis {name}"), min: 1 });
        }
        check::all_finite(&format!("axis {name}"), values)?;
        Ok(Axis { name: name.into(), values: values.to_vec() })
    }

    /// The name of the parameter.
    pub fn name(&self) -> &str {
        &self.name
    }
    /// The values of the parameter.
    pub fn values(&self) -> &[f64] {
        &self.values
    }
}

/// The points of a sweep: the values of one [`Axis`], a grid of axes or a list. In a grid the last axis
/// varies fastest.
///
/// ```
/// use gear_dynamics::sweep::{Axis, Points};
/// let grid = Points::grid(vec![Axis::of_values("a", &[1.0, 2.0])?, Axis::of_values("b", &[5.0, 6.0, 7.0])?])?;
/// assert_eq!(grid.len(), 6);
/// assert_eq!((grid.point(4)["a"], grid.point(4)["b"]), (2.0, 6.0));
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Points {
    names: Vec<String>,
    pub(crate) kind: PointsKind,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum PointsKind {
    Grid(Vec<Axis>),
    /// The rows of all points, concatenated.
    List(Vec<f64>),
}

impl From<Axis> for Points {
    fn from(axis: Axis) -> Self {
        Points { names: vec![axis.name.clone()], kind: PointsKind::Grid(vec![axis]) }
    }
}

impl Points {
    /// Every combination of the values of the axes.
    ///
    /// # Errors
    /// No axis; two axes of the same name; more than `usize::MAX` points.
    pub fn grid(axes: Vec<Axis>) -> Result<Self, ParameterError> {
        if axes.is_empty() {
            return Err(ParameterError::Empty { name: "axes of the grid".into(), min: 1 });
        }
        let lengths = || axes.iter().map(|axis| axis.values.len());
        if lengths().try_fold(1, usize::checked_mul).is_none() {
            let value = lengths().map(|length| length as f64).product();
            return Err(ParameterError::OutOfRange {
                name: "points of the grid".into(),
                value,
                allowed: "[1, usize::MAX]",
            });
        }
        Ok(Points {
            names: different(axes.iter().map(|axis| axis.name.as_str()))?,
            kind: PointsKind::Grid(axes),
        })
    }

    /// A list of points: named columns, one row for each point.
    ///
    /// # Errors
    /// No rows or no names; a row whose length differs from the number of names; two columns of the same
    /// name; a value that is not finite.
    pub fn of_rows(names: &[&str], rows: &[Vec<f64>]) -> Result<Self, ParameterError> {
        if rows.is_empty() || names.is_empty() {
            return Err(ParameterError::Empty { name: "list of points".into(), min: 1 });
        }
        for (i, row) in rows.iter().enumerate() {
            check::length(format!("point {i}"), row.len(), names.len())?;
            check::all_finite(&format!("point {i}"), row)?;
        }
        Ok(Points { names: different(names.iter().copied())?, kind: PointsKind::List(rows.concat()) })
    }

    /// [`of_rows`](Points::of_rows) from concatenated rows.
    pub(crate) fn flat(names: &[String], values: Vec<f64>) -> Result<Self, ParameterError> {
        if values.is_empty() || names.is_empty() {
            return Err(ParameterError::Empty { name: "list of points".into(), min: 1 });
        }
        let last = values.len() % names.len();
        if last != 0 {
            check::length("values of the last point", last, names.len())?;
        }
        for (i, row) in values.chunks(names.len()).enumerate() {
            if row.iter().any(|x| !x.is_finite()) {
                check::all_finite(&format!("point {i}"), row)?;
            }
        }
        Ok(Points { names: different(names.iter().map(String::as_str))?, kind: PointsKind::List(values) })
    }

    /// The number of points.
    pub fn len(&self) -> usize {
        match &self.kind {
            PointsKind::Grid(axes) => axes.iter().map(|axis| axis.values.len()).product(),
            PointsKind::List(values) => values.len() / self.names.len(),
        }
    }
    /// Always `false`: a sweep has at least one point.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// The names of the parameters.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The number of consecutive points that form a line: with a [`WarmStart`](crate::sweep::WarmStart), each
    /// run on a line starts in the state in which its neighbour ended. It is the length of the last axis of a
    /// grid, or of the whole list.
    pub(crate) fn line(&self) -> usize {
        match &self.kind {
            PointsKind::Grid(axes) => axes.last().map_or(1, |axis| axis.values.len()),
            PointsKind::List(_) => self.len(),
        }
    }

    /// Point `index`, counted from 0.
    ///
    /// # Panics
    /// If `index` is not below the number of points.
    pub fn point(&self, index: usize) -> Point<'_> {
        assert!(index < self.len(), "point {index} does not exist: there are {}", self.len());
        let values = match &self.kind {
            PointsKind::List(values) => values[index * self.names.len()..][..self.names.len()].to_vec(),
            PointsKind::Grid(axes) => {
                let mut rest = index;
                let mut values: Vec<f64> = axes
                    .iter()
                    .rev()
                    .map(|axis| {
                        let value = axis.values[rest % axis.values.len()];
                        rest /= axis.values.len();
                        value
                    })
                    .collect();
                values.reverse();
                values
            }
        };
        Point { index, names: &self.names, values }
    }
}

/// The names as a list; an error if two are the same.
fn different<'n>(names: impl Iterator<Item = &'n str>) -> Result<Vec<String>, ParameterError> {
    let names: Vec<String> = names.map(str::to_owned).collect();
    match names.iter().enumerate().find(|(i, name)| names[..*i].contains(name)) {
        Some((_, name)) => Err(ParameterError::Twice { name: name.clone() }),
        None => Ok(names),
    }
}

/// One point of a sweep: named values.
///
/// ```
/// use gear_dynamics::sweep::{Axis, Points};
/// let points = Points::from(Axis::of_values("load", &[10.0, 30.0])?);
/// let point = points.point(1);
/// assert_eq!((point.index(), point["load"], point.get("speed")), (1, 30.0, None));
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Point<'p> {
    index: usize,
    names: &'p [String],
    values: Vec<f64>,
}

impl Point<'_> {
    /// The index of the point in the sweep, counted from 0.
    pub fn index(&self) -> usize {
        self.index
    }
    /// The parameter values, in the order of the names.
    pub fn values(&self) -> &[f64] {
        &self.values
    }
    /// The value of parameter `name`; `None` if there is no such parameter.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.names.iter().position(|n| n == name).map(|i| self.values[i])
    }
}

impl Index<&str> for Point<'_> {
    type Output = f64;

    /// The value of parameter `name`.
    ///
    /// # Panics
    /// If there is no parameter of that name.
    fn index(&self, name: &str) -> &f64 {
        let place = self.names.iter().position(|n| n == name);
        assert!(place.is_some(), "no parameter \"{name}\" among {:?}", self.names);
        &self.values[place.unwrap_or(0)]
    }
}
