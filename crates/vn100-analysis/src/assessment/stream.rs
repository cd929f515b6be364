//! What changes the noise between the sensor and its stream: averaging and decimation on board, a
//! filter of the bias, rounding.

use vn100_protocol::{Channel, Quantity};

use super::{
    ChannelAssessment,
    noise::LongTauValidity,
    onboard::{Onboard, WindowFrom, filter},
    rounding::hidden_terms,
};
use crate::{
    remedy::{Remedy, Setting, Text},
    sensor::{sensor_name, sensor_of},
    snapshot::{ChannelSnapshot, Snapshot},
    warning::{Warning, WarningKind},
};

/// `was_moved`: what the curves show is the motion.
pub(super) fn warnings(snapshot: &Snapshot, assessed: &[ChannelAssessment], was_moved: bool) -> Vec<Warning> {
    let names = |holds: &dyn Fn(&Channel, &ChannelSnapshot, &ChannelAssessment) -> bool| -> Vec<String> {
        (snapshot.assessed(assessed))
            .filter(|(channel, results, assessed)| holds(channel, results, assessed))
            .map(|(channel, ..)| channel.name.to_string())
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
        for (channel, ..) in snapshot.assessed(assessed).filter(|(.., assessed)| assessed.onboard == Some(onboard)) {
            let sensor = sensor_of(channel.quantity).map_or("sensor", sensor_name);
            if !sensors.contains(&sensor) {
                sensors.push(sensor);
            }
        }
        if let Some((headline, details)) = decimation(&sensors, &onboard) {
            let channels = names(&|_, _, assessed| assessed.onboard == Some(onboard));
            warnings.push(Warning::new(WarningKind::DecimatedStream, channels, headline, details));
        }
    }
    warnings.extend(contradicted_window(snapshot));
    if was_moved {
        return warnings;
    }
    let tracked = names(&|_, _, assessed| {
        assessed.noise.as_ref().is_some_and(|noise| noise.long_taus == LongTauValidity::LooksCompensated)
    });
    if !tracked.is_empty() {
        let headline = format!("a filter removes the bias of {}: B and K not measurable", tracked.join(" "));
        let details = "At long averaging times the deviation falls below the white noise of the channel, which that of a sensor does \
                       not. Record its uncompensated output to measure bias instability, random walk and ramp.";
        warnings.push(Warning::new(WarningKind::CompensatedStream, tracked, headline, details));
    }
    let filtered = names(&|_, _, assessed| correlated_over(assessed).is_some());
    if !filtered.is_empty() {
        let samples = assessed.iter().filter_map(correlated_over).fold(0.0, f64::max);
        let headline =
            format!("low-pass filter on {}: white noise correlated over {samples:.1} samples", filtered.join(" "));
        let details = "The spectrum falls towards high frequencies as noise of a sensor does not: a low pass slower than the output, of \
                       unknown transfer function. N is the density at low frequencies, as the fit of the whole spectrum gives it.";
        warnings.push(Warning::new(WarningKind::LowPass, filtered, headline, details));
    }
    let unsure = names(&|_, _, assessed| assessed.noise.as_ref().is_some_and(|noise| noise.fit.may_be_filtered));
    if !unsure.is_empty() {
        let headline = format!("possible filter on {}: N known less well", unsure.join(" "));
        let details = "The spectrum may be that of a filter slower than the output, or of white noise by chance. The interval of N \
                       holds with and without a filter. A longer record can decide.";
        warnings.push(Warning::new(WarningKind::PossibleFilter, unsure, headline, details));
    }
    let full = names(&|_, _, assessed| assessed.noise.as_ref().is_some_and(|noise| noise.fit.lacks_free_band));
    if !full.is_empty() {
        let headline = format!("spectral peaks cover more than half of the band on {}", full.join(" "));
        let details = "What looks like white noise between them may be theirs: only an upper bound for N is given. Measure on a heavy \
                       base, away from vibration.";
        warnings.push(Warning::new(WarningKind::LineFreeBand, full, headline, details));
    }
    warnings.extend(correlated_noise(snapshot, assessed));
    // a series of no sensor has no model, and its curve is shown all the same
    let rounded = names(&|channel, results, assessed| match channel.quantity {
        Quantity::Value => !hidden_terms(channel, results).is_empty(),
        _ => assessed.noise.as_ref().is_some_and(|noise| !noise.rounded_away.is_empty()),
    });
    if !rounded.is_empty() {
        let headline = format!("quantisation hides the noise of {}", rounded.join(" "));
        let details = "From sample to sample the noise is less than half a step of the values: the curve is that of the rounding. \
                       Of values with a large constant part, subtract that: the rest is then kept in finer steps.";
        warnings.push(Warning::new(WarningKind::QuantisationFloor, rounded, headline, details));
    }
    warnings
}

