//! What happens to the client.

use crate::{
    ClientCommand, RunContent, RunQuery, Socket, StoredPage, StoredResult, StoredRun, StoredSlot, Viewpoint,
};
use api::{Graph, ScanFrame, ServerMessage, TileHash, TileList};
use site_model::{InspectionPointId, PictureComparison, PlanFile, RunId};
use vocab::{KeyframeId, MapId, SessionId, UploadId};

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
    /// The request for a page of the stored runs ended.
    RunsListed {
        /// Which of them.
        query: RunQuery,
        /// Where the page begins; none: at the newest.
        before: Option<String>,
        /// The page, or a sentence that says why not.
        result: Result<StoredPage<StoredRun>, String>,
    },
    /// The request for the slots of schedules that were decided ended.
    SlotsListed(Result<StoredPage<StoredSlot>, String>),
    /// The request for the result before another one at an inspection point ended.
    PreviousFetched {
        /// The inspection point.
        point: InspectionPointId,
        /// Number of the later result.
        before: u64,
        /// The result; none: there is none before it. Or a sentence that says why it could not be fetched.
        result: Result<Option<StoredResult>, String>,
    },
    /// The question how two photos are aligned was answered.
    PicturesCompared {
        /// Number of the result with the earlier photo.
        before: u64,
        /// Number of the result with the later one.
        after: u64,
        /// The answer, or a sentence that says why there is none.
        result: Result<PictureComparison, String>,
    },
    /// The request for a page of the results at an inspection point ended.
    PointResultsFetched {
        /// The inspection point.
        point: InspectionPointId,
        /// Where the page begins; none: at the newest.
        before: Option<String>,
        /// The page, or a sentence that says why not.
        result: Result<StoredPage<StoredResult>, String>,
    },
    /// The request for the attempts and results of a run ended.
    RunFetched {
        /// Which run.
        run: RunId,
        /// What is stored of it, or a sentence that says why not.
        result: Result<RunContent, String>,
    },
    /// A file of missions and schedules was read.
    PlanFileRead {
        /// The file's name.
        name: String,
        /// Its content, or a sentence that says why it could not be read.
        result: Result<PlanFile, String>,
    },
    /// The camera moved.
    ViewpointChanged(Viewpoint),
    /// The operator asks for something.
    Command(ClientCommand),
    /// Time passed. Comes at least every 0.1 s while anything is due.
    Tick,
}
