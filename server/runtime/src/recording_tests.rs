//! The queue of the recorder: what is written, what is left out, what is kept, and what people read about it.

use super::*;
use ports::JournalError;
use std::fs::{File, OpenOptions};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use store::{Recordings, RecordingsConfig};

/// What the disk does.
#[derive(Debug)]
struct Disk {
    /// Inputs that it takes until it fails.
    capacity: usize,
    /// Size of an input, bytes. The files have holes, so that they take no space.
    bytes_per_input: u64,
    /// Number of the inputs in each segment, by its path.
    written: Vec<(PathBuf, Segment, Vec<Stamp>)>,
}

#[derive(Clone)]
struct FakeDisk(Arc<Mutex<Disk>>);

struct FakeFile {
    disk: FakeDisk,
    file: File,
    index: usize,
}

impl FakeDisk {
    fn with<T>(&self, use_it: impl FnOnce(&mut Disk) -> T) -> T {
        use_it(&mut self.0.lock().expect("no panic"))
    }

    fn fail() -> JournalError {
        JournalError("the disk is full".into())
    }
}

impl SegmentWriter for FakeDisk {
    fn create(&mut self, path: &Path, segment: &Segment) -> Result<Box<dyn Journal>, JournalError> {
        let file = OpenOptions::new().create(true).append(true).open(path).map_err(|_| Self::fail())?;
        let index = self.with(|disk| {
            disk.written.push((path.to_owned(), segment.clone(), Vec::new()));
            disk.written.len() - 1
        });
        Ok(Box::new(FakeFile { disk: self.clone(), file, index }))
    }
}

impl Journal for FakeFile {
    fn append(&mut self, at: Stamp, _input: &Input) -> Result<(), JournalError> {
        self.disk.with(|disk| {
            disk.capacity = disk.capacity.checked_sub(1).ok_or_else(FakeDisk::fail)?;
            let (_, _, inputs) = &mut disk.written[self.index];
            inputs.push(at);
            self.file.set_len(inputs.len() as u64 * disk.bytes_per_input).map_err(|_| FakeDisk::fail())
        })
    }

    fn finish(self: Box<Self>) -> Result<(), JournalError> {
        Ok(())
    }
}

struct Rig {
    queue: RecorderQueue,
    recorder: Recorder,
    disk: FakeDisk,
    mailbox: Arc<Mailbox>,
    dir: tempfile::TempDir,
}

fn rig(max_queued_inputs: usize, recordings: RecordingsConfig) -> Rig {
    let dir = tempfile::tempdir().expect("temporary directory");
    let disk = FakeDisk(Arc::new(Mutex::new(Disk {
        capacity: usize::MAX,
        bytes_per_input: 1,
        written: Vec::new(),
    })));
    let config = RecordingsConfig { min_free_bytes: 0, ..recordings };
    let run = Recordings::new(dir.path(), config).begin_run(Stamp::EPOCH).expect("begins");
    let target = RecordingTarget { writer: Box::new(disk.clone()), run };
    let config = RecorderConfig { max_queued_inputs, ..RecorderConfig::default() };
    let mailbox = Arc::<Mailbox>::default();
    let (queue, recorder) = Recorder::new(config, target, Arc::clone(&mailbox), Arc::default());
    Rig { queue, recorder, disk, mailbox, dir }
}

impl Rig {
    fn notices(&self) -> Vec<(Severity, String)> {
        let is_notice = |publication| match publication {
            Publication::Notice(notice) => Some((notice.severity, notice.text)),
            _ => None,
        };
        self.mailbox.wait(Instant::now()).ordered.into_iter().filter_map(is_notice).collect()
    }

    /// The segments as (number, whether it continues the one before, first and last second).
    fn segments(&self) -> Vec<(u32, bool, i64, i64)> {
        let seconds = |at: &Stamp| at.parts().0;
        self.disk.with(|disk| {
            let written = disk.written.iter().filter(|(_, _, inputs)| !inputs.is_empty());
            let span = |inputs: &Vec<Stamp>| (seconds(&inputs[0]), seconds(&inputs[inputs.len() - 1]));
            written
                .map(|(_, segment, inputs)| {
                    let (first, last) = span(inputs);
                    (segment.number, segment.continues, first, last)
                })
                .collect()
        })
    }

    /// Passes what waits in the queue to the recorder.
    fn pump(&mut self) {
        while let Ok(input) = self.recorder.inputs.try_recv() {
            self.recorder.record(input);
        }
    }

    /// Records one input a second, with maintenance every five.
    fn run(&mut self, seconds: std::ops::Range<i64>) {
        for second in seconds {
            self.queue.record(Stamp::from_parts(second, 0), &Input::Tick);
            self.pump();
            if second % 5 == 0 {
                self.recorder.maintain();
            }
        }
    }

    fn incident(&mut self, second: i64) {
        self.queue.report(Incident { at: Stamp::from_parts(second, 0), text: "Simulated.".to_owned() });
    }
}

#[test]
fn a_slow_disk_makes_a_gap_that_is_told_once_and_recording_goes_on() {
    let mut rig = rig(2, RecordingsConfig::default());
    for second in 0..5 {
        rig.queue.record(Stamp::from_parts(second, 0), &Input::Tick);
    }
    rig.pump();
    rig.run(6..10);
    assert_eq!(rig.segments(), [(0, true, 0, 1), (1, false, 6, 9)]);
    assert_eq!(rig.notices(), [(Severity::Warning, texts::recording_resumed(3))]);
}

