use super::*;
use crate::state_publisher::StatePublisher;
use api::{CoreMessage, EditDone, Event, QueryReply, RunFilter, SiteAssembly, SiteState};
use messages::{ResultRecord, RunRecord, SiteWrite};
use site_model::{
    ActionReport, ActionRequest, Alert, AlertState, Asset, AssetId, Change, EditError, EditId, GaugeReport,
    InspectionPoint, InspectionPointId, MissionEvent, MissionEventKind, MissionId, MonitorId, NodeId, Object,
    ObjectId, Reading, ReadingLimits, Revision, RunId,
};
use std::fs;
use std::thread::{self, JoinHandle};
use std::time::Instant;
use tempfile::TempDir;
use uuid::Uuid;
use vocab::ClientId;

const PATIENCE: Duration = Duration::from_secs(30);

/// A running ledger, and a gateway that reads what it publishes.
struct Bench {
    dir: TempDir,
    store: Arc<Store>,
    queue: Option<LedgerQueue>,
    inbox: Arc<LedgerInbox>,
    inputs: crossbeam_channel::Receiver<Input>,
    mailbox: Arc<Mailbox>,
    publisher: Arc<StatePublisher>,
    connection: u64,
    thread: Option<JoinHandle<()>>,
}

impl Bench {
    fn start() -> Self {
        Self::on(tempfile::tempdir().expect("temporary directory"))
    }

    fn on(dir: TempDir) -> Self {
        let store = Arc::new(Store::open(dir.path()).expect("opens"));
        let config = LedgerConfig { retry_period: Duration::from_millis(1), ..LedgerConfig::default() };
        let (queue, inbox) = LedgerQueue::new(config);
        let (sender, inputs) = crossbeam_channel::unbounded();
        let mailbox = Arc::<Mailbox>::default();
        let publisher = Arc::<StatePublisher>::default();
        let clock = Arc::<RobotClock>::default();
        let site = SiteKeeper::open(
            Arc::clone(&store),
            Arc::clone(&publisher),
            sender.clone(),
            Arc::clone(&mailbox),
            Arc::clone(&clock),
            config,
        );
        let connection = publisher.connect();
        let worker = LedgerWorker {
            store: Arc::clone(&store),
            inbox: Arc::clone(&inbox),
            site,
            inputs: sender,
            mailbox: Arc::clone(&mailbox),
            clock,
        };
        let thread = Some(thread::spawn(move || worker.run(&Heartbeat::unwatched())));
        Self { dir, store, queue: Some(queue), inbox, inputs, mailbox, publisher, connection, thread }
    }

    fn queue(&self) -> &LedgerQueue {
        self.queue.as_ref().expect("running")
    }

    /// Ends it, and returns its directory.
    fn end(mut self) -> TempDir {
        drop(self.queue.take());
        self.thread.take().expect("running").join().expect("ended");
        self.dir
    }

    /// The next commit that is durable. What the stack is told of the site is left out.
    fn committed(&self, patience: Duration) -> Option<u64> {
        loop {
            match self.inputs.recv_timeout(patience).ok()? {
                Input::Committed { seq } => return Some(seq),
                Input::MissionsRestored(_) | Input::Site(_) | Input::SiteEdited(_) => {}
                input => panic!("not of the ledger: {input:?}"),
            }
        }
    }

    fn next(&self) -> CoreMessage {
        self.publisher.next(self.connection).expect("connected")
    }

    /// Waits for the answer to an edit. Returns it with the changes that were published before it.
    fn done(&self, id: EditId) -> (EditOutcome, Vec<u64>) {
        let mut changes = Vec::new();
        loop {
            match self.next() {
                CoreMessage::Event { event: Event::SiteChanged(changed), .. } => {
                    changes.push(changed.revision)
                }
                CoreMessage::Event { event: Event::EditDone(EditDone { id: done, outcome }), .. }
                    if done == id =>
                {
                    return (outcome, changes);
                }
                _ => {}
            }
        }
    }

    fn edit(&self, edit: Edit) -> (EditOutcome, Vec<u64>) {
        let id = edit.id;
        let by = Principal::operator(ClientId(Uuid::from_u128(5)));
        self.inbox.edit(EditRequest { by, address: None, edit }).expect("room for it");
        self.done(id)
    }
}

fn asset(number: u128, name: &str) -> Object {
    Object::Asset(Asset {
        id: AssetId(Uuid::from_u128(number)),
        name: name.to_owned(),
        tags: Default::default(),
    })
}

fn asset_id(number: u128) -> ObjectId {
    ObjectId::Asset(AssetId(Uuid::from_u128(number)))
}

fn put(number: u128, base: Option<u64>, object: Object) -> Edit {
    let changes = vec![Change::Put { base: base.map(Revision), object }];
    Edit { id: EditId(Uuid::from_u128(number)), changes }
}

