//! Ids of the objects of a site. They are made by whoever makes the object, and never change.

use serde::{Deserialize, Serialize};
use std::fmt;
use vocab::uuid_id;

uuid_id! {
    /// A place at which the robot can be, in the topological map.
    NodeId
}
uuid_id! {
    /// A way from one node to another.
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
    /// A way to look at a thing.
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
        };
        write!(f, "{kind} {id}")
    }
}
