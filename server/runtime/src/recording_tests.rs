//! The queue of the recorder: what is written, what is left out, and what people read about it.

use super::*;
use messages::Publication;
use ports::JournalError;
use std::sync::Mutex;
use store::Store;

/// Appends to a list, and fails once it holds `capacity` inputs.
struct ListJournal {
    written: Arc<Mutex<Vec<Stamp>>>,
    capacity: usize,
}

impl Journal for ListJournal {
    fn append(&mut self, at: Stamp, _input: &Input) -> Result<(), JournalError> {
        let mut written = self.written.lock().expect("no panic");
        if written.len() == self.capacity {
            return Err(JournalError("the disk is full".into()));
        }
        written.push(at);
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), JournalError> {
        Ok(())
    }
}

struct Rig {
    queue: RecorderQueue,
    recorder: Recorder,
    written: Arc<Mutex<Vec<Stamp>>>,
    mailbox: Arc<Mailbox>,
    _dir: tempfile::TempDir,
}

fn rig(max_queued_inputs: usize, capacity: usize) -> Rig {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = Store::open(dir.path()).expect("store");
    let written = Arc::<Mutex<Vec<Stamp>>>::default();
    let target = RecordingTarget {
        journal: Box::new(ListJournal { written: Arc::clone(&written), capacity }),
        path: dir.path().join("recordings/now.mcap"),
        recordings: store.recordings(),
    };
    let config = RecorderConfig { max_queued_inputs, ..RecorderConfig::default() };
    let mailbox = Arc::<Mailbox>::default();
    let (queue, recorder) = Recorder::new(config, target, Arc::clone(&mailbox), Arc::default());
    Rig { queue, recorder, written, mailbox, _dir: dir }
}

fn notices(mailbox: &Mailbox) -> Vec<(Severity, String)> {
    let is_notice = |publication| match publication {
        Publication::Notice(notice) => Some((notice.severity, notice.text)),
        _ => None,
    };
    mailbox.wait(Instant::now()).ordered.into_iter().filter_map(is_notice).collect()
}

#[test]
fn inputs_that_find_the_queue_full_are_left_out_and_counted() {
    let Rig { queue, recorder, written, mailbox, _dir } = rig(2, usize::MAX);
    for nanos in 0..5 {
        queue.record(Stamp::from_nanos(nanos), &Input::Tick);
    }
    drop(queue);
    recorder.run();
    assert_eq!(*written.lock().expect("no panic"), [0, 1].map(Stamp::from_nanos));
    assert_eq!(notices(&mailbox), [(Severity::Warning, texts::inputs_lost(3))]);
}

#[test]
fn a_failing_disk_ends_the_recording_with_one_notice_and_the_queue_blocks_nobody() {
    let Rig { queue, recorder, written, mailbox, _dir } = rig(10, 1);
    queue.record(Stamp::from_nanos(0), &Input::Tick);
    queue.record(Stamp::from_nanos(1), &Input::Tick);
    recorder.run();
    queue.record(Stamp::from_nanos(2), &Input::Tick);
    assert_eq!(written.lock().expect("no panic").len(), 1);
    let notices = notices(&mailbox);
    assert_eq!(notices.len(), 1, "{notices:?}");
    assert_eq!(notices[0].0, Severity::Error);
    assert!(notices[0].1.contains("the disk is full"), "{notices:?}");
}
