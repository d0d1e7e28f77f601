//! What the shell shall do.

use crate::features::view_settings::{Bookmark, ViewSettings};
use crate::{AccountAction, LoopPair, ResultFileKind, RunQuery, StoredDraft};
use api::{ClientMessage, Command, StreamRequest, TileHash};
use site_model::{InspectionPointId, PlanFile, RunId};
use vocab::{BlobHash, KeyframeId, MapId, SessionId, UploadId, Vec3};

/// One of the two sockets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Socket {
    /// State and commands.
    Control,
    /// Live scans.
    Stream,
}

/// A movement of the camera. The shell animates it.
#[derive(Clone, Debug, PartialEq)]
pub enum CameraMove {
    /// To a pose from which the whole map is visible.
    Fit,
    /// To a view straight down.
    Top,
    /// To the robot.
    Robot,
    /// To a pose from which both keyframes of a loop are visible.
    Loop(LoopPair),
    /// To a point of the map, metres.
    Point(Vec3),
    /// To a saved camera.
    Bookmark(Bookmark),
    /// Nowhere: save the present camera under this name.
    SaveBookmark(String),
}

/// Something that the shell shall do after an event, in the order given.
#[derive(Clone, Debug, PartialEq)]
pub enum ClientEffect {
    /// Do something about the account that has signed in, in the page around the client.
    Account(AccountAction),
    /// Open a socket.
    OpenSocket(Socket),
    /// Close a socket, silently: no [`crate::ClientEvent::SocketClosed`] is expected.
    CloseSocket(Socket),
    /// Send a message on the control socket.
    Send(ClientMessage),
    /// Stop motion by a request of its own: there is no control socket.
    RequestStop,
    /// Send a message on the stream socket.
    SendStream(StreamRequest),
    /// Fetch tile list and pose graph of a saved map.
    LoadMap(MapId),
    /// Fetch a tile.
    FetchTile(TileHash),
    /// Fetch the scan of a keyframe.
    FetchCloud {
        /// The session of the keyframe.
        session: SessionId,
        /// Which.
        keyframe: KeyframeId,
    },
    /// Open the file dialogue, and upload the chosen file.
    OpenFileDialog,
    /// Fetch a page of the stored runs.
    FetchRuns {
        /// Which of them.
        query: RunQuery,
        /// Where the page begins; none: at the newest.
        before: Option<String>,
    },
    /// Fetch the slots of schedules that were decided last.
    FetchSlots,
    /// Fetch the result before another one at an inspection point.
    FetchPrevious {
        /// The inspection point.
        point: InspectionPointId,
        /// Number of the later result.
        before: u64,
    },
    /// Fetch a page of the results at an inspection point.
    FetchPointResults {
        /// The inspection point.
        point: InspectionPointId,
        /// Where the page begins; none: at the newest.
        before: Option<String>,
    },
    /// Ask the robot how the photos of two results are aligned.
    ComparePictures {
        /// Number of the result with the earlier photo.
        before: u64,
        /// Number of the result with the later one.
        after: u64,
    },
    /// Save a table as a file of the operator's machine.
    SaveTable {
        /// Name of the file.
        name: String,
        /// Comma-separated values.
        text: String,
    },
    /// Fetch the attempts and results of a run.
    FetchRun(RunId),
    /// Fetch and decode a file of a result.
    FetchResultFile {
        /// Its content.
        blob: BlobHash,
        /// How it is decoded.
        kind: ResultFileKind,
    },
    /// Open the file dialogue for a file of missions and schedules, and read the chosen file.
    OpenPlanFile,
    /// Save missions and schedules as a file of the operator's machine.
    SavePlanFile(PlanFile),
    /// Cancel an upload.
    CancelUpload(UploadId),
    /// Cancel the fetch of a tile.
    CancelTile(TileHash),
    /// Remove a tile from the screen.
    RemoveTile(TileHash),
    /// Move the camera.
    MoveCamera(CameraMove),
    /// Store the settings for the next visit.
    SaveSettings(ViewSettings),
    /// Store the draft of the site for the next visit.
    SaveDraft(StoredDraft),
}

impl ClientEffect {
    /// A command to the server.
    pub(crate) fn command(id: vocab::CommandId, command: Command) -> Self {
        Self::Send(ClientMessage::Command { id, command })
    }
}
