//! Why a command over a live link was not carried out, or not for certain.

use thiserror::Error;
use vn100_protocol::{QueueFull, RequestFailure};

/// Why a command has no good answer.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum CommandError {
    /// The sensor refused it, did not answer, or the link went down before it did.
    #[error(transparent)]
    Failed(#[from] RequestFailure),
    /// More is asked for than can wait.
    #[error(transparent)]
    QueueFull(#[from] QueueFull),
    /// The link was opened to send nothing.
    #[error("nothing is sent on this link: it was opened to listen only")]
    ListenOnly,
    /// The link is closed for good.
    #[error("the link to the sensor is closed; open it again")]
    LinkClosed,
}
