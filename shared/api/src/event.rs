//! Events for clients. Every event replaces the last of its kind unless its documentation says otherwise.

use crate::{
    BinnedMap, CommandOutcome, DamagedMap, EditDone, ExecutiveStatus, Goal, GraphChanged, GraphPart,
    LoopsChanged, MapSummary, SiteChanged, SitePart, StoredResult, TileEntry, TopomapGeneration,
};
use serde::{Deserialize, Serialize};
use site_model::{MissionStatus, RouteStatus};
use vocab::{
    CameraHead, ClientId, CommandId, Covariance6, KeyframeId, MapId, Pose, SessionId, Span, Stamp, Twist,
    UploadId, Vec3,
};

/// One piece of state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Event {
    /// Estimate of the robot's pose.
    Estimate(Estimate),
    /// Poses and edges of the current mapping session; empty without one. It changes by [`Self::GraphChanged`].
    Graph(Graph),
    /// Tiles of the current mapping session: adds to what was sent, unless `reset`.
    Tiles(TilesChanged),
    /// Quality of the map of the current mapping session; empty without one.
    Quality(Quality),
    /// State of mapping.
    Mapping(Mapping),
    /// State of localisation in a saved map.
    Localisation(Localisation),
    /// State of motion.
    Motion(Motion),
    /// State of the executive.
    Executive(ExecutiveStatus),
    /// The newest goals with their outcomes, the newest first, [`crate::MAX_GOALS`] at most.
    Goals(Vec<Goal>),
    /// Holder of the control lease.
    Control(Control),
    /// Sensors and odometry.
    Health(Health),
    /// Battery.
    Battery(Battery),
    /// Saved maps, newest first.
    Maps(Vec<MapSummary>),
    /// Pairs of keyframes decided on in the current mapping session: adds to what was sent, unless `reset`.
    Loops(LoopsChanged),
    /// A message for people; adds to those before.
    Notice(Notice),
    /// Answer to a command, to the client that sent it only.
    CommandDone {
        /// Id of the command.
        id: CommandId,
        /// Its outcome.
        outcome: CommandOutcome,
    },
    /// State of the server itself.
    Platform(Platform),
    /// State of the running or the last import.
    Import(Import),
    /// Docks of saved maps, as the robot recorded them while it was charged.
    Docks(Vec<MapDock>),
    /// Changes of the graph of the current mapping session; adds to [`Self::Graph`]. See [`GraphChanged`] for what to do if they do not apply.
    GraphChanged(GraphChanged),
    /// Saved maps that cannot be read, in the order of their folders' names. They are not in [`Self::Maps`].
    DamagedMaps(Vec<DamagedMap>),
    /// Mapping sessions that ended with their process, the newest first. Each waits until a person saves or discards it.
    InterruptedSessions(Vec<InterruptedSession>),
    /// Deleted maps, the last deleted first.
    BinnedMaps(Vec<BinnedMap>),
    /// Uploaded files that wait to be imported, or to be imported again after a failure; the oldest first.
    Uploads(Vec<StoredUpload>),
    /// A part of a graph that takes the place of [`Self::Graph`] where that would be too long for one message.
    GraphPart(GraphPart),
    /// A part of the whole site, the documents that people edit. It changes by [`Self::SiteChanged`].
    SitePart(SitePart),
    /// An edit of the site; adds to what was sent. See [`SiteChanged`] for what to do if it does not apply.
    SiteChanged(SiteChanged),
    /// Answer to an edit, to the client that sent it only.
    EditDone(EditDone),
    /// State of missions.
    Missions(MissionStatus),
    /// Where the robot is on the topological map, and the route that it follows.
    Route(RouteStatus),
    /// State of the making of a topological map, or how the last one ended.
    TopomapGeneration(TopomapGeneration),
    /// A result of a run is durable; adds to what was sent, in the order of its number. It is sent again once its picture was compared with an earlier one. Earlier ones, and those that a
    /// client has missed, are asked for over HTTP.
    ResultStored(StoredResult),
    /// The actions that can be called now.
    Actions(Vec<OfferedAction>),
}

/// An action that can be called.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct OfferedAction {
    /// Its name, such as `photo`.
    pub name: String,
    /// Shown to people.
    pub title: String,
    /// JSON Schema of its parameters.
    pub parameter_schema: String,
    /// How long it is expected to take with the parameters that the schema has as defaults.
    pub expected: Span,
    /// Energy that it is expected to take then besides what the standing robot takes, joules.
    pub expected_energy_j: u32,
    /// Whether it can be repeated without harm.
    pub is_idempotent: bool,
}

/// An uploaded file that no map was made of yet.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StoredUpload {
    /// Its id. [`crate::Command::ImportMap`] makes a map of it.
    pub upload: UploadId,
    /// Name of the map that it was to become, if that was tried.
    pub name: Option<String>,
    /// The saved map whose frame that map was to have, if any.
    pub frame: Option<MapId>,
    /// Its size.
    pub bytes: u64,
    /// Why the last import of it failed, one sentence; none if none was tried.
    pub problem: Option<String>,
    /// When it is deleted, by calendar time. None while the clock of the robot's computer is not synchronised: then it stays.
    pub kept_until: Option<Stamp>,
}

