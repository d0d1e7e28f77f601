//! Which tiles are fetched, that the counts hold, and which map is on the screen.

use crate::testing::*;
use crate::*;
use api::{
    ClientMessage, Graph, GraphChanged, GraphNode, MapSummary, Mapping, TileAnchor, TileEntry, TileHash,
    TileList, TilesChanged,
};
use proptest::prelude::*;
use uuid::Uuid;
use vocab::{Aabb, KeyframeId, MapId, Pose, SessionId, Stamp, Vec3};

fn max_requests() -> usize {
    TilePlanConfig::default().max_requests
}

#[test]
fn the_coarsest_tiles_come_first_and_few_at_a_time() {
    let mut client = TestClient::connected();
    let mut tiles: Vec<TileEntry> = (0..20).map(|i| tile(i + 10, 2, 2.0 * f32::from(i), 1000)).collect();
    tiles.push(tile(1, 0, 0.0, 1000));
    client.event(api::Event::Tiles(TilesChanged { reset: true, added: tiles }));
    client.apply(ClientEvent::ViewpointChanged(eye_at(-3.0)));
    let fetches: Vec<TileHash> = client
        .take_effects()
        .into_iter()
        .filter_map(|effect| match effect {
            ClientEffect::FetchTile(hash) => Some(hash),
            _ => None,
        })
        .collect();
    assert_eq!(fetches.len(), max_requests());
    assert_eq!(fetches[0], TileHash([1; 32]), "coarse first");
    assert_eq!(fetches[1], TileHash([10; 32]), "then the nearest");
}

#[test]
fn an_eye_that_comes_before_the_tiles_keeps_none_waiting() {
    let mut client = TestClient::connected();
    client.apply(ClientEvent::ViewpointChanged(eye_at(-3.0)));
    assert!(!client.model.displayed_map().tiles.listed());
    client.event(api::Event::Tiles(TilesChanged { reset: true, added: vec![tile(1, 0, 0.0, 10)] }));
    assert!(
        client.take_effects().iter().any(|effect| matches!(effect, ClientEffect::FetchTile(_))),
        "at once, not a period later"
    );
    assert!(client.model.displayed_map().tiles.listed());
}

#[test]
fn tiles_no_longer_wanted_are_cancelled_and_others_fetched() {
    let mut client = TestClient::connected();
    let near: Vec<TileEntry> = (0..8).map(|i| tile(i + 10, 5, f32::from(i), 1000)).collect();
    let far: Vec<TileEntry> = (0..8).map(|i| tile(i + 50, 5, 900.0 + f32::from(i), 1000)).collect();
    client.event(api::Event::Tiles(TilesChanged { reset: true, added: [near, far].concat() }));
    client.apply(ClientEvent::ViewpointChanged(eye_at(-1.0)));
    client.take_effects();
    client.now = client.now.after(1.0);
    client.apply(ClientEvent::ViewpointChanged(eye_at(899.0)));
    let effects = client.take_effects();
    let cancelled = effects.iter().filter(|effect| matches!(effect, ClientEffect::CancelTile(_))).count();
    let fetched = |effect: &&ClientEffect| matches!(effect, ClientEffect::FetchTile(hash) if hash.0[0] >= 50);
    assert_eq!((cancelled, effects.iter().filter(fetched).count()), (max_requests(), max_requests()));
}

#[test]
fn a_tile_that_cannot_be_had_is_tried_again_later_a_few_times() {
    let mut client = TestClient::connected();
    client.event(api::Event::Tiles(TilesChanged { reset: true, added: vec![tile(1, 0, 0.0, 10)] }));
    client.apply(ClientEvent::ViewpointChanged(eye_at(-3.0)));
    let mut tries = 0;
    for _ in 0..600 {
        for effect in client.take_effects() {
            if let ClientEffect::FetchTile(hash) = effect {
                tries += 1;
                client.apply(ClientEvent::TileFailed { hash });
            }
        }
        client.wait(0.5);
    }
    assert_eq!(tries, 5);
}

