//! `vn100 compare`: captures side by side.

use anyhow::{Result, bail};
use vn100_pipeline::{Comparison, DEFAULT_CONFIDENCE, Record};

use crate::{
    args::{FileArgs, Telling},
    comparison_document::ComparisonDocument,
    exit::{Exit, print, print_json, report},
    files::{EachSecond, measure_files},
    measured::Measured,
    text,
};

pub(crate) fn compare(args: &FileArgs) -> Result<Exit> {
    let telling = args.measure.telling();
    if telling == Telling::Ndjson || args.measure.filter_models {
        bail!("--ndjson and --filter-models belong to one capture: give them to vn100 replay");
    }
    let mut all: Vec<Measured> = Vec::new();
    measure_files(args, EachSecond::Unseen, |measured| {
        measured.origin.error.iter().chain(&measured.unmet).for_each(|text| report(text));
        all.push(measured);
        Ok(())
    })?;
    let records: Vec<Record<'_>> = all.iter().map(record).collect();
    let comparison = Comparison::of(&records, args.measure.confidence.unwrap_or(DEFAULT_CONFIDENCE));
    if telling == Telling::Json {
        let document = ComparisonDocument::new(&all, &comparison);
        print_json(&serde_json::to_string_pretty(&document)?)?;
    } else {
        print(&text::comparison(&all, &comparison))?;
    }
    Ok(all.iter().map(|measured| measured.exit).max().unwrap_or(Exit::Good))
}

fn record(measured: &Measured) -> Record<'_> {
    Record { name: &measured.origin.name, snapshot: &measured.snapshot, assessment: &measured.assessment }
}
