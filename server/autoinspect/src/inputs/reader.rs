//! Reads recordings on a separate thread, so that decoding and mapping overlap.

use crate::failure::Failure;
use crate::process::thread_cpu_time;
use crossbeam_channel::{Receiver, Sender};
use messages::Sensor;
use recorder::{ReadError, Recording};
use std::thread::{self, JoinHandle};
use std::time::Duration;
use vocab::Stamp;

/// Parameters of an [`InputReader`].
#[derive(Clone, Copy, Debug)]
struct ReaderConfig {
    /// Largest number of messages that are read ahead: about 1 s, with a few scans. While the queue is full, reading waits. Chosen: it bounds the memory while the stack
    /// is busy.
    max_messages_ahead: usize,
}

const CONFIG: ReaderConfig = ReaderConfig { max_messages_ahead: 256 };

/// A message of a recording, or the error of reading it.
pub type Message = Result<(Stamp, Sensor), ReadError>;

/// Messages of several recordings, one after the other.
pub struct InputReader {
    pub messages: Receiver<Message>,
    thread: JoinHandle<ReadStatistics>,
}

/// Statistics of reading.
#[derive(Clone, Copy, Debug, Default)]
pub struct ReadStatistics {
    /// CPU time of the thread.
    pub time: Duration,
    /// Points without a return.
    pub dropped_points: u64,
}

impl InputReader {
    /// Starts reading.
    pub fn start(recordings: Vec<Recording>) -> Result<Self, Failure> {
        Self::spawn("reader", move |sender| read(&recordings, sender))
    }

    /// Starts another source of messages on a thread of this name. It ends when nobody receives them any more.
    pub fn spawn(
        name: &str,
        work: impl FnOnce(&Sender<Message>) -> ReadStatistics + Send + 'static,
    ) -> Result<Self, Failure> {
        let (sender, messages) = crossbeam_channel::bounded(CONFIG.max_messages_ahead);
        let thread = thread::Builder::new()
            .name(name.to_owned())
            .spawn(move || work(&sender))
            .map_err(Failure::failed)?;
        Ok(Self { messages, thread })
    }

    /// Waits for the thread after the last message.
    pub fn finish(self) -> ReadStatistics {
        drop(self.messages);
        // A panic was reported on standard error; the statistics are then unknown.
        self.thread.join().unwrap_or_default()
    }
}

fn read(recordings: &[Recording], sender: &Sender<Message>) -> ReadStatistics {
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
    ReadStatistics { time: thread_cpu_time(), dropped_points }
}
