//! What operators ask for, as views emit it.

use crate::{
    AccountAction, CameraMove, DraftCommand, GraphTool, LoopInitialGuess, LoopPair, MissionEditorCommand,
    NoticeId, PointHistoryCommand, ResultFileKind, RunQuery, ScanOverlay, ScheduleSelection, Screen,
    Selection, ShownChanges, SiteEdit, ViewSettings,
};
use api::SimulatedFault;
use site_model::{
    DockId, InspectionPointId, LocalDate, MissionCommandKind, MissionId, NodeId, RunId, SceneChangeId,
};
use std::collections::BTreeSet;
use vocab::{BlobHash, GoalId, MapId, Pose, SessionId, Twist, UploadId, Vec3};

/// A command of the operator at this client. Views emit these; only [`crate::Model::handle_event`] acts on them.
#[derive(Clone, Debug, PartialEq)]
pub enum ClientCommand {
    /// Do something about the account that has signed in.
    Account(AccountAction),
    /// Go to a screen.
    ShowScreen(Screen),
    /// Stop the robot now.
    StopMotion,
    /// Allow the robot to move again.
    AllowMotion,
    /// Take the control lease.
    TakeControl,
    /// Give the control lease back.
    ReleaseControl,
    /// Keep the control lease, although somebody asks for it.
    RefuseTakeOver,
    /// Start a mapping session.
    StartMapping,
    /// Start a mapping session that extends a saved map.
    ExtendMap(MapId),
    /// Localise in a saved map.
    UseMap(MapId),
    /// End localisation in the saved map.
    LeaveMap,
    /// Explore nearby until the pose in the saved map is known.
    Relocalise,
    /// Let the next drag on the ground set the robot's pose, or no longer.
    PickPose(bool),
    /// The robot's pose in the map on the screen, or else the one in use: base, map frame.
    SetPose(Pose),
    /// Open the file dialogue for a point cloud to import.
    ImportMap {
        /// The saved map whose frame the new map shall have; its own frame if `None`.
        frame: Option<MapId>,
    },
    /// Cancel the upload, or the import on the server.
    CancelImport,
    /// Make the example, with schedules in this time zone.
    MakeExample {
        /// A name of the IANA database.
        time_zone: String,
    },
    /// Cancel the making of the example, whoever has asked for it.
    CancelExample,
    /// The example was shown to the operator, or why there is none.
    DismissExample,
    /// Begin to align a saved map to another one.
    AlignMap {
        /// The map that is moved.
        map: MapId,
        /// The map whose frame the result has; `None`: chosen later.
        reference: Option<MapId>,
    },
    /// The next of the corresponding points: one of the map on the screen, metres.
    AddAlignmentPoint(Vec3),
    /// Take the last point back.
    RemoveAlignmentPoint,
    /// Align by the picked points; without any, by the appearance of both maps.
    StartAlignment,
    /// End the alignment without a result.
    CancelAlignment,
    /// Let a simulated robot have a fault.
    InjectFault(SimulatedFault),
    /// End mapping and save the map.
    FinishMapping {
        /// Name of the map; an empty one is replaced by the date.
        name: String,
    },
    /// End mapping and save nothing.
    DiscardMapping,
    /// Save a mapping session that was interrupted.
    SaveInterruptedSession {
        /// The session.
        session: SessionId,
        /// Name of the map.
        name: String,
        /// Whether to go on with it: a new session then extends the map.
        resume: bool,
    },
    /// Delete a mapping session that was interrupted.
    DiscardInterruptedSession(SessionId),
    /// Give a saved map another name.
    RenameMap {
        /// The map.
        map: MapId,
        /// Its new name.
        name: String,
    },
    /// Move a saved map to the bin.
    DeleteMap(MapId),
    /// Move a map back from the bin.
    RestoreMap(MapId),
    /// Delete a map in the bin for good.
    DeleteMapPermanently(MapId),
    /// Remove the last deletion of a map from the screen; it stays in the bin.
    DismissDeletion,
    /// Import a file again that was uploaded before.
    RetryImport(UploadId),
    /// Delete a file that was uploaded before.
    DeleteUpload(UploadId),
    /// Accept a loop that was held or rejected.
    AcceptLoop(LoopPair),
    /// Reject a loop that was accepted or held.
    RejectLoop(LoopPair),
    /// Undo the last decision on a loop that was made here.
    UndoLoop,
    /// Begin to choose two keyframes for a loop, or stop.
    PickLoopKeyframes(bool),
    /// From where the comparison of the two chosen keyframes starts.
    SetLoopInitialGuess(LoopInitialGuess),
    /// Propose the two chosen keyframes as a loop.
    ProposeLoop,
    /// At which poses the scans of the selected loop are drawn.
    SetScanOverlay(ScanOverlay),
    /// The velocity that joystick or keys command; `None` on release.
    SetVelocity(Option<Twist>),
    /// Go to this node of the topological map.
    GoToNode(NodeId),
    /// Go into this dock and charge.
    GoToDock(DockId),
    /// Leave the dock.
    LeaveDock,
    /// Walk to this point of the map, metres.
    WalkTo(Vec3),
    /// Cancel a goal.
    CancelGoal(GoalId),
    /// Remove the outcome of a goal from the screen.
    DismissGoal(GoalId),
    /// Let the next click on the ground set the goal of a walk, or no longer.
    PickGoal(bool),
    /// View a saved map; `None`: the live one.
    ViewMap(Option<MapId>),
    /// Change how things look. Edits in quick succession become one step of undo.
    EditView(ViewSettings),
    /// Let clicks in the scene edit the topological map, or no longer.
    UseGraphTool(Option<GraphTool>),
    /// Change objects of the site together.
    EditSite(SiteEdit),
    /// Work on the draft of the site.
    Draft(DraftCommand),
    /// Select these nodes of the topological map and nothing else.
    SelectNodes(BTreeSet<NodeId>),
    /// Show only this floor of the topological map; `None`: all.
    ShowFloor(Option<i32>),
    /// Change what is shown of a mission that is edited.
    MissionEditor(MissionEditorCommand),
    /// Run a mission.
    StartMission {
        /// Which.
        mission: MissionId,
        /// Whether it waits until those before it have ended; else it begins now or not at all.
        is_queued: bool,
    },
    /// Ask something of a run: pause, resume, skip, redo, cancel, abort, answer.
    Run(MissionCommandKind),
    /// Fetch what is stored of a run.
    OpenRun(RunId),
    /// Fetch a file of a result.
    FetchResultFile {
        /// Its content.
        blob: BlobHash,
        /// How it is decoded.
        kind: ResultFileKind,
    },
    /// List these of the stored runs.
    ListRuns(RunQuery),
    /// List older ones too.
    ListOlderRuns,
    /// Fetch the result before another one at an inspection point.
    OpenPrevious {
        /// The inspection point.
        point: InspectionPointId,
        /// Number of the later result.
        before: u64,
    },
    /// Look at the history of an inspection point.
    PointHistory(PointHistoryCommand),
    /// Save missions and schedules as a file of the operator's machine.
    SavePlanFile,
    /// Open the file dialogue for a file of missions and schedules, and put what it has into the site.
    LoadPlanFile,
    /// Select a schedule, or nothing.
    SelectSchedule(Option<ScheduleSelection>),
    /// Show the week of this day; `None`: the current one.
    ShowWeek(Option<LocalDate>),
    /// Make the topological map from this saved map, in place of the one that the site has.
    GenerateTopomap(MapId),
    /// Show the objects of one visit, of both, or a wipe between them.
    ShowChanges(ShownChanges),
    /// Make these changes of the scene normal, in a new version of their map.
    MakeNormal(Vec<SceneChangeId>),
    /// Remove the result of the making of a topological map from the screen.
    DismissTopomapResult,
    /// Undo the last edit of the view or the site, decision on a loop or deletion of a map, whichever came last.
    Undo,
    /// Do it again.
    Redo,
    /// Move the camera.
    MoveCamera(CameraMove),
    /// Select something in the scene, or nothing. While keyframes are chosen for a loop, a keyframe is the next of them.
    Select(Option<Selection>),
    /// Remove a notice from the screen.
    DismissNotice(NoticeId),
    /// Connect now instead of at the next attempt.
    Reconnect,
}
