//! The axes of a sensor against its temperature, which the stream carries or which was polled.

use imu_noise::{NoCoefficient, Sensor, TemperatureBlocks, TemperatureSearch};
use vn100_protocol::{Channel, Layout, Quantity, VNIMU};

use crate::sensor::sensor_of;

/// Sums of the angular rates and accelerations of a record against the temperature of the sensor.
#[derive(Debug, Clone)]
pub struct TemperatureRecord {
    blocks: TemperatureBlocks,
    /// The role of each channel of the layout.
    parts: Vec<ChannelRole>,
    degrees_per_count: f64,
    is_polled: bool,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum ChannelRole {
    None,
    Temperature,
    Axis(usize),
}

impl TemperatureRecord {
    /// By the first channel of the stream that is a temperature; `None` without one, or without an
    /// axis.
    pub(crate) fn of_stream(layout: &Layout) -> Option<Self> {
        let temperature = layout.channels.iter().position(is_temperature)?;
        let mut record = Self::new(layout, &layout.channels[temperature], false)?;
        record.parts[temperature] = ChannelRole::Temperature;
        Some(record)
    }

    /// By readings of register 54 between the rows; `None` without an axis.
    pub(crate) fn polled(layout: &Layout) -> Option<Self> {
        Self::new(layout, VNIMU.channels.iter().find(|channel| is_temperature(channel))?, true)
    }

    fn new(layout: &Layout, temperature: &Channel, is_polled: bool) -> Option<Self> {
        let mut axes = 0;
        let part = |channel: &Channel| match sensor_of(channel.quantity) {
            Some(Sensor::Gyroscope | Sensor::Accelerometer) => {
                axes += 1;
                ChannelRole::Axis(axes - 1)
            }
            Some(Sensor::Magnetometer) | None => ChannelRole::None,
        };
        let parts: Vec<ChannelRole> = layout.channels.iter().map(part).collect();
        (axes > 0).then(|| Self {
            blocks: TemperatureBlocks::new(axes),
            parts,
            degrees_per_count: temperature.in_unit(1.0),
            is_polled,
        })
    }

    /// Adds samples of the channel at this place of the layout, the first with this absolute index.
    pub(crate) fn push(&mut self, place: usize, first: u64, counts: &[i32]) {
        match self.parts.get(place) {
            Some(ChannelRole::Axis(axis)) => self.blocks.push_axis(*axis, first, counts),
            Some(ChannelRole::Temperature) => self.blocks.push_temperature(first, counts),
            Some(ChannelRole::None) | None => {}
        }
    }

    /// Adds a reading at the sample with this index; ignored where the stream carries the
    /// temperature.
    pub(crate) fn push_reading(&mut self, index: u64, counts: i32) {
        if self.is_polled {
            self.blocks.push_temperature(index, &[counts]);
        }
    }

    pub(crate) fn part(&mut self) {
        self.blocks.part();
    }

    /// Whether the temperature was polled between the rows, and is no channel of the stream.
    #[must_use]
    pub const fn is_polled(&self) -> bool {
        self.is_polled
    }

    /// The search for the temperature coefficients of all axes.
    pub(crate) fn search(&self, interval_s: f64) -> Result<TemperatureSearch, NoCoefficient> {
        TemperatureSearch::new(&self.blocks, interval_s, self.degrees_per_count)
    }

    /// The number of the axis at this place of the layout; `None` for another channel, and for an
    /// axis that lacks more than a tenth of its samples.
    pub(crate) fn axis(&self, place: usize) -> Option<usize> {
        match self.parts.get(place) {
            Some(ChannelRole::Axis(axis)) => {
                let (absent, samples) = self.blocks.lacks(*axis);
                (10 * absent <= samples).then_some(*axis)
            }
            _ => None,
        }
    }
}

fn is_temperature(channel: &Channel) -> bool {
    channel.quantity == Quantity::Temperature
}
