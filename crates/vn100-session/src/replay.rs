//! The session of a capture, as fast as the machine can, or at a pace.

use std::{
    io,
    path::{Path, PathBuf},
    sync::Arc,
    time::Duration,
};

use tokio::{sync::watch, task};
use tokio_util::sync::CancellationToken;
use vn100_analysis::protocol::{Layout, stream::ReadOptions};
use vn100_analysis::{End, Goal, Playback, RateFrom, Settings, SourceFacts, Speed, recorded_settings};
use vn100_capture::{Capture, CaptureOptions, Event, OpenError, recording_path};

use crate::{
    channels::{Channels, EventObserver},
    measure::{Ending, Measuring, measure, read_options},
    sample_tap::SampleTap,
    session_result::{SessionResult, not_started, result},
    start_error::StartError,
    state::SourceState,
};

/// A capture, and the options of its measurement.
#[derive(Clone, Default)]
pub struct ReplaySpec {
    /// The file; `-` is standard input.
    pub path: PathBuf,
    /// The user's options for the content of the file.
    pub capture: CaptureOptions,
    /// Whether the topic is one of several streams of the file, each with a session of its own.
    pub is_one_of_several: bool,
    /// The messages of the others of these.
    pub other_streams: Vec<Arc<Layout>>,
    /// The settings of the measurement. If they name no end, that of the recorded measurement is
    /// used.
    pub settings: Settings,
    /// The options for reading the bytes.
    pub read: ReadOptions,
    /// The pace of the replay; `None` for a measurement as fast as the machine can.
    pub speed: Option<Speed>,
    /// Whether the state at every second of data time is sent to
    /// [`Session::seconds`](crate::Session::seconds).
    pub each_second: bool,
    /// Receives the samples as well; `None` for no such receiver.
    pub samples: Option<SampleTap>,
    /// Called with every event; `None` for no observer.
    pub observer: Option<EventObserver>,
    /// Ends the session.
    pub stop: CancellationToken,
}

impl ReplaySpec {
    /// The whole file, as fast as the machine can, with all options at their defaults.
    pub fn of(path: impl Into<PathBuf>) -> Self {
        Self { path: path.into(), ..Self::default() }
    }

    /// One for each stream of the file. A goal for a channel that only some streams have is one of theirs.
    pub fn streams(self) -> Vec<Self> {
        let topics = Capture::streams(&self.path, &self.capture);
        if topics.len() < 2 {
            return vec![self];
        }
        let of = |topic| {
            let capture = CaptureOptions { topic, ..self.capture.clone() };
            Self { capture, is_one_of_several: true, ..self.clone() }
        };
        let mut streams: Vec<Self> = topics.into_iter().map(of).collect();
        let layouts: Vec<Option<Arc<Layout>>> = streams.iter().map(Self::layout).collect();
        for (place, stream) in streams.iter_mut().enumerate() {
            let others = layouts.iter().enumerate().filter(|(other, _)| *other != place);
            stream.other_streams = others.filter_map(|(_, layout)| layout.clone()).collect();
            let others = &stream.other_streams;
            let is_elsewhere = |goal: &Goal| goal.figure.is_only_in(others, layouts[place].as_deref());
            stream.settings.until.retain(|goal| !is_elsewhere(goal));
        }
        streams
    }

    /// The message of the stream by its first samples.
    fn layout(&self) -> Option<Arc<Layout>> {
        let mut events = Capture::open(&self.path, &self.capture).ok()?.events(self.read).ok()?;
        events.find_map(|event| if let Event::Batch(batch) = event { batch.layout } else { None })
    }

    /// The name of the source in results: the file's name without its folder, because a result does
    /// not depend on the folder of its capture; for the parts of a recording, the name of the
    /// recording. The topic follows if it is one of several streams.
    pub fn name(&self) -> String {
        let path = if self.capture.later_parts.is_empty() { self.path.clone() } else { recording_path(&self.path) };
        self.with_topic(&path.file_name().unwrap_or(path.as_os_str()).to_string_lossy())
    }

