//! What a command measures of its files: each stream of each.

use std::path::{Path, PathBuf};

use vn100_capture::{Capture, CaptureOptions};

use crate::args::FileArgs;

/// A stream of a file.
#[derive(Debug, Clone)]
pub(crate) struct FileStream {
    pub(crate) path: PathBuf,
    pub(crate) options: CaptureOptions,
    /// Whether the file has others, too.
    pub(crate) is_one_of_several: bool,
}

/// The streams of the files, in their order. Standard input, which cannot be read twice, counts as
/// one.
pub(crate) fn inputs(args: &FileArgs) -> Vec<FileStream> {
    let options = CaptureOptions { columns: args.columns.clone(), topic: args.topic.clone() };
    let mut inputs = Vec::new();
    for path in &args.files {
        let topics = match path == Path::new("-") {
            true => vec![options.topic.clone()],
            false => Capture::streams(path, &options),
        };
        let is_one_of_several = topics.len() > 1;
        inputs.extend(topics.into_iter().map(|topic| FileStream {
            path: path.clone(),
            options: CaptureOptions { topic, ..options.clone() },
            is_one_of_several,
        }));
    }
    inputs
}
