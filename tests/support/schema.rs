//! Checks documents against their schema: only the part of JSON Schema that it uses.

use std::collections::BTreeSet;

use serde_json::Value;

const KEYWORDS: [&str; 20] = [
    "$schema",
    "$defs",
    "$ref",
    "title",
    "description",
    "type",
    "const",
    "properties",
    "patternProperties",
    "required",
    "additionalProperties",
    "items",
    "prefixItems",
    "anyOf",
    "oneOf",
    // of the types of this program, and not checked
    "format",
    "minimum",
    "maximum",
    "minItems",
    "maxItems",
];

const NAMES: [&str; 2] = ["vn100.analysis/2", "vn100.progress/2"];

/// The schema of documents of measurements.
pub(crate) fn analysis() -> Value {
    vn100_report::analysis_schema().to_value()
}

/// The schema of lines about a measurement in progress.
pub(crate) fn progress() -> Value {
    vn100_report::progress_schema().to_value()
}

/// Checks documents of measurements, alone or among others in an array.
#[track_caller]
pub(crate) fn check(document: &Value) {
    for document in document.as_array().unwrap_or(&vec![document.clone()]) {
        if NAMES.iter().any(|name| document["schema"] == *name) {
            let errors = errors(document, &mut BTreeSet::new());
            assert!(errors.is_empty(), "not as the schema has it:\n{}", errors.join("\n"));
        }
    }
}

/// What is not as the schema has it. `seen` takes the places of the fields that held a value.
pub(crate) fn errors(document: &Value, seen: &mut BTreeSet<String>) -> Vec<String> {
    let root = if document["schema"] == NAMES[1] { progress() } else { analysis() };
    let mut errors = Vec::new();
    Check { root: &root, errors: &mut errors, seen }.whole(document, &root, ("", ""));
    errors
}

struct Check<'a> {
    root: &'a Value,
    errors: &'a mut Vec<String>,
    seen: &'a mut BTreeSet<String>,
}

impl Check<'_> {
    /// A value at its place in the document, by the schema at its place among the schemas.
    fn whole(&mut self, value: &Value, schema: &Value, (at, place): (&str, &str)) {
        let known = self.known(value, schema, (at, place));
        let unknown =
            value.as_object().into_iter().flat_map(|fields| fields.keys()).find(|name| !known.contains(*name));
        self.errors.extend(unknown.map(|name| format!("{at}/{name} is not in the schema")));
    }

    /// The fields that the schema has.
    fn known(&mut self, value: &Value, schema: &Value, (at, place): (&str, &str)) -> BTreeSet<String> {
        let mut known = BTreeSet::new();
        if let Some(reference) = schema["$ref"].as_str() {
            let place = reference.trim_start_matches('#');
            let target = self.root.pointer(place).unwrap_or_else(|| panic!("no {place}"));
            known.extend(self.known(value, target, (at, place)));
        }
        for keyword in ["anyOf", "oneOf"] {
            let Some(all) = schema[keyword].as_array() else { continue };
            let mut fits = false;
            for (number, one) in all.iter().enumerate() {
                let mut errors = Vec::new();
                let mut check = Check { root: self.root, errors: &mut errors, seen: self.seen };
                let fields = check.known(value, one, (at, &format!("{place}/{keyword}/{number}")));
                if errors.is_empty() {
                    fits = true;
                    known.extend(fields);
                }
            }
            self.refuse(fits, || format!("{at}: {value} is none of {}", schema[keyword]));
        }
        let types: Vec<&str> = match &schema["type"] {
            Value::Array(all) => all.iter().filter_map(Value::as_str).collect(),
            one => one.as_str().into_iter().collect(),
        };
        self.refuse(types.is_empty() || types.iter().any(|name| is_of(value, name)), || {
            format!("{at}: {value} is not of {types:?}")
        });
        self.refuse(schema.get("const").is_none_or(|one| one == value), || {
            format!("{at}: {value} is another constant")
        });
        for (index, item) in value.as_array().into_iter().flatten().enumerate() {
            let at = format!("{at}/{index}");
            match schema["prefixItems"].get(index) {
                Some(schema) => self.whole(item, schema, (&at, &format!("{place}/prefixItems/{index}"))),
                None if schema["items"].is_object() => {
                    self.whole(item, &schema["items"], (&at, &format!("{place}/items")));
                }
                None => {}
            }
        }
        let Some(fields) = value.as_object() else { return known };
        for name in schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str) {
            self.refuse(fields.contains_key(name), || format!("{at}: {name} is missing"));
        }
        let others = [&schema["additionalProperties"], &schema["patternProperties"]];
        let other = others.into_iter().find(|other| other.as_object().is_some_and(|other| !other.is_empty()));
        for (name, field) in fields {
            let at = format!("{at}/{name}");
            if let Some(schema) = schema["properties"].get(name) {
                let place = format!("{place}/properties/{name}");
                self.whole(field, schema, (&at, &place));
                if !field.is_null() {
                    self.seen.insert(place);
                }
                known.insert(name.clone());
            } else if let Some(other) = other {
                self.whole(field, other, (&at, &format!("{place}/additionalProperties")));
                known.insert(name.clone());
            }
        }
        known
    }

    fn refuse(&mut self, is_right: bool, error: impl FnOnce() -> String) {
        self.errors.extend((!is_right).then(error));
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

/// Every field that the schema describes, with its place.
pub(crate) fn places(schema: &Value, place: &str, places: &mut Vec<String>) {
    let Some(parts) = schema.as_object() else { return };
    let unknown = parts.keys().find(|keyword| !KEYWORDS.contains(&keyword.as_str()));
    assert_eq!(unknown, None, "a keyword that is not checked, at {place}");
    for (name, field) in schema["properties"].as_object().into_iter().flatten() {
        let place = format!("{place}/properties/{name}");
        assert!(field["description"].as_str().is_some_and(|text| text.len() > 3), "{place} is not described");
        places.push(place.clone());
        self::places(field, &place, places);
    }
    for keyword in ["items", "additionalProperties"] {
        self::places(&schema[keyword], &format!("{place}/{keyword}"), places);
    }
    for keyword in ["anyOf", "oneOf", "prefixItems"] {
        for (number, one) in schema[keyword].as_array().into_iter().flatten().enumerate() {
            self::places(one, &format!("{place}/{keyword}/{number}"), places);
        }
    }
    for (name, definition) in schema["$defs"].as_object().into_iter().flatten() {
        self::places(definition, &format!("/$defs/{name}"), places);
    }
}
