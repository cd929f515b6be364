//! The content of a message as data: its channels, their units and their decimals.

use alloc::{borrow::Cow, string::String, vec::Vec};

/// A measuring message: its name and its channels in the order of the wire.
#[derive(Debug, Clone, PartialEq)]
pub struct Layout {
    /// The header of the sentence, without the `$`.
    pub message: Cow<'static, str>,
    /// Whether user calibration is applied and the bias estimated by the attitude filter is
    /// subtracted from the angular rates; `None` if neither a message nor a user tells it.
    pub compensated: Option<bool>,
    /// The channels.
    pub channels: Cow<'static, [Channel]>,
    /// The source of the channels in a table or a bag, whose units may be mistaken; `None` for the
    /// messages of the sensor.
    pub columns: Option<ColumnsRead>,
}

/// The columns of a table, or the fields of a message of another program, that are read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ColumnsRead {
    /// One for each channel, in the same order.
    pub columns: Vec<ColumnRead>,
    /// The columns of the times with their forms, as written in a column map; `None` without times.
    pub times: Option<String>,
}

/// A column that is read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ColumnRead {
    /// The column as written in a column map: by the name in the file, or by its number from 1.
    pub name: String,
    /// The assumed unit of its numbers.
    pub unit: String,
}

impl ColumnsRead {
    /// The column map that reads `channels` again in the same way, except for units that `unit`
    /// gives in place of the channel's own.
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
    /// The measured quantity.
    pub quantity: Quantity,
    /// The unit of its value.
    pub unit: Cow<'static, str>,
    /// The digits after the point: a count of 1 is 10^-`decimals` · `scale` units.
    pub decimals: u8,
    /// The printed unit in units of the channel: 1 for the sensor's own messages, another factor
    /// for a file in other units. Binary floats have no decimals and a power of two here, which
    /// scales every count and every mean of counts exactly.
    pub scale: f64,
    /// The counts of the value whose count is 0: 0, but for numbers with a large constant part.
    pub zero_counts: i64,
    /// The largest magnitude of a count; with a larger one the line is damaged.
    pub limit_counts: i32,
    /// The number of new measurements per second, if rows in between repeat the value; `None` for a
    /// channel that is new in every row, and for sentences.
    pub refresh_hz: Option<u32>,
    /// For a mean over the whole interval before its row, which the sensor has integrated so that
    /// no noise is aliased: the smallest step of an increment, in units times seconds; 0 for
    /// floats. Register 82 tells whether it is compensated. `None` for a momentary value.
    pub increment_step: Option<f64>,
}

/// The quantity of a channel.
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
    /// A number of a foreign series, of no known sensor: no rule for motion, gravity or a data
    /// sheet applies.
    Value,
}

#[expect(clippy::panic, reason = "evaluated at compile time alone")]
impl Layout {
    /// The channels of a row of the table, for constants; panics at compile time for a layout that
    /// owns them.
    pub(super) const fn constant_channels(&self) -> &[Channel] {
        match &self.channels {
            Cow::Borrowed(channels) => channels,
            Cow::Owned(_) => panic!("a row of the table owns nothing"),
        }
    }
}

impl Quantity {
    /// Whether it is an attitude, which only a filter determines.
    pub fn is_attitude(self) -> bool {
        matches!(self, Self::Angle | Self::Quaternion)
    }
}

impl Channel {
    /// The value of `count` in [`unit`](Self::unit): with a scale of 1 the float nearest to the
    /// printed decimal, for up to 22 decimals.
    pub fn value(&self, count: i32) -> f64 {
        self.in_unit((i64::from(count) + self.zero_counts) as f64)
    }

    /// The number of rows at `rate_hz` from one new measurement of the sensor to the next, rounded
    /// up to a power of two.
    pub fn stride(&self, rate_hz: f64) -> u64 {
        let rows = self.refresh_hz.map_or(1.0, |refresh_hz| rate_hz / f64::from(refresh_hz));
        // in integers, because rounding needs the standard library
        let whole = rows.min(1e9) as u64;
        (whole + u64::from((whole as f64) < rows)).max(1).next_power_of_two()
    }

    /// A mean, a deviation or a difference of counts in [`unit`](Self::unit): divided once by a
    /// power of ten, which is exact up to 22 decimals, and multiplied once by the scale.
    pub fn in_unit(&self, counts: f64) -> f64 {
        counts / (0..self.decimals).fold(1.0, |power, _| power * 10.0) * self.scale
    }
}

/// The rates in hertz at which the sensor sends a message, as register 7 accepts them.
pub const OUTPUT_RATES_HZ: [u32; 11] = [1, 2, 4, 5, 10, 20, 25, 40, 50, 100, 200];

/// The number of digits in the numbers of a sentence.
///
/// | | angles | magnetic field | acceleration | angular rate |
/// |---|---|---|---|---|
/// | `Current` | `+ddd.ddd` | `+dd.dddd` | `+dd.ddd` | `+dd.dddddd` |
/// | `Old` (firmware 1 and earlier) | `+ddd.dd` | `+d.dddd` | `+dd.ddd` | `+dd.dddd` |
///
/// The whole digits are a minimum: a larger value takes more. Counts always have the decimals of
/// the layout: counts of an old sentence are multiplied by 10 or 100, which is exact.
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
    pub const fn decimals(self, channel: &Channel) -> u8 {
        match (self, channel.quantity) {
            (Self::Old, Quantity::Angle) => 2,
            (Self::Old, Quantity::AngularRate) => 4,
            _ => channel.decimals,
        }
    }

    /// Whether messages of these channels have this format: the format of temperature and pressure
    /// in old firmware is not known.
    pub(super) fn covers(self, channels: &[Channel]) -> bool {
        let is_new = |channel: &Channel| matches!(channel.quantity, Quantity::Temperature | Quantity::Pressure);
        self == Self::Current || !channels.iter().any(is_new)
    }
}
