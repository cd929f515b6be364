//! What a command measures of its files: each stream of each, and the parts of a recording as one.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use vn100_capture::{Capture, CaptureOptions, RecordingPart, joined_parts, missing_parts};

use crate::{args::FileArgs, exit::report};

#[derive(Debug, Clone)]
pub(crate) struct FileStream {
    pub(crate) path: PathBuf,
    pub(crate) options: CaptureOptions,
    pub(crate) is_one_of_several: bool,
}

impl FileStream {
    /// Its file, and the parts that follow it.
    pub(crate) fn files(&self) -> impl Iterator<Item = &Path> {
        std::iter::once(&self.path).chain(&self.options.later_parts).map(PathBuf::as_path)
    }
}

/// What the user says of the content of the files.
pub(crate) fn capture_options(args: &FileArgs, later_parts: Vec<PathBuf>) -> CaptureOptions {
    CaptureOptions { columns: args.columns.clone(), topic: args.topic.clone(), later_parts }
}

/// The streams of the files, in their order; parts of one recording stand where the first of them
/// is named.
pub(crate) fn inputs(args: &FileArgs) -> Vec<FileStream> {
    let part = |path: &PathBuf| (!is_stdin(path)).then(|| RecordingPart::of(path)).flatten();
    let mut inputs = Vec::new();
    for parts in joined_parts(args.files.iter().map(|path| (path.clone(), part(path)))) {
        report_missing(&parts);
        let mut files: Vec<PathBuf> = parts.into_values().collect();
        let path = files.remove(0);
        // standard input, which cannot be read twice, counts as one stream
        let topics = match is_stdin(&path) {
            true => vec![args.topic.clone()],
            false => Capture::streams(&path, &capture_options(args, Vec::new())),
        };
        let options = capture_options(args, files);
        let is_one_of_several = topics.len() > 1;
        inputs.extend(topics.into_iter().map(|topic| FileStream {
            path: path.clone(),
            options: CaptureOptions { topic, ..options.clone() },
            is_one_of_several,
        }));
    }
    inputs
}

fn is_stdin(path: &Path) -> bool {
    path == Path::new("-")
}

/// Reports the parts of a recording that are not there; of a part alone it is known which it is.
fn report_missing(parts: &BTreeMap<u32, PathBuf>) {
    if let Some((path, text)) = parts.values().next().zip(missing_parts(&parts.keys().copied().collect::<Vec<_>>())) {
        report(&format!("{}: {text}", path.display()));
    }
}
