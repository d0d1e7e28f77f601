//! What leaves the stack.

use crate::{
    BatteryState, DisambiguationTask, ExecutiveStatus, GoalUpdate, GraphDelta, LoopDecision, LoopTask,
    MapSearchTask, PoseInMap, Reanchored, RelocalisationTask, RevisitTask,
};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use vocab::{
    ActionCallId, ClientId, CommandId, Covariance6, KeyframeId, MapId, Pose, SessionId, Span, Stamp, Twist,
    Vec3,
};

/// What the shell has to do after a step, in this order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum StackEffect {
    /// Tell the robot how to move. Links stop the robot by themselves when these cease for 0.5 s.
    Drive(Drive),
    /// Run a job and hand its result back as `Input::JobDone`.
    StartJob {
        /// Number of the job, counted up from 0.
        job: u64,
        /// What to do.
        work: Job,
    },
    /// Tell whoever listens.
    Publish(Publication),
    /// Make these durable, in this order, then answer with `Input::Committed`. What follows from them is done after the answer.
    Commit {
        /// Number of the commit, counted up from 0.
        seq: u64,
        /// What is to be durable.
        events: Vec<LedgerEvent>,
    },
    /// Call an action. Feedback and result come as `Input::ActionFeedback` and `Input::ActionDone`.
    CallAction {
        /// Names the call.
        call: ActionCallId,
        /// Registered name of the action.
        action: String,
        /// Parameters as JSON, as the action's schema has it.
        parameters: String,
    },
    /// Cancel a call. It still ends with `Input::ActionDone`.
    CancelAction(ActionCallId),
    /// Answer a command, to its maker only.
    Answer {
        /// Which command.
        id: CommandId,
        /// Its maker.
        to: ClientId,
        /// `None` when it was accepted; else one sentence: why not and what to do.
        refused: Option<String>,
    },
}

/// An event that must be durable before the stack acts on it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum LedgerEvent {
    /// A goal was accepted or has ended.
    Goal(GoalUpdate),
}

/// A velocity command to the robot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Drive {
    /// Wanted velocity of the base in its own frame; zero stops.
    pub velocity: Twist,
}

/// ComputeJob too long for a step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Job {
    /// Write a finished map as an immutable version.
    SaveMap(Arc<FinishedMap>),
    /// Look whether two keyframes saw the same place. The stack keeps what that takes until it is fetched with
    /// `Stack::take_compute_job`; a replay never fetches it, because the result is in the log.
    VerifyLoop(LoopTask),
    /// Compare what is seen now with an old keyframe; as for [`Self::VerifyLoop`].
    CompareRevisit(RevisitTask),
    /// Read a saved map that a session goes on from, and make its clouds the session's first.
    LoadMap {
        /// The session.
        session: SessionId,
        /// The saved map.
        map: MapId,
    },
    /// Look for the robot's place in that map; as for [`Self::VerifyLoop`].
    SearchMap(MapSearchTask),
    /// Read a saved map to be localised in.
    ReadMap(MapId),
    /// Look where the robot may stand in it; as for [`Self::VerifyLoop`].
    Relocalise(RelocalisationTask),
    /// Look which way to walk to tell places in it apart; as for [`Self::VerifyLoop`].
    PlanDisambiguation(DisambiguationTask),
}

/// Points in the frame that the holder names, as parallel columns.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Cloud {
    /// Metres.
    pub xyz: Vec<[f32; 3]>,
    /// Sensor units, or empty.
    pub intensity: Vec<f32>,
}

/// What the stack says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Publication {
    /// Where the robot is; after every scan, and at 20 Hz between them.
    Estimate(Estimate),
    /// A motion-corrected scan.
    Scan(CorrectedScan),
    /// A new keyframe of the map under construction. The shell keeps its cloud until the session is saved or discarded.
    Keyframe(Keyframe),
    /// The whole pose graph: at the beginning, and whenever changes alone do not say it. Afterwards it changes by [`Self::GraphDelta`].
    Graph(Arc<PoseGraph>),
    /// A pair of keyframes was decided on.
    LoopDecided(LoopDecision),
    /// The robot found its place on known ground.
    Reanchored(Reanchored),
    /// How good the map under construction is; every few seconds while it changes.
    Quality(MapQuality),
    /// State of mapping.
    Mapping(MappingState),
    /// State of localisation in a saved map.
    Localisation(LocalisationState),
    /// Docks of saved maps: all that are known now.
    Docks(Arc<[PoseInMap]>),
    /// State of motion.
    Motion(MotionState),
    /// A goal was accepted, has got on, or has ended.
    Goal(GoalUpdate),
    /// State of the executive.
    Executive(ExecutiveStatus),
    /// Who controls.
    Control(ControlState),
    /// State of sensors and odometry; at 1 Hz and on change.
    Health(Health),
    /// The battery spoke.
    Battery(BatteryState),
    /// Something people should read.
    Notice(Notice),
    /// The pose graph changed: keyframes and edges were added or removed, or poses moved.
    GraphDelta(Arc<GraphDelta>),
}

/// Where the robot is and how sure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The instant of the estimate.
    pub stamp: Stamp,
    /// Base in the map of the session.
    pub map_from_base: Pose,
    /// Velocity of the base in its own frame.
    pub velocity: Twist,
    /// Of `map_from_base`.
    pub covariance: Covariance6,
    /// Directions that the LiDAR did not see, as unit vectors in the base frame, carried by other sources.
    pub degenerate: [Option<Vec3>; 3],
    /// Metres walked since boot.
    pub distance: f64,
}

