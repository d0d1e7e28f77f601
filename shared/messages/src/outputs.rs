//! Outputs of the stack: effects for the shell, and publications for clients.

use crate::{
    BatteryState, ExecutiveStatus, GoalUpdate, GraphDelta, Job, JobId, LedgerEvent, LoopDecision, PoseInMap,
    Reanchored,
};
use serde::{Deserialize, Serialize};
use site_model::{MissionStatus, RouteStatus};
use std::sync::Arc;
use vocab::{
    ActionCallId, ClientId, CommandId, Covariance6, KeyframeId, MapId, Pose, SessionId, Span, Stamp, Twist,
    Vec3,
};

/// Action that the shell must execute after a step. The effects of a step are executed in their order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum StackEffect {
    /// Send a velocity command to the robot. Links stop the robot by themselves when none comes for 0.5 s.
    Drive(Drive),
    /// Run a job and hand its result back as `Input::JobDone`.
    StartJob {
        /// Its name.
        job: JobId,
        /// What to do.
        work: Job,
    },
    /// Publish state to all clients.
    Publish(Publication),
    /// Write these events to durable storage, in this order, then answer with `Input::Committed`. The stack acts on them after the answer.
    Commit {
        /// Number of the commit, counted up from 0.
        seq: u64,
        /// The events.
        events: Vec<LedgerEvent>,
    },
    /// Call an action. Feedback and result come as `Input::ActionFeedback` and `Input::ActionDone`.
    CallAction {
        /// Id of the call.
        call: ActionCallId,
        /// Registered name of the action.
        action: String,
        /// Parameters as JSON, as the action's schema has it. With a `target_m` (metres, map frame) the shell aims the camera by the latest [`Estimate`]; the body is
        /// turned by whoever calls.
        parameters: String,
    },
    /// Cancel a call. It still ends with `Input::ActionDone`.
    CancelAction(ActionCallId),
    /// Answer a command. Only the client that sent it gets the answer.
    Answer {
        /// Id of the command.
        id: CommandId,
        /// The client that sent it.
        to: ClientId,
        /// `None` when it was accepted; else one sentence: why not and what to do.
        refused: Option<String>,
    },
}

/// A velocity command to the robot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Drive {
    /// Wanted velocity of the base in its own frame; zero stops.
    pub velocity: Twist,
}

/// Points as parallel columns. The type that contains them documents their frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Cloud {
    /// Metres.
    pub xyz: Vec<[f32; 3]>,
    /// Sensor units, or empty.
    pub intensity: Vec<f32>,
}

/// State that the stack publishes to clients.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Publication {
    /// Estimate of the robot's pose; after every scan, and at 20 Hz between scans.
    Estimate(Estimate),
    /// A motion-corrected scan.
    Scan(CorrectedScan),
    /// A new keyframe of the map under construction. The shell keeps its cloud until the session is saved or discarded.
    Keyframe(Keyframe),
    /// The whole pose graph: at the beginning of a session, and as the answer to [`crate::Input::GraphRequested`]. Afterwards it changes by
    /// [`Self::GraphDelta`].
    Graph {
        /// Which mapping session.
        session: SessionId,
        /// Its graph.
        graph: Arc<PoseGraph>,
    },
    /// A pair of keyframes was decided on.
    LoopDecided(LoopDecision),
    /// The robot's pose on known ground was measured against an old keyframe.
    Reanchored(Reanchored),
    /// Quality of the map under construction; every few seconds while it changes.
    Quality(MapQuality),
    /// State of mapping.
    Mapping(MappingState),
    /// State of localisation in a saved map.
    Localisation(LocalisationState),
    /// Docks of saved maps: all that are known now.
    Docks(Arc<[PoseInMap]>),
    /// State of motion.
    Motion(MotionState),
    /// A goal was accepted, has made progress, or has ended.
    Goal(GoalUpdate),
    /// State of the executive.
    Executive(ExecutiveStatus),
    /// Holder of the control lease.
    Control(ControlState),
    /// State of sensors and odometry; at 1 Hz and on change.
    Health(Health),
    /// State of the battery.
    Battery(BatteryState),
    /// A message for people.
    Notice(Notice),
    /// The pose graph changed: keyframes and edges were added or removed, or poses moved.
    GraphDelta(Arc<GraphDelta>),
    /// State of missions: when it changes.
    Missions(Arc<MissionStatus>),
    /// Place on the topological map and route: when they change.
    Route(Arc<RouteStatus>),
}

/// Estimate of the robot's pose with its covariance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The instant of the estimate.
    pub stamp: Stamp,
    /// Base in the map in use.
    pub map_from_base: Pose,
    /// Velocity of the base in its own frame.
    pub velocity: Twist,
    /// Of `map_from_base`.
    pub covariance: Covariance6,
    /// Degenerate directions of the last registration, as unit vectors in the base frame. Other sensors determine the pose along them.
    pub degenerate: [Option<Vec3>; 3],
    /// Distance walked since boot, metres.
    pub distance_m: f64,
}

