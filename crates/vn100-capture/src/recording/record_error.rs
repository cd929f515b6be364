//! Why a recording cannot be made.

use std::{io, path::PathBuf};

use super::reader::RecordingError;

/// Why a recording cannot begin.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The operating system refused.
    #[error("cannot record to {}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What it said.
        source: io::Error,
    },
    /// A file of this name is there.
    #[error("{} exists and is not replaced: choose another name, or resume it", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// To resume a recording replaces its file, and a symbolic link would be replaced instead.
    #[error("{} is a symbolic link: name the recording itself to resume it", path.display())]
    SymbolicLink {
        /// The link.
        path: PathBuf,
    },
    /// Another program records to it.
    #[error("{} is being recorded to: end that first", path.display())]
    InUse {
        /// The file.
        path: PathBuf,
    },
    /// What is there is no recording that can be resumed.
    #[error("{} cannot be resumed: {problem}", path.display())]
    NotResumable {
        /// The file.
        path: PathBuf,
        /// What it is instead.
        problem: RecordingError,
    },
}
