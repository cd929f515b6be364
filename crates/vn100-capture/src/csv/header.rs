//! The line with the names of the columns, and the use of each column.

use std::borrow::Cow;

use vn100_protocol::Quantity;

use super::{
    CsvError,
    column_map::{ColumnMap, ColumnName, STAMP, Unit, known},
    column_name::{channel_of, is_unit},
    fields::FieldCutter,
    number::Number,
    shown,
    stamp::StampForm,
    stamp_columns::StampColumns,
    streams::quantity,
};

/// The most fields without names that may end the rows.
const MOST_NAMELESS: usize = 16;

/// A line cut into the names of columns.
pub(super) struct Header {
    /// The names, without empty ones at the end.
    pub(super) names: Vec<String>,
    /// The units of the columns, where a row of units follows the names; else empty.
    pub(super) units: Vec<String>,
    /// Number of fields without a name at the end of each row, from separators too many.
    pub(super) nameless_end: usize,
}

/// The columns that are used, by place.
#[derive(Debug, Default)]
pub(super) struct ColumnPlaces {
    pub(super) stamp: Option<StampColumns>,
    pub(super) sentence: Option<usize>,
    /// Place and channel, in the order of the columns.
    pub(super) channels: Vec<(usize, usize)>,
    /// The channels whose unit is in the name of their column.
    pub(super) units: Vec<(usize, &'static Unit)>,
    /// The places of the channels of other streams.
    pub(super) others: Vec<usize>,
}

impl Header {
    /// Cuts `line` at the separators.
    pub(super) fn read(line: &[u8], separator: u8) -> Self {
        let mut names: Vec<_> = FieldCutter::of_head(separator).cut(line).iter().map(shown).collect();
        let named = names.iter().rposition(|name| !name.is_empty()).map_or(1, |last| last + 1);
        let nameless_end = names.len() - named;
        names.truncate(named);
        Self { names, units: Vec::new(), nameless_end }
    }

    /// Detects from the rows whether they end in a field without a name; the line of names may have
    /// a separator too many or too few.
    pub(super) fn fit<'a>(&mut self, rows: impl Iterator<Item = Cow<'a, [u8]>>, separator: u8) {
        let mut reader = FieldCutter::of_head(separator);
        let mut rows_with = vec![0; self.nameless_end.max(MOST_NAMELESS) + 1];
        for row in rows {
            let fields = reader.cut(&row);
            let Some(more) = fields.len().checked_sub(self.names.len()) else { continue };
            let are_empty = fields.iter().skip(self.names.len()).all(<[u8]>::is_empty);
            if let Some(count) = rows_with.get_mut(more).filter(|_| are_empty || more <= self.nameless_end) {
                *count += 1;
            }
        }
        let most = rows_with.iter().copied().max().filter(|most| *most > 0);
        // the fewest of several that are as frequent
        self.nameless_end = rows_with.iter().position(|count| Some(*count) == most).unwrap_or_default();
    }

    /// Takes the units from the row below the names, where that row contains nothing else. Returns
    /// whether it does.
    pub(super) fn take_units(&mut self, row: &[u8], separator: u8) -> bool {
        let units: Vec<String> = FieldCutter::of_head(separator).cut(row).iter().map(shown).collect();
        let bare = |unit: &str| unit.trim_matches(['[', ']', '(', ')', ' ']).to_owned();
        let units: Vec<String> = units.iter().map(|unit| bare(unit)).collect();
        let says_none = |unit: &String| matches!(unit.as_str(), "" | "-" | "1");
        let are_units = units.len() >= self.names.len()
            && units.iter().any(|unit| is_unit(unit))
            && units.iter().all(|unit| says_none(unit) || is_unit(unit));
        if are_units {
            self.units = units;
        }
        are_units
    }

