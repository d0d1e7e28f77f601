//! What happens to the client, and what the shell shall do.

use crate::{Bookmark, ClientCommand, LoopPair, ViewSettings, Viewpoint};
use api::{ClientMessage, Command, Graph, ScanFrame, ServerMessage, StreamRequest, TileHash, TileList};
use vocab::{KeyframeId, MapId, SessionId, UploadId};

/// One of the two sockets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Socket {
    /// State and commands.
    Control,
    /// Live scans.
    Stream,
}

/// Something that happened. Nothing else changes the model.
#[derive(Clone, Debug)]
pub enum ClientEvent {
    /// A socket opened.
    SocketOpened(Socket),
    /// A socket closed or could not be opened.
    SocketClosed {
        /// Which.
        socket: Socket,
        /// Random number, uniform in 0..1: many clients shall not reconnect at the same time.
        jitter: f64,
    },
    /// A message came on the control socket.
    Server {
        /// The message.
        message: ServerMessage,
        /// Length on the wire.
        bytes: usize,
    },
    /// A message could not be decoded.
    DecodeFailed {
        /// On which socket.
        socket: Socket,
    },
    /// A live scan; its points are decoded by the shell.
    Scan {
        /// The frame, its points still encoded.
        frame: ScanFrame,
        /// Length on the wire.
        bytes: usize,
    },
    /// The request for the tile list of a saved map ended.
    TilesListed {
        /// Which map.
        map: MapId,
        /// Its tiles, or a sentence that says why not.
        result: Result<TileList, String>,
    },
    /// The request for the pose graph of a saved map ended.
    GraphLoaded {
        /// Which map.
        map: MapId,
        /// Its graph, or a sentence that says why not.
        result: Result<Graph, String>,
    },
    /// A tile was fetched and drawn.
    TileReady {
        /// Which.
        hash: TileHash,
        /// Length on the wire.
        bytes: usize,
    },
    /// A tile could not be fetched or decoded.
    TileFailed {
        /// Which.
        hash: TileHash,
    },
    /// The request for the scan of a keyframe ended; the shell keeps its points.
    CloudFetched {
        /// The session of the keyframe.
        session: SessionId,
        /// Which.
        keyframe: KeyframeId,
        /// A sentence that says why it failed, if it did.
        result: Result<(), String>,
    },
    /// The operator chose a point cloud to import; its upload begins.
    UploadStarted {
        /// Id, made by the shell.
        upload: UploadId,
        /// The file's name.
        file: String,
    },
    /// The upload went on.
    UploadProgress {
        /// Which.
        upload: UploadId,
        /// Share of its bytes that was sent, 0 to 1.
        share: f32,
    },
    /// The upload ended.
    UploadFinished {
        /// Which.
        upload: UploadId,
        /// A sentence that says why it failed, if it did.
        result: Result<(), String>,
    },
    /// The camera moved.
    ViewpointChanged(Viewpoint),
    /// The operator asks for something.
    Command(ClientCommand),
    /// Time passed. Comes at least every 0.1 s while anything is due.
    Tick,
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
    /// To a saved camera.
    Bookmark(Bookmark),
    /// Nowhere: save the present camera under this name.
    SaveBookmark(String),
}

/// Something that the shell shall do after an event, in the order given.
#[derive(Clone, Debug, PartialEq)]
pub enum ClientEffect {
    /// Open a socket.
    OpenSocket(Socket),
    /// Close a socket, silently: no [`ClientEvent::SocketClosed`] is expected.
    CloseSocket(Socket),
    /// Send a message on the control socket.
    Send(ClientMessage),
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
}

impl ClientEffect {
    /// A command to the server.
    pub(crate) fn command(id: vocab::CommandId, command: Command) -> Self {
        Self::Send(ClientMessage::Command { id, command })
    }
}
