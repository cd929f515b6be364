//! The assignment of the columns of a foreign CSV file to channels and units:
//! `gyro_x=wx:deg/s,accel_x=4:g,t=time:ns`.

use std::{borrow::Cow, f64::consts::PI, fmt, str::FromStr, sync::LazyLock};

use vn100_protocol::{Channel, MESSAGES, Quantity};

use super::stamp::{StampForm, StampUnit};

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
/// - `degC` `K` for the temperature, `kPa` `hPa` `Pa` for the pressure, any word for `value`, which
///   is not converted,
/// - and for the stamp `s` `ms` `us` `ns` `100us` `d`, `iso` for a date with the year first, `dmy`, `mdy`,
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
    /// Empty if only the stamp or the sentences are mapped.
    pub(crate) channels: Vec<MappedChannel>,
    /// The column of the stamps, and the column that is added to it, if there are two.
    pub(super) stamp: Vec<(ColumnName, StampForm)>,
    /// The column of sentences.
    pub(super) sentence: Option<ColumnName>,
}

/// A column that holds a channel.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MappedChannel {
    /// The index, as in [`known`].
    pub(crate) index: usize,
    pub(crate) column: ColumnName,
    pub(crate) unit: Unit,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum ColumnName {
    Header(String),
    /// The number, from 1.
    Number(usize),
}

/// The reason why a text is no [`ColumnMap`].
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ColumnMapError {
    /// A part between two commas does not have the form `CHANNEL=COLUMN:UNIT`.
    #[error("{0:?} is not of the form CHANNEL=COLUMN:UNIT, as in gyro_x=wx:deg/s or t=1:ns")]
    Form(String),
    /// No channel has this name.
    #[error("unknown channel {channel:?} in {part:?}: use one of {}", channel_names())]
    Channel {
        /// The text before the `=`.
        channel: String,
        /// The part between two commas.
        part: String,
    },
    /// The channel cannot be in this unit.
    #[error("unknown unit {unit:?} of {channel} in {part:?}: use {}", unit_names(channel))]
    Unit {
        /// The text after the last `:`.
        unit: String,
        /// The channel.
        channel: String,
        /// The part between two commas.
        part: String,
    },
    /// This part names column 0, but columns are numbered from 1.
    #[error("column 0 in {0:?} does not exist: columns are numbered from 1")]
    ColumnZero(String),
    /// A channel is mapped twice.
    #[error("{channel} is mapped twice, again in {part:?}: keep one")]
    Twice {
        /// The channel.
        channel: String,
        /// The part between two commas.
        part: String,
    },
    /// A column of sentences is mapped together with columns of values.
    #[error("raw=NAME gives whole sentences, which hold all channels: map no other channel")]
    RawBesideChannels,
    /// The map is empty.
    #[error("no channel is mapped: map at least one of {}", channel_names())]
    NoChannel,
}

impl FromStr for ColumnMap {
    type Err = ColumnMapError;

    fn from_str(text: &str) -> Result<Self, ColumnMapError> {
        let mut map = Self { channels: Vec::new(), stamp: Vec::new(), sentence: None };
        // a map that a terminal broke into lines is the same map
        let text = one_line(text);
        for part in text.split(',').map(str::trim).filter(|part| !part.is_empty()) {
            map.add(part)?;
        }
        if map.columns().next().is_none() {
            return Err(ColumnMapError::NoChannel);
        }
        if map.sentence.is_some() && !map.channels.is_empty() {
            return Err(ColumnMapError::RawBesideChannels);
        }
        Ok(map)
    }
}

impl ColumnMap {
    fn add(&mut self, part: &str) -> Result<(), ColumnMapError> {
        if let Some((RAW, column)) = part.split_once('=').map(|(channel, column)| (channel.trim(), column.trim())) {
            let column = column_name(column, part)?;
            return match self.sentence.replace(column) {
                Some(_) => Err(ColumnMapError::Twice { channel: RAW.into(), part: part.into() }),
                None => Ok(()),
            };
        }
        // the name of a column may contain `=` and `:`, channel and unit cannot
        let (channel, column, unit) = part
            .split_once('=')
            .and_then(|(channel, rest)| {
                let (column, unit) = rest.rsplit_once(':')?;
                Some((channel.trim(), column.trim(), unit.trim()))
            })
            .filter(|(_, column, _)| !column.is_empty())
            .ok_or_else(|| ColumnMapError::Form(part.into()))?;
        let bad_unit = || ColumnMapError::Unit { unit: unit.into(), channel: channel.into(), part: part.into() };
        let twice = || ColumnMapError::Twice { channel: channel.into(), part: part.into() };
        if channel == STAMP {
            let form = StampForm::by_name(unit).ok_or_else(bad_unit)?;
            // two columns, as in secs:s+nsecs:ns
            let pair = StampUnit::all().find_map(|first| {
                let (seconds, part) = column.split_once(&format!(":{}+", first.name))?;
                Some((seconds.trim(), StampForm::Unit(first), part.trim()))
            });
            let columns = match pair.filter(|_| matches!(form, StampForm::Unit(_))) {
                Some((seconds, first, added)) => vec![(seconds, first), (added, form)],
                None => vec![(column, form)],
            };
            let columns = columns.into_iter().map(|(column, form)| Ok((column_name(column, part)?, form)));
            let stamp = columns.collect::<Result<_, _>>()?;
            return if std::mem::replace(&mut self.stamp, stamp).is_empty() { Ok(()) } else { Err(twice()) };
        }
        let column = column_name(column, part)?;
        let index =
            by_name(channel).ok_or_else(|| ColumnMapError::Channel { channel: channel.into(), part: part.into() })?;
        let quantity = known(index).quantity;
        let unit = match quantity {
            Quantity::Value if !unit.is_empty() && !unit.contains(char::is_control) => {
                Unit { name: unit.to_owned().into(), ..UNCONVERTED }
            }
            _ => units(quantity).find(|known| known.name == unit).cloned().ok_or_else(bad_unit)?,
        };
        if self.channels.iter().any(|mapped| mapped.index == index) {
            return Err(twice());
        }
        self.channels.push(MappedChannel { index, column, unit });
        Ok(())
    }

