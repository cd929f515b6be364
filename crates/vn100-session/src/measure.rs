//! The one loop that measures a source: events and commands in, the published state out.
//!
//! ```text
//! reading task --4 batches--> measure --state--> every face
//!             commands --8--/   \--4 states--> every second, if asked
//! ```
//!
//! Every channel is bounded; of batches of one line 256 may wait. The loop takes events as fast as
//! it can, or at the pace of a replay. It waits only for the receiver of the states of every
//! second, and only for a capture or a stream, which can wait. A face reads the latest state and
//! misses the states between two reads.

mod commands;
mod ending;

use std::{
    collections::VecDeque,
    future,
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
    time::Duration,
};

use tokio::{
    sync::{mpsc, watch},
    time::{self, Instant, MissedTickBehavior, sleep_until},
};
use vn100_analysis::protocol::stream::{Batch, FileReport, LinkEventKind, ReadOptions};
use vn100_analysis::{Analysis, DEFAULT_RATE_HZ, End, GoalCheck, Playback, Settings, Snapshot, Speed};
use vn100_capture::{Event, RecordingState};
use vn100_driver::{LinkHandle, LinkState};

pub(crate) use ending::Ending;

use crate::{
    channels::Channels,
    pace::{Due, Pace},
    recording::RecordedMessage,
    sample_tap::UntappedSamples,
    session_event::SessionEvent,
    state::Stage,
    wall_limits::{Deadlines, WallLimits},
    watchdog::StreamWatchdog,
};

/// Measures the events of a source until their end, or until the stop. If the settings end the
/// measurement at its recorded end, the few bytes after it are read as well, for the recorded reason.
pub(crate) async fn measure(
    mut source: Measuring,
    mut events: mpsc::Receiver<Event>,
    mut recording: Option<watch::Receiver<RecordingState>>,
    ends_as_recorded: bool,
    channels: &mut Channels,
) -> Ending {
    let mut ticks = time::interval(source.analysis.settings().watch_every.max(Duration::from_millis(1)));
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut looks = time::interval(StreamWatchdog::PERIOD);
    let stop = channels.stop.clone();
    let mut link = source.link.as_ref().map(LinkHandle::state);
    let stop_ends_it = source.pace.is_some() || (source.watchdog.is_none() && source.stored_bytes_read.is_none());
    channels.state.send_modify(|state| {
        state.stage = Stage::Measuring;
        state.link = latest(&mut link);
        state.recording = latest(&mut recording);
    });
    source.publish(channels);
    let mut pending = VecDeque::new();
    loop {
        tokio::select! {
            // a command that was received in time counts
            biased;
            Some(command) = channels.commands.recv() => source.handle(command, channels),
            () = stop.cancelled(), if stop_ends_it => {
                source.end.get_or_insert(End::Stopped);
                return source.finish(channels).await;
            }
            () = changed(&mut link) => {
                let now = latest(&mut link);
                if now.as_ref().and_then(LinkState::up).is_some() {
                    source.deadlines.note_connected(Instant::now());
                }
                channels.state.send_modify(|state| state.link = now);
            }
            () = changed(&mut recording) => channels.state.send_modify(|state| state.recording = latest(&mut recording)),
            _ = ticks.tick(), if source.has_changed && source.is_watched(channels) => source.publish(channels),
            _ = looks.tick(), if source.watchdog.is_some() => source.watch(channels),
            () = passed(source.deadlines.wall_at()), if !stop.is_cancelled() => source.end_by_wall_time(channels),
            event = next_due(&mut events, &mut pending, source.pace.as_ref()), if source.end.is_none() => {
                source.take(event, channels).await;
                if source.end.is_some() {
                    // the remaining events are read only if the end of the recording is needed
                    while ends_as_recorded && events.recv().await.is_some() {}
                    events.close();
                    if source.pace.is_none() {
                        return source.finish(channels).await;
                    }
                    source.stand_at_end(channels);
                }
            }
            // after the events: a sample that waits to be measured has arrived in time
            () = passed(source.deadlines.give_up_at()), if !stop.is_cancelled() => source.give_up(channels),
        }
    }
}

/// Waits until that time; forever if it is `None`.
async fn passed(time: Option<Instant>) {
    if let Some(time) = time { sleep_until(time).await } else { future::pending().await }
}

/// The next event or command. Dropping the future loses nothing, because received items wait in
/// `pending`.
async fn next_due(
    events: &mut mpsc::Receiver<Event>,
    pending: &mut VecDeque<Event>,
    pace: Option<&Pace>,
) -> Option<Event> {
    let Some(pace) = pace else { return events.recv().await };
    if pending.is_empty() {
        match events.recv().await? {
            Event::Batch(batch) => {
                let mut lines = batch.lines();
                while let Some(line) = lines.next_line() {
                    pending.push_back(line.clone().into());
                }
            }
            event => pending.push_back(event),
        }
    }
    if let Some(Event::Batch(batch)) = pending.front()
        && batch.row_count() > 0
    {
        match pace.due() {
            Due::Now => {}
            Due::At(time) => sleep_until(time).await,
            Due::Never => future::pending().await,
        }
    }
    pending.pop_front()
}

