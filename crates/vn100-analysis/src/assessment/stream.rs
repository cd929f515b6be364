//! What changes the noise between the sensor and its stream: a filter, other sources of noise,
//! rounding.

use vn100_protocol::{Channel, ImuFilter, Quantity, Register};

use super::{ChannelAssessment, WindowFrom, noise::LongTauValidity, rounding::hidden_terms};
use crate::{
    snapshot::{ChannelSnapshot, Snapshot},
    warning::{Finding, Severity, Warning},
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
    warnings.extend(ignored_window(snapshot, assessed));
    if was_moved {
        return warnings;
    }
    let tracked = names(&|_, _, assessed| {
        assessed.noise.as_ref().is_some_and(|noise| noise.long_taus == LongTauValidity::LooksCompensated)
    });
    warnings.extend(Warning::of_any(Finding::BiasTracked, tracked));
    let filtered = names(&|_, _, assessed| correlated_over(assessed).is_some());
    let samples = assessed.iter().filter_map(correlated_over).fold(0.0, f64::max);
    warnings.extend(Warning::of_any(Finding::LowPass(samples), filtered));
    let full = names(&|_, _, assessed| assessed.noise.as_ref().is_some_and(|noise| noise.fit.lacks_free_band));
    warnings.extend(Warning::of_any(Finding::NoFreeBand, full));
    warnings.extend(correlated_noise(snapshot, assessed));
    // a series of no sensor has no model, and its curve is shown all the same
    let rounded = names(&|channel, results, assessed| match channel.quantity {
        Quantity::Value => !hidden_terms(channel, results).is_empty(),
        _ => assessed.noise.as_ref().is_some_and(|noise| !noise.rounded_away.is_empty()),
    });
    warnings.extend(Warning::of_any(Finding::RoundedAway, rounded));
    warnings
}

/// A window that was given, and that register 85 contradicts or no channel has.
fn ignored_window(snapshot: &Snapshot, assessed: &[ChannelAssessment]) -> Option<Warning> {
    let given = snapshot.settings.window?;
    let filter = snapshot.register::<ImuFilter>(Register::IMU_FILTER);
    let windows = filter.map(|filter| [filter.accel_window, filter.gyro_window].map(u32::from));
    let is_taken =
        |channel: &ChannelAssessment| channel.onboard.is_some_and(|onboard| onboard.window_from == WindowFrom::Given);
    let counts = assessed.is_empty() || windows == Some([given; 2]) || assessed.iter().any(is_taken);
    (!counts).then(|| Warning::new(Finding::WindowIgnored(given, windows)).as_severe_as(Severity::Caution))
}

/// The correlation time in samples of a filter that is not the sensor's own.
fn correlated_over(assessed: &ChannelAssessment) -> Option<f64> {
    let fit = &assessed.noise.as_ref()?.fit;
    let own = assessed.onboard.and_then(|onboard| onboard.own_low_pass());
    fit.correlation_samples.filter(|found| own.is_none_or(|own| *found > own))
}

fn correlated_noise(snapshot: &Snapshot, assessed: &[ChannelAssessment]) -> Option<Warning> {
    let of = |(channel, _, assessed): (&Channel, &ChannelSnapshot, &ChannelAssessment)| {
        let fit = &assessed.noise.as_ref()?.fit;
        let apparent = fit.apparent_white()?;
        let process = fit.likeliest.processes.iter().max_by(|a, b| a.sigma.total_cmp(&b.sigma))?;
        let (name, unit) = (channel.name.to_string(), channel.unit.to_string());
        Some((name, process.sigma, unit, process.correlation_time_s, apparent))
    };
    let found: Vec<_> = snapshot.assessed(assessed).filter_map(of).collect();
    let channels: Vec<String> = found.iter().map(|(channel, ..)| channel.clone()).collect();
    Warning::of_any(Finding::Correlated(found), channels)
}
