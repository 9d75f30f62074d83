//! Conversion of rows to bytes and back, for files and for other machines.

use crate::sweep::error::{PointError, SweepError};
use crate::sweep::rows::hash::Hash;
use crate::sweep::rows::layout::Layout;
use crate::sweep::rows::table::Rows;
use crate::sweep::settings::sweep::Sweep;

/// First eight bytes: name and version of the format.
const MARK: u64 = u64::from_le_bytes(*b"gd-rows3");

impl Rows {
    /// The rows as little-endian bytes, the same on every machine. [`Sweep::rows_from_bytes`] reads them, for
    /// example to resume a sweep from a file or to merge chunks from several machines.
    ///
    /// The bytes contain all values, checks and error texts, and a hash of the points and settings of the
    /// sweep. They do not contain [`alone`](Rows::alone).
    pub fn to_bytes(&self) -> Vec<u8> {
        let l = &self.layout;
        let broken: Vec<(&usize, &PointError)> =
            self.checks.iter().filter_map(|(index, row)| Some((index, row.as_ref().err()?))).collect();
        let checks = self.checks.len() - broken.len();
        let head = [self.range.start, self.range.end, l.dof, l.channels, l.contacts, l.strobes, l.exponents];
        let mut words = vec![MARK, self.sweep];
        words.extend(
            head.into_iter()
                .chain([checks, self.errors.len(), broken.len(), self.exponent_errors.len()])
                .map(|x| x as u64),
        );
        words.extend(self.done.iter().map(|done| u64::from(*done)));
        words.extend(self.data.iter().map(|x| x.to_bits()));
        for (index, row) in &self.checks {
            if let Ok(row) = row {
                words.push(*index as u64);
                words.extend(row.iter().map(|x| x.to_bits()));
            }
        }
        let mut bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        for (index, error) in self.errors.iter().chain(broken).chain(&self.exponent_errors) {
            let text = error.to_string();
            bytes.extend((*index as u64).to_le_bytes());
            bytes.extend((text.len() as u64).to_le_bytes());
            bytes.extend(text.as_bytes());
        }
        bytes.extend(Hash::of_bytes(&bytes).to_le_bytes());
        bytes
    }
}