/// Waits until a watched value changes; forever if it is `None` or cannot change any more.
async fn changed<T>(watched: &mut Option<watch::Receiver<T>>) {
    if let Some(watched) = watched
        && watched.changed().await.is_ok()
    {
        return;
    }
    future::pending().await
}

fn latest<T: Clone>(watched: &mut Option<watch::Receiver<T>>) -> Option<T> {
    watched.as_mut().map(|watched| watched.borrow_and_update().clone())
}

/// A source that is measured.
pub(crate) struct Measuring {
    analysis: Analysis,
    goals: GoalCheck,
    /// Data time up to the last restart of the measurement.
    before: Duration,
    /// Data time after that, excluded as warm-up.
    warm_up: Duration,
    /// Of a capture replayed at a pace. The measurement lasts until the stop, so that the user can
    /// read its end.
    pace: Option<Pace>,
    /// Of a live source. A stop ends the reading, and the measurement ends with the last event that
    /// was read.
    watchdog: Option<StreamWatchdog>,
    /// Until the sensor has sent a message.
    recorded: Option<RecordedMessage>,
    deadlines: Deadlines,
    link: Option<LinkHandle>,
    /// Of a capture, read as fast as possible. A stop ends it in the same way as a live source.
    stored_bytes_read: Option<Arc<AtomicU64>>,
    /// Number of seconds of data time whose states were sent.
    seconds: u64,
    has_changed: bool,
    /// Samples that the writer of samples has not got.
    untapped: UntappedSamples,
    /// The reason why the stream is given up although the sensor still sends; `None` while it continues.
    stream_ended: Option<End>,
    end: Option<End>,
    /// What the file tells of its content up to the last row.
    report: Option<Arc<FileReport>>,
}

impl Measuring {
    pub(crate) fn new(settings: Settings) -> Self {
        Self {
            analysis: Analysis::new(settings),
            goals: GoalCheck::default(),
            before: Duration::ZERO,
            warm_up: Duration::ZERO,
            pace: None,
            watchdog: None,
            recorded: None,
            deadlines: Deadlines::new(WallLimits::default(), Instant::now()),
            link: None,
            stored_bytes_read: None,
            seconds: 0,
            has_changed: false,
            untapped: UntappedSamples::default(),
            stream_ended: None,
            end: None,
            report: None,
        }
    }

    /// A live source with these limits; `recorded` is the message of a recording that is resumed.
    pub(crate) fn live(
        settings: Settings,
        link: Option<LinkHandle>,
        recorded: Option<RecordedMessage>,
        deadlines: Deadlines,
    ) -> Self {
        Self { link, recorded, deadlines, watchdog: Some(StreamWatchdog::default()), ..Self::new(settings) }
    }

    /// A capture, at this pace if there is one.
    pub(crate) fn capture(settings: Settings, speed: Option<Speed>, stored_bytes_read: Arc<AtomicU64>) -> Self {
        let rate_hz = settings.rate_hz.unwrap_or(DEFAULT_RATE_HZ);
        Self {
            pace: speed.map(|speed| Pace::new(speed, rate_hz, Instant::now())),
            stored_bytes_read: speed.is_none().then_some(stored_bytes_read),
            ..Self::new(settings)
        }
    }

    /// Takes an event; `None` when the reading task has ended.
    async fn take(&mut self, event: Option<Event>, channels: &Channels) {
        let Some(event) = event else {
            // the samples received until now are valid
            self.end = Some(End::SourceFailed("the task that reads the source stopped".into()));
            return;
        };
        // those of a batch follow row by row
        if !matches!(event, Event::Batch(_)) {
            channels.observe(&event);
        }
        match event {
            Event::Batch(batch) => {
                let mut lines = batch.lines();
                while let (Some(line), None) = (lines.next_line(), &self.end) {
                    if channels.observer.is_some() {
                        channels.observe(&line.clone().into());
                    }
                    let repeated = self.analysis.repeated_rows();
                    self.absorb(line, channels).await;
                    if channels.samples.is_some() {
                        self.untapped.push(line, self.analysis.repeated_rows().saturating_sub(repeated));
                        self.tap(channels).await;
                    }
                    self.look(channels).await;
                }
            }
            // when the link is lost, the gap before the pending rows is decided
            Event::Link(event) => {
                self.analysis.take_link_event(&event);
                if let (true, LinkEventKind::PortShared { program }) = (self.watchdog.is_some(), event.kind) {
                    channels.report(SessionEvent::PortShared { program });
                }
                self.look(channels).await;
            }
            Event::End(end) => {
                let reason = match end.error {
                    Some(error) => End::SourceFailed(error.to_string()),
                    None if channels.stop.is_cancelled() => End::Stopped,
                    None => End::SourceEnded,
                };
                self.end = Some(reason);
                self.report = end.report.map(Arc::new);
            }
        }
    }

