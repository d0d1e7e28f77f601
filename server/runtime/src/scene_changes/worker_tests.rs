//! Runs end, and what a comparison finds comes into the site once.

use super::super::baseline::Compared;
use super::*;
use crate::ledger::{LedgerConfig, LedgerQueue, LedgerWorker, SiteKeeper};
use crate::state_publisher::StatePublisher;
use messages::Input;
use site_model::{
    EndedRun, LocalisationQuality, MissionId, MissionStatus, Object, OrientedBox, ReportPlace, RunState,
    SceneChange, SceneChangeKind,
};
use store::{RunCloudCause, RunCloudEntry, RunCloudsConfig};
use vocab::{Covariance6, MapId, Pose, Stamp, Vec3};

const MAP: MapId = MapId(Uuid::from_u128(1));
const MISSION: MissionId = MissionId(Uuid::from_u128(3));
const RUN: RunId = RunId(Uuid::from_u128(10));
const LATER_RUN: RunId = RunId(Uuid::from_u128(11));

/// Where objects appear.
const PLACE: OrientedBox =
    OrientedBox { centre_m: Vec3::new(4.0, 0.0, 0.5), size_m: [0.6, 0.4, 1.0], yaw_rad: 0.2 };

/// Number of clouds of an earlier visit, and what is said to have changed since.
type EarlierRuns = (usize, Vec<ChangedSince>);

/// Finds this number of objects that appeared at one place, or fails.
#[derive(Clone)]
struct FakeFinder {
    found: Option<usize>,
    /// Earlier visits that were those of runs.
    before: Arc<Mutex<Vec<EarlierRuns>>>,
}

impl ChangeFinder for FakeFinder {
    fn compare(
        &self,
        before: &Path,
        after: &Path,
        out: &Path,
        _: &mut dyn FnMut() -> bool,
    ) -> Result<FoundChanges, String> {
        assert!(after.ends_with(RUN.to_string()) || after.ends_with(LATER_RUN.to_string()));
        if !before.ends_with(MAP.to_string()) {
            let clouds = store::read_run_index(before).expect("read").len();
            let changes = store::read_changed_since(before).expect("read");
            self.before.lock().expect("no panic").push((clouds, changes));
        }
        let found = self.found.ok_or_else(|| "It needs more memory.".to_owned())?;
        fs::create_dir_all(out).expect("made");
        let file = |name: &str| {
            fs::write(out.join(name), name).expect("written");
            out.join(name)
        };
        let place = PLACE;
        let kind = SceneChangeKind::Appeared;
        let cloud = file("object-1.ply");
        let objects = vec![
            FoundChange {
                kind,
                place,
                points: 80,
                confidence: 0.99,
                cloud,
                move_probability: None,
                descriptor: None
            };
            found
        ];
        Ok(FoundChanges { objects, changed: file("changed.ply"), unchanged: file("unchanged.ply") })
    }
}

fn keep_cloud(store: &Store, run: RunId, utc_ns: i64) {
    let entry = RunCloudEntry {
        cloud: BlobHash([0; 32]),
        bytes: 0,
        robot_time: Stamp::EPOCH,
        utc_ns,
        cause: RunCloudCause::Distance,
        mission: Some(MISSION),
        step: None,
        place: ReportPlace {
            map: Some(MAP),
            map_from_base: Pose::IDENTITY,
            covariance: Covariance6::default(),
            quality: LocalisationQuality::Good,
        },
        base_from_sensor_m: [0.0, 0.0, 0.25],
        points: 1,
    };
    let config = RunCloudsConfig { min_free_bytes: 0, ..RunCloudsConfig::default() };
    store.put_run_cloud(run, entry, &[[1.0, 2.0, 3.0]], &[], &config).expect("written");
}

