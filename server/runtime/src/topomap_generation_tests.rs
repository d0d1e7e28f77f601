//! A saved map becomes the topological map of the site.

use super::*;
use crate::clock::RobotClock;
use crate::jobs::{ComputeTask, DiskJob, Jobs};
use crate::ledger::{LedgerConfig, LedgerQueue, LedgerWorker, SiteKeeper};
use crate::mailbox::Mailbox;
use crate::testing::save_corridor;
use api::{CoreMessage, SiteAssembly, SiteState};
use crossbeam_channel::Receiver;
use messages::Input;
use std::time::Duration;
use uuid::Uuid;
use vocab::ClientId;
use watchdog::Heartbeat;

const MAP: MapId = MapId(Uuid::from_u128(1));

/// The lanes and the ledger without their threads, and a gateway that reads what is published.
struct Bench {
    generator: TopomapGenerator,
    jobs: Jobs,
    disk: Receiver<DiskJob>,
    worker: Option<LedgerWorker>,
    queue: Option<LedgerQueue>,
    publisher: Arc<StatePublisher>,
    connection: u64,
    stack: Receiver<Input>,
    _compute: Receiver<ComputeTask>,
    _dir: tempfile::TempDir,
}

fn bench() -> Bench {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = Arc::new(Store::open(dir.path()).expect("opens"));
    save_corridor(&store, MAP, 0.0);
    let (mailbox, clock) = (Arc::<Mailbox>::default(), Arc::<RobotClock>::default());
    let publisher = Arc::<StatePublisher>::default();
    let (jobs, disk, compute) = Jobs::new(Arc::clone(&mailbox), Arc::clone(&clock));
    let (queue, inbox) = LedgerQueue::new(LedgerConfig::default());
    let (inputs, stack) = crossbeam_channel::bounded(16);
    let site = SiteKeeper::open(
        Arc::clone(&store),
        Arc::clone(&publisher),
        inputs.clone(),
        Arc::clone(&mailbox),
        Arc::clone(&clock),
        LedgerConfig { retry_period: Duration::from_millis(1), ..LedgerConfig::default() },
    );
    let connection = publisher.connect();
    let (store_of_worker, inbox_of_worker) = (Arc::clone(&store), Arc::clone(&inbox));
    let worker =
        LedgerWorker { store: store_of_worker, inbox: inbox_of_worker, site, inputs, mailbox, clock };
    let generator = TopomapGenerator::new(store, Arc::clone(&publisher), inbox, RobotProfile::default());
    Bench {
        generator,
        jobs,
        disk,
        worker: Some(worker),
        queue: Some(queue),
        publisher,
        connection,
        stack,
        _compute: compute,
        _dir: dir,
    }
}

fn request(map: MapId, edit: u128) -> TopomapRequest {
    TopomapRequest {
        by: Principal::operator(ClientId(Uuid::from_u128(5))),
        map,
        edit: EditId(Uuid::from_u128(edit)),
    }
}

impl Bench {
    fn begin(&self, request: TopomapRequest) -> Result<(), &'static str> {
        self.generator
            .begin(request, |request| self.jobs.start_for_person(DiskJob::ReadTopomapSource(request)))
    }

    /// What the lanes do with the job that waits.
    fn work(&self) {
        let Ok(DiskJob::ReadTopomapSource(request)) = self.disk.try_recv() else { panic!("no job") };
        if let Some(task) = self.generator.read(request) {
            self.generator.generate(task);
        }
    }

    /// Lets the ledger do what waits, and end.
    fn end_ledger(&mut self) {
        drop(self.queue.take());
        self.worker.take().expect("not ended").run(&Heartbeat::unwatched());
    }

    /// How the making ended, with the site after it.
    fn outcome(&self) -> (TopomapGeneration, SiteState) {
        let (mut site, mut parts) = (SiteState::default(), SiteAssembly::default());
        let mut outcome = None;
        loop {
            // The queue to the gateway keeps no order between states and changes of the site.
            let is_complete = match &outcome {
                Some(TopomapGeneration::Done { .. }) => site.revision > 0,
                outcome => outcome.is_some(),
            };
            if let Some(state) = outcome.take_if(|_| is_complete) {
                return (state, site);
            }
            let message = self.publisher.next(self.connection).expect("connected");
            let CoreMessage::Event { event, .. } = message else { continue };
            match event {
                Event::SitePart(part) => site = parts.add(&part).unwrap_or(site),
                Event::SiteChanged(changed) => assert!(site.apply(&changed)),
                Event::TopomapGeneration(TopomapGeneration::Running { .. }) => {}
                Event::TopomapGeneration(state) => outcome = Some(state),
                _ => {}
            }
        }
    }
}

#[test]
fn a_walked_map_becomes_nodes_and_edges_in_one_edit_of_the_person() {
    let mut bench = bench();
    assert_eq!(bench.begin(request(MAP, 7)), Ok(()));
    assert_eq!(bench.begin(request(MAP, 8)), Err(texts::TOPOMAP_IS_MADE));
    bench.work();
    bench.end_ledger();
    let (state, site) = bench.outcome();
    let is_edit =
        |input: &Input| matches!(input, Input::SiteEdited(edit) if edit.id == EditId(Uuid::from_u128(7)));
    assert!(bench.stack.try_iter().any(|input| is_edit(&input)), "the stack gets the edit too");
    let TopomapGeneration::Done { map, edit, summary } = state else { panic!("{state:?}") };
    assert_eq!((map, edit, site.revision), (MAP, EditId(Uuid::from_u128(7)), 1));
    assert_eq!(
        (site.site.nodes().count(), site.site.edges().count()),
        (summary.nodes as usize, summary.edges as usize,)
    );
    assert!(summary.nodes >= 2 && (summary.length_m - 20.0).abs() < 3.0, "{summary:?}");
    assert_eq!((summary.pieces, summary.blocked.len(), summary.floors), (1, 0, 1));
    assert_eq!(site.site.settings().and_then(|settings| settings.map), Some(MAP));
}

#[test]
fn a_map_that_does_not_exist_is_said_and_the_next_one_can_be_made() {
    let bench = bench();
    let missing = MapId(Uuid::from_u128(99));
    assert_eq!(bench.begin(request(missing, 7)), Ok(()));
    bench.work();
    let (state, _) = bench.outcome();
    assert!(
        matches!(&state, TopomapGeneration::Failed { map, reason } if *map == missing && reason.ends_with('.')),
        "{state:?}"
    );
    assert_eq!(bench.begin(request(MAP, 8)), Ok(()));
}
