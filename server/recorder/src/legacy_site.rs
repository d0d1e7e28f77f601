//! Sites in journals of version 12 and 13: changes of the scene did not say of which thing they were.
//!
//! Frozen copies of the types on the way to a change, with their conversions. Only entries of the site differ.

use messages::{Input, SiteSnapshot};
use serde::{Deserialize, Serialize};
use site_model::{
    Alert, Asset, Change, Dock, EarlierVisit, Edge, EdgeBlock, Edit, EditId, InspectionPoint, Mission,
    Monitor, MutexHold, Node, Object, ObjectId, OrientedBox, ReviewState, Revision, RunId, SceneChange,
    SceneChangeClouds, SceneChangeId, SceneChangeKind, Schedule, SiteSettings, Utc, Versioned, Zone,
};
use vocab::MapId;

/// Places of `Input::Site` and `Input::SiteEdited` among the variants of `messages::Input`.
const SITE: u8 = 10;
const SITE_EDITED: u8 = 11;

/// An entry of version 12 or 13 about the site.
#[derive(Debug)]
pub(crate) enum SiteEntryV13 {
    Site(SiteSnapshotV13),
    Edited(EditV13),
}

/// Reads an entry about the site, with what follows it; `None` for all other entries, which are as those of version 14 and later.
pub(crate) fn take_site_entry_v13(entry: &[u8]) -> Option<Result<(SiteEntryV13, &[u8]), postcard::Error>> {
    match entry.split_first()? {
        (&SITE, rest) => {
            Some(postcard::take_from_bytes(rest).map(|(site, rest)| (SiteEntryV13::Site(site), rest)))
        }
        (&SITE_EDITED, rest) => {
            Some(postcard::take_from_bytes(rest).map(|(edit, rest)| (SiteEntryV13::Edited(edit), rest)))
        }
        _ => None,
    }
}

/// `messages::SiteSnapshot`.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct SiteSnapshotV13 {
    objects: Vec<VersionedV13>,
    removed: Vec<(ObjectId, Revision)>,
}

/// `site_model::Versioned`.
#[derive(Debug, Serialize, Deserialize)]
struct VersionedV13 {
    revision: Revision,
    object: ObjectV13,
}

/// `site_model::Edit`.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct EditV13 {
    id: EditId,
    changes: Vec<ChangeV13>,
}

/// `site_model::Change`.
#[derive(Debug, Serialize, Deserialize)]
enum ChangeV13 {
    Put { base: Option<Revision>, object: ObjectV13 },
    Remove { base: Revision, object: ObjectId },
}

/// `site_model::Object`.
#[derive(Debug, Serialize, Deserialize)]
enum ObjectV13 {
    Settings(SiteSettings),
    Node(Node),
    Edge(Edge),
    EdgeBlock(EdgeBlock),
    Zone(Zone),
    Dock(Dock),
    Asset(Asset),
    InspectionPoint(InspectionPoint),
    Mission(Mission),
    Schedule(Schedule),
    Monitor(Monitor),
    MutexHold(MutexHold),
    SceneChange(SceneChangeV13),
    Alert(Alert),
}

/// `site_model::SceneChange`, without its thing and its descriptor.
#[derive(Debug, Serialize, Deserialize)]
struct SceneChangeV13 {
    id: SceneChangeId,
    map: MapId,
    kind: SceneChangeKind,
    place: OrientedBox,
    points: u32,
    confidence: f64,
    before: EarlierVisit,
    after: RunId,
    first_seen: Utc,
    last_seen: Utc,
    times_seen: u32,
    review: ReviewState,
    comment: String,
    clouds: Option<SceneChangeClouds>,
}

impl From<SiteEntryV13> for Input {
    fn from(entry: SiteEntryV13) -> Self {
        match entry {
            SiteEntryV13::Site(SiteSnapshotV13 { objects, removed }) => {
                let versioned =
                    |VersionedV13 { revision, object }| Versioned { revision, object: object.into() };
                let objects = objects.into_iter().map(versioned).collect();
                Self::Site(Box::new(SiteSnapshot { objects, removed }))
            }
            SiteEntryV13::Edited(EditV13 { id, changes }) => {
                let change = |change| match change {
                    ChangeV13::Put { base, object } => Change::Put { base, object: object.into() },
                    ChangeV13::Remove { base, object } => Change::Remove { base, object },
                };
                Self::SiteEdited(Box::new(Edit { id, changes: changes.into_iter().map(change).collect() }))
            }
        }
    }
}

impl From<ObjectV13> for Object {
    fn from(object: ObjectV13) -> Self {
        match object {
            ObjectV13::Settings(object) => Self::Settings(object),
            ObjectV13::Node(object) => Self::Node(object),
            ObjectV13::Edge(object) => Self::Edge(object),
            ObjectV13::EdgeBlock(object) => Self::EdgeBlock(object),
            ObjectV13::Zone(object) => Self::Zone(object),
            ObjectV13::Dock(object) => Self::Dock(object),
            ObjectV13::Asset(object) => Self::Asset(object),
            ObjectV13::InspectionPoint(object) => Self::InspectionPoint(object),
            ObjectV13::Mission(object) => Self::Mission(object),
            ObjectV13::Schedule(object) => Self::Schedule(object),
            ObjectV13::Monitor(object) => Self::Monitor(object),
            ObjectV13::MutexHold(object) => Self::MutexHold(object),
            ObjectV13::SceneChange(change) => Self::SceneChange(SceneChange {
                id: change.id,
                map: change.map,
                kind: change.kind,
                place: change.place,
                points: change.points,
                confidence: change.confidence,
                before: change.before,
                after: change.after,
                first_seen: change.first_seen,
                last_seen: change.last_seen,
                times_seen: change.times_seen,
                review: change.review,
                comment: change.comment,
                clouds: change.clouds,
                physical_object: None,
                descriptor: None,
            }),
            ObjectV13::Alert(object) => Self::Alert(object),
        }
    }
}

#[cfg(test)]
impl Serialize for SiteEntryV13 {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Site(site) => serializer.serialize_newtype_variant("Input", SITE.into(), "Site", site),
            Self::Edited(edit) => {
                serializer.serialize_newtype_variant("Input", SITE_EDITED.into(), "SiteEdited", edit)
            }
        }
    }
}
