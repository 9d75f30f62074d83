//! The rows of a sweep as a table of numbers.

use crate::error::ParameterError;
use crate::export::ResultTable;
use crate::model::Channel;
use crate::sweep::rows::collection::Rows;
use crate::sweep::rows::row::Row;

impl Rows {
    /// A table with a line for each point, the results NaN for a point without a row. Columns:
    ///
    /// - `point`, the index, then the parameters of the point;
    /// - `period multiple` (0 for `None`), `change`, `settled after`, `scatter`, `sensitive` (0 or 1);
    /// - `mean q0`, `rms q0`, `min q0`, `max q0`, `deviation q0` of each channel, in its unit if the model
    ///   states one;
    /// - with [`rattle`](crate::Sweep::rattle) for each contact: `lower 0`, `gap 0`, `upper 0`
    ///   (shares of the time), `impacts lower 0`, `impacts upper 0`, `rattle state 0`
    ///   ([`rsv`](crate::RattleState::rsv));
    /// - with [`lyapunov`](crate::Sweep::lyapunov): `lyapunov`, `lyapunov error`;
    /// - with [`multipliers`](crate::Sweep::multipliers): `largest multiplier`, `multiplier error`.
    ///
    /// Strobed states, checks and the texts of errors are not in the table.
    ///
    /// ```
    /// use gear_dynamics::{sweep::{Axis, Located}, Dop853, NfgPair, NfgParams, Sweep};
    /// let speeds = Axis::of_values("speed", &[100.0, 120.0])?;
    /// let rows = Sweep::new(speeds).settle(3).measure(1).channels(&["q0", "elastic part"]).of(
    ///     &Located(Dop853::new()), // lanes and tables have no channels of the model's own
    ///     |p| NfgPair::new(&NfgParams { speed: p["speed"], ..NfgParams::table1() }),
    /// ).run()?;
    /// let table = rows.table()?;
    /// assert_eq!(table.column("speed")?, [100.0, 120.0]);
    /// let unit = |name: &str| table.columns().iter().find(|c| c.name == name).map(|c| c.unit.as_str());
    /// assert_eq!((unit("mean elastic part"), unit("mean q0")), (Some("rad"), Some("")));
    /// assert_eq!(table.column("mean q0")?[1], rows.get(1)?.channel("q0")?.mean);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ParameterError::Twice`] for a parameter that has the name of another column.
    pub fn table(&self) -> Result<ResultTable, ParameterError> {
        let parameters = self.points().names();
        let mut columns = vec![Channel::new("point", "1")];
        columns.extend(parameters.iter().map(|name| Channel::new(name, "")));
        columns.extend(["period multiple", "change", "settled after", "scatter", "sensitive"].map(ratio));
        for (i, name) in self.sweep.names().iter().enumerate() {
            let figures = ["mean", "rms", "min", "max", "deviation"];
            let unit = self.units.get(i).map_or("", String::as_str);
            columns.extend(figures.map(|figure| Channel::new(format!("{figure} {name}"), unit)));
        }
        for i in 0..self.layout.contacts {
            let figures = ["lower", "gap", "upper", "impacts lower", "impacts upper", "rattle state"];
            columns.extend(figures.map(|figure| ratio(&format!("{figure} {i}"))));
        }
        if self.layout.exponents > 0 {
            columns.extend(["lyapunov", "lyapunov error"].map(ratio));
        }
        if self.layout.multipliers > 0 {
            columns.extend(["largest multiplier", "multiplier error"].map(ratio));
        }
        let width = columns.len();
        let mut table = ResultTable::new(columns)?;
        let mut line = Vec::with_capacity(width);
        for index in self.range() {
            line.clear();
            line.push(index as f64);
            line.extend_from_slice(self.points().point(index).values());
            if let Ok(row) = self.get(index) {
                self.results(&row, &mut line)?;
            }
            line.resize(width, f64::NAN);
            table.push(&line)?;
        }
        Ok(table)
    }

    /// Adds the results of a row to the line of its point.
    fn results(&self, row: &Row<'_>, line: &mut Vec<f64>) -> Result<(), ParameterError> {
        line.extend([
            row.period_multiple().unwrap_or(0) as f64,
            row.change(),
            row.settled_after() as f64,
            row.scatter(),
            f64::from(u8::from(row.is_sensitive())),
        ]);
        for name in self.sweep.names() {
            let summary = row.channel(name)?;
            line.extend([summary.mean, summary.rms, summary.min, summary.max, summary.deviation]);
        }
        for contact in row.contacts() {
            line.extend(contact.time);
            line.extend(contact.impacts.map(|count| count as f64));
            line.push(f64::from(contact.rattle_state().rsv()));
        }
        if self.layout.exponents > 0 {
            line.extend([row.lyapunov(), row.lyapunov_standard_error()].map(|x| x.unwrap_or(f64::NAN)));
        }
        if self.layout.multipliers > 0 {
            let found = row.multipliers();
            line.extend(found.map_or([f64::NAN; 2], |found| [found.largest(), found.value_error()]));
        }
        Ok(())
    }
}

/// A column without a unit.
fn ratio(name: &str) -> Channel {
    Channel::new(name, "1")
}
