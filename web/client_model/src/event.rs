//! What happens to the client, and what it wants done.

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

/// Something that happened. Everything that can change the model is here.
#[derive(Clone, Debug)]
pub enum ClientEvent {
    /// A socket opened.
    SocketOpened(Socket),
    /// A socket closed or could not be opened.
    SocketClosed {
        /// Which.
        socket: Socket,
        /// Uniform in 0..1: spreads reconnections of many clients.
        jitter: f64,
    },
    /// The server spoke on the control socket.
    Server {
        /// What it said.
        message: ServerMessage,
        /// Length on the wire.
        bytes: usize,
    },
    /// A message that this client cannot read.
    DecodeFailed {
        /// Where it came from.
        socket: Socket,
    },
    /// A live scan; its points are decoded by the shell.
    Scan {
        /// The frame, its points still encoded.
        frame: ScanFrame,
        /// Length on the wire.
        bytes: usize,
    },
    /// The tiles of a saved map were listed, or could not be.
    TilesListed {
        /// Which map.
        map: MapId,
        /// Its tiles, or a sentence.
        result: Result<TileList, String>,
    },
    /// The pose graph of a saved map came, or did not.
    GraphLoaded {
        /// Which map.
        map: MapId,
        /// Its graph, or a sentence.
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
    /// The scan of a keyframe was fetched and decoded, or could not be.
    CloudFetched {
        /// Of which session.
        session: SessionId,
        /// Which.
        keyframe: KeyframeId,
        /// A sentence when it could not.
        result: Result<(), String>,
    },
    /// A person chose a point cloud to make a map of; it is being sent.
    UploadStarted {
        /// Named by the shell.
        upload: UploadId,
        /// The file's name.
        file: String,
    },
    /// So much of it has been sent, 0 to 1.
    UploadProgress {
        /// Which.
        upload: UploadId,
        /// Share of its bytes.
        share: f32,
    },
    /// It is all there, or could not be sent.
    UploadFinished {
        /// Which.
        upload: UploadId,
        /// A sentence when it could not.
        result: Result<(), String>,
    },
    /// The camera moved.
    ViewpointChanged(Viewpoint),
    /// A person wants something.
    Command(ClientCommand),
    /// Time passed; at least every 0.1 s while anything is due.
    Tick,
}

/// A movement of the camera; it always flies.
#[derive(Clone, Debug, PartialEq)]
pub enum CameraMove {
    /// So that everything is seen.
    Fit,
    /// Straight down.
    Top,
    /// To the robot.
    Robot,
    /// To where the two keyframes of a loop are seen.
    Loop(LoopPair),
    /// To a remembered view.
    Bookmark(Bookmark),
    /// Remember the present view under this name.
    SaveBookmark(String),
}

/// Something the shell has to do after an event, in this order.
#[derive(Clone, Debug, PartialEq)]
pub enum ClientEffect {
    /// Open a socket.
    OpenSocket(Socket),
    /// Close a socket, silently: no [`ClientEvent::SocketClosed`] is expected.
    CloseSocket(Socket),
    /// Say something on the control socket.
    Send(ClientMessage),
    /// Say something on the stream socket.
    SendStream(StreamRequest),
    /// Fetch tiles and graph of a saved map.
    LoadMap(MapId),
    /// Fetch a tile.
    FetchTile(TileHash),
    /// Fetch the scan of a keyframe.
    FetchCloud {
        /// Of which session.
        session: SessionId,
        /// Which.
        keyframe: KeyframeId,
    },
    /// Let a person choose a file, and send it.
    OpenFileDialog,
    /// Give up sending it.
    CancelUpload(UploadId),
    /// Give up fetching a tile.
    CancelTile(TileHash),
    /// Take a tile off the screen.
    RemoveTile(TileHash),
    /// Move the camera.
    MoveCamera(CameraMove),
    /// Keep these settings for the next visit.
    SaveSettings(ViewSettings),
}

impl ClientEffect {
    /// A command to the server.
    pub(crate) fn command(id: vocab::CommandId, order: Command) -> Self {
        Self::Send(ClientMessage::Command { id, command: order })
    }
}
