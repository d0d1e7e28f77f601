//! Changes of the scene, filtered. One of them is read and edited as any object of the site.

use super::objects::site;
use super::parse::document;
use super::schemas::{ObjectListDocument, VersionedDocument};
use crate::app::App;
use crate::documents::Answer;
use crate::json_response::json;
use crate::problem::ProblemResponse;
use crate::schemas::ProblemDocument;
use crate::texts;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, State};
use serde::Deserialize;
use site_model::{
    Object, ObjectStay, PhysicalObjectId, SceneChange, SceneChangeId, Site, Utc, Versioned, object_history,
};
use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::sync::Arc;
use vocab::MapId;

/// Which changes are wanted.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SceneChangeFilter {
    limit: Option<u32>,
    after: Option<String>,
    kind: Option<KindName>,
    review: Option<ReviewName>,
    min_size_m: Option<f64>,
    map: Option<MapId>,
    physical_object: Option<PhysicalObjectId>,
    from_ns: Option<i64>,
}

/// Kinds of changes without where from.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
enum KindName {
    Appeared,
    Removed,
    Moved,
}

/// What people have decided, without their reasons.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
enum ReviewName {
    New,
    Acknowledged,
    Dismissed,
    Watched,
    Normal,
    Routine,
}

impl KindName {
    fn name(self) -> &'static str {
        match self {
            Self::Appeared => "appeared",
            Self::Removed => "removed",
            Self::Moved => "moved",
        }
    }
}

impl ReviewName {
    fn name(self) -> &'static str {
        match self {
            Self::New => "new",
            Self::Acknowledged => "acknowledged",
            Self::Dismissed => "dismissed",
            Self::Watched => "watched",
            Self::Normal => "normal",
            Self::Routine => "routine",
        }
    }
}

impl SceneChangeFilter {
    fn admits(&self, change: &SceneChange) -> bool {
        self.kind.is_none_or(|kind| kind.name() == change.kind.name())
            && self.review.is_none_or(|review| review.name() == change.review.name())
            && self.min_size_m.is_none_or(|size_m| change.place.longest_side_m() >= size_m)
            && self.map.is_none_or(|map| change.map == map)
            && self.physical_object.is_none_or(|id| change.physical_object.is_some_and(|of| of.id == id))
            && self.from_ns.is_none_or(|from_ns| change.last_seen.0 >= from_ns)
    }
}

/// The changes of each thing.
struct Things<'a>(BTreeMap<PhysicalObjectId, Vec<&'a SceneChange>>);

impl<'a> Things<'a> {
    fn of(site: &'a Site) -> Self {
        let mut things: BTreeMap<PhysicalObjectId, Vec<&SceneChange>> = BTreeMap::new();
        for change in site.scene_changes() {
            if let Some(object) = change.physical_object {
                things.entry(object.id).or_default().push(change);
            }
        }
        Self(things)
    }

    /// Where the thing of a change was; none if nobody said of which thing it is.
    fn history(&self, object: &Object) -> Option<Vec<ObjectStay>> {
        let Object::SceneChange(change) = object else { return None };
        let changes = self.0.get(&change.physical_object?.id)?;
        Some(object_history(changes.iter().copied()))
    }
}

/// Place in the list: those seen last come first.
type Position = (Reverse<Utc>, SceneChangeId);

fn position(change: &SceneChange) -> Position {
    (Reverse(change.last_seen), change.id)
}

/// The position that `next` of a page names.
fn parse_position(text: &str) -> Option<Position> {
    let (last_seen, id) = text.split_once('.')?;
    Some((Reverse(Utc(last_seen.parse().ok()?)), id.parse().ok()?))
}

/// What has changed between visits, the changes that were seen last first.
#[utoipa::path(get, path = api::paths::SCENE_CHANGES_PATH, tag = "site", operation_id = "listSceneChanges",
    params(
        ("limit" = Option<u32>, Query, description = "Changes wanted; 100 at most, and if left out"),
        ("after" = Option<String>, Query, description = "Only changes after this one: `next` of the page before"),
        ("kind" = Option<String>, Query, description = "Only those of this kind: appeared, removed or moved"),
        ("review" = Option<String>, Query, description = "Only those on which people have decided so: new, acknowledged, dismissed, watched, normal or routine"),
        ("min_size_m" = Option<f64>, Query, description = "Only those with a side of at least this length, metres"),
        ("map" = Option<String>, Query, format = Uuid, description = "Only those in this map"),
        ("physical_object" = Option<String>, Query, format = Uuid, description = "Only those of this thing"),
        ("from_ns" = Option<i64>, Query, description = "Only those that were seen at this time or later, nanoseconds since 1970 UTC"),
    ),
    responses(
    (status = 200, body = ObjectListDocument, description = "A page of changes with their revisions"),
    (status = 400, body = ProblemDocument, content_type = "application/problem+json", description = "A parameter is malformed"),
    (status = 503, body = ProblemDocument, content_type = "application/problem+json", description = "The core has not sent the site yet"),
))]
pub(crate) async fn list_scene_changes(
    State(app): State<Arc<App>>,
    query: Result<Query<SceneChangeFilter>, QueryRejection>,
) -> Answer {
    let malformed = |detail: &str| ProblemResponse::malformed(texts::query_malformed(detail));
    let Query(filter) = query.map_err(|rejection| malformed(&rejection.body_text()))?;
    let after = match filter.after.as_deref() {
        None => None,
        Some(text) => Some(parse_position(text).ok_or_else(|| malformed(texts::AFTER_NO_CHANGE))?),
    };
    let limit = filter.limit.unwrap_or(api::MAX_PAGE).clamp(1, api::MAX_PAGE) as usize;
    let state = site(&app)?;
    let wanted = state.site.objects().filter_map(|versioned| match &versioned.object {
        Object::SceneChange(change) if filter.admits(change) => Some((position(change), versioned)),
        _ => None,
    });
    let mut wanted: Vec<(Position, &Versioned)> =
        wanted.filter(|(at, _)| after.is_none_or(|after| *at > after)).collect();
    wanted.sort_by_key(|(at, _)| *at);
    let is_more = wanted.len() > limit;
    wanted.truncate(limit);
    let next = wanted.last().filter(|_| is_more).map(|((seen, id), _)| format!("{}.{id}", seen.0.0));
    let things = Things::of(&state.site);
    let items = wanted.into_iter().map(|(_, versioned)| VersionedDocument {
        revision: versioned.revision.0,
        object: document(&versioned.object),
        history: things.history(&versioned.object),
    });
    Ok(json(ObjectListDocument { revision: state.revision, items: items.collect(), next }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use uuid::Uuid;

    #[test]
    fn a_position_is_read_as_the_page_names_it_and_newer_changes_come_first() {
        let id = SceneChangeId(Uuid::from_u128(7));
        assert_eq!(parse_position(&format!("-5.{id}")), Some((Reverse(Utc(-5)), id)));
        for text in ["", "5", "5.", "x.y", "5.7"] {
            assert_eq!(parse_position(text), None, "{text}");
        }
        assert!((Reverse(Utc(9)), id) < (Reverse(Utc(8)), id));
    }
}
