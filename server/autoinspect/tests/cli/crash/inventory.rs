//! What a data directory holds, by the hash of each file.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};
use vocab::{MapId, Stamp};

/// Hash of each file by its path in the data directory.
pub type Inventory = BTreeMap<PathBuf, blake3::Hash>;

/// Hashes all files below `data` except `run/` and sockets.
pub fn inventory(data: &Path) -> Inventory {
    let mut found = Inventory::new();
    collect(data, data, &mut found);
    found
}

fn collect(data: &Path, folder: &Path, found: &mut Inventory) {
    for entry in fs::read_dir(folder).into_iter().flatten().filter_map(Result::ok) {
        let path = entry.path();
        let Ok(kind) = entry.file_type() else { continue };
        let name = path.strip_prefix(data).expect("below the data directory").to_owned();
        if kind.is_dir() && name != Path::new("run") {
            collect(data, &path, found);
        } else if kind.is_file() {
            // A temporary file may have vanished.
            if let Ok(bytes) = fs::read(&path) {
                found.insert(name, blake3::hash(&bytes));
            }
        }
    }
}

/// The files of these maps and their tiles.
pub fn files_of_maps(all: &Inventory, data: &Path, maps: impl Iterator<Item = MapId>) -> Inventory {
    let mut files = Inventory::new();
    for map in maps {
        let folder = Path::new("maps").join(map.to_string());
        files.extend(all.iter().filter(|(path, _)| path.starts_with(&folder)).map(|(p, h)| (p.clone(), *h)));
        let list = fs::read(data.join(&folder).join("tiles.json")).expect("tiles of a listed map");
        let list: api::TileList = serde_json::from_slice(&list).expect("valid JSON");
        for tile in list.tiles {
            let name = tile.hash.to_string();
            let path = Path::new("tiles").join(&name[..2]).join(&name);
            let hash = all.get(&path).unwrap_or_else(|| panic!("{} of map {map} is missing", path.display()));
            assert_eq!(hash.to_string(), name, "a tile of map {map} is not whole");
            files.insert(path, *hash);
        }
    }
    files
}

/// The first file of `before` that is missing or different in `after`, as a sentence.
pub fn first_change(before: &Inventory, after: &Inventory) -> Option<String> {
    before.iter().find_map(|(path, hash)| match after.get(path) {
        Some(now) if now == hash => None,
        Some(_) => Some(format!("{} has changed", path.display())),
        None => Some(format!("{} is gone", path.display())),
    })
}

/// Temporary files, except those of sessions, which go with their session.
pub fn temporary_files(all: &Inventory) -> Vec<PathBuf> {
    let is_temporary = |path: &&PathBuf| {
        let hidden = path.iter().any(|part| part.as_encoded_bytes().starts_with(b"."));
        (hidden || path.extension().is_some_and(|ending| ending == "part")) && !path.starts_with("sessions")
    };
    all.keys().filter(is_temporary).cloned().collect()
}

/// Makes files look two days old, which is longer than anything unused is kept.
pub fn make_old(data: &Path, files: &[PathBuf]) {
    let old = SystemTime::now() - Duration::from_secs(48 * 3600);
    for file in files {
        let file = File::options().write(true).open(data.join(file)).expect("a file");
        file.set_modified(old).expect("the time can be set");
    }
}

/// Copies a folder with everything below it.
pub fn copy_folder(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("made");
    for entry in fs::read_dir(from).expect("readable").filter_map(Result::ok) {
        let target = to.join(entry.file_name());
        let kind = entry.file_type().expect("known");
        if kind.is_dir() {
            copy_folder(&entry.path(), &target);
        } else if kind.is_file() {
            fs::copy(entry.path(), target).expect("copied");
        }
    }
}

/// Instant of the last input in the newest recording.
pub fn recorded_until(data: &Path) -> Option<Stamp> {
    let runs = fs::read_dir(data.join("recordings")).ok()?.filter_map(Result::ok);
    let run = runs.map(|entry| entry.path()).max()?;
    let recording = recorder::Recording::open(&run, &recorder::TopicSelection::default()).ok()?;
    recording.journal().ok()?.filter_map(Result::ok).map(|(at, _)| at).last()
}

/// Checks that a listed map can be opened, with all its tiles and clouds of all keyframes but the newest `max_clouds_missing`.
pub fn check_whole(data: &Path, map: MapId, max_clouds_missing: usize) -> Result<(), String> {
    let folder = ports::DataDir::new(data).map(map);
    let saved = store::SavedMap::read(&folder).map_err(|error| ports::error_with_causes(&error))?;
    let clouds = store::map_clouds(&folder, store::CloudSelection::ALL)
        .and_then(|clouds| clouds.map(|cloud| cloud.map(|_| ())).collect::<Result<Vec<()>, _>>());
    let clouds = clouds.map_err(|error| ports::error_with_causes(&error))?.len();
    if clouds + max_clouds_missing < saved.poses.len() {
        return Err(format!("map {map} has {} keyframes and {clouds} clouds", saved.poses.len()));
    }
    Ok(())
}
