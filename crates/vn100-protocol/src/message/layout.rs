//! What a message holds, as data: its channels, their units and their decimals.

use alloc::{borrow::Cow, string::String, vec::Vec};

/// A measuring message: its name and its channels in the order of the wire.
#[derive(Debug, Clone, PartialEq)]
pub struct Layout {
    /// The header of the sentence, without the `$`.
    pub message: Cow<'static, str>,
    /// Whether user calibration is applied, and the bias that the attitude filter estimates taken
    /// off the angular rates; `None` where neither a message nor a user says so.
    pub compensated: Option<bool>,
    /// The channels.
    pub channels: Cow<'static, [Channel]>,
    /// What the channels are read from in a table or a bag, where their units may be mistaken;
    /// `None` for the messages of the sensor.
    pub columns: Option<ColumnsRead>,
}

/// The columns of a table, or the fields of a message of another program, that are read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ColumnsRead {
    /// One for each channel, in their order.
    pub columns: Vec<ColumnRead>,
    /// The columns of the times with their forms, as a column map names them; `None` without times.
    pub times: Option<String>,
}

/// A column that is read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ColumnRead {
    /// As a column map names it: by the name in the file, or by its number from 1.
    pub name: String,
    /// The unit that its numbers are taken to be in.
    pub unit: String,
}

impl ColumnsRead {
    /// The column map by which `channels` are read again as they were, but for the units that `unit`
    /// gives instead of that of a channel.
    #[must_use]
    pub fn map(&self, channels: &[Channel], unit: impl Fn(&Channel) -> Option<&'static str>) -> String {
        let column = |(channel, column): (&Channel, &ColumnRead)| {
            alloc::format!("{}={}:{}", channel.name, column.name, unit(channel).unwrap_or(&column.unit))
        };
        let columns = channels.iter().zip(&self.columns).map(column);
        let times = self.times.as_ref().map(|times| alloc::format!("t={times}"));
        columns.chain(times).collect::<Vec<_>>().join(",")
    }
}

/// One number of a message.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Its name, unique within the message.
    pub name: Cow<'static, str>,
    /// What it measures.
    pub quantity: Quantity,
    /// The unit of its value.
    pub unit: Cow<'static, str>,
    /// The digits behind the point: a count of 1 is 10^-`decimals` · `scale` units.
    pub decimals: u8,
    /// Units in one of the numbers as printed: 1 for the sensor's own messages, another factor for
    /// a file in other units. Binary floats have no decimals and a power of two here, by which
    /// every count and every mean of counts is scaled exactly.
    pub scale: f64,
    /// The largest magnitude a count may have; beyond it the line is damaged.
    pub limit_counts: i32,
    /// How often in a second the sensor measures it anew, where rows repeat it in between; `None`
    /// for what is new in every row, and in sentences.
    pub refresh_hz: Option<u32>,
    /// Of a mean over the whole interval before its row, which the sensor has integrated so that no
    /// noise is aliased: the smallest step of an increment, in units times seconds, 0 for floats.
    /// Register 82 says whether it is compensated. `None` for a momentary value.
    pub increment_step: Option<f64>,
}

/// What a channel measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Quantity {
    /// Yaw, pitch or roll: the attitude of the body against north, east, down, as Euler 3-2-1.
    Angle,
    /// An element of the quaternion of that attitude, the scalar last; q and -q are the same
    /// attitude.
    Quaternion,
    /// The magnetic flux density along an axis of the body.
    MagneticField,
    /// The specific force along an axis of the body: at rest and level, z reads about -9.8 m/s².
    Acceleration,
    /// The angular rate about an axis of the body.
    AngularRate,
    /// The temperature inside the sensor.
    Temperature,
    /// The air pressure.
    Pressure,
    /// A number of a foreign series, of no sensor known here: no rule of motion, gravity or a data
    /// sheet is for it.
    Value,
}

#[expect(clippy::panic, reason = "evaluated at compile time alone")]
impl Layout {
    /// The header of a row of the table, where a constant needs it; panics at compile time for a
    /// layout that owns it.
    pub(super) const fn constant_header(&self) -> &str {
        match &self.message {
            Cow::Borrowed(header) => header,
            Cow::Owned(_) => panic!("a row of the table owns nothing"),
        }
    }

    /// The same of its channels.
    pub(super) const fn constant_channels(&self) -> &[Channel] {
        match &self.channels {
            Cow::Borrowed(channels) => channels,
            Cow::Owned(_) => panic!("a row of the table owns nothing"),
        }
    }
}

impl Quantity {
    /// Whether it is an attitude, which only a filter gives.
    #[must_use]
    pub fn is_attitude(self) -> bool {
        matches!(self, Self::Angle | Self::Quaternion)
    }
}

impl Channel {
    /// The value of `count` in [`unit`](Self::unit): with a scale of 1 the float nearest to the
    /// printed decimal, for up to 22 decimals.
    #[must_use]
    pub fn value(&self, count: i32) -> f64 {
        self.in_unit(count.into())
    }

    /// The fewest rows, a power of two, in which the sensor measures it anew: those of rows at
    /// `rate_hz` by which its own samples lie apart.
    #[must_use]
    pub fn stride(&self, rate_hz: f64) -> u64 {
        let rows = self.refresh_hz.map_or(1.0, |refresh_hz| rate_hz / f64::from(refresh_hz));
        // in integers, as there is no rounding without the standard library
        let whole = rows.min(1e9) as u64;
        (whole + u64::from((whole as f64) < rows)).max(1).next_power_of_two()
    }

    /// A mean, a deviation or a difference of counts in [`unit`](Self::unit): divided once by a
    /// power of ten, which is exact up to 22 decimals, and multiplied once by the scale.
    #[must_use]
    pub fn in_unit(&self, counts: f64) -> f64 {
        counts / (0..self.decimals).fold(1.0, |power, _| power * 10.0) * self.scale
    }
}

/// The rates in hertz at which the sensor sends a message, as register 7 takes them.
pub const OUTPUT_RATES_HZ: [u32; 11] = [1, 2, 4, 5, 10, 20, 25, 40, 50, 100, 200];

/// How many digits the numbers of a sentence have.
///
/// | | angles | magnetic field | acceleration | angular rate |
/// |---|---|---|---|---|
/// | `Current` | `+ddd.ddd` | `+dd.dddd` | `+dd.ddd` | `+dd.dddddd` |
/// | `Old` (firmware 1 and earlier) | `+ddd.dd` | `+d.dddd` | `+dd.ddd` | `+dd.dddd` |
///
/// The whole digits are a minimum: a larger value takes more. Counts are always in the decimals of
/// the layout: those of an old sentence are multiplied by 10 or 100, which is exact.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub enum PrintFormat {
    /// Firmware 2 and 3; also every sentence with a temperature or a pressure.
    #[default]
    Current,
    /// Old firmware.
    Old,
}

impl PrintFormat {
    /// The decimals printed for `channel`.
    #[must_use]
    pub const fn decimals(self, channel: &Channel) -> u8 {
        match (self, channel.quantity) {
            (Self::Old, Quantity::Angle) => 2,
            (Self::Old, Quantity::AngularRate) => 4,
            _ => channel.decimals,
        }
    }

    /// Whether a message of these channels is printed so: how old firmware printed temperature and
    /// pressure is not on record.
    pub(super) const fn covers(self, channels: &[Channel]) -> bool {
        let mut index = 0;
        while index < channels.len() {
            if matches!((self, channels[index].quantity), (Self::Old, Quantity::Temperature | Quantity::Pressure)) {
                return false;
            }
            index += 1;
        }
        true
    }
}