#[test]
fn a_failing_disk_pauses_the_recording_with_one_notice_and_blocks_nobody() {
    let mut rig = rig(10, RecordingsConfig::default());
    rig.disk.with(|disk| disk.capacity = 1);
    rig.run(1..30);
    let notices = rig.notices();
    assert_eq!(notices.len(), 1, "{notices:?}");
    assert_eq!(notices[0].0, Severity::Error);
    assert!(notices[0].1.contains("the disk is full"), "{notices:?}");

    rig.disk.with(|disk| disk.capacity = usize::MAX);
    rig.run(30..40);
    assert_eq!(rig.notices(), [(Severity::Warning, texts::recording_resumed(29))]);
    let segments = rig.segments();
    assert_eq!((segments[0], segments.len()), ((0, true, 1, 1), 2), "{segments:?}");
    assert_eq!((segments[1].1, segments[1].2, segments[1].3), (false, 31, 39), "{segments:?}");
}

#[test]
fn a_full_disk_pauses_the_recording_until_there_is_room() {
    let config =
        RecordingsConfig { max_bytes: Some(1_000), max_segment_share: 2.0, ..RecordingsConfig::default() };
    let mut rig = rig(10, config);
    rig.disk.with(|disk| disk.bytes_per_input = 300);
    rig.run(1..6);
    let notices = rig.notices();
    assert_eq!(notices.len(), 1, "{notices:?}");
    assert!(notices[0].1.contains(texts::RECORDINGS_FILL_THEIR_SHARE), "{notices:?}");
    // All that recordings may take is less than a recording needs.
    rig.run(6..20);
    assert_eq!((rig.notices(), rig.segments().len()), (Vec::new(), 1));
}

#[test]
fn segments_follow_each_other_without_a_gap() {
    let mut rig = rig(10, RecordingsConfig::default());
    rig.run(0..700);
    drop(rig.recorder);
    let spans: Vec<_> =
        rig.disk.with(|disk| disk.written.iter().map(|(_, _, inputs)| inputs.len()).collect());
    assert_eq!(spans, [300, 300, 100]);
    let all: Vec<Stamp> =
        rig.disk.with(|disk| disk.written.iter().flat_map(|(_, _, inputs)| inputs.clone()).collect());
    assert_eq!(all, (0..700).map(|second| Stamp::from_parts(second, 0)).collect::<Vec<_>>());
    assert!(rig.disk.with(|disk| disk.written.iter().all(|(_, segment, _)| segment.continues)));
}

#[test]
fn a_run_ends_with_everything_written_and_marked() {
    let Rig { mut queue, recorder, disk, dir, .. } = rig(10, RecordingsConfig::default());
    for second in 0..5 {
        queue.record(Stamp::from_parts(second, 0), &Input::Tick);
    }
    let run = recorder.run.clone();
    drop(queue);
    recorder.run(&Heartbeat::unwatched());
    assert_eq!(disk.with(|disk| disk.written[0].2.len()), 5);
    assert!(dir.path().join(run.name()).join("ended").exists());
}

/// Two hours of patrol at 0.7 MB/s, half of the time walking, in 2 GB, with a fault every 20 minutes: two minutes before and after each of them are kept.
#[test]
fn two_hours_of_patrol_in_2_gb_keep_two_minutes_around_each_fault() {
    const BUDGET: u64 = 2_000_000_000;
    let mut rig = rig(10, RecordingsConfig { max_bytes: Some(BUDGET), ..RecordingsConfig::default() });
    rig.disk.with(|disk| disk.bytes_per_input = 700_000);
    let faults = [400, 1_600, 2_800, 4_000, 5_200, 6_400, 6_410];
    for second in 0..7_200 {
        if faults.contains(&second) {
            rig.incident(second);
        }
        rig.run(second..second + 1);
    }
    let kept: Vec<Stamp> = rig.disk.with(|disk| {
        let present = disk.written.iter().filter(|(path, _, _)| path.exists());
        present.flat_map(|(_, _, inputs)| inputs.clone()).collect()
    });
    for fault in faults {
        let missing = (fault - 120..=fault + 120)
            .filter(|second| !kept.contains(&Stamp::from_parts(*second, 0)))
            .count();
        assert_eq!(missing, 0, "around the fault at {fault} s");
    }
    let bytes: u64 = rig.disk.with(|disk| {
        disk.written.iter().filter_map(|(path, _, _)| path.metadata().ok()).map(|file| file.len()).sum()
    });
    assert!(bytes <= BUDGET + 5 * 700_000, "{bytes}");
    assert!(bytes > BUDGET / 2, "the space is used: {bytes}");
    // Otherwise the test would keep everything without any pin.
    assert!(!kept.contains(&Stamp::from_parts(1_000, 0)));
    assert!(rig.notices().is_empty());
}

#[test]
fn the_start_after_an_interruption_is_pinned() {
    let rig_before = rig(10, RecordingsConfig::default());
    let Rig { mut recorder, mut queue, disk, dir, .. } = rig_before;
    queue.record(Stamp::EPOCH, &Input::Tick);
    recorder.record(recorder.inputs.recv().expect("queued"));
    // The process dies here: the run is not ended.
    let config = RecordingsConfig { min_free_bytes: 0, ..RecordingsConfig::default() };
    let run = Recordings::new(dir.path(), config).begin_run(Stamp::from_parts(1, 0)).expect("begins");
    let pinned = |path: PathBuf| path.with_extension("pinned").exists();
    assert!(pinned(recorder.run.segment(0)));
    let target = RecordingTarget { writer: Box::new(disk), run: run.clone() };
    let (mut queue, mut next) =
        Recorder::new(RecorderConfig::default(), target, Arc::default(), Arc::default());
    queue.record(Stamp::EPOCH, &Input::Tick);
    next.record(next.inputs.recv().expect("queued"));
    assert!(pinned(run.segment(0)));
}
