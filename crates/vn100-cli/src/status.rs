//! What is told of live sources while they are measured: a line on stderr for each, or words for
//! the view where there is one.

use std::{borrow::Cow, time::Duration};

use indicatif::{HumanBytes, MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};
use vn100_analysis::Snapshot;
use vn100_capture::RecordingState;
use vn100_driver::{LinkState, Up};
use vn100_report::printable;

use crate::{
    exit::{about, report},
    view::MessageQueue,
};

/// The lines of all sources. Where stderr is no terminal, only what befalls a link is written.
pub(crate) struct Status {
    lines: MultiProgress,
    /// Where words go while a view has the terminal.
    view: Option<MessageQueue>,
}

impl Status {
    /// How often a line is worth writing anew.
    pub(crate) const PERIOD: Duration = Duration::from_millis(500);

    /// Lines on stderr, or none where a view takes what is to be told, or something `else_is_told`
    /// there all the time.
    pub(crate) fn new(view: Option<MessageQueue>, else_is_told: bool) -> Self {
        let target = if view.is_some() || else_is_told {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr_with_hz(4)
        };
        Self { lines: MultiProgress::with_draw_target(target), view }
    }

    /// Tells something for good.
    pub(crate) fn report(&self, text: &str) {
        match &self.view {
            Some(view) => view.push(text.to_owned()),
            None => self.suspend(|| report(text)),
        }
    }

    /// A line for the source of that name.
    pub(crate) fn line(&self, name: &str) -> StatusLine {
        let bar = self.lines.add(ProgressBar::no_length());
        // the default style stands in for a template it does not understand
        if let Ok(style) = ProgressStyle::with_template("{spinner} {wide_msg}") {
            bar.set_style(style);
        }
        StatusLine {
            bar,
            view: self.view.clone(),
            name: printable(name),
            told: None,
            failure_told: false,
            hint_told: false,
        }
    }

    /// Takes the lines away while `print` writes to the terminal.
    pub(crate) fn suspend<T>(&self, print: impl FnOnce() -> T) -> T {
        self.lines.suspend(print)
    }
}

/// The line of one source.
pub(crate) struct StatusLine {
    bar: ProgressBar,
    view: Option<MessageQueue>,
    name: String,
    /// What of the link was last told for good.
    told: Option<LinkState>,
    failure_told: bool,
    /// How to shorten the latency of the adapter.
    hint_told: bool,
}

impl StatusLine {
    /// Shows where the source and its recording are, and tells what befell them.
    pub(crate) fn show(&mut self, link: Option<&LinkState>, recording: Option<&RecordingState>, snapshot: &Snapshot) {
        if let Some(state) = link {
            self.tell(state);
        }
        if let Some(RecordingState { path, error: Some(error), .. }) = recording
            && !self.failure_told
        {
            self.failure_told = true;
            let failure =
                format!("{}: RECORDING FAILED, {}: {error}; the measurement goes on", self.name, path.display());
            self.report(&failure);
        }
        let state = link.map_or("reading".into(), short_state);
        let recorded = recording.map_or(String::new(), |recording| match recording.error {
            Some(_) => "RECORDING FAILED  ".into(),
            None => format!("recorded {}  ", HumanBytes(recording.bytes)),
        });
        self.bar.set_message(format!("{}  {state}  {recorded}{}", self.name, counts(snapshot)));
        self.bar.tick();
    }

    /// Tells what befell the link, once: a link that is looked for fails again and again, and its
    /// first cause is the one that says why, unless a later one is for its user to mend.
    pub(crate) fn tell(&mut self, state: &LinkState) {
        if let Some(event) = event(self.told.as_ref(), state).filter(|_| is_news(self.told.as_ref(), state)) {
            self.report(&about(&self.name, &event));
            if let Some(hint) = latency_hint(state).filter(|_| !self.hint_told) {
                self.hint_told = true;
                self.report(&about(&self.name, hint));
            }
            self.told = Some(state.clone());
        }
    }

    fn report(&self, text: &str) {
        match &self.view {
            Some(view) => view.push(text.to_owned()),
            None => self.bar.suspend(|| report(text)),
        }
    }
}

impl Drop for StatusLine {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// Whether a state is to be told behind the one told last.
fn is_news(told: Option<&LinkState>, state: &LinkState) -> bool {
    match (told, state) {
        (Some(LinkState::Down { cause: told, .. }), LinkState::Down { cause, needs_help, .. }) => {
            *needs_help && cause != told
        }
        _ => told != Some(state),
    }
}

/// What is worth a line of its own; the coming and going of single attempts is not.
fn event(told: Option<&LinkState>, state: &LinkState) -> Option<String> {
    let told_since = told.and_then(up).map(|up| up.since_ns);
    match state {
        LinkState::Up(Up { restarted: Some(error), since_ns, .. }) if told_since != Some(*since_ns) => {
            Some(format!("the sensor restarted: {error}"))
        }
        LinkState::Up(Up { output_resumed: true, .. }) if told.and_then(up).is_none_or(|up| !up.output_resumed) => Some(
            "the output of the sensor was paused, as by a program that broke off: it was made to go on, and is paused again at the end".into(),
        ),
        LinkState::Up(up) if matches!(told, Some(LinkState::Silent(silent)) if silent.since_ns == up.since_ns) => {
            Some("the sensor sends again".into())
        }
        LinkState::Up(Up { port, baud, .. }) => {
            let speed = baud.map_or(String::new(), |baud| format!(" at {baud} baud"));
            Some(format!("connected to {port}{speed}"))
        }
        LinkState::Silent(_) => Some("the sensor is silent".into()),
        LinkState::Down { was_up: true, cause, .. } => Some(format!("lost: {cause}; trying again")),
        LinkState::Down { was_up: false, cause, .. } => Some(format!("not there yet: {cause}; trying again")),
        _ => None,
    }
}

/// How to shorten the latency of the adapter, where somebody must.
fn latency_hint(state: &LinkState) -> Option<&str> {
    up(state)?.latency_timer.as_ref()?.advice.as_deref()
}

fn up(state: &LinkState) -> Option<&Up> {
    match state {
        LinkState::Up(up) | LinkState::Silent(up) => Some(up),
        _ => None,
    }
}

fn short_state(state: &LinkState) -> Cow<'static, str> {
    match state {
        LinkState::Opening => "opening".into(),
        LinkState::Probing { baud: Some(baud), .. } => format!("listening at {baud} baud").into(),
        LinkState::Probing { baud: None, .. } => "listening".into(),
        LinkState::Up(Up { baud: Some(baud), .. }) => format!("{baud} baud").into(),
        LinkState::Up(_) => "connected".into(),
        LinkState::Silent(_) => "SILENT".into(),
        LinkState::Down { was_up: true, .. } => "LOST".into(),
        LinkState::Down { was_up: false, .. } => "not there yet".into(),
        _ => "ending".into(),
    }
}

