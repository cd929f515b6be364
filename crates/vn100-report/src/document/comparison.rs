//! The JSON document of several captures side by side, schema `vn100.comparison/1`: a contract with
//! scripts.
//!
//! SI units (magnetic field in gauss); what is not known is `null`. `record` is a place in
//! `records`, from 0. A probability `p` is that of one test alone, `corrected` is `p` with Holm's
//! correction; `differs` is `corrected` < 1 - `confidence`.

use serde::Serialize;
use vn100_analysis::{Caveat, Comparison, RemedyWords, SourceResult};

use crate::{caveats::caveat_in_words, warnings::in_words};

/// The JSON document of several records side by side.
#[derive(Debug, Serialize)]
pub struct ComparisonDocument<'a> {
    schema: &'static str,
    /// In the order given, those that could not be read too.
    records: Vec<RecordDocument<'a>>,
    #[serde(flatten)]
    comparison: &'a Comparison,
    disturbances: Vec<DisturbanceDocument<'a>>,
    caveats: Vec<CaveatDocument<'a>>,
}

#[derive(Debug, Serialize)]
struct RecordDocument<'a> {
    name: &'a str,
    kind: Option<&'static str>,
    error: Option<&'a str>,
    message: Option<&'a str>,
    compensated: Option<bool>,
    rate_hz: Option<f64>,
    duration_s: f64,
    samples: u64,
    /// Kinds of all warnings of its own analysis.
    warnings: Vec<&'static str>,
}

#[derive(Debug, Serialize)]
struct DisturbanceDocument<'a> {
    record: usize,
    kind: &'static str,
    channels: &'a [String],
    text: String,
}

#[derive(Debug, Serialize)]
struct CaveatDocument<'a> {
    #[serde(flatten)]
    caveat: &'a Caveat,
    text: String,
}

impl<'a> ComparisonDocument<'a> {
    /// The document of a comparison of `all`; remedies are put into `words`.
    pub fn new(all: &'a [SourceResult], comparison: &'a Comparison, words: RemedyWords) -> Self {
        let disturbances = comparison.disturbances.iter().map(|(record, warning)| DisturbanceDocument {
            record: *record,
            kind: warning.kind.name(),
            channels: &warning.channels,
            text: in_words(warning, words),
        });
        let caveats = comparison.caveats.iter();
        Self {
            schema: "vn100.comparison/1",
            records: all.iter().map(RecordDocument::new).collect(),
            comparison,
            disturbances: disturbances.collect(),
            caveats: caveats
                .map(|caveat| CaveatDocument { caveat, text: caveat_in_words(caveat, all, comparison, words) })
                .collect(),
        }
    }
}

impl<'a> RecordDocument<'a> {
    fn new(result: &'a SourceResult) -> Self {
        let SourceResult { source, timing, .. } = result;
        Self {
            name: &source.name,
            kind: source.kind,
            error: source.error.as_deref(),
            message: source.message.as_deref(),
            compensated: source.compensated,
            rate_hz: timing.rate_hz,
            duration_s: timing.duration_s,
            samples: timing.samples,
            warnings: result.warnings.iter().map(|warning| warning.kind.name()).collect(),
        }
    }
}
