//! Tests that the data of earlier programs can be opened: `tests/fixtures` has a data directory of each.

use crate::core_process::CoreProcess;
use crate::fake_gateway::FakeGateway;
use crate::program::{json, text};
use api::{Event, Localisation};
use std::fs;
use std::path::{Path, PathBuf};

/// The data directory of the program of November 2026.
pub fn data_of_november_2026() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fixtures/data-2026-11")
}

/// Copies a folder with everything below it.
pub fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("made");
    for entry in fs::read_dir(from).expect("readable") {
        let entry = entry.expect("readable");
        let target = to.join(entry.file_name());
        match entry.file_type().expect("known").is_dir() {
            true => copy(&entry.path(), &target),
            false => drop(fs::copy(entry.path(), target).expect("copied")),
        }
    }
}

/// Every file below a folder, by its path in the folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).into_iter().flatten() {
        let path = entry.expect("readable").path();
        match path.is_dir() {
            true => found.extend(files(&path)),
            false => found.push(path),
        }
    }
    found
}

#[test]
fn all_data_of_november_2026_is_opened() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let data = dir.path().join("data");
    copy(&data_of_november_2026(), &data);
    let stored: Vec<_> =
        files(&data).into_iter().map(|file| (fs::read(&file).expect("read"), file)).collect();

    let mut core = CoreProcess::start(&data);
    let mut gateway = FakeGateway::connect(&core.socket);
    let (mut map, mut docks, mut localising) = (None, None, false);
    while map.is_none() || docks.is_none() || !localising {
        gateway.event(|event| {
            match event {
                Event::Maps(maps) if !maps.is_empty() => map = Some(maps[0].clone()),
                Event::Docks(known) if !known.is_empty() => docks = Some(known.clone()),
                // The map is read, and the robot is localised in it.
                Event::Localisation(Localisation::Relocalising { .. } | Localisation::Localised { .. }) => {
                    localising = true;
                }
                _ => return None,
            }
            Some(())
        });
    }
    core.stop();

    let (map, docks) = (map.expect("listed"), docks.expect("known"));
    assert_eq!((map.name.as_str(), map.keyframes), ("Hall, first walk", 17));
    assert!(map.points > 1_000 && map.distance_m > 10.0, "{map:?}");
    assert_eq!((docks.len(), docks[0].map), (1, map.id));

    let store = store::Store::open(&data).expect("opens");
    let list = fs::read(store.dir().map_tiles(map.id)).expect("tiles of the map");
    let list: api::TileList = serde_json::from_slice(&list).expect("valid JSON");
    assert!(!list.tiles.is_empty());
    for tile in &list.tiles {
        let bytes = fs::read(store.dir().tile(tile.hash)).expect("a tile");
        assert_eq!(map_codec::decode(&bytes).expect("decodes").points.len(), tile.points as usize);
    }
    // Only the files of the last pose and of the docks may change, and no file may vanish.
    for (bytes, file) in stored {
        let now = fs::read(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        if !["place.json", "docks.json"].iter().any(|name| file.ends_with(name)) {
            assert!(now == bytes, "{} was written to", file.display());
        }
    }
}

#[test]
fn recordings_of_november_2026_are_replayed_and_localised_in_their_map() {
    let data = data_of_november_2026();
    let recording = |name: &str| data.join("recordings").join(name);
    let mapped = recording("2026-11-23T17-09-45.944Z.mcap");
    let walked = recording("2026-11-23T17-10-04.801Z.mcap");
    for (file, inputs) in [(&mapped, 10_183), (&walked, 5_960)] {
        let replayed = json(&["replay", text(file)]);
        assert_eq!(replayed["inputs"].as_u64(), Some(inputs), "{replayed}");
        assert!(replayed["effects"].as_u64() > Some(100), "{replayed}");
    }

    let dir = tempfile::tempdir().expect("temporary directory");
    let [map, found] = ["map", "found.tum"].map(|name| dir.path().join(name));
    json(&["map", text(&mapped), "--out", text(&map)]);
    let saved = data.join("maps/a0a00000-0000-4000-8000-000000000001");
    let report = json(&["localise", text(&walked), "--map", text(&saved), "--out", text(&found)]);
    let count = |name: &str| report[name].as_u64().expect("a count");
    assert!(count("localised") * 10 > count("scans") * 8 && count("lost") == 0, "{report}");
}