fn counts(snapshot: &Snapshot) -> String {
    let timing = &snapshot.timing;
    let bad = snapshot.link.tally.rejected.total();
    let held = snapshot.lines_held().map(|lines| format!("{lines} lines held, finding their rate"));
    match held {
        // neither a time nor a rate is known yet
        Some(held) if timing.samples == 0 => format!("{held}, {bad} bad lines"),
        held => format!(
            "{} samples in {:.0} s at {} Hz, {bad} bad lines, {} missing{}",
            timing.samples,
            timing.duration_s(),
            timing.rate_hz,
            timing.missing,
            held.map_or(String::new(), |held| format!(", {held}"))
        ),
    }
}

#[cfg(test)]
mod tests {
    use vn100_analysis::{Analysis, Settings};
    use vn100_driver::LatencyTimer;
    use vn100_protocol::VNYMR;
    use vn100_protocol::stream::{Arrival, Batch};

    use super::*;

    fn down(cause: &str, needs_help: bool) -> LinkState {
        LinkState::Down { was_up: true, cause: cause.into(), needs_help, retry_in: Duration::from_millis(50) }
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
    fn of_failed_attempts_only_those_that_need_help_are_told_once_each() {
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
        };
        assert!(!is_news(Some(&busy), &later));
    }

    #[test]
    fn lines_that_are_held_are_told_and_no_rate_that_is_not_known() {
        let told = |lines: usize| {
            let arrivals = (0..lines).map(|line| Arrival { from_row: line, at_ns: 25_000_000 * line as i64 }).collect();
            let (counts, layout) = (vec![0; VNYMR.channels.len() * lines], Some(VNYMR.clone().into()));
            let mut analysis = Analysis::new(Settings::default());
            analysis.absorb(&Batch { counts, layout, arrivals, ..Batch::default() });
            super::counts(&analysis.snapshot())
        };
        assert_eq!(told(7), "7 lines held, finding their rate, 0 bad lines");
        assert_eq!(told(80), "80 samples in 2 s at 40 Hz, 0 bad lines, 0 missing");
    }

    #[test]
    fn an_output_that_was_found_paused_is_told_once() {
        let silent = connected();
        let resumed = Up { output_resumed: true, ..silent.clone() };
        let (silent_again, resumed) = (LinkState::Silent(resumed.clone()), LinkState::Up(resumed));
        let told = event(Some(&LinkState::Silent(silent)), &resumed).unwrap();
        assert!(told.contains("paused again at the end"), "{told}");
        assert_eq!(event(Some(&silent_again), &resumed).unwrap(), "the sensor sends again");
    }

    #[test]
    fn how_to_shorten_the_latency_is_told_once_where_the_program_may_not() {
        let messages = MessageQueue::default();
        let mut line = Status::new(Some(messages.clone()), false).line("/dev/imu");
        let timer = LatencyTimer { ms: 16, advice: Some("the adapter keeps bytes for up to 16 ms".into()) };
        let up = Up { latency_timer: Some(timer), ..connected() };
        let again = Up { since_ns: 1, ..up.clone() };
        line.tell(&LinkState::Up(up));
        line.tell(&down("the port is gone", false));
        line.tell(&LinkState::Up(again));
        let told = messages.take();
        assert_eq!(told.iter().filter(|told| told.contains("up to 16 ms")).count(), 1, "{told:?}");
    }

    #[test]
    fn a_restart_is_told_and_not_as_a_connection() {
        let up = connected();
        let again = Up { since_ns: 1, restarted: Some(vn100_protocol::DeviceError::HardFault), ..up.clone() };
        let silent = LinkState::Silent(again.clone());
        let (up, again) = (LinkState::Up(up), LinkState::Up(again));
        assert!(is_news(Some(&up), &again));
        let told = event(Some(&up), &again).unwrap();
        assert!(told.starts_with("the sensor restarted: VNERR"), "{told}");
        assert_eq!(event(Some(&silent), &again).unwrap(), "the sensor sends again");
        assert!(event(None, &up).unwrap().starts_with("connected"));
        assert!(event(Some(&down("the port is gone", false)), &up).unwrap().starts_with("connected"));
    }
}
