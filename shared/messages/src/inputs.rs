//! Inputs of the stack.

use crate::{GoalKind, JobDone, RobotProfile, Sensor};
use serde::{Deserialize, Serialize};
use site_model::{Edit, MissionCommandKind, MissionEvent, ObjectId, Revision, Versioned};
use std::sync::Arc;
use vocab::{
    ActionCallId, ClientId, CommandId, GoalId, KeyframeId, MapId, Pose, Role, SessionId, Span, Twist,
};

/// One step's input. A log of these, with their `at`, is all that is needed to repeat a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Input {
    /// First input of every log: the robot's profile and the setup of the stack.
    Boot(Box<BootRecord>),
    /// A tick of the clock, at 20 Hz, with or without sensor messages.
    Tick,
    /// A sensor message.
    Sensor(Sensor),
    /// A command of a client.
    Command(Command),
    /// A job that the stack started has ended.
    JobDone(JobDone),
    /// The calendar time, once a second. Time-outs use the step's `at` only.
    WallClock {
        /// Nanoseconds since 1970-01-01 UTC.
        utc_ns: i64,
        /// Whether the computer's clock is known to follow a time server. Schedules wait while it is not.
        synchronised: bool,
    },
    /// What [`crate::StackEffect::Commit`] asked for is durable.
    Committed {
        /// Number of the commit.
        seq: u64,
    },
    /// Progress of an action that the stack called.
    ActionFeedback {
        /// Which call.
        call: ActionCallId,
        /// Share that is done, 0 to 1, if it is known.
        progress: Option<f32>,
        /// Its present step, for people.
        text: String,
    },
    /// An action that the stack called has ended.
    ActionDone {
        /// Which call.
        call: ActionCallId,
        /// How it ended.
        outcome: ActionOutcome,
    },
    /// The shell's copy of the pose graph is not the one that a [`crate::GraphDelta`] applies to: it needs the whole graph.
    GraphRequested,
    /// The site as the ledger has it: once after the boot record, and whenever the ledger was opened anew.
    Site(Box<SiteSnapshot>),
    /// An edit of the site, by a person or by the robot itself. It is durable.
    SiteEdited(Box<Edit>),
    /// What earlier programs committed and this one needs to take up runs, schedules and monitors. Comes before [`Self::Site`].
    MissionsRestored(Vec<MissionEvent>),
    /// The actions that can be called now. It replaces those before.
    ActionsRegistered(Vec<RegisteredAction>),
}

/// All objects of a site.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SiteSnapshot {
    /// The objects with their revisions.
    pub objects: Vec<Versioned>,
    /// Revisions at which objects were removed.
    pub removed: Vec<(ObjectId, Revision)>,
}

/// An action that can be called.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RegisteredAction {
    /// Its name, such as `photo`.
    pub name: String,
    /// Whether it can be repeated without harm.
    pub is_idempotent: bool,
    /// How long it is expected to take.
    pub expected: Span,
}

/// How an action ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ActionOutcome {
    /// It was done.
    Succeeded {
        /// Its result, a [`site_model::ActionReport`] as JSON. The files that it names are on the disk.
        result: String,
    },
    /// It could not be done.
    Failed {
        /// One sentence for people.
        reason: String,
    },
    /// It was cancelled before it was done.
    Cancelled,
    /// It was not begun: the camera's head does not pan so far. The body has to turn first, by this to the left (negative: to the right), radians.
    NeedsTurn {
        /// The turn.
        turn_rad: f64,
    },
}

/// Who asks. Every command carries it, so that an audit log can be made from a recording.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Principal {
    /// Browser tab or program; it holds the control lease.
    pub client: ClientId,
    /// Account that signed in; none where the gateway asks nobody to.
    pub account: Option<String>,
    /// What it may do.
    pub role: Role,
}

impl Principal {
    /// An operator at a client where nobody has to sign in.
    pub fn operator(client: ClientId) -> Self {
        Self { client, account: None, role: Role::Operator }
    }
}