    /// Whether it names columns of channels, and not only the stamp.
    pub(crate) fn has_channels(&self) -> bool {
        !self.channels.is_empty()
    }

    /// The columns of the times, or of the parts that are added, with their unit in nanoseconds;
    /// `None` for text.
    pub(crate) fn stamp_columns(&self) -> impl Iterator<Item = (&ColumnName, Option<i64>)> {
        self.stamp.iter().map(|(column, form)| match form {
            StampForm::Unit(unit) => (column, Some(unit.in_nanoseconds())),
            StampForm::Date(_) => (column, None),
        })
    }

    /// Every column with the channel it holds, the stamp last.
    pub(crate) fn columns(&self) -> impl Iterator<Item = (&'static str, &ColumnName)> {
        let channels = self.channels.iter();
        channels
            .map(|mapped| (&*known(mapped.index).name, &mapped.column))
            .chain(self.stamp.iter().map(|(column, _)| (STAMP, column)))
            .chain(self.sentence.iter().map(|column| (RAW, column)))
    }
}

/// The text with one space for each run of spaces and line ends.
pub(super) fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A column by name, or by number from 1.
fn column_name(column: &str, part: &str) -> Result<ColumnName, ColumnMapError> {
    match column.parse() {
        _ if column.is_empty() => Err(ColumnMapError::Form(part.into())),
        Ok(0) => Err(ColumnMapError::ColumnZero(part.into())),
        Ok(number) => Ok(ColumnName::Number(number)),
        Err(_) => Ok(ColumnName::Header(column.into())),
    }
}

impl fmt::Display for ColumnMap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut comma = "";
        for mapped in &self.channels {
            write!(f, "{comma}{}={}:{}", known(mapped.index).name, mapped.column, mapped.unit.name)?;
            comma = ",";
        }
        for (place, (column, form)) in self.stamp.iter().enumerate() {
            let before = if place == 0 { format!("{comma}{STAMP}=") } else { "+".into() };
            write!(f, "{before}{column}:{}", form.name())?;
            comma = ",";
        }
        if let Some(column) = &self.sentence {
            write!(f, "{comma}{RAW}={column}")?;
        }
        Ok(())
    }
}

impl fmt::Display for ColumnName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Header(name) => f.write_str(name),
            Self::Number(number) => write!(f, "{number}"),
        }
    }
}

/// The name of the stamp among the channels.
pub(super) const STAMP: &str = "t";

/// The name of the sentences among the channels.
pub(super) const RAW: &str = "raw";

/// All names before an `=`.
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

/// The channels of all messages of the sensor and that of any series, in the order in which a
/// layout holds them.
static KNOWN: LazyLock<Vec<&Channel>> = LazyLock::new(|| {
    let mut known: Vec<&Channel> = Vec::new();
    for channel in MESSAGES.iter().flat_map(|layout| &*layout.channels) {
        if known.iter().all(|other| other.name != channel.name) {
            known.push(channel);
        }
    }
    known.push(&VALUE);
    known.sort_by_key(|channel| channel.quantity);
    known
});

/// Numbers of a series; the file determines the decimals and limits.
static VALUE: Channel = Channel {
    name: Cow::Borrowed("value"),
    quantity: Quantity::Value,
    unit: Cow::Borrowed("1"),
    decimals: 0,
    scale: 1.0,
    limit_counts: i32::MAX,
    refresh_hz: None,
    increment_step: None,
};

/// Standard acceleration of free fall in m/s² (BIPM, The International System of Units, 2019).
const STANDARD_GRAVITY_M_S2: f64 = 9.80665;

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Unit {
    pub(crate) name: Cow<'static, str>,
    pub(super) quantity: Quantity,
    /// The unit in units of the channel.
    pub(crate) scale: f64,
    /// The channel's own zero on this scale, in hundredths: 0 for all units except kelvin.
    pub(crate) zero_hundredths: i64,
}