fn latch() -> LedgerEvent {
    LedgerEvent::StopLatch(Some(StopLatch { by: None }))
}

fn run() -> LedgerEvent {
    LedgerEvent::Run(RunRecord {
        run: RunId(Uuid::from_u128(50)),
        mission: MissionId(Uuid::from_u128(60)),
        state: "running".to_owned(),
        is_ended: false,
        body: "{}".to_owned(),
    })
}

#[test]
fn a_commit_is_answered_once_the_disk_has_taken_it() {
    let bench = Bench::start();
    // A directory in the place of the file: writing fails until it is gone.
    let obstacle = bench.store.dir().stop_latch();
    fs::create_dir(&obstacle).expect("made");
    assert_eq!(bench.queue().commit(3, vec![run(), latch()]), None);
    let mail = bench.mailbox.wait(Instant::now() + PATIENCE);
    assert!(format!("{:?}", mail.ordered).contains("stop.json"), "{:?}", mail.ordered);
    assert_eq!(bench.committed(Duration::ZERO), None, "nothing was written");
    // What needs no disk waits for what comes before it.
    assert_eq!(bench.queue().commit(4, Vec::new()), None);
    fs::remove_dir(&obstacle).expect("removed");
    let mut newest = 0;
    while newest < 4 {
        newest = bench.committed(PATIENCE).expect("committed");
    }
    assert_eq!(bench.store.stop_latch().latch, Some(StopLatch { by: None }));
    let dir = bench.end();
    let store = Store::open(dir.path()).expect("opens");
    let (ledger, _) = store.open_ledger().expect("opens");
    assert_eq!(ledger.unfinished_runs().expect("read").len(), 1);
}

#[test]
fn an_edit_is_published_then_answered_and_there_after_a_restart() {
    let bench = Bench::start();
    let (outcome, published) = bench.edit(put(1, None, asset(1, "Pump")));
    assert!(
        matches!(&outcome, EditOutcome::Applied { revision: 1, changes } if changes.len() == 1),
        "{outcome:?}"
    );
    assert_eq!(published, [1]);
    let dir = bench.end();

    let bench = Bench::on(dir);
    // Sent again, it gets its answer again and changes nothing.
    assert_eq!(bench.edit(put(1, None, asset(1, "Pump"))), (outcome, Vec::new()));
    let (conflict, published) = bench.edit(put(2, None, asset(1, "Fan")));
    let expected = EditError::Conflict { object: asset_id(1), revision: Some(Revision(1)) };
    assert_eq!(conflict, EditOutcome::Refused(EditRefusal::Invalid(vec![expected])));
    assert_eq!(published, [0; 0]);
    assert!(matches!(
        bench.edit(put(3, Some(1), asset(1, "Fan"))).0,
        EditOutcome::Applied { revision: 2, .. }
    ));
    let query = Query::Revisions { object: asset_id(1), before: None, limit: 100 };
    bench.inbox.query(9, query).expect("room for it");
    let reply = loop {
        if let CoreMessage::Reply { number: 9, result } = bench.next() {
            break result;
        }
    };
    let Ok(QueryReply::Revisions(revisions)) = reply else { panic!("{reply:?}") };
    assert_eq!(revisions.iter().map(|it| it.revision.0).collect::<Vec<_>>(), [2, 1]);
    drop(bench.end());
}

#[test]
fn all_that_is_wrong_with_an_edit_is_told_and_nothing_of_it_is_applied() {
    let bench = Bench::start();
    bench.edit(put(1, None, asset(1, "Pump")));
    let change =
        |base: Option<u64>, number| Change::Put { base: base.map(Revision), object: asset(number, "x") };
    let changes = vec![change(None, 1), change(None, 2), change(Some(4), 3), change(None, 2)];
    let id = EditId(Uuid::from_u128(2));
    let (outcome, _) = bench.edit(Edit { id, changes });
    let EditOutcome::Refused(EditRefusal::Invalid(errors)) = outcome else { panic!("{outcome:?}") };
    assert_eq!(errors.len(), 3, "{errors:?}");
    let (outcome, _) = bench.edit(Edit { id, changes: Vec::new() });
    assert!(matches!(outcome, EditOutcome::Refused(EditRefusal::Rejected(_))), "{outcome:?}");
    let huge = "x".repeat(api::MAX_OBJECT_BYTES);
    let (outcome, _) = bench.edit(put(3, None, asset(5, &huge)));
    assert!(matches!(outcome, EditOutcome::Refused(EditRefusal::Rejected(_))), "{outcome:?}");
    let (outcome, _) = bench.edit(put(4, Some(1), asset(1, "Pump 1")));
    assert!(matches!(outcome, EditOutcome::Applied { revision: 2, .. }), "{outcome:?}");
    drop(bench.end());
}

