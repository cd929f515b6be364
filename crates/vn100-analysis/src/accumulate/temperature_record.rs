//! The axes of a sensor against its temperature, which the stream carries or which was polled.

use imu_noise::{NoCoefficient, Sensor, TemperatureBlocks, TemperatureSearch};
use vn100_protocol::{Channel, Layout, Quantity, VNIMU};

use crate::sensor::sensor_of;

/// Sums of the angular rates and accelerations of a record against the temperature of the sensor.
#[derive(Debug, Clone)]
pub struct TemperatureRecord {
    blocks: TemperatureBlocks,
    /// The places of the axes in the layout.
    axes: Vec<usize>,
    /// The place of the temperature; `None` if it is polled.
    temperature: Option<usize>,
    degrees_per_count: f64,
}

impl TemperatureRecord {
    /// By the first temperature of the stream; `None` without one, or without an axis.
    pub(crate) fn of_stream(layout: &Layout) -> Option<Self> {
        let place = layout.channels.iter().position(is_temperature)?;
        Self::new(layout, Some(place), &layout.channels[place])
    }

    /// By readings of register 54 between the rows; `None` without an axis.
    pub(crate) fn polled(layout: &Layout) -> Option<Self> {
        Self::new(layout, None, VNIMU.channels.iter().find(|channel| is_temperature(channel))?)
    }

    fn new(layout: &Layout, temperature: Option<usize>, channel: &Channel) -> Option<Self> {
        let sensor = |place: &usize| sensor_of(layout.channels[*place].quantity);
        let is_axis = |place: &usize| matches!(sensor(place), Some(Sensor::Gyroscope | Sensor::Accelerometer));
        let axes: Vec<usize> = (0..layout.channels.len()).filter(is_axis).collect();
        let blocks = TemperatureBlocks::new(axes.len());
        (!axes.is_empty()).then(|| Self { blocks, axes, temperature, degrees_per_count: channel.in_unit(1.0) })
    }

    /// Adds samples of the channel at this place of the layout, the first with this absolute index.
    pub(crate) fn push(&mut self, place: usize, first: u64, counts: &[i32]) {
        if let Some(axis) = self.number_of(place) {
            self.blocks.push_axis(axis, first, counts);
        } else if self.temperature == Some(place) {
            self.blocks.push_temperature(first, counts);
        }
    }

    /// Adds a reading at this sample; ignored where the stream carries the temperature.
    pub(crate) fn push_reading(&mut self, index: u64, counts: i32) {
        if self.is_polled() {
            self.blocks.push_temperature(index, &[counts]);
        }
    }

    pub(crate) fn part(&mut self) {
        self.blocks.part();
    }

    /// Whether the temperature was polled between the rows, and is no channel of the stream.
    pub const fn is_polled(&self) -> bool {
        self.temperature.is_none()
    }

    /// The search for the temperature coefficients of all axes.
    pub(crate) fn search(&self, interval_s: f64) -> Result<TemperatureSearch, NoCoefficient> {
        TemperatureSearch::new(&self.blocks, interval_s, self.degrees_per_count)
    }

    /// The number of the axis at this place; `None` for another channel, and for an axis that lacks more
    /// than a tenth of its samples.
    pub(crate) fn axis(&self, place: usize) -> Option<usize> {
        let axis = self.number_of(place)?;
        let (absent, samples) = self.blocks.lacks(axis);
        (10 * absent <= samples).then_some(axis)
    }

    fn number_of(&self, place: usize) -> Option<usize> {
        self.axes.iter().position(|axis| *axis == place)
    }
}

fn is_temperature(channel: &Channel) -> bool {
    channel.quantity == Quantity::Temperature
}
