//! The assignment of the columns of a foreign CSV file to channels and units:
//! `gyro_x=wx:deg/s,accel_x=4:g,t=time:ns`.

use std::{fmt, str::FromStr};

use vn100_protocol::Quantity;

use super::{
    channels::{by_name, known, names},
    stamp::StampForm,
    unit::{Unit, units},
};

/// Names the columns of any CSV file with the numbers of an inertial sensor.
///
/// Written as `CHANNEL=COLUMN:UNIT`, comma-separated. `CHANNEL` is `yaw` `pitch` `roll`, `quat_`
/// with `x` `y` `z` `w`, `mag_` `accel_` `gyro_` with `x` `y` `z`, `temperature`, `pressure`,
/// `value` for the numbers of any series, or `t` for the stamp of the row; `raw=COLUMN` is a column
/// of sentences. With `t` or `raw` alone the other columns are recognised by their names. `COLUMN`
/// is the name at the head of the column or its number, from 1. `UNIT` is
///
/// - `rad/s` `deg/s` `deg/h` `mdeg/s` `mrad/s` `rpm` for a rate, `m/s^2` `g` `mg` `ug` `cm/s^2`
///   `ft/s^2` for an acceleration, with 9.80665 m/s² for g,
/// - `gauss` `mgauss` `T` `uT` `mT` `nT` for a magnetic field, `deg` `rad` for an angle,
///   `1` for an element of the quaternion,
/// - another unit of an angle or a length and a time, or a unit with a factor: `rev/s` `mm/s^2` `0.01 deg/s`,
/// - `degC` `K` for the temperature, `kPa` `hPa` `Pa` for the pressure, any word for `value`, which
///   is not converted,
/// - and for the stamp `s` `ms` `us` `ns` `100us` `d` `min` `h`, `iso` for a date with the year first, `dmy`, `mdy`,
///   `clock` for a time of day, or `mmss` for minutes and seconds; a stamp in two columns is
///   `t=SECS:s+NANOS:ns`.
///
/// ```
/// use vn100_capture::ColumnMap;
///
/// let map: ColumnMap = "gyro_x=wx:deg/s,accel_x=4:g,t=time:ns".parse()?;
/// assert_eq!(map.to_string(), "gyro_x=wx:deg/s,accel_x=4:g,t=time:ns");
/// # Ok::<_, vn100_capture::ColumnMapError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ColumnMap {
    /// As it was written, in one line.
    text: String,
    /// Empty if only the stamp or the sentences are mapped.
    pub(crate) channels: Vec<MappedChannel>,
    /// The column of the stamps, and the column that is added to it, if there are two.
    pub(super) stamp: Vec<(String, StampForm)>,
    pub(super) sentence: Option<String>,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MappedChannel {
    /// The index, as in [`known`].
    pub(crate) index: usize,
    /// The name of the column, or its number from 1.
    pub(crate) column: String,
    pub(crate) unit: Unit,
}

/// The reason why a text is no [`ColumnMap`], in words.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct ColumnMapError(String);

/// The name of the stamp among the channels.
pub(super) const STAMP: &str = "t";

/// The name of the sentences among the channels.
pub(super) const RAW: &str = "raw";

impl FromStr for ColumnMap {
    type Err = ColumnMapError;

    fn from_str(text: &str) -> Result<Self, ColumnMapError> {
        // a map that a terminal broke into lines is the same map
        let text = one_line(text);
        let mut map = Self { text: text.clone(), channels: Vec::new(), stamp: Vec::new(), sentence: None };
        for part in text.split(',').map(str::trim).filter(|part| !part.is_empty()) {
            map.add(part).map_err(ColumnMapError)?;
        }
        if map.columns().next().is_none() {
            return Err(ColumnMapError(format!("no channel is mapped: map at least one of {}", channel_names())));
        }
        if map.sentence.is_some() && !map.channels.is_empty() {
            let problem = "raw=NAME gives whole sentences, which hold all channels: map no other channel";
            return Err(ColumnMapError(problem.into()));
        }
        Ok(map)
    }
}

