//! How the bias of each axis follows the temperature of the sensor.

use crate::hypothesis_tests::holm;
use imu_noise::{NoCoefficient, PROVED_P};
use vn100_protocol::Channel;

use super::{ChannelAssessment, LongTauValidity, axis_temperature::AxisTemperature};
use crate::{
    in_parallel::in_parallel,
    snapshot::Snapshot,
    warning::{Finding, Warning},
};

/// The axes whose noise the temperature exaggerates.
pub(super) fn warning(snapshot: &Snapshot, channels: &[ChannelAssessment]) -> Option<Warning> {
    let following = |(channel, _, assessed)| -> Option<(&Channel, f64)> {
        let assessed: &ChannelAssessment = assessed;
        let temperature = assessed.noise.as_ref()?.temperature.as_ref()?;
        Some((channel, temperature.share_as_noise()?))
    };
    let axes: Vec<(&Channel, f64)> = snapshot.assessed(channels).filter_map(following).collect();
    let (worst, share) = axes.iter().max_by(|(_, a), (_, b)| a.total_cmp(b))?;
    let names: Vec<String> = axes.iter().map(|(channel, _)| channel.name.to_string()).collect();
    let found = Finding::Temperature(worst.name.to_string(), *share);
    Some(Warning::new(found).of(names))
}

/// Adds to the noise of each axis how it follows the temperature.
pub(super) fn add(snapshot: &Snapshot, was_moved: bool, confidence: f64, channels: &mut [ChannelAssessment]) {
    let Some(temperature) = &snapshot.temperature else { return };
    let search = temperature.search(snapshot.shape().interval_s);
    let coefficient = |(place, channel): (usize, &Channel)| {
        let (axis, noise) = (temperature.axis(place)?, channels.get(place)?.noise.as_ref()?);
        Some(match (noise.long_taus, &search) {
            _ if was_moved => Err(NoCoefficient::Moved),
            (LongTauValidity::Sensor, Ok(search)) => {
                search.coefficient(axis, channel.in_unit(1.0), confidence).ok_or(NoCoefficient::Constant)
            }
            (LongTauValidity::Sensor, Err(why)) => Err(*why),
            _ => Err(NoCoefficient::BiasNotInStream),
        })
    };
    let axes = snapshot.layout_channels().iter().enumerate();
    // without a coefficient to be found there is no work to be shared
    let found: Vec<_> = if search.is_ok() { in_parallel(axes, coefficient) } else { axes.map(coefficient).collect() };
    let tests: Vec<f64> = found.iter().flatten().flatten().map(|found| found.p).collect();
    let mut corrected = holm(&tests).into_iter();
    let search = search.ok();
    for (channel, coefficient) in channels.iter_mut().zip(found) {
        let (Some(noise), Some(coefficient)) = (&mut channel.noise, coefficient) else { continue };
        noise.temperature = Some(AxisTemperature {
            excursion_c: search.as_ref().map(|search| search.excursion_c),
            correlation_with_time: search.as_ref().map(|search| search.correlation_with_time),
            is_polled: temperature.is_polled(),
            is_proved: coefficient.is_ok() && corrected.next().is_some_and(|p| p <= PROVED_P),
            coefficient,
        });
    }
}
