//! The program's own files, which a failing disk may damage.

use crate::assert_sentence;
use crate::scratch::{with_file, with_folder};
use std::fs;
use std::path::Path;
use store::{SavedMap, Store};
use vocab::{MapId, Stamp};

/// `places.bin`: descriptors of keyframes.
pub fn places(bytes: &[u8]) {
    store::fuzzing::read_keyframe_descriptors(bytes);
}

/// `viewpoints_*.bin`: the clouds of virtual viewpoints.
pub fn viewpoints(bytes: &[u8]) {
    if let Err(error) = store::fuzzing::read_viewpoint_clouds(bytes) {
        assert_sentence(&error);
    }
}

/// `journal.bin` of a mapping session. The input is the records alone, each after its length, two bytes: a fuzzer cannot guess their
/// checksums. If its first byte is odd, the rest of it is the file itself.
pub fn session_journal(bytes: &[u8]) {
    let Some((choice, rest)) = bytes.split_first() else { return };
    let file = match choice & 1 {
        0 => framed(rest),
        _ => rest.to_vec(),
    };
    if let Err(error) = with_file("journal.bin", &file, store::fuzzing::read_session_journal) {
        assert_sentence(&error);
    }
}

fn framed(mut rest: &[u8]) -> Vec<u8> {
    let mut records = Vec::new();
    while let Some((length, after)) = rest.split_first_chunk::<2>() {
        let (record, after) = after.split_at(usize::from(u16::from_le_bytes(*length)).min(after.len()));
        records.push(record);
        rest = after;
    }
    store::fuzzing::session_journal_of(&records).expect("records are short")
}

/// The files of a data directory that one input replaces, by its first byte.
pub const STORED_FILES: [&str; 13] = [
    "maps/MAP/map.json",
    "maps/MAP/graph.json",
    "maps/MAP/tiles.json",
    "maps/MAP/loops.json",
    "maps/MAP/graph.g2o",
    "maps/MAP/trajectory.tum",
    "place.json",
    "docks.json",
    "stop.json",
    "bin/MAP/map.json",
    "bin/MAP/tiles.json",
    "bin/MAP/deleted.json",
    "uploads/MAP.json",
];

/// The map of the fixture.
const MAP: &str = "a0a00000-0000-4000-8000-000000000001";

/// The small files of a saved map and of the data directory. The first byte chooses the file that the rest replaces; the others are those
/// of `tests/fixtures`.
///
/// # Panics
/// When the directory cannot be made.
pub fn stored_files(bytes: &[u8]) {
    let Some((choice, content)) = bytes.split_first() else { return };
    let replaced = STORED_FILES[usize::from(*choice) % STORED_FILES.len()];
    with_folder(|folder| {
        let data = folder.join("data");
        let _ = fs::remove_dir_all(&data);
        for folder in ["maps", "bin", "uploads"] {
            fs::create_dir_all(data.join(folder).join(MAP)).expect("a temporary folder can be made");
        }
        let fixture = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fixtures/data-2026-11");
        for name in STORED_FILES {
            let path = name.replace("MAP", MAP);
            if name == replaced {
                fs::write(data.join(path), content).expect("a temporary file can be written");
            } else if let Ok(content) = fs::read(fixture.join(path.replace("bin/", "maps/"))) {
                fs::write(data.join(path), content).expect("a temporary file can be written");
            }
        }
        read_data_directory(&data);
    });
}

fn read_data_directory(data: &Path) {
    if let Err(error) = SavedMap::read(&data.join("maps").join(MAP)) {
        assert_sentence(&error);
    }
    let store = match Store::open(data) {
        Ok(store) => store,
        Err(error) => return assert_sentence(&error),
    };
    match store.list_maps() {
        Ok(list) => list.damaged.iter().for_each(|map| assert_sentence(&map.error)),
        Err(error) => assert_sentence(&error),
    }
    let map: MapId = MAP.parse().map(MapId).expect("it is an id");
    if let Err(error) = store.map_tiles(map) {
        assert_sentence(&error);
    }
    let _ = (store.last_pose(), store.docks(), store.stop_latch(), store.uploads().map(|all| all.len()));
    match store.binned_maps() {
        Ok(maps) => {
            for map in &maps {
                let _ = map.kept_until();
                map.problem.iter().for_each(|problem| assert_sentence(problem));
            }
        }
        Err(error) => assert_sentence(&error),
    }
    if let Err(error) = store.empty_bin(Stamp::from_parts(1_700_000_000, 0)) {
        assert_sentence(&error);
    }
}
