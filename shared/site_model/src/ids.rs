//! Ids of the objects of a site. They are made by whoever makes the object, and never change.

use serde::{Deserialize, Serialize};
use std::fmt;
use uuid::Uuid;
use vocab::uuid_id;

uuid_id! {
    /// A place at which the robot can be, in the topological map.
    NodeId
}
uuid_id! {
    /// A connection from one node to another.
    EdgeId
}
uuid_id! {
    /// An area in which a rule holds.
    ZoneId
}
uuid_id! {
    /// A charging dock.
    DockId
}
uuid_id! {
    /// A thing that is inspected, such as a pump.
    AssetId
}
uuid_id! {
    /// What is looked at, from where, and with which action.
    InspectionPointId
}
uuid_id! {
    /// An ordered list of tasks.
    MissionId
}
uuid_id! {
    /// A task of a mission.
    TaskId
}
uuid_id! {
    /// A rule that says when a mission runs.
    ScheduleId
}
uuid_id! {
    /// A watched condition.
    MonitorId
}
uuid_id! {
    /// That somebody else uses a group of edges.
    MutexHoldId
}
uuid_id! {
    /// An object that changed between two visits.
    SceneChangeId
}
uuid_id! {
    /// Something that a person has to look at.
    AlertId
}
uuid_id! {
    /// A thing that was seen at one place or several, over many visits.
    PhysicalObjectId
}
uuid_id! {
    /// One execution of a mission. A client makes it for a run that it asks for; that of a schedule follows from schedule and slot.
    RunId
}
uuid_id! {
    /// An edit, named by the client, so that an edit sent twice is applied once.
    EditId
}

/// Id of any object of a site.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ObjectId {
    /// The one [`crate::SiteSettings`].
    Settings,
    /// A [`crate::Node`].
    Node(NodeId),
    /// An [`crate::Edge`].
    Edge(EdgeId),
    /// The [`crate::EdgeBlock`] of this edge.
    EdgeBlock(EdgeId),
    /// A [`crate::Zone`].
    Zone(ZoneId),
    /// A [`crate::Dock`].
    Dock(DockId),
    /// An [`crate::Asset`].
    Asset(AssetId),
    /// An [`crate::InspectionPoint`].
    InspectionPoint(InspectionPointId),
    /// A [`crate::Mission`].
    Mission(MissionId),
    /// A [`crate::Schedule`].
    Schedule(ScheduleId),
    /// A [`crate::Monitor`].
    Monitor(MonitorId),
    /// A [`crate::MutexHold`].
    MutexHold(MutexHoldId),
    /// A [`crate::SceneChange`].
    SceneChange(SceneChangeId),
    /// A [`crate::Alert`].
    Alert(AlertId),
}

/// Kind of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs, reason = "each variant is the kind of the type of its name")]
pub enum ObjectKind {
    Settings,
    Node,
    Edge,
    EdgeBlock,
    Zone,
    Dock,
    Asset,
    InspectionPoint,
    Mission,
    Schedule,
    Monitor,
    MutexHold,
    SceneChange,
    Alert,
}

impl ObjectKind {
    /// All kinds, in the order of [`ObjectId`].
    pub const ALL: [Self; 14] = [
        Self::Settings,
        Self::Node,
        Self::Edge,
        Self::EdgeBlock,
        Self::Zone,
        Self::Dock,
        Self::Asset,
        Self::InspectionPoint,
        Self::Mission,
        Self::Schedule,
        Self::Monitor,
        Self::MutexHold,
        Self::SceneChange,
        Self::Alert,
    ];

    /// Its name in JSON, such as `inspection_point`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Settings => "settings",
            Self::Node => "node",
            Self::Edge => "edge",
            Self::EdgeBlock => "edge_block",
            Self::Zone => "zone",
            Self::Dock => "dock",
            Self::Asset => "asset",
            Self::InspectionPoint => "inspection_point",
            Self::Mission => "mission",
            Self::Schedule => "schedule",
            Self::Monitor => "monitor",
            Self::MutexHold => "mutex_hold",
            Self::SceneChange => "scene_change",
            Self::Alert => "alert",
        }
    }

    /// The kind of this name.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }
}

