//! Writes what must be durable before it is acknowledged, on a thread of its own: the disk lane may be busy with a map for a minute.
//!
//! These are the commits of the stack (stops of motion in `stop.json`, all else in the ledger) and clients' edits of the site. The thread also holds the site, and
//! answers questions about what is stored.
//!
//! | what waits | policy |
//! | --- | --- |
//! | commits | kept, in their order; of stops of motion that follow each other only the newest counts, and its commit answers all. When the disk fails, a notice says so, and writing is tried again until it succeeds. The stack waits for the answer before it acts, so they are few |
//! | edits and questions | refused beyond [`LedgerConfig::max_waiting_requests`] or [`LedgerConfig::max_waiting_bytes`], and when the disk fails |

mod alerts;
mod reading_limits;
mod site;
#[cfg(test)]
mod tests;

pub(crate) use alerts::raised;
pub use site::SiteKeeper;

use crate::clock::RobotClock;
use crate::mailbox::Mailbox;
use crate::picture_queue::{PicturePair, PictureQueue};
use crate::texts;
use api::{EditOutcome, EditRefusal, Query};
use crossbeam_channel::Sender;
use messages::{Input, LedgerEvent, Principal, Severity, StopLatch};
use ports::error_with_causes;
use site_model::{Edit, Site};
use std::collections::VecDeque;
use std::fmt;
use std::net::IpAddr;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::Duration;
use store::{Ledger, LedgerWriter, Store, StoreError};
use vocab::Stamp;
use watchdog::{BEAT_PERIOD, Heartbeat};

/// Parameters of the [`LedgerWorker`] and its queue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LedgerConfig {
    /// Time between two attempts to write to a disk that fails. Chosen: people who free space see that it goes on; a failed attempt costs little.
    pub retry_period: Duration,
    /// Edits and questions that may wait. Chosen: eight transactions ([`Self::max_edits_at_once`]).
    pub max_waiting_requests: usize,
    /// Bytes that edits may take while they wait: four of the longest.
    pub max_waiting_bytes: usize,
    /// Edits that are written in one transaction. They share its wait for the disk. Chosen: a transaction then takes milliseconds more than one edit does.
    pub max_edits_at_once: usize,
    /// Entries of the audit log that are kept. Given by `--audit-entries`; the default is chosen: more than a year of 1,000 entries a day.
    pub audit_entries: u64,
}

impl Default for LedgerConfig {
    fn default() -> Self {
        Self {
            retry_period: Duration::from_secs(1),
            max_waiting_requests: 512,
            max_waiting_bytes: 4 * api::MAX_EDIT_BYTES,
            max_edits_at_once: 64,
            audit_entries: 500_000,
        }
    }
}

/// What the stack wants to be durable.
#[derive(Debug)]
struct Commit {
    seq: u64,
    events: Vec<LedgerEvent>,
}

impl Commit {
    /// Whether it is nothing but a stop of motion or its end.
    fn is_latch_only(&self) -> bool {
        self.events.iter().all(|event| matches!(event, LedgerEvent::StopLatch(_)))
    }
}

/// A client's edit.
#[derive(Debug)]
pub struct EditRequest {
    pub by: Principal,
    /// From where; none: from the robot's own computer.
    pub address: Option<IpAddr>,
    pub edit: Edit,
}

/// An edit that is made of the site at the moment when it is applied, so that no other edit comes between.
pub struct SiteWork {
    /// Whose edit it is.
    pub by: Principal,
    /// Makes the edit. One without changes counts as applied.
    pub make: Box<dyn FnOnce(&Site) -> Edit + Send>,
    /// Is told what became of it.
    pub done: Box<dyn FnOnce(EditOutcome) + Send>,
}

impl fmt::Debug for SiteWork {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SiteWork").field("by", &self.by).finish_non_exhaustive()
    }
}

/// Something else to write, such as accounts.
pub struct LedgerWork {
    /// Writes it, with the calendar time.
    pub write: LedgerWrite,
    /// Is told whether it is durable, or why not, a clause.
    pub done: Sender<Result<(), String>>,
}

