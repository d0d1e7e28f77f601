//! Objects of the topological map. Poses are those of the site's map, metres and radians.

use crate::{
    ActionRequest, AssetId, DockId, EdgeId, GaugeDial, InspectionPointId, NodeId, Parameters, Reading, ZoneId,
};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use vocab::{KeyframeId, Pose, Span, Stamp, Vec3, is_in_polygon};

/// A place at which the robot can be.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Node {
    /// Its id.
    pub id: NodeId,
    /// Shown to people.
    pub name: String,
    /// What it is for.
    pub kind: NodeKind,
    /// Pose of the base at the node.
    pub map_from_node: Pose,
    /// The keyframe with which the node moves when the map is corrected; none keeps it where it is.
    #[serde(default)]
    pub anchor: Option<Anchor>,
    /// How far from the pose the robot still is at the node.
    #[serde(default)]
    pub tolerance: PoseTolerance,
    /// Corners of the area in which the robot counts as at the node, metres, in the frame of the node. Empty: the ellipse of the tolerance.
    #[serde(default)]
    pub influence_area_m: Vec<[f64; 2]>,
    /// Number of the floor; 0 is the one on which the map began.
    #[serde(default)]
    pub floor: i32,
    /// Words by which people find it.
    #[serde(default)]
    pub tags: BTreeSet<String>,
    /// Further properties of people and programs.
    #[serde(default)]
    pub properties: BTreeMap<String, String>,
}

/// What a node is for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum NodeKind {
    /// To pass by.
    #[default]
    Waypoint,
    /// To act at.
    Inspection,
    /// On a dock.
    Dock,
    /// In front of a dock, where the robot aligns itself.
    DockApproach,
    /// To wait at.
    Hold,
    /// One end of stairs or of a lift.
    Portal,
    /// To retreat to.
    Safe,
}

/// A keyframe and the pose relative to it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Anchor {
    /// Keyframe of the site's map.
    pub keyframe: KeyframeId,
    /// Pose of the node in the frame of the keyframe.
    pub keyframe_from_node: Pose,
}

/// The poses that count as reached: an ellipse in the frame of the node, and an angle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PoseTolerance {
    /// Half axis along the x axis of the node, metres.
    pub along_m: f64,
    /// Half axis along its y axis, metres.
    pub across_m: f64,
    /// Greatest difference of heading, radians.
    pub yaw_rad: f64,
}

impl Default for PoseTolerance {
    /// 0.1 m and 3 degrees: a target 2 m away then stays within a tenth of the picture of a camera with a view of 60 degrees.
    fn default() -> Self {
        Self { along_m: 0.1, across_m: 0.1, yaw_rad: 0.0524 }
    }
}

/// A connection from one node to another. It is directed; editors make pairs by default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Edge {
    /// Its id.
    pub id: EdgeId,
    /// The node where it begins.
    pub from: NodeId,
    /// The node where it ends.
    pub to: NodeId,
    /// How it is traversed.
    pub traversal: Traversal,
    /// What it costs.
    #[serde(default)]
    pub cost: EdgeCost,
    /// Greatest speed, m/s; none: that of the robot.
    #[serde(default)]
    pub max_speed_m_s: Option<f64>,
    /// How far from the straight line the robot may walk.
    #[serde(default)]
    pub corridor: Corridor,
    /// Which way the robot faces.
    #[serde(default)]
    pub direction: TravelDirection,
    /// Actions before the robot sets out.
    #[serde(default)]
    pub on_enter: Vec<ActionRequest>,
    /// Actions while it walks.
    #[serde(default)]
    pub during: Vec<ActionRequest>,
    /// Actions after it has arrived.
    #[serde(default)]
    pub on_leave: Vec<ActionRequest>,
    /// What is tried in turn when the edge cannot be walked.
    #[serde(default)]
    pub fail_policy: Vec<EdgeFailStep>,
    /// Edges of one group are used by one robot at a time.
    #[serde(default)]
    pub mutex_group: Option<String>,
    /// Whether routes may use it.
    pub is_enabled: bool,
}

impl Edge {
    /// An edge that is walked, open to routes, with the default of everything else.
    pub fn walk(id: EdgeId, from: NodeId, to: NodeId) -> Self {
        Self {
            id,
            from,
            to,
            traversal: Traversal::Walk,
            cost: EdgeCost::Length,
            max_speed_m_s: None,
            corridor: Corridor::default(),
            direction: TravelDirection::Forward,
            on_enter: Vec::new(),
            during: Vec::new(),
            on_leave: Vec::new(),
            fail_policy: Vec::new(),
            mutex_group: None,
            is_enabled: true,
        }
    }
}

/// How an edge is traversed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Traversal {
    /// Walk on flat ground.
    Walk,
    /// Climb stairs.
    Stairs,
    /// Pass a door.
    Door,
    /// Walk slowly.
    Slow,
    /// Walk onto a dock.
    Dock,
    /// By an action that a robot or program has registered.
    Action {
        /// Its name.
        name: String,
        /// Its parameters.
        #[serde(default)]
        parameters: Parameters,
    },
}