    /// The name of a column with its unit.
    pub(super) fn described(&self, place: usize) -> Cow<'_, str> {
        let name = &self.names[place];
        match self.units.get(place) {
            Some(unit) if is_unit(unit) && !name.contains(['[', '(']) => format!("{name} [{unit}]").into(),
            _ => name.into(),
        }
    }

    /// The number of fields in a row.
    pub(super) fn width(&self) -> usize {
        self.names.len() + self.nameless_end
    }

    /// The columns with known names; the first of two with the same meaning.
    pub(super) fn known_places(&self) -> ColumnPlaces {
        let mut places = ColumnPlaces::default();
        for place in 0..self.names.len() {
            let name = self.described(place).to_lowercase();
            if let Some((channel, unit)) = channel_of(&name)
                && places.channels.iter().all(|&(_, other)| other != channel)
            {
                places.channels.push((place, channel));
                places.units.extend(unit.map(|unit| (channel, unit)));
            }
        }
        places
    }

    /// The columns that `map` names.
    pub(super) fn mapped_places(&self, map: &ColumnMap) -> Result<ColumnPlaces, CsvError> {
        let mut found: Vec<(&'static str, usize)> = Vec::new();
        for (channel, column) in map.columns() {
            let place = self.mapped_place(channel, column)?;
            if let Some((other, _)) = found.iter().find(|(_, taken)| *taken == place) {
                return Err(CsvError::SameColumn { column: column.to_string(), channels: [other, channel] });
            }
            found.push((channel, place));
        }
        let channels = map.channels.iter().zip(&found);
        Ok(ColumnPlaces {
            channels: channels.map(|(mapped, &(_, place))| (place, mapped.index)).collect(),
            ..ColumnPlaces::default()
        })
    }

    /// Whether the line consists of numbers instead of names, where `map` has columns: a file
    /// without a header. Only columns given by number can be found in such a file.
    pub(super) fn is_row(&self, map: &ColumnMap, places: &ColumnPlaces) -> bool {
        let by_number = map.columns().all(|(_, column)| matches!(column, ColumnName::Number(_)));
        let mut mapped = places.channels.iter().map(|&(place, _)| place);
        let is_stamp = |(column, form): &(ColumnName, StampForm)| {
            let place = self.mapped_place(STAMP, column);
            place.is_ok_and(|place| form.nanoseconds(self.names[place].as_bytes()).is_some())
        };
        by_number
            && mapped.all(|place| Number::parse(self.names[place].as_bytes()).is_some())
            && map.stamp.iter().all(is_stamp)
    }

    /// Whether the line could name columns: several fields, each neither empty, number nor
    /// sentence. The first may be empty: a column that numbers the rows.
    pub(super) fn names_columns(&self) -> bool {
        let names = match &self.names[..] {
            [first, others @ ..] if first.is_empty() => others,
            names => names,
        };
        let is_name =
            |name: &String| !name.is_empty() && !name.starts_with('$') && Number::parse(name.as_bytes()).is_none();
        names.len() > 1 && names.iter().all(is_name)
    }

    /// Whether the line is the first row of several numbers, and not a line of names.
    pub(super) fn is_all_numbers(&self) -> bool {
        self.names.len() > 1 && self.names.iter().all(|name| Number::parse(name.as_bytes()).is_some())
    }

    /// The names of the columns that have one.
    pub(super) fn given_names(&self) -> Vec<String> {
        if self.is_all_numbers() {
            return vec![format!("{} columns without names", self.names.len())];
        }
        self.names.iter().filter(|name| !name.is_empty()).cloned().collect()
    }

    /// The column at `place` as a column map names it.
    pub(super) fn argument(&self, place: usize) -> String {
        let name = &self.names[place];
        let is_row = self.names.iter().any(|name| name.contains("$VN"));
        let is_number = Number::parse(name.as_bytes()).is_some();
        let is_usable = !is_row && !name.is_empty() && !name.contains(',') && !is_number;
        if is_usable { name.clone() } else { (place + 1).to_string() }
    }

    /// The place of a column that a map names for `channel`.
    pub(super) fn mapped_place(&self, channel: &'static str, column: &ColumnName) -> Result<usize, CsvError> {
        let place = match column {
            ColumnName::Number(number) => (*number <= self.names.len()).then(|| number - 1),
            ColumnName::Header(name) => {
                let exactly = self.names.iter().position(|other| other == name);
                exactly.or_else(|| self.names.iter().position(|other| other.eq_ignore_ascii_case(name)))
            }
        };
        let missing = || CsvError::MissingColumn { channel, column: column.to_string(), found: self.names.clone() };
        place.ok_or_else(missing)
    }
}

impl ColumnPlaces {
    /// The names of the columns that are recognised, in words.
    pub(super) const SEARCHED: &'static str = "gyro_x gyro_y gyro_z accel_x accel_y accel_z (gyr_ and acc_ too; with them mag_ or magn_ \
         x y z, yaw pitch roll, temperature, pressure and stamps), or stamps beside a column with $VN… sentences";

