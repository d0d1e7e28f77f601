//! Imports: makes maps of uploaded point clouds, aligns saved maps with other saved maps, and makes new versions of them. One import runs at a time, on a thread of its own.
//!
//! The work itself is done by the [`MapImporter`] in another process. The new map is adopted by the store when it is complete, and the uploaded file
//! goes. If no map could be made, the file is kept for a second attempt, unless a person cancelled the import.

use crate::access::audit_texts;
use crate::clock::{CalendarTime, RobotClock};
use crate::ledger::LedgerInbox;
use crate::mailbox::Mailbox;
use crate::map_list::{publish_map_list, publish_uploads};
use crate::map_usage::MapUsage;
use crate::state_publisher::StatePublisher;
use crate::texts::{self, ImportVerb};
use api::{Event, Import, ImportStage, MapSummary};
use crossbeam_channel::{Receiver, Sender, TrySendError};
use messages::{Command, Principal, Severity};
use ports::{ExampleMaker, ExampleRequest, MapImporter, error_with_causes};
use site_model::SceneChangeId;
use std::fs;
use std::net::IpAddr;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use store::{ImportSpaceConfig, Store, StoreError, UploadNote};
use vocab::{MapId, UploadId, Vec3};
use watchdog::{BEAT_PERIOD, Heartbeat};

/// Parameters of imports.
#[derive(Clone, Copy, Debug)]
struct ImportsConfig {
    /// Longest name of a map, characters; longer names are cut. It fits on a line of the client's list of maps.
    max_name_chars: usize,
    /// An import that takes longer hangs. Chosen: the processor time of an import is limited to 20 minutes, and it runs with low priority beside everything else.
    max_duration: Duration,
}

const CONFIG: ImportsConfig =
    ImportsConfig { max_name_chars: 80, max_duration: Duration::from_secs(6 * 3_600) };

/// A request to make a map.
pub struct ImportRequest {
    /// Id of the uploaded file, or for an alignment an id made by the client.
    pub upload: UploadId,
    /// Who asks.
    pub by: Principal,
    /// From where; none: from the robot's own computer.
    pub address: Option<IpAddr>,
    /// Name of the map.
    pub name: String,
    /// Where its points come from.
    pub source: ImportSource,
}

/// Where the points of a new map come from.
pub enum ImportSource {
    /// The uploaded file.
    File {
        /// The map with which it is aligned; its frame becomes the new map's frame.
        frame: Option<MapId>,
    },
    /// A saved map.
    Map {
        /// The map.
        map: MapId,
        /// The map with which it is aligned; its frame becomes the new map's frame.
        onto: MapId,
        /// Corresponding points picked in both maps; without any, the alignment is found by place recognition.
        pairs: Vec<[Vec3; 2]>,
    },
    /// The example, which a simulated robot walks.
    Example {
        /// Time zone of its schedule.
        time_zone: String,
    },
    /// A saved map, with changes that are normal in the new version.
    Normal {
        /// The changes.
        changes: Vec<SceneChangeId>,
    },
}

impl ImportRequest {
    /// A request for the example.
    pub fn example(upload: UploadId, by: Principal, address: Option<IpAddr>, time_zone: String) -> Self {
        let source = ImportSource::Example { time_zone };
        Self { upload, by, address, name: texts::EXAMPLE_NAME.to_owned(), source }
    }
}

impl ImportSource {
    /// The saved maps that the import reads.
    fn maps(&self) -> Vec<MapId> {
        match self {
            Self::File { frame } => frame.iter().copied().collect(),
            Self::Map { map, onto, .. } => vec![*map, *onto],
            // The changes say which map; `make_normal` notes it.
            Self::Example { .. } | Self::Normal { .. } => Vec::new(),
        }
    }

    /// What the audit log says is done.
    fn verb_of_command(&self) -> &'static str {
        match self {
            Self::File { .. } => "import",
            Self::Map { .. } => "align",
            Self::Example { .. } | Self::Normal { .. } => "make",
        }
    }

    fn verb(&self) -> ImportVerb {
        match self {
            Self::File { .. } => ImportVerb::Imported,
            Self::Map { .. } => ImportVerb::Aligned,
            Self::Example { .. } | Self::Normal { .. } => ImportVerb::Made,
        }
    }
}

/// A new version of a map that is to be made.
pub(crate) struct NormalRequest<'a> {
    pub(crate) changes: &'a [SceneChangeId],
    /// Name of the new version.
    pub(crate) name: &'a str,
    /// Folder in which it is made.
    pub(crate) out: &'a Path,
}

/// The upload whose import was cancelled last.
type Cancelled = Arc<Mutex<Option<UploadId>>>;

/// Sends requests to the import thread.
#[derive(Clone)]
pub struct ImportQueue {
    /// `None` without an importer.
    requests: Option<Sender<ImportRequest>>,
    cancelled: Cancelled,
}

