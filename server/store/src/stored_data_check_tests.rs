//! The check of stored data names every damaged file, and no other.

use super::*;
use crate::SessionRecord;
use messages::{Cloud, FinishedMap, GraphNode, Keyframe, PoseGraph, RevisitCounts};
use std::fs;
use std::sync::Arc;
use uuid::Uuid;
use vocab::{KeyframeId, MapId, Pose, Stamp};

const MAP: MapId = MapId(Uuid::from_u128(1));
const SESSION: SessionId = SessionId(Uuid::from_u128(2));

/// Five clouds of a session, and its graph.
fn write_session(store: &Store) -> PoseGraph {
    let nodes: Vec<GraphNode> = (0..5)
        .map(|id| {
            let (id, stamp, map_from_keyframe) = (KeyframeId(id), Stamp::EPOCH, Pose::IDENTITY);
            let xyz: Vec<[f32; 3]> = (0..100_u16).map(|i| [1.0, f32::from(i) * 0.1, id.0 as f32]).collect();
            let cloud = Arc::new(Cloud { intensity: vec![1.0; xyz.len()], xyz });
            let lidar = [0.0; 3];
            let keyframe = Keyframe { session: SESSION, id, stamp, map_from_keyframe, cloud, lidar };
            store.write_session_cloud(&keyframe).expect("written");
            GraphNode { id, stamp, map_from_keyframe }
        })
        .collect();
    PoseGraph { revision: 1, nodes, edges: Vec::new() }
}

/// A store with a map and an interrupted session.
fn store_with_data(dir: &Path) -> Store {
    let store = Store::open(dir).expect("opens");
    let finished = FinishedMap {
        map: MAP,
        name: "Hall".to_owned(),
        session: SESSION,
        extends: None,
        at: Stamp::EPOCH,
        distance_m: 1.0,
        trajectory: vec![(Stamp::EPOCH, Pose::IDENTITY)],
        graph: Arc::new(write_session(&store)),
        degenerate: Vec::new(),
        decisions: Vec::new(),
        unverified: 0,
        revisits: RevisitCounts::default(),
    };
    store.save_map(&finished).expect("saved");
    store.discard_session(SESSION).expect("discarded");
    let graph = Arc::new(write_session(&store));
    let mut journal = store.session_journal(SESSION).expect("begun");
    journal.append(&SessionRecord::Graph(graph)).expect("written");
    store
}

struct Found(Vec<String>);

impl StoredDataReport for Found {
    fn on_damage(&mut self, error: StoreError) {
        self.0.push(error.to_string());
    }

    fn on_read(&mut self, _: u64) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

fn damage(store: &Store) -> Vec<String> {
    let mut found = Found(Vec::new());
    store.check_stored_data(&[SESSION], &mut found).expect("checked");
    found.0
}

#[test]
fn one_wrong_bit_in_any_file_is_found_and_named() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = store_with_data(dir.path());
    assert_eq!(damage(&store), Vec::<String>::new());
    let map = store.dir().map(MAP);
    let names = files_with_checksum(&map).expect("listed");
    assert_eq!(
        names.len(),
        5 + ["graph.g2o", "graph.json", "loops.json", "places.bin", "tiles.json", "trajectory.tum"].len()
    );
    let tiles = store.map_tiles(MAP).expect("read").tiles;
    let tile = store.dir().tile(tiles[0].hash);
    let cloud = store.session(SESSION).join("000003.pcd");
    let files = names.iter().map(|name| map.join(name)).chain([tile, cloud, map.join("checksums.b3")]);
    for path in files.filter(|path| path.file_name().is_none_or(|name| name != "tiles.json")) {
        let whole = fs::read(&path).expect("read");
        let mut bytes = whole.clone();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        fs::write(&path, &bytes).expect("written");
        let found = damage(&store);
        let name = path.display().to_string();
        // A damaged checksum looks like a damaged file, which the sentence says of both.
        let is_checksums = path.ends_with("checksums.b3");
        assert!(
            !found.is_empty() && (is_checksums || found.iter().all(|text| text.contains(&name))),
            "{name}: {found:?}"
        );
        fs::remove_file(&path).expect("removed");
        assert!(!damage(&store).is_empty(), "{name} was removed");
        fs::write(&path, &whole).expect("restored");
    }
    assert_eq!(damage(&store), Vec::<String>::new());
}

#[test]
fn maps_without_checksums_are_read_and_a_removed_map_is_not_damaged() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = store_with_data(dir.path());
    let map = store.dir().map(MAP);
    fs::remove_file(map.join("checksums.b3")).expect("removed");
    let [problem] = &damage(&store)[..] else { panic!("one problem") };
    assert!(problem.contains("checksums.b3 is missing"), "{problem}");
    let summary = serde_json::to_vec(&store.maps().expect("listed")[0]).expect("JSON");
    fs::write(map.join("map.json"), summary).expect("as the first program wrote it");
    assert_eq!(damage(&store), Vec::<String>::new());
    fs::write(map.join("graph.g2o"), "nonsense").expect("written");
    assert!(damage(&store)[0].contains("graph.g2o"));
    fs::remove_dir_all(&map).expect("removed");
    assert_eq!(damage(&store), Vec::<String>::new());
}

#[test]
fn one_wrong_bit_in_the_checksums_of_a_session_is_found() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = store_with_data(dir.path());
    let folder = store.session(SESSION);
    let path = folder.join("checksums.b3");
    let whole = fs::read(&path).expect("read");
    // Every seventh bit, so that each of a byte's eight comes.
    for bit in (0..whole.len() * 8).step_by(7) {
        let mut bytes = whole.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        fs::write(&path, &bytes).expect("written");
        let mut found = Found(Vec::new());
        assert!(check_session(&folder, &mut found).is_continue());
        let is_named = found.0.iter().any(|text| text.contains("checksums.b3"));
        assert!(is_named, "bit {bit}: {:?} in {}", found.0, String::from_utf8_lossy(&bytes));
    }
}
