//! What a draft changes, object by object, in words.

use super::row_kind::RowKind;
use super::texts;
use crate::features::site_graph::name_of;
use client_model::{DraftEntry, FieldChange, Selection, SiteFeature, field_changes};
use site_model::{Object, ObjectId, Site};
use uuid::Uuid;

/// An object that the draft changes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct DraftRow {
    pub(super) id: ObjectId,
    pub(super) kind: RowKind,
    /// Its kind and name, as `Node N3`.
    pub(super) name: String,
    /// What selects it in the scene.
    pub(super) selection: Option<Selection>,
    /// Fields that differ from the site's.
    pub(super) fields: Vec<FieldChange>,
    /// Missions of which tasks refer to an object that is removed.
    pub(super) breaks: Vec<String>,
    /// What somebody else has changed of it since; `None` if nobody has.
    pub(super) theirs: Option<Vec<FieldChange>>,
}

/// All of them, in the order of their ids.
pub(super) fn rows_of(site: &SiteFeature) -> Vec<DraftRow> {
    site.draft_entries().map(|entry| row_of(site, &entry)).collect()
}

fn row_of(site: &SiteFeature, entry: &DraftEntry<'_>) -> DraftRow {
    let (published, shown) = (site.published_site(), site.site());
    let named = |id: Uuid| shown.and_then(|site| name_of_id(site, id)).or_else(|| name_of_id(published, id));
    let differences = |before: Option<&Object>, after: Option<&Object>| match (before, after) {
        (Some(before), Some(after)) => field_changes(before, after, &named),
        _ => Vec::new(),
    };
    let kind = match (entry.theirs, entry.mine) {
        (None, _) => RowKind::Added,
        (_, None) => RowKind::Removed,
        _ => RowKind::Changed,
    };
    let needed = published.missions_that_need(entry.id);
    let mission = |id| published.mission(id).map(|mission| mission.name.clone());
    let breaks =
        if kind == RowKind::Removed { needed.into_iter().filter_map(mission).collect() } else { Vec::new() };
    let object = entry.mine.or(entry.theirs);
    let name = match object {
        Some(Object::Edge(edge)) => {
            let end = |node| {
                [shown, Some(published)]
                    .into_iter()
                    .flatten()
                    .find_map(|site| site.node(node).map(|_| name_of(site, node).to_owned()))
            };
            let [from, to] = [edge.from, edge.to].map(|node| end(node).unwrap_or_else(|| "?".to_owned()));
            texts::edge(&from, &to)
        }
        Some(object) => texts::object(entry.id.kind(), object.name().unwrap_or_default()),
        None => String::new(),
    };
    DraftRow {
        id: entry.id,
        kind,
        name,
        selection: selection_of(entry.id),
        fields: differences(entry.theirs, entry.mine),
        breaks,
        theirs: entry.is_conflict.then(|| differences(entry.before, entry.theirs)),
    }
}

fn selection_of(id: ObjectId) -> Option<Selection> {
    match id {
        ObjectId::Node(node) => Some(Selection::Node(node)),
        ObjectId::Edge(edge) => Some(Selection::Edge(edge)),
        ObjectId::InspectionPoint(point) => Some(Selection::InspectionPoint(point)),
        ObjectId::Zone(zone) => Some(Selection::Zone(zone)),
        _ => None,
    }
}

/// Name of the node, point, mission or dock of an id.
fn name_of_id(site: &Site, id: Uuid) -> Option<String> {
    let ids = [
        ObjectId::Node(site_model::NodeId(id)),
        ObjectId::InspectionPoint(site_model::InspectionPointId(id)),
        ObjectId::Mission(site_model::MissionId(id)),
        ObjectId::Dock(site_model::DockId(id)),
    ];
    ids.into_iter().find_map(|id| site.get(id)?.object.name().map(str::to_owned))
}
