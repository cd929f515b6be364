//! The JSON document of one source, schema `vn100.analysis/2`: a contract with scripts. It is the
//! result of the source with its warnings and statuses in words.

pub(crate) mod comparison;
pub(crate) mod plan;
pub(crate) mod progress;

use schemars::{JsonSchema, Schema, generate::SchemaSettings, transform::RecursiveTransform};
use serde::Serialize;
use serde_json::Value;
use vn100_analysis::{RemedyWords, Severity, SourceResult};

use crate::{remedies::RemedyDocument, warnings::in_words};

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
    #[must_use]
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
#[must_use]
pub fn analysis_schema() -> Schema {
    schema_of::<Document<'_>>()
}

pub(crate) fn schema_of<T: JsonSchema>() -> Schema {
    let settings = SchemaSettings::draft2020_12().for_serialize().with_transform(RecursiveTransform(described));
    settings.into_generator().into_root_schema_for::<T>()
}

/// Puts the words of the code into those of the document, on one line; a field that has none takes
/// those of the variant that it belongs to.
fn described(schema: &mut Schema) {
    let Some(object) = schema.as_object_mut() else { return };
    if let Some(Value::String(text)) = object.get_mut("description") {
        *text = text.replace("`None`", "null").replace('`', "").split_whitespace().collect::<Vec<_>>().join(" ");
    }
    let own = object.get("description").cloned();
    let fields = object.get_mut("properties").and_then(Value::as_object_mut);
    for field in fields.into_iter().flat_map(|fields| fields.values_mut()).filter_map(Value::as_object_mut) {
        if let (false, Some(own)) = (field.contains_key("description"), own.clone()) {
            field.insert("description".into(), own);
        }
    }
}
