//! What people ask for, as views emit it.

use crate::{CameraMove, NoteId, Screen, Selection, ViewSettings};
use vocab::{KeyframeId, MapId, Pose, Twist, Vec3};

/// A wish of the person at the client. Views emit these; [`crate::Model::apply`] alone acts on them.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Go to a screen.
    Show(Screen),
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
    /// End mapping and save under this name.
    FinishMapping {
        /// Name of the map; an empty one is replaced by the date.
        name: String,
    },
    /// End mapping and keep nothing.
    DiscardMapping,
    /// Close a loop that was held or rejected.
    AcceptLoop {
        /// Keyframe of the map being made.
        from: KeyframeId,
        /// Another one.
        to: KeyframeId,
    },
    /// Open a closed loop again, or drop a held one.
    RejectLoop {
        /// Keyframe of the map being made.
        from: KeyframeId,
        /// Another one.
        to: KeyframeId,
    },
    /// Look whether two keyframes saw the same place.
    ProposeLoop {
        /// Keyframe of the map being made.
        from: KeyframeId,
        /// Another one.
        to: KeyframeId,
        /// Guess of `to` in `from`.
        guess: Pose,
    },
    /// Velocity wanted by the hand on the stick or the keys; `None` when it lets go.
    Drive(Option<Twist>),
    /// Walk to this point of the map, metres.
    WalkTo(Vec3),
    /// Give up the walk.
    CancelWalk,
    /// The next click on the ground says where to walk; or no longer.
    ArmWalk(bool),
    /// Look at a saved map; `None` goes back to the live one.
    ViewMap(Option<MapId>),
    /// Change how things look. Neighbouring changes of one kind become one step of undo.
    Edit(ViewSettings),
    /// Take back the last change of the view.
    Undo,
    /// Do it again.
    Redo,
    /// Move the camera.
    Move(CameraMove),
    /// Select something in the scene, or nothing.
    Select(Option<Selection>),
    /// Put a notice away.
    Dismiss(NoteId),
    /// Connect now instead of waiting.
    Reconnect,
}
