//! Point clouds that clients sent, made into maps, and maps laid into other maps' frames: one at a time, far from the control loop.

use crate::clock::RobotClock;
use crate::mailbox::Mailbox;
use crate::recording::sentence;
use crate::state_publisher::StatePublisher;
use api::{Event, Import, ImportStage};
use crossbeam_channel::{Receiver, Sender, TrySendError};
use messages::Severity;
use ports::MapImporter;
use std::fs;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use store::{Store, StoreError};
use vocab::{MapId, UploadId, Vec3};

/// Names longer than this are cut, characters.
const NAME_MAX: usize = 80;

/// A request to make a map.
pub struct ImportRequest {
    /// The uploaded file, or the id that the client gave to this work.
    pub upload: UploadId,
    /// Name of the map.
    pub name: String,
    /// Where its points come from.
    pub source: ImportSource,
}

/// Where the points of a new map come from.
pub enum ImportSource {
    /// The uploaded file.
    File {
        /// The map whose frame it is to have.
        frame: Option<MapId>,
    },
    /// Another map.
    Map {
        /// Which.
        map: MapId,
        /// The map whose frame it is to have.
        onto: MapId,
        /// Points picked in both.
        pairs: Vec<[Vec3; 2]>,
    },
}

/// The upload whose import was cancelled last.
type Cancelled = Arc<Mutex<Option<UploadId>>>;

/// Sends requests to the import thread.
#[derive(Clone)]
pub struct Imports {
    /// None where this core imports no files.
    requests: Option<Sender<ImportRequest>>,
    cancelled: Cancelled,
}

/// The import thread.
pub struct ImportWorker {
    pub importer: Box<dyn MapImporter>,
    pub store: Arc<Store>,
    pub state_publisher: Arc<StatePublisher>,
    pub mailbox: Arc<Mailbox>,
    pub clock: Arc<RobotClock>,
    pub requests: Receiver<ImportRequest>,
    /// Disconnected when it is time to end.
    pub stop: Receiver<()>,
    pub cancelled: Cancelled,
}

impl Imports {
    /// With what the worker listens to. One may wait.
    pub fn new() -> (Self, Receiver<ImportRequest>) {
        let (sender, requests) = crossbeam_channel::bounded(1);
        (Self { requests: Some(sender), cancelled: Cancelled::default() }, requests)
    }

    /// What the worker asks whether to go on.
    pub fn cancelled(&self) -> Cancelled {
        Arc::clone(&self.cancelled)
    }

    /// Where nobody makes maps of files.
    pub fn none() -> Self {
        Self { requests: None, cancelled: Cancelled::default() }
    }

    /// Begins to make a map of an uploaded file.
    ///
    /// # Errors
    /// Why not, one sentence.
    pub fn begin(&self, request: ImportRequest) -> Result<(), String> {
        let requests = self.requests.as_ref().ok_or("This platform makes no maps of files.")?;
        requests.try_send(request).map_err(|error| match error {
            TrySendError::Full(_) => "Another map is being imported. Wait until that is done.".to_owned(),
            TrySendError::Disconnected(_) => "The platform is ending.".to_owned(),
        })
    }

    /// Ends the import of that file, if it is under way.
    pub fn cancel(&self, upload: UploadId) {
        *self.cancelled.lock().unwrap_or_else(PoisonError::into_inner) = Some(upload);
    }
}

impl ImportWorker {
    /// Works until told to stop.
    pub fn run(self) {
        loop {
            crossbeam_channel::select! {
                recv(self.stop) -> _ => return,
                recv(self.requests) -> request => match request {
                    Ok(request) => self.make(request.upload, &tidy(&request.name), &request.source),
                    Err(_) => return,
                },
            }
        }
    }

