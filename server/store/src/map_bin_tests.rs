//! The bin, also for processes that are killed between any two steps.

use super::*;
use crate::maps::tests::{SESSION, content, make_a_day_older, session};
use api::TileList;
use std::path::PathBuf;
use uuid::Uuid;
use vocab::{Pose, Span};

const MAP: MapId = MapId(Uuid::from_u128(1));
const NOW: Stamp = Stamp::from_parts(1_795_000_000, 0);

fn hours(hours: i64) -> Span {
    Span::from_millis(hours * 3_600_000)
}

/// A store with the saved map [`MAP`], and the files of its folder.
fn store_with_map(dir: &Path) -> (Store, Vec<(PathBuf, Vec<u8>)>) {
    let store = Store::open(dir).expect("opens");
    store.save_map(&session(&store, 1, 100)).expect("saved");
    store.discard_session(SESSION).expect("discarded");
    let files = content(&store.dir().map(MAP));
    (store, files)
}

fn reopened(store: Store) -> Store {
    let root = store.dir().root().to_owned();
    drop(store);
    Store::open(root).expect("opens")
}

fn tiles(store: &Store, folder: &Path) -> Vec<PathBuf> {
    let list: TileList = files::read_json(&folder.join("tiles.json")).expect("tiles");
    list.tiles.iter().map(|tile| store.dir().tile(tile.hash)).collect()
}

fn pose() -> PoseInMap {
    PoseInMap { map: MAP, map_from_base: Pose::IDENTITY }
}

#[test]
fn a_deleted_map_comes_back_as_it_was_with_its_docks() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let (store, files) = store_with_map(dir.path());
    store.save_docks(&[pose()]).expect("saved");
    store.save_last_pose(Some(&pose())).expect("saved");
    store.bin_map(MAP, Some(NOW)).expect("moved");
    store.bin_map(MAP, None).expect("again is no error");
    assert!(store.maps().expect("listed").is_empty());
    assert!(
        !store.dir().last_pose().exists(),
        "the robot has left the map, and nobody has removed the pose yet"
    );
    let store = reopened(store);
    assert_eq!(store.docks(), [pose()], "docks of maps in the bin are kept");
    let [binned] = store.binned_maps().expect("listed").try_into().expect("one");
    assert_eq!((binned.map, binned.deleted_at), (MAP, Some(NOW)));
    assert_eq!(binned.kept_until(), Some(NOW + hours(7 * 24)));
    assert_eq!(binned.summary.expect("readable").name, "Hall");
    store.restore_map(MAP).expect("moved back");
    store.restore_map(MAP).expect("again is no error");
    assert_eq!(content(&store.dir().map(MAP)), files);
    assert_eq!((store.last_pose(), store.docks()), (None, vec![pose()]));
    assert!(store.binned_maps().expect("listed").is_empty());
}

#[test]
fn the_robots_pose_in_a_damaged_map_goes_to_the_bin_and_comes_back_with_it() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let (store, _) = store_with_map(dir.path());
    store.save_last_pose(Some(&pose())).expect("saved");
    let summary = store.dir().map_summary(MAP);
    let whole = fs::read(&summary).expect("readable");
    fs::write(&summary, "{").expect("written");
    store.bin_map(MAP, Some(NOW)).expect("moved");
    store.save_last_pose(None).expect("removed");
    fs::write(store.dir().binned_map(MAP).join("map.json"), whole).expect("mended");
    store.restore_map(MAP).expect("moved back");
    assert_eq!(store.last_pose(), Some(pose()));
}