/// What writes to the ledger in a transaction.
pub type LedgerWrite = Box<dyn FnMut(&LedgerWriter<'_>, Stamp) -> Result<(), StoreError> + Send>;

impl fmt::Debug for LedgerWork {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LedgerWork").finish_non_exhaustive()
    }
}

/// Reads the ledger and the site that it holds, or is told why they cannot be read, a clause.
type LedgerReader = Box<dyn FnOnce(Result<(&Ledger, &Site), String>) + Send>;

struct LedgerRead(LedgerReader);

impl fmt::Debug for LedgerRead {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LedgerRead").finish_non_exhaustive()
    }
}

/// What clients ask for.
#[derive(Debug)]
enum Request {
    Edit { request: EditRequest, bytes: usize },
    ChangeSite(SiteWork),
    Write(LedgerWork),
    Read(LedgerRead),
    Query { number: u64, query: Query },
}

/// What waits.
#[derive(Debug, Default)]
struct WaitingLedgerRequests {
    commits: VecDeque<Commit>,
    requests: VecDeque<Request>,
    /// Bytes of the edits.
    bytes: usize,
    /// Whether commits were taken that are not written yet.
    is_writing: bool,
    /// Whether the control loop has ended.
    is_closed: bool,
}

impl WaitingLedgerRequests {
    fn is_empty(&self) -> bool {
        self.commits.is_empty() && self.requests.is_empty()
    }
}

/// The queue, shared by all threads that use it.
#[derive(Debug, Default)]
pub struct LedgerInbox {
    config: LedgerConfig,
    waiting: Mutex<WaitingLedgerRequests>,
    changed: Condvar,
    /// Whoever compares pictures; none compares none.
    pictures: OnceLock<PictureQueue>,
}

impl LedgerInbox {
    /// A panic of another thread leaves what waits usable, because no code under the lock leaves it half changed.
    fn lock(&self) -> MutexGuard<'_, WaitingLedgerRequests> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Hands in an edit. Never blocks.
    ///
    /// # Errors
    /// What to answer at once if it cannot wait.
    pub fn edit(&self, request: EditRequest) -> Result<(), EditOutcome> {
        let bytes = api::encoded_bytes(&request.edit);
        self.ask(Request::Edit { request, bytes }, bytes)
            .map_err(|reason| EditOutcome::Refused(EditRefusal::Unavailable(reason.to_owned())))
    }

