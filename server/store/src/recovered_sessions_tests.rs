//! Sessions that their process did not end.

use super::*;
use crate::{SessionRecord, keyframe_descriptors};
use messages::{Cloud, GraphNode, Keyframe, PoseGraph};
use std::fs;
use uuid::Uuid;
use vocab::{KeyframeId, Pose, Stamp, Vec3};

const SESSION: SessionId = SessionId(Uuid::from_u128(1));
const KEYFRAMES: u32 = 5;

fn map(number: u128) -> MapId {
    MapId(Uuid::from_u128(number))
}

/// Writes a session of five keyframes a metre apart, and leaves it as a crash does.
fn interrupted(dir: &Path) -> Store {
    let store = Store::open(dir).expect("opens");
    let mut journal = store.session_journal(SESSION).expect("begun");
    journal.append(&SessionRecord::State { extends: None, distance_m: 4.0 }).expect("written");
    let mut graph = PoseGraph { revision: 1, ..PoseGraph::default() };
    for id in 0..KEYFRAMES {
        let stamp = Stamp::from_parts(i64::from(id), 0);
        let map_from_keyframe = Pose { position: Vec3::new(f64::from(id), 0.0, 0.0), ..Pose::IDENTITY };
        let xyz: Vec<[f32; 3]> =
            (0..400_u16).map(|i| [1.0, f32::from(i % 20) * 0.1, f32::from(i / 20) * 0.1 + 0.05]).collect();
        let cloud = Arc::new(Cloud { intensity: vec![10.0; xyz.len()], xyz });
        let (id, lidar) = (KeyframeId(id), [0.0; 3]);
        let keyframe = Keyframe { session: SESSION, id, stamp, map_from_keyframe, cloud, lidar };
        store.write_session_cloud(&keyframe).expect("written");
        graph.nodes.push(GraphNode { id, stamp, map_from_keyframe });
        graph.revision += 1;
        journal.append(&SessionRecord::Graph(Arc::new(graph.clone()))).expect("written");
        journal
            .append(&SessionRecord::ScanPose { stamp, map_from_base: map_from_keyframe })
            .expect("written");
    }
    drop(store);
    Store::open(dir).expect("opens after the crash")
}

#[test]
fn an_interrupted_session_waits_and_becomes_a_map() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = interrupted(dir.path());
    let InterruptedSessions { sessions, problems } = store.interrupted_sessions().expect("listed");
    assert_eq!(problems, Vec::<String>::new());
    let [session] = &sessions[..] else { panic!("{sessions:?}") };
    assert_eq!((session.session, session.keyframes, session.distance_m), (SESSION, KEYFRAMES, 4.0));
    assert_eq!((session.at, session.extends), (Stamp::from_parts(4, 0), None));

    let (report, problems) = store.save_interrupted_session(SESSION, map(2), "Hall").expect("saved");
    assert_eq!((report.summary.keyframes, problems), (KEYFRAMES, Vec::<String>::new()));
    assert!(report.summary.points > 1_000 && report.summary.distance_m == 4.0, "{:?}", report.summary);
    let saved = store.map(map(2)).expect("read");
    assert_eq!((saved.poses.len(), saved.trajectory.len()), (KEYFRAMES as usize, KEYFRAMES as usize));
    // The map is on the disk, so a crash before the session was removed offers it no more.
    drop(store);
    let store = Store::open(dir.path()).expect("opens");
    assert_eq!(store.interrupted_sessions().expect("listed"), InterruptedSessions::default());
}

/// A process may be killed after the graph was recorded and before the cloud was written.
#[test]
fn a_last_keyframe_without_cloud_is_left_out() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = interrupted(dir.path());
    fs::remove_file(store.session(SESSION).join("000004.pcd")).expect("removed");
    let listed = store.interrupted_sessions().expect("listed").sessions;
    assert_eq!(listed[0].keyframes, KEYFRAMES - 1);
    let (report, problems) = store.save_interrupted_session(SESSION, map(2), "Hall").expect("saved");
    assert_eq!((report.summary.keyframes, problems), (KEYFRAMES - 1, Vec::<String>::new()));
    let descriptors = keyframe_descriptors(&store.dir().map(map(2)), 4).expect("written");
    assert_eq!(descriptors.len(), 4);
}

/// A map is used and extended without a cloud that was damaged.
#[test]
fn a_keyframe_without_cloud_keeps_no_map_from_use() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = interrupted(dir.path());
    fs::write(store.session(SESSION).join("000002.pcd"), b"").expect("written");
    store.save_interrupted_session(SESSION, map(2), "Hall").expect("saved");
    let descriptors = keyframe_descriptors(&store.dir().map(map(2)), 5).expect("written");
    let points: Vec<usize> = descriptors.iter().map(|descriptor| descriptor.points.len()).collect();
    assert!(points[1] > 0 && points[2] == 0 && points[3] > 0, "{points:?}");
    let extension = SessionId(Uuid::from_u128(8));
    store.copy_map_clouds_to_session(map(2), extension).expect("copied");
    assert!(store.session(extension).join("000003.pcd").exists());
}

