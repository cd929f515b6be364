//! The line with the names of the columns.

use std::borrow::Cow;

use super::{
    HeadRows, Unusable,
    column_map::{ColumnMap, STAMP, one_line},
    fields::fields,
    number::Number,
    numbers_at, shown,
    stamp::time_unit,
    unit::Unit,
};

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
    /// The number of columns, with those at the end that have no name.
    pub(super) width: usize,
    /// Whether the line is a row as well: its cells have names, or it is a row of a known message.
    pub(super) is_first_row: bool,
    /// The units of the columns, if a row of units follows the names; else empty.
    units: Vec<String>,
}

fn is_number(name: &str) -> bool {
    Number::parse(name.as_bytes()).is_some()
}

impl Header {
    pub(super) fn of_names(mut names: Vec<String>) -> Self {
        let width = names.len();
        names.truncate(names.iter().rposition(|name| !name.is_empty()).map_or(1, |last| last + 1));
        Self { names, width, ..Self::default() }
    }

    pub(super) fn read(line: &[u8], separator: u8) -> Self {
        Self::of_names(fields(line, separator).map(|field| shown(&field)).collect())
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

    /// Cuts off the first row, if a line of names that has lost its line end runs into it.
    pub(super) fn cut_off_row(&mut self, rows: &HeadRows) {
        let names = self.names.iter().take_while(|name| !is_number(name)).count();
        let width = rows.first().map_or(0, Vec::len);
        if (3..=width).contains(&names) && self.names.len() > width && rows.iter().all(|row| row.len() == width) {
            self.names.truncate(names);
            self.width = width;
        }
    }

    /// Whether a row has all named columns, and no field beyond the others but empty ones.
    pub(super) fn fits(&self, row: &[Vec<u8>]) -> bool {
        row.len() >= self.names.len() && row.iter().skip(self.width).all(Vec::is_empty)
    }

    /// Takes the units from the row below the names, if that row contains nothing else. Returns
    /// whether it does.
    pub(super) fn take_units(&mut self, row: &[u8], separator: u8) -> bool {
        let bare = |unit: Cow<'_, [u8]>| shown(&unit).trim_matches(['[', ']', '(', ')', ' ']).to_owned();
        let units: Vec<String> = fields(row, separator).map(bare).collect();
        let are_units = units.len() >= self.names.len()
            && units.iter().any(|unit| is_unit(unit))
            && units.iter().all(|unit| matches!(unit.as_str(), "" | "-" | "1") || is_unit(unit));
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

    /// Whether the line consists of numbers instead of names, if `map` has columns: a file without a
    /// header. Only columns given by number can be found in such a file.
    pub(super) fn is_row(&self, map: &ColumnMap) -> bool {
        let cell = |column: &str| {
            column.parse::<usize>().ok()?;
            self.mapped_place(STAMP, column).ok().map(|place| self.names[place].as_bytes())
        };
        map.channels.iter().all(|mapped| cell(&mapped.column).and_then(Number::parse).is_some())
            && map.stamp.iter().all(|(column, form)| cell(column).and_then(|stamp| form.nanoseconds(stamp)).is_some())
    }

    /// Whether the line could name columns: several fields, each neither empty, number nor
    /// sentence. The first may be empty, because it may number the rows.
    pub(super) fn names_columns(&self) -> bool {
        let is_name = |(place, name): (usize, &String)| {
            if name.is_empty() { place == 0 } else { !name.starts_with('$') && !is_number(name) }
        };
        self.names.len() > 1 && self.names.iter().enumerate().all(is_name)
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
        (0..self.names.len()).map(|place| format!("{} (mean {:.4})", place + 1, mean_at(rows, place))).collect()
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

    /// The place of a column that a map names for `channel`, by its name or number.
    pub(super) fn mapped_place(&self, channel: &str, column: &str) -> Result<usize, Unusable> {
        let names = || self.names.iter().map(|name| one_line(name));
        let place = match column.parse::<usize>() {
            Ok(number) => number.checked_sub(1).filter(|place| *place < self.names.len()),
            Err(_) => names()
                .position(|name| name == column)
                .or_else(|| names().position(|name| name.eq_ignore_ascii_case(column))),
        };
        place.ok_or_else(|| {
            Unusable::new(format!("no column {column:?} for {channel}: the file has {}", self.names.join(", ")))
        })
    }
}

/// The mean of the numbers of a column in the first rows.
pub(super) fn mean_at(rows: &HeadRows, place: usize) -> f64 {
    let numbers: Vec<f64> = numbers_at(rows, place).map(|number| number.value()).collect();
    numbers.iter().sum::<f64>() / numbers.len() as f64
}

/// Whether people write a unit of a channel or of a time in this way.
fn is_unit(text: &str) -> bool {
    time_unit(&text.to_lowercase()).is_some() || Unit::is_one(text)
}
