//! The unit in which the values and deviations of a channel are shown: that of the bias instability in
//! the summary.

use imu_noise::Term;
use vn100_analysis::{ChannelResult, sensor_of};
use vn100_report::units::parameter_unit;

/// How the values and deviations of a channel are shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ShownUnit<'a> {
    pub(crate) name: &'a str,
    /// One of the channel's own unit in this one.
    pub(crate) factor: f64,
    /// That resolve a sample.
    pub(crate) decimals: usize,
}

impl<'a> ShownUnit<'a> {
    pub(crate) fn of(channel: &'a ChannelResult) -> Self {
        let of_sensor = |sensor| parameter_unit(sensor, Term::BiasInstability);
        let (name, factor) = sensor_of(channel.quantity).map_or((channel.unit.as_str(), 1.0), of_sensor);
        let decimals = (channel.decimals as f64 - factor.log10()).ceil().max(0.0) as usize;
        Self { name, factor, decimals }
    }
}