/// A motion-corrected scan.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CorrectedScan {
    /// The instant to which all points were moved.
    pub stamp: Stamp,
    /// Base in the map at `stamp`.
    pub map_from_base: Pose,
    /// Points in the base frame.
    pub cloud: Arc<Cloud>,
}

/// A keyframe with its cloud.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Keyframe {
    /// The mapping session it belongs to.
    pub session: SessionId,
    /// Counts from 0 within the session.
    pub id: KeyframeId,
    /// The instant of its pose.
    pub stamp: Stamp,
    /// Base at that instant in the map.
    pub map_from_keyframe: Pose,
    /// Motion-corrected points in the keyframe's frame.
    pub cloud: Arc<Cloud>,
    /// Position of the LiDAR, keyframe's frame, metres.
    pub lidar: [f32; 3],
}

/// Poses and edges of the map under construction.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PoseGraph {
    /// Grows with every change.
    pub revision: u64,
    /// Every keyframe's pose in the map, in the order of their ids.
    pub nodes: Vec<GraphNode>,
    /// Every edge: those of the odometry, then loops, each in the order of creation.
    pub edges: Vec<GraphEdge>,
}

/// One keyframe's pose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GraphNode {
    /// Id of the keyframe.
    pub id: KeyframeId,
    /// When it was made.
    pub stamp: Stamp,
    /// Its pose in the map.
    pub map_from_keyframe: Pose,
}

/// A measured relative pose between two keyframes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GraphEdge {
    /// Parent keyframe.
    pub from: KeyframeId,
    /// Child keyframe.
    pub to: KeyframeId,
    /// Its kind.
    pub kind: EdgeKind,
    /// Measured pose of `to` in `from`.
    pub from_from_to: Pose,
    /// Information (inverse covariance), `[rotation; translation]`.
    pub information: [[f64; 6]; 6],
}

/// Kind of an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum EdgeKind {
    /// Consecutive keyframes.
    Odometry,
    /// A loop closure between keyframes of the same place.
    Loop,
}

/// State of localisation in a saved map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum LocalisationState {
    /// No saved map is in use.
    #[default]
    Idle,
    /// The map is being read.
    Loading {
        /// The map.
        map: MapId,
    },
    /// The robot's pose in the map is not known.
    Relocalising {
        /// The map.
        map: MapId,
        /// Number of poses at which the robot may be; 0 where it has to move to see more.
        hypotheses: u32,
    },
    /// The robot's pose in the map is known.
    Localised {
        /// The map.
        map: MapId,
        /// What speaks against it, if anything does.
        degradation: Option<DegradationReason>,
    },
}

/// What speaks against the robot's pose in a saved map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum DegradationReason {
    /// The scans are not what the map shows there.
    MapMismatch,
    /// The covariance of the pose is too large.
    PoseUncertain,
    /// The LiDAR sees nothing.
    LidarBlind,
    /// The map shows nothing of what the LiDAR sees: the robot has left it.
    Unmapped,
    /// The pose was given, and the rest of the map has not been searched yet for poses that look alike.
    Unconfirmed,
}

/// State of mapping.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum MappingState {
    /// No session.
    #[default]
    Idle,
    /// Waiting for the robot to stand still for gravity and biases.
    Starting {
        /// Which session.
        session: SessionId,
    },
    /// The saved map that the session extends is being read.
    Loading {
        /// Which session.
        session: SessionId,
        /// Which map.
        map: MapId,
    },
    /// The robot is not localised in that map yet. Nothing is added to it, and poses are not in its frame.
    Finding {
        /// Which session.
        session: SessionId,
        /// Which map.
        map: MapId,
        /// Distance walked in this state, metres.
        distance_m: f64,
        /// Whether the walk so far fits the map at two poses.
        ambiguous: bool,
    },
    /// Building.
    Mapping {
        /// Which session.
        session: SessionId,
        /// The saved map that it extends, if any.
        extends: Option<MapId>,
        /// Since when.
        since: Stamp,
        /// Distance walked in it, metres.
        distance_m: f64,
        /// Keyframes so far.
        keyframes: u32,
        /// Whether the map already shows what the robot sees, so that it does not grow.
        on_known_ground: bool,
    },
    /// Being written.
    Saving {
        /// Which session.
        session: SessionId,
        /// Which version it becomes.
        map: MapId,
    },
}

impl MappingState {
    /// The running session.
    pub fn session(&self) -> Option<SessionId> {
        match self {
            Self::Idle => None,
            Self::Loading { session, .. }
            | Self::Starting { session }
            | Self::Finding { session, .. }
            | Self::Mapping { session, .. }
            | Self::Saving { session, .. } => Some(*session),
        }
    }
}

