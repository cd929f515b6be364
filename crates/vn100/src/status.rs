//! The status of live sources while they are measured: a line on stderr for each, or messages for
//! the view if there is one.

use std::time::Duration;

use indicatif::{HumanBytes, MultiProgress, ProgressBar, ProgressDrawTarget, ProgressFinish, ProgressStyle};
use vn100_analysis::{LinkCounts, Snapshot, TimeBase};
use vn100_capture::RecordingState;
use vn100_driver::{LinkState, Up};
use vn100_report::{
    health::link_word,
    names::{damaged_packets, missing_text, pending_text},
    numbers::plain::time,
    printable,
};
use vn100_session::link_facts;

use vn100_view::MessageQueue;

use crate::exit::{about, report};

/// The lines of all sources. If stderr is no terminal, only link events are written.
#[derive(Clone)]
pub(crate) struct StatusLines {
    lines: MultiProgress,
    /// Takes messages while a view has the terminal.
    view: Option<MessageQueue>,
    /// Failures alone are reported.
    is_quiet: bool,
}

impl StatusLines {
    pub(crate) const PERIOD: Duration = Duration::from_millis(500);

    /// Lines on stderr; none if a view takes the messages, or the log goes to the terminal.
    pub(crate) fn new(view: Option<MessageQueue>, logs_to_terminal: bool, is_quiet: bool) -> Self {
        let is_quiet = is_quiet && view.is_none();
        let target = if view.is_some() || logs_to_terminal || is_quiet {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr_with_hz(4)
        };
        Self { lines: MultiProgress::with_draw_target(target), view, is_quiet }
    }

    /// Says where a recording is that has ended, unless nothing but results is asked for; an empty one is
    /// removed.
    pub(crate) fn report_recorded(&self, name: &str, recording: Option<&RecordingState>) {
        if let Some(RecordingState { path, bytes: bytes @ 1.., error: None, .. }) = recording
            && !self.is_quiet
        {
            self.report(&format!("{name}: recorded {} to {}", HumanBytes(*bytes), path.display()));
        }
    }

    pub(crate) fn report(&self, text: &str) {
        if let Some(view) = &self.view { view.push(text.to_owned()) } else { self.suspend(|| report(text)) }
    }

    /// For a source by this name; `next` is what follows where its recording fails.
    pub(crate) fn line(&self, name: &str, next: &'static str) -> StatusLine {
        // the default style stands in for a template it does not understand
        let style = ProgressStyle::with_template("{spinner} {wide_msg}");
        let style = style.unwrap_or_else(|_| ProgressStyle::default_bar());
        let bar = ProgressBar::no_length().with_style(style).with_finish(ProgressFinish::AndClear);
        let bar = self.lines.add(bar);
        let (status, name) = (self.clone(), printable(name));
        StatusLine {
            bar,
            status,
            name,
            next,
            reported: None,
            failure_reported: false,
            low_space_reported: false,
            hint_reported: false,
        }
    }

    /// Clears the lines while `print` writes to the terminal.
    pub(crate) fn suspend<T>(&self, print: impl FnOnce() -> T) -> T {
        self.lines.suspend(print)
    }
}

pub(crate) struct StatusLine {
    bar: ProgressBar,
    status: StatusLines,
    name: String,
    next: &'static str,
    reported: Option<LinkState>,
    failure_reported: bool,
    low_space_reported: bool,
    /// How to shorten the latency of the adapter.
    hint_reported: bool,
}

impl StatusLine {
    /// Shows the state of the source and its recording, and reports what happened to them.
    pub(crate) fn show(&mut self, link: Option<&LinkState>, recording: Option<&RecordingState>, snapshot: &Snapshot) {
        if let Some(state) = link {
            self.report_link(state);
        }
        self.report_recording(recording, self.next);
        let state = link.map_or("reading".into(), |link| link_word(&link_facts(link)));
        let recorded = recording.map_or(String::new(), |recording| match recording.error {
            Some(_) => "RECORDING FAILED  ".into(),
            None => format!("recorded {}  ", HumanBytes(recording.bytes)),
        });
        self.bar.set_message(format!("{}  {state}  {recorded}{}", self.name, counts(snapshot)));
        self.bar.tick();
    }

    /// Takes the line from the terminal; what happened can be reported after that.
    pub(crate) fn clear(&self) {
        self.bar.finish_and_clear();
    }

