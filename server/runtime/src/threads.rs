//! The core's threads: how long each may be silent, and how they are started and ended.

use crate::clock::RobotClock;
use crate::mailbox::Mailbox;
use crate::recording::{Recorder, RecorderConfig, RecorderQueue, RecordingTarget};
use crate::start_error::StartError;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;
use watchdog::{Heartbeat, Watchdog};

/// Name of the thread of the control loop.
pub const CONTROL_THREAD: &str = "control";

/// Longest times without a heartbeat. A thread that is silent for longer hangs, and the process has to be started again.
#[derive(Clone, Copy, Debug)]
pub struct ThreadLimits {
    /// The control loop; the main threads of the gateway and of the simulated robot have the same limit. Supervisors judge them much earlier by the
    /// heartbeats that they get. Chosen: it is judged earlier where that is possible, and this is for what they do not see.
    pub control: Duration,
    /// The publisher, which reads the list of tiles of a large map within seconds. Chosen: two minutes, far longer than that.
    pub publisher: Duration,
    /// Threads that write to the disk. A new start mends no disk, so they are given much time. Chosen: ten minutes; disks that come back do so within it.
    pub disk: Duration,
    /// Threads that wait for a job. Jobs have a limit of their own. Chosen: as [`Self::control`].
    pub lane: Duration,
}

/// The limits in force.
pub const THREAD_LIMITS: ThreadLimits = ThreadLimits {
    control: Duration::from_secs(60),
    publisher: Duration::from_secs(120),
    disk: Duration::from_secs(600),
    lane: Duration::from_secs(60),
};

/// The queue of inputs, and the thread that records them until the control loop has ended.
pub fn recorder_thread(
    recording: Option<RecordingTarget>,
    mailbox: &Arc<Mailbox>,
    clock: &Arc<RobotClock>,
    watchdog: &Watchdog,
) -> Result<(RecorderQueue, Option<JoinHandle<()>>), StartError> {
    let Some(target) = recording else {
        return Ok((RecorderQueue::none(), None));
    };
    let (queue, recorder) =
        Recorder::new(RecorderConfig::default(), target, Arc::clone(mailbox), Arc::clone(clock));
    Ok((queue, Some(spawn(watchdog, "recorder", THREAD_LIMITS.disk, move |beat| recorder.run(beat))?)))
}

/// Starts a watched thread.
pub fn spawn(
    watchdog: &Watchdog,
    name: &str,
    limit: Duration,
    run: impl FnOnce(&Heartbeat) + Send + 'static,
) -> Result<JoinHandle<()>, StartError> {
    watchdog.spawn(name, limit, run).map_err(StartError::Thread)
}

/// Waits for a thread's end. A panic of it was reported already.
pub fn join(thread: Option<JoinHandle<()>>) {
    if let Some(thread) = thread {
        let _ = thread.join();
    }
}
