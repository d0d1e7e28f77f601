//! What enters the stack.

use crate::{
    ComparedRevisit, DisambiguationPlan, MapSearchResult, PriorMap, RelocalisationResponse, Sensor,
    VerifiedLoop,
};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use vocab::{ClientId, CommandId, KeyframeId, MapId, Pose, SessionId, Twist, Vec3};

/// One step's input. A log of these, with their `at`, is all that is needed to repeat a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Input {
    /// First input of every log: who the robot is and how the stack is set up.
    Boot(Box<BootRecord>),
    /// Time passes; sent at 20 Hz whether or not sensors speak.
    Tick,
    /// A sensor spoke.
    Sensor(Sensor),
    /// Somebody wants something.
    Command(Command),
    /// A job started by the stack has finished.
    JobDone(JobDone),
}

/// Everything the stack knows before the first sensor speaks.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BootRecord {
    /// Name of the robot, for people.
    pub robot: String,
    /// Where sensors sit on the base; `None` where the recording does not say (then assumed at the base).
    pub mounting: Mounting,
    /// Which sources odometry may use.
    pub sources: Sources,
    /// Whether to begin a mapping session at once (offline use).
    pub start_mapping: Option<SessionId>,
    /// Whether loops are left open, so that the map is what the odometry alone makes of it.
    pub leave_loops_open: bool,
    /// Where the robot was before it was switched off: it is localised in that map at once.
    pub last_place: Option<PlaceInMap>,
    /// Docks of saved maps, as it learnt them before.
    pub docks: Arc<[PlaceInMap]>,
}

/// A place in a saved map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlaceInMap {
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
    /// Height of the base over the ground when standing, metres.
    pub standing_height: Option<f64>,
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

/// A command with its maker. Repeating an id does nothing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Command {
    /// Made by the client.
    pub id: CommandId,
    /// Who asks.
    pub by: ClientId,
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
    /// Walk to a point in the map frame (metres), round obstacles seen on the way.
    WalkTo(Vec3),
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
    /// Begin a mapping session that goes on from a saved map: the robot finds its place in it, and what is new is added.
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
    /// Walk about a little, to find the place in the saved map.
    LookAbout,
}

/// The result of a job, with its number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JobDone {
    /// Number the stack gave it.
    pub job: u64,
    /// What came out.
    pub result: JobResult,
}

/// What came out of a job.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum JobResult {
    /// The map was saved with these numbers.
    MapSaved {
        /// Which version.
        map: MapId,
        /// Bytes on disk.
        bytes: u64,
    },
    /// A pair of keyframes was looked at.
    LoopVerified(Box<VerifiedLoop>),
    /// A visit was compared with an old keyframe.
    RevisitCompared(Box<ComparedRevisit>),
    /// There was no time to look at the pair of keyframes, at the visit, or for the robot's place.
    LoopNotVerified,
    /// The map could not be saved; the sentence says why and what to do.
    MapNotSaved {
        /// Which version.
        map: MapId,
        /// One clear sentence.
        reason: String,
    },
    /// A saved map was read.
    MapLoaded(Arc<PriorMap>),
    /// It could not be read; the sentence says why and what to do.
    MapNotLoaded {
        /// Which version.
        map: MapId,
        /// One clear sentence.
        reason: String,
    },
    /// The robot's place was looked for in a saved map.
    MapSearched(MapSearchResult),
    /// Where the robot may stand in a saved map.
    Relocalised(Box<RelocalisationResponse>),
    /// Which way to walk to tell places apart.
    DisambiguationPlanned(DisambiguationPlan),
}
