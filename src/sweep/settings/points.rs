//! What is swept: axes, grids and lists of points.

use crate::error::{ParameterError, check};
use std::ops::Index;

/// The values that one parameter takes, increasing or as listed.
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
    /// `count` equally spaced values, both ends included.
    ///
    /// # Errors
    /// Ends that are not finite or not in order, or so far apart that their distance is not finite; fewer than two values or more than 2²⁶.
    pub fn linear(name: &str, from: f64, to: f64, count: usize) -> Result<Self, ParameterError> {
        check::quantity(format!("start of axis {name}"), from)?;
        check::quantity(format!("end of axis {name}"), to)?;
        check::positive(format!("length of axis {name}, its end less its start"), to - from)?;
        if count < 2 {
            return Err(ParameterError::TooFew {
                name: format!("values on axis {name}"),
                value: count,
                least: 2,
            });
        }
        check::count(format!("values on axis {name}"), &[count], check::NUMBERS)?;
        let last = (count - 1) as f64;
        let value = |i: usize| if i + 1 == count { to } else { from + (to - from) * (i as f64 / last) };
        Ok(Axis { name: name.into(), values: (0..count).map(value).collect() })
    }

    /// Given values in any order.
    ///
    /// # Errors
    /// An empty list, or values that are not finite.
    pub fn list(name: &str, values: &[f64]) -> Result<Self, ParameterError> {
        if values.is_empty() {
            return Err(ParameterError::Empty { name: format!("axis {name}"), least: 1 });
        }
        check::all_finite(&format!("axis {name}"), values)?;
        Ok(Axis { name: name.into(), values: values.to_vec() })
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }
    /// Its values.
    pub fn values(&self) -> &[f64] {
        &self.values
    }
}

/// The points of a sweep: a grid of axes, the last one running fastest, or a list.
///
/// ```
/// use gear_dynamics::sweep::{Axis, Points};
/// let grid = Points::grid(vec![Axis::list("a", &[1.0, 2.0])?, Axis::list("b", &[5.0, 6.0, 7.0])?])?;
/// assert_eq!(grid.len(), 6);
/// assert_eq!((grid.point(4)["a"], grid.point(4)["b"]), (2.0, 6.0));
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Points {
    names: Vec<String>,
    kind: Kind,
}

#[derive(Clone, Debug, PartialEq)]
enum Kind {
    Grid(Vec<Axis>),
    /// All rows one after the other.
    List(Vec<f64>),
}

impl Points {
    /// Every combination of the values of the axes.
    ///
    /// # Errors
    /// No axis at all, two of one name, more points than can be counted.
    pub fn grid(axes: Vec<Axis>) -> Result<Self, ParameterError> {
        if axes.is_empty() {
            return Err(ParameterError::Empty { name: "axes of the grid".into(), least: 1 });
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
        Ok(Points { names: different(axes.iter().map(|axis| axis.name.as_str()))?, kind: Kind::Grid(axes) })
    }

    /// One axis.
    pub fn along(axis: Axis) -> Self {
        Points { names: vec![axis.name.clone()], kind: Kind::Grid(vec![axis]) }
    }

    /// Named columns, one row for each point.
    ///
    /// # Errors
    /// No rows, rows of another length than the names, two columns of one name, values that are not finite.
    pub fn list(names: &[&str], rows: &[Vec<f64>]) -> Result<Self, ParameterError> {
        if rows.is_empty() || names.is_empty() {
            return Err(ParameterError::Empty { name: "list of points".into(), least: 1 });
        }
        for (i, row) in rows.iter().enumerate() {
            check::length(format!("point {i}"), row.len(), names.len())?;
            check::all_finite(&format!("point {i}"), row)?;
        }
        Ok(Points { names: different(names.iter().copied())?, kind: Kind::List(rows.concat()) })
    }

    /// The same from rows that follow one another.
    pub(crate) fn flat(names: &[String], values: Vec<f64>) -> Result<Self, ParameterError> {
        if values.is_empty() || names.is_empty() {
            return Err(ParameterError::Empty { name: "list of points".into(), least: 1 });
        }
        for (i, row) in values.chunks(names.len()).enumerate() {
            if row.iter().any(|x| !x.is_finite()) {
                check::all_finite(&format!("point {i}"), row)?;
            }
        }
        Ok(Points { names: different(names.iter().map(String::as_str))?, kind: Kind::List(values) })
    }

    /// How many points.
    pub fn len(&self) -> usize {
        match &self.kind {
            Kind::Grid(axes) => axes.iter().map(|axis| axis.values.len()).product(),
            Kind::List(values) => values.len() / self.names.len(),
        }
    }
    /// Never: a sweep has at least one point.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// The names of the parameters.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Neighbours in a row along which a state may be carried: the last axis of a grid, or the whole list.
    pub(crate) fn line(&self) -> usize {
        match &self.kind {
            Kind::Grid(axes) => axes.last().map_or(1, |axis| axis.values.len()),
            Kind::List(_) => self.len(),
        }
    }

    /// Point `index`.
    ///
    /// # Panics
    /// If there is no such point.
    pub fn point(&self, index: usize) -> Point<'_> {
        assert!(index < self.len(), "point {index} of {}", self.len());
        let values = match &self.kind {
            Kind::List(values) => values[index * self.names.len()..][..self.names.len()].to_vec(),
            Kind::Grid(axes) => {
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

/// The names, if no two are the same.
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
/// let points = Points::along(Axis::list("load", &[10.0, 30.0])?);
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
    /// Its place in the sweep.
    pub fn index(&self) -> usize {
        self.index
    }
    /// Its values, in the order of the names.
    pub fn values(&self) -> &[f64] {
        &self.values
    }
    /// The value of a parameter, if there is one of that name.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.names.iter().position(|n| n == name).map(|i| self.values[i])
    }
}

impl Index<&str> for Point<'_> {
    type Output = f64;

    /// # Panics
    /// If there is no parameter of that name.
    fn index(&self, name: &str) -> &f64 {
        let place = self.names.iter().position(|n| n == name);
        assert!(place.is_some(), "no parameter \"{name}\" among {:?}", self.names);
        &self.values[place.unwrap_or(0)]
    }
}
