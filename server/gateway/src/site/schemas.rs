//! Schemas of the documents of the site. The objects themselves are described in `docs/api/site.md`.
#![allow(dead_code, reason = "some are described only, never made")]

use serde::Serialize;
use serde_json::Value;
use site_model::ObjectStay;
use std::collections::BTreeMap;
use utoipa::ToSchema;

/// The site.
#[derive(Serialize, ToSchema)]
#[schema(as = Site)]
pub(crate) struct SiteDocument {
    /// Number of edits since the site began.
    pub(crate) revision: u64,
    /// Number of objects of each kind.
    pub(crate) objects: BTreeMap<String, u64>,
    /// The first hundred problems.
    pub(crate) problems: Vec<SiteProblemDocument>,
    /// Number of all problems.
    pub(crate) problem_count: u64,
}

/// Something that is wrong with an object.
#[derive(Serialize, ToSchema)]
#[schema(as = SiteProblem)]
pub(crate) struct SiteProblemDocument {
    /// Path of the object.
    pub(crate) path: String,
    /// `warning`, or `error`: the object cannot be used.
    pub(crate) severity: String,
    /// What is wrong.
    pub(crate) detail: String,
}

/// A page of objects.
#[derive(Serialize, ToSchema)]
#[schema(as = ObjectList)]
pub(crate) struct ObjectListDocument {
    /// Revision of the site.
    pub(crate) revision: u64,
    /// The objects.
    pub(crate) items: Vec<VersionedDocument>,
    /// `after` of the next page; null: there is none.
    pub(crate) next: Option<String>,
}

/// An object with its revision.
#[derive(Serialize, ToSchema)]
#[schema(as = VersionedObject)]
pub(crate) struct VersionedDocument {
    /// Its revision.
    pub(crate) revision: u64,
    /// The object.
    #[schema(value_type = Object)]
    pub(crate) object: Value,
    /// Of a change: where its thing was, the earliest first.
    #[schema(value_type = Option<Vec<Object>>)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) history: Option<Vec<ObjectStay>>,
}

/// A page of revisions.
#[derive(Serialize, ToSchema)]
#[schema(as = RevisionList)]
pub(crate) struct RevisionListDocument {
    /// The revisions, the newest first.
    pub(crate) items: Vec<RevisionDocument>,
    /// `before` of the next page; null: there is none.
    pub(crate) next: Option<u64>,
}

/// A state of an object.
#[derive(Serialize, ToSchema)]
#[schema(as = StoredRevision)]
pub(crate) struct RevisionDocument {
    /// Its revision.
    pub(crate) revision: u64,
    /// The object; null: it was removed.
    #[schema(value_type = Option<Object>)]
    pub(crate) object: Option<Value>,
    /// Who made it; null: the robot itself.
    #[schema(value_type = Option<Object>)]
    pub(crate) author: Option<Value>,
    /// When, nanoseconds since the Unix epoch.
    pub(crate) at: i64,
}

/// What was removed.
#[derive(Serialize, ToSchema)]
#[schema(as = Removal)]
pub(crate) struct RemovalDocument {
    /// Paths of the removed objects.
    pub(crate) removed: Vec<String>,
    /// Paths of the missions that needed the object. They have problems now.
    pub(crate) missions: Vec<String>,
}

/// Changes that are made together or not at all.
#[derive(ToSchema)]
#[schema(as = Edit)]
pub(crate) struct EditDocument {
    /// Made by the client.
    #[schema(format = Uuid)]
    id: String,
    /// Each is `{"put": {"base": REVISION, "object": {"KIND": OBJECT}}}`, with null for a new object, or
    /// `{"remove": {"base": REVISION, "object": {"KIND": ID}}}`.
    #[schema(value_type = Vec<Object>)]
    changes: Vec<Value>,
}

/// What an edit did.
#[derive(Serialize, ToSchema)]
#[schema(as = EditResult)]
pub(crate) struct EditResultDocument {
    /// Revision of the site after it.
    pub(crate) revision: u64,
    /// Revisions of the changed objects before and after it, in the order of the changes.
    #[schema(value_type = Vec<Object>)]
    pub(crate) changes: Value,
}

/// An error that names fields, RFC 9457.
#[derive(ToSchema)]
#[schema(as = FieldsProblem)]
pub(crate) struct FieldsProblemDocument {
    /// HTTP status.
    status: u16,
    /// The kind of problem, short.
    title: String,
    /// This case: what, where and what to do.
    detail: String,
    /// What is wrong with which field.
    errors: Option<Vec<FieldProblemDocument>>,
    /// The object as it is with its revision, where somebody else has changed it; null: it was removed.
    #[schema(value_type = Option<Object>)]
    current: Option<Value>,
    /// The object as the request would have made it.
    #[schema(value_type = Option<Object>)]
    yours: Option<Value>,
}

/// What is wrong with one field.
#[derive(ToSchema)]
#[schema(as = FieldProblem)]
pub(crate) struct FieldProblemDocument {
    /// JSON pointer (RFC 6901) of the field; empty for the whole document.
    pointer: String,
    /// What is wrong.
    detail: String,
}