/// Everything the stack knows before the first sensor speaks.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BootRecord {
    /// Body and limits of the robot.
    pub profile: RobotProfile,
    /// Where sensors sit on the base; `None` where the recording does not say (then assumed at the base).
    pub mounting: Mounting,
    /// Which sources odometry may use.
    pub sources: Sources,
    /// Whether to begin a mapping session at once (offline use).
    pub start_mapping: Option<SessionId>,
    /// Whether loops are left open, so that the map is what the odometry alone makes of it.
    pub leave_loops_open: bool,
    /// The robot's pose when the program ended, if it was localised. It is localised in that map at once.
    pub last_pose: Option<PoseInMap>,
    /// Docks of saved maps, as the robot recorded them while it was charged.
    pub docks: Arc<[PoseInMap]>,
    /// A stop of motion that was in force when the program ended. It still is.
    pub stop_latch: Option<StopLatch>,
}

/// Motion was stopped by a person. It stays stopped until [`CommandKind::AllowMotion`], also after a restart of the program.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StopLatch {
    /// Who stopped it; `None` where the file that says so was damaged.
    pub by: Option<Principal>,
}

/// A pose of the base in a saved map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PoseInMap {
    /// The saved map.
    pub map: MapId,
    /// The base in it.
    pub map_from_base: Pose,
}

/// Static transforms of the sensors. The base frame has x forward, y left, z up, its origin in the body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Mounting {
    /// LiDAR in the base.
    pub base_from_lidar: Option<Pose>,
    /// IMU in the base.
    pub base_from_imu: Option<Pose>,
    /// Frame of the external odometry in the base.
    pub base_from_external: Option<Pose>,
    /// Height of the base over the ground when standing, metres, where the recording says it. Then it replaces the profile's.
    pub standing_height_m: Option<f64>,
}

/// Which sources odometry may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the fields are the sources")]
pub struct Sources {
    pub lidar: bool,
    pub imu: bool,
    pub legs: bool,
    pub external: bool,
}

impl Default for Sources {
    fn default() -> Self {
        Self { lidar: true, imu: true, legs: true, external: true }
    }
}

/// A command with whoever gives it. Repeating an id does nothing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Command {
    /// Made by the client.
    pub id: CommandId,
    /// Who asks.
    pub by: Principal,
    /// What is asked.
    pub kind: CommandKind,
}

/// What can be asked of the stack.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum CommandKind {
    /// Take the control lease (from whoever has it).
    TakeControl {
        /// Shown to the others.
        name: String,
    },
    /// Give the lease back.
    ReleaseControl,
    /// Begin a mapping session; the id is made by the client or the shell.
    StartMapping(SessionId),
    /// End the session and save it as a map version of this id and name.
    FinishMapping {
        /// Id of the new version.
        map: MapId,
        /// Its name, for people.
        name: String,
    },
    /// End the session and keep nothing of its map.
    DiscardMapping,
    /// Move with this velocity of the base; stops by itself 0.5 s after the last one.
    Teleoperate(Twist),
    /// Begin a goal. It replaces the one that runs. Repeating the id of a known goal does nothing.
    StartGoal {
        /// Made by the client.
        goal: GoalId,
        /// What is to be reached.
        kind: GoalKind,
    },
    /// End this goal, if it runs.
    CancelGoal(GoalId),
    /// Stop motion now and stay stopped until [`CommandKind::AllowMotion`].
    StopMotion,
    /// Allow motion again after [`CommandKind::StopMotion`].
    AllowMotion,
    /// Make an edge of a pair that was held or rejected, on a person's word.
    AcceptLoop {
        /// Keyframe of the running session.
        from: KeyframeId,
        /// Another one.
        to: KeyframeId,
    },
    /// Take an accepted loop back, or a held one away, on a person's word.
    RejectLoop {
        /// Keyframe of the running session.
        from: KeyframeId,
        /// Another one.
        to: KeyframeId,
    },
    /// Look at a pair that a person points at. What comes of it is decided as for any other.
    ProposeLoop {
        /// Keyframe of the running session.
        from: KeyframeId,
        /// Another one.
        to: KeyframeId,
        /// Guess of `to` in `from`.
        guess: Pose,
    },
    /// Begin a mapping session that goes on from a saved map: the robot is localised in it, and what is new is added.
    ExtendMap {
        /// Id of the session.
        session: SessionId,
        /// The saved map.
        map: MapId,
    },
    /// Be localised in a saved map, from now on.
    Localise {
        /// The saved map.
        map: MapId,
        /// The base in it, if somebody knows: to a metre and 20 degrees.
        at: Option<Pose>,
    },
    /// Be in no map any more.
    LeaveMap,
    /// Ask something of missions.
    Mission(MissionCommandKind),
}
