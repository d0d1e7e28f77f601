//! Objects of the site from JSON documents, with every field that is wrong.

use super::fields::{FieldProblem, parse_problem, unknown_fields};
use crate::limits::FIXED;
use crate::texts;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use site_model::{Edit, Object, ObjectId, ObjectKind};

/// Calls `$use` with the type of the object and its variant for a kind.
macro_rules! with_type {
    ($kind:expr, $use:ident) => {
        match $kind {
            ObjectKind::Settings => $use!(Settings),
            ObjectKind::Node => $use!(Node),
            ObjectKind::Edge => $use!(Edge),
            ObjectKind::EdgeBlock => $use!(EdgeBlock),
            ObjectKind::Zone => $use!(Zone),
            ObjectKind::Dock => $use!(Dock),
            ObjectKind::Asset => $use!(Asset),
            ObjectKind::InspectionPoint => $use!(InspectionPoint),
            ObjectKind::Mission => $use!(Mission),
            ObjectKind::Schedule => $use!(Schedule),
            ObjectKind::Monitor => $use!(Monitor),
            ObjectKind::MutexHold => $use!(MutexHold),
            ObjectKind::SceneChange => $use!(SceneChange),
            ObjectKind::Alert => $use!(Alert),
        }
    };
}

/// An object of this kind from its document.
///
/// # Errors
/// All that is wrong, where that can be found at once.
pub(crate) fn object(kind: ObjectKind, document: &Value) -> Result<Object, Vec<FieldProblem>> {
    macro_rules! parse {
        ($variant:ident) => {
            understood(document).map(Object::$variant)
        };
    }
    with_type!(kind, parse)
}

/// An edit from its document.
///
/// # Errors
/// As for [`object`].
pub(crate) fn edit(document: &Value) -> Result<Edit, Vec<FieldProblem>> {
    understood(document)
}

/// The document of an object, without the name of its kind.
pub(crate) fn document(object: &Object) -> Value {
    let tagged = serde_json::to_value(object).unwrap_or_default();
    match tagged {
        Value::Object(fields) => fields.into_iter().next().map(|(_, inner)| inner).unwrap_or_default(),
        other => other,
    }
}

/// JSON of a request's body.
///
/// # Errors
/// Where it is no JSON.
pub(crate) fn json(bytes: &[u8]) -> Result<Value, Vec<FieldProblem>> {
    let mut deserializer = serde_json::Deserializer::from_slice(bytes);
    let value = serde_path_to_error::deserialize(&mut deserializer);
    let value = value.map_err(|error| vec![parse_problem(&error)])?;
    deserializer.end().map_err(|error| vec![FieldProblem::new("", error.to_string())])?;
    Ok(value)
}

/// A document of a request whose type knows all of its fields.
///
/// # Errors
/// Where it is no JSON, or the field that is wrong.
pub(crate) fn read_document<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, Vec<FieldProblem>> {
    serde_path_to_error::deserialize(&json(bytes)?).map_err(|error| vec![parse_problem(&error)])
}

/// Whether a JSON document takes little more memory than its length once it is parsed: it has not too many values, and no string that is longer than an object may be.
/// Commas and brackets within strings count too.
pub(crate) fn is_of_bounded_size(json: &[u8]) -> bool {
    let values = json.iter().filter(|byte| matches!(byte, b',' | b'[' | b'{')).count();
    let longest = json.split(|byte| *byte == b'"').map(<[u8]>::len).max().unwrap_or(0);
    values <= FIXED.max_edit_values && longest <= FIXED.max_object_json_bytes
}

fn understood<T: DeserializeOwned + Serialize>(document: &Value) -> Result<T, Vec<FieldProblem>> {
    let parsed: T =
        serde_path_to_error::deserialize(document).map_err(|error| vec![parse_problem(&error)])?;
    let unknown = unknown_fields(document, &serde_json::to_value(&parsed).unwrap_or_default());
    if unknown.is_empty() { Ok(parsed) } else { Err(unknown) }
}

/// Name of the field that holds an object's id; none for the settings.
fn id_field(kind: ObjectKind) -> Option<&'static str> {
    match kind {
        ObjectKind::Settings => None,
        ObjectKind::EdgeBlock => Some("edge"),
        _ => Some("id"),
    }
}

/// Writes the id of an object into its document, where it has none.
///
/// # Errors
/// When the document has another one, or is no object.
pub(crate) fn set_id(document: &mut Value, id: ObjectId) -> Result<(), Vec<FieldProblem>> {
    let Value::Object(fields) = document else {
        return Err(vec![FieldProblem::new("", texts::DOCUMENT_NOT_OBJECT)]);
    };
    let Some(name) = id_field(id.kind()) else { return Ok(()) };
    let expected = Value::from(id.uuid().to_string());
    match fields.get(name) {
        None => drop(fields.insert(name.to_owned(), expected)),
        Some(given) if *given == expected => {}
        Some(_) => return Err(vec![FieldProblem::new(format!("/{name}"), texts::OTHER_ID)]),
    }
    Ok(())
}

/// The id that a document has, if it has a valid one.
///
/// # Errors
/// When it has one that is not valid.
pub(crate) fn id_of(kind: ObjectKind, document: &Value) -> Result<Option<ObjectId>, Vec<FieldProblem>> {
    let Some(name) = id_field(kind) else { return Ok(Some(ObjectId::Settings)) };
    let Some(given) = document.get(name) else { return Ok(None) };
    let id = given.as_str().and_then(|text| text.parse().ok());
    let malformed = || vec![FieldProblem::new(format!("/{name}"), texts::OBJECT_ID_MALFORMED)];
    id.map(|id| Some(ObjectId::new(kind, id))).ok_or_else(malformed)
}

/// A document after a JSON merge patch (RFC 7396).
pub(crate) fn merge_patch(document: &mut Value, patch: &Value) {
    let Value::Object(changes) = patch else {
        patch.clone_into(document);
        return;
    };
    if !document.is_object() {
        *document = Value::Object(serde_json::Map::new());
    }
    if let Value::Object(fields) = document {
        for (key, change) in changes {
            match change {
                Value::Null => drop(fields.remove(key)),
                change => merge_patch(fields.entry(key.as_str()).or_insert(Value::Null), change),
            }
        }
    }
}
