//! What `attach` changes on a sensor before it is measured, and puts back behind it.

use anyhow::Result;
use tokio_util::sync::CancellationToken;
use vn100_driver::{Change, ConfigureError, Configured, LinkHandle, OutputSettings, configure};
use vn100_protocol::Command;

use crate::{
    configure::{describe, restore_same, serial},
    live_source::{Interrupted, LiveSource},
};

const PUT_BACK: &str = "put back as it was";

/// A sensor as it was set for its measurement.
#[derive(Default)]
pub(crate) struct SetUp {
    changes: Vec<Change>,
    /// Of the sensor that was changed, where it has one.
    serial: Option<String>,
    /// Whether its output was found paused.
    was_paused: bool,
    /// Whether its output was paused here, and may be so still.
    may_be_paused: bool,
}

impl SetUp {
    /// Sets the sensor as asked, and tells what was changed. An interrupt is the end of the data
    /// and no error: nothing is changed then, or left to be undone.
    pub(crate) async fn new(
        live: &LiveSource,
        settings: Option<OutputSettings>,
        stop: &CancellationToken,
        tell: impl Fn(&str),
    ) -> Result<Self> {
        let Some(settings) = settings else { return Ok(Self::default()) };
        let set = async |link: LinkHandle| Ok((configure(&link, &settings, stop).await?, serial(&link).await));
        match live.ask(stop, set).await {
            Ok((configured, serial)) => {
                tell(&describe(&configured));
                let Configured { changes, was_paused, .. } = configured;
                Ok(Self { changes, serial, was_paused, may_be_paused: false })
            }
            Err(error) if error.is::<Interrupted>() => Ok(Self::default()),
            Err(error) => Self::interrupted(error.downcast()?, tell),
        }
    }

    /// Where an interrupt has broken off what was begun.
    fn interrupted(error: ConfigureError, tell: impl Fn(&str)) -> Result<Self> {
        match error {
            ConfigureError::Interrupted { undone } => {
                if !undone.is_empty() {
                    tell(PUT_BACK);
                }
                Ok(Self::default())
            }
            // once more, on a link of its own
            ConfigureError::Left { cause, changes, may_be_paused, .. }
                if matches!(*cause, ConfigureError::Interrupted { .. }) =>
            {
                Ok(Self { changes, may_be_paused, ..Self::default() })
            }
            error => Err(error.into()),
        }
    }

    /// What is to be set again on a sensor that comes back.
    pub(crate) fn changes(&self) -> &[Change] {
        &self.changes
    }

    /// Sets the sensor as it was before, and tells so: whether it is.
    pub(crate) async fn undo(self, live: &LiveSource, tell: impl Fn(&str)) -> bool {
        let Self { changes, serial, was_paused, may_be_paused } = self;
        if changes.is_empty() && !was_paused && !may_be_paused {
            return true;
        }
        // a second signal ends the program
        let undo = async |link: LinkHandle| {
            let restored = restore_same(&link, &changes, serial.as_deref()).await;
            if was_paused || may_be_paused {
                link.request(Command::Async(!was_paused)).await?;
            }
            restored
        };
        let undone = live.ask(&CancellationToken::new(), undo).await;
        tell(&match &undone {
            Ok(()) if was_paused => format!("{PUT_BACK}, with its output paused"),
            Ok(()) => PUT_BACK.into(),
            // it says itself what stays
            Err(error) if error.is::<ConfigureError>() => format!("could not be put back as it was: {error:#}"),
            Err(error) => {
                let output = match (was_paused, may_be_paused) {
                    (true, _) => Some("its output is on".into()),
                    (false, true) => Some("its output may be paused".into()),
                    (false, false) => None,
                };
                let changes: Vec<_> = changes.iter().map(ToString::to_string).chain(output).collect();
                format!("could not be put back as it was, and may stay changed: {}: {error:#}", changes.join(", "))
            }
        });
        undone.is_ok()
    }
}