/// A mapping session that its process did not end, because it was killed or the power went.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InterruptedSession {
    /// The session.
    pub session: SessionId,
    /// Instant of its last scan, robot's clock.
    pub at: Stamp,
    /// Keyframes that can be saved, those of the map that it extends included. 0 where its files are damaged: it can only be discarded.
    pub keyframes: u32,
    /// Metres walked in it.
    pub distance_m: f64,
    /// The saved map that it extends, if any.
    pub extends: Option<MapId>,
}

/// A dock of a saved map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MapDock {
    /// The saved map.
    pub map: MapId,
    /// The base there while it is charged.
    pub map_from_base: Pose,
}

/// State of an import: the making of a map of an uploaded point cloud, or the alignment of a saved map.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Import {
    /// None so far.
    #[default]
    None,
    /// It runs.
    Running {
        /// The file.
        upload: UploadId,
        /// Name of the map.
        name: String,
        /// Its present stage.
        stage: ImportStage,
        /// Share of the stage that is done, 0 to 1.
        share: f32,
    },
    /// The map was made.
    Done {
        /// The file.
        upload: UploadId,
        /// The map.
        map: MapId,
    },
    /// The map could not be made.
    Failed {
        /// The file.
        upload: UploadId,
        /// Name of the map that it should have been.
        name: String,
        /// What is wrong and what to do, one sentence.
        reason: String,
    },
}

/// Stage of an import.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ImportStage {
    /// The file is read.
    #[default]
    Reading,
    /// Virtual viewpoints are computed: poses at which a robot could stand, and the points visible from them.
    ComputingViewpoints,
    /// The map is written.
    Writing,
    /// A simulated robot walks through the example, and maps it.
    Walking,
    /// The topological map of the example is made.
    MakingTopomap,
}

/// Estimate of the robot's pose with its covariance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The instant of the estimate, robot's clock.
    pub stamp: Stamp,
    /// Base in the map.
    pub map_from_base: Pose,
    /// Velocity of the base in its own frame.
    pub velocity: Twist,
    /// Of `map_from_base`.
    pub covariance: Covariance6,
    /// Number of degenerate directions of the last registration.
    pub degenerate: u8,
    /// Distance walked since the stack started, metres.
    pub distance_m: f64,
}

/// Poses and edges of a pose graph.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Graph {
    /// Which session; `None` for a saved map.
    pub session: Option<SessionId>,
    /// Grows with every change within a session. Changes apply to exactly one revision.
    #[serde(default)]
    pub revision: u64,
    /// Keyframes in the map, in the order of their ids.
    pub nodes: Vec<GraphNode>,
    /// Edges of the odometry as pairs of keyframes.
    pub edges: Vec<(KeyframeId, KeyframeId)>,
    /// Closed loops as pairs of keyframes, the older first.
    #[serde(default)]
    pub loops: Vec<(KeyframeId, KeyframeId)>,
}

/// One keyframe.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GraphNode {
    /// Which.
    pub id: KeyframeId,
    /// When it was made.
    pub stamp: Stamp,
    /// Its pose in the map.
    pub map_from_keyframe: Pose,
}

/// Quality of the map under construction.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// Floor seen from near, square metres.
    pub covered_m2: f64,
    /// Floor seen from afar only, square metres.
    pub from_afar_m2: f64,
    /// Standard deviation of each keyframe's position relative to the first keyframe, metres.
    pub deviations_m: Vec<f32>,
    /// Where to walk, or walk again, the most useful first.
    pub targets: Vec<SurveyTarget>,
}

impl Quality {
    /// Standard deviation of a keyframe's position relative to the first keyframe, metres; `None` where it is not known.
    pub fn deviation_of(&self, keyframe: KeyframeId) -> Option<f32> {
        self.deviations_m.get(keyframe.0 as usize).copied()
    }
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

/// New tiles.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TilesChanged {
    /// Forget the tiles sent before.
    pub reset: bool,
    /// Tiles that came.
    pub added: Vec<TileEntry>,
}

/// State of mapping.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Mapping {
    /// No session.
    #[default]
    Idle,
    /// The robot stands still to find gravity.
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
    /// The robot is not localised in that map yet. Nothing is added to it, and estimates are not in its frame.
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
    Running {
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
        /// Which version it becomes.
        map: MapId,
    },
}