#[test]
fn a_map_has_another_name_and_all_else_stays() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let (store, files) = store_with_map(dir.path());
    store.rename_map(MAP, "Cellar, \"east\"").expect("renamed");
    let renamed = store.maps().expect("listed").remove(0);
    assert_eq!(renamed.name, "Cellar, \"east\"");
    store.rename_map(MAP, "Hall").expect("renamed");
    let path = store.dir().map_summary(MAP);
    // The order of the fields may change, and with it their checksum.
    let meaning = |bytes: &[u8]| {
        let mut document: serde_json::Value = serde_json::from_slice(bytes).expect("JSON");
        assert!(document.as_object_mut().expect("an object").remove("checksum").is_some());
        document
    };
    for ((path_now, now), (path_before, before)) in content(&store.dir().map(MAP)).iter().zip(&files) {
        assert_eq!(path_now, path_before);
        if *path_now == path {
            assert_eq!(meaning(now), meaning(before));
        } else {
            assert_eq!(now, before);
        }
    }
    assert!(matches!(store.rename_map(MapId(Uuid::nil()), "x"), Err(StoreError::NoSuchMap { .. })));
}

/// Every state that a process which was killed can leave.
#[test]
fn a_kill_between_the_steps_loses_nothing() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let (store, files) = store_with_map(dir.path());
    let (map, binned) = (store.dir().map(MAP), store.dir().binned_map(MAP));
    let deletion = DeletionDocument { format_version: 1, deleted_at: Some(NOW), last_pose: None };
    // While it is deleted: the file is there, the folder was not moved. It is still saved, and can be deleted.
    deletion.write(&map).expect("written");
    let store = reopened(store);
    assert_eq!(store.maps().expect("listed").len(), 1);
    store.bin_map(MAP, Some(NOW)).expect("moved");
    // While it is restored: the folder was moved, the file is still there.
    fs::rename(&binned, &map).expect("moved");
    let store = reopened(store);
    assert_eq!((store.maps().expect("listed").len(), store.binned_maps().expect("listed").len()), (1, 0));
    assert!(files.iter().all(|(path, bytes)| fs::read(path).expect("kept") == *bytes));
    // While it is renamed: the new file was written, and is not in its place.
    fs::write(map.join("map.json.part"), "{").expect("written");
    store.rename_map(MAP, "Cellar").expect("renamed");
    // While it is deleted for good: half of it is gone.
    store.bin_map(MAP, Some(NOW)).expect("moved");
    let leaving = store.dir().bin().join(format!(".{MAP}"));
    fs::rename(&binned, &leaving).expect("moved");
    fs::remove_file(leaving.join("map.json")).expect("removed");
    let store = reopened(store);
    assert!(!leaving.exists() && store.binned_maps().expect("listed").is_empty());
}

#[test]
fn maps_are_kept_for_a_week_and_their_tiles_a_day_longer() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let (store, _) = store_with_map(dir.path());
    let tiles = tiles(&store, &store.dir().map(MAP));
    store.bin_map(MAP, Some(NOW)).expect("moved");
    make_a_day_older(&store.dir().tiles());
    let store = reopened(store);
    assert!(store.empty_bin(NOW + hours(7 * 24 - 1)).expect("emptied").is_empty());
    assert!(!tiles.is_empty() && tiles.iter().all(|tile| tile.exists()), "tiles of the bin are in use");
    assert_eq!(store.empty_bin(NOW + hours(7 * 24)).expect("emptied"), ["Hall"]);
    assert!(!store.dir().binned_map(MAP).exists());
    let store = reopened(store);
    assert!(tiles.iter().all(|tile| tile.exists()), "a day's grace");
    make_a_day_older(&store.dir().tiles());
    let _store = reopened(store);
    assert!(tiles.iter().all(|tile| !tile.exists()));
}

#[test]
fn the_week_begins_when_the_time_is_known() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let (store, _) = store_with_map(dir.path());
    store.bin_map(MAP, None).expect("moved");
    assert_eq!(store.binned_maps().expect("listed")[0].kept_until(), None);
    assert!(store.empty_bin(NOW).expect("emptied").is_empty());
    assert_eq!(store.binned_maps().expect("listed")[0].kept_until(), Some(NOW + hours(7 * 24)));
    assert!(store.empty_bin(NOW + hours(24)).expect("emptied").is_empty());
    assert_eq!(store.empty_bin(NOW + hours(7 * 24)).expect("emptied"), ["Hall"]);
}

