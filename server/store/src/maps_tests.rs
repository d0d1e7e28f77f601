use super::*;
use crate::keyframe_descriptors;
use api::Graph;
use messages::{
    Cloud, DegenerateSegment, EdgeKind, GraphEdge, GraphNode, Keyframe, LoopDecision, LoopEvidence,
    PoseCorrection, PoseGraph, RevisitCounts,
};
use std::sync::Arc;
use std::time::Duration;
use uuid::Uuid;
use vocab::{KeyframeId, MapId, Pose, SessionId, Stamp, Vec3};

pub(crate) const SESSION: SessionId = SessionId(Uuid::from_u128(7));

fn pose(x: f64) -> Pose {
    Pose { position: Vec3::new(x, 0.0, 0.0), ..Pose::IDENTITY }
}

fn keyframe(id: KeyframeId, (stamp, map_from_keyframe): (Stamp, Pose), cloud: Cloud) -> Keyframe {
    let (cloud, lidar) = (Arc::new(cloud), [0.0; 3]);
    Keyframe { session: SESSION, id, stamp, map_from_keyframe, cloud, lidar }
}

/// Ten keyframes a metre apart, each seeing a wall of its own.
pub(crate) fn session(store: &Store, map: u128, created: i64) -> FinishedMap {
    let nodes: Vec<GraphNode> = (0..10)
        .map(|id| GraphNode {
            id: KeyframeId(id),
            stamp: Stamp::from_parts(i64::from(id), 0),
            map_from_keyframe: pose(f64::from(id)),
        })
        .collect();
    for node in &nodes {
        let xyz: Vec<[f32; 3]> =
            (0..400_u16).map(|i| [0.0, f32::from(i % 20) * 0.1, f32::from(i / 20) * 0.1 + 0.05]).collect();
        let intensity = vec![10.0; xyz.len()];
        let at = (node.stamp, node.map_from_keyframe);
        store.write_session_cloud(&keyframe(node.id, at, Cloud { xyz, intensity })).expect("kept");
    }
    FinishedMap {
        map: MapId(Uuid::from_u128(map)),
        name: "Hall".to_owned(),
        session: SESSION,
        extends: None,
        at: Stamp::from_parts(created, 0),
        distance_m: 9.0,
        trajectory: nodes.iter().map(|node| (node.stamp, node.map_from_keyframe)).collect(),
        graph: Arc::new(PoseGraph { revision: 1, nodes, edges: Vec::new() }),
        degenerate: vec![DegenerateSegment { from: Stamp::EPOCH, until: Stamp::EPOCH, distance_m: 1.0 }],
        decisions: Vec::new(),
        unverified: 0,
        revisits: RevisitCounts::default(),
    }
}

#[test]
fn a_saved_map_is_listed_and_its_tiles_hold_every_wall() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = Store::open(dir.path()).expect("opens");
    store.save_map(&session(&store, 1, 100)).expect("saved");
    store.save_map(&session(&store, 2, 200)).expect("saved");
    let maps = store.maps().expect("listed");
    assert_eq!(maps.iter().map(|map| map.id.0.as_u128()).collect::<Vec<_>>(), [2, 1], "newest first");
    assert_eq!(maps[0].points, 4000);
    assert_eq!(maps[0].keyframes, 10);

    let list: TileList = files::read_json(&store.dir().map_tiles(maps[0].id)).expect("tiles");
    let mut walls = std::collections::BTreeSet::new();
    for tile in &list.tiles {
        let bytes = fs::read(store.dir().tile(tile.hash)).expect("tile");
        assert_eq!(bytes.len(), tile.bytes as usize);
        let chunk = map_codec::decode(&bytes).expect("decodes");
        walls.extend(chunk.points.iter().map(|point| chunk.position(point)[0].round() as i32));
    }
    assert_eq!(walls.into_iter().collect::<Vec<_>>(), (0..10).collect::<Vec<_>>());
    for name in ["trajectory.tum", "graph.g2o", "graph.json", "clouds/000009.pcd"] {
        assert!(store.dir().map(maps[0].id).join(name).exists(), "{name}");
    }
    assert!(!store.dir().map(maps[0].id).join("clouds/000009.scan").exists(), "it was for clients only");
}