    /// The name of the source in an archive: the path as given, and the topic if it is one of
    /// several streams. Bytes of a path that are not text are escaped.
    pub fn name_with_folder(&self) -> String {
        self.with_topic(&self.path.to_str().map_or_else(|| format!("{:?}", self.path), str::to_owned))
    }

    fn with_topic(&self, name: &str) -> String {
        match self.capture.topic.as_deref().filter(|_| self.is_one_of_several) {
            Some(topic) => format!("{name} {topic}"),
            None => name.to_owned(),
        }
    }

    /// A number, in hexadecimal digits, of this program's version, the options of the measurement,
    /// and `judged_by`, the basis of the verdicts: rows of an archive with another number are not
    /// comparable.
    pub fn options_digest(&self, judged_by: &str) -> String {
        let Self { settings, read, capture, .. } = self;
        let version = env!("CARGO_PKG_VERSION");
        let text = format!("{version} {settings:?} {read:?} {:?} {:?} {judged_by}", capture.columns, capture.topic);
        // FNV-1a
        let number = text
            .bytes()
            .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3));
        format!("{number:016x}")
    }

    async fn open(&self) -> Result<Capture, OpenError> {
        let (path, options) = (self.path.clone(), self.capture.clone());
        let failed = |error| OpenError::Io { path: self.path.clone(), source: io::Error::other(error) };
        let open = move || match path == Path::new("-") {
            true => Capture::from_reader(io::stdin(), &options),
            false => Capture::open(path, &options),
        };
        task::spawn_blocking(open).await.map_err(failed)?
    }
}

fn kind(capture: &Capture, name: &str) -> &'static str {
    if name == "-" { "stdin" } else { capture.format.code() }
}

pub(crate) async fn run_replay(spec: ReplaySpec, mut channels: Channels) -> SessionResult {
    let opened = tokio::select! {
        // checked first: after a stop no further file is opened
        biased;
        () = channels.stop.cancelled() => Err(StartError::Stopped),
        opened = spec.open() => opened.map_err(StartError::from).and_then(|capture| {
            let is_unknown = capture.lacks_times() && spec.settings.rate_hz.is_none();
            if is_unknown { Err(StartError::RateUnknown { refusal: None }) } else { Ok(capture) }
        }),
    };
    let capture = match opened {
        Ok(capture) => capture,
        Err(error) => {
            let result = channels.end(not_started(error, &channels));
            if spec.speed.is_some() {
                // the token lives as long as the parallel replays
                channels.stop.cancelled().await;
            }
            return result;
        }
    };
    let holds_values = capture.holds_values;
    let before = channels.state.borrow().clone();
    let settings = publish_source(&capture, &spec, &channels);
    if let Some(speed) = spec.speed {
        channels.state.send_modify(|state| state.playback = Some(Playback::begin(speed)));
        task::spawn(count_samples(spec.clone(), channels.state.clone(), channels.stop.clone()));
    }
    let goals = settings.until.clone();
    let ending = measure_capture(capture, settings, &spec, &mut channels).await;
    let timing = &ending.snapshot.timing;
    // the rate had to be assumed, and a result depends on it
    if holds_values && timing.rate_from == RateFrom::Assumed && timing.samples > 1 {
        let refusal = ending.snapshot.arrivals.and_then(|arrivals| arrivals.refusal);
        channels.state.send_modify(|state| {
            *state = SourceState { stored_bytes_read: state.stored_bytes_read, ..before };
        });
        return channels.end(not_started(StartError::RateUnknown { refusal }, &channels));
    }
    channels.end(result(ending, &goals, &channels))
}

/// Publishes the metadata of an opened capture. Returns the settings with the end that the metadata
/// names.
fn publish_source(capture: &Capture, spec: &ReplaySpec, channels: &Channels) -> Settings {
    let source = SourceFacts {
        kind: Some(kind(capture, &spec.name())),
        meta: capture.recorded.as_ref().and_then(|recorded| recorded_settings::conditions(&recorded.metadata)),
        name: spec.name(),
        csv: capture.csv.clone(),
        stream: capture.topic.clone(),
        other_streams: spec.other_streams.clone(),
        ..SourceFacts::default()
    };
    channels.state.send_modify(|state| {
        state.source = source.into();
        state.recorded.clone_from(&capture.recorded);
    });
    let settings = spec.settings.clone();
    match &capture.recorded {
        Some(recorded) if recorded.is_one_measurement() => recorded_settings::with_end(settings, &recorded.metadata),
        _ => settings,
    }
}

