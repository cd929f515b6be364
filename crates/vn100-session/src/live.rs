//! The session of a live sensor: it is recorded, configured, measured and restored.

use std::{collections::BTreeMap, error::Error, time::Duration};

use tokio::time::Instant;
use tokio_util::sync::CancellationToken;
use vn100_analysis::{Settings, protocol::Register, recorded_settings};
use vn100_capture::Recorder;
use vn100_driver::{Change, LinkHandle, LinkOptions, LinkState, OutputSettings};

use crate::{
    channels::Channels,
    live_source::LiveSource,
    measure::{Measuring, measure, read_options},
    recording::{RecordedMessage, RecordingSpec, layout_named},
    sample_tap::SampleTap,
    sensor_setup::SensorSetup,
    session_event::SessionEvent,
    session_result::{SessionResult, not_started, result},
    start_error::StartError,
    state::Stage,
    wall_limits::{Deadlines, WallLimits},
};

/// The interval between two reads of register 54, if the temperature is polled.
const TEMPERATURE_PERIOD: Duration = Duration::from_secs(10);

/// A live source, and the options of its measurement.
pub struct LiveSpec {
    /// The name of the source in results.
    pub name: String,
    /// `serial`, `tcp`, `sim` or `stdin`; `None` while the kind is not known.
    pub kind: Option<&'static str>,
    /// The source; an error ends the session at once, with
    /// [`StartError::StreamInput`](crate::StartError).
    pub source: Result<LiveSource, Box<dyn Error + Send + Sync>>,
    /// The settings of the measurement.
    pub settings: Settings,
    /// Whether the temperature is polled between the samples (register 54).
    pub temperature: bool,
    /// The settings of the sensor for the measurement; `None` to leave it unchanged.
    pub output: Option<OutputSettings>,
    /// The conditions of the measurement, as written by the user: name and text.
    pub conditions: BTreeMap<String, String>,
    /// The recording to make; `None` for none.
    pub recording: Option<RecordingSpec>,
    /// Whether the state at every second of data time is sent to
    /// [`Session::seconds`](crate::Session::seconds). A stream waits until each state is taken; of
    /// a link, states that are not taken in time are dropped.
    pub each_second: bool,
    /// Receives the samples as well; `None` for no such receiver.
    pub samples: Option<SampleTap>,
    /// The limits that end the session by the clock.
    pub limits: WallLimits,
    /// Ends the session.
    pub stop: CancellationToken,
}

pub(crate) async fn run_live(mut spec: LiveSpec, mut channels: Channels) -> SessionResult {
    let start = Instant::now();
    let unusable = Err(Box::from("the source is in use"));
    let mut source = match std::mem::replace(&mut spec.source, unusable) {
        Ok(source) => source,
        Err(error) => return channels.end(not_started(StartError::StreamInput(error), &channels)),
    };
    // first, so that no setting is changed for a recording that cannot be made
    let (recorder, recorded) = match begin_recording(&source, &spec).await {
        Ok(begun) => begun.unzip(),
        Err(error) => return channels.end(not_started(error, &channels)),
    };
    let known_serial = recorder.as_ref().and_then(Recorder::known_serial).map(str::to_owned);
    let result = match SensorSetup::new(&source, spec.output.clone(), known_serial.as_deref(), &channels).await {
        Ok(setup) => {
            let keep = setup.changes.clone();
            if keep.iter().any(|change| change.register == Register::BAUD_RATE) {
                // the sensor is searched at its present baud rate; after a power loss it has the
                // former one again
                source.options.baud = None;
            }
            let result =
                measure_and_record(&source, keep, recorder, recorded.flatten(), &spec, start, &mut channels).await;
            let is_restored = setup.undo(&source, known_serial.as_deref(), &channels).await;
            SessionResult { is_restored, ..result }
        }
        Err(error) => not_measured(error.into(), recorder, &spec, &channels).await,
    };
    channels.end(result)
}

/// The recording, and the message that it has already.
async fn begin_recording(
    source: &LiveSource,
    spec: &LiveSpec,
) -> Result<Option<(Recorder, Option<RecordedMessage>)>, StartError> {
    let Some(recording) = &spec.recording else { return Ok(None) };
    let recorded = recording.message().await;
    let asked = spec.output.as_ref().and_then(|output| layout_named(output.message.as_deref()?));
    recorded.iter().zip(&asked).try_for_each(|(recorded, asked)| recorded.check(asked))?;
    let metadata = recorded_settings::metadata(&spec.conditions, &spec.settings, source.options.read.measured);
    Ok(Some((recording.begin(metadata).await?, recorded)))
}

/// The result of a source that is not measured; an empty recording is removed.
async fn not_measured(
    error: StartError,
    recorder: Option<Recorder>,
    spec: &LiveSpec,
    channels: &Channels,
) -> SessionResult {
    let result = not_started(error, channels);
    if let (Some(recorder), Some(recording)) = (recorder, &spec.recording) {
        recording.end(recorder, &result.end, result.excluded).await;
    }
    result
}

async fn measure_and_record(
    source: &LiveSource,
    keep: Vec<Change>,
    recorder: Option<Recorder>,
    recorded: Option<RecordedMessage>,
    spec: &LiveSpec,
    start: Instant,
    channels: &mut Channels,
) -> SessionResult {
    let options = LinkOptions {
        read: read_options(source.options.read, &spec.settings),
        poll_temperature: spec.temperature.then_some(TEMPERATURE_PERIOD),
        desired_settings: keep,
        known_serial: recorder.as_ref().and_then(Recorder::known_serial).map(str::to_owned),
        recording: recorder.as_ref().map(Recorder::inputs),
        ..source.options.clone()
    };
    let reading = channels.stop.child_token();
    let opened = source.open(options, reading.clone());
    let (link, events) = match opened {
        Ok(opened) => opened,
        Err(error) => return not_measured(error.into(), recorder, spec, channels).await,
    };
    let mut deadlines = Deadlines::new(spec.limits, start);
    if link.is_none() {
        deadlines.note_connected(Instant::now());
    }
    let measuring = Measuring::live(spec.settings.clone(), link.clone(), recorded, deadlines);
    let ending = measure(measuring, events, recorder.as_ref().map(Recorder::state), false, channels).await;
    channels.stage(Stage::Finishing);
    if let Some(link) = &link {
        match closed(link).await {
            Some(true) => channels.report(SessionEvent::OutputPausedAgain),
            Some(false) => channels.report(SessionEvent::OutputNotPausedAgain),
            None => {}
        }
        channels.state.send_modify(|state| state.link = Some(link.state().borrow().clone()));
    } else {
        // a stream that sends nothing more would keep the recording open
        reading.cancel();
    }
    let result = result(ending, &spec.settings.until, channels);
    let (Some(recorder), Some(recording)) = (recorder, &spec.recording) else { return result };
    let state = recording.end(recorder, &result.end, result.excluded).await;
    channels.state.send_modify(|shown| shown.recording = Some(state.clone()));
    let unrecorded_bytes = link.map_or(0, |link| link.unrecorded_bytes());
    SessionResult { recording: Some(state), unrecorded_bytes, ..result }
}

/// Waits until the link has closed its port. Returns whether an output that was found paused is
/// paused again.
async fn closed(link: &LinkHandle) -> Option<bool> {
    // if the task of the link has ended, its state is not known
    match link.state().wait_for(|state| matches!(state, LinkState::Closed { .. })).await.as_deref() {
        Ok(LinkState::Closed { paused_again }) => *paused_again,
        _ => None,
    }
}
