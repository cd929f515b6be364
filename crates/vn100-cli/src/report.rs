//! `vn100 report`: one page with every figure and table of a noise measurement, and its numbers in
//! the forms other programs read.

mod capture_file;
mod export;
mod figure;
mod figures;
mod findings;
mod numbers;
mod output;
mod page;
mod record;
mod words;

use anyhow::{Result, bail};

use crate::{
    args::ReportArgs,
    exit::{Exit, report as complain},
    files::{EachSecond, measure_files},
    judging::Judging,
    measured::Measured,
};
use capture_file::CaptureFile;
use export::Exports;
use figures::Figures;
use output::Output;
use record::Record;

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
    let judging = Judging::new(&files.measure)?.with_filter_models(args.filter_models);
    measure_files(files, judging, EachSecond::Unseen, |measured| {
        if let Some(error) = &measured.origin.error {
            complain(error);
        }
        all.push(measured);
        Ok(())
    })?;
    let records: Vec<Record<'_>> =
        (all.iter().zip(&files.files)).map(|(measured, path)| Record::new(measured, CaptureFile::of(path))).collect();
    let names: Vec<String> = (0..records.len()).map(page::letter).collect();
    let prefix = |name: &String| if records.len() > 1 { format!("{name}-") } else { String::new() };
    let figures = records
        .iter()
        .zip(&names)
        .map(|(record, name)| Figures::of(record, &prefix(name)))
        .collect::<Result<Vec<_>>>()?;
    let together = if records.len() > 1 { Figures::together(&records, &names)? } else { Figures::default() };
    if let Some(path) = output.page() {
        output.write(path, page::page(&records, &figures, &together, args)?.as_bytes())?;
    }
    exports.write(&records, &figures, &together)?;
    Ok(all.iter().map(|measured| measured.exit).max().unwrap_or(Exit::Good))
}
