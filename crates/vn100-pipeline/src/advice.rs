//! The warnings a snapshot deserves, in words.

use imu_noise::{NominalRate, TimebaseSummary};
use vn100_protocol::{Channel, Quantity, Tally};

use crate::{
    snapshot::{ChannelSnapshot, RateChange, RateFrom, Snapshot},
    warning::{Warning, WarningKind},
};

/// What only the analysis knows, beyond the numbers of its snapshot.
#[derive(Debug, Default)]
pub(crate) struct Findings {
    pub(crate) repeated_lines: u64,
    pub(crate) print_changes: u64,
    /// Names of the angles whose count had to start anew.
    pub(crate) restarted: Vec<String>,
}

/// The warnings for `snapshot`, the gravest first.
pub(crate) fn warnings(snapshot: &Snapshot, findings: Findings) -> Vec<Warning> {
    let timing = &snapshot.timing;
    let tally = &snapshot.link.tally;
    let mut warnings = Vec::new();
    let mut warn = |kind, channels, text| warnings.push(Warning { kind, channels, text });

    if let Some(text) = no_samples(snapshot) {
        warn(WarningKind::NoValidLines, vec![], text);
    }
    if findings.repeated_lines > 0 {
        warn(
            WarningKind::RepeatedLines,
            vec![],
            format!(
                "{} of {} lines repeat an earlier one digit for digit: this is a recording played in a loop, not a living sensor, and its \
                 deviations say nothing about one",
                findings.repeated_lines, timing.samples
            ),
        );
    }
    if tally.bad.total() > tally.bad.unchecked {
        warn(
            WarningKind::BadLines,
            vec![],
            format!(
                "{} were damaged and are left out, each counted as one missing sample where good lines surround it; look at the cable, the \
                 connector and the baud rate",
                of_lines(tally.bad.total() - tally.bad.unchecked, tally)
            ),
        );
    }
    if tally.bad.unchecked > 0 {
        warn(
            WarningKind::UncheckedLines,
            vec![],
            format!(
                "{} carry no checksum and are left out; --accept-unchecked takes them, and then nothing but the form of a number protects it",
                of_lines(tally.bad.unchecked, tally)
            ),
        );
    }
    if tally.unchecked_lines > 0 {
        warn(
            WarningKind::UncheckedLines,
            vec![],
            format!(
                "{} carry no checksum and were taken all the same: a damaged digit in them cannot be told from a good one",
                of_lines(tally.unchecked_lines, tally)
            ),
        );
    }
    if let Some(RateChange { after_samples, from_hz, to_hz }) = snapshot.rate_change {
        warn(
            WarningKind::RateChanged,
            vec![],
            format!(
                "after {after_samples} samples the rate changed from {from_hz} to {to_hz} Hz: the {} samples behind are left out; \
                 --skip leaves the first part out instead",
                timing.left_out
            ),
        );
    }
    if let Some(arrivals) = &snapshot.arrivals {
        warn_of_arrivals(arrivals, &mut warn);
    }
    if timing.missing > 0 {
        warn(
            WarningKind::Gaps,
            vec![],
            format!(
                "{} samples are missing in {} places ({:.2} % of the record): only windows without a gap count, so that the longest taus rest \
                 on fewer of them",
                timing.missing,
                timing.gaps,
                100.0 * timing.missing as f64 / (timing.missing + timing.samples) as f64
            ),
        );
    }
    if findings.print_changes > 0 {
        warn(
            WarningKind::PrintFormat,
            vec![],
            format!(
                "the number of printed decimals changed {} times: the segments are kept apart, and values are given to the coarser resolution",
                findings.print_changes
            ),
        );
    }
    if !findings.restarted.is_empty() {
        warn(
            WarningKind::AngleRestarted,
            findings.restarted,
            "the angle turned several thousand times one way and its count started anew: mean, minimum and maximum mix the branches".into(),
        );
    }
    let stuck = channels_where(snapshot, |_, results| is_stuck(results));
    if !stuck.is_empty() {
        warn(
            WarningKind::StuckDigits,
            stuck,
            "the channel shows no more than two values: its noise lies below the last printed digit, or it is not alive; its deviations \
             are those of the rounding"
                .into(),
        );
    }
    let at_limit = channels_where(snapshot, reaches_limit);
    if !at_limit.is_empty() {
        warn(
            WarningKind::FullRange,
            at_limit,
            "the channel reaches the end of the sensor's range (2.5 gauss, 16 g, 2000 deg/s as quoted): beyond it values are cut, and \
             statistics of cut values are wrong"
                .into(),
        );
    }
    if snapshot.layout.is_some() && timing.samples < 2 {
        warn(
            WarningKind::TooShort,
            vec![],
            format!("{} sample is not enough for a deviation, which needs 2 at least", timing.samples),
        );
    }
    if timing.rate_from == RateFrom::Assumed && timing.samples > 0 {
        warn(
            WarningKind::RateAssumed,
            vec![],
            format!(
                "nothing in the recording tells its sample rate; {} Hz is the sensor's default. If it was set otherwise give --rate: every tau \
                 scales with it",
                timing.rate_hz
            ),
        );
    }
    if let Some(layout) = snapshot.layout.as_ref().filter(|layout| layout.compensated) {
        let channels = layout
            .channels
            .iter()
            .map(|channel| channel.name.to_string())
            .filter(|name| name.starts_with("gyro"))
            .collect();
        warn(
            WarningKind::CompensatedStream,
            channels,
            format!(
                "the angular rates of {} have the attitude filter's bias estimate removed: at long tau their deviation shows that filter, not \
                 the sensor. Bias instability and rate random walk of the sensor need the uncompensated message VNIMU",
                layout.message
            ),
        );
    }
    warnings
}

