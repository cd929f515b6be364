//! Why a text cannot be used.

use thiserror::Error;

/// Why a text of the user cannot be used, in one sentence that says what can.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct InvalidText(pub(crate) String);
