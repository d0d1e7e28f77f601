//! Recording inputs on a thread of its own.
//!
//! The queue holds some ten seconds of a fully equipped robot. When the disk is slower than that for longer, inputs
//! are left out and the recording says so in a notice; the robot goes on. When the disk fails, recording ends with a
//! notice; the robot goes on.

use crate::clock::RobotClock;
use crate::mailbox::Mailbox;
use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, TrySendError};
use messages::{Input, Severity};
use ports::Journal;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use store::{RecordingSpace, Recordings};
use vocab::Stamp;

/// Inputs that may wait for the disk.
const QUEUE_MAX: usize = 6_000;
/// How often lost inputs are reported and room is made on the disk.
const LOOK_EVERY: Duration = Duration::from_secs(5);

/// Where a run is recorded.
pub struct RecordingTarget {
    /// Takes the inputs.
    pub journal: Box<dyn Journal>,
    /// The file it writes.
    pub path: PathBuf,
    /// Where that file and its older siblings share the disk.
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

    /// Queues one input. Never blocks; see the head of this file for what happens when the queue is full.
    pub fn record(&self, at: Stamp, input: &Input) {
        let Some(sender) = &self.sender else {
            return;
        };
        if let Err(TrySendError::Full(_)) = sender.try_send((at, input.clone())) {
            self.lost.fetch_add(1, Ordering::Relaxed);
        }
    }
}

/// The recorder's end.
pub struct Recorder {
    target: RecordingTarget,
    inputs: Receiver<(Stamp, Input)>,
    lost: Arc<AtomicU64>,
    mailbox: Arc<Mailbox>,
    clock: Arc<RobotClock>,
}

impl Recorder {
    /// Both ends.
    pub fn new(
        target: RecordingTarget,
        mailbox: Arc<Mailbox>,
        clock: Arc<RobotClock>,
    ) -> (RecorderQueue, Self) {
        let (sender, inputs) = crossbeam_channel::bounded(QUEUE_MAX);
        let lost = Arc::new(AtomicU64::new(0));
        let queue = RecorderQueue { sender: Some(sender), lost: Arc::clone(&lost) };
        (queue, Self { target, inputs, lost, mailbox, clock })
    }

    /// Writes until the control loop ends, then closes the file.
    pub fn run(mut self) {
        if let Err(reason) = self.write_all() {
            self.say(
                Severity::Error,
                format!(
                    "Recording stopped: {reason}. The robot goes on without it; free some disk and restart."
                ),
            );
            return;
        }
        if let Err(error) = self.target.journal.finish() {
            tracing::error!("{}", sentence(&error));
        }
    }

    fn write_all(&mut self) -> Result<(), String> {
        let mut look_at = Instant::now();
        loop {
            match self.inputs.recv_deadline(look_at) {
                Ok((at, input)) => {
                    self.target.journal.append(at, &input).map_err(|error| sentence(&error))?
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            }
            if Instant::now() >= look_at {
                self.report_lost();
                self.make_room()?;
                look_at = Instant::now() + LOOK_EVERY;
            }
        }
    }

    fn make_room(&self) -> Result<(), String> {
        match self.target.recordings.evict_oldest(&self.target.path) {
            Ok(RecordingSpace::Available) => Ok(()),
            Ok(RecordingSpace::Exhausted) => {
                Err("it holds all of the disk that recordings may take".to_owned())
            }
            Err(error) => Err(sentence(&error)),
        }
    }

    fn report_lost(&self) {
        let lost = self.lost.swap(0, Ordering::Relaxed);
        if lost > 0 {
            let text = format!(
                "The disk is too slow: {lost} inputs are missing from the recording, which cannot be replayed \
                 exactly from here on."
            );
            self.say(Severity::Warning, text);
        }
    }

    fn say(&self, severity: Severity, text: String) {
        tracing::warn!("{text}");
        self.mailbox.notice(self.clock.now(), severity, text);
    }
}

/// An error with its causes, for a person.
pub fn sentence(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text = format!("{text}: {error}");
        cause = error.source();
    }
    text
}
