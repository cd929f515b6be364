//! What stands between the sensor and its stream: decimation, a bias filter, rounding.

use imu_noise::counts_to_unit;
use vn100_protocol::Channel;

use super::{ChannelAssessment, Onboard, noise::LongTauValidity};
use crate::{
    remedy::{Remedy, Setting, Text},
    sensor::{sensor_name, sensor_of},
    snapshot::{ChannelSnapshot, Snapshot},
    warning::{Warning, WarningKind},
};

/// Below this ratio of noise to the last digit the rounding is no longer white noise of its own.
const LEAST_NOISE_DIGITS: f64 = 0.5;

pub(super) fn warnings(snapshot: &Snapshot, assessed: &[ChannelAssessment]) -> Vec<Warning> {
    let channels: Vec<_> = snapshot.measured().zip(assessed).collect();
    let names = |holds: &dyn Fn(&Channel, &ChannelSnapshot, &ChannelAssessment) -> bool| -> Vec<String> {
        (channels.iter())
            .filter(|((channel, results), assessed)| holds(channel, results, assessed))
            .map(|((channel, _), _)| channel.name.to_string())
            .collect()
    };
    let mut warnings = Vec::new();
    let mut filters: Vec<Onboard> = Vec::new();
    for onboard in assessed.iter().filter_map(|channel| channel.onboard) {
        if !filters.contains(&onboard) {
            filters.push(onboard);
        }
    }
    for onboard in filters {
        let mut sensors: Vec<&str> = Vec::new();
        for ((channel, _), _) in channels.iter().filter(|(_, assessed)| assessed.onboard == Some(onboard)) {
            let sensor = sensor_of(channel.quantity).map_or("sensor", sensor_name);
            if !sensors.contains(&sensor) {
                sensors.push(sensor);
            }
        }
        if let Some(text) = decimation(&sensors, &onboard, snapshot.timing.rate_hz) {
            let channels = names(&|_, _, assessed| assessed.onboard == Some(onboard));
            warnings.push(Warning::new(WarningKind::DecimatedStream, channels, text));
        }
    }
    let tracked = names(&|_, _, assessed| {
        assessed.noise.as_ref().is_some_and(|noise| noise.long_taus == LongTauValidity::LooksCompensated)
    });
    if !tracked.is_empty() {
        let text = "the deviation falls, at long tau, below the line of the channel's own white noise, which no sensor does: a filter takes \
                    the bias out. Bias instability, random walk and ramp of the sensor are not in this stream; record its uncompensated \
                    output";
        warnings.push(Warning::new(WarningKind::CompensatedStream, tracked, text));
    }
    let rounded = names(&|channel, results, assessed| {
        assessed.noise.is_some() && results.moments.count() >= 100 && is_rounded_away(channel, results)
    });
    if !rounded.is_empty() {
        let text = "from sample to sample the noise is less than half of the last printed digit: the curve is that of the rounding, not of \
                    the sensor";
        warnings.push(Warning::new(WarningKind::QuantisationFloor, rounded, text));
    }
    warnings
}

fn decimation(sensors: &[&str], onboard: &Onboard, rate_hz: f64) -> Option<Text> {
    let Onboard { refresh_hz, window, window_known } = *onboard;
    let averaged = match window.length {
        0 | 1 => "averages none of them".into(),
        length => format!("averages {length} of them"),
    };
    let (said_by, percent) = (
        if window_known { "register 85 says" } else { "unless register 85 was changed" },
        100.0 * Onboard::UNCERTAINTY,
    );
    let factor = onboard.white_factor();
    let take = match sensors {
        [one] => format!("{one} takes"),
        several => format!("{} take", several.join(" and ")),
    };
    let seen =
        format!("the {take} {refresh_hz} values a second; the sensor {averaged} ({said_by}) and sends {rate_hz}");
    let window_to_set = onboard.unaliased_window();
    let cure = match onboard.refresh_hz > 250.0 {
        true => Text::from(format!("; a window of {window_to_set} ("))
            .remedy(Remedy::Configure(Setting::Window(window_to_set)))
            .then(") brings the sensor's own density into the stream"),
        false => Text::default(),
    };
    if window.overlaps() && window_known {
        let text = format!("{seen}: neighbouring samples share values, and short taus read too low. N allows for it");
        Some(Text::from(text).append(cure))
    } else if factor > 1.0 + Onboard::UNCERTAINTY {
        let text = format!(
            "{seen}: white noise folds, and a healthy sensor reads {factor:.2} times its own density (±{percent:.0} %) in this stream, whatever \
             reads it. A data sheet's density must be multiplied by that before it is compared"
        );
        Some(Text::from(text).append(cure))
    } else {
        None
    }
}

/// White noise of less than half a digit shows as a deviation, at m = 1, of less than that.
pub(crate) fn is_rounded_away(channel: &Channel, results: &ChannelSnapshot) -> bool {
    let digit_counts = counts_to_unit(1.0, results.printed_decimals) / counts_to_unit(1.0, channel.decimals);
    let deviation = results.octaves.first().and_then(imu_noise::OctaveSum::deviation_counts);
    deviation.is_some_and(|deviation| deviation < LEAST_NOISE_DIGITS * digit_counts)
}