/// The import thread.
pub struct ImportWorker {
    /// Makes the maps.
    pub importer: Box<dyn MapImporter>,
    /// Makes the example.
    pub example_maker: Option<Box<dyn ExampleMaker>>,
    /// The simulated site of the robot, if it is simulated.
    pub robot_site: Option<String>,
    pub ledger: Arc<LedgerInbox>,
    /// Hands a command to the stack.
    pub command: Box<dyn Fn(Command) + Send>,
    pub store: Arc<Store>,
    pub state_publisher: Arc<StatePublisher>,
    pub mailbox: Arc<Mailbox>,
    pub clock: Arc<RobotClock>,
    pub usage: Arc<MapUsage>,
    pub requests: Receiver<ImportRequest>,
    /// Disconnected when the core ends.
    pub stop: Receiver<()>,
    pub cancelled: Cancelled,
}

impl ImportQueue {
    /// With the worker's end of the queue. One request may wait.
    pub fn new() -> (Self, Receiver<ImportRequest>) {
        let (sender, requests) = crossbeam_channel::bounded(1);
        (Self { requests: Some(sender), cancelled: Cancelled::default() }, requests)
    }

    /// Shared with the worker: the upload whose import was cancelled last.
    pub fn cancelled(&self) -> Cancelled {
        Arc::clone(&self.cancelled)
    }

    /// Refuses every request.
    pub fn none() -> Self {
        Self { requests: None, cancelled: Cancelled::default() }
    }

    /// Queues a request.
    ///
    /// # Errors
    /// The reason for the refusal, one sentence for people.
    pub fn begin(&self, request: ImportRequest) -> Result<(), String> {
        let requests = self.requests.as_ref().ok_or(texts::NO_IMPORTER)?;
        requests.try_send(request).map_err(|error| match error {
            TrySendError::Full(_) => texts::IMPORT_BUSY.to_owned(),
            TrySendError::Disconnected(_) => texts::PLATFORM_ENDING.to_owned(),
        })
    }

    /// Cancels the import of this upload, if it is running.
    pub fn cancel(&self, upload: UploadId) {
        *self.cancelled.lock().unwrap_or_else(PoisonError::into_inner) = Some(upload);
    }
}

impl ImportWorker {
    /// Handles requests until the core ends.
    pub fn run(self, heartbeat: &Heartbeat) {
        loop {
            heartbeat.beat();
            crossbeam_channel::select! {
                recv(self.stop) -> _ => return,
                recv(self.requests) -> request => match request {
                    Ok(request) => {
                        let _job = heartbeat.begin_long_job(CONFIG.max_duration);
                        self.import(&request, &display_name(&request.name));
                    }
                    Err(_) => return,
                },
                default(BEAT_PERIOD) => {}
            }
        }
    }

