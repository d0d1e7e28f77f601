//! The core goes, comes back, misbehaves.

use crate::support::{Gateway, TestCore, TestSocket};
use api::{
    ClientMessage, Command, CommandOutcome, CoreMessage, Event, GatewayMessage, Graph, GraphChanged,
    GraphNode, Notice, Severity, TileEntry, TileHash, TilesChanged,
};
use vocab::{Aabb, CommandId, KeyframeId, Stamp};

fn tiles(reset: bool, numbers: std::ops::Range<u8>) -> Event {
    let tile = |number| TileEntry {
        hash: TileHash([number; 32]),
        anchor: api::TileAnchor::Map,
        level: 0,
        spacing_m: 1.0,
        bounds: Aabb { min: [0.0; 3], max: [1.0; 3] },
        points: number.into(),
        bytes: 1,
    };
    Event::Tiles(TilesChanged { reset, added: numbers.map(tile).collect() })
}

fn notice(at: i64) -> Event {
    Event::Notice(Notice { at: Stamp::from_nanos(at), severity: Severity::Info, text: "n".into() })
}

async fn core_is(socket: &mut TestSocket, connected: bool) {
    socket
        .find(|event| matches!(event, Event::Platform(p) if p.core_connected == connected).then_some(()))
        .await;
}

async fn send_state(core: &mut TestCore) {
    core.publish(tiles(true, 0..2)).await;
    core.publish(notice(1)).await;
    core.publish(notice(2)).await;
}

/// What a client knows.
#[derive(Default)]
struct Picture {
    tiles: Vec<u32>,
    notices: Vec<i64>,
}

impl Picture {
    /// Reads until these tiles and notices are known, and then whatever else the gateway owes.
    async fn read(&mut self, socket: &mut TestSocket, core: &mut TestCore, tiles: &[u32], notices: &[i64]) {
        self.read_until(socket, |picture, _| picture.tiles == tiles && picture.notices == notices).await;
        // What waited longest goes first, so after two rounds of marks nothing older can be owed.
        for mark in [0.25, 0.75] {
            core.publish(Event::Battery(api::Battery { charge: mark, ..api::Battery::default() })).await;
            let marked =
                |_: &Self, event: &Event| matches!(event, Event::Battery(battery) if battery.charge == mark);
            self.read_until(socket, marked).await;
        }
        assert_eq!((&self.tiles[..], &self.notices[..]), (tiles, notices), "and nothing more");
    }

    async fn read_until(&mut self, socket: &mut TestSocket, done: impl Fn(&Self, &Event) -> bool) {
        let read = |event: &Event| {
            match event {
                Event::Tiles(change) => {
                    if change.reset {
                        self.tiles.clear();
                    }
                    self.tiles.extend(change.added.iter().map(|tile| tile.points));
                }
                Event::Notice(notice) => self.notices.push(notice.at.nanos()),
                _ => {}
            }
            done(self, event).then_some(())
        };
        socket.find(read).await;
    }
}

#[tokio::test]
async fn a_core_that_comes_back_and_repeats_itself_confuses_nobody() {
    let gateway = Gateway::start().await;
    let mut core = gateway.core().await;
    let mut client = gateway.client(1).await;
    core_is(&mut client, true).await;
    send_state(&mut core).await;
    let mut picture = Picture::default();
    picture.read(&mut client, &mut core, &[0, 1], &[1, 2]).await;

    drop(core);
    core_is(&mut client, false).await;
    let mut core = gateway.core().await;
    // This core does not say `reset`: the gateway knows by itself that everything starts anew.
    core.publish(tiles(false, 0..3)).await;
    core.publish(notice(2)).await;
    core.publish(notice(3)).await;
    picture.read(&mut client, &mut core, &[0, 1, 2], &[1, 2, 3]).await;
    let mut newcomer = gateway.client(2).await;
    Picture::default().read(&mut newcomer, &mut core, &[0, 1, 2], &[1, 2, 3]).await;
}

#[tokio::test]
async fn commands_without_a_core_are_refused_and_never_done_later() {
    let gateway = Gateway::start().await;
    let mut client = gateway.client(1).await;
    core_is(&mut client, false).await;
    let id = |number| CommandId(uuid::Uuid::from_u128(number));
    let refused = |number| {
        move |event: &Event| match event {
            Event::CommandDone { id: done, outcome: CommandOutcome::Refused(reason) }
                if *done == id(number) =>
            {
                Some(reason.clone())
            }
            _ => None,
        }
    };
    client.send(&ClientMessage::Command { id: id(1), command: Command::AllowMotion }).await;
    assert!(client.find(refused(1)).await.contains("core"));

    let mut core = gateway.core().await;
    core_is(&mut client, true).await;
    client.send(&ClientMessage::Command { id: id(2), command: Command::AllowMotion }).await;
    core.command().await;
    drop(core);
    assert!(client.find(refused(2)).await.contains("before it answered"), "no answer is owed for ever");

    let mut core = gateway.core().await;
    core_is(&mut client, true).await;
    client.send(&ClientMessage::Command { id: id(3), command: Command::StopMotion }).await;
    let first = core.command().await;
    assert!(
        matches!(first, GatewayMessage::Command { command: Command::StopMotion, .. }),
        "nothing old: {first:?}"
    );
}

