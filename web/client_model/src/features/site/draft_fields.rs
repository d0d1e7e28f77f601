//! Which fields of an object differ, as a person reads them.

use serde_json::Value;
use site_model::Object;
use std::collections::BTreeMap;
use uuid::Uuid;

/// Parameters of the values that a draft shows.
struct FieldTextConfig {
    /// Entries of a list that are written out; longer lists are counted. Chosen: they fit into the card's line.
    max_listed: usize,
    /// Longest text of a value, characters. Chosen: a line of the card.
    max_chars: usize,
}

const CONFIG: FieldTextConfig = FieldTextConfig { max_listed: 4, max_chars: 60 };

/// A field that differs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FieldChange {
    /// Its name, as `corridor left (m)`.
    pub field: String,
    /// What it was; empty: nothing.
    pub before: String,
    /// What it is; empty: nothing.
    pub after: String,
}

/// The fields in which two states of an object differ, by name. `name_of`: the name of the object of an id.
pub fn field_changes(
    before: &Object,
    after: &Object,
    name_of: &dyn Fn(Uuid) -> Option<String>,
) -> Vec<FieldChange> {
    let [before, after] = [before, after].map(|object| fields(object, name_of));
    let all: BTreeMap<&String, ()> = before.keys().chain(after.keys()).map(|field| (field, ())).collect();
    let text =
        |fields: &BTreeMap<String, String>, field: &String| fields.get(field).cloned().unwrap_or_default();
    all.into_keys()
        .map(|field| FieldChange {
            field: field.clone(),
            before: text(&before, field),
            after: text(&after, field),
        })
        .filter(|change| change.before != change.after)
        .collect()
}

fn fields(object: &Object, name_of: &dyn Fn(Uuid) -> Option<String>) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    // An object is a map of one entry, its kind.
    if let Ok(Value::Object(kinds)) = serde_json::to_value(object) {
        kinds.into_iter().for_each(|(_, value)| collect("", &value, name_of, &mut found));
    }
    found
}

fn collect(
    path: &str,
    value: &Value,
    name_of: &dyn Fn(Uuid) -> Option<String>,
    found: &mut BTreeMap<String, String>,
) {
    match value {
        Value::Object(map) if map.len() > 1 && as_vector(value).is_none() => {
            for (key, value) in map {
                // The pose of a node is the node's own.
                let key = if key == "map_from_node" { "" } else { key };
                let joint = if path.is_empty() || key.is_empty() { "" } else { " " };
                collect(&format!("{path}{joint}{key}"), value, name_of, found);
            }
        }
        value => {
            found.insert(label(path), text(value, name_of));
        }
    }
}

/// A path as words, with its unit in brackets.
fn label(path: &str) -> String {
    let units = [("_m_s", " (m/s)"), ("_m", " (m)"), ("_rad", " (rad)"), ("_s", " (s)")];
    let (stem, unit) = units
        .iter()
        .find_map(|(suffix, unit)| Some((path.strip_suffix(suffix)?, *unit)))
        .unwrap_or((path, ""));
    format!("{}{unit}", stem.replace('_', " "))
}

fn text(value: &Value, name_of: &dyn Fn(Uuid) -> Option<String>) -> String {
    if let Some(vector) = as_vector(value) {
        return vector;
    }
    let text = match value {
        Value::Null => String::new(),
        Value::Bool(yes) => (if *yes { "yes" } else { "no" }).to_owned(),
        Value::Number(number) => number.as_f64().map_or_else(|| number.to_string(), short),
        Value::String(text) => text.parse().ok().and_then(name_of).unwrap_or_else(|| text.replace('_', " ")),
        Value::Array(items) if items.len() > CONFIG.max_listed => format!("{} entries", items.len()),
        Value::Array(items) => items.iter().map(|item| text(item, name_of)).collect::<Vec<_>>().join(", "),
        Value::Object(map) => {
            let part = |(key, value): (&String, &Value)| format!("{} {}", label(key), text(value, name_of));
            map.iter().map(part).collect::<Vec<_>>().join(", ")
        }
    };
    match text.char_indices().nth(CONFIG.max_chars) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

/// Positions as coordinates, and orientations as a heading; `None` for anything else.
fn as_vector(value: &Value) -> Option<String> {
    let number = |key: &str| value.get(key).and_then(Value::as_f64);
    let [x, y, z] = [number("x")?, number("y")?, number("z")?];
    match number("w") {
        Some(w) => {
            let yaw = (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z));
            Some(format!("{}°", short(yaw.to_degrees().round() + 0.0)))
        }
        None => Some([x, y, z].map(short).join(", ")),
    }
}

/// A number with two digits after the point at most.
fn short(number: f64) -> String {
    let rounded = (number * 100.0).round() / 100.0 + 0.0;
    format!("{rounded}")
}
