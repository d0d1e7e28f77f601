//! The documents of the site over HTTP. They are read from the snapshot; changes are edits that the core applies and makes durable before they are answered.

mod action_parameters;
mod edits;
mod fields;
mod objects;
mod parse;
mod paths;
mod requests;
mod revisions;
mod scene_changes;
pub(crate) mod schemas;

pub(crate) use action_parameters::ActionSchemas;
pub(crate) use fields::FieldProblem;
pub(crate) use objects::site;
pub(crate) use parse::{document, read_document};
pub(crate) use paths::new_id;
pub(crate) use requests::SiteRequests;
pub(crate) use revisions::ask;

pub(crate) mod handlers {
    //! What the router and the description refer to.
    pub(crate) use super::edits::*;
    pub(crate) use super::objects::*;
    pub(crate) use super::revisions::*;
    pub(crate) use super::scene_changes::*;
}
