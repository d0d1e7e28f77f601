//! Changes of the scene that become normal, over HTTP: a new version of their map is made on request, and its progress is told. The core does the work.

use crate::app::App;
use crate::documents::Answer;
use crate::example::{ExampleProgressDocument, RequestedExampleDocument, progress_of_import};
use crate::json_response::json;
use crate::maps::perform;
use crate::problem::ProblemResponse;
use crate::runs::handlers::parse;
use crate::schemas::ProblemDocument;
use crate::site::{FieldProblem, new_id, site};
use crate::texts;
use api::{Command, MAX_ACCEPTED_CHANGES};
use axum::body::Bytes;
use axum::extract::State;
use axum::extract::rejection::BytesRejection;
use axum::http::StatusCode;
use axum::response::IntoResponse;
use serde::Deserialize;
use site_model::{Object, ObjectId, SceneChangeId, Site};
use std::sync::Arc;
use utoipa::ToSchema;
use vocab::UploadId;

/// What is to be normal.
#[derive(Deserialize, ToSchema)]
#[schema(as = NewNormalRequest)]
#[serde(deny_unknown_fields)]
pub(crate) struct NewNormalRequestDocument {
    /// Ids of scene changes, all of one map: 1 to 200.
    #[schema(value_type = Vec<String>)]
    changes: Vec<SceneChangeId>,
    /// Name of the new version of the map.
    name: String,
}

/// Makes changes normal: a new version of their map shows the scene as it is now. It is kept only if the clouds of the run that found them fit it.
#[utoipa::path(post, path = api::paths::NORMAL_CHANGES_PATH, tag = "site", operation_id = "makeChangesNormal",
    request_body(content = NewNormalRequestDocument, example = json!({ "changes": ["55555555-0000-4000-8000-000000000001"], "name": "Hall, as it is now" })),
    responses(
    (status = 202, body = RequestedExampleDocument, description = "It is begun, and takes some seconds; a GET tells how far it is, which map was made, and why it failed"),
    (status = 400, body = ProblemDocument, content_type = "application/problem+json", description = "The document is malformed"),
    (status = 409, body = ProblemDocument, content_type = "application/problem+json", description = "A map is being made already"),
    (status = 413, body = ProblemDocument, content_type = "application/problem+json", description = "The document is too long"),
    (status = 422, body = ProblemDocument, content_type = "application/problem+json", description = "There is no change, more than 200, one that the site does not have, or one of another map; each is named"),
    (status = 503, body = ProblemDocument, content_type = "application/problem+json", description = "The core is not connected"),
    (status = 504, body = ProblemDocument, content_type = "application/problem+json", description = "The core has not answered yet"),
))]
pub(crate) async fn make_normal(State(app): State<Arc<App>>, body: Result<Bytes, BytesRejection>) -> Answer {
    let NewNormalRequestDocument { changes, name } = parse(body)?;
    let wrong = wrong_changes(&changes, &site(&app)?.site);
    if !wrong.is_empty() {
        let refusal = ProblemResponse::new(StatusCode::UNPROCESSABLE_ENTITY, texts::CHANGES_NOT_NORMAL);
        return Err(refusal.with_fields(wrong));
    }
    let upload = UploadId(new_id());
    perform(&app, Command::MakeNormal { upload, name, changes }).await?;
    Ok((StatusCode::ACCEPTED, json(RequestedExampleDocument::new(upload))).into_response())
}

/// How far that is, or the import of another map.
#[utoipa::path(get, path = api::paths::NORMAL_CHANGES_PATH, tag = "site", operation_id = "getChangesNormal",
    responses(
    (status = 200, body = ExampleProgressDocument, description = "The state of the last one"),
    (status = 503, body = ProblemDocument, content_type = "application/problem+json", description = "The core is not connected"),
))]
pub(crate) async fn normal_progress(State(app): State<Arc<App>>) -> Answer {
    progress_of_import(&app)
}

/// What is wrong with the list of changes; empty if nothing is. Logarithmic in the site for each change.
fn wrong_changes(changes: &[SceneChangeId], site: &Site) -> Vec<FieldProblem> {
    if changes.is_empty() || changes.len() > MAX_ACCEPTED_CHANGES {
        return vec![FieldProblem::new("/changes", texts::number_of_changes(MAX_ACCEPTED_CHANGES))];
    }
    let map_of = |change: &SceneChangeId| match &site.get(ObjectId::SceneChange(*change))?.object {
        Object::SceneChange(change) => Some(change.map),
        _ => None,
    };
    let map = changes.first().and_then(map_of);
    let wrong = |(index, change): (usize, &SceneChangeId)| {
        let detail = match map_of(change) {
            None => texts::NO_SUCH_CHANGE,
            of_change if of_change == map || map.is_none() => return None,
            Some(_) => texts::CHANGE_OF_OTHER_MAP,
        };
        Some(FieldProblem::new(format!("/changes/{index}"), detail))
    };
    changes.iter().enumerate().filter_map(wrong).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use site_model::{
        Change, EarlierVisit, Edit, EditId, OrientedBox, ReviewState, RunId, SceneChange, SceneChangeKind,
        Utc,
    };
    use uuid::Uuid;
    use vocab::{MapId, Vec3};

    fn change_id(number: u128) -> SceneChangeId {
        SceneChangeId(Uuid::from_u128(number))
    }

    /// Changes 1 and 2 are of one map, 3 is of another.
    fn site_with_changes() -> Site {
        let mut site = Site::default();
        for (number, map) in [(1, 7), (2, 7), (3, 8)] {
            let change = SceneChange {
                id: change_id(number),
                map: MapId(Uuid::from_u128(map)),
                kind: SceneChangeKind::Appeared,
                place: OrientedBox {
                    centre_m: Vec3::new(1.0, 2.0, 0.5),
                    size_m: [0.6, 0.4, 1.0],
                    yaw_rad: 0.0,
                },
                points: 100,
                confidence: 0.9,
                before: EarlierVisit::Map(MapId(Uuid::from_u128(map))),
                after: RunId(Uuid::from_u128(9)),
                first_seen: Utc(1),
                last_seen: Utc(1),
                times_seen: 1,
                review: ReviewState::New,
                comment: String::new(),
                clouds: None,
                physical_object: None,
                descriptor: None,
            };
            let put = Change::Put { base: None, object: Object::SceneChange(change) };
            let edit = Edit { id: EditId(Uuid::from_u128(number)), changes: vec![put] };
            site.apply(&edit, EditId(Uuid::nil())).unwrap();
        }
        site
    }

    #[test]
    fn changes_of_one_map_can_become_normal_and_others_are_named() {
        let site = site_with_changes();
        let wrong = |numbers: &[u128]| {
            let changes: Vec<SceneChangeId> = numbers.iter().copied().map(change_id).collect();
            let wrong = wrong_changes(&changes, &site);
            wrong.into_iter().map(|problem| (problem.pointer, problem.detail)).collect::<Vec<_>>()
        };
        assert!(wrong(&[1, 2]).is_empty());
        let other = ("/changes/2".to_owned(), texts::CHANGE_OF_OTHER_MAP.to_owned());
        let unknown = ("/changes/1".to_owned(), texts::NO_SUCH_CHANGE.to_owned());
        assert_eq!(wrong(&[1, 5, 3]), [unknown, other]);
        let number = [("/changes".to_owned(), "Name 1 to 200 changes.".to_owned())];
        assert_eq!(wrong(&[]), number);
        assert_eq!(wrong(&[1; 201]), number);
    }
}
