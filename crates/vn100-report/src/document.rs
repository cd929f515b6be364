//! The JSON document of one source, schema `vn100.analysis/2`: a contract with scripts. It is the
//! result of the source with its warnings and statuses in words.

pub(crate) mod comparison;
pub(crate) mod plan;
pub(crate) mod progress;

use schemars::{JsonSchema, Schema};
use serde::Serialize;
use vn100_analysis::{RemedyWords, Severity, SourceResult};

use crate::{remedies::RemedyDocument, schema::schema_of, warnings::in_words};

use crate::summary::{AspectStatus, status::statuses};

/// The JSON document of one source.
#[derive(Debug, JsonSchema, Serialize)]
#[schemars(
    title = "vn100.analysis/2",
    description = "Result of a measurement of one source. SI units; angles in degrees, magnetic field in gauss; null if a number is not known. Fields may be added."
)]
pub struct Document<'a> {
    /// Name of this schema.
    #[schemars(extend("const" = "vn100.analysis/2"))]
    schema: &'static str,
    #[serde(flatten)]
    result: &'a SourceResult,
    /// How far the record can be trusted, aspect by aspect.
    statuses: Vec<AspectStatus>,
    /// Limits of the result, the gravest first.
    warnings: Vec<WarningDocument>,
}

/// One warning.
#[derive(Debug, JsonSchema, Serialize)]
struct WarningDocument {
    /// Kind of the warning, as a code.
    kind: &'static str,
    /// What the warning means for the result: problem, caution or note.
    severity: &'static str,
    /// Names of the channels concerned; empty if all are.
    channels: Vec<String>,
    /// What was found, why it matters and what to do.
    text: String,
    /// What can be done in this case.
    remedies: Vec<RemedyDocument>,
}

impl<'a> Document<'a> {
    /// The document of a result; remedies are put into `words`.
    pub fn new(result: &'a SourceResult, words: RemedyWords) -> Self {
        let warnings = result.warnings.iter().map(|warning| WarningDocument {
            kind: warning.kind.name(),
            severity: Severity::name(warning.severity),
            channels: warning.channels.clone(),
            text: in_words(warning, words),
            remedies: warning.remedies.iter().map(RemedyDocument::new).collect(),
        });
        Self { schema: "vn100.analysis/2", result, statuses: statuses(result, |_| 0), warnings: warnings.collect() }
    }
}

/// The JSON Schema (2020-12) of [`Document`], with a description of every field.
pub fn analysis_schema() -> Schema {
    schema_of::<Document<'_>>()
}