#[test]
fn a_damaged_map_can_be_deleted_and_stays_until_a_person_decides() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let late = NOW + hours(1000);
    let later = r#"{"format_version": 1000}"#;
    for (name, broken) in [
        ("map.json", "{"),
        ("map.json", later),
        ("tiles.json", ""),
        ("deleted.json", "{"),
        ("deleted.json", later),
    ] {
        let dir = dir.path().join(format!("{name}-{}", broken.len()));
        let (store, _) = store_with_map(&dir);
        let tiles = tiles(&store, &store.dir().map(MAP));
        if name != "deleted.json" {
            fs::write(store.dir().map(MAP).join(name), broken).expect("written");
        }
        store.bin_map(MAP, Some(NOW)).expect("moved, though it is damaged");
        assert!(store.damaged_maps().expect("listed").is_empty());
        if name == "deleted.json" {
            fs::write(store.dir().binned_map(MAP).join(name), broken).expect("written");
        }
        make_a_day_older(&store.dir().tiles());
        let store = reopened(store);
        let before = content(&dir);
        assert!(store.empty_bin(late).expect("emptied").is_empty());
        assert!(store.empty_bin(late).expect("emptied").is_empty());
        assert_eq!(content(&dir), before, "{name}");
        let listed = store.binned_maps().expect("listed").remove(0);
        assert!(listed.problem.expect("named").to_string().contains(name));
        if name != "deleted.json" {
            assert!(tiles.iter().all(|tile| tile.exists()));
        }
        store.restore_map(MAP).expect("moved back");
        assert_eq!(store.damaged_maps().expect("listed").len(), usize::from(name != "deleted.json"));
        store.bin_map(MAP, Some(NOW)).expect("moved");
        store.delete_map_permanently(MAP).expect("deleted");
        assert!(!store.dir().binned_map(MAP).exists() && !store.dir().map(MAP).exists());
        if name == "deleted.json" {
            continue;
        }
        drop(store);
    }
}

#[test]
fn an_id_is_either_saved_or_in_the_bin() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let (store, _) = store_with_map(dir.path());
    store.bin_map(MAP, Some(NOW)).expect("moved");
    let again = session(&store, 1, 200);
    assert!(matches!(store.save_map(&again), Err(StoreError::MapInBin { .. })));
    // Somebody copies the folder back by hand.
    fs::create_dir_all(store.dir().map(MAP)).expect("made");
    assert!(matches!(store.bin_map(MAP, Some(NOW)), Err(StoreError::MapInBin { .. })));
    assert!(matches!(store.restore_map(MAP), Err(StoreError::MapExists { .. })));
    let nobody = MapId(Uuid::nil());
    assert!(matches!(store.restore_map(nobody), Err(StoreError::NotInBin { .. })));
    assert!(matches!(store.bin_map(nobody, None), Err(StoreError::NoSuchMap { .. })));
    store.delete_map_permanently(nobody).expect("no error");
}

#[test]
fn the_bytes_of_version_1_are_read_and_missing_fields_have_defaults() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let golden = concat!(
        r#"{"format_version":1,"deleted_at":1795000000000000000,"last_pose":{"map":"00000000-0000-0000-0000-000000000001","#,
        r#""map_from_base":{"position":{"x":0.0,"y":0.0,"z":0.0},"orientation":{"w":1.0,"x":0.0,"y":0.0,"z":0.0}}}}"#
    );
    let deletion = DeletionDocument { format_version: 1, deleted_at: Some(NOW), last_pose: Some(pose()) };
    let path = dir.path().join(DELETION_NAME);
    fs::write(&path, golden).expect("written");
    assert_eq!(DeletionDocument::read(dir.path()).expect("read"), deletion);
    fs::write(&path, r#"{"format_version":1}"#).expect("written");
    let least = DeletionDocument { format_version: 1, ..DeletionDocument::default() };
    assert_eq!(DeletionDocument::read(dir.path()).expect("read"), least);
}
