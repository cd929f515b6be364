//! The settings of a sensor for its measurement, and their restoration after it.

use tokio_util::sync::CancellationToken;
use vn100_analysis::protocol::{Register, SensorCommand};
use vn100_driver::{Change, ConfigureError, Configured, LinkHandle, OutputSettings, configure, restore};

use crate::{
    channels::Channels,
    live_source::LiveSource,
    session_event::{OutputLeft, SessionEvent},
    start_error::{LiveError, SetupError},
};

#[derive(Default)]
pub(crate) struct SensorSetup {
    pub(crate) changes: Vec<Change>,
    serial: Option<String>,
    was_paused: bool,
    /// Whether this session paused the output and may not have resumed it.
    may_be_paused: bool,
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
                Ok(Self { changes, serial, was_paused, may_be_paused: false })
            }
            Err(SetupError::Live(LiveError::Stopped)) => Ok(Self::default()),
            Err(SetupError::Configure(ConfigureError::Interrupted { undone })) => {
                if !undone.is_empty() {
                    channels.report(SessionEvent::SettingsRestored { output_paused: false });
                }
                Ok(Self::default())
            }
            // restored once more, over another link
            Err(SetupError::Configure(ConfigureError::Left { cause, changes, may_be_paused, .. }))
                if matches!(*cause, ConfigureError::Interrupted { .. }) =>
            {
                Ok(Self { changes, may_be_paused, ..Self::default() })
            }
            Err(error) => Err(error),
        }
    }

    /// Restores the settings. Returns whether the sensor is as it was before.
    pub(crate) async fn undo(self, source: &LiveSource, known_serial: Option<&str>, channels: &Channels) -> bool {
        let Self { changes, serial, was_paused, may_be_paused } = self;
        if changes.is_empty() && !was_paused && !may_be_paused {
            return true;
        }
        // a stop does not interrupt this; only the end of the process does
        let undo = async |link: LinkHandle| {
            let restored = restore_same(&link, &changes, serial.as_deref()).await;
            let is_other = matches!(restored, Err(SetupError::AnotherSensor { .. }));
            if (was_paused || may_be_paused) && !is_other {
                let output = link.request(SensorCommand::Async(!was_paused)).await;
                return restored.and(output.map(|_| ()).map_err(Into::into));
            }
            restored
        };
        let undone = source.with_link(known_serial, &CancellationToken::new(), undo).await;
        let is_restored = undone.is_ok();
        channels.report(match undone {
            Ok(()) => SessionEvent::SettingsRestored { output_paused: was_paused },
            Err(error) => {
                let maybe_paused = may_be_paused.then_some(OutputLeft::MaybePaused);
                let output = if was_paused { Some(OutputLeft::On) } else { maybe_paused };
                SessionEvent::SettingsNotRestored { error, changes, output }
            }
        });
        is_restored
    }
}

/// The serial number of a sensor; `None` if the sensor does not report one.
async fn serial(link: &LinkHandle) -> Option<String> {
    let contents = link.read(Register::SERIAL_NUMBER).await;
    contents.ok().flatten().map(|contents| contents.fields.to_string())
}

/// Restores the settings; another sensor on the port is left as it is.
async fn restore_same(link: &LinkHandle, changes: &[Change], known: Option<&str>) -> Result<(), SetupError> {
    if let (Some(known), Some(now)) = (known, serial(link).await)
        && now != known
    {
        return Err(SetupError::AnotherSensor { now, known: known.to_owned() });
    }
    Ok(restore(link, changes).await?)
}
