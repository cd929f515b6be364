//! The line with the names of the columns.

use std::borrow::Cow;

use super::{
    CsvError, HeadRows,
    column_map::{ColumnMap, ColumnName, STAMP, one_line},
    fields::fields,
    name::is_unit,
    number::Number,
    numbers_at, shown,
};

/// The most nameless fields at the end of a row.
const MOST_NAMELESS: usize = 16;

/// The fields of a row of `ros2 topic echo --csv` of a `sensor_msgs/Imu`, which has no names; each
/// covariance has nine.
const ROS2_IMU: &str = "header.stamp.sec header.stamp.nanosec header.frame_id orientation.x orientation.y orientation.z \
     orientation.w C angular_velocity.x angular_velocity.y angular_velocity.z C linear_acceleration.x linear_acceleration.y \
     linear_acceleration.z C";

/// A line cut into the names of columns.
#[derive(Default)]
pub(super) struct Header {
    /// The names, without empty ones at the end.
    pub(super) names: Vec<String>,
    /// Whether the line is a row as well: its cells have names, or it is a row of a known message.
    pub(super) is_first_row: bool,
    /// The units of the columns, if a row of units follows the names; else empty.
    units: Vec<String>,
    /// Number of fields without a name at the end of each row, from surplus separators.
    nameless_end: usize,
}

fn is_number(name: &str) -> bool {
    Number::parse(name.as_bytes()).is_some()
}

impl Header {
    pub(super) fn of_names(names: Vec<String>) -> Self {
        Self { names, ..Self::default() }
    }

    /// Cuts `line` at the separators.
    pub(super) fn read(line: &[u8], separator: u8) -> Self {
        let mut names: Vec<_> = fields(line, separator).map(|field| shown(&field)).collect();
        let named = names.iter().rposition(|name| !name.is_empty()).map_or(1, |last| last + 1);
        let nameless_end = names.len() - named;
        names.truncate(named);
        Self { nameless_end, ..Self::of_names(names) }
    }

    /// Names the fields of a row of `ros2 topic echo --csv`.
    pub(super) fn name_ros2_imu(&mut self) {
        let names: Vec<String> = ROS2_IMU
            .split_whitespace()
            .flat_map(|name| vec![name.replace('C', "covariance"); if name == "C" { 9 } else { 1 }])
            .collect();
        let fits = |(place, name): (usize, &String)| place == 2 || is_number(name);
        if self.names.len() == names.len() && self.names.iter().enumerate().all(fits) {
            (self.names, self.is_first_row) = (names, true);
        }
    }

    /// Fits the names to the number of fields of the rows. A line of names that has lost its line end
    /// runs into the first row, and rows may end in fields without a name; the line of names may
    /// have a separator too many or too few.
    pub(super) fn fit(&mut self, rows: &[Cow<'_, [u8]>], separator: u8) {
        let rows: Vec<Vec<_>> = rows.iter().map(|row| fields(row, separator).collect()).collect();
        let names = self.names.iter().take_while(|name| !is_number(name)).count();
        if let Some(width) = rows.first().map(Vec::len).filter(|width| rows.iter().all(|row| row.len() == *width))
            && self.names.len() > width
            && (3..=width).contains(&names)
        {
            self.names.truncate(names);
            self.nameless_end = width - names;
        }
        let mut rows_with = vec![0; self.nameless_end.max(MOST_NAMELESS) + 1];
        for row in &rows {
            let Some(more) = row.len().checked_sub(self.names.len()) else { continue };
            let are_empty = row[self.names.len()..].iter().all(|field| field.is_empty());
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
        let bare = |unit: Cow<'_, [u8]>| shown(&unit).trim_matches(['[', ']', '(', ')', ' ']).to_owned();
        let units: Vec<String> = fields(row, separator).map(bare).collect();
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
    pub(super) fn is_row(&self, map: &ColumnMap) -> bool {
        let by_number = |column: &ColumnName| matches!(column, ColumnName::Number(_));
        let place =
            |column: &ColumnName| self.mapped_place(STAMP, column).ok().map(|place| self.names[place].as_bytes());
        map.channels
            .iter()
            .all(|mapped| by_number(&mapped.column) && place(&mapped.column).and_then(Number::parse).is_some())
            && map.stamp.iter().all(|(column, form)| {
                by_number(column) && place(column).and_then(|stamp| form.nanoseconds(stamp)).is_some()
            })
    }

    /// Whether the line could name columns: several fields, each neither empty, number nor
    /// sentence. The first may be empty, because it may number the rows.
    pub(super) fn names_columns(&self) -> bool {
        let is_name = |name: &String| !name.is_empty() && !name.starts_with('$') && !is_number(name);
        let may_number_rows = |(place, name): (usize, &String)| place == 0 && name.is_empty();
        self.names.len() > 1 && self.names.iter().enumerate().all(|name| may_number_rows(name) || is_name(name.1))
    }

    /// Whether the line is the first row of several numbers, and not a line of names.
    pub(super) fn is_all_numbers(&self) -> bool {
        self.names.len() > 1 && self.names.iter().all(|name| is_number(name))
    }

    /// The columns with a name, or the places and mean values of columns without names.
    pub(super) fn listed(&self, rows: &HeadRows) -> Vec<String> {
        if !self.is_all_numbers() {
            return self.names.iter().filter(|name| !name.is_empty()).cloned().collect();
        }
        let mean = |place: usize| {
            let numbers: Vec<f64> = numbers_at(rows, place).map(|number| number.value()).collect();
            numbers.iter().sum::<f64>() / numbers.len() as f64
        };
        (0..self.names.len()).map(|place| format!("{} (mean {:.4})", place + 1, mean(place))).collect()
    }

    /// The column at `place` as written in a column map.
    pub(super) fn argument(&self, place: usize) -> String {
        let name = &self.names[place];
        let is_row = self.names.iter().any(|name| name.contains("$VN"));
        let is_unique = self.names.iter().filter(|other| other.eq_ignore_ascii_case(name)).count() == 1;
        // a control character or a cut name cannot be typed
        let is_typed =
            !name.is_empty() && !name.contains([',', '…', char::REPLACEMENT_CHARACTER]) && name.trim() == name;
        if !is_row && !is_number(name) && is_unique && is_typed { name.clone() } else { (place + 1).to_string() }
    }

    /// The place of a column that a map names for `channel`.
    pub(super) fn mapped_place(&self, channel: &str, column: &ColumnName) -> Result<usize, CsvError> {
        let place = match column {
            ColumnName::Number(number) => (*number <= self.names.len()).then(|| number - 1),
            ColumnName::Header(name) => {
                let names = || self.names.iter().map(|name| one_line(name));
                let exactly = names().position(|other| other == *name);
                exactly.or_else(|| names().position(|other| other.eq_ignore_ascii_case(name)))
            }
        };
        place.ok_or_else(|| {
            let column = column.to_string();
            CsvError::uncertain(format!("no column {column:?} for {channel}: the file has {}", self.names.join(", ")))
        })
    }
}
