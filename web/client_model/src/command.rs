//! What people ask for, as views emit it.

use crate::{CameraMove, LoopInitialGuess, LoopPair, NoticeId, ScanOverlay, Screen, Selection, ViewSettings};
use api::SimulatedFault;
use vocab::{MapId, Pose, Twist, Vec3};

/// A wish of the person at the client. Views emit these; [`crate::Model::apply`] alone acts on them.
#[derive(Clone, Debug, PartialEq)]
pub enum ClientCommand {
    /// Go to a screen.
    ShowScreen(Screen),
    /// Stop the robot now.
    StopMotion,
    /// Let the robot move again.
    AllowMotion,
    /// Take the control lease.
    TakeControl,
    /// Give it back.
    ReleaseControl,
    /// Begin to map.
    StartMapping,
    /// Begin to map on from a saved map.
    ExtendMap(MapId),
    /// Be localised in a saved map.
    UseMap(MapId),
    /// Be in no map any more.
    LeaveMap,
    /// Walk about a little, to find the place in the map.
    Relocalise,
    /// The next drag on the ground says where the robot stands and where it looks; or no longer.
    PickPose(bool),
    /// The robot stands there in the map on show or else in use: the base, map frame.
    SetPose(Pose),
    /// Let a person choose a point cloud to make a map of, in the frame of a saved map or in its own.
    ImportMap {
        /// The saved map.
        frame: Option<MapId>,
    },
    /// Begin to lay a saved map into the frame of another one, which may be chosen later.
    AlignMap {
        /// The map that is to be laid.
        map: MapId,
        /// The other one.
        onto: Option<MapId>,
    },
    /// This point of the map on show is the next of those that both maps show, metres.
    AddAlignmentPoint(Vec3),
    /// Take the last one back.
    RemoveAlignmentPoint,
    /// Lay the map by the points picked; by what both maps look like if there are none.
    StartAlignment,
    /// Leave both maps as they are.
    CancelAlignment,
    /// Give up sending it, or making a map of it.
    CancelImport,
    /// Let something go wrong with a simulated robot.
    InjectFault(SimulatedFault),
    /// End mapping and save under this name.
    FinishMapping {
        /// Name of the map; an empty one is replaced by the date.
        name: String,
    },
    /// End mapping and keep nothing.
    DiscardMapping,
    /// Close a loop that was held or rejected.
    AcceptLoop(LoopPair),
    /// Open a closed loop again, or drop a held one.
    RejectLoop(LoopPair),
    /// Take back the last decision on a loop that was made here.
    UndoLoop,
    /// Begin to choose two keyframes for a loop, from the first; or stop that.
    PickLoopKeyframes(bool),
    /// Where the newer of the two chosen keyframes is guessed to be.
    SetLoopInitialGuess(LoopInitialGuess),
    /// Look whether the two chosen keyframes saw the same place.
    ProposeLoop,
    /// How the scans of the selected loop are laid over each other.
    SetScanOverlay(ScanOverlay),
    /// Velocity wanted by the hand on the stick or the keys; `None` when it lets go.
    SetVelocity(Option<Twist>),
    /// Walk to this point of the map, metres.
    WalkTo(Vec3),
    /// Give up the walk.
    CancelWalk,
    /// The next click on the ground says where to walk; or no longer.
    PickGoal(bool),
    /// Look at a saved map; `None` goes back to the live one.
    ViewMap(Option<MapId>),
    /// Change how things look. Neighbouring changes of one kind become one step of undo.
    EditView(ViewSettings),
    /// Take back the last change of the view or decision on a loop, whichever came later.
    Undo,
    /// Do it again.
    Redo,
    /// Move the camera.
    MoveCamera(CameraMove),
    /// Select something in the scene, or nothing. While keyframes are chosen for a loop, a keyframe is the next of them.
    Select(Option<Selection>),
    /// Put a notice away.
    DismissNotice(NoticeId),
    /// Connect now instead of waiting.
    Reconnect,
}