#[test]
fn what_keyframes_leave_behind_is_read_back_and_made_anew_where_its_file_is_broken() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = Store::open(dir.path()).expect("opens");
    let map = store.save_map(&session(&store, 1, 100)).expect("saved").summary.id;
    let folder = store.dir().map(map);
    let clouds = folder.join("clouds");
    let hidden = folder.join("elsewhere");
    fs::rename(&clouds, &hidden).expect("renamed");
    let kept = keyframe_descriptors(&folder, 10).expect("read without the clouds");
    assert_eq!(kept.len(), 10);
    assert!(kept.iter().all(|place| place.points.len() > 100));
    fs::rename(&hidden, &clouds).expect("renamed");
    for broken in [&b"AIPLACES"[..], b"", b"something else"] {
        fs::write(folder.join("places.bin"), broken).expect("written");
        assert_eq!(keyframe_descriptors(&folder, 10).expect("made anew"), kept);
    }
    fs::remove_file(folder.join("places.bin")).expect("removed");
    assert_eq!(keyframe_descriptors(&folder, 10).expect("made anew"), kept);
}

#[test]
fn clients_find_the_whole_scan_of_a_keyframe_while_its_session_lasts() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = Store::open(dir.path()).expect("opens");
    let xyz: Vec<[f32; 3]> = (0..500_u16).map(|i| [0.01 * f32::from(i), 2.0, -1.0]).collect();
    let cloud = Cloud { xyz: xyz.clone(), intensity: vec![7.0; 500] };
    let at = (Stamp::EPOCH, Pose::IDENTITY);
    store.write_session_cloud(&keyframe(KeyframeId(12), at, cloud.clone())).expect("kept");
    let path = store.session(SESSION).join("000012.scan");
    let chunk = map_codec::decode(&fs::read(&path).expect("written")).expect("decodes");
    let mut found: Vec<[f32; 3]> = chunk.points.iter().map(|point| chunk.position(point)).collect();
    found.sort_by(|a, b| a[0].total_cmp(&b[0]));
    assert_eq!(found.len(), xyz.len());
    for (found, expected) in found.iter().zip(&xyz) {
        assert!(
            (0..3).all(|axis| (found[axis] - expected[axis]).abs() < 0.011),
            "{found:?} for {expected:?}"
        );
    }
    assert!(!files::temporary_path(&path).exists());
    store.discard_session(SESSION).expect("discarded");
    assert!(!path.exists());
}

#[test]
fn a_map_holds_its_loops_and_its_points_where_the_keyframes_came_to_lie() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = Store::open(dir.path()).expect("opens");
    let mut finished = session(&store, 1, 100);
    let graph = Arc::make_mut(&mut finished.graph);
    let edge = |from, to, kind| GraphEdge {
        from: KeyframeId(from),
        to: KeyframeId(to),
        kind,
        from_from_to: pose(1.0),
        information: [[0.0; 6]; 6],
    };
    graph.edges = vec![edge(0, 1, EdgeKind::Odometry), edge(0, 9, EdgeKind::Loop)];
    // The last keyframe was moved by the loop after its cloud had been kept.
    graph.nodes[9].map_from_keyframe = pose(40.0);
    store.save_map(&finished).expect("saved");
    let folder = store.dir().map(finished.map);
    let api_graph: Graph = files::read_json(&folder.join("graph.json")).expect("graph");
    assert_eq!(api_graph.edges, [(KeyframeId(0), KeyframeId(1))]);
    assert_eq!(api_graph.loops, [(KeyframeId(0), KeyframeId(9))]);
    let g2o = fs::read_to_string(folder.join("graph.g2o")).expect("graph");
    assert_eq!(g2o.lines().filter(|line| line.starts_with("EDGE_SE3:QUAT")).count(), 2, "{g2o}");
    let list: TileList = files::read_json(&store.dir().map_tiles(finished.map)).expect("tiles");
    assert!((list.bounds.max[0] - 40.0).abs() < 0.1, "{:?}", list.bounds);
    assert_eq!(fs::read_to_string(folder.join("loops.json")).expect("loops").trim(), "[]");
}