/// A scan with the robot's motion during the sweep taken out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CorrectedScan {
    /// The instant to which all points were moved.
    pub stamp: Stamp,
    /// Base in the map at `stamp`.
    pub map_from_base: Pose,
    /// Points in the base frame.
    pub cloud: Arc<Cloud>,
}

/// A place of the pose graph with its cloud.
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
    /// Where the LiDAR was that saw them, keyframe's frame, metres.
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
    /// Which keyframe.
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
    /// What made it.
    pub kind: EdgeKind,
    /// Measured pose of `to` in `from`.
    pub from_from_to: Pose,
    /// Information (inverse covariance), `[rotation; translation]`.
    pub information: [[f64; 6]; 6],
}

/// What made an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum EdgeKind {
    /// Consecutive keyframes.
    Odometry,
    /// The walk came back to a place.
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
    /// A saved map is being read, that the session goes on from.
    Loading {
        /// Which session.
        session: SessionId,
        /// Which map.
        map: MapId,
    },
    /// The robot looks for its place in that map; nothing is added to it yet, and poses are not of its frame.
    Finding {
        /// Which session.
        session: SessionId,
        /// Which map.
        map: MapId,
        /// Metres walked while looking.
        distance: f64,
        /// Whether what was seen so far fits in two ways.
        ambiguous: bool,
    },
    /// Building.
    Mapping {
        /// Which session.
        session: SessionId,
        /// The saved map that it goes on from.
        extends: Option<MapId>,
        /// Since when.
        since: Stamp,
        /// Metres walked in it.
        distance: f64,
        /// Keyframes so far.
        keyframes: u32,
        /// Whether the robot is where the map shows everything already, so that it does not grow.
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

/// How good a map is while it is made.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MapQuality {
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
    /// Area of the floor around it that was seen from afar only, square metres.
    FromAfar(f64),
    /// Standard deviation of the map there, metres.
    Uncertain(f64),
}

/// State of motion.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum MotionState {
    /// Standing, free to move.
    #[default]
    Idle,
    /// Stopped by somebody; nothing moves until allowed again.
    Stopped {
        /// Who pressed it, if known.
        by: Option<ClientId>,
    },
    /// Driven by hand.
    Teleoperated,
    /// Walking to a point.
    Walking {
        /// Where to, map frame.
        goal: Vec3,
        /// The way there, map frame.
        path: Vec<Vec3>,
        /// Metres to go.
        remaining: f64,
    },
    /// On its way to a point, and standing because it sees nothing; goes on by itself.
    Waiting {
        /// Where to, map frame.
        goal: Vec3,
    },
    /// Looking about to find its place in the map; goes on by itself once it knows.
    Looking {
        /// Where it goes then, map frame, if anywhere.
        goal: Option<Vec3>,
    },
    /// Could not go on; the reason is for people.
    Blocked {
        /// Where to, map frame.
        goal: Vec3,
        /// One clear sentence.
        reason: String,
    },
}

/// Who controls the robot.
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
    /// One entry per sensor that was heard or is expected.
    pub sensors: Vec<SensorHealth>,
    /// One entry per thing that is wrong, most serious first.
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

/// Something wrong with a sensor or its setup, with what to do about it.
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

/// Something people should read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Notice {
    /// When.
    pub at: Stamp,
    /// How bad.
    pub severity: Severity,
    /// Says what happened and what comes next.
    pub text: String,
}

/// A finished mapping session. The clouds are not in it: each went out with its [`Publication::Keyframe`], and the
/// shell keeps them on disk by session and keyframe, so that memory does not grow with the walk.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FinishedMap {
    /// Id of the version.
    pub map: MapId,
    /// Name, for people.
    pub name: String,
    /// Session it came from.
    pub session: SessionId,
    /// The saved map that it goes on from, whose keyframes come first. Its trajectory and decisions are not repeated here.
    pub extends: Option<MapId>,
    /// When it was finished.
    pub at: Stamp,
    /// Metres walked.
    pub distance: f64,
    /// Final graph, with the final pose of every keyframe.
    pub graph: Arc<PoseGraph>,
    /// Base in the map after every scan, with final corrections; in sessions of hours, of what was walked long ago after some scans.
    pub trajectory: Vec<(Stamp, Pose)>,
    /// Stretches in which the LiDAR alone could not tell the motion in some direction.
    pub degenerate: Vec<DegenerateStretch>,
    /// Every pair of keyframes that was decided on, in that order.
    pub decisions: Vec<LoopDecision>,
    /// Pairs that there was no time to look at.
    pub unverified: u64,
    /// What became of walks over known ground.
    pub revisits: RevisitCounts,
}

/// Comparisons of what is seen with old keyframes, on known ground.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RevisitCounts {
    /// Made.
    pub compared: u64,
    /// That found the robot where it was expected, or nearly.
    pub confirmed: u64,
}

/// A stretch of the walk in which the LiDAR did not see some direction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DegenerateStretch {
    /// First scan of it.
    pub from: Stamp,
    /// Last scan of it.
    pub until: Stamp,
    /// Metres walked in it.
    pub distance: f64,
}