/// A graph that was made of a map is entered at once.
#[test]
fn an_edit_of_ten_thousand_objects_is_one_change_and_comes_in_parts_to_whoever_connects() {
    let bench = Bench::start();
    let objects = (0..10_000)
        .map(|number| Change::Put { base: None, object: asset(number, "A pump with a longer name") });
    let edit = Edit { id: EditId(Uuid::from_u128(1)), changes: objects.collect() };
    let (outcome, published) = bench.edit(edit);
    assert!(matches!(outcome, EditOutcome::Applied { revision: 1, .. }));
    assert_eq!(published, [1]);
    let connection = bench.publisher.connect();
    let mut assembly = SiteAssembly::default();
    let (mut parts, mut whole) = (0, None::<SiteState>);
    while whole.is_none() {
        let message = bench.publisher.next(connection).expect("connected");
        if let CoreMessage::Event { event: Event::SitePart(part), .. } = message {
            parts += 1;
            whole = assembly.add(&part);
        }
    }
    assert!(parts > 1);
    assert_eq!(whole.map(|state| (state.revision, state.site.objects().len())), Some((1, 10_000)));
    drop(bench.end());
}

#[test]
fn the_robots_own_changes_need_no_revision() {
    let bench = Bench::start();
    bench.edit(put(1, None, asset(1, "Pump")));
    bench.edit(put(2, None, asset(2, "Fan")));
    let write = SiteWrite { put: vec![asset(1, "Pump, hot")], removed: vec![asset_id(2), asset_id(3)] };
    assert_eq!(bench.queue().commit(0, vec![LedgerEvent::Site(write)]), None);
    assert_eq!(bench.committed(PATIENCE), Some(0));
    let dir = bench.end();
    let (_, state) = Store::open(dir.path()).expect("opens").open_ledger().expect("opens");
    let names: Vec<_> = state.site.objects().map(|it| (it.revision.0, it.object.name())).collect();
    assert_eq!((state.revision, names), (3, vec![(2, Some("Pump, hot"))]));
}

#[test]
fn a_ledger_of_a_later_program_is_told_and_edits_are_refused() {
    let dir = Bench::start().end();
    // The version of the schema, in the header of the file.
    let path = dir.path().join("ledger.db");
    let mut bytes = fs::read(&path).expect("read");
    bytes[63] = 99;
    fs::write(&path, &bytes).expect("written");
    let bench = Bench::on(dir);
    assert!(bench.store.take_problems()[0].contains("update AutoInspect"));
    let (outcome, _) = bench.edit(put(1, None, asset(1, "Pump")));
    let EditOutcome::Refused(EditRefusal::Unavailable(reason)) = outcome else { panic!("{outcome:?}") };
    assert!(reason.contains("update AutoInspect"), "{reason}");
    let dir = bench.end();
    assert!(fs::read(path).expect("read") == bytes, "nothing was written to it");
    drop(dir);
}

#[test]
fn what_does_not_fit_the_queue_is_refused_at_once() {
    let (queue, inbox) =
        LedgerQueue::new(LedgerConfig { max_waiting_requests: 1, ..LedgerConfig::default() });
    let request = || EditRequest {
        by: Principal::operator(ClientId(Uuid::from_u128(5))),
        address: None,
        edit: put(1, None, asset(1, "Pump")),
    };
    assert_eq!(inbox.edit(request()), Ok(()));
    assert!(matches!(inbox.edit(request()), Err(EditOutcome::Refused(EditRefusal::Unavailable(_)))));
    drop(queue);
    assert_eq!(
        inbox.query(1, Query::Runs { filter: RunFilter::default(), before: None, limit: 1 }),
        Err(texts::CORE_ENDS)
    );
}

#[test]
fn the_stack_is_told_the_site_its_edits_and_what_earlier_programs_have_committed() {
    let bench = Bench::start();
    let next_input = |bench: &Bench| bench.inputs.recv_timeout(PATIENCE).expect("told");
    assert_eq!(next_input(&bench), Input::MissionsRestored(Vec::new()));
    assert_eq!(next_input(&bench), Input::Site(Box::default()));
    let edit = put(1, None, asset(7, "Pump"));
    bench.edit(edit.clone());
    assert_eq!(next_input(&bench), Input::SiteEdited(Box::new(edit)));
    let holds = MissionEvent {
        utc: None,
        command: None,
        kind: MissionEventKind::MonitorChanged { monitor: MonitorId(Uuid::from_u128(8)), holds: true },
    };
    assert_eq!(bench.queue().commit(0, vec![LedgerEvent::Mission(holds.clone())]), None);
    assert_eq!(next_input(&bench), Input::Committed { seq: 0 });

    let bench = Bench::on(bench.end());
    assert_eq!(next_input(&bench), Input::MissionsRestored(vec![holds]));
    let Input::Site(site) = next_input(&bench) else { panic!("the site") };
    assert_eq!(site.objects.len(), 1);
}

