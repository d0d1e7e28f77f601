//! Which tiles are shown, and when they change.

use super::*;
use crate::testing::{MAP, SESSION, keyframe, save_map};
use uuid::Uuid;
use vocab::Stamp;

fn live_map() -> (LiveMap, Arc<Store>, tempfile::TempDir) {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = Arc::new(Store::open(dir.path()).expect("store"));
    (LiveMap::new(LiveMapConfig::default(), Arc::clone(&store)), store, dir)
}

fn mapping(session: SessionId, extends: Option<MapId>) -> MappingState {
    let since = Stamp::EPOCH;
    MappingState::Mapping { session, extends, since, distance_m: 0.0, keyframes: 0, on_known_ground: false }
}

fn tiles(event: &Event) -> &TilesChanged {
    match event {
        Event::Tiles(tiles) => tiles,
        other => panic!("tiles were expected: {other:?}"),
    }
}

#[test]
fn a_keyframe_becomes_tiles_in_its_own_frame_that_a_new_session_forgets() {
    let (mut live_map, store, _dir) = live_map();
    assert_eq!(live_map.set_mapping(&mapping(SESSION, None)), None, "no session was before");
    assert_eq!(live_map.session(), Some(SESSION));
    let event = live_map.insert_keyframe(&keyframe(SESSION, 3)).expect("written");
    let added = &tiles(&event).added;
    assert_eq!(added.iter().map(|tile| tile.points).sum::<u32>(), 400);
    for tile in added {
        assert_eq!(tile.anchor, TileAnchor::Keyframe(KeyframeId(3)));
        assert!((tile.bounds.min[0] - 1.0).abs() < 0.02, "the wall is 1 m before the keyframe: {tile:?}");
        assert!(store.dir().tile(tile.hash).exists());
    }
    assert_eq!(live_map.set_mapping(&MappingState::Saving { session: SESSION, map: MAP }), None);
    let (ended, hashes) = live_map.set_mapping(&MappingState::Idle).expect("the session has ended");
    assert_eq!((ended, hashes), (SESSION, added.iter().map(|tile| tile.hash).collect()));
    assert_eq!(live_map.session(), None);
}

#[test]
fn the_extended_map_is_shown_once_when_the_robot_is_localised_in_it() {
    let (mut live_map, store, _dir) = live_map();
    save_map(&store);
    let finding = MappingState::Finding { session: SESSION, map: MAP, distance_m: 0.0, ambiguous: false };
    live_map.set_mapping(&finding);
    assert_eq!(live_map.show_extended(&finding).expect("readable"), []);
    let extending = mapping(SESSION, Some(MAP));
    let shown = live_map.show_extended(&extending).expect("readable");
    let [first, Event::Loops(LoopsChanged { reset: false, .. })] = shown.as_slice() else {
        panic!("tiles and loops were expected: {shown:?}");
    };
    assert!(!tiles(first).reset && !tiles(first).added.is_empty());
    assert_eq!(live_map.show_extended(&extending).expect("readable"), [], "it was sent before");
}

#[test]
fn a_saved_map_is_shown_while_the_robot_is_in_it_and_no_session_runs() {
    let (mut live_map, store, _dir) = live_map();
    save_map(&store);
    assert_eq!(live_map.show_saved(&LocalisationState::Loading { map: MAP }).expect("readable"), []);
    let relocalising = LocalisationState::Relocalising { map: MAP, hypotheses: 0 };
    let shown = live_map.show_saved(&relocalising).expect("readable");
    let [Event::Graph(graph), second] = shown.as_slice() else {
        panic!("graph and tiles were expected: {shown:?}");
    };
    assert_eq!(graph.nodes.len(), 3);
    assert!(tiles(second).reset && !tiles(second).added.is_empty());
    let localised = LocalisationState::Localised { map: MAP, degradation: None };
    assert_eq!(live_map.show_saved(&localised).expect("readable"), [], "it is shown already");
    let cleared = live_map.show_saved(&LocalisationState::Idle).expect("readable");
    let empty = TilesChanged { reset: true, added: Vec::new() };
    assert_eq!(cleared, [Event::Graph(Graph::default()), Event::Tiles(empty)]);

    live_map.set_mapping(&mapping(SESSION, None));
    assert_eq!(live_map.show_saved(&localised).expect("readable"), [], "the session is shown");
    let missing = LocalisationState::Localised { map: MapId(Uuid::from_u128(9)), degradation: None };
    live_map.set_mapping(&MappingState::Idle);
    assert!(live_map.show_saved(&missing).is_err());
}
