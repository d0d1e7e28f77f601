//! Names of objects in paths, and the headers of conditional requests.

use crate::problem::ProblemResponse;
use crate::texts;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use site_model::{EditId, ObjectId, ObjectKind, Revision};
use std::collections::hash_map::RandomState;
use std::hash::{BuildHasher, Hasher};
use uuid::Uuid;

/// Id of the settings in paths: there is one.
const SETTINGS_ID: &str = "main";

/// A kind as paths name it: `inspection-points`.
pub(crate) fn kind_path(kind: ObjectKind) -> &'static str {
    match kind {
        ObjectKind::Settings => "settings",
        ObjectKind::Node => "nodes",
        ObjectKind::Edge => "edges",
        ObjectKind::EdgeBlock => "edge-blocks",
        ObjectKind::Zone => "zones",
        ObjectKind::Dock => "docks",
        ObjectKind::Asset => "assets",
        ObjectKind::InspectionPoint => "inspection-points",
        ObjectKind::Mission => "missions",
        ObjectKind::Schedule => "schedules",
        ObjectKind::Monitor => "monitors",
        ObjectKind::MutexHold => "mutex-holds",
        ObjectKind::SceneChange => "scene-changes",
        ObjectKind::Alert => "alerts",
    }
}

/// The kind that a path names.
pub(crate) fn kind(name: &str) -> Result<ObjectKind, ProblemResponse> {
    let found = ObjectKind::ALL.into_iter().find(|kind| kind_path(*kind) == name);
    found.ok_or_else(|| ProblemResponse::not_found(texts::no_kind(name)))
}

/// The object that a path names.
pub(crate) fn object_id(kind_name: &str, id: &str) -> Result<ObjectId, ProblemResponse> {
    let kind = kind(kind_name)?;
    if kind == ObjectKind::Settings {
        let is_settings = id == SETTINGS_ID;
        return is_settings
            .then_some(ObjectId::Settings)
            .ok_or_else(|| ProblemResponse::not_found(texts::SETTINGS_ID_MALFORMED));
    }
    let id = id.parse().map_err(|_| ProblemResponse::malformed(texts::OBJECT_ID_MALFORMED))?;
    Ok(ObjectId::new(kind, id))
}

/// Path of an object.
pub(crate) fn path_of(id: ObjectId) -> String {
    let name = match id {
        ObjectId::Settings => SETTINGS_ID.to_owned(),
        id => id.uuid().to_string(),
    };
    format!("{}/{}/{name}", api::paths::SITE_PATH, kind_path(id.kind()))
}

/// The entity tag of a revision.
pub(crate) fn etag(revision: Revision) -> HeaderValue {
    HeaderValue::try_from(format!("\"{revision}\"")).unwrap_or(HeaderValue::from_static("\"0\""))
}

/// What a request says about the revision that it is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Condition {
    /// Nothing.
    None,
    /// Any that is there.
    Any,
    /// This one.
    Revision(Revision),
}

/// The `If-Match` of a request.
pub(crate) fn if_match(headers: &HeaderMap) -> Result<Condition, ProblemResponse> {
    let Some(value) = headers.get(header::IF_MATCH) else { return Ok(Condition::None) };
    let malformed = || ProblemResponse::malformed(texts::IF_MATCH_MALFORMED);
    let text = value.to_str().map_err(|_| malformed())?.trim();
    if text == "*" {
        return Ok(Condition::Any);
    }
    let number = text.trim_start_matches("W/").strip_prefix('"').and_then(|text| text.strip_suffix('"'));
    let number = number.and_then(|number| number.parse().ok()).ok_or_else(malformed)?;
    Ok(Condition::Revision(Revision(number)))
}

/// Whether the request is for an object that must not be there yet.
pub(crate) fn must_be_new(headers: &HeaderMap) -> bool {
    headers.get(header::IF_NONE_MATCH).is_some_and(|value| value.as_bytes() == b"*")
}

/// The id of the edit that a request makes: its `Idempotency-Key`, or a new one.
pub(crate) fn edit_id(headers: &HeaderMap) -> Result<EditId, ProblemResponse> {
    let Some(value) = headers.get("idempotency-key") else { return Ok(EditId(new_id())) };
    let text = value.to_str().ok().map(|text| text.trim().trim_matches('"'));
    let malformed = || ProblemResponse::new(StatusCode::BAD_REQUEST, texts::IDEMPOTENCY_KEY_MALFORMED);
    text.and_then(|text| text.parse().ok()).map(EditId).ok_or_else(malformed)
}

/// An id that differs from all others: the standard library draws the keys of its hashes from the system's random numbers.
pub(crate) fn new_id() -> Uuid {
    let draw = || RandomState::new().build_hasher().finish().to_be_bytes();
    let (high, low) = (draw(), draw());
    let mut bytes = [0; 16];
    bytes[..8].copy_from_slice(&high);
    bytes[8..].copy_from_slice(&low);
    uuid::Builder::from_random_bytes(bytes).into_uuid()
}
