//! `vn100 report`: one page with every figure and table of a noise measurement, and its numbers in
//! the forms other programs read.

mod capture_file;
mod exports;
mod options;
mod output;

use anyhow::{Result, bail};
use vn100_analysis::DEFAULT_CONFIDENCE;
use vn100_report::{Figures, Measured, PageOptions, Program, Record, record_letter, write_page};

use crate::{
    args::ReportArgs,
    datasheet::evaluation,
    exit::{Exit, report as complain},
    files::{EachSecond, measure_files},
    remedy_words::remedy_words,
};
use capture_file::capture_file;
use exports::Exports;
use options::option_text;
use output::Output;

/// What makes the report.
const PROGRAM: Program<'_> =
    Program { name: concat!("vn100 ", env!("CARGO_PKG_VERSION")), commit: option_env!("VN100_COMMIT") };

pub(crate) fn report(args: &ReportArgs) -> Result<Exit> {
    let files = &args.files;
    let output = Output::new(&args.output, args.force);
    match output.page() {
        Some(page) => output.check(page, &files.files)?,
        None if args.export.is_empty() => {
            bail!(
                "{} does not end in .html, and nothing is exported: name a page, or --export something",
                args.output.display()
            )
        }
        None => {}
    }
    let exports = Exports::new(args, &output)?;
    let mut all: Vec<Measured> = Vec::new();
    let evaluation = evaluation(&files.measure)?.with_filter_models(args.filter_models);
    measure_files(files, evaluation, EachSecond::Unseen, |measured| {
        if let Some(error) = &measured.facts.error {
            complain(error);
        }
        all.push(measured);
        Ok(())
    })?;
    for (measured, path) in all.iter_mut().zip(&files.files) {
        measured.facts.file = capture_file(path);
    }
    let records: Vec<Record<'_>> = all.iter().map(Record::new).collect();
    let names: Vec<String> = (0..records.len()).map(record_letter).collect();
    let prefix = |name: &String| if records.len() > 1 { format!("{name}-") } else { String::new() };
    let figures = records
        .iter()
        .zip(&names)
        .map(|(record, name)| Figures::of(record, &prefix(name)))
        .collect::<Result<Vec<_>, _>>()?;
    let together = if records.len() > 1 { Figures::together(&records, &names)? } else { Figures::default() };
    if let Some(path) = output.page() {
        let options = PageOptions {
            confidence: files.measure.confidence.unwrap_or(DEFAULT_CONFIDENCE),
            asked: &option_text(args),
            words: remedy_words,
            program: PROGRAM,
        };
        output.write(path, |file| Ok(write_page(file, &records, &figures, &together, options)?))?;
    }
    exports.write(&records, &figures, &together)?;
    Ok(all.iter().map(|measured| measured.completion.into()).max().unwrap_or(Exit::Good))
}
