//! Watches the threads of a process. A thread fails when it panics, or when it gives no heartbeat for longer than its limit. The process then ends with the
//! reason, so that its supervisor starts it again.
//!
//! A watched thread never waits longer than [`BEAT_PERIOD`] without a heartbeat, so one that waits for work is not taken for one that hangs. Work that takes
//! longer than the thread's limit is announced with [`Heartbeat::begin_long_job`].

mod fault_injection;
mod texts;

pub use fault_injection::FaultInjection;

use crossbeam_channel::{Receiver, Sender};
use std::any::Any;
use std::fmt;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// Longest time that a watched thread waits between two heartbeats. A thread wakes once a second, which costs next to nothing.
pub const BEAT_PERIOD: Duration = Duration::from_secs(1);

/// A thread that has failed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ThreadFailure {
    /// Name of the thread.
    pub thread: String,
    /// How it failed.
    pub kind: FailureKind,
}

/// How a thread failed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FailureKind {
    /// It panicked with this message.
    Panicked(String),
    /// It gave no heartbeat for this time.
    Silent(Duration),
    /// It ended although nobody asked it to.
    Ended,
}

/// A clause: what the process did.
impl fmt::Display for ThreadFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.kind {
            FailureKind::Panicked(message) => f.write_str(&texts::panicked(&self.thread, message)),
            FailureKind::Silent(silence) => f.write_str(&texts::silent(&self.thread, *silence)),
            FailureKind::Ended => f.write_str(&texts::ended(&self.thread)),
        }
    }
}

/// The registry of the watched threads of a process.
#[derive(Clone)]
pub struct Watchdog {
    shared: Arc<Shared>,
}

struct Shared {
    start: Instant,
    threads: Mutex<Vec<Weak<Watched>>>,
    failed: Sender<ThreadFailure>,
    failures: Receiver<ThreadFailure>,
    faults: FaultInjection,
}

/// One thread.
struct Watched {
    name: String,
    limit: Duration,
    /// Milliseconds after [`Shared::start`].
    last_beat_ms: AtomicU64,
    /// Limit until the next heartbeat, milliseconds. Longer than `limit` during a long job.
    limit_ms: AtomicU64,
}

/// Failures that are kept. Only the first matters.
const MAX_FAILURES: usize = 16;

impl Default for Watchdog {
    fn default() -> Self {
        Self::new(FaultInjection::default())
    }
}

impl Watchdog {
    /// Watches nothing yet.
    pub fn new(faults: FaultInjection) -> Self {
        let (failed, failures) = crossbeam_channel::bounded(MAX_FAILURES);
        let shared = Shared { start: Instant::now(), threads: Mutex::default(), failed, failures, faults };
        Self { shared: Arc::new(shared) }
    }

    /// Starts a thread that is watched until it ends. It fails when it gives no heartbeat for `limit`.
    ///
    /// # Errors
    /// When the system cannot start a thread.
    pub fn spawn(
        &self,
        name: &str,
        limit: Duration,
        run: impl FnOnce(&Heartbeat) + Send + 'static,
    ) -> io::Result<JoinHandle<()>> {
        let heartbeat = self.watch(name, limit);
        let (failed, thread) = (self.shared.failed.clone(), name.to_owned());
        thread::Builder::new().name(name.to_owned()).spawn(move || {
            if let Err(failure) = catch_panic(&thread, || run(&heartbeat)) {
                // If the channel is full, the process is ending for another failure.
                let _ = failed.try_send(failure);
            }
        })
    }

    /// Watches the calling thread until the heartbeat is dropped. Its panics are not caught.
    pub fn watch(&self, name: &str, limit: Duration) -> Heartbeat {
        let watched = Arc::new(Watched {
            name: name.to_owned(),
            limit,
            last_beat_ms: AtomicU64::new(self.shared.now_ms()),
            limit_ms: AtomicU64::new(millis(limit)),
        });
        let mut threads = self.shared.threads();
        threads.retain(|thread| thread.strong_count() > 0);
        threads.push(Arc::downgrade(&watched));
        Heartbeat { watched, shared: Arc::clone(&self.shared) }
    }

    /// Failures of threads, as they come. [`Self::check`] finds the silent ones.
    pub fn failures(&self) -> Receiver<ThreadFailure> {
        self.shared.failures.clone()
    }

    /// Reports threads that have given no heartbeat for longer than their limit. To be called every second.
    pub fn check(&self) {
        let now_ms = self.shared.now_ms();
        for thread in self.shared.threads().iter().filter_map(Weak::upgrade) {
            let silence_ms = now_ms.saturating_sub(thread.last_beat_ms.load(Ordering::Relaxed));
            if silence_ms > thread.limit_ms.load(Ordering::Relaxed) {
                let kind = FailureKind::Silent(Duration::from_millis(silence_ms));
                let _ = self.shared.failed.try_send(ThreadFailure { thread: thread.name.clone(), kind });
            }
        }
    }

    /// Time since the last heartbeat of a thread; `None` if no thread of this name is watched.
    pub fn silence_of(&self, name: &str) -> Option<Duration> {
        let threads = self.shared.threads();
        let thread = threads.iter().filter_map(Weak::upgrade).find(|thread| thread.name == name)?;
        let last_beat_ms = thread.last_beat_ms.load(Ordering::Relaxed);
        Some(Duration::from_millis(self.shared.now_ms().saturating_sub(last_beat_ms)))
    }
}