    /// Sends the samples that precede the end, as far as that is known, to the writer of samples, if there
    /// is one.
    async fn tap(&mut self, channels: &Channels) {
        let Some(samples) = &channels.samples else { return };
        let may_end = self.analysis.settings().ends_between_reads();
        let after_end = if may_end { self.analysis.rows_after_end() } else { 0 };
        while let Some(batch) = self.untapped.next_before(after_end) {
            samples.send(batch, self.link.is_none(), &channels.stop).await;
        }
    }

    async fn absorb(&mut self, batch: &Batch, channels: &Channels) {
        if channels.seconds.is_some() {
            let mut has_more = self.analysis.absorb_to_second(batch);
            while has_more {
                self.send_second(channels).await;
                has_more = self.analysis.continue_to_second();
            }
        } else {
            self.analysis.absorb(batch);
        }
        self.report.clone_from(&batch.report);
        if self.watchdog.is_some() && batch.row_count() > 0 {
            self.deadlines.note_sample(Instant::now());
        }
        if let Some(pace) = &mut self.pace {
            pace.playback.samples += batch.row_count() as u64;
        }
    }

    async fn look(&mut self, channels: &Channels) {
        self.has_changed = true;
        if let Some(end) = self.goals.end(&mut self.analysis) {
            self.end = Some(end);
        } else {
            self.send_second(channels).await;
        }
    }

    /// Sends the state if a second has passed and the measurement continues. After a stop, whose result follows,
    /// no second is sent: the receiver is not waited for, and seconds between others would be missing.
    async fn send_second(&mut self, channels: &Channels) {
        let Some(seconds) = channels.seconds.as_ref().filter(|_| self.analysis.seconds() > self.seconds) else {
            return;
        };
        if self.analysis.is_complete() || channels.stop.is_cancelled() {
            return;
        }
        self.seconds = self.analysis.seconds();
        self.publish(channels);
        let state = channels.state.borrow().clone();
        // without a receiver of the states the measurement continues
        if self.link.is_some() {
            let _ = seconds.try_send(state);
        } else {
            tokio::select! {
                _ = seconds.send(state) => {}
                () = channels.stop.cancelled() => {}
            }
        }
    }

    /// Whether a face sees the snapshots, or the pace of the replay depends on their rate.
    fn is_watched(&self, channels: &Channels) -> bool {
        self.pace.is_some() || channels.state.receiver_count() > 0
    }

    fn publish(&mut self, channels: &Channels) {
        self.has_changed = false;
        self.analysis.settle();
        let mut snapshot = self.analysis.snapshot();
        if self.end.is_some() {
            let facts = channels.state.borrow().facts_at(true);
            snapshot.warnings.extend(facts.recording.and_then(|recording| recording.end?.warning()));
        }
        if let Some(pace) = &mut self.pace {
            pace.set_rate(snapshot.timing.rate_hz, Instant::now());
        }
        self.show(Arc::new(snapshot), channels);
    }

    fn show(&self, snapshot: Arc<Snapshot>, channels: &Channels) {
        channels.state.send_modify(|state| {
            state.snapshot = snapshot;
            state.unrecorded_bytes = self.link.as_ref().map_or(0, LinkHandle::unrecorded_bytes);
            state.stored_bytes_read = self.stored_bytes_read.as_ref().map_or(0, |read| read.load(Ordering::Relaxed));
        });
        self.show_playback(channels);
    }

    fn show_playback(&self, channels: &Channels) {
        if let Some(pace) = &self.pace {
            channels.state.send_modify(|state| {
                let total = state.playback.and_then(|playback| playback.total);
                state.playback = Some(Playback { total, ..pace.playback });
            });
        }
    }
}

pub(crate) fn read_options(read: ReadOptions, settings: &Settings) -> ReadOptions {
    ReadOptions { line_by_line: read.line_by_line || settings.ends_between_reads(), ..read }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_result_that_ends_between_two_reads_is_read_line_by_line() {
        let whole = ReadOptions::default();
        let line_by_line = ReadOptions { line_by_line: true, ..whole };
        let timed = Settings { duration: Some(Duration::from_secs(1)), ..Settings::default() };
        let sought = Settings { until: vec!["gyro N ±5%".parse().unwrap()], ..Settings::default() };
        assert!(!read_options(whole, &Settings::default()).line_by_line);
        assert!(read_options(whole, &timed).line_by_line && read_options(whole, &sought).line_by_line);
        assert!(read_options(line_by_line, &Settings::default()).line_by_line);
    }
}
