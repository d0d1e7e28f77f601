//! The example over HTTP: a site to try is made on request, and its progress is told. The core does the work.

use crate::app::App;
use crate::documents::Answer;
use crate::json_response::json;
use crate::maps::{perform, stored};
use crate::problem::ProblemResponse;
use crate::runs::handlers::parse;
use crate::schemas::ProblemDocument;
use crate::site::new_id;
use api::{Command, Import, ImportStage};
use axum::body::Bytes;
use axum::extract::State;
use axum::extract::rejection::BytesRejection;
use axum::http::StatusCode;
use axum::response::IntoResponse;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use utoipa::ToSchema;
use vocab::{MapId, UploadId};

/// Which example is wanted.
#[derive(Deserialize, ToSchema)]
#[schema(as = ExampleRequest)]
#[serde(deny_unknown_fields)]
pub(crate) struct ExampleRequestDocument {
    /// Time zone of its schedule, a name of the IANA database; UTC if it is left out.
    #[serde(default = "utc")]
    time_zone: String,
}

/// An example that is made.
#[derive(Serialize, ToSchema)]
#[schema(as = RequestedExample)]
pub(crate) struct RequestedExampleDocument {
    /// Name of this work, a UUID; DELETE /api/v1/example cancels whichever runs.
    #[schema(value_type = String)]
    work: UploadId,
}

impl RequestedExampleDocument {
    /// Of this work.
    pub(crate) fn new(work: UploadId) -> Self {
        Self { work }
    }
}

/// How far the making of the example is.
#[derive(Serialize, ToSchema)]
#[schema(as = ExampleProgress)]
#[serde(rename_all = "snake_case")]
pub(crate) enum ExampleProgressDocument {
    /// Nothing was made since the start.
    None {},
    /// It is being made, or another map is imported.
    Running {
        /// `walking`, `writing` or `making_topomap`.
        #[schema(value_type = String)]
        stage: ImportStage,
        /// Share of the stage that is done, 0 to 1.
        share: f32,
    },
    /// It is there.
    Done {
        /// Its map, a UUID.
        #[schema(value_type = String)]
        map: MapId,
    },
    /// It could not be made.
    Failed {
        /// Why, one sentence.
        reason: String,
    },
}

fn utc() -> String {
    "UTC".to_owned()
}

/// Makes the example: map, topological map, nine inspection points, a mission and a schedule.
#[utoipa::path(post, path = api::paths::EXAMPLE_PATH, tag = "example", operation_id = "makeExample",
    request_body(content = ExampleRequestDocument, example = json!({ "time_zone": "Europe/London" })),
    responses(
    (status = 202, body = RequestedExampleDocument, description = "It is begun, and takes about a minute; a GET tells how far it is and why it failed"),
    (status = 400, body = ProblemDocument, content_type = "application/problem+json", description = "The document is malformed"),
    (status = 409, body = ProblemDocument, content_type = "application/problem+json", description = "A map is being made already"),
    (status = 413, body = ProblemDocument, content_type = "application/problem+json", description = "The document is too long"),
    (status = 503, body = ProblemDocument, content_type = "application/problem+json", description = "The core is not connected"),
    (status = 504, body = ProblemDocument, content_type = "application/problem+json", description = "The core has not answered yet"),
))]
pub(crate) async fn make(State(app): State<Arc<App>>, body: Result<Bytes, BytesRejection>) -> Answer {
    let ExampleRequestDocument { time_zone } = parse(body)?;
    let upload = UploadId(new_id());
    perform(&app, Command::MakeExample { upload, time_zone }).await?;
    Ok((StatusCode::ACCEPTED, json(RequestedExampleDocument::new(upload))).into_response())
}

/// How far the making of the example, or the import of another map, is.
#[utoipa::path(get, path = api::paths::EXAMPLE_PATH, tag = "example", operation_id = "getExample",
    responses(
    (status = 200, body = ExampleProgressDocument, description = "The state of the last one"),
    (status = 503, body = ProblemDocument, content_type = "application/problem+json", description = "The core is not connected"),
))]
pub(crate) async fn progress(State(app): State<Arc<App>>) -> Answer {
    progress_of_import(&app)
}

/// The state of the last map that was made or imported.
pub(crate) fn progress_of_import(app: &App) -> Answer {
    let import = stored(app, |data| Some(data.import.cloned().unwrap_or_default()))?;
    Ok(json(match import {
        Import::None => ExampleProgressDocument::None {},
        Import::Running { stage, share, .. } => ExampleProgressDocument::Running { stage, share },
        Import::Done { map, .. } => ExampleProgressDocument::Done { map },
        Import::Failed { reason, .. } => ExampleProgressDocument::Failed { reason },
    }))
}

/// Cancels it.
#[utoipa::path(delete, path = api::paths::EXAMPLE_PATH, tag = "example", operation_id = "cancelExample",
    responses(
    (status = 204, description = "It is cancelled, or nothing was being made"),
    (status = 503, body = ProblemDocument, content_type = "application/problem+json", description = "The core is not connected"),
    (status = 504, body = ProblemDocument, content_type = "application/problem+json", description = "The core has not answered yet"),
))]
pub(crate) async fn cancel(State(app): State<Arc<App>>) -> Answer {
    let import = stored(&app, |data| Some(data.import.cloned().unwrap_or_default()))?;
    if let Import::Running { upload, .. } = import {
        perform(&app, Command::CancelImport(upload)).await?;
    }
    Ok::<_, ProblemResponse>(StatusCode::NO_CONTENT.into_response())
}
