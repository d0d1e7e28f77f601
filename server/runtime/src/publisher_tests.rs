//! Events that clients get for the stack's publications.

use super::*;
use crate::lease_arbiter::LeaseConfig;
use crate::live_map::LiveMapConfig;
use crate::pose_persistence::PosePersistenceConfig;
use crate::testing::{MAP, SESSION, keyframe};
use messages::{
    GoalKind, GoalProgress, GoalStatus, GoalUpdate, LocalisationState, MappingState, Notice, Principal,
    RobotProfile,
};
use store::Store;
use uuid::Uuid;
use vocab::{ClientId, GoalId, Pose, Span, Stamp, Vec3};

struct Rig {
    mailbox: Arc<Mailbox>,
    state_publisher: Arc<StatePublisher>,
    worker: PublisherWorker,
    store: Arc<Store>,
    _dir: tempfile::TempDir,
}

fn rig() -> Rig {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = Arc::new(Store::open(dir.path()).expect("store"));
    let (mailbox, clock) = (Arc::<Mailbox>::default(), Arc::<RobotClock>::default());
    let state_publisher = Arc::<StatePublisher>::default();
    let (jobs, _, _) = Jobs::new(Arc::clone(&mailbox), Arc::clone(&clock));
    let worker = PublisherWorker {
        config: PublisherConfig::default(),
        mailbox: Arc::clone(&mailbox),
        state_publisher: Arc::clone(&state_publisher),
        lease: Arc::new(LeaseArbiter::new(LeaseConfig::default(), Arc::clone(&state_publisher))),
        clock,
        jobs,
        live_map: LiveMap::new(LiveMapConfig::default(), Arc::clone(&store)),
        platform: PlatformProbe::new(RobotProfile::default(), None, store.recordings(), Vec::new()),
        battery: BatteryForecast::default(),
        persistence: PosePersistence::new(PosePersistenceConfig::default(), Arc::clone(&store)),
        goals: Vec::new(),
        docks: None,
        requests: crossbeam_channel::bounded(1).0,
        needs_graph: false,
        is_graph_requested: false,
        tile_recovery: TileRecovery::default(),
    };
    Rig { mailbox, state_publisher, worker, store, _dir: dir }
}

impl Rig {
    /// Publishes and ends. Returns the messages to a gateway that was connected all the time.
    fn run(self, publications: impl IntoIterator<Item = Publication>) -> Vec<CoreMessage> {
        let connection = self.state_publisher.connect();
        self.state_publisher.set_streams(1);
        publications.into_iter().for_each(|publication| self.mailbox.post(publication));
        self.mailbox.close();
        self.worker.run(&Heartbeat::unwatched());
        let id = vocab::CommandId(Uuid::from_u128(99));
        self.state_publisher.answer(id, ClientId(Uuid::from_u128(99)), None);
        let mut messages = Vec::new();
        while let Some(message) = self.state_publisher.next(connection) {
            if matches!(message, CoreMessage::Event { event: Event::CommandDone { .. }, .. }) {
                break;
            }
            messages.push(message);
        }
        messages
    }
}

fn events(messages: Vec<CoreMessage>) -> Vec<Event> {
    let event = |message| match message {
        CoreMessage::Event { event, .. } => Some(event),
        _ => None,
    };
    messages.into_iter().filter_map(event).collect()
}

fn goal(id: u128, status: GoalStatus) -> Publication {
    Publication::Goal(GoalUpdate {
        id: GoalId(Uuid::from_u128(id)),
        kind: GoalKind::WalkTo(Vec3::new(1.0, 0.0, 0.0)),
        by: Principal::operator(ClientId(Uuid::from_u128(5))),
        accepted: Stamp::EPOCH,
        status,
    })
}

#[test]
fn clients_get_the_newest_goals_each_with_its_last_state() {
    let many = (1..=MAX_GOALS as u128 + 1).map(|id| goal(id, GoalStatus::Accepted));
    let running = GoalStatus::Running(GoalProgress { remaining_m: Some(2.0), waits_for: None });
    let events = events(rig().run(many.chain([goal(4, running)])));
    let goals = events.iter().rev().find_map(|event| match event {
        Event::Goals(goals) => Some(goals),
        _ => None,
    });
    let goals = goals.expect("goals were published");
    let ids: Vec<u128> = goals.iter().map(|goal| goal.id.0.as_u128()).collect();
    assert_eq!(ids, [4, 9, 8, 7, 6, 5, 3, 2], "the first goal is too old");
    assert!(matches!(goals[0].status, api::GoalStatus::Running(_)), "{:?}", goals[0]);
}

#[test]
fn a_new_session_clears_what_clients_show_and_its_keyframes_follow() {
    let publications = [
        Publication::Mapping(MappingState::Starting { session: SESSION }),
        Publication::Keyframe(keyframe(SESSION, 0)),
    ];
    let events = events(rig().run(publications));
    let place = |wanted: &dyn Fn(&Event) -> bool| events.iter().position(wanted).expect("published");
    let tiles = events.iter().rev().find_map(|event| match event {
        Event::Tiles(tiles) => Some(tiles),
        _ => None,
    });
    // Both wait for the gateway, so they come as one.
    assert!(tiles.is_some_and(|tiles| tiles.reset && !tiles.added.is_empty()), "{events:?}");
    place(&|event| matches!(event, Event::Loops(loops) if loops.reset));
    assert!(
        events.iter().any(|event| matches!(event, Event::Graph(graph) if graph.session == Some(SESSION))),
        "{events:?}"
    );
}