#[test]
fn an_extended_map_holds_the_clouds_trajectories_and_distances_of_both() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = Store::open(dir.path()).expect("opens");
    let first = session(&store, 1, 100);
    store.save_map(&first).expect("saved");
    store.copy_map_clouds_to_session(first.map, SESSION).expect("read back");
    assert!(store.session(SESSION).join("000009.scan").exists(), "clients may ask for it");
    let mut nodes = first.graph.nodes.clone();
    // A loop closure with the new part moved the old one by a metre.
    for node in &mut nodes {
        node.map_from_keyframe.position.y = 1.0;
    }
    let stamp = Stamp::from_parts(50, 0);
    let map_from_keyframe = Pose { position: Vec3::new(10.0, 1.0, 0.0), ..Pose::IDENTITY };
    let cloud = Cloud { xyz: vec![[0.0, 0.0, 1.0]; 30], intensity: vec![1.0; 30] };
    store.write_session_cloud(&keyframe(KeyframeId(10), (stamp, map_from_keyframe), cloud)).expect("kept");
    nodes.push(GraphNode { id: KeyframeId(10), stamp, map_from_keyframe });
    // A cloud that is missing in the session is copied when the map is saved.
    fs::remove_file(store.session(SESSION).join("000003.pcd")).expect("removed");
    let larger = FinishedMap {
        map: MapId(Uuid::from_u128(2)),
        extends: Some(first.map),
        distance_m: 2.5,
        trajectory: vec![(stamp, map_from_keyframe)],
        graph: Arc::new(PoseGraph { revision: 2, nodes, edges: Vec::new() }),
        ..first.clone()
    };
    store.save_map(&larger).expect("saved");
    let saved = store.map(larger.map).expect("read back");
    assert_eq!((saved.poses.len(), saved.trajectory.len(), saved.summary.distance_m), (11, 11, 11.5));
    assert!(saved.trajectory.iter().all(|(_, pose)| (pose.position.y - 1.0).abs() < 1e-6));
    assert_eq!(saved.graph().nodes, larger.graph.nodes);
    assert!(store.dir().map(larger.map).join("clouds/000003.pcd").exists());
    assert_eq!(store.maps().expect("listed").len(), 2, "the first one is kept");
    // A session that extends a map that does not exist is not saved, and nothing is lost.
    store.copy_map_clouds_to_session(first.map, SESSION).expect("read back");
    let (map, gone) = (MapId(Uuid::from_u128(3)), MapId(Uuid::from_u128(9)));
    assert!(store.save_map(&FinishedMap { map, extends: Some(gone), ..larger.clone() }).is_err());
    assert!(store.session(SESSION).join("000003.pcd").exists());
}

#[test]
fn an_imported_map_can_be_extended_with_its_viewpoints_in_one_file() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = Store::open(dir.path()).expect("opens");
    let graph = |nodes| Arc::new(PoseGraph { revision: 1, nodes, edges: Vec::new() });
    let node = |id: u32| GraphNode {
        id: KeyframeId(id),
        stamp: Stamp::EPOCH,
        map_from_keyframe: pose(f64::from(id)),
    };
    let imported = FinishedMap {
        session: SessionId(Uuid::nil()),
        graph: graph(vec![node(0), node(1)]),
        trajectory: Vec::new(),
        distance_m: 0.0,
        degenerate: Vec::new(),
        ..session(&store, 1, 100)
    };
    store.discard_session(SESSION).expect("discarded");
    let cloud = MapPoints {
        xyz: (0..50_u16).map(|i| [5.0, f32::from(i) * 0.1, 1.0]).collect(),
        intensity: vec![2.0; 50],
    };
    let all: Vec<u32> = (0..50).collect();
    let viewpoint = |x: f64| crate::CloudViewpoint {
        cloud_from_base: Isometry::translation(x, 0.0, 0.0),
        lidar: [0.0; 3],
        visible: all.clone(),
    };
    let options = MapFileOptions { ply: false, has_pose_graph: false };
    let added = store.add_map(&imported, options, cloud.clone(), |folder| {
        let viewpoints = [viewpoint(0.0), viewpoint(1.0)];
        crate::write_viewpoint_clouds(&folder.join("clouds"), KeyframeId(0), &cloud, viewpoints.into_iter())
    });
    assert!(!added.expect("added").summary.has_pose_graph);

    store.copy_map_clouds_to_session(imported.map, SESSION).expect("copied");
    assert!(store.session(SESSION).join("000001.scan").exists(), "clients may ask for it");
    let walked = Cloud { xyz: vec![[0.0, 0.0, 1.0]; 30], intensity: vec![1.0; 30] };
    store.write_session_cloud(&keyframe(KeyframeId(2), (Stamp::EPOCH, pose(2.0)), walked)).expect("written");
    let extended = FinishedMap {
        map: MapId(Uuid::from_u128(2)),
        session: SESSION,
        extends: Some(imported.map),
        graph: graph(vec![node(0), node(1), node(2)]),
        ..imported
    };
    assert!(store.save_map(&extended).expect("saved").summary.has_pose_graph);
    let folder = store.dir().map(extended.map);
    let clouds = crate::map_clouds(&folder, crate::CloudSelection::ALL).expect("opened");
    let sizes: Vec<usize> = clouds.map(|cloud| cloud.expect("read").xyz.len()).collect();
    assert_eq!(sizes, [50, 50, 30]);
    assert!(folder.join("clouds/viewpoints_000000.bin").exists());
}

