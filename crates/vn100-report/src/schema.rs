//! The JSON Schema of a type, with the words of its code.

use schemars::{JsonSchema, Schema, generate::SchemaSettings, transform::RecursiveTransform};
use serde_json::Value;

/// The schema (2020-12) of a type as it is written.
pub(crate) fn schema_of<T: JsonSchema>() -> Schema {
    let settings = SchemaSettings::draft2020_12().for_serialize().with_transform(RecursiveTransform(described));
    settings.into_generator().into_root_schema_for::<T>()
}

/// Puts the words of the code into the document; a field without any takes those of its variant.
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