async fn measure_capture(capture: Capture, settings: Settings, spec: &ReplaySpec, channels: &mut Channels) -> Ending {
    let read = read_options(as_recorded(spec.read, &capture), &settings);
    let read = ReadOptions { line_by_line: read.line_by_line || spec.each_second || spec.speed.is_some(), ..read };
    let stored_bytes_read = capture.stored_bytes_read.clone();
    match capture.read(read, channels.stop.clone()) {
        Ok(events) => {
            let ends_as_recorded = spec.settings.duration.is_none() && spec.settings.until.is_empty();
            let measuring = Measuring::capture(settings, spec.speed, stored_bytes_read);
            let ending = measure(measuring, events, None, ends_as_recorded, channels).await;
            if !(ends_as_recorded || matches!(ending.reason, End::SourceEnded | End::SourceFailed(_))) {
                // the reader may or may not have reached the end of the recording, depending on
                // timing
                channels
                    .state
                    .send_modify(|state| state.recorded.iter_mut().for_each(|recorded| recorded.end = Arc::default()));
            }
            ending
        }
        Err(error) => {
            let snapshot = channels.state.borrow().snapshot.clone();
            let (reason, excluded) = (End::SourceFailed(error.to_string()), Duration::ZERO);
            Ending { snapshot, reason, report: None, excluded, shortfall: None }
        }
    }
}

/// The options for reading the bytes of a recording: sentences or packets as chosen now, else as in
/// the recorded measurement.
fn as_recorded(read: ReadOptions, capture: &Capture) -> ReadOptions {
    let Some(recorded) = &capture.recorded else { return read };
    ReadOptions { measured: recorded_settings::frames(read.measured, &recorded.metadata), ..read }
}

/// Counts the samples of the capture, for the position of its replay. A capture that cannot be read
/// twice is not counted.
async fn count_samples(spec: ReplaySpec, state: watch::Sender<SourceState>, stop: CancellationToken) {
    if spec.path == Path::new("-") {
        return;
    }
    // a capture that cannot be opened again has no count
    let Ok(capture) = spec.open().await else { return };
    let read = as_recorded(spec.read, &capture);
    let Ok(mut events) = capture.read(read, stop) else { return };
    let mut samples = 0;
    while let Some(event) = events.recv().await {
        if let Event::Batch(batch) = event {
            samples += batch.row_count() as u64;
        }
    }
    state.send_modify(|state| {
        if let Some(playback) = &mut state.playback {
            playback.total = Some(samples);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stream_is_named_by_its_file_and_one_of_several_also_by_its_topic() {
        let capture = CaptureOptions { topic: Some("/imu".into()), ..CaptureOptions::default() };
        let mut spec = ReplaySpec { capture, ..ReplaySpec::of("day/bag.mcap") };
        assert_eq!((spec.name(), spec.name_with_folder()), ("bag.mcap".into(), "day/bag.mcap".into()));
        spec.is_one_of_several = true;
        assert_eq!((spec.name(), spec.name_with_folder()), ("bag.mcap /imu".into(), "day/bag.mcap /imu".into()));
    }

    #[test]
    fn a_capture_is_named_by_its_format_and_standard_input_by_itself() {
        for (bytes, expected) in [("$VNYMR,+000.0*00\r\n", "text"), ("time,gyro_x\n0.0,1.0\n0.1,2.0\n", "csv")] {
            let capture = Capture::from_reader(io::Cursor::new(bytes), &CaptureOptions::default()).unwrap();
            assert_eq!((kind(&capture, "noon"), kind(&capture, "-")), (expected, "stdin"));
        }
    }
}