impl ColumnMap {
    fn add(&mut self, part: &str) -> Result<(), String> {
        let form = || format!("{part:?} is not of the form CHANNEL=COLUMN:UNIT, as in gyro_x=wx:deg/s or t=1:ns");
        let (channel, rest) = part.split_once('=').map(|(channel, rest)| (channel.trim(), rest)).ok_or_else(form)?;
        // the name of a column may contain `=` and `:`, channel and unit cannot
        let (column, unit) = if channel == RAW { (rest, "") } else { rest.rsplit_once(':').ok_or_else(form)? };
        let (column, unit) = (column.trim(), unit.trim());
        if column.is_empty() {
            return Err(form());
        }
        let bad_unit = || format!("unknown unit {unit:?} of {channel} in {part:?}: use {}", unit_names(channel));
        if self.columns().any(|(other, _)| other == channel) {
            return Err(format!("{channel} is mapped twice, again in {part:?}: keep one"));
        }
        if channel == RAW {
            self.sentence = Some(column.into());
        } else if channel == STAMP {
            self.stamp = stamp(column, StampForm::by_name(unit).ok_or_else(bad_unit)?);
        } else {
            let unknown = || format!("unknown channel {channel:?} in {part:?}: use one of {}", channel_names());
            let index = by_name(channel).ok_or_else(unknown)?;
            let unit = match known(index).quantity {
                Quantity::Value if !unit.is_empty() && !unit.contains(char::is_control) => {
                    Unit::unconverted(unit.into())
                }
                quantity => Unit::of(quantity, unit).ok_or_else(bad_unit)?,
            };
            self.channels.push(MappedChannel { index, column: column.into(), unit });
        }
        Ok(())
    }

    /// Whether it names columns of channels, and not only the stamp.
    pub(crate) fn has_channels(&self) -> bool {
        !self.channels.is_empty()
    }

    /// The columns of the times, or of the parts that are added, with their unit in nanoseconds;
    /// `None` for text.
    pub(crate) fn stamp_columns(&self) -> impl Iterator<Item = (&String, Option<i64>)> {
        self.stamp.iter().map(|(column, form)| match form {
            StampForm::Unit(unit_ns) => (column, Some(*unit_ns)),
            _ => (column, None),
        })
    }

    /// Every column with the channel it holds, the stamp last.
    pub(crate) fn columns(&self) -> impl Iterator<Item = (&'static str, &str)> {
        let channels = self.channels.iter();
        channels
            .map(|mapped| (&*known(mapped.index).name, &*mapped.column))
            .chain(self.stamp.iter().map(|(column, _)| (STAMP, &**column)))
            .chain(self.sentence.iter().map(|column| (RAW, &**column)))
    }
}

/// The columns of a stamp in this form; of two in a text such as `secs:s+nsecs`.
fn stamp(column: &str, form: StampForm) -> Vec<(String, StampForm)> {
    let is_unit = |form: &StampForm| matches!(form, StampForm::Unit(_));
    let pair = StampForm::all().filter(|first| is_unit(first) && is_unit(&form)).find_map(|first| {
        let (whole, part) = column.split_once(&format!(":{}+", first.name()))?;
        Some(vec![(whole.trim().into(), first), (part.trim().into(), form)])
    });
    pair.unwrap_or_else(|| vec![(column.into(), form)])
}

/// The text with one space for each run of spaces and line ends.
pub(super) fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

impl fmt::Display for ColumnMap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

fn channel_names() -> String {
    names().chain([STAMP, RAW]).collect::<Vec<_>>().join(" ")
}

fn unit_names(channel: &str) -> String {
    let names: Vec<_> = match by_name(channel) {
        Some(index) if known(index).quantity == Quantity::Value => return "one, such as s/s, ns or V".into(),
        Some(index) => units(known(index).quantity).map(|unit| &*unit.name).collect(),
        None => StampForm::all().map(StampForm::name).collect(),
    };
    format!("one of {}", names.join(" "))
}

