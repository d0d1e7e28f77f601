//! Records inputs on a thread of its own.
//!
//! The queue holds about ten seconds of inputs of a fully equipped robot. When it is full, inputs are left out of the recording and a notice
//! gives their number. When the disk fails, recording ends with a notice. The robot goes on in both cases.

use crate::clock::RobotClock;
use crate::mailbox::Mailbox;
use crate::texts;
use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, TrySendError};
use messages::{Input, Severity};
use ports::{Journal, error_with_causes};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use store::{RecordingSpace, Recordings};
use vocab::Stamp;

/// Parameters of the [`Recorder`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RecorderConfig {
    /// Inputs that may wait for the disk: ten seconds at 600 inputs a second.
    pub max_queued_inputs: usize,
    /// Time between two checks for lost inputs and for space on the disk.
    pub maintenance_period: Duration,
}

impl Default for RecorderConfig {
    fn default() -> Self {
        Self { max_queued_inputs: 6_000, maintenance_period: Duration::from_secs(5) }
    }
}

/// Where a run is recorded.
pub struct RecordingTarget {
    /// Takes the inputs.
    pub journal: Box<dyn Journal>,
    /// The file it writes.
    pub path: PathBuf,
    /// All recordings: the oldest are deleted when they take more than their share of the disk.
    pub recordings: Recordings,
}

/// The control loop's end of the recorder.
pub struct RecorderQueue {
    sender: Option<Sender<(Stamp, Input)>>,
    lost: Arc<AtomicU64>,
}

impl RecorderQueue {
    /// Records nothing.
    pub fn none() -> Self {
        Self { sender: None, lost: Arc::default() }
    }

    /// Queues one input. Never blocks: an input that finds the queue full is left out and counted.
    pub fn record(&self, at: Stamp, input: &Input) {
        let Some(sender) = &self.sender else {
            return;
        };
        if let Err(TrySendError::Full(_)) = sender.try_send((at, input.clone())) {
            self.lost.fetch_add(1, Ordering::Relaxed);
        }
    }
}

/// The recorder's end of the queue.
pub struct Recorder {
    config: RecorderConfig,
    target: RecordingTarget,
    inputs: Receiver<(Stamp, Input)>,
    lost: Arc<AtomicU64>,
    mailbox: Arc<Mailbox>,
    clock: Arc<RobotClock>,
}

impl Recorder {
    /// Both ends of the queue.
    pub fn new(
        config: RecorderConfig,
        target: RecordingTarget,
        mailbox: Arc<Mailbox>,
        clock: Arc<RobotClock>,
    ) -> (RecorderQueue, Self) {
        let (sender, inputs) = crossbeam_channel::bounded(config.max_queued_inputs);
        let lost = Arc::new(AtomicU64::new(0));
        let queue = RecorderQueue { sender: Some(sender), lost: Arc::clone(&lost) };
        (queue, Self { config, target, inputs, lost, mailbox, clock })
    }

    /// Writes until the control loop ends, then closes the file.
    pub fn run(mut self) {
        if let Err(reason) = self.write_all() {
            self.publish_notice(Severity::Error, texts::recording_stopped(&reason));
            return;
        }
        if let Err(error) = self.target.journal.finish() {
            tracing::error!("{}", error_with_causes(&error));
        }
    }

    fn write_all(&mut self) -> Result<(), String> {
        let mut maintenance_at = Instant::now();
        loop {
            match self.inputs.recv_deadline(maintenance_at) {
                Ok((at, input)) => {
                    self.target.journal.append(at, &input).map_err(|error| error_with_causes(&error))?
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            }
            if Instant::now() >= maintenance_at {
                self.report_lost();
                self.make_room()?;
                maintenance_at = Instant::now() + self.config.maintenance_period;
            }
        }
    }

    fn make_room(&self) -> Result<(), String> {
        match self.target.recordings.evict_oldest(&self.target.path) {
            Ok(RecordingSpace::Available) => Ok(()),
            Ok(RecordingSpace::Exhausted) => Err(texts::RECORDINGS_FILL_THEIR_SHARE.to_owned()),
            Err(error) => Err(error_with_causes(&error)),
        }
    }

    fn report_lost(&self) {
        let lost = self.lost.swap(0, Ordering::Relaxed);
        if lost > 0 {
            self.publish_notice(Severity::Warning, texts::inputs_lost(lost));
        }
    }

    fn publish_notice(&self, severity: Severity, text: String) {
        tracing::warn!("{text}");
        self.mailbox.notice(self.clock.now(), severity, text);
    }
}

#[cfg(test)]
#[path = "recording_tests.rs"]
mod tests;