/// A window that was given and that register 85 contradicts.
fn contradicted_window(snapshot: &Snapshot) -> Option<Warning> {
    let (given, filter) = snapshot.given_window.zip(filter(snapshot))?;
    let windows = [filter.accel_window, filter.gyro_window].map(u32::from);
    (windows != [given; 2]).then(|| {
        let [accel, gyro] = windows;
        let headline = format!("averaging window {given} ignored: register 85 is {accel} (accel), {gyro} (gyro)");
        Warning::new(WarningKind::DecimatedStream, Vec::new(), headline, "The stream contains the register.")
    })
}

/// The correlation time in samples of a filter that is not the sensor's own.
fn correlated_over(assessed: &ChannelAssessment) -> Option<f64> {
    let fit = &assessed.noise.as_ref()?.fit;
    let own = assessed.onboard.and_then(|onboard| onboard.own_low_pass());
    let unknown =
        fit.roll_off.filter(|found| own.is_none_or(|own| found.correlation_samples > own.correlation_samples));
    unknown.map(|found| found.correlation_samples)
}

fn correlated_noise(snapshot: &Snapshot, assessed: &[ChannelAssessment]) -> Option<Warning> {
    let found: Vec<(String, String)> = (snapshot.assessed(assessed))
        .filter_map(|(channel, _, assessed)| {
            let fit = &assessed.noise.as_ref()?.fit;
            let apparent = fit.apparent_white()?;
            let process = fit.processes.iter().max_by(|a, b| a.sigma.total_cmp(&b.sigma))?;
            let (name, unit) = (channel.name.to_string(), &channel.unit);
            let text = format!(
                "{name} {:.2e} {unit} with a correlation time of about {:.1} s, apparent random walk {apparent:.3e} {unit}/sqrt(Hz)",
                process.sigma, process.correlation_time_s
            );
            Some((name, text))
        })
        .collect();
    if found.is_empty() {
        return None;
    }
    let (channels, list): (Vec<_>, Vec<_>) = found.into_iter().unzip();
    let headline = format!("correlated noise, in addition to white noise, on {}", channels.join(" "));
    let details = format!(
        "{}. N holds for averaging times below the correlation time; over longer times the integral follows the apparent random walk.",
        list.join("; ")
    );
    Some(Warning::new(WarningKind::CorrelatedNoise, channels, headline, details))
}

/// What averaging and decimation on board do to white noise, and what to do about it; `None` where
/// that is less than is known of the factor.
fn decimation(sensors: &[&str], onboard: &Onboard) -> Option<(String, Text)> {
    let Onboard { refresh_hz, rate_hz, window, window_from } = *onboard;
    let averages = match window.length {
        0 | 1 => "does not average them".into(),
        length => format!("averages {length} samples"),
    };
    let source = match window_from {
        WindowFrom::Register => "register 85",
        WindowFrom::Given => "as given",
        WindowFrom::Integrated => "integrals",
        WindowFrom::Default => "factory default of register 85",
    };
    let factor = window.white_factor();
    let all = sensors.join(" and ");
    let sampling = format!("Sampled at {refresh_hz} Hz; the sensor {averages} ({source}) and outputs {rate_hz} Hz.");
    let is_imu = refresh_hz > Onboard::MAG_REFRESH_HZ;
    let window_to_set = onboard.unaliased_window();
    let advice = match is_imu {
        true => Text::from(format!(" A window of {window_to_set} (`"))
            .remedy(Remedy::Configure(Setting::Window(window_to_set)))
            .then("`) avoids it."),
        false => Text::default(),
    };
    if window.overlaps() && onboard.window_known() {
        let details = format!(
            "{sampling} Neighbouring samples share values, so that deviations at short averaging times are too low; N is corrected for it."
        );
        Some((format!("{all}: averaging window longer than the output interval"), Text::from(details).append(advice)))
    } else if factor > 1.0 + Onboard::UNCERTAINTY {
        let percent = 100.0 * Onboard::UNCERTAINTY;
        let headline = format!("aliasing raises N of {all} {factor:.2} times (±{percent:.0} %)");
        let details = format!(
            "{sampling} White noise above {} Hz aliases into the band: multiply the density of a data sheet by that factor before comparing.",
            rate_hz / 2.0
        );
        let details = Text::from(details).append(advice);
        Some((
            headline,
            match onboard.window_known() || !is_imu {
                true => details,
                false => details.then(" If register 85 is known, set ").remedy(Remedy::GiveWindow).then("."),
            },
        ))
    } else {
        None
    }
}