#[cfg(test)]
mod tests {
    use super::{super::name::Meaning, *};

    #[test]
    fn columns_are_given_by_name_or_number() {
        let map: ColumnMap = " gyro_x = w=x: :deg/s , t=1:us, ".parse().unwrap();
        assert_eq!((&*map.channels[0].column, &*map.channels[0].unit.name), ("w=x:", "deg/s"));
        assert_eq!(map.stamp, [("1".to_owned(), StampForm::Unit(1000))]);
        let pair: ColumnMap = "t=secs:s+nsecs:ns".parse().unwrap();
        assert_eq!(
            pair.stamp,
            [("secs".to_owned(), StampForm::Unit(1_000_000_000)), ("nsecs".to_owned(), StampForm::Unit(1))]
        );
        let made: ColumnMap = "accel_x=ax:mm/s^2,gyro_x=wx:0.01 rad/s".parse().unwrap();
        assert_eq!(made.channels.iter().map(|mapped| mapped.unit.scale).collect::<Vec<_>>(), [1e-3, 1e-2]);
        for text in ["t=secs:s+nsecs:ns", "t=1:s+2:ns,raw=VNYMR read", "t=Time (local):iso", "raw=5", "t=a:b+c:clock"] {
            assert_eq!(text.parse::<ColumnMap>().unwrap().to_string(), text);
        }
    }

    #[test]
    fn an_error_is_reported_with_the_remedy() {
        assert_eq!(
            channel_names(),
            "yaw pitch roll quat_x quat_y quat_z quat_w mag_x mag_y mag_z accel_x accel_y accel_z gyro_x gyro_y gyro_z temperature \
             pressure value t raw"
        );
        for (text, message) in [
            ("", "no channel is mapped: map at least one of CHANNELS"),
            (" , ", "no channel is mapped: map at least one of CHANNELS"),
            ("gyro_x=wx", "\"gyro_x=wx\" is not of the form CHANNEL=COLUMN:UNIT, as in gyro_x=wx:deg/s or t=1:ns"),
            ("gyro_x", "\"gyro_x\" is not of the form CHANNEL=COLUMN:UNIT, as in gyro_x=wx:deg/s or t=1:ns"),
            ("gyro_x=:g", "\"gyro_x=:g\" is not of the form CHANNEL=COLUMN:UNIT, as in gyro_x=wx:deg/s or t=1:ns"),
            ("gyr_x=wx:g", "unknown channel \"gyr_x\" in \"gyr_x=wx:g\": use one of CHANNELS"),
            (
                "gyro_x=wx:g",
                "unknown unit \"g\" of gyro_x in \"gyro_x=wx:g\": use one of rad/s deg/s deg/h mdeg/s mrad/s rpm",
            ),
            (
                "t=1:week",
                "unknown unit \"week\" of t in \"t=1:week\": use one of s ms us ns 100us d min h iso dmy mdy clock mmss",
            ),
            ("yaw=1:deg,yaw=2:deg", "yaw is mapped twice, again in \"yaw=2:deg\": keep one"),
            ("t=1:s,t=2:s", "t is mapped twice, again in \"t=2:s\": keep one"),
        ] {
            let message = message.replace("CHANNELS", &channel_names());
            assert_eq!(text.parse::<ColumnMap>().unwrap_err().to_string(), message);
        }
    }

    #[test]
    fn a_series_may_be_in_any_unit() {
        for unit in ["s/s", "ns", "V", "parts per billion"] {
            let text = format!("value=2:{unit}");
            assert_eq!(text.parse::<ColumnMap>().unwrap().to_string(), text);
        }
        let without = "value=2:".parse::<ColumnMap>().unwrap_err().to_string();
        assert_eq!(without, "unknown unit \"\" of value in \"value=2:\": use one, such as s/s, ns or V");
        assert!(Meaning::of("value", None).is_none(), "a column of this name is not taken for one");
    }
}