#[test]
fn only_the_newest_scan_and_estimate_are_published() {
    let at = |nanos| Stamp::EPOCH + Span::from_nanos(nanos);
    let cloud = keyframe(SESSION, 0).cloud;
    let publications = [1, 2].into_iter().flat_map(|nanos| {
        let stamp = at(nanos);
        [
            Publication::Estimate(Estimate { stamp, ..Estimate::default() }),
            Publication::Scan(CorrectedScan { stamp, cloud: Arc::clone(&cloud), ..CorrectedScan::default() }),
        ]
    });
    let messages = rig().run(publications);
    let scans: Vec<(Stamp, usize)> = messages
        .iter()
        .filter_map(|message| match message {
            CoreMessage::Scan { stamp, points, .. } => {
                Some((*stamp, map_codec::decode(points).expect("decodes").points.len()))
            }
            _ => None,
        })
        .collect();
    assert_eq!(scans, [(at(2), 400)]);
    let estimates: Vec<Stamp> = events(messages)
        .iter()
        .filter_map(|event| match event {
            Event::Estimate(estimate) => Some(estimate.stamp),
            _ => None,
        })
        .collect();
    assert_eq!(estimates, [at(2)]);
}

#[test]
fn a_saved_map_that_cannot_be_read_is_a_notice_and_docks_are_saved_when_they_change() {
    let Rig { mailbox, mut worker, store, _dir, .. } = rig();
    worker.publish(Publication::Localisation(LocalisationState::Localised { map: MAP, degradation: None }));
    let notices: Vec<Publication> = mailbox.wait(Instant::now()).ordered.into();
    let [Publication::Notice(Notice { severity: Severity::Warning, text, .. })] = notices.as_slice() else {
        panic!("a notice was expected: {notices:?}");
    };
    assert!(text.starts_with("The map in use cannot be shown: "), "{text}");

    std::fs::create_dir_all(store.dir().map(MAP)).expect("made");
    std::fs::write(store.dir().map_summary(MAP), "{}").expect("written");
    let dock = PoseInMap { map: MAP, map_from_base: Pose::IDENTITY };
    worker.publish(Publication::Docks(Arc::from([dock])));
    assert!(!store.dir().docks().exists(), "the first publication repeats what is on disk");
    let moved = Pose { position: Vec3::new(1.0, 0.0, 0.0), ..Pose::IDENTITY };
    let docks = [PoseInMap { map_from_base: moved, ..dock }];
    worker.publish(Publication::Docks(Arc::from(docks)));
    assert_eq!(store.docks(), docks);
}

#[test]
fn what_a_slow_publisher_has_missed_is_shown_all_the_same() {
    let mut rig = rig();
    let (requests, asked) = crossbeam_channel::bounded(4);
    rig.worker.requests = requests;
    let count = 9;
    let nodes = (0..count).map(|id| keyframe(SESSION, id)).map(|keyframe| messages::GraphNode {
        id: keyframe.id,
        stamp: keyframe.stamp,
        map_from_keyframe: keyframe.map_from_keyframe,
    });
    let graph = Arc::new(messages::PoseGraph { revision: 9, nodes: nodes.collect(), edges: Vec::new() });
    for id in 0..count {
        rig.store.write_session_cloud(&keyframe(SESSION, id)).expect("written");
    }
    // The publisher stands still while these come, so the clouds of the first are dropped.
    let mailbox = Arc::clone(&rig.mailbox);
    mailbox.post(Publication::Mapping(MappingState::Starting { session: SESSION }));
    let cloud = Arc::new(messages::Cloud { xyz: vec![[0.0; 3]; 3 << 20], intensity: Vec::new() });
    for id in 0..count {
        mailbox.post(Publication::Keyframe(Keyframe { cloud: Arc::clone(&cloud), ..keyframe(SESSION, id) }));
    }
    let state_publisher = Arc::clone(&rig.state_publisher);
    let worker = std::thread::spawn(move || rig.worker.run(&Heartbeat::unwatched()));
    let asked = asked.recv_timeout(Duration::from_secs(30)).expect("the whole graph is asked for");
    assert!(matches!(asked, LoopRequest::WholeGraph));
    mailbox.post(Publication::Graph { session: SESSION, graph });
    // Every keyframe has tiles in the end.
    let connection = state_publisher.connect();
    let mut shown = std::collections::BTreeSet::new();
    while shown.len() < count as usize {
        let message = state_publisher.next(connection).expect("connected");
        if let CoreMessage::Event { event: Event::Tiles(tiles), .. } = message {
            shown.extend(tiles.added.iter().map(|tile| tile.anchor));
        }
    }
    mailbox.close();
    worker.join().expect("ended");
}
