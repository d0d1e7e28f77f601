//! What people change in stored data, and what is refused.

use super::*;
use crate::testing::{MAP, save_map};
use api::{BinnedMap, CommandOutcome, CoreMessage, Event};
use messages::{LocalisationState, Publication};
use uuid::Uuid;
use vocab::ClientId;
use vocab::{SessionId, Stamp};

const CLIENT: ClientId = ClientId(Uuid::from_u128(5));
const UPLOAD: UploadId = UploadId(Uuid::from_u128(6));

fn day(day: i64) -> CalendarTime {
    CalendarTime { utc: Stamp::from_parts(1_700_000_000 + 86_400 * day, 0), is_synchronised: true }
}

/// A worker over a store with the saved map [`MAP`], and the time of day 0.
struct Bench {
    worker: StoredDataWorker,
    connection: u64,
    _dir: tempfile::TempDir,
}

impl Bench {
    fn new() -> Self {
        let dir = tempfile::tempdir().expect("temporary directory");
        let store = Arc::new(Store::open(dir.path()).expect("opens"));
        save_map(&store);
        let state_publisher = Arc::<StatePublisher>::default();
        let connection = state_publisher.connect();
        let worker = StoredDataWorker {
            config: CleanUpConfig::default(),
            store,
            state_publisher,
            mailbox: Arc::default(),
            clock: Arc::default(),
            usage: Arc::default(),
            calendar: || day(0),
            tiles_searched: Instant::now(),
        };
        Self { worker, connection, _dir: dir }
    }

    /// The answer to a change, with the lists that were published before it.
    fn ask(&self, change: StoredDataChange) -> (CommandOutcome, Vec<String>, Vec<BinnedMap>) {
        self.ask_with(change, &[])
    }

    fn ask_with(
        &self,
        change: StoredDataChange,
        interrupted: &[InterruptedSession],
    ) -> (CommandOutcome, Vec<String>, Vec<BinnedMap>) {
        let id = CommandId(Uuid::from_u128(9));
        self.worker.handle(StoredDataRequest { id, by: Principal::operator(CLIENT), change }, interrupted);
        let (mut names, mut binned) = (Vec::new(), Vec::new());
        loop {
            match self.worker.state_publisher.next(self.connection).expect("connected") {
                CoreMessage::Event { event: Event::Maps(maps), .. } => {
                    names = maps.into_iter().map(|map| map.name).collect();
                }
                CoreMessage::Event { event: Event::BinnedMaps(maps), .. } => binned = maps,
                CoreMessage::Event { event: Event::CommandDone { outcome, .. }, to } => {
                    assert_eq!(to, Some(CLIENT));
                    return (outcome, names, binned);
                }
                _ => {}
            }
        }
    }
}

fn refused(outcome: &CommandOutcome) -> &str {
    match outcome {
        CommandOutcome::Refused(sentence) => sentence,
        CommandOutcome::Accepted => panic!("accepted"),
    }
}

#[test]
fn a_map_is_renamed_deleted_and_restored() {
    let bench = Bench::new();
    let (outcome, names, _) = bench.ask(StoredDataChange::RenameMap(MAP, "  Cellar ".to_owned()));
    assert_eq!((outcome, names), (CommandOutcome::Accepted, vec!["Cellar".to_owned()]));
    let (outcome, names, _) = bench.ask(StoredDataChange::RenameMap(MAP, " ".to_owned()));
    assert_eq!((refused(&outcome), names.len()), (texts::MAP_NEEDS_NAME, 1));
    for _ in 0..2 {
        let (outcome, names, binned) = bench.ask(StoredDataChange::DeleteMap(MAP));
        assert_eq!((outcome, names), (CommandOutcome::Accepted, Vec::new()), "also when it is repeated");
        assert_eq!((binned[0].id, binned[0].name.as_str()), (MAP, "Cellar"));
        assert_eq!(binned[0].kept_until, Some(day(7).utc));
        assert_eq!(binned[0].time_left, Some(api::BIN_RETENTION));
    }
    for _ in 0..2 {
        let (outcome, names, binned) = bench.ask(StoredDataChange::RestoreMap(MAP));
        assert_eq!((outcome, names.len(), binned.len()), (CommandOutcome::Accepted, 1, 0));
    }
    bench.ask(StoredDataChange::DeleteMap(MAP));
    let (outcome, names, binned) = bench.ask(StoredDataChange::DeleteMapPermanently(MAP));
    assert_eq!((outcome, names.len(), binned.len()), (CommandOutcome::Accepted, 0, 0));
    let (outcome, ..) = bench.ask(StoredDataChange::RestoreMap(MAP));
    assert_eq!(refused(&outcome), texts::MAP_NOT_IN_BIN);
    assert_eq!(refused(&bench.ask(StoredDataChange::DeleteMap(MAP)).0), texts::MAP_MISSING);
}