/// Quality of the map under construction.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MapQuality {
    /// Revision of the pose graph from which it was computed. The graph may have changed since.
    pub revision: u64,
    /// Floor seen from near, square metres.
    pub covered_m2: f64,
    /// Floor seen from afar only, square metres.
    pub from_afar_m2: f64,
    /// Standard deviation of each keyframe's position relative to the first keyframe, metres.
    pub deviations_m: Vec<f32>,
    /// Where to walk, or walk again, the most useful first.
    pub targets: Vec<SurveyTarget>,
}

/// A place worth walking to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SurveyTarget {
    /// On the floor, map frame, metres.
    pub at: Vec3,
    /// Why.
    pub why: SurveyReason,
}

/// Why a place is worth walking to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum SurveyReason {
    /// The floor around it was seen from afar only.
    FromAfar {
        /// Area of that floor, square metres.
        area_m2: f64,
    },
    /// The map is uncertain there.
    Uncertain {
        /// Standard deviation of positions there, metres.
        deviation_m: f64,
    },
}

/// State of motion.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum MotionState {
    /// Standing, free to move.
    #[default]
    Idle,
    /// Stopped by a person. The robot does not move until a person allows it.
    Stopped {
        /// Who stopped it, if known.
        by: Option<ClientId>,
    },
    /// Driven by hand.
    Teleoperated,
    /// Walking to a point.
    Walking {
        /// Where to, map frame.
        goal: Vec3,
        /// The path to it, map frame.
        path: Vec<Vec3>,
        /// Distance along the path to the goal, metres.
        remaining_m: f64,
    },
    /// Standing on the path to a point, because the LiDAR sees nothing. It continues by itself.
    Waiting {
        /// Where to, map frame.
        goal: Vec3,
    },
    /// Relocalising in the map. It continues by itself when its pose is known.
    Relocalising {
        /// The point to which it walks then, map frame, if any.
        goal: Option<Vec3>,
    },
    /// The goal was given up; the reason is for people.
    Blocked {
        /// Where to, map frame.
        goal: Vec3,
        /// One clear sentence.
        reason: String,
    },
}

/// Holder of the control lease.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ControlState {
    /// Holder of the lease.
    pub owner: Option<ClientId>,
    /// Name of the holder, for people.
    pub name: String,
}

/// State of sensors and odometry.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Health {
    /// One entry per sensor that has sent a message.
    pub sensors: Vec<SensorHealth>,
    /// One entry per problem, the most serious first.
    pub findings: Vec<Finding>,
    /// Points of the last scan that entered registration.
    pub points_used: u32,
}

/// State of one sensor.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SensorHealth {
    /// For people: "LiDAR", "IMU", "Legs".
    pub name: String,
    /// Messages per second over the last few seconds.
    pub rate_hz: f32,
    /// Since the last message.
    pub age: Span,
}

/// A problem of a sensor or its setup, with its remedy.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Finding {
    /// How bad.
    pub severity: Severity,
    /// What is wrong, one sentence.
    pub what: String,
    /// What to do, one sentence.
    pub remedy: String,
}

/// How bad.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the names say it")]
pub enum Severity {
    Info,
    Warning,
    Error,
}

/// A message for people.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Notice {
    /// When.
    pub at: Stamp,
    /// How bad.
    pub severity: Severity,
    /// What happened and what comes next.
    pub text: String,
}

/// A finished mapping session without clouds. Each cloud was published with its [`Publication::Keyframe`], and the shell keeps it on disk by
/// session and keyframe, so that memory does not grow with the walk.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FinishedMap {
    /// Id of the version.
    pub map: MapId,
    /// Name, for people.
    pub name: String,
    /// Session it came from.
    pub session: SessionId,
    /// The saved map that it extends. The keyframes of that map come first; its trajectory and decisions are not repeated here.
    pub extends: Option<MapId>,
    /// When it was finished.
    pub at: Stamp,
    /// Distance walked, metres.
    pub distance_m: f64,
    /// Final graph, with the final pose of every keyframe.
    pub graph: Arc<PoseGraph>,
    /// Pose of the base in the map after every scan, with final corrections. In sessions of hours, old parts have a pose after some scans only.
    pub trajectory: Vec<(Stamp, Pose)>,
    /// Segments in which the registration of scans was degenerate in some direction.
    pub degenerate: Vec<DegenerateSegment>,
    /// All loop decisions in their order.
    pub decisions: Vec<LoopDecision>,
    /// Number of proposed pairs that were not compared for lack of time.
    pub unverified: u64,
    /// Comparisons on known ground.
    pub revisits: RevisitCounts,
}

/// Numbers of comparisons of scans with old keyframes on known ground.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RevisitCounts {
    /// Comparisons made.
    pub compared: u64,
    /// Comparisons that confirmed the expected pose, or nearly.
    pub confirmed: u64,
}

/// A segment of the walk in which the registration of scans was degenerate in some direction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DegenerateSegment {
    /// First scan of it.
    pub from: Stamp,
    /// Last scan of it.
    pub until: Stamp,
    /// Distance walked in it, metres.
    pub distance_m: f64,
}
