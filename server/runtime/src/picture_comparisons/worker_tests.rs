//! Photos are stored, and each is compared with the one before it once, also over a restart.

use super::*;
use crate::ledger::{LedgerConfig, LedgerQueue, LedgerWorker, SiteKeeper};
use crate::picture_queue::PictureQueue;
use api::Query;
use messages::{Input, LedgerEvent, Publication, ResultRecord};
use site_model::{
    ActionReport, ActionRequest, AlignedPictures, Edit, EditId, InspectionPoint, InspectionPointId, NodeId,
    Object, PictureChange, ReportFile, RunId,
};
use std::path::PathBuf;
use std::sync::Mutex;
use std::thread::{self, JoinHandle};
use std::time::Instant;
use tempfile::TempDir;
use uuid::Uuid;
use vocab::{BlobHash, ClientId};

const POINT: InspectionPointId = InspectionPointId(Uuid::from_u128(9));

/// Finds a change in each picture, or fails. Notes what was compared: the first byte of the names of both files.
struct FakeComparer {
    pairs: Arc<Mutex<Vec<[u8; 2]>>>,
    fails: bool,
}

impl PictureComparer for FakeComparer {
    fn compare(
        &self,
        before: ComparedPicture<'_>,
        after: ComparedPicture<'_>,
        _: &mut dyn FnMut() -> bool,
    ) -> Result<PictureComparisonOutcome, String> {
        let byte = |file: &std::path::Path| {
            let name = PathBuf::from(file).file_name().expect("a name").to_string_lossy().into_owned();
            u8::from_str_radix(&name[..2], 16).expect("a hash")
        };
        self.pairs.lock().expect("whole").push([byte(before.file), byte(after.file)]);
        if self.fails {
            return Err("It needs more memory.".to_owned());
        }
        let change = PictureChange { min_px: [1, 2], max_px: [3, 4], area_px: 9, strength: 0.7 };
        Ok(PictureComparisonOutcome::Aligned(AlignedPictures {
            after_from_before: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            residual_px: 0.2,
            before_size_px: [640, 480],
            after_size_px: [640, 480],
            changes: vec![change],
        }))
    }
}

/// A ledger and the thread that compares photos.
struct Bench {
    dir: TempDir,
    queue: Option<LedgerQueue>,
    inbox: Arc<LedgerInbox>,
    inputs: Receiver<Input>,
    publisher: Arc<StatePublisher>,
    connection: u64,
    mailbox: Arc<Mailbox>,
    pairs: Arc<Mutex<Vec<[u8; 2]>>>,
    stop: Option<crossbeam_channel::Sender<()>>,
    threads: Vec<JoinHandle<()>>,
}

impl Bench {
    fn start(dir: TempDir, fails: bool) -> Self {
        let store = Arc::new(Store::open(dir.path()).expect("opens"));
        let (queue, inbox) = LedgerQueue::new(LedgerConfig::default());
        let (sender, inputs) = crossbeam_channel::unbounded();
        let (mailbox, publisher, clock) =
            (Arc::<Mailbox>::default(), Arc::<StatePublisher>::default(), Arc::<RobotClock>::default());
        let site = SiteKeeper::open(
            Arc::clone(&store),
            Arc::clone(&publisher),
            sender.clone(),
            Arc::clone(&mailbox),
            Arc::clone(&clock),
            LedgerConfig::default(),
        );
        let connection = publisher.connect();
        let ledger = LedgerWorker {
            store: Arc::clone(&store),
            inbox: Arc::clone(&inbox),
            site,
            inputs: sender,
            mailbox: Arc::clone(&mailbox),
            clock: Arc::clone(&clock),
        };
        let pairs = Arc::default();
        let (pictures, work) = PictureQueue::new();
        inbox.compare_pictures_with(pictures);
        let (stop, stopped) = crossbeam_channel::bounded(0);
        let worker = PictureWorker {
            comparer: Box::new(FakeComparer { pairs: Arc::clone(&pairs), fails }),
            store,
            ledger: Arc::clone(&inbox),
            work,
            state_publisher: Arc::clone(&publisher),
            mailbox: Arc::clone(&mailbox),
            clock,
            stop: stopped,
        };
        let threads = vec![
            thread::spawn(move || ledger.run(&Heartbeat::unwatched())),
            thread::spawn(move || worker.run(&Heartbeat::unwatched())),
        ];
        let (queue, stop) = (Some(queue), Some(stop));
        Self { dir, queue, inbox, inputs, publisher, connection, mailbox, pairs, stop, threads }
    }

    /// Stores results as the stack does.
    fn store(&self, events: Vec<LedgerEvent>) {
        assert_eq!(self.queue.as_ref().expect("running").commit(0, events), None);
        while !matches!(self.inputs.recv().expect("running"), Input::Committed { .. }) {}
    }

    /// Waits until this result is published with a comparison.
    fn compared(&self, number: u64) -> PictureComparison {
        loop {
            let message = self.publisher.next(self.connection).expect("connected");
            let CoreMessage::Event { event: Event::ResultStored(result), .. } = message else { continue };
            if let Some(comparison) = result.comparison.filter(|_| result.number == number) {
                return serde_json::from_str(&comparison).expect("JSON");
            }
        }
    }