/// State of localisation in a saved map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Localisation {
    /// No saved map is in use.
    #[default]
    Idle,
    /// It is being read.
    Loading {
        /// Which.
        map: MapId,
    },
    /// The robot's pose in the map is not known.
    Relocalising {
        /// Which.
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

impl Localisation {
    /// The saved map in use, if any.
    pub fn map(&self) -> Option<MapId> {
        match self {
            Self::Idle => None,
            Self::Loading { map } | Self::Relocalising { map, .. } | Self::Localised { map, .. } => {
                Some(*map)
            }
        }
    }
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

/// State of motion.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Motion {
    /// Standing, free to move.
    #[default]
    Idle,
    /// Stopped by somebody.
    Stopped {
        /// By whom, if known.
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
    /// The goal was given up.
    Blocked {
        /// Where to, map frame.
        goal: Vec3,
        /// Why, for people.
        reason: String,
    },
}

/// Holder of the control lease.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Control {
    /// Holder of the lease.
    pub owner: Option<ClientId>,
    /// Name of the holder.
    pub name: String,
    /// Somebody who asks for the lease. The holder can refuse.
    pub request: Option<ControlRequest>,
}

/// Somebody asks for the control lease, which another client has.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ControlRequest {
    /// Who.
    pub by: ClientId,
    /// Name, for people.
    pub name: String,
    /// Time in which the holder can refuse, when this was published, s.
    pub seconds_left: f32,
}

/// Sensors and odometry.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Health {
    /// One entry per sensor.
    pub sensors: Vec<SensorHealth>,
    /// What is wrong, most serious first.
    pub findings: Vec<Finding>,
    /// Points of the last scan that entered registration.
    pub points_used: u32,
}

/// One sensor.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SensorHealth {
    /// For people.
    pub name: String,
    /// Messages per second.
    pub rate_hz: f32,
    /// Since the last message.
    pub age: Span,
}

/// A problem of a sensor or its setup, with its remedy.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Finding {
    /// How bad.
    pub severity: Severity,
    /// What is wrong.
    pub what: String,
    /// What to do.
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

/// The battery.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Battery {
    /// When it was measured.
    pub stamp: Stamp,
    /// Charge, 0 to 1.
    pub charge: f32,
    /// Predicted time until it is empty, or until it is full while it charges, if known.
    pub left: Option<Span>,
    /// Whether it charges.
    pub charging: bool,
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

/// Greatest number of tiles in one event: about 50 kB, so that a pose does not wait until a large map has been sent.
pub const MAX_TILES_PER_EVENT: usize = 512;

/// Greatest number of saved maps in a list, the newest: about 1.5 MB. Older ones stay on the disk.
pub const MAX_LISTED_MAPS: usize = 10_000;

impl Notice {
    /// Greatest number of notices that are kept for a client that connects later, the newest.
    pub const MAX_KEPT: usize = 50;
}

/// The server itself.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Platform {
    /// Name of the robot.
    pub robot: String,
    /// Name of the site, if the robot is simulated.
    pub site: Option<String>,
    /// Robot's clock when this was measured.
    pub now: Stamp,
    /// Robot time over real time in the last second; below 1 the stack falls behind.
    pub real_time_factor: f32,
    /// CPU of core and gateway, cores.
    pub cpu_cores: f32,
    /// Resident memory of core and gateway, bytes.
    pub memory_bytes: u64,
    /// Free space for recordings, bytes.
    pub disk_free_bytes: u64,
    /// Whether core and gateway are connected.
    pub core_connected: bool,
    /// Clients connected.
    pub clients: u32,
    /// Processes that failed since the platform was started and run again, each with its last failure.
    pub restarts: Vec<ProcessRestart>,
    /// Speed limits while a person drives the robot, of its profile. None while no core has told them: the robot cannot be driven then.
    pub manual_limits: Option<SpeedLimits>,
    /// The robot's body, of its profile. None while no core has told it.
    pub body: Option<RobotBody>,
    /// Speed limits while the robot walks by itself, of its profile. None while no core has told them.
    pub autonomous_limits: Option<SpeedLimits>,
    /// The disk of the data directory. None while no core has told it, or where the system does not say.
    pub disk: Option<DiskUse>,
}

/// The disk of the data directory, and what recordings take of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DiskUse {
    /// Size of the disk, bytes. What is neither free nor of this is used, by whatever program.
    pub total_bytes: u64,
    /// What recordings take, bytes.
    pub recordings_bytes: u64,
    /// What recordings may take, bytes: beyond it the oldest are deleted.
    pub max_recordings_bytes: u64,
}

/// The space that the robot's body takes and what it steps over.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RobotBody {
    /// Radius of the circle that it turns in, metres.
    pub footprint_radius_m: f64,
    /// Height over the ground that must be free for it to pass, metres.
    pub clearance_height_m: f64,
    /// Height of the base over the ground while it stands, metres.
    pub standing_height_m: f64,
    /// Highest step that it takes, metres.
    pub step_height_m: f64,
    /// The head of its cameras.
    pub camera_head: CameraHead,
}

/// Greatest speeds of the base in its own frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpeedLimits {
    /// Forwards and backwards, m/s.
    pub forward_m_s: f64,
    /// To either side, m/s.
    pub sideways_m_s: f64,
    /// Turning to either side, rad/s.
    pub turn_rad_s: f64,
}

/// A process that failed and was started again.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ProcessRestart {
    /// Its role.
    pub process: ProcessRole,
    /// What it did, a clause after its name: "did not answer for 5 s".
    pub cause: String,
    /// How often it was started again since the platform was started.
    pub count: u32,
}

/// A supervised process.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ProcessRole {
    /// The robot's core.
    Core,
    /// The server for browsers.
    Gateway,
    /// The simulated robot.
    SimulatedRobot,
}