    /// Reports once that the recording has failed and what is `next`, and once that its disk is nearly full.
    pub(crate) fn report_recording(&mut self, recording: Option<&RecordingState>, next: &str) {
        if let Some(RecordingState { path, error: Some(error), .. }) = recording
            && !self.failure_reported
        {
            self.failure_reported = true;
            let name = &self.name;
            self.status.report(&format!("{name}: RECORDING FAILED, {}: {error}; {next}", path.display()));
        }
        if let Some(RecordingState { path, low_space: Some(low), .. }) = recording
            && !self.low_space_reported
        {
            self.low_space_reported = true;
            let (free, lasts) = (HumanBytes(low.free_bytes), time(low.lasts.as_secs_f64()));
            let path = path.display();
            self.status.report(&format!(
                "{}: the disk of {path} has {free} left, enough for {lasts} at the present rate: make room",
                self.name
            ));
        }
    }

    /// Reports each link event once; of repeated failures the first, and those that need the user.
    pub(crate) fn report_link(&mut self, state: &LinkState) {
        if self.status.is_quiet {
            return;
        }
        if let Some(event) = event(self.reported.as_ref(), state).filter(|_| is_news(self.reported.as_ref(), state)) {
            self.status.report(&about(&self.name, &event));
            // only the user can shorten the latency of the adapter
            let hint = state.up().and_then(|up| up.latency_timer.as_ref()?.advice.as_deref());
            if let Some(hint) = hint.filter(|_| !self.hint_reported) {
                self.hint_reported = true;
                self.status.report(&about(&self.name, hint));
            }
            self.reported = Some(state.clone());
        }
    }
}

/// Whether a state is to be reported after the one reported last.
fn is_news(reported: Option<&LinkState>, state: &LinkState) -> bool {
    match (reported, state) {
        (Some(LinkState::Down { cause: reported, .. }), LinkState::Down { cause, needs_help, .. }) => {
            *needs_help && cause != reported
        }
        _ => reported != Some(state),
    }
}

/// What is worth a line of its own; single attempts are not.
fn event(reported: Option<&LinkState>, state: &LinkState) -> Option<String> {
    let reported_since = reported.and_then(LinkState::up).map(|up| up.since_ns);
    match state {
        LinkState::Up(Up { restarted: Some(error), since_ns, .. }) if reported_since != Some(*since_ns) => {
            Some(format!("the sensor restarted: {error}"))
        }
        LinkState::Up(Up { output_resumed: true, .. })
            if reported.and_then(LinkState::up).is_none_or(|up| !up.output_resumed) =>
        {
            Some("the sensor's output was paused; it is resumed for the measurement and paused again on exit".into())
        }
        LinkState::Up(up) if matches!(reported, Some(LinkState::Silent(silent)) if silent.since_ns == up.since_ns) => {
            Some("the sensor sends again".into())
        }
        LinkState::Up(Up { port, baud, .. }) => {
            let speed = baud.map_or(String::new(), |baud| format!(" at {baud} baud"));
            Some(format!("connected to {port}{speed}"))
        }
        LinkState::Silent(_) => Some("the sensor is silent".into()),
        LinkState::Down { was_up: true, cause, .. } => Some(format!("disconnected: {cause}; retrying")),
        LinkState::Down { was_up: false, cause, .. } => Some(format!("cannot connect: {cause}; retrying")),
        _ => None,
    }
}

fn counts(snapshot: &Snapshot) -> String {
    let (timing, link) = (TimeBase::of(snapshot), LinkCounts::of(snapshot));
    let (rejected, packets) = (link.rejected.total(), damaged_packets(&link));
    // neither a time nor a rate is known yet
    if timing.awaits_rate() {
        return format!("{} samples pending, measuring the rate, {rejected} rejected{packets}", timing.pending);
    }
    format!(
        "{} samples in {:.0} s at {}, {rejected} rejected{packets}, {} dropped{}",
        timing.samples,
        timing.duration_s,
        timing.rate_hz.map_or_else(|| "an unknown rate".into(), |hz| format!("{hz} Hz")),
        missing_text(&timing),
        pending_text(&timing)
    )
}

#[cfg(test)]
mod tests {
    use std::{io, sync::Arc};

    use vn100_analysis::{Analysis, Settings};
    use vn100_capture::LowSpace;
    use vn100_driver::LatencyTimer;
    use vn100_protocol::VNYMR;
    use vn100_protocol::stream::{Arrival, Batch};

    use super::*;

    fn down(cause: &str, needs_help: bool) -> LinkState {
        LinkState::Down {
            was_up: true,
            cause: cause.into(),
            needs_help,
            retry_in: Duration::from_millis(50),
            attempts: 0,
        }
    }

    fn connected() -> Up {
        Up {
            port: "/dev/imu".into(),
            baud: None,
            since_ns: 0,
            latency_timer: None,
            restarted: None,
            output_resumed: false,
        }
    }