#[test]
fn tiles_of_keyframes_wait_for_their_pose() {
    let mut client = TestClient::connected();
    let anchored = TileEntry { anchor: TileAnchor::Keyframe(KeyframeId(4)), ..tile(1, 0, 0.0, 10) };
    client.event(api::Event::Tiles(TilesChanged { reset: true, added: vec![anchored] }));
    client.apply(ClientEvent::ViewpointChanged(eye_at(-3.0)));
    assert!(!client.take_effects().iter().any(|effect| matches!(effect, ClientEffect::FetchTile(_))));
    let node = GraphNode { id: KeyframeId(4), ..GraphNode::default() };
    client.now = client.now.after(1.0);
    client.event(api::Event::Graph(Graph { nodes: vec![node], ..Graph::default() }));
    assert!(client.take_effects().iter().any(|effect| matches!(effect, ClientEffect::FetchTile(_))));
}

#[test]
fn a_saved_map_is_shown_as_soon_as_it_is_written_and_the_live_one_with_the_next_session() {
    let mut client = TestClient::connected();
    let map = MapId(Uuid::from_u128(3));
    client.event(api::Event::Mapping(Mapping::Saving { map }));
    client.event(api::Event::Mapping(Mapping::Idle));
    assert_eq!(client.model.viewed_map(), Some(map));
    assert!(client.take_effects().contains(&ClientEffect::LoadMap(map)));
    client.apply(ClientEvent::TilesListed {
        map,
        result: Ok(TileList { bounds: Aabb::EMPTY, tiles: vec![tile(1, 0, 0.0, 9)], robust_bounds: None }),
    });
    assert_eq!(client.model.displayed_map().tiles.points(), 9);
    assert!(
        client.take_effects().contains(&ClientEffect::MoveCamera(CameraMove::Fit)),
        "one sees all of it first"
    );
    client.event(api::Event::Mapping(Mapping::Starting { session: SessionId(Uuid::from_u128(1)) }));
    assert_eq!(client.model.viewed_map(), None);
}

fn keyframe(id: u32, x: f64) -> GraphNode {
    let map_from_keyframe = Pose { position: Vec3::new(x, 0.0, 0.0), ..Pose::IDENTITY };
    GraphNode { id: KeyframeId(id), map_from_keyframe, ..GraphNode::default() }
}

#[test]
fn lost_changes_of_the_graph_make_the_client_ask_for_the_whole_graph_once() {
    let mut client = TestClient::connected();
    let session = Some(SessionId(Uuid::from_u128(1)));
    let whole = |revision: u64| {
        let nodes = (0..revision as u32).map(|id| keyframe(id, 0.0)).collect();
        api::Event::Graph(Graph { session, revision, nodes, ..Graph::default() })
    };
    let changed = |base_revision: u64| {
        let nodes = vec![keyframe(base_revision as u32, 1.0)];
        api::Event::GraphChanged(GraphChanged {
            session,
            base_revision,
            revision: base_revision + 1,
            nodes,
            ..GraphChanged::default()
        })
    };
    let requests = |client: &mut TestClient| {
        let is_request =
            |effect: &&ClientEffect| matches!(effect, ClientEffect::Send(ClientMessage::RequestGraph));
        client.take_effects().iter().filter(is_request).count()
    };
    client.event(whole(2));
    client.event(changed(2));
    assert_eq!((requests(&mut client), client.model.live_map().graph.revision), (0, 3));

    client.event(changed(4));
    assert_eq!(requests(&mut client), 1, "revision 4 was lost");
    client.event(changed(5));
    client.event(changed(6));
    assert_eq!(requests(&mut client), 0, "it has asked");
    let graph = &client.model.live_map().graph;
    assert_eq!((graph.revision, graph.nodes.len()), (3, 3), "what was known stays");

    client.event(whole(7));
    client.event(changed(7));
    let graph = &client.model.live_map().graph;
    assert_eq!((graph.revision, graph.nodes.len()), (8, 8));
    assert_eq!(
        client
            .model
            .live_map()
            .map_from_anchor(TileAnchor::Keyframe(KeyframeId(7)))
            .map(|pose| pose.position.x),
        Some(1.0)
    );
    client.event(changed(7));
    assert_eq!(requests(&mut client), 1, "after a whole graph it may ask again");
}

#[test]
fn a_graph_in_parts_is_shown_once_it_is_whole() {
    let mut client = TestClient::connected();
    let count = api::MAX_GRAPH_ENTRIES as u32 + 2;
    let nodes = (0..count).map(|id| keyframe(id, 0.0)).collect();
    let graph = Graph { revision: 4, nodes, ..Graph::default() };
    client.event(api::Event::GraphPart(graph.part(0)));
    assert!(client.model.live_map().graph.nodes.is_empty());
    client.event(api::Event::GraphPart(graph.part(1)));
    assert_eq!(client.model.live_map().graph, graph);
}

