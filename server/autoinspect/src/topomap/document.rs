//! The objects of a topological map as a document, JSON or YAML.

use crate::failure::Failure;
use api::MapSummary;
use serde::Serialize;
use serde_json::Value;
use site_model::Object;
use std::fmt::Write;
use topomap::GeneratedMap;
use vocab::MapId;

/// Version of the document.
const FORMAT_VERSION: u32 = 1;

/// The document.
#[derive(Debug, Serialize)]
struct Document<'a> {
    format_version: u32,
    /// The map to which all poses refer.
    map: MapId,
    name: &'a str,
    objects: Vec<Object>,
}

fn document<'a>(summary: &'a MapSummary, made: &GeneratedMap) -> Document<'a> {
    Document {
        format_version: FORMAT_VERSION,
        map: summary.id,
        name: &summary.name,
        objects: made.objects().collect(),
    }
}

/// As JSON.
pub fn json(summary: &MapSummary, made: &GeneratedMap) -> Result<String, Failure> {
    let text = serde_json::to_string_pretty(&document(summary, made)).map_err(Failure::failed)?;
    Ok(text + "\n")
}

/// As YAML.
pub fn yaml(summary: &MapSummary, made: &GeneratedMap) -> Result<String, Failure> {
    let value = serde_json::to_value(document(summary, made)).map_err(Failure::failed)?;
    let mut text = String::new();
    write_block(&mut text, &value, 0);
    Ok(text)
}

/// Writes a value as YAML in block style. Scalars are those of JSON, which YAML 1.2 includes.
fn write_block(text: &mut String, value: &Value, indent: usize) {
    let pad = " ".repeat(indent);
    match value {
        Value::Object(fields) => {
            for (key, value) in fields {
                let _ = write!(text, "{pad}{}:", scalar(&Value::String(key.clone())));
                write_after(text, value, indent + 2);
            }
        }
        Value::Array(values) => {
            for value in values {
                let _ = write!(text, "{pad}-");
                write_after(text, value, indent + 2);
            }
        }
        other => {
            let _ = writeln!(text, "{pad}{}", scalar(other));
        }
    }
}

/// Writes a value after its key or dash.
fn write_after(text: &mut String, value: &Value, indent: usize) {
    let is_empty = value.as_object().is_some_and(|fields| fields.is_empty())
        || value.as_array().is_some_and(|values| values.is_empty());
    if (value.is_object() || value.is_array()) && !is_empty {
        text.push('\n');
        write_block(text, value, indent);
    } else {
        let _ = writeln!(text, " {}", scalar(value));
    }
}

/// A scalar, or an empty collection. Names of fields stand without quotes.
fn scalar(value: &Value) -> String {
    match value {
        Value::String(name)
            if name.starts_with(|c: char| c.is_ascii_lowercase())
                && name.chars().all(|c| c.is_ascii_lowercase() || c == '_')
                && !["true", "false", "null", "yes", "no", "on", "off", "y", "n"]
                    .contains(&name.as_str()) =>
        {
            name.clone()
        }
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn yaml_is_in_block_style_and_quotes_what_could_be_misread() {
        let value = json!({
            "map": "a: b",
            "y": 1.5,
            "list": [{"name": "yes", "empty": []}, [1, 2], null],
        });
        let mut text = String::new();
        write_block(&mut text, &value, 0);
        let expected = "list:\n  -\n    empty: []\n    name: \"yes\"\n  -\n    - 1\n    - 2\n  - null\nmap: \"a: b\"\n\"y\": 1.5\n";
        assert_eq!(text, expected);
    }
}
