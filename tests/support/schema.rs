//! Checks documents against their schema: only the part of JSON Schema that it uses.

use std::collections::BTreeSet;

use serde_json::Value;

const KEYWORDS: [&str; 14] = [
    "$schema",
    "$defs",
    "$ref",
    "title",
    "description",
    "type",
    "enum",
    "const",
    "properties",
    "required",
    "additionalProperties",
    "items",
    "anyOf",
    "minItems",
];

/// The schema of documents of measurements.
pub(crate) fn analysis() -> Value {
    serde_json::from_str(vn100_report::ANALYSIS_SCHEMA).unwrap()
}

/// The schema of lines about a measurement in progress.
pub(crate) fn progress() -> Value {
    serde_json::from_str(vn100_report::PROGRESS_SCHEMA).unwrap()
}

/// Checks documents of measurements, alone or among others in an array.
#[track_caller]
pub(crate) fn check(document: &Value) {
    for document in document.as_array().unwrap_or(&vec![document.clone()]) {
        if ["vn100.analysis/1", "vn100.progress/1"].iter().any(|name| document["schema"] == *name) {
            let errors = errors(document, &mut BTreeSet::new());
            assert!(errors.is_empty(), "not as the schema has it:\n{}", errors.join("\n"));
        }
    }
}

/// The differences from the schema. `seen` collects the places of the schema that had a value.
pub(crate) fn errors(document: &Value, seen: &mut BTreeSet<String>) -> Vec<String> {
    let schema = match document["schema"].as_str() {
        Some("vn100.progress/1") => progress(),
        _ => analysis(),
    };
    let mut errors = Vec::new();
    compare(document, &schema, &schema, ("", ""), &mut errors, seen);
    errors
}

fn compare(
    value: &Value,
    schema: &Value,
    root: &Value,
    (at, place): (&str, &str),
    errors: &mut Vec<String>,
    seen: &mut BTreeSet<String>,
) {
    if let Some(reference) = schema["$ref"].as_str() {
        let place = reference.trim_start_matches('#');
        let schema = root.pointer(place).unwrap_or_else(|| panic!("no {place}"));
        return compare(value, schema, root, (at, place), errors, seen);
    }
    if let Some(all) = schema["anyOf"].as_array() {
        let found = all.iter().any(|one| {
            let mut other = Vec::new();
            compare(value, one, root, (at, place), &mut other, seen);
            other.is_empty()
        });
        if !found {
            errors.push(format!("{at}: {value} is none of {}", schema["anyOf"]));
        }
        return;
    }
    let mut refuse = |is_right: bool, keyword: &str| {
        if !is_right {
            errors.push(format!("{at}: {value} is not of {keyword} {}", schema[keyword]));
        }
    };
    let types: Vec<&str> = match &schema["type"] {
        Value::Array(all) => all.iter().filter_map(Value::as_str).collect(),
        one => one.as_str().into_iter().collect(),
    };
    refuse(types.is_empty() || types.iter().any(|name| is_of(value, name)), "type");
    refuse(schema.get("enum").is_none_or(|all| all.as_array().unwrap().contains(value)), "enum");
    refuse(schema.get("const").is_none_or(|one| one == value), "const");
    let items = value.as_array().map_or(0, Vec::len) as u64;
    refuse(!value.is_array() || schema["minItems"].as_u64().is_none_or(|least| items >= least), "minItems");
    if !value.is_null() {
        seen.insert(place.into());
    }
    for (index, item) in value.as_array().into_iter().flatten().enumerate() {
        compare(item, &schema["items"], root, (&format!("{at}/{index}"), &format!("{place}/items")), errors, seen);
    }
    let Some(fields) = value.as_object() else { return };
    for name in schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str) {
        if !fields.contains_key(name) {
            errors.push(format!("{at}: {name} is missing"));
        }
    }
    for (name, field) in fields {
        let (at, known) = (format!("{at}/{name}"), &schema["properties"][name]);
        if known.is_object() {
            compare(field, known, root, (&at, &format!("{place}/properties/{name}")), errors, seen);
        } else if schema["additionalProperties"].is_object() {
            let place = format!("{place}/additionalProperties");
            compare(field, &schema["additionalProperties"], root, (&at, &place), errors, seen);
        } else {
            errors.push(format!("{at} is not in the schema"));
        }
    }
}

fn is_of(value: &Value, name: &str) -> bool {
    match name {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "integer" => value.is_i64() || value.is_u64(),
        "number" => value.is_number(),
        "string" => value.is_string(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        other => panic!("no type {other}"),
    }
}

/// Every field that the schema describes, with its place; for arrays and maps, the fields of their
/// elements.
pub(crate) fn places(schema: &Value, place: &str, places: &mut Vec<String>) {
    let Some(parts) = schema.as_object() else { return };
    let unknown = parts.keys().find(|keyword| !KEYWORDS.contains(&keyword.as_str()) && *keyword != "minimum");
    assert_eq!(unknown.filter(|keyword| *keyword != "maxItems"), None, "a keyword that is not checked, at {place}");
    for (name, field) in schema["properties"].as_object().into_iter().flatten() {
        let place = format!("{place}/properties/{name}");
        assert!(field["description"].as_str().is_some_and(|text| text.len() > 3), "{place} is not described");
        let is_own = field.get("$ref").is_none() && field.get("anyOf").is_none();
        places.extend(is_own.then(|| place.clone()));
        self::places(field, &place, places);
    }
    self::places(&schema["items"], &format!("{place}/items"), places);
    self::places(&schema["additionalProperties"], &format!("{place}/additionalProperties"), places);
    for (name, definition) in schema["$defs"].as_object().into_iter().flatten() {
        self::places(definition, &format!("/$defs/{name}"), places);
    }
}
