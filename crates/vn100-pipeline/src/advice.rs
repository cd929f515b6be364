//! The warnings a snapshot deserves, in words.

use vn100_protocol::Tally;

use crate::{
    snapshot::{RateFrom, Snapshot},
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