    /// Hands in a question. Never blocks.
    ///
    /// # Errors
    /// Why it cannot wait, one sentence.
    pub fn query(&self, number: u64, query: Query) -> Result<(), &'static str> {
        if let Query::PictureComparison { before, after } = query {
            let pictures = self.pictures.get().ok_or(texts::NO_PICTURE_COMPARISON)?;
            return pictures.ask(PicturePair { question: number, results: [before, after] });
        }
        self.ask(Request::Query { number, query }, 0)
    }

    /// Hands in an edit that is still to be made. Never blocks.
    ///
    /// # Errors
    /// Why it cannot wait, one sentence.
    pub fn change_site(&self, work: SiteWork) -> Result<(), &'static str> {
        self.ask(Request::ChangeSite(work), 0)
    }

    /// Hands in something else to write. Never blocks.
    ///
    /// # Errors
    /// Why it cannot wait, one sentence.
    pub fn write(&self, work: LedgerWork) -> Result<(), &'static str> {
        self.ask(Request::Write(work), 0)
    }

    /// Names the thread that compares pictures: it is told of new results, and gets questions about pictures.
    pub fn compare_pictures_with(&self, pictures: PictureQueue) {
        // There is one such thread.
        let _ = self.pictures.set(pictures);
    }

    /// Reads the ledger and the site on the ledger's thread, and waits for it.
    ///
    /// # Errors
    /// Why that was not done, a clause or a sentence.
    pub fn read<T: Send + 'static>(
        &self,
        read: impl FnOnce(&Ledger, &Site) -> Result<T, StoreError> + Send + 'static,
    ) -> Result<T, String> {
        let (done, outcome) = crossbeam_channel::bounded(1);
        let reader: LedgerReader = Box::new(move |opened| {
            let read = opened
                .and_then(|(ledger, site)| read(ledger, site).map_err(|error| error_with_causes(&error)));
            // Whoever waited may have given up.
            let _ = done.send(read);
        });
        self.ask(Request::Read(LedgerRead(reader)), 0)?;
        outcome.recv().unwrap_or_else(|_| Err(texts::CORE_ENDS.to_owned()))
    }

    fn ask(&self, request: Request, bytes: usize) -> Result<(), &'static str> {
        let mut waiting = self.lock();
        if waiting.is_closed {
            return Err(texts::CORE_ENDS);
        }
        let is_full = waiting.requests.len() >= self.config.max_waiting_requests
            || waiting.bytes + bytes > self.config.max_waiting_bytes;
        if is_full {
            return Err(texts::LEDGER_BUSY);
        }
        waiting.bytes += bytes;
        waiting.requests.push_back(request);
        drop(waiting);
        self.changed.notify_one();
        Ok(())
    }

    /// Waits for something to do; none when the control loop has ended and nothing waits. Takes all commits and some requests.
    fn wait(&self, heartbeat: &Heartbeat) -> Option<(VecDeque<Commit>, Vec<Request>)> {
        let mut waiting = self.lock();
        waiting.is_writing = false;
        while waiting.is_empty() && !waiting.is_closed {
            heartbeat.beat();
            waiting =
                self.changed.wait_timeout(waiting, BEAT_PERIOD).unwrap_or_else(PoisonError::into_inner).0;
        }
        if waiting.is_empty() {
            return None;
        }
        let count = waiting.requests.len().min(self.config.max_edits_at_once);
        let requests: Vec<Request> = waiting.requests.drain(..count).collect();
        for request in &requests {
            if let Request::Edit { bytes, .. } = request {
                waiting.bytes -= bytes;
            }
        }
        waiting.is_writing = !waiting.commits.is_empty();
        Some((std::mem::take(&mut waiting.commits), requests))
    }

    /// Puts commits back that could not be written, and waits some time. Returns whether the control loop has ended.
    fn put_back(&self, mut commits: VecDeque<Commit>, pause: Duration) -> bool {
        let mut waiting = self.lock();
        commits.append(&mut waiting.commits);
        waiting.commits = commits;
        if !waiting.is_closed {
            waiting = self.changed.wait_timeout(waiting, pause).unwrap_or_else(PoisonError::into_inner).0;
        }
        waiting.is_closed
    }
}

/// The control loop's end. Dropping it ends the thread, after what waits was written.
pub struct LedgerQueue {
    inbox: Arc<LedgerInbox>,
}

impl LedgerQueue {
    /// Both ends.
    pub fn new(config: LedgerConfig) -> (Self, Arc<LedgerInbox>) {
        let inbox = Arc::new(LedgerInbox { config, ..LedgerInbox::default() });
        (Self { inbox: Arc::clone(&inbox) }, inbox)
    }

    /// Hands in a commit. Never blocks. Returns the input that answers it, if nothing of it needs the disk.
    pub fn commit(&self, seq: u64, mut events: Vec<LedgerEvent>) -> Option<Input> {
        // Goals are not stored.
        events.retain(|event| !matches!(event, LedgerEvent::Goal(_)));
        let mut waiting = self.inbox.lock();
        if events.is_empty() && waiting.commits.is_empty() && !waiting.is_writing {
            return Some(Input::Committed { seq });
        }
        let commit = Commit { seq, events };
        match waiting.commits.back_mut() {
            Some(last) if last.is_latch_only() && commit.is_latch_only() && !commit.events.is_empty() => {
                *last = commit;
            }
            _ => waiting.commits.push_back(commit),
        }
        drop(waiting);
        self.inbox.changed.notify_one();
        None
    }
}

