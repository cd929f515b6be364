//! The line with the names of the columns.

use std::borrow::Cow;

use super::{
    CsvError, HeadRows,
    column_map::{ColumnMap, ColumnName, STAMP, one_line},
    fields::FieldCutter,
    name::is_unit,
    number::Number,
    shown,
    stamp::StampForm,
};

/// The most nameless fields at the end of a row.
const MOST_NAMELESS: usize = 16;

/// A line cut into the names of columns.
pub(super) struct Header {
    /// The names, without empty ones at the end.
    pub(super) names: Vec<String>,
    /// Whether the line is a row as well: its cells have names, or it is a row of a known message.
    pub(super) is_first_row: bool,
    /// The units of the columns, if a row of units follows the names; else empty.
    pub(super) units: Vec<String>,
    /// Number of fields without a name at the end of each row, from surplus separators.
    pub(super) nameless_end: usize,
}

impl Header {
    /// Cuts `line` at the separators.
    pub(super) fn read(line: &[u8], separator: u8) -> Self {
        let mut names: Vec<_> = FieldCutter::of_head(separator).cut(line).iter().map(shown).collect();
        let named = names.iter().rposition(|name| !name.is_empty()).map_or(1, |last| last + 1);
        let nameless_end = names.len() - named;
        names.truncate(named);
        Self { names, is_first_row: false, units: Vec::new(), nameless_end }
    }

    /// Names the fields of a row of `ros2 topic echo --csv` of a `sensor_msgs/Imu`, which has no
    /// names: its header, then orientation, rate and acceleration, each with nine covariances.
    pub(super) fn name_ros2_imu(&mut self) {
        let is_number = |place: usize| Number::parse(self.names[place].as_bytes()).is_some();
        let covariance = |name: &str| (0..9).map(|place| format!("{name}_covariance_{place}")).collect();
        let axes = |name: &str, axes: &[&str]| axes.iter().map(|axis| format!("{name}.{axis}")).collect();
        let names: [Vec<String>; 7] = [
            ["header.stamp.sec", "header.stamp.nanosec", "header.frame_id"].map(str::to_owned).to_vec(),
            axes("orientation", &["x", "y", "z", "w"]),
            covariance("orientation"),
            axes("angular_velocity", &["x", "y", "z"]),
            covariance("angular_velocity"),
            axes("linear_acceleration", &["x", "y", "z"]),
            covariance("linear_acceleration"),
        ];
        let names = names.concat();
        if self.names.len() == names.len() && (0..names.len()).all(|place| place == 2 || is_number(place)) {
            (self.names, self.is_first_row) = (names, true);
        }
    }

    /// Cuts the numbers of the first row off a line of names that has lost its line end, if the
    /// rows are shorter by as many fields.
    pub(super) fn part_from_row(&mut self, width: usize) {
        let is_number = |name: &String| Number::parse(name.as_bytes()).is_some();
        let names = self.names.iter().take_while(|name| !is_number(name)).count();
        if width > 0 && self.names.len() > width && (3..=width).contains(&names) {
            self.names.truncate(names);
            self.nameless_end = width - names;
        }
    }

    /// Determines from the rows whether they end in fields without a name; the line of names may
    /// have a separator too many or too few.
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
        // the smallest of several equally frequent counts
        self.nameless_end = rows_with.iter().position(|count| Some(*count) == most).unwrap_or_default();
    }

    /// Takes the units from the row below the names, if that row contains nothing else. Returns
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

    /// Whether the line consists of numbers instead of names, if `map` has columns: a file without a
    /// header. Only columns given by number can be found in such a file.
    pub(super) fn is_row(&self, map: &ColumnMap, mut mapped: impl Iterator<Item = usize>) -> bool {
        let by_number = map.columns().all(|(_, column)| matches!(column, ColumnName::Number(_)));
        let is_stamp = |(column, form): &(ColumnName, StampForm)| {
            let place = self.mapped_place(STAMP, column);
            place.is_ok_and(|place| form.nanoseconds(self.names[place].as_bytes()).is_some())
        };
        by_number
            && mapped.all(|place| Number::parse(self.names[place].as_bytes()).is_some())
            && map.stamp.iter().all(is_stamp)
    }

    /// Whether the line could name columns: several fields, each neither empty, number nor
    /// sentence. The first may be empty, because it may number the rows.
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

    /// The columns with a name, or the places and mean values of columns without names.
    pub(super) fn listed(&self, rows: &HeadRows) -> Vec<String> {
        if !self.is_all_numbers() {
            return self.names.iter().filter(|name| !name.is_empty()).cloned().collect();
        }
        let mean = |place: usize| {
            let numbers: Vec<f64> = super::numbers_at(rows, place).map(|number| number.value()).collect();
            numbers.iter().sum::<f64>() / numbers.len() as f64
        };
        (0..self.names.len()).map(|place| format!("{} (mean {:.4})", place + 1, mean(place))).collect()
    }

    /// The column at `place` as written in a column map.
    pub(super) fn argument(&self, place: usize) -> String {
        let name = &self.names[place];
        let is_row = self.names.iter().any(|name| name.contains("$VN"));
        let is_number = Number::parse(name.as_bytes()).is_some();
        let is_unique = self.names.iter().filter(|other| other.eq_ignore_ascii_case(name)).count() == 1;
        // a control character or a cut name cannot be typed
        let is_typed =
            !name.is_empty() && !name.contains([',', '…', char::REPLACEMENT_CHARACTER]) && name.trim() == name;
        if !is_row && !is_number && is_unique && is_typed { name.clone() } else { (place + 1).to_string() }
    }

    /// The place of a column that a map names for `channel`.
    pub(super) fn mapped_place(&self, channel: &'static str, column: &ColumnName) -> Result<usize, CsvError> {
        let place = match column {
            ColumnName::Number(number) => (*number <= self.names.len()).then(|| number - 1),
            ColumnName::Header(name) => {
                let names = || self.names.iter().map(|name| one_line(name));
                let exactly = names().position(|other| other == *name);
                exactly.or_else(|| names().position(|other| other.eq_ignore_ascii_case(name)))
            }
        };
        let missing = || CsvError::MissingColumn { channel, column: column.to_string(), found: self.names.clone() };
        place.ok_or_else(missing)
    }
}