    /// Whether there is a channel that only an inertial sensor has.
    pub(super) fn has_inertial_channel(&self) -> bool {
        let quantities = self.channels.iter().map(|&(_, channel)| known(channel).quantity);
        { quantities }.any(|quantity| matches!(quantity, Quantity::Acceleration | Quantity::AngularRate))
    }

    /// Keeps only the channels that `stream` names, one by one or by their quantity.
    pub(super) fn choose(&mut self, stream: &str) -> Result<(), CsvError> {
        let words: Vec<_> = stream.split_whitespace().collect();
        let is_of = |channel: usize, word: &str| {
            let name = &*known(channel).name;
            name == word || quantity(name) == word
        };
        let is_there = |word: &&str| self.channels.iter().any(|&(_, channel)| is_of(channel, word));
        if words.is_empty() || !words.iter().all(is_there) {
            let mut found: Vec<_> = self.channels.iter().map(|&(_, channel)| quantity(&known(channel).name)).collect();
            found.dedup();
            return Err(CsvError::NoStream { name: stream.into(), found: found.join(", ") });
        }
        let is_chosen = |&(_, channel): &(usize, usize)| words.iter().any(|word| is_of(channel, word));
        let (chosen, others): (Vec<_>, Vec<_>) = self.channels.iter().copied().partition(is_chosen);
        self.channels = chosen;
        self.others = others.into_iter().map(|(place, _)| place).collect();
        Ok(())
    }

    /// The names of the columns that are not used.
    pub(super) fn ignored(&self, header: &Header) -> Vec<String> {
        let names = header.names.iter().enumerate();
        names.filter(|(place, _)| !self.uses(*place)).map(|(_, name)| name.clone()).collect()
    }

    /// Whether a column holds stamps, sentences or a channel.
    pub(super) fn uses(&self, place: usize) -> bool {
        self.stamp.as_ref().is_some_and(|stamp| stamp.columns.iter().any(|&(taken, _)| taken == place))
            || self.sentence == Some(place)
            || self.channels.iter().any(|&(other, _)| other == place)
    }
}

#[cfg(test)]
mod tests {
    use super::{super::dialect::Dialect, *};

    fn header(line: &[u8]) -> Header {
        Header::read(line, Dialect::of(line, std::iter::empty()).separator)
    }

    fn channels(line: &str) -> Vec<(usize, &'static str)> {
        let places = header(line.as_bytes()).known_places();
        let channels = places.channels.iter();
        channels.map(|&(place, channel)| (place, &*known(channel).name)).collect()
    }

    #[test]
    fn names_are_found_however_written() {
        for line in ["t,acc_x,gyr_z", " Time ; \"Accel_X\" ;GYRO_Z", "%time\tACC_X\tgyro_z"] {
            assert_eq!(channels(line), [(1, "accel_x"), (2, "gyro_z")], "{line:?}");
        }
    }

    #[test]
    fn the_first_of_two_columns_is_taken() {
        let header = header(b"gyr_x,gyro_x,n");
        let places = header.known_places();
        assert_eq!(places.channels.len(), 1);
        assert_eq!(places.ignored(&header), ["gyro_x", "n"]);
    }

    #[test]
    fn mapped_columns_are_found_or_missed_by_name() {
        let header = header(b"time;wx;WY");
        let places = |map: &str| header.mapped_places(&map.parse().unwrap()).map_err(|error| error.to_string());
        let found = places("gyro_x=2:deg/s,gyro_y=wy:deg/s,t=time:ns").unwrap();
        let [x, y] = ["gyro_x", "gyro_y"].map(|name| channel_of(name).unwrap().0);
        assert_eq!(&*found.channels, &[(1, x), (2, y)][..]);
        assert_eq!(places("gyro_x=wz:deg/s").unwrap_err(), "no column \"wz\" for gyro_x: the file has time, wx, WY");
        assert_eq!(places("gyro_x=4:deg/s").unwrap_err(), "no column \"4\" for gyro_x: the file has time, wx, WY");
        assert_eq!(
            places("gyro_x=wx:deg/s,gyro_y=2:deg/s").unwrap_err(),
            "column \"2\" is mapped to both gyro_x and gyro_y: give each its own"
        );
    }
}
