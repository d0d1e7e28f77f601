//! Gauges are read once their pictures are taken, before the action ends, so that the value is part of its result. A thread of its own waits for the process that reads them.
//!
//! | what waits | policy |
//! | --- | --- |
//! | pictures | beyond [`ports::MAX_OPEN_ACTIONS`], as many as there can be actions, the result says that the gauge was not read |
//! | values | kept: the thread of actions takes them |

use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, TryRecvError};
use ports::{GaugeReader, MAX_OPEN_ACTIONS, ReadGauge};
use site_model::GaugeDial;
use std::sync::Arc;
use std::time::Duration;
use store::Store;
use vocab::{ActionCallId, BlobHash};
use watchdog::{BEAT_PERIOD, Heartbeat};

/// Longest time for which a picture is read. Chosen: 640 x 480 pixels take a tenth of a second, the largest pictures a minute; beyond ten it hangs.
const MAX_DURATION: Duration = Duration::from_secs(600);

/// A gauge whose picture is stored.
#[derive(Clone, Debug, PartialEq)]
pub struct GaugePicture {
    pub call: ActionCallId,
    pub picture: BlobHash,
    pub dial: GaugeDial,
}

/// What was read, or a sentence why nothing was.
pub type GaugeAnswer = (ActionCallId, Result<ReadGauge, String>);

/// The end of the thread of actions.
pub struct GaugeQueue {
    pub pictures: Sender<GaugePicture>,
    pub answers: Receiver<GaugeAnswer>,
}

/// The thread's end.
pub struct GaugeWorker {
    pub reader: Box<dyn GaugeReader>,
    pub store: Arc<Store>,
    pub pictures: Receiver<GaugePicture>,
    pub answers: Sender<GaugeAnswer>,
    /// Disconnected when the core ends.
    pub stop: Receiver<()>,
}

impl GaugeQueue {
    /// Both ends: this one, and what the thread receives from and sends to.
    pub fn new() -> (Self, Receiver<GaugePicture>, Sender<GaugeAnswer>) {
        let (pictures, waiting) = crossbeam_channel::bounded(MAX_OPEN_ACTIONS);
        let (sender, answers) = crossbeam_channel::unbounded();
        (Self { pictures, answers }, waiting, sender)
    }
}

impl GaugeWorker {
    /// Works until the core ends.
    pub fn run(self, heartbeat: &Heartbeat) {
        while !self.is_ending() {
            heartbeat.beat();
            match self.pictures.recv_timeout(BEAT_PERIOD) {
                Ok(picture) => {
                    let _job = heartbeat.begin_long_job(MAX_DURATION);
                    let dir = self.store.dir();
                    let files = [dir.blob(picture.picture), dir.blob(picture.dial.picture)];
                    let read =
                        self.reader.read(&files[0], &files[1], &picture.dial, &mut || self.is_ending());
                    // The thread of actions may have ended.
                    let _ = self.answers.send((picture.call, read));
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return,
            }
        }
    }

    fn is_ending(&self) -> bool {
        matches!(self.stop.try_recv(), Err(TryRecvError::Disconnected))
    }
}