#[test]
fn an_id_is_used_once_and_an_empty_session_not_at_all() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = Store::open(dir.path()).expect("opens");
    let first = session(&store, 1, 100);
    store.save_map(&first).expect("saved");
    assert!(matches!(store.save_map(&session(&store, 1, 100)), Err(StoreError::MapExists { .. })));
    store.discard_session(SESSION).expect("discarded");
    let again = FinishedMap { map: MapId(Uuid::from_u128(3)), ..first };
    assert!(matches!(store.save_map(&again), Err(StoreError::EmptySession { .. })));
}

#[test]
fn a_failed_save_leaves_no_map_and_can_be_tried_again() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = Store::open(dir.path()).expect("opens");
    let finished = session(&store, 1, 100);
    let broken = store.session(SESSION).join("000003.pcd");
    let cloud = fs::read(&broken).expect("cloud");
    fs::write(&broken, b"not a cloud").expect("writable");
    assert!(matches!(store.save_map(&finished), Err(StoreError::Cloud { .. })));
    assert_eq!(store.maps().expect("listed"), []);
    fs::write(&broken, cloud).expect("writable");
    store.save_map(&finished).expect("saved at the second attempt");
}

#[test]
fn opening_removes_what_a_crash_left_and_keeps_what_maps_need() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = Store::open(dir.path()).expect("opens");
    let finished = session(&store, 1, 100);
    store.save_map(&finished).expect("saved");
    session(&store, 2, 200);
    let stray = store.tiles().put(b"of a session").expect("put");
    let half = store.dir().maps().join(format!(".{}", Uuid::from_u128(9)));
    fs::create_dir(&half).expect("made");
    fs::write(half.join("tiles.json"), "{").expect("written");
    let data = store.dir().clone();

    assert!(matches!(Store::open(dir.path()), Err(StoreError::InUse { .. })));
    drop(store);
    let store = Store::open(dir.path()).expect("opens again");
    assert!(!half.exists() && !store.session(SESSION).exists());
    assert!(data.tile(stray).exists(), "it is younger than a day");
    make_a_day_older(&data.tiles());
    drop(store);
    Store::open(dir.path()).expect("opens again");
    assert!(!data.tile(stray).exists());
    let list: TileList = files::read_json(&data.map_tiles(finished.map)).expect("tiles");
    assert!(!list.tiles.is_empty() && list.tiles.iter().all(|tile| data.tile(tile.hash).exists()));
}

/// Makes every file below a directory look as if it had been written a day and a minute ago.
pub(crate) fn make_a_day_older(directory: &Path) {
    let then = std::time::SystemTime::now() - crate::tiles::CONFIG.unused_grace - Duration::from_secs(60);
    for path in files::entries(directory).expect("listed") {
        if path.is_dir() {
            make_a_day_older(&path);
        } else {
            fs::File::options().write(true).open(&path).expect("opens").set_modified(then).expect("set");
        }
    }
}

/// Every file below a directory with its bytes.
pub(crate) fn content(directory: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut content = Vec::new();
    for path in files::entries(directory).expect("listed") {
        if path.is_dir() {
            content.extend(self::content(&path));
        } else {
            content.push((path.clone(), fs::read(&path).expect("read")));
        }
    }
    content
}

