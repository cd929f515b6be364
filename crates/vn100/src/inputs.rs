//! What a command measures of its files: each stream of each, and the parts of a recording as one.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use vn100_capture::{CaptureOptions, RecordingPart, joined_parts, missing_parts};
use vn100_session::ReplaySpec;

use crate::{args::FileArgs, exit::report};

/// What the user says of every file.
pub(crate) fn any_input(args: &FileArgs) -> ReplaySpec {
    ReplaySpec {
        settings: args.settings(),
        read: args.measure.read_options(),
        capture: CaptureOptions { columns: args.columns.clone(), topic: args.topic.clone(), later_parts: Vec::new() },
        ..ReplaySpec::default()
    }
}

/// The streams of the files, in their order; parts of one recording stand where the first of them
/// is named.
pub(crate) fn inputs(args: &FileArgs) -> Vec<ReplaySpec> {
    let any = any_input(args);
    let part = |path: &PathBuf| (!is_stdin(path)).then(|| RecordingPart::of(path)).flatten();
    let mut inputs = Vec::new();
    for parts in joined_parts(args.files.iter().map(|path| (path.clone(), part(path)))) {
        report_missing(&parts);
        let mut files: Vec<PathBuf> = parts.into_values().collect();
        let path = files.remove(0);
        let capture = CaptureOptions { later_parts: files, ..any.capture.clone() };
        let input = ReplaySpec { path, capture, ..any.clone() };
        // standard input, which cannot be read twice, counts as one stream
        inputs.extend(if is_stdin(&input.path) { vec![input] } else { input.streams() });
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