    fn import(&self, request: &ImportRequest, name: &str) {
        let ImportRequest { upload, ref by, address, ref source, .. } = *request;
        let out = self.store.dir().upload_map(upload);
        self.usage.begin_import(upload, source.maps());
        self.note(upload, name, source, None);
        let mut progress = |stage, share| {
            self.state_publisher.publish(Event::Import(Import::Running {
                upload,
                name: name.to_owned(),
                stage,
                share,
            }));
            if self.is_cancelled(upload) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let adopted = match source {
            ImportSource::Example { time_zone } => {
                self.make_example(upload, by, ExampleRequest { name, time_zone, out: &out }, &mut progress)
            }
            ImportSource::Normal { changes } => {
                self.make_normal(upload, by, NormalRequest { changes, name, out: &out }, &mut progress)
            }
            _ if progress(ImportStage::Reading, 0.0).is_break() => Err(texts::IMPORT_CANCELLED.to_owned()),
            _ => self
                .run_importer(upload, source, name, &out, &mut progress)
                .and_then(|()| self.adopt(upload, &out)),
        };
        // A folder that cannot be removed now is removed at the next start.
        let _ = fs::remove_dir_all(&out);
        match &adopted {
            Err(reason) if !self.is_cancelled_by_person(upload) => {
                self.note(upload, name, source, Some(reason));
            }
            _ => self.remove(upload, source),
        }
        self.usage.end_import();
        if let Some(audit) = self.state_publisher.audit() {
            let outcome = match &adopted {
                Ok(_) => audit_texts::DONE.to_owned(),
                Err(reason) => audit_texts::failed_because(reason),
            };
            audit.ended(by, address, &audit_texts::map_made(source.verb_of_command(), name), &outcome);
        }
        self.publish_outcome(upload, name, source.verb(), adopted.map(|summary| summary.id));
    }

    /// Makes a complete map one of the store's, unless that was cancelled.
    pub(crate) fn adopt(&self, upload: UploadId, out: &Path) -> Result<MapSummary, String> {
        if self.is_cancelled(upload) {
            return Err(texts::IMPORT_CANCELLED.to_owned());
        }
        self.store.adopt_map(out).map_err(|error| store_reason(&error))
    }

    /// Notes what an uploaded file is to become, and why it has not.
    fn note(&self, upload: UploadId, name: &str, source: &ImportSource, problem: Option<&str>) {
        let ImportSource::File { frame } = *source else { return };
        if !self.store.dir().upload(upload).exists() {
            return;
        }
        let note = UploadNote { name: name.to_owned(), frame, problem: problem.map(str::to_owned) };
        if let Err(error) = self.store.note_upload(upload, note) {
            tracing::warn!("{}", error_with_causes(&error));
        }
    }

    /// Removes an uploaded file that is not needed any more.
    fn remove(&self, upload: UploadId, source: &ImportSource) {
        if matches!(source, ImportSource::File { .. })
            && let Err(error) = self.store.remove_upload(upload)
        {
            tracing::warn!("{}", error_with_causes(&error));
        }
    }

    /// Makes the map in the folder `out`. Fails with a sentence for people.
    fn run_importer(
        &self,
        upload: UploadId,
        source: &ImportSource,
        name: &str,
        out: &Path,
        progress: &mut dyn FnMut(ImportStage, f32) -> ControlFlow<()>,
    ) -> Result<(), String> {
        let file = &self.store.dir().upload(upload);
        let folder = |map: MapId| Some(self.store.dir().map(map)).filter(|folder| folder.exists());
        match source {
            // They are made by `make_example` and `make_normal`.
            ImportSource::Example { .. } | ImportSource::Normal { .. } => Ok(()),
            ImportSource::File { .. } if !file.exists() => Err(texts::UPLOAD_MISSING.to_owned()),
            ImportSource::File { .. }
                if !self
                    .store
                    .has_space_for_import(upload, &ImportSpaceConfig::default())
                    .map_err(|error| store_reason(&error))? =>
            {
                Err(texts::NO_SPACE_FOR_IMPORT.to_owned())
            }
            ImportSource::File { frame: None } => self.importer.import(file, name, None, out, progress),
            ImportSource::File { frame: Some(frame) } => match folder(*frame) {
                Some(frame) => self.importer.import(file, name, Some(&frame), out, progress),
                None => Err(texts::FRAME_MAP_MISSING.to_owned()),
            },
            ImportSource::Map { map, onto, .. } if map == onto => Err(texts::ALIGN_ONTO_ITSELF.to_owned()),
            ImportSource::Map { map, onto, pairs } => match (folder(*map), folder(*onto)) {
                (Some(_), Some(_))
                    if !self.store.has_space_for_copy(*map).map_err(|error| store_reason(&error))? =>
                {
                    Err(texts::NO_SPACE_FOR_COPY.to_owned())
                }
                (Some(map), Some(onto)) => self.importer.align([&map, &onto], pairs, name, out, progress),
                (None, _) => Err(texts::ALIGNED_MAP_MISSING.to_owned()),
                (_, None) => Err(texts::FRAME_MAP_MISSING.to_owned()),
            },
        }
    }

    /// Whether a client has cancelled this import, or the core ends.
    pub(crate) fn is_cancelled(&self, upload: UploadId) -> bool {
        let is_ending = matches!(self.stop.try_recv(), Err(crossbeam_channel::TryRecvError::Disconnected));
        self.is_cancelled_by_person(upload) || is_ending
    }

    fn is_cancelled_by_person(&self, upload: UploadId) -> bool {
        *self.cancelled.lock().unwrap_or_else(PoisonError::into_inner) == Some(upload)
    }

    fn publish_outcome(&self, upload: UploadId, name: &str, verb: ImportVerb, result: Result<MapId, String>) {
        let (severity, text) = match &result {
            Ok(_) => (Severity::Info, texts::import_done(name, verb)),
            Err(reason) => (Severity::Warning, texts::import_failed(name, verb, reason)),
        };
        let calendar = CalendarTime::read();
        let published = publish_uploads(&self.store, &self.state_publisher, calendar).and_then(|()| {
            result.as_ref().map_or(Ok(()), |_| publish_map_list(&self.store, &self.state_publisher, calendar))
        });
        if let Err(error) = published {
            tracing::error!("{}", error_with_causes(&error));
        }
        self.state_publisher.publish(Event::Import(match result {
            Ok(map) => Import::Done { upload, map },
            Err(reason) => Import::Failed { upload, name: name.to_owned(), reason },
        }));
        self.mailbox.notice(self.clock.now(), severity, text);
    }
}

/// Why the store refuses the map, one sentence for people.
pub(crate) fn store_reason(error: &StoreError) -> String {
    match error {
        StoreError::MapExists { .. } => texts::MAP_EXISTS.to_owned(),
        StoreError::MapInBin { .. } => texts::MAP_IN_BIN.to_owned(),
        error => format!("{}.", error_with_causes(error)),
    }
}

/// The name without control characters, cut to [`ImportsConfig::max_name_chars`]; a default for an empty one.
fn display_name(name: &str) -> String {
    let name: String =
        name.chars().filter(|letter| !letter.is_control()).take(CONFIG.max_name_chars).collect();
    let name = name.trim();
    if name.is_empty() { texts::UNNAMED_MAP.to_owned() } else { name.to_owned() }
}

#[cfg(test)]
#[path = "imports_tests.rs"]
mod tests;
