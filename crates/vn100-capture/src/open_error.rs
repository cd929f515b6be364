//! Why a capture cannot be opened.

use std::{
    error::Error,
    io,
    path::{Path, PathBuf},
};

pub use vn100_protocol::stream::OpenHint;

/// The reason why a capture could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The operating system, or the decompressor, reports an error.
    #[error("cannot read {}", path.display())]
    Io {
        /// The file, `-` for standard input.
        path: PathBuf,
        /// The error.
        source: io::Error,
    },
    /// The columns of a table, the topics of a bag or the files of an archive cannot be used.
    #[error("{}: {problem}", path.display())]
    Unusable {
        /// The file or folder, `-` for standard input.
        path: PathBuf,
        /// The reason.
        problem: Unusable,
    },
    /// The file can be read and is no capture.
    #[error("{} is not {reason}", path.display())]
    NotACapture {
        /// The file, `-` for standard input.
        path: PathBuf,
        /// What it is not, and the kind of its content, as far as that is recognised.
        reason: String,
    },
}

/// The reason why a file cannot be used as a capture, in words.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{reason}")]
pub struct Unusable {
    reason: String,
    hint: Option<OpenHint>,
    /// Whether the columns of a table are known, but their stamps are not understood or the requested
    /// stream is missing.
    pub(crate) is_certain: bool,
}

impl Unusable {
    pub(crate) fn new(reason: impl Into<String>) -> Self {
        Self { reason: reason.into(), hint: None, is_certain: false }
    }

    pub(crate) fn certain(reason: impl Into<String>) -> Self {
        Self { is_certain: true, ..Self::new(reason) }
    }

    pub(crate) fn with_hint(self, hint: OpenHint) -> Self {
        Self { hint: Some(hint), ..self }
    }

    /// What the user can add so that the file can be read; `None` if nothing helps.
    pub const fn hint(&self) -> Option<&OpenHint> {
        self.hint.as_ref()
    }
}

/// The reason why a file could not be opened, without its path.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Problem {
    #[error(transparent)]
    Io(#[from] io::Error),
    #[error(transparent)]
    Unusable(#[from] Unusable),
    /// What the file is not.
    #[error("it is not {0}")]
    NotACapture(String),
}

impl Problem {
    pub(crate) fn new(reason: impl Into<String>) -> Self {
        Self::Unusable(Unusable::new(reason))
    }

    pub(crate) fn at(self, path: &Path) -> OpenError {
        let path = path.to_owned();
        match self {
            Self::Io(source) => OpenError::Io { path, source },
            Self::Unusable(problem) => OpenError::Unusable { path, problem },
            Self::NotACapture(reason) => OpenError::NotACapture { path, reason },
        }
    }
}

/// An error with all its causes.
pub fn with_causes(error: &dyn Error) -> String {
    let causes = std::iter::successors(error.source(), |cause| (**cause).source());
    causes.fold(error.to_string(), |text, cause| format!("{text}: {cause}"))
}