#[tokio::test]
async fn health_follows_the_core() {
    let gateway = Gateway::start().await;
    gateway.get(api::paths::HEALTH_PATH, &[]).await.expect_problem(503);
    let core = gateway.core().await;
    let mut client = gateway.client(1).await;
    core_is(&mut client, true).await;
    let reply = gateway.get(api::paths::HEALTH_PATH, &[]).await;
    assert_eq!((reply.status, &reply.json()["clients"]), (200, &1.into()));
    drop(core);
    core_is(&mut client, false).await;
    gateway.get(api::paths::HEALTH_PATH, &[]).await.expect_problem(503);
}

#[tokio::test]
async fn a_core_of_another_version_or_without_sense_is_left_and_tried_again() {
    let gateway = Gateway::start().await;
    let mut other = gateway.raw_core().await;
    other.send(&CoreMessage::Hello { version: api::VERSION + 1 }).await;
    other.closed().await;

    let mut unmannered = gateway.raw_core().await;
    unmannered
        .send(&CoreMessage::Scan {
            stamp: Stamp::EPOCH,
            map_from_base: vocab::Pose::IDENTITY,
            points: vec![],
        })
        .await;
    unmannered.closed().await;
    let health = gateway.get(api::paths::HEALTH_PATH, &[]).await;
    health.expect_problem(503);
    assert!(
        health.json()["detail"].as_str().is_some_and(|detail| detail.contains("sends no hello")),
        "{health:?}"
    );

    for senseless in [&u32::MAX.to_le_bytes()[..], &[3, 0, 0, 0, 255, 255, 255], &[0, 0, 0, 0]] {
        let mut core = gateway.core().await;
        core.send_bytes(senseless).await;
        core.closed().await;
    }
    gateway.core().await;
}

#[tokio::test]
async fn the_core_is_told_who_listens() {
    let gateway = Gateway::start().await;
    let mut core = gateway.core().await;
    assert_eq!(core.receive().await, GatewayMessage::Listeners { clients: 0, streams: 0 });
    let client = gateway.client(1).await;
    core.listeners((1, 0)).await;
    let mut stream = gateway.socket(api::STREAM_PATH).await;
    stream.send(&api::StreamRequest::Open { version: api::VERSION, max_hz: 10.0 }).await;
    core.listeners((1, 1)).await;
    stream.send(&api::StreamRequest::Open { version: api::VERSION, max_hz: 0.0 }).await;
    core.listeners((1, 0)).await;
    drop(client);
    core.listeners((0, 0)).await;
    stream.send(&api::StreamRequest::Open { version: api::VERSION, max_hz: 1.0 }).await;
    core.listeners((0, 1)).await;
    drop(core);
    let mut core = gateway.core().await;
    assert_eq!(
        core.receive().await,
        GatewayMessage::Listeners { clients: 0, streams: 1 },
        "told to a new core"
    );
    drop(stream);
    core.listeners((0, 0)).await;
}

/// A graph with this number of keyframes. The number is also its revision.
fn graph(revision: u64) -> Event {
    let node = |id: u64| GraphNode { id: KeyframeId(id as u32), ..GraphNode::default() };
    Event::Graph(Graph { revision, nodes: (0..revision).map(node).collect(), ..Graph::default() })
}

/// The change from that graph to the next.
fn next_keyframe(base_revision: u64) -> Event {
    let nodes = vec![GraphNode { id: KeyframeId(base_revision as u32), ..GraphNode::default() }];
    let revision = base_revision + 1;
    Event::GraphChanged(GraphChanged { base_revision, revision, nodes, ..GraphChanged::default() })
}

fn of_graph(event: &Event) -> Option<Event> {
    matches!(event, Event::Graph(_) | Event::GraphChanged(_)).then(|| event.clone())
}