const BOILER: InspectionPointId = InspectionPointId(Uuid::from_u128(9));

/// An inspection point whose readings are to be 5 bar at most.
fn boiler() -> Object {
    Object::InspectionPoint(InspectionPoint {
        id: BOILER,
        name: "Boiler".to_owned(),
        asset: None,
        node: NodeId(Uuid::from_u128(2)),
        target_m: vocab::Vec3::default(),
        request: ActionRequest { action: "photo".to_owned(), parameters: Default::default() },
        limits: Some(ReadingLimits { min: None, max: Some(5.0), unit: "bar".to_owned() }),
        gauge: None,
    })
}

/// What was read there. `problem`: why its gauge was not read.
fn boiler_result(step: u32, bar: f64, problem: Option<&str>) -> LedgerEvent {
    let report = ActionReport {
        readings: vec![Reading {
            name: "gauge".to_owned(),
            value: bar,
            standard_deviation: None,
            unit: "bar".to_owned(),
        }],
        gauge: Some(GaugeReport { problem: problem.map(str::to_owned), ..GaugeReport::default() }),
        ..ActionReport::default()
    };
    LedgerEvent::Result(ResultRecord {
        run: RunId(Uuid::from_u128(3)),
        step,
        attempt: 1,
        kind: "photo".to_owned(),
        blob: None,
        body: serde_json::json!({ "inspection_point": BOILER, "value": report }).to_string(),
    })
}

#[test]
fn people_are_told_at_once_of_a_reading_outside_its_limits_and_of_a_gauge_that_was_not_read() {
    let bench = Bench::start();
    bench.edit(put(1, None, boiler()));
    let result = boiler_result;
    let results =
        vec![run(), result(0, 4.9, None), result(1, 5.3, None), result(2, 1.0, Some("It is dark."))];
    assert_eq!(bench.queue().commit(0, results), None);
    while bench.committed(PATIENCE) != Some(0) {}
    let mail = bench.mailbox.wait(Instant::now() + PATIENCE);
    let told: Vec<&str> = mail
        .ordered
        .iter()
        .filter_map(|publication| match publication {
            messages::Publication::Notice(notice) => Some(notice.text.as_str()),
            _ => None,
        })
        .collect();
    assert_eq!(told, ["Boiler: the gauge is 5.30 bar, above the limit of 5.00 bar.", "Boiler: It is dark."]);
}

/// Acknowledging and closing are edits of people; the results come between them, and a restart.
#[test]
fn a_reading_outside_its_limits_raises_an_alert_that_people_close_and_later_ones_raise_a_new_one() {
    let bench = Bench::start();
    bench.edit(put(1, None, boiler()));
    let apply = |bench: &Bench, seq: u64, events: Vec<LedgerEvent>| {
        assert_eq!(bench.queue().commit(seq, events), None);
        while bench.committed(PATIENCE) != Some(seq) {}
    };
    apply(&bench, 0, vec![run(), boiler_result(0, 5.3, None)]);
    apply(&bench, 1, vec![boiler_result(1, 5.4, None), boiler_result(1, 5.4, None)]);
    let dir = bench.end();
    let alerts = |dir: &TempDir| -> Vec<Alert> {
        let (_, state) = Store::open(dir.path()).expect("opens").open_ledger().expect("opens");
        state.site.alerts().cloned().collect()
    };
    let raised = alerts(&dir);
    assert_eq!(raised.len(), 1, "{raised:?}");
    assert_eq!((raised[0].times_raised, &raised[0].state), (2, &AlertState::Open), "a result counts once");

    let bench = Bench::on(dir);
    // After a crash, what was not answered is committed again.
    apply(&bench, 1, vec![boiler_result(1, 5.4, None)]);
    let (by, at) = ("Ada".to_owned(), site_model::Utc(1));
    let acknowledged = AlertState::Acknowledged { by: by.clone(), at };
    let closed = AlertState::Closed { by, at, remark: "new valve".to_owned() };
    let decided = |state| Object::Alert(Alert { state, owner: "Ada".to_owned(), ..raised[0].clone() });
    for (number, base, state) in [(2, 2, acknowledged), (3, 3, closed)] {
        let (outcome, _) = bench.edit(put(number, Some(base), decided(state)));
        assert!(matches!(outcome, EditOutcome::Applied { .. }), "{outcome:?}");
    }
    apply(&bench, 2, vec![boiler_result(2, 5.5, None)]);
    let mut after = alerts(&bench.end());
    after.sort_by_key(|alert| alert.state.is_closed());
    let told: Vec<_> = after.iter().map(|alert| (alert.state.name(), alert.times_raised)).collect();
    assert_eq!(told, [("open", 1), ("closed", 2)]);
    assert_ne!(after[0].id, after[1].id);
}