#[test]
fn a_map_in_use_is_not_deleted_and_the_sentence_says_what_to_do() {
    let bench = Bench::new();
    let usage = &bench.worker.usage;
    let localisation = |state| usage.update(&Publication::Localisation(state));
    localisation(LocalisationState::Localised { map: MAP, degradation: None });
    let (outcome, names, _) = bench.ask(StoredDataChange::DeleteMap(MAP));
    assert!(refused(&outcome).contains("Leave the map") && names.len() == 1, "{outcome:?}");
    localisation(LocalisationState::Idle);
    usage.begin_import(UPLOAD, vec![MAP]);
    assert!(refused(&bench.ask(StoredDataChange::DeleteMap(MAP)).0).contains("import"));
    usage.end_import();
    let session = SessionId(Uuid::from_u128(3));
    let interrupted =
        InterruptedSession { session, at: Stamp::EPOCH, keyframes: 3, distance_m: 1.0, extends: Some(MAP) };
    let (outcome, names, _) = bench.ask_with(StoredDataChange::DeleteMap(MAP), &[interrupted]);
    assert!(refused(&outcome).contains("interrupted") && names.len() == 1, "{outcome:?}");
}

#[test]
fn nothing_is_deleted_for_good_while_the_clock_is_not_synchronised() {
    let mut bench = Bench::new();
    let upload = bench.worker.store.dir().upload(UPLOAD);
    std::fs::write(&upload, "points").expect("written");
    bench.worker.calendar = || CalendarTime { is_synchronised: false, ..day(40_000) };
    let (_, _, binned) = bench.ask(StoredDataChange::DeleteMap(MAP));
    assert_eq!((binned[0].kept_until, binned[0].time_left), (None, None));
    bench.worker.clean_up();
    assert_eq!(bench.worker.store.binned_maps().expect("listed").len(), 1);
    bench.worker.calendar = || day(10);
    bench.worker.clean_up();
    assert_eq!(bench.worker.store.binned_maps().expect("listed").len(), 1, "its week begins now");
    bench.worker.calendar = || day(17);
    bench.worker.clean_up();
    assert!(bench.worker.store.binned_maps().expect("listed").is_empty());
    assert!(upload.exists(), "it came later than that");
    bench.worker.calendar = || day(40_000);
    bench.worker.clean_up();
    assert!(!upload.exists());
    let mail = bench.worker.mailbox.wait(Instant::now());
    assert!(format!("{:?}", mail.ordered).contains("Hall"), "people are told");
}

#[test]
fn an_upload_that_is_imported_is_not_deleted() {
    let bench = Bench::new();
    let upload = bench.worker.store.dir().upload(UPLOAD);
    std::fs::write(&upload, "points").expect("written");
    bench.worker.usage.begin_import(UPLOAD, Vec::new());
    let (outcome, ..) = bench.ask(StoredDataChange::DeleteUpload(UPLOAD));
    assert_eq!((refused(&outcome), upload.exists()), (texts::UPLOAD_IN_USE, true));
    bench.worker.usage.end_import();
    let (outcome, ..) = bench.ask(StoredDataChange::DeleteUpload(UPLOAD));
    assert_eq!((outcome, upload.exists()), (CommandOutcome::Accepted, false));
}