/// Starts the platform when these runs have ended. Returns the changes that come into the site.
fn start(
    store: &Arc<Store>,
    mailbox: &Arc<Mailbox>,
    ended: &[RunId],
    finder: FakeFinder,
) -> Vec<SceneChange> {
    let of_run = |run: &RunId| EndedRun { run: *run, mission: MISSION, outcome: RunState::Succeeded };
    let status = MissionStatus { ended: ended.iter().map(of_run).collect(), ..MissionStatus::default() };
    let status = Publication::Missions(Arc::new(status));
    let clock = Arc::<RobotClock>::default();
    let (queue, inbox) = LedgerQueue::new(LedgerConfig::default());
    let (inputs, stack) = crossbeam_channel::bounded(16);
    let site = SiteKeeper::open(
        Arc::clone(store),
        Arc::<StatePublisher>::default(),
        inputs.clone(),
        Arc::clone(mailbox),
        Arc::clone(&clock),
        LedgerConfig { retry_period: Duration::from_millis(1), ..LedgerConfig::default() },
    );
    let ledger = LedgerWorker {
        store: Arc::clone(store),
        inbox: Arc::clone(&inbox),
        site,
        inputs,
        mailbox: Arc::clone(mailbox),
        clock: Arc::clone(&clock),
    };
    let (mut ended_runs, runs) = SceneChangeQueue::new();
    ended_runs.watch(&status);
    ended_runs.watch(&status);
    drop(ended_runs);
    let (_running, stop) = crossbeam_channel::bounded(0);
    let worker = SceneChangeWorker {
        finder: Box::new(finder),
        store: Arc::clone(store),
        ledger: inbox,
        runs,
        mailbox: Arc::clone(mailbox),
        clock,
        stop,
    };
    std::thread::scope(|scope| {
        scope.spawn(|| ledger.run(&Heartbeat::unwatched()));
        worker.run(&Heartbeat::unwatched());
        drop(queue);
    });
    let edits = stack.try_iter().filter_map(|input| match input {
        Input::SiteEdited(edit) => Some(edit),
        _ => None,
    });
    let changes = edits.flat_map(|edit| edit.changes).filter_map(|change| match change {
        site_model::Change::Put { object: Object::SceneChange(change), .. } => Some(change),
        _ => None,
    });
    changes.collect()
}

/// The changes that come into the site, and what people are told, when a run has ended and the platform is started twice.
fn changes_of_two_starts(found: Option<usize>) -> (Vec<SceneChange>, Vec<String>) {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = Arc::new(Store::open(dir.path()).expect("opens"));
    keep_cloud(&store, RUN, 77);
    let mailbox = Arc::<Mailbox>::default();
    let finder = FakeFinder { found, before: Arc::default() };
    let mut changes = start(&store, &mailbox, &[RUN], finder.clone());
    changes.extend(start(&store, &mailbox, &[RUN], finder));
    let folder = store.dir().clouds_of_run(RUN);
    assert!(folder.join(MARKER).exists() && !folder.join(FOLDER).exists());
    for clouds in changes.iter().filter_map(|change| change.clouds) {
        assert_eq!(fs::read(store.dir().blob(clouds.object)).expect("kept"), b"object-1.ply");
        assert_eq!(fs::read(store.dir().blob(clouds.unchanged)).expect("kept"), b"unchanged.ply");
    }
    let mail = mailbox.wait(std::time::Instant::now());
    let told = mail.ordered.into_iter().filter_map(|publication| match publication {
        Publication::Notice(notice) => Some(notice.text),
        _ => None,
    });
    (changes, told.collect())
}

#[test]
fn a_run_that_has_ended_is_compared_once() {
    let (changes, told) = changes_of_two_starts(Some(1));
    assert_eq!(changes.len(), 1, "{changes:?}");
    let SceneChange { map, before, after, first_seen, times_seen, clouds, .. } = &changes[0];
    assert_eq!((*map, *before, *after), (MAP, EarlierVisit::Map(MAP), RUN));
    assert_eq!((*first_seen, *times_seen, clouds.is_some()), (Utc(77), 1, true));
    assert_eq!(told, ["Compared with the map, 1 thing changed. Look at Changes on Runs."]);
}

#[test]
fn a_comparison_that_fails_is_told_once_and_changes_nothing() {
    let (changes, told) = changes_of_two_starts(None);
    assert_eq!(changes, []);
    assert_eq!(told, ["The run was not compared with earlier ones. It needs more memory."]);
}

#[test]
fn a_comparison_that_finds_nothing_says_so() {
    let (changes, told) = changes_of_two_starts(Some(0));
    assert_eq!(changes, []);
    assert_eq!(told, ["Compared with the map, nothing has changed."]);
}

#[test]
fn a_later_run_is_compared_with_what_was_last_seen_and_told_what_has_changed_since() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = Arc::new(Store::open(dir.path()).expect("opens"));
    let finder = FakeFinder { found: Some(1), before: Arc::default() };
    let mailbox = Arc::<Mailbox>::default();
    keep_cloud(&store, RUN, 77);
    start(&store, &mailbox, &[RUN], finder.clone());
    keep_cloud(&store, LATER_RUN, 99);
    start(&store, &mailbox, &[LATER_RUN, RUN], finder.clone());
    assert_eq!(*finder.before.lock().expect("no panic"), [(1, Vec::new())], "of the one earlier run");
    assert!(!store.dir().background().exists(), "it is made for one comparison");
    let marker = fs::read(store.dir().clouds_of_run(LATER_RUN).join(MARKER)).expect("compared");
    let compared: Compared = serde_json::from_slice(&marker).expect("read");
    let change = ChangedSince { utc_ns: 99, was: None, is: Some(PLACE) };
    assert_eq!((compared.before, compared.changes), (Some(EarlierVisit::Run(RUN)), vec![change]));
}