#[test]
fn a_session_whose_map_was_not_finished_stays() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = interrupted(dir.path());
    store.mark_as_saving(SESSION, map(2)).expect("marked");
    let half = store.dir().maps().join(format!(".{}", map(2)));
    fs::create_dir_all(&half).expect("made");
    link_clouds(&store.session(SESSION), &half.join("clouds")).expect("linked");
    drop(store);
    let store = Store::open(dir.path()).expect("opens");
    assert!(!half.exists(), "an unfinished map is removed");
    assert_eq!(store.interrupted_sessions().expect("listed").sessions[0].keyframes, KEYFRAMES);
    store.save_interrupted_session(SESSION, map(2), "Hall").expect("saved");
    // A map that was damaged since does not make the session superfluous.
    fs::write(store.dir().map_summary(map(2)), "{").expect("written");
    drop(store);
    let store = Store::open(dir.path()).expect("opens");
    assert_eq!(store.interrupted_sessions().expect("listed").sessions.len(), 1);
}

/// Cuts, zeroes and changes every file of a session in turn.
#[test]
fn no_damage_removes_a_session_and_all_of_it_is_named() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = interrupted(dir.path());
    let folder = store.session(SESSION);
    let journal = journal_path(&folder);
    let whole = fs::read(&journal).expect("written");
    drop(store);
    let count = fs::read_dir(&folder).expect("listed").count();
    let cut = whole[..whole.len() / 2].to_vec();
    let mut flipped = whole.clone();
    flipped[whole.len() / 2] ^= 1;
    for damaged in [Vec::new(), cut[..20].to_vec(), vec![0; whole.len()], flipped] {
        fs::write(&journal, &damaged).expect("written");
        let store = Store::open(dir.path()).expect("opens");
        let found = store.interrupted_sessions().expect("listed");
        assert_eq!(found.sessions.len(), 1);
        assert!(found.problems.iter().any(|text| text.contains("journal.bin")), "{:?}", found.problems);
        assert_eq!(fs::read_dir(&folder).expect("listed").count(), count);
    }
    fs::write(&journal, &whole).expect("written");
    fs::write(folder.join("000002.pcd"), b"").expect("written");
    let store = Store::open(dir.path()).expect("opens");
    let (report, problems) = store.save_interrupted_session(SESSION, map(2), "Hall").expect("saved");
    assert_eq!(report.summary.keyframes, KEYFRAMES);
    assert!(problems[0].contains("000002.pcd"), "{problems:?}");
    assert!(store.dir().map(map(2)).join("clouds/000002.pcd.damaged").exists());
}

#[test]
fn a_session_without_keyframes_is_removed() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = Store::open(dir.path()).expect("opens");
    let mut journal = store.session_journal(SESSION).expect("begun");
    journal.append(&SessionRecord::State { extends: None, distance_m: 0.0 }).expect("written");
    drop((store, journal));
    let store = Store::open(dir.path()).expect("opens");
    assert!(!store.session(SESSION).exists());
}

#[test]
fn a_session_that_was_being_removed_is_not_offered_again() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = interrupted(dir.path());
    let folder = store.session(SESSION);
    // A crash after the folder got its hidden name, and after some of its files are gone.
    let hidden = folder.with_file_name(format!(".{SESSION}"));
    fs::rename(&folder, &hidden).expect("renamed");
    fs::remove_file(hidden.join("000000.pcd")).expect("removed");
    drop(store);
    let store = Store::open(dir.path()).expect("opens");
    assert_eq!(store.interrupted_sessions().expect("listed"), InterruptedSessions::default());
    assert!(!hidden.exists());
}

#[test]
fn a_cloud_with_a_wrong_bit_is_put_aside() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = interrupted(dir.path());
    let path = store.session(SESSION).join("000002.pcd");
    let mut bytes = fs::read(&path).expect("read");
    let last = bytes.len() - 1;
    bytes[last] ^= 1;
    fs::write(&path, &bytes).expect("written");
    let (_, problems) = store.save_interrupted_session(SESSION, map(2), "Hall").expect("saved");
    let [problem] = &problems[..] else { panic!("{problems:?}") };
    assert!(problem.contains("000002.pcd"), "{problem}");
    assert_eq!(fs::read(store.dir().map(map(2)).join("clouds/000002.pcd.damaged")).expect("kept"), bytes);
}
