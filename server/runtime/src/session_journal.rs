//! Writes the journal of the running mapping session, on a thread of its own: it must not wait for the disk lane, which copies the clouds of a map that a
//! session extends.
//!
//! Each record is handed to the system at once and is on the disk a second later. When the queue is full or the disk fails, records are left out; the whole
//! graph is then asked for, so that the records after it are complete again.

use crate::clock::RobotClock;
use crate::mailbox::Mailbox;
use crate::texts;
use crossbeam_channel::{Receiver, RecvTimeoutError, Sender};
use messages::{MappingState, Publication, Severity};
use ports::error_with_causes;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use store::{SessionJournal, SessionRecord, Store, StoreError};
use vocab::SessionId;
use watchdog::{BEAT_PERIOD, Heartbeat};

/// Parameters of the [`SessionJournalQueue`] and the [`SessionJournalWorker`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SessionJournalConfig {
    /// Longest time between a record and its being on the disk. A power cut loses that much. Chosen: a second of a walk is made good by walking it again.
    pub sync_period: Duration,
    /// Records that may wait for the disk: a minute of scans, loops and changes of the graph. Chosen: disks that stall do so for some seconds.
    pub max_queued_records: usize,
}

impl Default for SessionJournalConfig {
    fn default() -> Self {
        Self { sync_period: Duration::from_secs(1), max_queued_records: 2_000 }
    }
}

/// What the thread is told.
pub enum SessionEntry {
    /// This session runs.
    Session(SessionId),
    /// It changed.
    Record(SessionRecord),
    /// It was saved or discarded.
    End,
}

/// The worker's end of the queue.
pub struct SessionEntries {
    entries: Receiver<SessionEntry>,
    /// Whether an entry found the queue full.
    has_lost: Arc<AtomicBool>,
}

/// The control loop's end of the queue.
pub struct SessionJournalQueue {
    entries: Sender<SessionEntry>,
    has_lost: Arc<AtomicBool>,
    /// Whether poses of scans are poses in the map of the session.
    is_in_map: bool,
}

impl SessionJournalQueue {
    /// Both ends.
    pub fn new(config: SessionJournalConfig) -> (Self, SessionEntries) {
        let (sender, entries) = crossbeam_channel::bounded(config.max_queued_records);
        let has_lost = Arc::<AtomicBool>::default();
        let queue = Self { entries: sender, has_lost: Arc::clone(&has_lost), is_in_map: false };
        (queue, SessionEntries { entries, has_lost })
    }

    /// Records what a publication says of the session. Never blocks.
    pub fn record(&mut self, publication: &Publication) {
        match publication {
            Publication::Mapping(state) => self.record_state(state),
            Publication::Graph { graph, .. } => self.push(SessionRecord::Graph(Arc::clone(graph))),
            Publication::GraphDelta(delta) => self.push(SessionRecord::GraphDelta(Arc::clone(delta))),
            Publication::LoopDecided(decision) => self.push(SessionRecord::LoopDecided(decision.clone())),
            Publication::Scan(scan) if self.is_in_map => {
                let (stamp, map_from_base) = (scan.stamp, scan.map_from_base);
                self.push(SessionRecord::ScanPose { stamp, map_from_base });
            }
            _ => {}
        }
    }

    fn record_state(&mut self, state: &MappingState) {
        self.is_in_map = matches!(state, MappingState::Mapping { .. });
        let (session, extends, distance_m) = match state {
            MappingState::Idle => return self.send(SessionEntry::End),
            MappingState::Saving { .. } => return,
            MappingState::Starting { session } => (*session, None, 0.0),
            MappingState::Loading { session, map } | MappingState::Finding { session, map, .. } => {
                (*session, Some(*map), 0.0)
            }
            MappingState::Mapping { session, extends, distance_m, .. } => (*session, *extends, *distance_m),
        };
        self.send(SessionEntry::Session(session));
        self.push(SessionRecord::State { extends, distance_m });
    }

    fn push(&self, record: SessionRecord) {
        self.send(SessionEntry::Record(record));
    }

    fn send(&self, entry: SessionEntry) {
        if self.entries.try_send(entry).is_err() {
            self.has_lost.store(true, Ordering::Relaxed);
        }
    }
}

/// The journal's thread.
pub struct SessionJournalWorker {
    pub config: SessionJournalConfig,
    pub store: Arc<Store>,
    pub records: SessionEntries,
    /// Asks the stack for the whole graph. Returns whether that could be handed in.
    pub request_graph: Box<dyn Fn() -> bool + Send>,
    pub mailbox: Arc<Mailbox>,
    pub clock: Arc<RobotClock>,
}

/// What the thread works at.
#[derive(Default)]
struct Work {
    session: Option<SessionId>,
    journal: Option<SessionJournal>,
    /// When the first record was written that may not be on the disk.
    unsynced: Option<Instant>,
    is_failing: bool,
    /// Whether records are missing, so that the whole graph has to be asked for.
    needs_graph: bool,
}

impl SessionJournalWorker {
    /// Writes until the control loop has ended and all records are on the disk.
    pub fn run(self, heartbeat: &Heartbeat) {
        let mut work = Work::default();
        loop {
            heartbeat.beat();
            let received = match work.unsynced {
                Some(since) => self.records.entries.recv_deadline(since + self.config.sync_period),
                None => self.records.entries.recv_timeout(BEAT_PERIOD),
            };
            let is_ending = matches!(received, Err(RecvTimeoutError::Disconnected));
            if let Ok(entry) = received {
                self.handle(entry, &mut work);
            }
            if is_ending || work.unsynced.is_some_and(|since| since.elapsed() >= self.config.sync_period) {
                work.unsynced = None;
                let synced = work.journal.as_ref().map_or(Ok(()), SessionJournal::sync);
                self.check(synced, &mut work);
            }
            work.needs_graph |= self.records.has_lost.swap(false, Ordering::Relaxed);
            if work.needs_graph {
                work.needs_graph = !(self.request_graph)();
            }
            if is_ending {
                return;
            }
        }
    }

    fn handle(&self, entry: SessionEntry, work: &mut Work) {
        match entry {
            SessionEntry::Session(session) if work.session == Some(session) => {}
            SessionEntry::Session(session) => {
                *work = Work { session: Some(session), ..Work::default() };
            }
            SessionEntry::End => *work = Work::default(),
            SessionEntry::Record(record) => {
                let Some(session) = work.session else { return };
                let written = self.append(session, &record, work);
                let was_failing = work.is_failing;
                if self.check(written, work) {
                    work.unsynced.get_or_insert_with(Instant::now);
                    work.needs_graph |= was_failing;
                }
            }
        }
    }

    fn append(&self, session: SessionId, record: &SessionRecord, work: &mut Work) -> Result<(), StoreError> {
        let journal = match &mut work.journal {
            Some(journal) => journal,
            None => work.journal.insert(self.store.session_journal(session)?),
        };
        journal.append(record)
    }

    /// Returns whether it was done. Of consecutive failures, only the first is published.
    fn check(&self, done: Result<(), StoreError>, work: &mut Work) -> bool {
        let was_failing = std::mem::replace(&mut work.is_failing, done.is_err());
        if let Err(error) = &done
            && !was_failing
        {
            let text = texts::session_not_durable(&error_with_causes(error));
            tracing::error!("{text}");
            self.mailbox.notice(self.clock.now(), Severity::Error, text);
        }
        done.is_ok()
    }
}
