//! An object of any kind, and its revision.

use crate::{
    Alert, Asset, Dock, Edge, EdgeBlock, InspectionPoint, Mission, Monitor, MutexHold, Node, ObjectId,
    SceneChange, Schedule, SiteSettings, Zone,
};
use serde::{Deserialize, Serialize};
use std::fmt;

/// An object of a site.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs, reason = "each variant is the type of its name")]
pub enum Object {
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
    SceneChange(SceneChange),
    Alert(Alert),
}

impl Object {
    /// Its id.
    pub fn id(&self) -> ObjectId {
        match self {
            Self::Settings(_) => ObjectId::Settings,
            Self::Node(node) => ObjectId::Node(node.id),
            Self::Edge(edge) => ObjectId::Edge(edge.id),
            Self::EdgeBlock(block) => ObjectId::EdgeBlock(block.edge),
            Self::Zone(zone) => ObjectId::Zone(zone.id),
            Self::Dock(dock) => ObjectId::Dock(dock.id),
            Self::Asset(asset) => ObjectId::Asset(asset.id),
            Self::InspectionPoint(point) => ObjectId::InspectionPoint(point.id),
            Self::Mission(mission) => ObjectId::Mission(mission.id),
            Self::Schedule(schedule) => ObjectId::Schedule(schedule.id),
            Self::Monitor(monitor) => ObjectId::Monitor(monitor.id),
            Self::MutexHold(hold) => ObjectId::MutexHold(hold.id),
            Self::SceneChange(change) => ObjectId::SceneChange(change.id),
            Self::Alert(alert) => ObjectId::Alert(alert.id),
        }
    }

    /// The name that people gave it, if it has one.
    pub fn name(&self) -> Option<&str> {
        match self {
            Self::Settings(settings) => Some(&settings.name),
            Self::Node(node) => Some(&node.name),
            Self::Zone(zone) => Some(&zone.name),
            Self::Dock(dock) => Some(&dock.name),
            Self::Asset(asset) => Some(&asset.name),
            Self::InspectionPoint(point) => Some(&point.name),
            Self::Mission(mission) => Some(&mission.name),
            Self::Schedule(schedule) => Some(&schedule.name),
            Self::Monitor(monitor) => Some(&monitor.name),
            Self::Edge(_)
            | Self::EdgeBlock(_)
            | Self::MutexHold(_)
            | Self::SceneChange(_)
            | Self::Alert(_) => None,
        }
    }
}

/// Number of a state of an object. It grows with every change of the object, also when the object is removed and put again.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Revision(pub u64);

impl fmt::Display for Revision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// An object with its revision.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Versioned {
    /// Its revision.
    pub revision: Revision,
    /// The object.
    pub object: Object,
}