impl Drop for LedgerQueue {
    fn drop(&mut self) {
        self.inbox.lock().is_closed = true;
        self.inbox.changed.notify_one();
    }
}

/// The ledger's thread.
pub struct LedgerWorker {
    pub store: Arc<Store>,
    pub inbox: Arc<LedgerInbox>,
    pub site: SiteKeeper,
    /// To the control loop. Bounded: the ledger waits while it is full.
    pub inputs: Sender<Input>,
    pub mailbox: Arc<Mailbox>,
    pub clock: Arc<RobotClock>,
}

impl LedgerWorker {
    /// Writes until the control loop ends.
    pub fn run(mut self, heartbeat: &Heartbeat) {
        let mut is_failing = false;
        while let Some((commits, requests)) = self.inbox.wait(heartbeat) {
            heartbeat.beat();
            self.answer(requests);
            let Some(newest) = commits.back().map(|commit| commit.seq) else { continue };
            match self.write(&commits) {
                Ok(()) => {
                    is_failing = false;
                    self.tell_of_results(&commits);
                    // The control loop may have ended already.
                    let _ = self.inputs.send(Input::Committed { seq: newest });
                }
                Err(reason) => {
                    if !std::mem::replace(&mut is_failing, true) {
                        tracing::error!("{reason}");
                        self.mailbox.notice(self.clock.now(), Severity::Error, reason);
                    }
                    if self.inbox.put_back(commits, self.inbox.config.retry_period) {
                        return;
                    }
                }
            }
        }
    }

    /// Writes commits. All may be written again after a failure: a stop replaces the one before, and of the rest nothing was written.
    fn write(&mut self, commits: &VecDeque<Commit>) -> Result<(), String> {
        let events = || commits.iter().flat_map(|commit| &commit.events);
        let newest = events().rev().find_map(|event| match event {
            LedgerEvent::StopLatch(latch) => Some(latch),
            _ => None,
        });
        if let Some(latch) = newest {
            self.save_latch(latch.as_ref())
                .map_err(|error| texts::stop_not_durable(&error_with_causes(&error)))?;
        }
        let others: Vec<&LedgerEvent> =
            events().filter(|event| !matches!(event, LedgerEvent::StopLatch(_))).collect();
        self.site.write_events(&others).map_err(|reason| texts::run_not_durable(&reason))
    }

    /// Tells whoever compares pictures that there are new results.
    fn tell_of_results(&self, commits: &VecDeque<Commit>) {
        let mut events = commits.iter().flat_map(|commit| &commit.events);
        if let (Some(pictures), true) =
            (self.inbox.pictures.get(), events.any(|event| matches!(event, LedgerEvent::Result(_))))
        {
            pictures.wake();
        }
    }

    fn save_latch(&self, latch: Option<&StopLatch>) -> Result<(), StoreError> {
        self.store.save_stop_latch(latch)
    }

    fn answer(&mut self, requests: Vec<Request>) {
        let mut edits = Vec::new();
        for request in requests {
            match request {
                Request::Edit { request, .. } => edits.push(request),
                Request::ChangeSite(work) => {
                    self.site.apply(std::mem::take(&mut edits));
                    self.site.apply_work(work);
                }
                Request::Write(LedgerWork { write, done }) => {
                    // Whoever waited may have given up.
                    let _ = done.send(self.site.write(write));
                }
                Request::Read(LedgerRead(read)) => self.site.read(read),
                Request::Query { number, query } => self.site.answer(number, query),
            }
        }
        self.site.apply(edits);
    }
}

/// Why an edit was refused, for people: the first reason, a clause or a sentence.
pub fn refusal_reason(refusal: EditRefusal) -> String {
    match refusal {
        EditRefusal::Invalid(errors) => errors.first().map_or_else(String::new, ToString::to_string),
        EditRefusal::Rejected(reason) | EditRefusal::Unavailable(reason) => reason,
    }
}