#[test]
fn a_map_with_a_damaged_file_is_named_and_nothing_is_removed() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = Store::open(dir.path()).expect("opens");
    let (damaged, whole) = (session(&store, 1, 100), session(&store, 2, 200));
    store.save_map(&session(&store, 1, 100)).expect("saved");
    store.save_map(&session(&store, 2, 200)).expect("saved");
    // As the program does once the map is on the disk.
    store.discard_session(SESSION).expect("discarded");
    let data = store.dir().clone();
    drop(store);
    for name in ["map.json", "tiles.json"] {
        let path = data.map(damaged.map).join(name);
        let original = fs::read(&path).expect("read");
        let mut flipped = original.clone();
        flipped[0] ^= 1;
        for broken in [&original[..original.len() / 2], &vec![0; original.len()], b"", &flipped] {
            fs::write(&path, broken).expect("written");
            make_a_day_older(&data.tiles());
            let before = content(dir.path());
            let store = Store::open(dir.path()).expect("a damaged map does not keep the robot from starting");
            let named = store.damaged_maps().expect("listed");
            assert_eq!(named.len(), 1);
            assert!(named[0].error.to_string().contains(name), "{}", named[0].error);
            assert_eq!(store.maps().expect("listed").len(), 1, "the other one is listed");
            assert!(
                store
                    .remove_session_tiles(&[store.map_tiles(whole.map).expect("read").tiles[0].hash])
                    .is_err()
            );
            drop(store);
            assert_eq!(content(dir.path()), before);
        }
        fs::write(&path, original).expect("written");
    }
    let store = Store::open(dir.path()).expect("opens");
    assert_eq!((store.maps().expect("listed").len(), store.damaged_maps().expect("listed").len()), (2, 0));
}

/// A loop decision and the entry of the list of maps, as programs before format version 2 wrote them.
#[test]
fn names_without_units_are_read_as_maps_of_version_1_have_them() {
    let decisions = r#"[{"task": {"session": "00000000-0000-0000-0000-000000000009", "from": 2, "to": 7, "source": "Person",
        "guess": {"position": {"x": 1, "y": 2, "z": 3}, "orientation": {"w": 1, "x": 0, "y": 0, "z": 0}}},
        "from_from_to": {"position": {"x": 1, "y": 2, "z": 3}, "orientation": {"w": 1, "x": 0, "y": 0, "z": 0}},
        "evidence": {"score": 0.9, "overlap": [0.8, 0.7], "residual": 0.02, "through": [0.01, 0.03], "rival": 0.4, "blind": 1,
        "grip": 0.2, "moved": [0.5, 0.1], "surprise": null},
        "verdict": "Accepted", "by_hand": true, "reason": "It fits."}]"#;
    let decisions: Vec<LoopDecision> = serde_json::from_str(decisions).expect("decisions of version 1");
    let evidence = LoopEvidence {
        score: 0.9,
        overlap: [0.8, 0.7],
        residual_m: 0.02,
        free_space_violation: [0.01, 0.03],
        runner_up_ratio: 0.4,
        degenerate_directions: 1,
        conditioning: 0.2,
        correction: PoseCorrection { distance_m: 0.5, rotation_rad: 0.1 },
        mahalanobis_squared: None,
    };
    assert_eq!(decisions[0].evidence, evidence);
    let written = serde_json::to_string(&decisions).expect("written");
    assert!(written.contains(r#""correction":{"distance_m":0.5,"rotation_rad":0.1}"#), "{written}");
    assert_eq!(serde_json::from_str::<Vec<LoopDecision>>(&written).expect("read again"), decisions);

    let entry = r#"{"id": "00000000-0000-0000-0000-000000000001", "name": "Hall", "created": 5, "distance": 9.5, "keyframes": 1,
        "points": 2, "bytes": 3}"#;
    let entry: MapSummary = serde_json::from_str(entry).expect("entry of version 1");
    assert_eq!((entry.distance_m, entry.has_pose_graph), (9.5, true));
}