/// What an edge costs, in seconds of walking.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EdgeCost {
    /// Its length at the robot's usual speed.
    #[default]
    Length,
    /// This time, seconds.
    Fixed(f64),
    /// The time that earlier traversals took; its length before the first.
    Learned,
}

/// Distance to both sides of the line between two nodes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Corridor {
    /// To the left in the direction of travel, metres.
    pub left_m: f64,
    /// To the right, metres.
    pub right_m: f64,
}

impl Default for Corridor {
    /// 1 m to both sides: room to walk round a person.
    fn default() -> Self {
        Self { left_m: 1.0, right_m: 1.0 }
    }
}

/// Which way the robot faces on an edge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TravelDirection {
    /// Where it goes.
    #[default]
    Forward,
    /// The opposite direction.
    Backward,
    /// Any direction.
    Any,
}

/// A step of the policy for an edge that cannot be walked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EdgeFailStep {
    /// Try again this number of times.
    Retry(u8),
    /// Wait for this time and try again.
    Wait(Span),
    /// Take another route.
    Replan,
    /// Give up.
    Fail,
}

/// An edge that is not used for a time, because it could not be walked. It is an object of its own, so that a block by the robot and an edit by a
/// person do not conflict.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EdgeBlock {
    /// The edge.
    pub edge: EdgeId,
    /// When it is tried again, on the robot's clock.
    pub until: Stamp,
    /// Number of times in a row that it could not be walked; the time doubles with each.
    pub failures: u32,
    /// Why, for people.
    pub reason: String,
}

/// An area in which a rule holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Zone {
    /// Its id.
    pub id: ZoneId,
    /// Shown to people.
    pub name: String,
    /// Corners, metres, map frame, in either sense of rotation.
    pub corners_m: Vec<[f64; 2]>,
    /// Lowest and greatest height at which it holds, metres, map frame; none: all heights.
    #[serde(default)]
    pub height_m: Option<[f64; 2]>,
    /// What holds in it.
    pub effect: ZoneEffect,
    /// Part of each day in which it holds, in the site's time zone; it may cross midnight. None: always.
    #[serde(default)]
    pub daily: Option<[crate::LocalTime; 2]>,
}

impl Zone {
    /// Whether a point of the map frame is in it, heights included; times of the day are not looked at. Linear in the corners.
    pub fn contains(&self, point: Vec3) -> bool {
        let is_at_height = self.height_m.is_none_or(|[low, high]| (low..=high).contains(&point.z));
        is_at_height && is_in_polygon(&self.corners_m, [point.x, point.y])
    }
}

/// What holds in a zone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ZoneEffect {
    /// The robot does not enter it.
    KeepOut,
    /// Greatest speed, m/s.
    SpeedLimit(f64),
    /// Factor on the cost of walking, at least 1.
    Penalty(f64),
    /// An action on entering it.
    Action(ActionRequest),
}

/// A charging dock.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Dock {
    /// Its id.
    pub id: DockId,
    /// Shown to people.
    pub name: String,
    /// The node on the dock.
    pub node: NodeId,
    /// The node in front of it, where the robot aligns itself.
    pub approach: NodeId,
}

impl Dock {
    /// Distance between the node on a new dock and its approach node, metres: the length of a robot.
    pub const APPROACH_M: f64 = 1.0;
}

/// A thing that is inspected. It exists apart from nodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Asset {
    /// Its id.
    pub id: AssetId,
    /// Shown to people.
    pub name: String,
    /// Words by which people find it.
    #[serde(default)]
    pub tags: BTreeSet<String>,
}

/// What is looked at, from where, and with which action.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InspectionPoint {
    /// Its id.
    pub id: InspectionPointId,
    /// Shown to people.
    pub name: String,
    /// The thing; none if it is not listed.
    #[serde(default)]
    pub asset: Option<AssetId>,
    /// The node from which it is looked at.
    pub node: NodeId,
    /// What is looked at, metres, map frame.
    pub target_m: Vec3,
    /// The action and its parameters.
    pub request: ActionRequest,
    /// Limits of the reading; none: it is not judged.
    #[serde(default)]
    pub limits: Option<ReadingLimits>,
    /// The gauge that its photos show, which is read once they are taken; none: they show none, or it is not described yet.
    #[serde(default)]
    pub gauge: Option<GaugeDial>,
}

/// The range of a reading in which nothing is wrong.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReadingLimits {
    /// Smallest value; none: no limit.
    #[serde(default)]
    pub min: Option<f64>,
    /// Greatest value; none: no limit.
    #[serde(default)]
    pub max: Option<f64>,
    /// Unit of both, such as `bar`.
    pub unit: String,
}

/// The limit that a reading does not keep.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OutsideLimits {
    /// It is smaller than this smallest value.
    Below(f64),
    /// It is greater than this greatest value.
    Above(f64),
}

impl ReadingLimits {
    /// The limit that a reading does not keep; none if it keeps both, or has another unit.
    pub fn outside(&self, reading: &Reading) -> Option<OutsideLimits> {
        if reading.unit != self.unit {
            return None;
        }
        let below = self.min.filter(|min| reading.value < *min).map(OutsideLimits::Below);
        below.or_else(|| self.max.filter(|max| reading.value > *max).map(OutsideLimits::Above))
    }
}
