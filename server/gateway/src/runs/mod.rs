//! Runs of missions over HTTP: what runs now, what has run, with its steps and results, and what can be asked of runs. The core decides.

mod archive;
mod clouds;
mod commands;
mod comparison;
mod documents;
mod download;
#[cfg(test)]
mod fake_core;
mod lists;
mod mcap;
mod mcap_schemas;
mod names;
mod stored_content;
mod streamed_file;

pub(crate) use download::stored_run;
pub(crate) use names::{run_file_name, utc};
pub(crate) use stored_content::{
    CoreQueries, action_report, for_each_result, for_each_step, result_page, stored_json,
};
pub(crate) use streamed_file::FileStream;

pub(crate) mod handlers {
    //! What the router and the description refer to.
    pub(crate) use super::clouds::*;
    pub(crate) use super::commands::*;
    pub(crate) use super::comparison::*;
    pub(crate) use super::download::*;
    pub(crate) use super::lists::*;
}

use crate::documents::AnyPath;
use crate::problem::ProblemResponse;
use crate::texts;
use axum::extract::Path;
use site_model::RunId;

/// The run that a path names.
pub(crate) fn run_id(path: AnyPath) -> Result<RunId, ProblemResponse> {
    let malformed = || ProblemResponse::malformed(texts::RUN_ID_MALFORMED);
    let Path(id) = path.map_err(|_| malformed())?;
    id.parse().map_err(|_| malformed())
}
