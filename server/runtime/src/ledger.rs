//! Writes what must be durable before a command is answered, on a thread of its own: the disk lane may be busy with a map for a minute.
//!
//! Today these are stops of motion and their ends. Only the newest of them counts, so at most one waits: a newer one replaces it, and its commit answers
//! both. When the disk fails, a notice says so, and writing is tried again until it succeeds.

use crate::clock::RobotClock;
use crate::mailbox::Mailbox;
use crate::texts;
use crossbeam_channel::Sender;
use messages::{Input, LedgerEvent, Severity, StopLatch};
use ports::error_with_causes;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;
use store::Store;
use watchdog::{BEAT_PERIOD, Heartbeat};

/// Parameters of the [`LedgerWorker`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LedgerConfig {
    /// Time between two attempts to write to a disk that fails.
    pub retry_period: Duration,
}

impl Default for LedgerConfig {
    fn default() -> Self {
        Self { retry_period: Duration::from_secs(1) }
    }
}

/// What waits to be written.
#[derive(Default)]
struct Slot {
    /// The newest commit.
    waiting: Option<(u64, Option<StopLatch>)>,
    /// Whether the control loop has ended.
    is_closed: bool,
}

/// The slot, shared by both threads.
#[derive(Default)]
pub struct Commits {
    slot: Mutex<Slot>,
    changed: Condvar,
}

impl Commits {
    fn update(&self, change: impl FnOnce(&mut Slot)) {
        // A panic of the other thread leaves the slot usable, because every change of it is a single assignment.
        change(&mut self.slot.lock().unwrap_or_else(PoisonError::into_inner));
        self.changed.notify_one();
    }

    /// Waits for a commit; none when the control loop has ended and nothing waits.
    fn wait(&self, heartbeat: &Heartbeat) -> Option<(u64, Option<StopLatch>)> {
        let mut slot = self.slot.lock().unwrap_or_else(PoisonError::into_inner);
        while slot.waiting.is_none() && !slot.is_closed {
            heartbeat.beat();
            slot = self.changed.wait_timeout(slot, BEAT_PERIOD).unwrap_or_else(PoisonError::into_inner).0;
        }
        slot.waiting.take()
    }

    /// Puts a commit back that could not be written, unless a newer one waits, and waits some time. Returns whether the control loop has ended.
    fn put_back(&self, commit: (u64, Option<StopLatch>), pause: Duration) -> bool {
        let mut slot = self.slot.lock().unwrap_or_else(PoisonError::into_inner);
        if slot.waiting.is_none() {
            slot.waiting = Some(commit);
        }
        if !slot.is_closed {
            slot = self.changed.wait_timeout(slot, pause).unwrap_or_else(PoisonError::into_inner).0;
        }
        slot.is_closed
    }
}

/// The control loop's end. Dropping it ends the thread, after what waits was written.
pub struct LedgerQueue {
    commits: Arc<Commits>,
}

impl LedgerQueue {
    /// Both ends.
    pub fn new() -> (Self, Arc<Commits>) {
        let commits = Arc::<Commits>::default();
        (Self { commits: Arc::clone(&commits) }, commits)
    }

    /// Hands in a commit. Never blocks. Returns the input that answers it, if nothing of it needs the disk.
    pub fn commit(&self, seq: u64, events: Vec<LedgerEvent>) -> Option<Input> {
        let newest = events.into_iter().rev().find_map(|event| match event {
            LedgerEvent::StopLatch(latch) => Some(latch),
            LedgerEvent::Goal(_) => None,
        });
        let Some(latch) = newest else { return Some(Input::Committed { seq }) };
        self.commits.update(|slot| slot.waiting = Some((seq, latch)));
        None
    }
}

impl Drop for LedgerQueue {
    fn drop(&mut self) {
        self.commits.update(|slot| slot.is_closed = true);
    }
}

/// The ledger's thread.
pub struct LedgerWorker {
    pub config: LedgerConfig,
    pub store: Arc<Store>,
    pub commits: Arc<Commits>,
    /// To the control loop. Bounded: the ledger waits while it is full. Only the newest commit waits for the ledger.
    pub committed: Sender<u64>,
    pub mailbox: Arc<Mailbox>,
    pub clock: Arc<RobotClock>,
}

impl LedgerWorker {
    /// Writes until the control loop ends.
    pub fn run(self, heartbeat: &Heartbeat) {
        let mut is_failing = false;
        while let Some((seq, latch)) = self.commits.wait(heartbeat) {
            heartbeat.beat();
            match self.store.save_stop_latch(latch.as_ref()) {
                Ok(()) => {
                    is_failing = false;
                    // The control loop may have ended already.
                    let _ = self.committed.send(seq);
                }
                Err(error) => {
                    if !std::mem::replace(&mut is_failing, true) {
                        let text = texts::stop_not_durable(&error_with_causes(&error));
                        tracing::error!("{text}");
                        self.mailbox.notice(self.clock.now(), Severity::Error, text);
                    }
                    if self.commits.put_back((seq, latch), self.config.retry_period) {
                        return;
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::thread;

    fn latch() -> LedgerEvent {
        LedgerEvent::StopLatch(Some(StopLatch { by: None }))
    }

    #[test]
    fn a_commit_is_answered_once_the_disk_has_taken_it() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let store = Arc::new(Store::open(dir.path()).expect("opens"));
        // A directory in the place of the file: writing fails until it is gone.
        let obstacle = store.dir().stop_latch();
        fs::create_dir(&obstacle).expect("made");
        let (queue, commits) = LedgerQueue::new();
        let (sender, committed) = crossbeam_channel::bounded(1);
        let mailbox = Arc::<Mailbox>::default();
        let worker = LedgerWorker {
            config: LedgerConfig { retry_period: Duration::from_millis(1) },
            store: Arc::clone(&store),
            commits,
            committed: sender,
            mailbox: Arc::clone(&mailbox),
            clock: Arc::default(),
        };
        let thread = thread::spawn(move || worker.run(&Heartbeat::unwatched()));
        assert_eq!(queue.commit(3, vec![latch()]), None);
        let deadline = std::time::Instant::now() + Duration::from_secs(30);
        let mail = mailbox.wait(deadline);
        assert!(format!("{:?}", mail.ordered).contains("stop.json"), "{:?}", mail.ordered);
        assert!(committed.try_recv().is_err(), "nothing was written");
        fs::remove_dir(&obstacle).expect("removed");
        assert_eq!(committed.recv_timeout(Duration::from_secs(30)), Ok(3));
        assert_eq!(store.stop_latch().latch, Some(StopLatch { by: None }));
        assert_eq!(queue.commit(4, Vec::new()), Some(Input::Committed { seq: 4 }));
        drop(queue);
        thread.join().expect("ended");
    }
}