    /// The answer to a question about two results.
    fn ask(&self, before: u64, after: u64) -> Result<QueryReply, String> {
        self.inbox.query(5, Query::PictureComparison { before, after }).expect("room for it");
        loop {
            let message = self.publisher.next(self.connection).expect("connected");
            if let CoreMessage::Reply { number: 5, result } = message {
                return result;
            }
        }
    }

    fn pairs(&self) -> Vec<[u8; 2]> {
        self.pairs.lock().expect("whole").clone()
    }

    fn told(&self) -> Vec<String> {
        let mail = self.mailbox.wait(Instant::now());
        let told = mail.ordered.into_iter().filter_map(|publication| match publication {
            Publication::Notice(notice) => Some(notice.text),
            _ => None,
        });
        told.collect()
    }

    fn end(mut self) -> TempDir {
        drop((self.queue.take(), self.stop.take()));
        self.threads.drain(..).for_each(|thread| thread.join().expect("ended"));
        self.dir
    }
}

/// A photo whose file has a hash of this byte.
fn photo(byte: u8, point: Option<InspectionPointId>) -> LedgerEvent {
    let file = ReportFile {
        name: "photo.jpg".to_owned(),
        media_type: "image/jpeg".to_owned(),
        blob: BlobHash([byte; 32]),
        bytes: 5,
    };
    let report = ActionReport { files: vec![file], ..ActionReport::default() };
    result("photo", serde_json::json!({ "inspection_point": point, "value": report }))
}

fn result(kind: &str, body: serde_json::Value) -> LedgerEvent {
    LedgerEvent::Result(ResultRecord {
        run: RunId(Uuid::from_u128(3)),
        step: 0,
        attempt: 1,
        kind: kind.to_owned(),
        blob: None,
        body: body.to_string(),
    })
}

fn new_dir() -> TempDir {
    tempfile::tempdir().expect("temporary directory")
}

#[test]
fn each_photo_is_compared_once_with_the_one_before_it_at_its_point() {
    let bench = Bench::start(new_dir(), false);
    let boiler = InspectionPoint {
        id: POINT,
        name: "Boiler".to_owned(),
        asset: None,
        node: NodeId(Uuid::from_u128(2)),
        target_m: vocab::Vec3::default(),
        request: ActionRequest { action: "photo".to_owned(), parameters: Default::default() },
        limits: None,
        gauge: None,
    };
    let change = site_model::Change::Put { base: None, object: Object::InspectionPoint(boiler) };
    let edit = Edit { id: EditId(Uuid::from_u128(1)), changes: vec![change] };
    let by = messages::Principal::operator(ClientId(Uuid::from_u128(5)));
    bench.inbox.edit(crate::ledger::EditRequest { by, address: None, edit }).expect("room for it");
    let other = InspectionPointId(Uuid::from_u128(8));
    let reading = serde_json::json!({ "inspection_point": POINT, "value": {} });
    bench.store(vec![
        photo(1, Some(POINT)),
        photo(2, Some(other)),
        result("temperature", reading),
        photo(3, None),
        photo(4, Some(POINT)),
    ]);
    let comparison = bench.compared(5);
    assert_eq!((comparison.before, comparison.changes().len()), (1, 1));
    assert_eq!(bench.pairs(), [[1, 4]]);

    // After a restart: only what is new.
    let bench = Bench::start(bench.end(), false);
    bench.store(vec![photo(6, Some(POINT))]);
    assert_eq!(bench.compared(6).before, 5);
    assert_eq!(bench.pairs(), [[4, 6]]);
    // Any pair, whose answer is not stored; and one that was compared before.
    let Ok(QueryReply::PictureComparison(Some(json))) = bench.ask(1, 6) else { panic!("compared") };
    assert_eq!(serde_json::from_str::<PictureComparison>(&json).expect("JSON").before, 1);
    assert!(matches!(bench.ask(5, 6), Ok(QueryReply::PictureComparison(Some(_)))));
    for (before, after) in [(2, 6), (3, 6), (6, 6), (1, 99)] {
        assert_eq!(bench.ask(before, after), Ok(QueryReply::PictureComparison(None)), "{before} {after}");
    }
    assert_eq!(bench.pairs(), [[4, 6], [1, 6]]);
    assert_eq!(
        bench.told(),
        ["Boiler: the photo differs from the one before in 1 place. Look at Points on Runs."]
    );
    let stored = bench.inbox.read(|ledger, _| ledger.point_results(POINT, None, 100)).expect("read");
    let compared: Vec<_> = stored.iter().map(|stored| (stored.number, stored.comparison.is_some())).collect();
    assert_eq!(compared, [(6, true), (5, true), (3, false), (1, false)]);
    bench.end();
}

#[test]
fn a_comparison_that_fails_is_kept_as_a_sentence_and_not_tried_again() {
    let bench = Bench::start(new_dir(), true);
    bench.store(vec![photo(1, Some(POINT)), photo(2, Some(POINT))]);
    let outcome = bench.compared(2).outcome;
    assert_eq!(outcome, PictureComparisonOutcome::NotAligned("It needs more memory.".to_owned()));
    assert_eq!(bench.told(), Vec::<String>::new());
    let bench = Bench::start(bench.end(), true);
    bench.store(vec![photo(3, Some(POINT))]);
    assert_eq!(bench.compared(3).before, 2);
    assert_eq!(bench.pairs(), [[2, 3]], "the earlier pair is not compared again");
    bench.end();
}