fn warn_of_arrivals(arrivals: &TimebaseSummary, warn: &mut impl FnMut(WarningKind, Vec<String>, String)) {
    // every other line: the pairs a USB latency timer makes
    const BUNCHED_SHARE: f64 = 0.2;
    if let Some(refusal) = arrivals.refusal {
        warn(
            WarningKind::StampsRefused,
            vec![],
            format!("{refusal}. They are not used, and lines lost whole cannot be seen"),
        );
    }
    if let Some(NominalRate::Measured(hz)) = arrivals.nominal {
        warn(
            WarningKind::RateOffNominal,
            vec![],
            format!(
                "lines arrive at {hz:.3} Hz, which is none of the sensor's rates: every tau is by this rate; give --rate if it is wrong"
            ),
        );
    }
    if let Some(arrivals) = arrivals.arrivals.filter(|arrivals| arrivals.share_together > BUNCHED_SHARE) {
        warn(
            WarningKind::BunchedArrival,
            vec![],
            format!(
                "{:.0} % of the lines arrive together with the one before, {:.1} at a time: the latency timer of a USB serial adapter, 16 ms \
                 unless set to 1, holds them back. It spoils no deviation, for arrival times never enter one, but gaps are seen later",
                100.0 * arrivals.share_together,
                arrivals.lines_together
            ),
        );
    }
}

/// Names of the channels for which `holds`.
fn channels_where(snapshot: &Snapshot, holds: impl Fn(&Channel, &ChannelSnapshot) -> bool) -> Vec<String> {
    let channels = snapshot.layout.as_ref().map_or(&[][..], |layout| &layout.channels);
    (channels.iter().zip(&snapshot.channels))
        .filter(|(channel, results)| holds(channel, results))
        .map(|(channel, _)| channel.name.to_string())
        .collect()
}

/// No more than two values in at least a hundred samples, counted in what the sensor printed.
fn is_stuck(results: &ChannelSnapshot) -> bool {
    results.moments.count() >= 100
        && results.histogram.bin_width_counts() == 1
        && results.histogram.bins().take(3).count() <= 2
}

fn reaches_limit(channel: &Channel, results: &ChannelSnapshot) -> bool {
    // ranges in the channel's unit, from quotations of the maker's sheet; the last digits before them are already doubtful
    let range = match channel.quantity {
        Quantity::MagneticField => 2.5,
        Quantity::Acceleration => 16.0 * 9.80665,
        Quantity::AngularRate => 2000.0_f64.to_radians(),
        Quantity::Angle | Quantity::Temperature | Quantity::Pressure => return false,
    };
    let extremes = [results.moments.min_counts(), results.moments.max_counts()];
    extremes.into_iter().flatten().any(|counts| channel.value(counts).abs() >= 0.99 * range)
}

/// What a stream that brings bytes and no samples is likely to suffer from.
fn no_samples(snapshot: &Snapshot) -> Option<String> {
    // within so many bytes a whole line must have been among them, wherever the first one began
    const ENOUGH_BYTES: u64 = 3 * 122;
    let (link, tally) = (&snapshot.link, &snapshot.link.tally);
    if link.samples() > 0 || tally.bytes() < ENOUGH_BYTES {
        return None;
    }
    if let Some(name) = link.other_message {
        return Some(format!(
            "{} good lines, none of a message this program measures; the first is {name}. `vn100 configure PORT --set-message VNYMR` or \
             `--set-message VNIMU` makes the sensor send one",
            tally.good_lines()
        ));
    }
    if tally.good_lines() > 0 || tally.bad.unchecked == tally.bad.total() && tally.bad.total() > 0 {
        return None;
    }
    Some(format!(
        "{} bytes and no valid line among them: wrong baud rate? If the rate is right, the host's receiver flips bits: close and reopen the \
         port",
        tally.bytes()
    ))
}

fn of_lines(count: u64, tally: &Tally) -> String {
    format!("{count} of {} lines", tally.good_lines() + tally.bad.total())
}