/// The names of all channels.
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    KNOWN.iter().map(|channel| &*channel.name)
}

/// The channel at place `index` of the order that layouts use.
pub(crate) fn known(index: usize) -> &'static Channel {
    KNOWN[index]
}

/// The place of the channel with exactly this name.
pub(crate) fn by_name(name: &str) -> Option<usize> {
    names().position(|known| known == name)
}

/// The units of `quantity`, its channels' own unit first.
pub(crate) fn units(quantity: Quantity) -> impl Iterator<Item = &'static Unit> {
    UNITS.iter().filter(move |unit| unit.quantity == quantity)
}

static UNITS: [Unit; 26] = [
    unit("rad/s", Quantity::AngularRate, 1.0),
    unit("deg/s", Quantity::AngularRate, PI / 180.0),
    unit("deg/h", Quantity::AngularRate, PI / 648_000.0),
    unit("mdeg/s", Quantity::AngularRate, PI / 180_000.0),
    unit("mrad/s", Quantity::AngularRate, 1e-3),
    unit("rpm", Quantity::AngularRate, PI / 30.0),
    unit("m/s^2", Quantity::Acceleration, 1.0),
    unit("g", Quantity::Acceleration, STANDARD_GRAVITY_M_S2),
    unit("mg", Quantity::Acceleration, STANDARD_GRAVITY_M_S2 / 1e3),
    unit("ug", Quantity::Acceleration, STANDARD_GRAVITY_M_S2 / 1e6),
    unit("cm/s^2", Quantity::Acceleration, 1e-2),
    unit("ft/s^2", Quantity::Acceleration, 0.3048),
    unit("gauss", Quantity::MagneticField, 1.0),
    unit("mgauss", Quantity::MagneticField, 1e-3),
    unit("T", Quantity::MagneticField, 1e4),
    unit("uT", Quantity::MagneticField, 1e-2),
    unit("mT", Quantity::MagneticField, 10.0),
    unit("nT", Quantity::MagneticField, 1e-5),
    unit("deg", Quantity::Angle, 1.0),
    unit("rad", Quantity::Angle, 180.0 / PI),
    unit("1", Quantity::Quaternion, 1.0),
    unit("degC", Quantity::Temperature, 1.0),
    Unit { name: Cow::Borrowed("K"), quantity: Quantity::Temperature, scale: 1.0, zero_hundredths: 27_315 },
    unit("kPa", Quantity::Pressure, 1.0),
    unit("hPa", Quantity::Pressure, 0.1),
    unit("Pa", Quantity::Pressure, 1e-3),
];

/// The unit of numbers that are not converted.
const UNCONVERTED: Unit = unit("1", Quantity::Value, 1.0);

const fn unit(name: &'static str, quantity: Quantity, scale: f64) -> Unit {
    Unit { name: Cow::Borrowed(name), quantity, scale, zero_hundredths: 0 }
}

#[cfg(test)]
mod tests {
    use super::{super::name::Meaning, *};

    #[test]
    fn columns_are_given_by_name_or_number() {
        let map: ColumnMap = " gyro_x = w=x: :deg/s , t=1:us, ".parse().unwrap();
        assert_eq!(map.to_string(), "gyro_x=w=x::deg/s,t=1:us");
        let form = StampForm::Unit(StampUnit::USUAL[2]);
        assert_eq!(map.stamp, [(ColumnName::Number(1), form)]);
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
                "t=1:min",
                "unknown unit \"min\" of t in \"t=1:min\": use one of s ms us ns 100us d iso dmy mdy clock mmss",
            ),
            ("gyro_x=0:deg/s", "column 0 in \"gyro_x=0:deg/s\" does not exist: columns are numbered from 1"),
            ("yaw=1:deg,yaw=2:deg", "yaw is mapped twice, again in \"yaw=2:deg\": keep one"),
            ("t=1:s,t=2:s", "t is mapped twice, again in \"t=2:s\": keep one"),
        ] {
            let message = message.replace("CHANNELS", &channel_names());
            assert_eq!(text.parse::<ColumnMap>().unwrap_err().to_string(), message);
        }
    }

    #[test]
    fn every_channel_has_its_own_unit_first() {
        for (index, channel) in KNOWN.iter().enumerate().filter(|(_, channel)| channel.quantity != Quantity::Value) {
            let own = units(channel.quantity).next().unwrap();
            assert_eq!((&*own.name, own.scale), (&*channel.unit, 1.0));
            assert_eq!(by_name(&channel.name), Some(index));
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

    #[test]
    fn a_layout_of_any_message_keeps_its_order() {
        for layout in MESSAGES {
            let places = layout.channels.iter().map(|channel| by_name(&channel.name));
            assert!(places.clone().all(|place| place.is_some()) && places.is_sorted(), "{}", layout.message);
        }
    }
}
