//! `vn100 compare`: captures side by side.

use anyhow::Result;
use vn100_analysis::{ComparedRecord, Comparison, DEFAULT_CONFIDENCE};
use vn100_report::{ComparisonDocument, Measured};

use crate::{
    args::CompareArgs,
    datasheet::evaluation,
    exit::{Exit, print, print_json, report},
    files::{EachSecond, measure_files},
    remedy_words::remedy_words,
    text,
};

pub(crate) fn compare(args: &CompareArgs) -> Result<Exit> {
    let evaluation = evaluation(&args.files.measure)?;
    let mut all: Vec<Measured> = Vec::new();
    measure_files(&args.files, evaluation, EachSecond::Unseen, |measured| {
        measured.facts.error.iter().chain(&measured.unmet).for_each(|text| report(text));
        all.push(measured);
        Ok(())
    })?;
    let records: Vec<ComparedRecord<'_>> = all.iter().map(record).collect();
    let comparison = Comparison::of(&records, args.files.measure.confidence.unwrap_or(DEFAULT_CONFIDENCE));
    if args.json {
        let document = ComparisonDocument::new(&all, &comparison, remedy_words);
        print_json(&serde_json::to_string_pretty(&document)?)?;
    } else {
        print(&text::comparison(&all, &comparison))?;
    }
    Ok(all.iter().map(|measured| measured.completion.into()).max().unwrap_or(Exit::Good))
}

fn record(measured: &Measured) -> ComparedRecord<'_> {
    ComparedRecord { name: &measured.facts.name, snapshot: &measured.snapshot, assessment: &measured.assessment }
}
