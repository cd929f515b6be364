//! The state of a source under way: its link, its rate, its losses, and what is to come. Texts are
//! as on a terminal, see [`plain`](crate::numbers::plain).

use vn100_analysis::noise::Deviation;
use vn100_analysis::{LinkFacts, LinkStatus, Playback, RateFrom, Severity, SourceFacts, SourceResult};

use crate::{numbers::plain::time, printable::printable};

/// What a link is doing, or its baud rate if it is connected.
///
/// # Examples
/// ```
/// use vn100_analysis::{LinkFacts, LinkStatus};
/// let up = LinkFacts { status: LinkStatus::Connected, baud: Some(115_200), ..LinkFacts::default() };
/// assert_eq!(vn100_report::health::link_word(&up), "115200 baud");
/// ```
pub fn link_word(link: &LinkFacts) -> String {
    match (link.status, link.baud) {
        (LinkStatus::Opening, _) => "opening".into(),
        (LinkStatus::Scanning, Some(baud)) => format!("listening at {baud} baud"),
        (LinkStatus::Scanning, None) => "listening".into(),
        (LinkStatus::Connected, Some(baud)) => format!("{baud} baud"),
        (LinkStatus::Connected, None) => "connected".into(),
        (LinkStatus::Silent, _) => "SILENT".into(),
        (LinkStatus::Lost, _) => "DISCONNECTED".into(),
        (LinkStatus::NotConnected, _) => "not connected".into(),
        (LinkStatus::Closed, _) => "ending".into(),
    }
}

/// What a source does, in a word, and how grave that is: `None` if samples arrive.
pub fn state(facts: &SourceFacts, is_preparing: bool) -> (String, Option<Severity>) {
    match &facts.link {
        _ if is_preparing => ("preparing".into(), Some(Severity::Note)),
        _ if facts.end.is_some() && facts.error.is_some() => ("ENDED".into(), Some(Severity::Problem)),
        _ if facts.end.is_some() => ("ended".into(), Some(Severity::Note)),
        Some(link) => match link.status {
            LinkStatus::Connected => (link.baud.map_or("up".into(), |baud| format!("up {baud} baud")), None),
            LinkStatus::Opening | LinkStatus::Scanning | LinkStatus::NotConnected => {
                (link_word(link), Some(Severity::Caution))
            }
            LinkStatus::Silent | LinkStatus::Lost => (link_word(link), Some(Severity::Problem)),
            LinkStatus::Closed => (link_word(link), Some(Severity::Note)),
        },
        None => match facts.playback {
            // the requested duration
            Some(Playback { at_end: true, total: Some(total), samples, .. }) if samples < total => {
                ("duration reached".into(), Some(Severity::Note))
            }
            Some(Playback { at_end: true, .. }) => ("end of capture".into(), Some(Severity::Note)),
            Some(Playback { paused: true, .. }) => ("paused".into(), Some(Severity::Note)),
            _ => ("reading".into(), None),
        },
    }
}

/// A fault while a source is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FaultKind {
    /// The link is lost.
    Disconnected {
        /// Failed attempts to reconnect since the sensor was last connected.
        attempts: u32,
    },
    /// The port is open, and nothing arrives.
    Silent,
    /// The recording has stopped.
    RecordingFailed,
}

impl FaultKind {
    /// The name of the fault, in capitals.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Disconnected { .. } => "DISCONNECTED",
            Self::Silent => "SILENT",
            Self::RecordingFailed => "RECORDING FAILED",
        }
    }

    /// What the fault means, and what to do.
    pub const fn details(self) -> &'static str {
        match self {
            Self::Disconnected { .. } => {
                "The program connects again by itself, and the samples so far are kept. The samples of the meantime are lost, and no averaging time spans the gap. Check the cable and the power of the sensor."
            }
            Self::Silent => {
                "The port is open, but the sensor sends nothing. Check its power and its cable, and whether another program has switched its output off. The samples so far are kept."
            }
            Self::RecordingFailed => {
                "What is measured from here on is in the result, but not in the recording. The recording is readable up to this place. End the measurement, make room, and start a new recording."
            }
        }
    }

    /// The present faults, each with its cause.
    pub fn of(facts: &SourceFacts) -> Vec<(Self, String)> {
        let cause = |link: &LinkFacts| link.cause.clone().unwrap_or_default();
        let link = facts.link.as_ref().and_then(|link| match link.status {
            LinkStatus::Lost => Some((Self::Disconnected { attempts: link.attempts }, cause(link))),
            LinkStatus::Silent => {
                let port = printable(link.port.as_deref().unwrap_or_default());
                Some((Self::Silent, format!("{port} is open, but no data arrives")))
            }
            _ => None,
        });
        let error = facts.recorder.as_ref().and_then(|recorder| recorder.error.as_deref());
        let stopped = |error| format!("{}; the measurement continues", printable(error));
        let recording = error.map(|error| (Self::RecordingFailed, stopped(error)));
        link.into_iter().chain(recording).collect()
    }
}

/// The source of the nominal rate, in words that follow the rate.
pub const fn rate_from_word(from: RateFrom) -> &'static str {
    match from {
        RateFrom::Option => "as given",
        RateFrom::DeviceTime => "from device time",
        RateFrom::Device => "as reported",
        RateFrom::Arrival => "from arrivals",
        RateFrom::Assumed => "ASSUMED",
    }
}

/// The part of the baud rate in use, 0 to 1 and above, at ten bits per byte; `None` without a baud
/// rate or without a sentence.
pub fn line_load(result: &SourceResult) -> Option<f64> {
    let link = result.source.link.as_ref();
    let baud = link.filter(|link| matches!(link.status, LinkStatus::Connected | LinkStatus::Silent))?.baud?;
    let timing = &result.timing;
    let lines = timing.samples + timing.excluded + timing.missing_at_least;
    let bytes_per_line = result.link.framed_bytes as f64 / lines as f64;
    // a sensor that reconnected without its settings sends at its own rate
    let rate_hz = timing.rate_change.map(|change| change.to_hz).or(timing.rate_hz)?;
    (lines > 0).then(|| bytes_per_line * rate_hz * 10.0 / f64::from(baud))
}

/// The next octave that the record will show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NextOctave {
    /// Averaging time of the octave, in seconds.
    pub tau_s: f64,
    /// Data time until the record shows the octave, in seconds.
    pub wait_s: f64,
    /// Whether the record is long enough, but every window spans a gap.
    pub broken: bool,
}

impl NextOctave {
    /// The wait in words.
    pub fn when(&self) -> String {
        let wait = time(self.wait_s.ceil());
        if self.broken { format!("needs {wait} without a gap") } else { format!("in {wait}") }
    }
}

/// The next octave that the record will show; `None` before the first sample.
pub fn next_octave(result: &SourceResult) -> Option<NextOctave> {
    let timing = &result.timing;
    let interval_s = 1.0 / timing.rate_hz.filter(|_| timing.samples > 0)?;
    let longest = result.streamed().filter_map(|channel| channel.octaves().last()).map(|octave| octave.m).max();
    let m = longest.map_or(1, |m| 2 * m);
    let windows = match result.settings().deviation {
        Deviation::Allan => 2,
        Deviation::Hadamard => 3,
    };
    let needed = m * windows;
    let lacking = needed.saturating_sub(timing.samples + timing.missing_at_least);
    let broken = lacking == 0;
    let wait_s = if broken { needed } else { lacking } as f64 * interval_s;
    Some(NextOctave { tau_s: m as f64 * interval_s, wait_s, broken })
}