#[tokio::test]
async fn lost_changes_of_the_graph_lead_to_the_whole_graph() {
    let gateway = Gateway::start().await;
    let mut core = gateway.core().await;
    let mut client = gateway.client(1).await;
    core.publish(graph(2)).await;
    assert_eq!(client.find(of_graph).await, graph(2));
    core.publish(next_keyframe(2)).await;
    assert_eq!(client.find(of_graph).await, next_keyframe(2));

    // Revision 4 is lost between core and gateway: the gateway asks once, and clients see nothing of what does not apply.
    for base in 4..7 {
        core.publish(next_keyframe(base)).await;
    }
    assert_eq!(core.command().await, GatewayMessage::RequestGraph);
    core.publish(graph(7)).await;
    assert_eq!(client.find(of_graph).await, graph(7));
    core.publish(next_keyframe(7)).await;
    assert_eq!(client.find(of_graph).await, next_keyframe(7));
    client
        .send(&ClientMessage::Command { id: CommandId(uuid::Uuid::nil()), command: Command::StopMotion })
        .await;
    let next = core.command().await;
    assert!(matches!(next, GatewayMessage::Command { .. }), "it asked once: {next:?}");

    // Revision 8 is lost between gateway and client: the gateway's own copy answers.
    client.send(&ClientMessage::RequestGraph).await;
    assert_eq!(client.find(of_graph).await, graph(8));
    core.publish(next_keyframe(8)).await;
    assert_eq!(client.find(of_graph).await, next_keyframe(8));
}

#[tokio::test]
async fn a_map_that_no_single_message_could_hold_reaches_core_gateway_and_client() {
    let gateway = Gateway::start().await;
    let mut core = gateway.core().await;
    let (tile_count, node_count) = (550_000_u32, 600_000_u64);
    let tile = |number: u32| TileEntry {
        hash: TileHash([7; 32]),
        anchor: api::TileAnchor::Keyframe(KeyframeId(number)),
        level: 3,
        spacing_m: 0.25,
        bounds: Aabb { min: [-30.0; 3], max: [30.0; 3] },
        points: number,
        bytes: 50_000,
    };
    let Event::Graph(whole) = graph(node_count) else { panic!("a graph") };
    let all: Vec<TileEntry> = (0..tile_count).map(tile).collect();
    let in_one = CoreMessage::Event { to: None, event: Event::Graph(whole.clone()) };
    assert!(api::encode(&in_one).len() > api::MAX_MESSAGE_BYTES);
    let mut client = gateway.client(1).await;
    let send = async {
        for index in 0..whole.part_count() {
            core.publish(Event::GraphPart(whole.part(index))).await;
        }
        for added in all.chunks(api::MAX_TILES_PER_EVENT) {
            core.publish(Event::Tiles(TilesChanged { reset: false, added: added.to_vec() })).await;
        }
    };
    let (mut assembly, mut graph, mut tiles) = (api::GraphAssembly::default(), None, 0);
    let receive = client.find(|event| {
        match event {
            Event::GraphPart(part) => graph = assembly.add(part).or_else(|| graph.take()),
            Event::Tiles(changed) => {
                assert!(changed.added.iter().zip(tiles..).all(|(tile, number)| tile.points == number));
                tiles += changed.added.len() as u32;
            }
            _ => {}
        }
        (graph.is_some() && tiles == tile_count).then_some(())
    });
    tokio::join!(send, receive);
    assert!(graph == Some(whole), "the whole graph");
}

#[tokio::test]
async fn clients_are_told_which_process_was_started_again_and_why() {
    let restart = |process, cause: &str| api::ProcessRestart { process, cause: cause.into(), count: 2 };
    let (own, of_core) = (
        restart(api::ProcessRole::Gateway, "did not answer for 5 s"),
        restart(api::ProcessRole::Core, "was killed (signal 9)"),
    );
    let gateway = Gateway::start_again(gateway::Limits::default(), Some(own.clone())).await;
    let mut core = gateway.core().await;
    let mut client = gateway.client(1).await;
    let now = Stamp::from_nanos(77);
    let report = api::Platform { now, restarts: vec![of_core.clone()], ..api::Platform::default() };
    core.publish(Event::Platform(report)).await;
    let notice = client
        .find(|event| match event {
            Event::Notice(notice) => Some(notice.clone()),
            _ => None,
        })
        .await;
    assert_eq!((notice.at, notice.severity), (now, Severity::Warning));
    assert!(notice.text.contains("did not answer for 5 s"), "{}", notice.text);
    client
        .find(|event| {
            matches!(event, Event::Platform(platform) if platform.restarts.len() == 2).then_some(())
        })
        .await;
    let health = gateway.get(api::paths::HEALTH_PATH, &[]).await.json();
    assert_eq!(health["restarts"], serde_json::json!([of_core, own]));
}