impl Shared {
    fn now_ms(&self) -> u64 {
        millis(self.start.elapsed())
    }

    /// Plain data behind the lock.
    fn threads(&self) -> MutexGuard<'_, Vec<Weak<Watched>>> {
        self.threads.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl fmt::Debug for Heartbeat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Heartbeat").field("thread", &self.watched.name).finish_non_exhaustive()
    }
}

/// A thread's means to show that it works.
pub struct Heartbeat {
    watched: Arc<Watched>,
    shared: Arc<Shared>,
}

impl Heartbeat {
    /// Of a thread that nobody watches, for tests.
    pub fn unwatched() -> Self {
        Watchdog::default().watch("unwatched", Duration::MAX)
    }

    /// The thread works.
    pub fn beat(&self) {
        self.watched.last_beat_ms.store(self.shared.now_ms(), Ordering::Relaxed);
        self.shared.faults.inject(&self.watched.name);
    }

    /// The thread begins a job that may take up to `limit` without a heartbeat. It ends when the guard is dropped.
    pub fn begin_long_job(&self, limit: Duration) -> LongJob<'_> {
        self.beat();
        self.watched.limit_ms.store(millis(limit), Ordering::Relaxed);
        LongJob { heartbeat: self }
    }

    /// The thread waits, however long, for somebody outside this process. The wait ends when the guard is dropped.
    pub fn begin_wait(&self) -> LongJob<'_> {
        self.begin_long_job(Duration::MAX)
    }

    /// The thread has seen that another one, which is not watched, has ended although nobody asked it to.
    pub fn report_end_of(&self, thread: &str) {
        let failure = ThreadFailure { thread: thread.to_owned(), kind: FailureKind::Ended };
        let _ = self.shared.failed.try_send(failure);
    }
}

/// A long job or a wait of a thread.
pub struct LongJob<'a> {
    heartbeat: &'a Heartbeat,
}

impl Drop for LongJob<'_> {
    fn drop(&mut self) {
        let Heartbeat { watched, shared } = self.heartbeat;
        watched.last_beat_ms.store(shared.now_ms(), Ordering::Relaxed);
        watched.limit_ms.store(millis(watched.limit), Ordering::Relaxed);
    }
}

/// Runs a function on the calling thread. A failure has this name of the thread.
///
/// # Errors
/// When it panics.
pub fn catch_panic<T>(thread: &str, run: impl FnOnce() -> T) -> Result<T, ThreadFailure> {
    catch_unwind(AssertUnwindSafe(run)).map_err(|payload| {
        let kind = FailureKind::Panicked(panic_message(&*payload).to_owned());
        ThreadFailure { thread: thread.to_owned(), kind }
    })
}

/// The message of a panic.
fn panic_message(payload: &(dyn Any + Send)) -> &str {
    let text = payload.downcast_ref::<&str>().copied();
    text.or_else(|| payload.downcast_ref::<String>().map(String::as_str)).unwrap_or("without a message")
}

fn millis(duration: Duration) -> u64 {
    u64::try_from(duration.as_millis()).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PATIENCE: Duration = Duration::from_secs(30);

    #[test]
    fn a_thread_that_panics_is_reported_with_its_message() {
        let watchdog = Watchdog::default();
        let thread = watchdog.spawn("a", PATIENCE, |_| panic!("number {}", 7)).expect("starts");
        let failure = watchdog.failures().recv_timeout(PATIENCE).expect("reported");
        assert_eq!(failure.to_string(), "panicked in its thread a: number 7");
        thread.join().expect("the panic was caught");
        let thread = watchdog.spawn("b", Duration::ZERO, |_| {}).expect("starts");
        thread.join().expect("ends");
        watchdog.check();
        assert!(watchdog.failures().is_empty(), "a thread that has ended in order is not silent");
    }

    #[test]
    fn a_thread_is_silent_after_its_limit_and_not_while_it_does_a_long_job() {
        let watchdog = Watchdog::default();
        let heartbeat = watchdog.watch("lane", Duration::ZERO);
        let job = heartbeat.begin_long_job(PATIENCE);
        while watchdog.silence_of("lane") < Some(Duration::from_millis(2)) {
            thread::yield_now();
        }
        watchdog.check();
        assert!(watchdog.failures().is_empty(), "a long job is no silence");
        drop(job);
        while watchdog.silence_of("lane") < Some(Duration::from_millis(2)) {
            thread::yield_now();
        }
        watchdog.check();
        let failure = watchdog.failures().try_recv().expect("reported");
        assert!(matches!(failure.kind, FailureKind::Silent(_)) && failure.thread == "lane", "{failure}");
        drop(heartbeat);
        assert_eq!(watchdog.silence_of("lane"), None);
    }

    #[test]
    fn an_injected_fault_strikes_the_named_thread_once() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let watchdog = Watchdog::new(FaultInjection::from_folder(Some(dir.path().to_owned())));
        std::fs::write(dir.path().join("panic-b"), "").expect("written");
        let failures = watchdog.failures();
        let run = |heartbeat: &Heartbeat| heartbeat.beat();
        for name in ["a", "b", "b"] {
            watchdog.spawn(name, PATIENCE, run).expect("starts").join().expect("caught");
        }
        let failure = failures.try_recv().expect("reported");
        assert_eq!((failure.thread.as_str(), failures.is_empty()), ("b", true));
    }
}
