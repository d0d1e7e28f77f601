//! Reads recordings on a thread of its own, so that decoding and mapping overlap.

use crate::failure::Failure;
use crate::process::thread_cpu_time;
use crossbeam_channel::{Receiver, Sender};
use messages::Sensor;
use recorder::{ReadError, Recording};
use std::thread::{self, JoinHandle};
use std::time::Duration;
use vocab::Stamp;

/// Messages read ahead: a second or so, and a few scans.
const AHEAD_MAX: usize = 256;

/// What comes out of a recording.
pub type Message = Result<(Stamp, Sensor), ReadError>;

/// Messages of several recordings, one after the other.
pub struct Reader {
    pub messages: Receiver<Message>,
    thread: JoinHandle<Tally>,
}

/// What reading took.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    /// CPU time.
    pub time: Duration,
    /// Points without a return.
    pub dropped_points: u64,
}

impl Reader {
    /// Begins to read.
    pub fn start(recordings: Vec<Recording>) -> Result<Self, Failure> {
        let (sender, messages) = crossbeam_channel::bounded(AHEAD_MAX);
        let thread = thread::Builder::new()
            .name("reader".to_owned())
            .spawn(move || read(&recordings, &sender))
            .map_err(Failure::failed)?;
        Ok(Self { messages, thread })
    }

    /// Once all messages have come.
    pub fn finish(self) -> Tally {
        drop(self.messages);
        // A panic has been reported on standard error; the tally is then unknown.
        self.thread.join().unwrap_or_default()
    }
}

fn read(recordings: &[Recording], sender: &Sender<Message>) -> Tally {
    let mut dropped_points = 0;
    for recording in recordings {
        let mut inputs = recording.inputs();
        for message in inputs.by_ref() {
            if sender.send(message).is_err() {
                break;
            }
        }
        dropped_points += inputs.dropped_points();
    }
    Tally { time: thread_cpu_time(), dropped_points }
}