    fn make(&self, upload: UploadId, name: &str, of: &ImportSource) {
        let (file, made) = (self.store.dir().upload(upload), self.store.dir().upload_map(upload));
        let mut progress = |stage, share| {
            self.state_publisher.publish(Event::Import(Import::Running {
                upload,
                name: name.to_owned(),
                stage,
                share,
            }));
            if self.is_over(upload) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let imported = if progress(ImportStage::Reading, 0.0).is_break() {
            Err("It was cancelled.".to_owned())
        } else {
            self.made_of(of, &file, name, &made, &mut progress)
        };
        let adopted = imported.and_then(|()| match self.is_over(upload) {
            true => Err("It was cancelled.".to_owned()),
            false => self.store.adopt_map(&made).map_err(|error| told(&error)),
        });
        // What is left has no use; at the next start it is removed in any case.
        if matches!(of, ImportSource::File { .. }) {
            let _ = fs::remove_file(&file);
        }
        let _ = fs::remove_dir_all(&made);
        let verb = if matches!(of, ImportSource::File { .. }) { "imported" } else { "laid" };
        self.tell(upload, name, verb, adopted.map(|summary| summary.id));
    }

    fn made_of(
        &self,
        of: &ImportSource,
        file: &Path,
        name: &str,
        made: &Path,
        progress: &mut dyn FnMut(ImportStage, f32) -> ControlFlow<()>,
    ) -> Result<(), String> {
        let gone = |what: &str| Err(format!("The map {what} is not here any more."));
        let folder = |map: MapId| Some(self.store.dir().map(map)).filter(|folder| folder.exists());
        match of {
            ImportSource::File { .. } if !file.exists() => {
                Err("That file is not here any more. Send it again.".to_owned())
            }
            ImportSource::File { frame: None } => self.importer.import(file, name, None, made, progress),
            ImportSource::File { frame: Some(frame) } => match folder(*frame) {
                Some(frame) => self.importer.import(file, name, Some(&frame), made, progress),
                None => gone("whose frame it was to have"),
            },
            ImportSource::Map { map, onto, .. } if map == onto => {
                Err("A map cannot be laid onto itself.".to_owned())
            }
            ImportSource::Map { map, onto, pairs } => match (folder(*map), folder(*onto)) {
                (Some(_), Some(_)) if !self.store.has_space_for_copy(*map).map_err(|error| told(&error))? => {
                    Err("There is too little room on the robot's disk for another map of this size. Delete maps or recordings first."
                        .to_owned())
                }
                (Some(map), Some(onto)) => self.importer.align([&map, &onto], pairs, name, made, progress),
                (None, _) => gone("to be laid"),
                (_, None) => gone("whose frame it was to have"),
            },
        }
    }

    fn is_over(&self, upload: UploadId) -> bool {
        let cancelled = *self.cancelled.lock().unwrap_or_else(PoisonError::into_inner);
        let ended = matches!(self.stop.try_recv(), Err(crossbeam_channel::TryRecvError::Disconnected));
        cancelled == Some(upload) || ended
    }

    fn tell(&self, upload: UploadId, name: &str, verb: &str, result: Result<MapId, String>) {
        let (severity, text) = match &result {
            Ok(_) => (Severity::Info, format!("{name} is {verb}.")),
            Err(reason) => (Severity::Warning, format!("{name} was not {verb}: {reason}")),
        };
        if result.is_ok() {
            match self.store.maps() {
                Ok(maps) => self.state_publisher.publish(Event::Maps(maps)),
                Err(error) => tracing::error!("the saved maps cannot be listed: {error}"),
            }
        }
        self.state_publisher.publish(Event::Import(match result {
            Ok(map) => Import::Done { upload, map },
            Err(reason) => Import::Failed { upload, name: name.to_owned(), reason },
        }));
        self.mailbox.notice(self.clock.now(), severity, text);
    }
}

fn told(error: &StoreError) -> String {
    match error {
        StoreError::MapExists { .. } => "The same map is here already.".to_owned(),
        error => format!("{}.", sentence(error)),
    }
}

/// One line of a length that can be shown.
fn tidy(name: &str) -> String {
    let name: String = name.chars().filter(|letter| !letter.is_control()).take(NAME_MAX).collect();
    let name = name.trim();
    if name.is_empty() { "Map".to_owned() } else { name.to_owned() }
}