proptest! {
    /// Whatever comes, fetches under way stay few, counts agree with states, and nothing panics.
    #[test]
    fn tile_counts_hold(steps in proptest::collection::vec((0_u8..6, 0_u8..30), 0..200)) {
        let mut client = TestClient::connected();
        let mut loading = std::collections::BTreeSet::new();
        for (what, number) in steps {
            let hash = TileHash([number; 32]);
            match what {
                0 => client.event(api::Event::Tiles(TilesChanged {
                    reset: number == 0,
                    added: vec![tile(number, number % 4, f32::from(number), 300_000)],
                })),
                1 => client.apply(ClientEvent::ViewpointChanged(eye_at(f64::from(number)))),
                2 if loading.contains(&hash) => client.apply(ClientEvent::TileReady { hash, bytes: 1 }),
                3 if loading.contains(&hash) => client.apply(ClientEvent::TileFailed { hash }),
                4 => client.command(ClientCommand::ViewMap((number < 3).then_some(MapId(Uuid::from_u128(1))))),
                _ => client.wait(0.3),
            }
            if what == 2 || what == 3 {
                loading.remove(&hash);
            }
            for effect in client.take_effects() {
                match effect {
                    ClientEffect::FetchTile(hash) => { prop_assert!(loading.insert(hash), "fetched twice"); }
                    ClientEffect::CancelTile(hash) => { prop_assert!(loading.remove(&hash), "cancelled without a fetch"); }
                    _ => {}
                }
            }
            prop_assert!(loading.len() <= max_requests());
            prop_assert_eq!(client.model.displayed_map().tiles.loading(), loading.len());
            prop_assert!(client.model.displayed_map().tiles.ready_points() <= TilePlanConfig::default().max_points);
        }
    }
}

const SURVEY: MapId = MapId(Uuid::from_u128(5));

fn summary(has_pose_graph: bool) -> MapSummary {
    MapSummary {
        id: SURVEY,
        name: "Survey".into(),
        created: Stamp::from_secs_f64(1.0),
        distance_m: 0.0,
        keyframes: 438,
        points: 2_000_000,
        bytes: 40_000_000,
        has_pose_graph,
    }
}

/// A client that views a map whose server lists these tiles.
fn viewing(summary: MapSummary, list: TileList) -> TestClient {
    let mut client = TestClient::connected();
    client.event(api::Event::Maps(vec![summary]));
    client.command(ClientCommand::ViewMap(Some(SURVEY)));
    client.apply(ClientEvent::TilesListed { map: SURVEY, result: Ok(list) });
    client
}

fn boxed(min: [f32; 3], max: [f32; 3], points: u32, name: u8) -> TileEntry {
    TileEntry { bounds: Aabb { min, max }, points, ..tile(name, 1, 0.0, points) }
}

#[test]
fn the_virtual_viewpoints_of_a_survey_are_no_pose_graph() {
    assert!(TestClient::connected().model.has_pose_graph(), "a live session");
    for walked in [true, false] {
        let client = viewing(summary(walked), TileList::default());
        assert_eq!(client.model.has_pose_graph(), walked);
    }
}

#[test]
fn the_bounds_of_a_survey_are_the_servers_else_those_of_its_tiles_without_strays() {
    let tiles = vec![
        boxed([0.0; 3], [30.0, 20.0, 5.0], 1_000_000, 1),
        boxed([400.0, 300.0, 80.0], [402.0, 302.0, 82.0], 40, 2),
    ];
    let list = TileList { tiles, ..TileList::default() };
    let bounds = viewing(summary(false), list.clone()).model.displayed_map().robust_bounds().unwrap();
    assert!(bounds.max[0] < 31.0 && bounds.max[1] < 21.0 && bounds.max[2] < 6.0, "{bounds:?}");
    let listed = Aabb { min: [1.0; 3], max: [2.0; 3] };
    let list = TileList { robust_bounds: Some(listed), ..list };
    assert_eq!(viewing(summary(false), list).model.displayed_map().robust_bounds(), Some(listed));
}