#[test]
fn a_map_of_a_later_program_is_left_alone() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = Store::open(dir.path()).expect("opens");
    let finished = session(&store, 1, 100);
    store.save_map(&finished).expect("saved");
    let path = store.dir().map_summary(finished.map);
    let text = fs::read_to_string(&path).expect("read");
    let (_, unchecked) = text.split_once("\",\n").expect("after the checksum");
    let later = format!("{{{}", unchecked.replace("\"format_version\": 3", "\"format_version\": 4"));
    fs::write(&path, later).expect("written");
    assert_eq!(store.maps().expect("listed"), []);
    let damaged = store.damaged_maps().expect("listed");
    assert!(matches!(damaged[0].error, StoreError::LaterVersion { version: 4, newest: 3, .. }));
    // Also if it lacks what this program reads.
    fs::write(&path, r#"{"format_version": 4, "title": "Hall"}"#).expect("written");
    let damaged = store.damaged_maps().expect("listed");
    assert!(matches!(damaged[0].error, StoreError::LaterVersion { version: 4, newest: 3, .. }));
    assert!(matches!(store.rename_map(finished.map, "Cellar"), Err(StoreError::LaterVersion { .. })));
    let first = format!("{{{}", unchecked.replace("\"format_version\": 3,", ""));
    fs::write(&path, first).expect("written");
    assert_eq!(store.maps().expect("listed").len(), 1, "without a version it is of the first");
}

#[test]
fn a_tile_that_lacks_bytes_is_written_again() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = Store::open(dir.path()).expect("opens");
    let hash = store.tiles().put(b"of a session").expect("put");
    fs::write(store.dir().tile(hash), b"").expect("cut");
    assert_eq!(store.tiles().put(b"of a session").expect("put"), hash);
    assert_eq!(fs::read(store.dir().tile(hash)).expect("read"), b"of a session");
}

#[test]
fn tiles_of_an_ended_session_go_unless_a_map_shares_them() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = Store::open(dir.path()).expect("opens");
    let finished = session(&store, 1, 100);
    store.save_map(&finished).expect("saved");
    let list: TileList = files::read_json(&store.dir().map_tiles(finished.map)).expect("tiles");
    let (own, shared) = (store.tiles().put(b"of a session").expect("put"), list.tiles[0].hash);
    store.remove_session_tiles(&[own, shared]).expect("forgotten");
    assert!(!store.dir().tile(own).exists() && store.dir().tile(shared).exists());
}

#[test]
fn a_map_that_another_process_wrote_is_taken_in_once_with_its_tiles() {
    let (dir, other) = (
        tempfile::tempdir().expect("temporary directory"),
        tempfile::tempdir().expect("temporary directory"),
    );
    let (store, elsewhere) =
        (Store::open(dir.path()).expect("opens"), Store::open(other.path()).expect("opens"));
    let finished = session(&elsewhere, 3, 100);
    elsewhere.save_map(&finished).expect("saved");
    let made = store.dir().upload_map(vocab::UploadId(Uuid::from_u128(1)));
    let make = || {
        fs::rename(elsewhere.dir().map(finished.map), &made).expect("moved");
        fs::rename(elsewhere.dir().tiles(), made.join("tiles")).expect("moved");
    };
    make();
    let listed = store.adopt_map(&made).expect("taken in");
    assert_eq!((listed.id, listed.points), (finished.map, 4000));
    assert_eq!(store.maps().expect("listed"), [listed]);
    let tiles = store.map_tiles(finished.map).expect("readable").tiles;
    assert!(!tiles.is_empty() && tiles.iter().all(|tile| store.dir().tile(tile.hash).exists()));
    assert!(!made.exists());
    fs::create_dir_all(&made).expect("made");
    assert!(store.adopt_map(&made).is_err(), "it is none");
    fs::copy(store.dir().map_summary(finished.map), made.join("map.json")).expect("copied");
    assert!(matches!(store.adopt_map(&made), Err(StoreError::MapExists { .. })));
}

#[test]
fn the_room_that_another_map_takes_is_counted_with_all_its_folders() {
    let dir = tempfile::tempdir().expect("temporary directory");
    fs::create_dir_all(dir.path().join("a/b")).expect("made");
    for (name, bytes) in [("one", 10), ("a/two", 20), ("a/b/three", 30)] {
        fs::write(dir.path().join(name), vec![0; bytes]).expect("written");
    }
    assert_eq!(files::bytes_below(dir.path()).expect("read"), 60);
    assert!(files::free_bytes(dir.path()).expect("the disk says") > 0);
    let store = Store::open(dir.path().join("store")).expect("opens");
    assert!(store.has_space_for_copy(MapId(Uuid::from_u128(1))).is_err(), "there is no such map");
}
