//! `vn100 report`: one page with every figure and table of a noise measurement, and its numbers in
//! the forms other programs read.

mod exports;

use std::{fs, io::Write, path::Path, thread};

use anyhow::{Result, anyhow};
use vn100_analysis::{Completion, DEFAULT_CONFIDENCE, FileFacts, SourceResult};
use vn100_report::figure::ReportFigures;
use vn100_report::html::{PageOptions, report_page};
use vn100_session::ReplaySpec;

use vn100_report::remedies::page_words;

use crate::{
    args::ReportArgs,
    asked::asked,
    commands::replay::{Outputs, measure_files},
    digest::digest,
    exit::{print, report as complain, unless_closed},
    inputs::inputs,
    output::Output,
    serve::PROGRAM,
    user_files::evaluation,
};
use exports::Exports;
pub(super) use exports::not_written;

pub(crate) fn report(args: &ReportArgs) -> Result<Completion> {
    let files = &args.files;
    let output = Output::new(&args.output(), args.existing.force);
    if let Some(page) = output.page() {
        output.check(page, &files.files)?;
    }
    let inputs = inputs(files);
    let exports = Exports::new(args, &inputs, &output)?;
    let mut records: Vec<SourceResult> = Vec::new();
    let evaluation = evaluation(&files.measure)?;
    let stored = thread::scope(|scope| {
        // a checksum takes as long as reading the file once more: beside the measurement
        let stored = scope.spawn(|| inputs.iter().map(capture_of).collect::<Vec<_>>());
        measure_files(files, &inputs, evaluation.clone(), Outputs::default(), |measured| {
            measured.failures().for_each(|text| complain(text));
            records.push(measured);
            Ok(())
        })?;
        stored.join().map_err(|_| anyhow!("internal error: the checksums stopped"))
    })?;
    for (measured, stored) in records.iter_mut().zip(stored) {
        measured.source.file = stored;
    }
    let figures = ReportFigures::of(&records);
    // of a capture of which nothing was read there is nothing to say on a page
    let is_read = records.iter().any(|record| record.link.bytes > 0);
    if let Some(path) = output.page().filter(|_| is_read) {
        let options = PageOptions {
            confidence: files.measure.confidence.unwrap_or(DEFAULT_CONFIDENCE),
            asked: &asked(),
            words: page_words,
            program: PROGRAM,
            span_s: args.span.as_secs_f64(),
        };
        output.write(path, |file| Ok(file.write_all(report_page(&records, &figures, options).as_bytes())?))?;
        print_written(path)?;
    }
    let exported = exports.write(&records, &figures, &evaluation);
    Ok(records.iter().map(|measured| measured.completion).max().unwrap_or(Completion::Complete).max(exported))
}

/// A file that was written is the result of this command.
fn print_written(path: &Path) -> Result<()> {
    unless_closed(print(&format!("wrote {}\n", path.display())))
}

/// The facts of the stored bytes, compressed or not; parts that are joined are several files, and only
/// a file gives the same bytes when it is read twice.
fn capture_of(input: &ReplaySpec) -> Option<FileFacts> {
    let path = &input.path;
    let is_file = path != Path::new("-") && fs::metadata(path).is_ok_and(|found| found.is_file());
    (is_file && input.capture.later_parts.is_empty()).then(|| digest(path).ok())?
}
