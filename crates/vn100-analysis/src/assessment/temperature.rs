//! How the bias of each axis follows the temperature of the sensor.

use crate::hypothesis_tests::holm;
use imu_noise::{NoCoefficient, PROVED_P, TemperatureCoefficient, TemperatureSearch};
use vn100_protocol::Channel;

use super::{
    ChannelAssessment, ChannelNoise, LongTauValidity,
    axis_temperature::{AxisTemperature, WhyNoCoefficient},
};
use crate::{
    in_parallel::in_parallel,
    snapshot::Snapshot,
    warning::{Finding, Warning, WarningKind},
};

/// By place of the channel.
type Coefficients = Vec<Option<(Result<TemperatureCoefficient, WhyNoCoefficient>, bool)>>;

/// Of the axes that `why_none` does not exclude, and whether they are proved.
fn coefficients(
    snapshot: &Snapshot,
    search: &Result<TemperatureSearch, NoCoefficient>,
    confidence: f64,
    why_none: impl Fn(usize, &Channel) -> Option<WhyNoCoefficient> + Sync,
) -> Coefficients {
    let axis = |place: usize| snapshot.temperature.as_ref().and_then(|temperature| temperature.axis(place));
    let of = |(place, channel): (usize, &Channel)| {
        let axis = axis(place)?;
        Some(match (why_none(place, channel), search) {
            (Some(why), _) => Err(why),
            (None, Err(why)) => Err(WhyNoCoefficient::Temperature(*why)),
            (None, Ok(search)) => {
                search.coefficient(axis, channel.in_unit(1.0), confidence).ok_or(WhyNoCoefficient::Constant)
            }
        })
    };
    let channels = snapshot.layout_channels().iter().enumerate();
    // without a coefficient to be found there is no work to be shared
    let found = if search.is_ok() { in_parallel(channels, of) } else { channels.map(of).collect() };
    let p = |found: &Option<Result<TemperatureCoefficient, _>>| Some(found.as_ref()?.as_ref().ok()?.p);
    let mut corrected = holm(&found.iter().filter_map(p).collect::<Vec<_>>()).into_iter();
    let proved = |found: &Option<Result<TemperatureCoefficient, WhyNoCoefficient>>| {
        p(found).and_then(|_| corrected.next()).is_some_and(|p| p <= PROVED_P)
    };
    let are_proved: Vec<bool> = found.iter().map(proved).collect();
    found.into_iter().zip(are_proved).map(|(found, is_proved)| Some((found?, is_proved))).collect()
}

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
    Some(Warning::new(WarningKind::FollowsTemperature, found).of(names))
}

/// Adds to the noise of each axis how it follows the temperature.
pub(super) fn add(snapshot: &Snapshot, was_moved: bool, confidence: f64, channels: &mut [ChannelAssessment]) {
    let Some(temperature) = &snapshot.temperature else { return };
    let search = temperature.search(snapshot.shape().interval_s);
    let why_none = |place: usize, _: &Channel| {
        let noise = channels.get(place).and_then(|channel| channel.noise.as_ref());
        match noise.map(|noise| noise.long_taus) {
            _ if was_moved => Some(WhyNoCoefficient::Moved),
            Some(LongTauValidity::Sensor) => None,
            _ => Some(WhyNoCoefficient::BiasNotInStream),
        }
    };
    let found = coefficients(snapshot, &search, confidence, why_none);
    let search = search.as_ref().ok();
    for (place, found) in found.into_iter().enumerate() {
        let Some((coefficient, is_proved)) = found else { continue };
        let noise: Option<&mut ChannelNoise> = channels.get_mut(place).and_then(|channel| channel.noise.as_mut());
        if let Some(noise) = noise {
            noise.temperature = Some(AxisTemperature {
                excursion_c: search.map(|search| search.excursion_c),
                correlation_with_time: search.map(|search| search.correlation_with_time),
                is_polled: temperature.is_polled(),
                coefficient,
                is_proved,
            });
        }
    }
}
