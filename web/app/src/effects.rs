//! Executes the effects of the model. Every [`ClientEffect`] is matched here and nowhere else.
//!
//! Effects on sockets, downloads, uploads and storage are executed at once, also while the page is hidden. Effects on the scene and the
//! camera need a frame: they wait in a queue for `ClientRuntime::execute_scene_effects`.

use crate::browser;
use crate::change_clouds::ChangeClouds;
use crate::decode_queue::DecodeQueue;
use crate::downloads::Downloads;
use crate::inbox::Inbox;
use crate::plan_files::{self, PlanFiles};
use crate::result_files::ResultFileLoader;
use crate::saved_file;
use crate::sockets::SocketConnections;
use crate::storage;
use crate::uploads::Uploads;
use api::TileHash;
use client_model::{AccountAction, CameraMove, ClientEffect, Socket};
use std::collections::VecDeque;

/// Media type of tables.
const TABLE_TYPE: &str = "text/csv;charset=utf-8";

/// The connections of the client, and the effects that wait for a frame.
pub(crate) struct EffectExecutor {
    sockets: SocketConnections,
    downloads: Downloads,
    uploads: Uploads,
    plan_files: PlanFiles,
    /// Points of objects that changed.
    pub(crate) change_clouds: ChangeClouds,
    pub(crate) result_files: ResultFileLoader,
    scene_effects: VecDeque<SceneEffect>,
}

/// An effect that only a frame can execute.
pub(crate) enum SceneEffect {
    /// Removes a tile from the renderer.
    RemoveTile(TileHash),
    /// Moves the camera.
    MoveCamera(CameraMove),
}

impl EffectExecutor {
    /// `inbox` receives the results and events of sockets, downloads and uploads.
    pub(crate) fn new(inbox: &Inbox) -> Self {
        Self {
            sockets: SocketConnections::new(inbox.clone()),
            downloads: Downloads::new(inbox.clone()),
            uploads: Uploads::new(inbox.clone()),
            plan_files: PlanFiles::new(inbox.clone()),
            change_clouds: ChangeClouds::new(inbox.clone()),
            result_files: ResultFileLoader::new(inbox.clone()),
            scene_effects: VecDeque::new(),
        }
    }

    /// Executes an effect, or queues it for the next frame. A tile that is no longer needed also leaves `decode_queue`.
    pub(crate) fn execute(&mut self, effect: ClientEffect, decode_queue: &mut DecodeQueue) {
        match effect {
            ClientEffect::Account(action) => browser::dispatch(match action {
                AccountAction::SignOut => "autoinspect-sign-out",
                AccountAction::ChangePassword => "autoinspect-change-password",
                AccountAction::ManagePeople => "autoinspect-manage-people",
            }),
            ClientEffect::OpenSocket(socket) => self.sockets.open(socket),
            ClientEffect::CloseSocket(socket) => self.sockets.close(socket),
            ClientEffect::Send(message) => self.sockets.send(Socket::Control, &api::encode(&message)),
            ClientEffect::RequestStop => browser::dispatch("autoinspect-stop"),
            ClientEffect::SendStream(request) => self.send_stream_request(&request),
            ClientEffect::LoadMap(map) => self.downloads.fetch_map(map),
            ClientEffect::FetchTile(hash) => self.downloads.fetch_tile(hash),
            ClientEffect::CancelTile(hash) => {
                self.downloads.cancel_tile(&hash);
                decode_queue.remove_tile(&hash);
            }
            ClientEffect::FetchCloud { session, keyframe } => {
                self.downloads.fetch_keyframe_scan(session, keyframe);
            }
            ClientEffect::OpenFileDialog => self.uploads.open_file_dialog(),
            ClientEffect::FetchRuns { query, before } => self.downloads.fetch_runs(query, before),
            ClientEffect::FetchSlots => self.downloads.fetch_slots(),
            ClientEffect::FetchPrevious { point, before } => self.downloads.fetch_previous(point, before),
            ClientEffect::FetchPointResults { point, before } => {
                self.downloads.fetch_point_results(point, before);
            }
            ClientEffect::ComparePictures { before, after } => self.downloads.compare_pictures(before, after),
            ClientEffect::SaveTable { name, text } => saved_file::save(&name, TABLE_TYPE, &text),
            ClientEffect::FetchRun(run) => self.downloads.fetch_run(run),
            ClientEffect::FetchResultFile { blob, kind } => self.result_files.fetch(blob, kind),
            ClientEffect::OpenPlanFile => self.plan_files.open_file_dialog(),
            ClientEffect::SavePlanFile(file) => plan_files::save(&file),
            ClientEffect::CancelUpload(upload) => self.uploads.cancel(upload),
            ClientEffect::SaveSettings(settings) => storage::save_view_settings(&settings),
            ClientEffect::SaveDraft(draft) => storage::save_draft(&draft),
            ClientEffect::RemoveTile(hash) => self.scene_effects.push_back(SceneEffect::RemoveTile(hash)),
            ClientEffect::MoveCamera(to) => self.scene_effects.push_back(SceneEffect::MoveCamera(to)),
        }
    }

    /// Sends a request on the stream socket.
    pub(crate) fn send_stream_request(&mut self, request: &api::StreamRequest) {
        self.sockets.send(Socket::Stream, &api::encode(request));
    }

    /// Takes the oldest effect that waits for a frame.
    pub(crate) fn pop_scene_effect(&mut self) -> Option<SceneEffect> {
        self.scene_effects.pop_front()
    }
}
