//! Uploads: a file that the operator chooses in the browser's dialog is sent to the server.
//!
//! It uses `XMLHttpRequest`, because `fetch` does not report the progress of a request's body.

use crate::browser;
use crate::file_dialog::FileDialog;
use crate::inbox::Inbox;
use crate::texts;
use client_model::ClientEvent;
use gloo_events::EventListener;
use std::cell::RefCell;
use std::rc::Rc;
use uuid::Uuid;
use vocab::UploadId;
use wasm_bindgen::JsCast;
use web_sys::{File, ProgressEvent, XmlHttpRequest};

/// File types that the dialog offers first.
const FILE_TYPES: &str = ".pcd,.ply,.las,.laz,.e57,.ptx";
/// Id of the page's file input.
const INPUT_ID: &str = "map-file";

type CurrentUpload = Rc<RefCell<Option<RunningUpload>>>;

/// The file dialog and the running upload.
pub(crate) struct Uploads {
    inbox: Inbox,
    dialog: FileDialog,
    current: CurrentUpload,
}

struct RunningUpload {
    upload: UploadId,
    request: XmlHttpRequest,
    _listeners: [EventListener; 3],
}

impl Uploads {
    /// `inbox` receives the uploads' events.
    pub(crate) fn new(inbox: Inbox) -> Self {
        Self { inbox, dialog: FileDialog::new(INPUT_ID, FILE_TYPES), current: Rc::default() }
    }

    /// Opens the browser's file dialog; the chosen file is sent.
    pub(crate) fn open_file_dialog(&mut self) {
        let (inbox, current) = (self.inbox.clone(), Rc::clone(&self.current));
        self.dialog.open(move |file| start(&inbox, &current, &file));
    }

    /// Cancels an upload.
    pub(crate) fn cancel(&self, upload: UploadId) {
        let cancelled = self.current.borrow_mut().take_if(|running| running.upload == upload);
        if let Some(RunningUpload { request, .. }) = cancelled {
            // The result does not matter: nothing waits for the request any more.
            let _ = request.abort();
        }
    }
}

fn start(inbox: &Inbox, current: &CurrentUpload, file: &File) {
    let upload = UploadId(Uuid::from_u128(browser::random_u128()));
    inbox.push_event(ClientEvent::UploadStarted { upload, file: file.name() });
    match send(inbox, current, upload, file) {
        Some(running) => *current.borrow_mut() = Some(running),
        None => finish(inbox, upload, Err(texts::UPLOAD_UNSUPPORTED.to_owned())),
    }
}

fn finish(inbox: &Inbox, upload: UploadId, result: Result<(), String>) {
    inbox.push_event(ClientEvent::UploadFinished { upload, result });
}

fn send(inbox: &Inbox, current: &CurrentUpload, upload: UploadId, file: &File) -> Option<RunningUpload> {
    let request = XmlHttpRequest::new().ok()?;
    let path = api::paths::UPLOAD_PATH.replace("{id}", &upload.to_string());
    request.open("PUT", &path).ok()?;
    request.set_request_header("content-type", "application/octet-stream").ok()?;
    let on_progress = {
        let inbox = inbox.clone();
        move |event: &web_sys::Event| {
            if let Some(event) = event.dyn_ref::<ProgressEvent>() {
                let share = (event.loaded() / event.total().max(1.0)) as f32;
                inbox.push_event(ClientEvent::UploadProgress { upload, share });
            }
        }
    };
    let on_end = |kind: &'static str, result_of: fn(&XmlHttpRequest) -> Result<(), String>| {
        let (inbox, current, ended) = (inbox.clone(), Rc::clone(current), request.clone());
        EventListener::once(&request, kind, move |_| {
            finish(&inbox, upload, result_of(&ended));
            // Deferred, because the running upload owns this listener, which must not drop itself.
            wasm_bindgen_futures::spawn_local(async move {
                current.borrow_mut().take_if(|running| running.upload == upload);
            });
        })
    };
    let sending = request.upload().ok()?;
    let listeners = [
        EventListener::new(&sending, "progress", on_progress),
        on_end("load", response_result),
        on_end("error", |_| Err(texts::UPLOAD_INCOMPLETE.to_owned())),
    ];
    request.send_with_opt_blob(Some(file)).ok()?;
    Some(RunningUpload { upload, request, _listeners: listeners })
}

/// The result that the server's response reports.
fn response_result(request: &XmlHttpRequest) -> Result<(), String> {
    let status = request.status().unwrap_or(0);
    if (200..300).contains(&status) {
        return Ok(());
    }
    let body = request.response_text().ok().flatten().unwrap_or_default();
    Err(match serde_json::from_str::<api::Problem>(&body) {
        Ok(problem) => problem.detail,
        Err(_) => texts::server_error(status),
    })
}