impl Sweep {
    /// Rows of this sweep from the bytes of [`Rows::to_bytes`]. Errors of points are restored as their text,
    /// [`PointError::Text`].
    ///
    /// ```
    /// # use gear_dynamics::{sweep::{Axis, LaneRk4, Points}, NfgPair, NfgParams, ParameterError, Sweep};
    /// let speeds = Points::on_axis(Axis::linear("speed", 100.0, 110.0, 3)?);
    /// let sweep = Sweep::new(speeds).settle(1).measure(1).channels(&["q1"]);
    /// let rows = sweep.run(
    ///     &LaneRk4::<4>::new(63 * 32),
    ///     |p| NfgPair::new(&NfgParams { speed: p["speed"], ..NfgParams::table1() }),
    ///     |_, pair| pair.static_start(),
    /// )?;
    /// assert_eq!(sweep.rows_from_bytes(&rows.to_bytes())?, rows);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`SweepError::Bytes`] if the bytes are not rows, are incomplete or modified, or belong to a sweep over
    /// other points or with other settings. Engine, family and start are not checked: the bytes do not
    /// contain them.
    pub fn rows_from_bytes(&self, bytes: &[u8]) -> Result<Rows, SweepError> {
        let mut read = Reader { bytes, at: 0 };
        read.expect(MARK)?;
        read.expect(Hash::of(self))?;
        let [start, end, dof, channels, contacts, strobes, exponents] = read.sizes::<7>()?;
        let [checks, errors, broken, without] = read.sizes::<4>()?;
        let layout = Layout { dof, channels, contacts, strobes, exponents };
        let count = end
            .checked_sub(start)
            .filter(|_| end <= self.points().len())
            .ok_or(SweepError::Bytes { at: 16 })?;
        // Memory is allocated only if the bytes to fill it are present: damaged sizes cannot exhaust memory.
        let fits =
            |count: usize, each: usize| count.checked_mul(each).is_some_and(|words| words <= bytes.len() / 8);
        let small = [dof, channels, contacts, strobes, exponents].iter().all(|x| *x <= bytes.len());
        let stride = if small { layout.stride_checked() } else { None };
        let stride = stride
            .filter(|stride| fits(count, 1 + stride) && fits(checks, 1 + stride))
            .ok_or(SweepError::Bytes { at: 32 })?;
        let mut rows = Rows::new(self, &layout, start..end);
        for done in &mut rows.done {
            *done = read.word()? != 0;
        }
        // Rows without any result may have the layout of a sweep without a model: it is not checked.
        if (channels != self.names().len() || exponents != self.exponents()) && rows.done.contains(&true) {
            return Err(SweepError::Bytes { at: 40 });
        }
        for x in &mut rows.data {
            *x = f64::from_bits(read.word()?);
        }
        for _ in 0..checks {
            let index = read.index(&rows, true)?;
            let row = (0..stride).map(|_| read.word().map(f64::from_bits)).collect::<Result<_, _>>()?;
            rows.checks.insert(index, Ok(row));
        }
        for _ in 0..errors {
            let index = read.index(&rows, false)?;
            rows.errors.insert(index, read.error()?);
        }
        for _ in 0..broken {
            let index = read.index(&rows, true)?;
            rows.checks.insert(index, Err(read.error()?));
        }
        for _ in 0..without {
            let index = read.index(&rows, true)?;
            rows.exponent_errors.insert(index, read.error()?);
        }
        let at = read.at;
        read.expect(Hash::of_bytes(&bytes[..at]))?;
        if read.at == bytes.len() { Ok(rows) } else { Err(SweepError::Bytes { at: read.at }) }
    }
}

/// Reads words from bytes.
struct Reader<'b> {
    bytes: &'b [u8],
    /// Position of the next byte.
    at: usize,
}

impl<'b> Reader<'b> {
    fn take(&mut self, length: usize) -> Result<&'b [u8], SweepError> {
        let cut = SweepError::Bytes { at: self.at };
        let end = self.at.checked_add(length).ok_or(cut.clone())?;
        let taken = self.bytes.get(self.at..end).ok_or(cut)?;
        self.at = end;
        Ok(taken)
    }
    fn word(&mut self) -> Result<u64, SweepError> {
        let mut word = [0; 8];
        word.copy_from_slice(self.take(8)?);
        Ok(u64::from_le_bytes(word))
    }
    fn sizes<const N: usize>(&mut self) -> Result<[usize; N], SweepError> {
        let mut sizes = [0; N];
        for size in &mut sizes {
            *size = usize::try_from(self.word()?).map_err(|_| SweepError::Bytes { at: self.at })?;
        }
        Ok(sizes)
    }
    /// Reads the index of a point; it must have a row if `done` is `true`, and must have none otherwise.
    fn index(&mut self, rows: &Rows, done: bool) -> Result<usize, SweepError> {
        let at = self.at;
        let [index] = self.sizes::<1>()?;
        let place = index.checked_sub(rows.range.start).filter(|place| rows.done.get(*place) == Some(&done));
        place.map(|_| index).ok_or(SweepError::Bytes { at })
    }
    /// Reads the text of an error.
    fn error(&mut self) -> Result<PointError, SweepError> {
        let [length] = self.sizes::<1>()?;
        Ok(PointError::Text(String::from_utf8_lossy(self.take(length)?).into_owned()))
    }
    /// Reads a word that must equal `word`.
    fn expect(&mut self, word: u64) -> Result<(), SweepError> {
        let at = self.at;
        if self.word()? == word { Ok(()) } else { Err(SweepError::Bytes { at }) }
    }
}
