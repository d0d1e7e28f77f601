//! What clients may ask.

use crate::GoalKind;
use serde::{Deserialize, Serialize};
use site_model::{EditId, MissionCommandKind, SceneChangeId};
use vocab::{GoalId, KeyframeId, MapId, Pose, SessionId, Span, Twist, UploadId, Vec3};

/// A command from a person or program at a client.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Command {
    /// Take the control lease. Whoever has it can refuse within 5 s, unless an admin asks.
    TakeControl {
        /// Shown to the others.
        name: String,
    },
    /// Give the lease back.
    ReleaseControl,
    /// Begin a mapping session with this id.
    StartMapping(SessionId),
    /// Begin a mapping session with this id that goes on from a saved map: the robot is localised in it, and what is new is added.
    ExtendMap {
        /// Id of the session.
        session: SessionId,
        /// The saved map.
        map: MapId,
    },
    /// End the session and save it under this id and name.
    FinishMapping {
        /// Id of the new map version.
        map: MapId,
        /// Its name.
        name: String,
    },
    /// End the session and keep nothing.
    DiscardMapping,
    /// Move with this velocity of the base; repeat at 10 Hz, the robot stops 0.5 s after the last.
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
    /// Stop motion now. Needs no lease.
    StopMotion,
    /// Allow motion again.
    AllowMotion,
    /// Close a loop that was held or rejected, on a person's word.
    AcceptLoop {
        /// Keyframe of the running session.
        from: KeyframeId,
        /// Another one.
        to: KeyframeId,
    },
    /// Open a closed loop again, or drop a held one, on a person's word.
    RejectLoop {
        /// Keyframe of the running session.
        from: KeyframeId,
        /// Another one.
        to: KeyframeId,
    },
    /// Look whether two keyframes saw the same place.
    ProposeLoop {
        /// Keyframe of the running session.
        from: KeyframeId,
        /// Another one.
        to: KeyframeId,
        /// Guess of `to` in `from`, right to a metre or two.
        guess: Pose,
    },
    /// Be localised in a saved map from now on: the robot relocalises in it, and walks by it.
    Localise {
        /// The saved map.
        map: MapId,
        /// The base in it, if somebody knows: to a metre and 20 degrees.
        at: Option<Pose>,
    },
    /// Be in no map any more.
    LeaveMap,
    /// Inject a fault into a simulated robot. Needs no lease.
    InjectFault(SimulatedFault),
    /// Make a map of a point cloud that was uploaded. Needs no lease.
    ImportMap {
        /// The file.
        upload: UploadId,
        /// Name of the map.
        name: String,
        /// A saved map of the same site, whose frame it is to have; its own if none.
        frame: Option<MapId>,
    },
    /// Make a map of a saved one, laid into the frame of another one of the same site. Its progress and result are those of an import. Needs no lease.
    AlignMap {
        /// What [`crate::Import`] calls this work.
        upload: UploadId,
        /// Name of the map.
        name: String,
        /// The saved map that is laid.
        map: MapId,
        /// The one whose frame it is to have.
        onto: MapId,
        /// Points picked in both, metres, that of `map` first: two or more, [`MAX_PAIRS`] at most. None: it is found by what both look like.
        pairs: Vec<[Vec3; 2]>,
    },
    /// End the import that is under way, if it is of this upload. Needs no lease.
    CancelImport(UploadId),
    /// Save a mapping session that was interrupted as a map. Needs no lease.
    SaveInterruptedSession {
        /// The session, as [`crate::InterruptedSession`] lists it.
        session: SessionId,
        /// Id of the new map version.
        map: MapId,
        /// Its name.
        name: String,
        /// Whether to go on: a session with this id then extends the map, which needs the lease.
        resume_as: Option<SessionId>,
    },
    /// Delete a mapping session that was interrupted. Needs no lease.
    DiscardInterruptedSession(SessionId),
    /// Give a saved map another name. Needs no lease.
    RenameMap {
        /// The map.
        map: MapId,
        /// Its new name.
        name: String,
    },
    /// Move a saved map, damaged or not, to the bin. Refused while the map is in use. Needs no lease.
    DeleteMap(MapId),
    /// Move a map back from the bin. Needs no lease.
    RestoreMap(MapId),
    /// Delete a map in the bin for good. Needs no lease.
    DeleteMapPermanently(MapId),
    /// Delete an uploaded file. Refused while it is imported. Needs no lease.
    DeleteUpload(UploadId),
    /// Ask something of missions: start, pause, resume, skip, redo, cancel, answer.
    Mission(MissionCommandKind),
    /// Make the topological map of the site from a saved map. It takes the place of the one before, in one edit. Refused while one is made. Progress and result:
    /// [`crate::TopomapGeneration`]. Needs no lease.
    GenerateTopomap {
        /// The saved map.
        map: MapId,
        /// Id of the edit, made by the client.
        edit: EditId,
    },
    /// Make a site to try: map, topological map, inspection points, a mission and a schedule. Refused while the site has a topological map or missions, while a map
    /// has its name, and while one is made. Progress and result are those of an import. Needs no lease.
    MakeExample {
        /// What [`crate::Import`] calls this work.
        upload: UploadId,
        /// Time zone of the schedule, a name of the IANA database.
        time_zone: String,
    },
    /// Keep the control lease, although somebody asks for it.
    RefuseTakeOver,
    /// Make a new version of a map in which these changes are normal. Nodes and inspection points stay where they are. A robot that is localised in the map, and not on a run, is localised
    /// in the new version afterwards. Progress and result are those of an import. Needs no lease.
    MakeNormal {
        /// What [`crate::Import`] calls this work.
        upload: UploadId,
        /// Name of the new version.
        name: String,
        /// The changes, all of one map, [`MAX_ACCEPTED_CHANGES`] at most.
        changes: Vec<SceneChangeId>,
    },
}

/// Changes of [`Command::MakeNormal`] at most.
pub const MAX_ACCEPTED_CHANGES: usize = 200;

/// Pairs of points of [`Command::AlignMap`] at most.
pub const MAX_PAIRS: usize = 32;

/// Greatest root mean square distance of corresponding points after an alignment, metres. People pick a point to about 0.1 m; points that are
/// farther apart than this are not the same in both maps.
pub const MAX_PAIR_RMS_M: f64 = 0.5;

/// A fault that can be injected into a simulated robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SimulatedFault {
    /// The LiDAR is covered for this time and sees nothing.
    CoverLidar(Span),
    /// The LiDAR sends nothing for this time.
    SilenceLidar(Span),
    /// The IMU sends nothing for this time.
    SilenceImu(Span),
    /// The feet slip for this time.
    SlipFeet(Span),
    /// Somebody carries the robot away with its LiDAR covered, and puts it down elsewhere.
    CarryAway,
    /// All faults end.
    End,
}

/// What became of a command.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum CommandOutcome {
    /// Accepted by the robot.
    Accepted,
    /// Not done; the sentence says why and what to do.
    Refused(String),
}
