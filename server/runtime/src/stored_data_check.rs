//! Looks for damage in what is stored, once after each start, on a thread of its own with low priority. People are told which file is damaged and what to do.

use crate::clock::RobotClock;
use crate::mailbox::Mailbox;
use crate::texts;
use crossbeam_channel::{Receiver, RecvTimeoutError};
use messages::Severity;
use ports::error_with_causes;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};
use store::{Store, StoreError, StoredDataReport};
use vocab::{SessionId, Stamp};
use watchdog::{BEAT_PERIOD, Heartbeat};

/// Parameters of the [`StoredDataCheckWorker`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StoredDataCheckConfig {
    /// Bytes that are read in a second, so that the disk and its cache stay free for the robot: 20 GB of maps take a quarter of an hour. Chosen: slow disks read several
    /// times as fast.
    pub bytes_per_s: f64,
    /// Damaged files of which people are told one by one. The log names all. Chosen: a damaged disk would give thousands.
    pub max_notices: usize,
    /// Time between two looks at the robot's clock until it runs: notices carry its time. Chosen: nobody notices it.
    pub clock_poll: Duration,
}

impl Default for StoredDataCheckConfig {
    fn default() -> Self {
        Self { bytes_per_s: 20e6, max_notices: 10, clock_poll: Duration::from_millis(20) }
    }
}

/// The thread of the check.
pub struct StoredDataCheckWorker {
    pub config: StoredDataCheckConfig,
    pub store: Arc<Store>,
    /// The interrupted sessions that the start has found.
    pub sessions: Vec<SessionId>,
    pub mailbox: Arc<Mailbox>,
    pub clock: Arc<RobotClock>,
    /// Disconnected when the core ends.
    pub stop: Receiver<()>,
}

impl StoredDataCheckWorker {
    /// Checks everything once.
    pub fn run(self, heartbeat: &Heartbeat) {
        // On Linux this is the priority of this thread only. If the system refuses, the check runs with normal priority.
        let _ = rustix::process::nice(10);
        while self.clock.now() == Stamp::EPOCH {
            heartbeat.beat();
            if self.is_ending_within(self.config.clock_poll) {
                return;
            }
        }
        let mut report = Report { worker: &self, heartbeat, damaged: 0 };
        if let Err(error) = self.store.check_stored_data(&self.sessions, &mut report) {
            tracing::error!("the stored data cannot be checked: {}", error_with_causes(&error));
        }
        let more = report.damaged.saturating_sub(self.config.max_notices);
        if more > 0 {
            self.notice(texts::more_files_damaged(more));
        }
    }

    fn notice(&self, text: String) {
        self.mailbox.notice(self.clock.now(), Severity::Error, text);
    }

    /// Waits, and returns whether the core ends.
    fn is_ending_within(&self, time: Duration) -> bool {
        !matches!(self.stop.recv_timeout(time), Err(RecvTimeoutError::Timeout))
    }
}

struct Report<'a> {
    worker: &'a StoredDataCheckWorker,
    heartbeat: &'a Heartbeat,
    /// Number of damaged files so far.
    damaged: usize,
}

impl StoredDataReport for Report<'_> {
    fn on_damage(&mut self, error: StoreError) {
        let text = texts::stored_file_damaged(&error_with_causes(&error));
        tracing::error!("{text}");
        self.damaged += 1;
        if self.damaged <= self.worker.config.max_notices {
            self.worker.notice(text);
        }
    }

    fn on_read(&mut self, bytes: u64) -> ControlFlow<()> {
        let until = Instant::now() + Duration::from_secs_f64(bytes as f64 / self.worker.config.bytes_per_s);
        loop {
            self.heartbeat.beat();
            let pause = until.saturating_duration_since(Instant::now()).min(BEAT_PERIOD);
            if self.worker.is_ending_within(pause) {
                return ControlFlow::Break(());
            }
            if pause < BEAT_PERIOD {
                return ControlFlow::Continue(());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use uuid::Uuid;

    #[test]
    fn a_damaged_file_is_named_once_the_robot_is_there() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let store = Arc::new(Store::open(dir.path()).expect("opens"));
        let session = SessionId(Uuid::from_u128(1));
        let folder = store.dir().sessions().join(session.to_string());
        fs::create_dir(&folder).expect("made");
        fs::write(folder.join("checksums.b3"), "nonsense\n").expect("written");
        let (mailbox, clock) = (Arc::<Mailbox>::default(), Arc::<RobotClock>::default());
        let (stop, stopped) = crossbeam_channel::bounded::<()>(0);
        let worker = StoredDataCheckWorker {
            config: StoredDataCheckConfig::default(),
            store,
            sessions: vec![session],
            mailbox: Arc::clone(&mailbox),
            clock: Arc::clone(&clock),
            stop: stopped,
        };
        let thread = std::thread::spawn(move || worker.run(&Heartbeat::unwatched()));
        clock.set(Stamp::from_parts(5, 0));
        let mail = mailbox.wait(Instant::now() + Duration::from_secs(30));
        let said = format!("{:?}", mail.ordered);
        assert!(said.contains("checksums.b3") && said.contains("Nothing was removed"), "{said}");
        thread.join().expect("ended");
        drop(stop);
    }
}
