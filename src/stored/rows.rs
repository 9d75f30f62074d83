//! The stored form of rows.

use crate::numeric::not_finite::{AnyNumber, numbers, plain};
use crate::stored::row_figures::{check_exponents, check_figures};
use crate::sweep::rows::layout::Layout;
use crate::sweep::{PointError, Rows, Sweep};
use serde::de::{Deserialize, Deserializer, Error};
use serde::ser::{Serialize, Serializer};
use std::collections::{BTreeMap, BTreeSet};

/// Version of the stored form. A change that older readers cannot read increases it.
///
/// 2: the numbers of channels count from 0, in version 1 from 1.
const VERSION: u32 = 2;

#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "Rows")]
struct StoredRows {
    version: u32,
    /// Points and settings of the whole sweep.
    sweep: Sweep,
    /// Index of the first point of these rows.
    first: usize,
    layout: Layout,
    /// Units of the channels; none in files of before.
    #[serde(default)]
    units: Vec<String>,
    /// The values of each point, in the order of the layout; none for a point without a row.
    rows: Vec<Option<Vec<AnyNumber>>>,
    /// Texts of the errors of points without a row.
    errors: Vec<(usize, String)>,
    /// Results with a quarter of the step.
    checks: Vec<(usize, Result<Vec<AnyNumber>, String>)>,
    /// Texts of the errors of Lyapunov exponents.
    exponent_errors: Vec<(usize, String)>,
}

impl Serialize for Rows {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let stride = self.layout.stride();
        let row =
            |(place, done): (usize, &bool)| done.then(|| numbers(&self.data[place * stride..][..stride]));
        let texts = |errors: &BTreeMap<usize, PointError>| {
            errors.iter().map(|(index, error)| (*index, error.to_string())).collect()
        };
        let check = |(index, row): (&usize, &Result<Vec<f64>, PointError>)| {
            (*index, row.as_ref().map(|row| numbers(row)).map_err(PointError::to_string))
        };
        let stored = StoredRows {
            version: VERSION,
            sweep: self.sweep.clone(),
            first: self.range.start,
            layout: self.layout.clone(),
            units: self.units.clone(),
            rows: self.done.iter().enumerate().map(row).collect(),
            errors: texts(&self.errors),
            checks: self.checks.iter().map(check).collect(),
            exponent_errors: texts(&self.exponent_errors),
        };
        stored.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Rows {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        StoredRows::deserialize(deserializer)?.read().map_err(D::Error::custom)
    }
}

impl StoredRows {
    /// The rows, if all parts fit together.
    fn read(mut self) -> Result<Rows, String> {
        match self.version {
            VERSION => {}
            1 => self.sweep.channels.iter_mut().for_each(|name| *name = counted_from_0(name)),
            other => return Err(format!("version {other} of stored rows: up to {VERSION} can be read")),
        }
        self.sweep.check().map_err(|error| format!("settings of the sweep: {error}"))?;
        let (sweep, layout) = (&self.sweep, &self.layout);
        let end = self.first.checked_add(self.rows.len()).filter(|end| *end <= sweep.points().len());
        let end = end.ok_or_else(|| {
            let (rows, points) = (self.rows.len(), sweep.points().len());
            format!("{rows} rows from point {}: the sweep has {points} points", self.first)
        })?;
        let line = sweep.line();
        if !self.first.is_multiple_of(line) || !end.is_multiple_of(line) {
            return Err(format!(
                "rows {} to {end}: a warm start needs whole lines of {line} points",
                self.first
            ));
        }
        // Rows without any result may have the layout of a sweep without a model.
        let empty = *layout == Layout::default() && self.rows.iter().all(Option::is_none);
        if !empty && !layout.fits(sweep) {
            return Err("the layout of the rows does not fit the settings of the sweep".into());
        }
        let stride = layout.stride_checked();
        Rows::check_room(self.rows.len(), stride).map_err(|error| error.to_string())?;
        let stride = stride.ok_or("the layout of the rows is too large")?;
        let fits = |index: usize, row: &[AnyNumber]| {
            if row.len() == stride {
                Ok(())
            } else {
                Err(format!("the row of point {index} has {} values: {stride} are needed", row.len()))
            }
        };
        if !self.units.is_empty() && self.units.len() != layout.channels {
            return Err(format!("{} units for {} channels", self.units.len(), layout.channels));
        }
        let mut rows = Rows::new(sweep, layout, self.first..end);
        let failed: BTreeSet<usize> = self.exponent_errors.iter().map(|(index, _)| *index).collect();
        rows.units = self.units;
        for (place, row) in self.rows.into_iter().enumerate() {
            if let Some(row) = row {
                let index = self.first + place;
                fits(index, &row)?;
                let row = plain(row);
                check_figures(layout, &row)
                    .and_then(|()| check_exponents(layout, &row, failed.contains(&index)))
                    .map_err(|error| format!("row of point {index}: {error}"))?;
                rows.put(index, &Ok(row));
            }
        }
        let (first, has_row) = (self.first, rows.done.clone());
        let belongs = |index: usize, with_row: bool| {
            let place = index.checked_sub(first).filter(|place| has_row.get(*place) == Some(&with_row));
            place.map(|_| index).ok_or_else(|| format!("an entry for point {index} does not fit its row"))
        };
        for (index, text) in self.errors {
            rows.errors.insert(belongs(index, false)?, PointError::Text(text));
        }
        for (index, check) in self.checks {
            if let Ok(row) = &check {
                fits(index, row)?;
            }
            let check = check.map(plain).map_err(PointError::Text);
            if let Ok(row) = &check {
                check_figures(layout, row)
                    .and_then(|()| check_exponents(layout, row, true))
                    .map_err(|error| format!("check of point {index}: {error}"))?;
            }
            rows.checks.insert(belongs(index, true)?, check);
        }
        for (index, text) in self.exponent_errors {
            rows.exponent_errors.insert(belongs(index, true)?, PointError::Text(text));
        }
        Ok(rows)
    }
}

/// The name of a channel of version 1 as it is now: `q1` is `q0`.
fn counted_from_0(name: &str) -> String {
    const NUMBERED: [&str; 7] = [
        "q",
        "v",
        "deflection ",
        "mesh force ",
        "contact ",
        "transmission error ",
        "stiffness times deflection ",
    ];
    let numbered =
        NUMBERED.iter().find_map(|kind| Some((kind, name.strip_prefix(kind)?.parse::<usize>().ok()?)));
    match numbered {
        Some((kind, number @ 1..)) => format!("{kind}{}", number - 1),
        _ => name.into(),
    }
}
