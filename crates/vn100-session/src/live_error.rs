//! The reasons why a live source cannot be used.

use std::io;

use tokio::task;

/// The reason why a live source cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum LiveError {
    /// The source cannot be opened, or no sensor answers on it.
    #[error("{0}")]
    NoSensor(io::Error),
    /// The source was stopped before a sensor was connected.
    #[error("interrupted")]
    Stopped,
    /// The source is a stream, so no command can be sent to it.
    #[error("standard input is not a sensor that replies: name a port")]
    NoCommands,
    /// The source is a stream, so the temperature cannot be polled.
    #[error("the temperature cannot be polled on standard input: name a port")]
    NoTemperature,
    /// The thread that reads a stream cannot be started.
    #[error("cannot start reading")]
    Read(#[source] io::Error),
    /// The task of the link has ended.
    #[error("internal error: the link stopped")]
    LinkTask(#[from] task::JoinError),
}