impl ObjectId {
    /// The object of this kind and id. Settings have no id; theirs is ignored.
    pub fn new(kind: ObjectKind, id: Uuid) -> Self {
        match kind {
            ObjectKind::Settings => Self::Settings,
            ObjectKind::Node => Self::Node(NodeId(id)),
            ObjectKind::Edge => Self::Edge(EdgeId(id)),
            ObjectKind::EdgeBlock => Self::EdgeBlock(EdgeId(id)),
            ObjectKind::Zone => Self::Zone(ZoneId(id)),
            ObjectKind::Dock => Self::Dock(DockId(id)),
            ObjectKind::Asset => Self::Asset(AssetId(id)),
            ObjectKind::InspectionPoint => Self::InspectionPoint(InspectionPointId(id)),
            ObjectKind::Mission => Self::Mission(MissionId(id)),
            ObjectKind::Schedule => Self::Schedule(ScheduleId(id)),
            ObjectKind::Monitor => Self::Monitor(MonitorId(id)),
            ObjectKind::MutexHold => Self::MutexHold(MutexHoldId(id)),
            ObjectKind::SceneChange => Self::SceneChange(SceneChangeId(id)),
            ObjectKind::Alert => Self::Alert(AlertId(id)),
        }
    }

    /// Its kind.
    pub fn kind(self) -> ObjectKind {
        match self {
            Self::Settings => ObjectKind::Settings,
            Self::Node(_) => ObjectKind::Node,
            Self::Edge(_) => ObjectKind::Edge,
            Self::EdgeBlock(_) => ObjectKind::EdgeBlock,
            Self::Zone(_) => ObjectKind::Zone,
            Self::Dock(_) => ObjectKind::Dock,
            Self::Asset(_) => ObjectKind::Asset,
            Self::InspectionPoint(_) => ObjectKind::InspectionPoint,
            Self::Mission(_) => ObjectKind::Mission,
            Self::Schedule(_) => ObjectKind::Schedule,
            Self::Monitor(_) => ObjectKind::Monitor,
            Self::MutexHold(_) => ObjectKind::MutexHold,
            Self::SceneChange(_) => ObjectKind::SceneChange,
            Self::Alert(_) => ObjectKind::Alert,
        }
    }

    /// Its id within its kind; nil for the settings.
    pub fn uuid(self) -> Uuid {
        match self {
            Self::Settings => Uuid::nil(),
            Self::Node(id) => id.0,
            Self::Edge(id) | Self::EdgeBlock(id) => id.0,
            Self::Zone(id) => id.0,
            Self::Dock(id) => id.0,
            Self::Asset(id) => id.0,
            Self::InspectionPoint(id) => id.0,
            Self::Mission(id) => id.0,
            Self::Schedule(id) => id.0,
            Self::Monitor(id) => id.0,
            Self::MutexHold(id) => id.0,
            Self::SceneChange(id) => id.0,
            Self::Alert(id) => id.0,
        }
    }
}

impl fmt::Display for ObjectId {
    /// The kind and the id, such as `node 67e55044-…`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (kind, id): (_, &dyn fmt::Display) = match self {
            Self::Settings => return f.write_str("site settings"),
            Self::Node(id) => ("node", id),
            Self::Edge(id) => ("edge", id),
            Self::EdgeBlock(id) => ("block of edge", id),
            Self::Zone(id) => ("zone", id),
            Self::Dock(id) => ("dock", id),
            Self::Asset(id) => ("asset", id),
            Self::InspectionPoint(id) => ("inspection point", id),
            Self::Mission(id) => ("mission", id),
            Self::Schedule(id) => ("schedule", id),
            Self::Monitor(id) => ("monitor", id),
            Self::MutexHold(id) => ("hold of edges", id),
            Self::SceneChange(id) => ("change", id),
            Self::Alert(id) => ("alert", id),
        };
        write!(f, "{kind} {id}")
    }
}
