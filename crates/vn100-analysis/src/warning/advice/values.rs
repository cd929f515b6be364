//! Warnings about the values of the channels.

use vn100_protocol::{Channel, Quantity};

use super::{Advice, StreamFindings, counted, samples};
use crate::{
    snapshot::{ChannelSnapshot, Snapshot},
    warning::WarningKind,
};

impl Advice {
    pub(super) fn on_values(&mut self, snapshot: &Snapshot, findings: StreamFindings) {
        if findings.print_changes > 0 {
            let headline = format!("number of printed decimals changed {}", counted(findings.print_changes, "time"));
            let details = "No averaging window spans a change; the resolution given is the coarser one.";
            self.warn(WarningKind::PrintFormat, headline, details);
        }
        if !findings.restarted.is_empty() {
            let headline = format!("{} restarted after several thousand turns", findings.restarted.join(" "));
            let details = "Mean, minimum and maximum mix the branches.";
            self.warn_of(WarningKind::AngleRestarted, findings.restarted, headline, details);
        }
        let stuck = channels_where(snapshot, |channel, results| is_stuck(channel, results, snapshot.rate_of(results)));
        if !stuck.is_empty() {
            let headline = format!("no more than two values on {}", stuck.join(" "));
            let details = "The noise lies below the last printed digit, or the channel is dead; its deviations are those of the \
                           rounding.";
            self.warn_of(WarningKind::StuckDigits, stuck, headline, details);
        }
        if let Some((headline, details)) = saturated(snapshot) {
            let axes = snapshot.saturation.axes().map(|(axis, _)| axis.to_owned());
            self.warn_of(WarningKind::FullRange, axes.collect(), headline, details);
        }
        let at_limit = channels_where(snapshot, reaches_limit);
        if !at_limit.is_empty() {
            let headline = format!("end of the sensor's range reached on {}", at_limit.join(" "));
            let details = "The range is 2.5 gauss, 16 g, 2000 deg/s as quoted. Values beyond it are clipped, and statistics of \
                           clipped values are wrong.";
            self.warn_of(WarningKind::FullRange, at_limit, headline, details);
        }
    }

    /// Channels that rows lack; those that most rows lack are named separately.
    pub(super) fn on_absent_values(&mut self, snapshot: &Snapshot) {
        let rows = snapshot.timing.samples;
        let lacking = |(channel, results): (&Channel, &ChannelSnapshot)| {
            // a channel with a rate of its own is not absent from the rows that repeat its value
            let absent = if results.stride == 1 { rows.saturating_sub(results.moments.count()) } else { 0 };
            (absent > 0).then(|| (absent, channel.name.to_string()))
        };
        let lacking: Vec<_> = snapshot.measured().filter_map(lacking).collect();
        for (is_most, details) in [
            (
                true,
                "So few values do not show the noise from row to row. If these channels have a rate of their own, put them into a \
                 file of their own, without the rows that lack them.",
            ),
            (false, "Each is a dropped sample of its own channel alone."),
        ] {
            let of: Vec<_> = lacking.iter().filter(|(absent, _)| (2 * absent > rows) == is_most).collect();
            if !of.is_empty() {
                let counts: Vec<_> = of.iter().map(|(absent, channel)| format!("{channel} {absent}")).collect();
                let headline = format!("values absent in {}: {}", counted(rows, "row"), counts.join(", "));
                let channels = of.into_iter().map(|(_, channel)| channel.clone()).collect();
                self.warn_of(WarningKind::AbsentValues, channels, headline, details);
            }
        }
    }
}

/// The axes that the sensor itself reports at the end of their range, with the time.
fn saturated(snapshot: &Snapshot) -> Option<(String, String)> {
    let saturation = &snapshot.saturation;
    let (first, last) = saturation.first_at.zip(saturation.last_at)?;
    let axes: Vec<_> = saturation.axes().map(|(axis, count)| format!("{axis} {count}")).collect();
    let headline = format!("the sensor reports saturation in {}: {}", samples(saturation.samples), axes.join(", "));
    let when = match first == last {
        true => format!("At {:.3} s of the record.", first.as_secs_f64()),
        false => format!("From {:.3} to {:.3} s of the record.", first.as_secs_f64(), last.as_secs_f64()),
    };
    Some((
        headline,
        format!("{when} Values at the end of a range are clipped, and statistics of clipped values are wrong."),
    ))
}

/// Names of the channels for which `holds`.
fn channels_where(snapshot: &Snapshot, holds: impl Fn(&Channel, &ChannelSnapshot) -> bool) -> Vec<String> {
    (snapshot.measured())
        .filter(|(channel, results)| holds(channel, results))
        .map(|(channel, _)| channel.name.to_string())
        .collect()
}

/// Whether a channel has no more than two values for longer than its quantity may be constant.
fn is_stuck(channel: &Channel, results: &ChannelSnapshot, rate_hz: f64) -> bool {
    let least_s = match channel.quantity {
        // temperature and pressure of a room do not change in seconds; their noise may be finer
        // than the printed digits
        Quantity::Temperature | Quantity::Pressure => 300.0,
        // an element near ±1 changes with the square of the angle
        Quantity::Quaternion => return false,
        // a series of no sensor may well be nearly constant
        Quantity::Value => return false,
        Quantity::AngularRate | Quantity::Acceleration | Quantity::MagneticField | Quantity::Angle => 0.0,
    };
    let (histogram, count) = (&results.histogram, results.moments.count());
    count >= 100
        && count as f64 >= least_s * rate_hz
        && histogram.bin_width_counts() == 1
        && histogram.bins().take(3).count() <= 2
}

fn reaches_limit(channel: &Channel, results: &ChannelSnapshot) -> bool {
    // ranges in the unit of the channel, from quotations of the maker's data sheet; the last digits
    // below them are already doubtful
    let range = match channel.quantity {
        Quantity::MagneticField => 2.5,
        Quantity::Acceleration => 16.0 * 9.80665,
        Quantity::AngularRate => 2000.0_f64.to_radians(),
        Quantity::Angle | Quantity::Quaternion | Quantity::Temperature | Quantity::Pressure | Quantity::Value => {
            return false;
        }
    };
    let extremes = [results.moments.min_counts(), results.moments.max_counts()];
    extremes.into_iter().flatten().any(|counts| channel.value(counts).abs() >= 0.99 * range)
}
