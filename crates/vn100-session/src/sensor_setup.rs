//! The settings of a sensor for its measurement, and their restoration after it.

use tokio_util::sync::CancellationToken;
use vn100_analysis::protocol::{Register, SensorCommand};
use vn100_driver::{Change, ConfigureError, Configured, LinkHandle, OutputLeft, OutputSettings, configure, restore};

use crate::{
    channels::Channels,
    live_source::LiveSource,
    session_event::SessionEvent,
    start_error::{LiveError, SetupError},
};

#[derive(Default)]
pub(crate) struct SensorSetup {
    pub(crate) changes: Vec<Change>,
    serial: Option<String>,
    /// The output, if this session has to restore it.
    output: Option<OutputLeft>,
}

impl SensorSetup {
    /// Configures the sensor. A stop meanwhile is the end of the data and no error: in that case no
    /// change remains to be restored.
    pub(crate) async fn new(
        source: &LiveSource,
        settings: Option<OutputSettings>,
        known_serial: Option<&str>,
        channels: &Channels,
    ) -> Result<Self, SetupError> {
        let Some(settings) = settings else { return Ok(Self::default()) };
        let stop = &channels.stop;
        let set = async |link: LinkHandle| Ok((configure(&link, &settings, stop).await?, serial(&link).await));
        match source.with_link(known_serial, stop, set).await {
            Ok((configured, serial)) => {
                let Configured { changes, was_paused, .. } = configured.clone();
                channels.report(SessionEvent::SensorConfigured(configured));
                Ok(Self { changes, serial, output: was_paused.then_some(OutputLeft::On) })
            }
            Err(SetupError::Live(LiveError::Stopped)) => Ok(Self::default()),
            Err(SetupError::Configure(ConfigureError::Interrupted { undone })) => {
                if !undone.is_empty() {
                    channels.report(SessionEvent::SettingsRestored { output_paused: false });
                }
                Ok(Self::default())
            }
            // restored once more, over another link
            Err(SetupError::Configure(ConfigureError::Left { cause, changes, output, .. }))
                if matches!(*cause, ConfigureError::Interrupted { .. }) =>
            {
                Ok(Self { changes, output, ..Self::default() })
            }
            Err(error) => Err(error),
        }
    }

    /// Restores the settings. Returns whether the sensor is as it was before.
    pub(crate) async fn undo(self, source: &LiveSource, known_serial: Option<&str>, channels: &Channels) -> bool {
        let Self { changes, serial, output } = self;
        if changes.is_empty() && output.is_none() {
            return true;
        }
        // a stop does not interrupt this; only the end of the process does
        let undo = async |link: LinkHandle| restore_same(&link, &changes, output, serial.as_deref()).await;
        let undone = source.with_link(known_serial, &CancellationToken::new(), undo).await;
        let is_restored = undone.is_ok();
        channels.report(match undone {
            Ok(()) => SessionEvent::SettingsRestored { output_paused: output == Some(OutputLeft::On) },
            Err(error) => SessionEvent::SettingsNotRestored { error, changes, output },
        });
        is_restored
    }
}

/// The serial number of a sensor; `None` if the sensor does not report one.
async fn serial(link: &LinkHandle) -> Option<String> {
    let contents = link.read(Register::SERIAL_NUMBER).await;
    contents.ok().flatten().map(|contents| contents.fields.to_string())
}

/// Restores the settings and the output; another sensor on the port is left as it is.
async fn restore_same(
    link: &LinkHandle,
    changes: &[Change],
    output: Option<OutputLeft>,
    known: Option<&str>,
) -> Result<(), SetupError> {
    if let (Some(known), Some(now)) = (known, serial(link).await)
        && now != known
    {
        return Err(SetupError::AnotherSensor { now, known: known.to_owned() });
    }
    let restored = restore(link, changes).await.map_err(SetupError::from);
    let Some(output) = output else { return restored };
    let output = link.request(SensorCommand::Async(output == OutputLeft::MaybePaused)).await;
    restored.and(output.map(drop).map_err(SetupError::from))
}