    #[test]
    fn failed_attempts_that_need_help_are_reported_once_each() {
        let gone = down("the port is gone", false);
        let busy = down("it is in use by minicom", true);
        assert!(is_news(None, &gone));
        assert!(!is_news(Some(&gone), &down("there is no such port", false)));
        assert!(is_news(Some(&gone), &busy));
        let later = LinkState::Down {
            was_up: true,
            cause: "it is in use by minicom".into(),
            needs_help: true,
            retry_in: Duration::from_secs(5),
            attempts: 4,
        };
        assert!(!is_news(Some(&busy), &later));
    }

    #[test]
    fn pending_lines_are_shown_and_no_rate_before_it_is_known() {
        let reported = |lines: usize| {
            let arrivals = (0..lines).map(|line| Arrival { from_row: line, at_ns: 25_000_000 * line as i64 }).collect();
            let (counts, layout) = (vec![0; VNYMR.channels.len() * lines], Some(VNYMR.clone().into()));
            let mut analysis = Analysis::new(Settings::default());
            analysis.absorb(&Batch { counts, layout, arrivals, ..Batch::default() });
            super::counts(&analysis.snapshot())
        };
        assert_eq!(reported(7), "7 samples pending, measuring the rate, 0 rejected");
        assert_eq!(reported(80), "80 samples in 2 s at 40 Hz, 0 rejected, 0 dropped");
    }

    #[test]
    fn an_output_that_was_found_paused_is_reported_once() {
        let silent = connected();
        let resumed = Up { output_resumed: true, ..silent.clone() };
        let (silent_again, resumed) = (LinkState::Silent(resumed.clone()), LinkState::Up(resumed));
        let reported = event(Some(&LinkState::Silent(silent)), &resumed).unwrap();
        assert!(reported.contains("paused again on exit"), "{reported}");
        assert_eq!(event(Some(&silent_again), &resumed).unwrap(), "the sensor sends again");
    }

    #[test]
    fn a_disk_that_will_be_full_and_a_recording_that_failed_are_reported_once() {
        let messages = MessageQueue::default();
        let mut line =
            StatusLines::new(Some(messages.clone()), false, false).line("/dev/imu", "the measurement continues");
        let low_space = Some(LowSpace { free_bytes: 12_582_912, lasts: Duration::from_secs(2500) });
        let recording = RecordingState { path: "a.mcap".into(), bytes: 7, low_space, error: None, ended: false };
        let snapshot = Analysis::new(Settings::default()).snapshot();
        for _ in 0..3 {
            line.show(None, Some(&recording), &snapshot);
        }
        let expected =
            "/dev/imu: the disk of a.mcap has 12.00 MiB left, enough for 41 min 40 s at the present rate: make room";
        assert_eq!(messages.take(), [expected]);
        // it may fail after the last tick: what is next is that of the end
        let failed = RecordingState { error: Some(Arc::new(io::Error::other("the disk is full"))), ..recording };
        line.report_recording(Some(&failed), "the result has what was measured");
        line.show(None, Some(&failed), &snapshot);
        let expected = "/dev/imu: RECORDING FAILED, a.mcap: the disk is full; the result has what was measured";
        assert_eq!(messages.take(), [expected]);
    }

    #[test]
    fn the_latency_hint_is_reported_once() {
        let messages = MessageQueue::default();
        let mut line =
            StatusLines::new(Some(messages.clone()), false, false).line("/dev/imu", "the measurement continues");
        let timer = LatencyTimer { ms: 16, advice: Some("the adapter keeps bytes for up to 16 ms".into()) };
        let up = Up { latency_timer: Some(timer), ..connected() };
        let again = Up { since_ns: 1, ..up.clone() };
        line.report_link(&LinkState::Up(up));
        line.report_link(&down("the port is gone", false));
        line.report_link(&LinkState::Up(again));
        let reported = messages.take();
        assert_eq!(reported.iter().filter(|reported| reported.contains("up to 16 ms")).count(), 1, "{reported:?}");
    }

    #[test]
    fn a_restart_is_reported_and_not_as_a_connection() {
        let up = connected();
        let again = Up { since_ns: 1, restarted: Some(vn100_protocol::DeviceError::HardFault), ..up.clone() };
        let silent = LinkState::Silent(again.clone());
        let (up, again) = (LinkState::Up(up), LinkState::Up(again));
        assert!(is_news(Some(&up), &again));
        let reported = event(Some(&up), &again).unwrap();
        assert!(reported.starts_with("the sensor restarted: VNERR"), "{reported}");
        assert_eq!(event(Some(&silent), &again).unwrap(), "the sensor sends again");
        assert!(event(None, &up).unwrap().starts_with("connected"));
        assert!(event(Some(&down("the port is gone", false)), &up).unwrap().starts_with("connected"));
    }
}
