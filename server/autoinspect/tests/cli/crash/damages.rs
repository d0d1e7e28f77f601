//! Damages every file of a data directory in turn. The program must start, name the file, delete nothing, and open what is not damaged.

use super::case::{drive, map_until};
use super::client::CoreState;
use super::inventory::{Inventory, check_whole, copy_folder, inventory};
use super::options::CrashOptions;
use super::report::{CaseReport, CrashReport};
use super::target::{START_LIMIT, Target, Victim};
use crate::import::room_with_table_at;
use crate::program::{run, text};
use api::{Command, Import, Localisation};
use geometry::{Rng, RngTree};
use messages::PoseInMap;
use std::collections::BTreeMap;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::Duration;
use uuid::Uuid;
use vocab::{MapId, Pose, SessionId, UploadId};

/// Keyframes of the interrupted session. Half a journal is noticed by four or more clouds that it does not know, and this number leaves eight. With fewer than
/// four, a cut journal looks like that of a program that was killed before the last clouds were in it.
const SESSION_KEYFRAMES: usize = 16;

/// Longest time from the start until all files have been looked into.
const NAMING_LIMIT: Duration = Duration::from_secs(10);

/// The ledger. What SQLite keeps beside it goes when it is closed.
const LEDGER: &str = "ledger.db";

/// How a file is damaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Damage {
    CutAtHalf,
    Zeroed,
    BitFlipped,
    Emptied,
    ReplacedByDirectory,
}

impl Damage {
    const ALL: [Self; 5] =
        [Self::CutAtHalf, Self::Zeroed, Self::BitFlipped, Self::Emptied, Self::ReplacedByDirectory];

    fn name(self) -> &'static str {
        match self {
            Self::CutAtHalf => "cut at half",
            Self::Zeroed => "zeroed",
            Self::BitFlipped => "one bit flipped",
            Self::Emptied => "emptied",
            Self::ReplacedByDirectory => "replaced by a directory",
        }
    }

    fn apply(self, path: &Path, rng: &mut Rng) {
        let mut bytes = fs::read(path).expect("read");
        match self {
            Self::CutAtHalf => bytes.truncate(bytes.len() / 2),
            Self::Zeroed => bytes.fill(0),
            Self::BitFlipped => {
                let bit = (rng.uniform() * bytes.len() as f64 * 8.0) as usize;
                bytes[bit / 8] ^= 1 << (bit % 8);
            }
            Self::Emptied => bytes.clear(),
            Self::ReplacedByDirectory => {
                fs::remove_file(path).expect("removed");
                return fs::create_dir(path).expect("made");
            }
        }
        fs::write(path, bytes).expect("written");
    }
}

/// What a file is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum FileKind {
    MapFile(&'static str),
    MapCloud,
    ViewpointClouds,
    Tile,
    StateFile(&'static str),
    SessionJournal,
    SessionSaving,
    SessionChecksums,
    SessionCloud,
    /// Encoded for the clients of a running session. Once that is interrupted, nothing reads it.
    SessionScan,
    Recording,
    /// The report of a command, which is for people only.
    CommandReport,
    /// Bytes that other people made. The import that is asked for says what is wrong with them.
    Upload,
    UploadNote,
    BinnedMap,
    /// A file that an action has gathered.
    Blob,
}

impl FileKind {
    /// By the path in the data directory.
    fn of(path: &Path) -> Option<Self> {
        let name = path.file_name()?.to_str()?;
        let folder = path.iter().next()?.to_str()?;
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        let known = |names: &[&'static str]| names.iter().copied().find(|known| *known == name);
        Some(match folder {
            "tiles" => Self::Tile,
            "blobs" => Self::Blob,
            "recordings" if ending == "mcap" => Self::Recording,
            "uploads" if ending == "json" => Self::UploadNote,
            "uploads" => Self::Upload,
            "bin" if name != "summary.json" => Self::BinnedMap,
            "maps" if ending == "pcd" => Self::MapCloud,
            "maps" if name.starts_with("viewpoints_") => Self::ViewpointClouds,
            "maps" if name == "summary.json" => Self::CommandReport,
            "maps" => Self::MapFile(known(&[
                "map.json",
                "tiles.json",
                "graph.json",
                "graph.g2o",
                "loops.json",
                "trajectory.tum",
                "places.bin",
                "import.json",
                "summary.json",
                "checksums.json",
            ])?),
            "sessions" if ending == "pcd" => Self::SessionCloud,
            "sessions" if ending == "scan" => Self::SessionScan,
            "sessions" if name == "journal.bin" => Self::SessionJournal,
            "sessions" if name == "saving.json" => Self::SessionSaving,
            "sessions" if name == "checksums.b3" => Self::SessionChecksums,
            _ => Self::StateFile(known(&["place.json", "docks.json", "stop.json", LEDGER])?),
        })
    }

    fn name(self) -> String {
        match self {
            Self::MapFile(name) => format!("map: {name}"),
            Self::MapCloud => "map: cloud of a keyframe".to_owned(),
            Self::ViewpointClouds => "map: clouds of viewpoints".to_owned(),
            Self::Tile => "tile".to_owned(),
            Self::StateFile(name) => name.to_owned(),
            Self::SessionJournal => "session: journal.bin".to_owned(),
            Self::SessionSaving => "session: saving.json".to_owned(),
            Self::SessionChecksums => "session: checksums.b3".to_owned(),
            Self::SessionCloud => "session: cloud of a keyframe".to_owned(),
            Self::SessionScan => "session: cloud for clients".to_owned(),
            Self::Recording => "recording".to_owned(),
            Self::CommandReport => "map: summary.json".to_owned(),
            Self::Upload => "upload".to_owned(),
            Self::UploadNote => "upload: note".to_owned(),
            Self::BinnedMap => "bin: file of a map".to_owned(),
            Self::Blob => "file of an action".to_owned(),
        }
    }

    fn is_named_at_start(self) -> bool {
        !matches!(self, Self::SessionScan | Self::Recording | Self::CommandReport | Self::Upload)
    }
}

/// A data directory with a file of each kind.
struct Template {
    dir: PathBuf,
    /// Paths in the data directory.
    files: Vec<(FileKind, PathBuf)>,
    walked: MapId,
    imported: MapId,
}

/// Damages files and fails if one is lost or not named: every file in every way, or each kind in one way.
pub fn damage_files() {
    let options = CrashOptions::from_environment();
    let mut report = CrashReport::new(&options, "damage");
    let seeds = RngTree::new(options.seed).child("damage");
    let template = Template::make().expect("the files to be damaged");
    for (case, (kind, path, damage)) in template.cases(&options, &mut seeds.rng()).into_iter().enumerate() {
        if options.only.is_some_and(|only| only != case) {
            continue;
        }
        let mut rng = seeds.child(&case.to_string()).rng();
        let what = format!("{}: {}", kind.name(), damage.name());
        let mut row = CaseReport { case, what, ..CaseReport::default() };
        let result =
            catch_unwind(AssertUnwindSafe(|| template.try_case(kind, &path, damage, &mut rng, &mut row)));
        row.failure = match result {
            Ok(result) => result.err().map(|failure| format!("{}: {failure}", path.display())),
            Err(panic) => {
                Some(panic.downcast_ref::<String>().cloned().unwrap_or_else(|| "a panic".to_owned()))
            }
        };
        report.add(&row);
    }
    fs::remove_dir_all(&template.dir).expect("removed");
    report.finish();
}

impl Template {
    fn make() -> Result<Self, String> {
        let dir = tempfile::Builder::new().prefix("damage-").tempdir().expect("temporary directory").keep();
        let data = dir.join("data");
        let walked = MapId(Uuid::from_u128(1));
        let mut target = Target::start(Victim::Core, &dir)?;
        let client = &mut target.client;
        map_until(client, SessionId(Uuid::from_u128(1)), 3)?;
        client.command(Command::FinishMapping { map: walked, name: "Hall".to_owned() })?;
        client.until("the map is listed", |state| state.maps.iter().flatten().any(|map| map.id == walked))?;
        let upload = UploadId(Uuid::from_u128(3));
        fs::write(data.join("uploads").join(upload.to_string()), room_with_table_at(2.0)).expect("written");
        client.command(Command::ImportMap { upload, name: "Room".to_owned(), frame: None })?;
        client.until("an import", |state| matches!(state.import, Import::Done { .. }))?;
        let Import::Done { map: imported, .. } = client.state.import else {
            return Err("nothing was imported".to_owned());
        };
        // Another one goes to the bin.
        fs::write(data.join("uploads").join(upload.to_string()), room_with_table_at(5.0)).expect("written");
        client.command(Command::ImportMap { upload, name: "Old room".to_owned(), frame: None })?;
        client.until(
            "another import",
            |state| matches!(state.import, Import::Done { map, .. } if map != imported),
        )?;
        let Import::Done { map: binned, .. } = client.state.import else {
            return Err("nothing was imported".to_owned());
        };
        client.command(Command::DeleteMap(binned))?;
        client.command(Command::Localise { map: walked, at: None })?;
        client.until_with("a pose", drive, |state| {
            matches!(state.localisation, Localisation::Localised { .. })
        })?;
        client.until("the pose is written", |_| data.join("place.json").exists())?;
        drop(target.kill());

        let mut target = Target::start(Victim::Core, &dir)?;
        let client = &mut target.client;
        let session = SessionId(Uuid::from_u128(2));
        client.command(Command::TakeControl { name: "Test".to_owned() })?;
        client.command(Command::LeaveMap)?;
        map_until(client, session, SESSION_KEYFRAMES)?;
        client.command(Command::StopMotion)?;
        drop(target.kill());

        let store = store::Store::open(&data).map_err(|error| error.to_string())?;
        let pose = PoseInMap { map: walked, map_from_base: Pose::IDENTITY };
        store.save_docks(&[pose]).expect("saved");
        store.save_last_pose(Some(&pose)).expect("saved");
        store.note_upload(upload, store::UploadNote::default()).expect("noted");
        fill_ledger(&store);
        store.put_blob(&[7; 40_000], &store::BlobsConfig::default()).expect("stored");
        drop(store);
        // As if it had been killed while it was saved.
        let saving = data.join("sessions").join(session.to_string()).join("saving.json");
        let rest = format!(r#""format_version":2,"map":"{}"}}"#, Uuid::from_u128(9));
        let checksum = blake3::hash(rest.as_bytes());
        fs::write(saving, format!(r#"{{"checksum":"{checksum}",{rest}"#)).expect("written");
        fs::write(data.join("uploads").join(upload.to_string()), room_with_table_at(2.0)).expect("written");
        let _ = fs::remove_file(data.join("core.sock"));
        let template = dir.join("template");
        fs::rename(&data, &template).expect("renamed");
        let files = inventory(&template).into_keys();
        let files = files.filter_map(|path| Some((FileKind::of(&path)?, path)));
        let not_empty = |path: &PathBuf| fs::metadata(template.join(path)).is_ok_and(|about| about.len() > 0);
        // Tiles that only a session has shown belong to no map. They are not missed, and go after a day.
        let lists: Vec<String> =
            ["maps", "bin"].iter().flat_map(|folder| tile_lists(&template.join(folder))).collect();
        let is_used = |path: &Path| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            lists.iter().any(|list| list.contains(&*name))
        };
        let files =
            files.filter(|(kind, path)| not_empty(path) && (*kind != FileKind::Tile || is_used(path)));
        let files = files.collect();
        Ok(Self { dir, files, walked, imported })
    }

    /// What is damaged, and how.
    fn cases(&self, options: &CrashOptions, rng: &mut Rng) -> Vec<(FileKind, PathBuf, Damage)> {
        let all =
            |(kind, path): &(FileKind, PathBuf)| Damage::ALL.map(|damage| (*kind, path.clone(), damage));
        if options.all_damages {
            return self.files.iter().flat_map(all).collect();
        }
        let mut kinds: BTreeMap<FileKind, Vec<&PathBuf>> = BTreeMap::new();
        self.files.iter().for_each(|(kind, path)| kinds.entry(*kind).or_default().push(path));
        let mut draw = |count: usize| (rng.uniform() * count as f64) as usize;
        let sample = kinds.into_iter().map(|(kind, paths)| {
            (kind, paths[draw(paths.len())].clone(), Damage::ALL[draw(Damage::ALL.len())])
        });
        sample.collect()
    }

    fn try_case(
        &self,
        kind: FileKind,
        path: &Path,
        damage: Damage,
        rng: &mut Rng,
        row: &mut CaseReport,
    ) -> Result<(), String> {
        let data = self.dir.join("data");
        if data.exists() {
            fs::remove_dir_all(&data).expect("removed");
        }
        copy_folder(&self.dir.join("template"), &data);
        let damaged = data.join(path);
        damage.apply(&damaged, rng);
        let before = inventory(&data);
        let mut target = Target::start(Victim::Core, &self.dir)?;
        row.start = Some(target.start);
        if target.start > START_LIMIT {
            return Err(format!("the start took {:.1} s", target.start.as_secs_f64()));
        }
        let list = |state: &CoreState| {
            state.maps.is_some() && state.damaged_maps.is_some() && state.motion.is_some()
        };
        target.client.until("the first state", list)?;
        let named = self.wait_until_named(&mut target, kind, &damaged);
        let opened = self.check_listed(&data, path, &target.client.state);
        drop(target.kill());
        let kept = check_kept(&before, &data, path);
        if kind == FileKind::Recording {
            check_recording(&self.dir.join("template").join(path), &damaged)?;
        }
        // Parts of a database hold nothing: a wrong bit there changes nothing, and nobody is told.
        let is_harmless =
            || damage == Damage::BitFlipped && site_of(&data) == site_of(&self.dir.join("template"));
        let named = if kind == FileKind::StateFile(LEDGER) && is_harmless() { Ok(()) } else { named };
        named.and(opened).and(kept)
    }

    /// Waits until a notice, the list of damaged maps or the log names the file.
    fn wait_until_named(&self, target: &mut Target, kind: FileKind, damaged: &Path) -> Result<(), String> {
        if !kind.is_named_at_start() {
            return Ok(());
        }
        let path = damaged.display().to_string();
        let started = std::time::Instant::now();
        while started.elapsed() < NAMING_LIMIT {
            target.client.for_time(Duration::from_millis(20), |_| {})?;
            let state = &target.client.state;
            let lists = state.damaged_maps.iter().flatten().map(|map| map.problem.clone());
            let lists = lists.chain(state.binned_maps.iter().filter_map(|map| map.problem.clone()));
            if lists
                .chain(state.notices.iter().cloned())
                .chain([target.log()])
                .any(|text| text.contains(&path))
            {
                return Ok(());
            }
        }
        Err("it is not named".to_owned())
    }

    /// Checks that both maps are listed, as usable or as damaged, and that one without damage is whole.
    fn check_listed(&self, data: &Path, damaged: &Path, state: &CoreState) -> Result<(), String> {
        for map in [self.walked, self.imported] {
            let is_usable = state.maps.iter().flatten().any(|listed| listed.id == map);
            let folder = map.to_string();
            let is_damaged = state.damaged_maps.iter().flatten().any(|listed| listed.folder == folder);
            if is_usable == is_damaged {
                return Err(format!("map {map} is listed as usable: {is_usable}, as damaged: {is_damaged}"));
            }
            if damaged.starts_with(Path::new("maps").join(&folder)) || damaged.starts_with("tiles") {
                continue;
            }
            if is_damaged {
                return Err(format!("map {map} without damage is listed as damaged"));
            }
            check_whole(data, map, 0)?;
        }
        Ok(())
    }
}

/// Makes some hundred edits of the site.
fn fill_ledger(store: &store::Store) {
    let (mut ledger, mut state) = store.open_ledger().expect("opens");
    for number in 0..300_u64 {
        let asset = site_model::Asset {
            id: site_model::AssetId(Uuid::from_u128((number % 50).into())),
            name: format!("Pump {number}"),
            tags: Default::default(),
        };
        let id = site_model::EditId(Uuid::from_u128(number.into()));
        let edit = state.site.put(id, site_model::Object::Asset(asset));
        let changes = state.site.apply(&edit, id).expect("of this state").revisions;
        state.revision += 1;
        let record = store::EditRecord {
            revision: state.revision,
            edit: &edit,
            changes: &changes,
            by: None,
            at: vocab::Stamp::EPOCH,
        };
        ledger.write(|writer| writer.put_edit(&record)).expect("written");
    }
}

/// The site in the ledger of a data directory.
fn site_of(data: &Path) -> Option<api::SiteState> {
    let store = store::Store::open(data).ok()?;
    Some(store.open_ledger().ok()?.1)
}

/// The texts of the tile lists of the maps in a folder.
fn tile_lists(folder: &Path) -> Vec<String> {
    let maps = fs::read_dir(folder).expect("readable").filter_map(Result::ok);
    maps.filter_map(|map| fs::read_to_string(map.path().join("tiles.json")).ok()).collect()
}

/// Checks that every file is there with its bytes, the damaged one perhaps under another name.
fn check_kept(before: &Inventory, data: &Path, damaged: &Path) -> Result<(), String> {
    let after = inventory(data);
    for (path, hash) in before {
        // The rest is of the test: its socket.
        let Some(kind) = FileKind::of(path) else { continue };
        let is_same = after.get(path) == Some(hash);
        let is_moved =
            path == damaged && after.iter().any(|(other, kept)| is_aside_of(other, path) && kept == hash);
        // The robot's pose is written as it walks.
        let may_change = [FileKind::StateFile("place.json"), FileKind::StateFile(LEDGER)].contains(&kind)
            && path != damaged
            && after.contains_key(path);
        if !(is_same || is_moved || may_change) {
            return Err(format!("{} was removed or written to", path.display()));
        }
    }
    let is_directory = |path: &Path| data.join(path).is_dir();
    let aside =
        damaged.with_file_name(format!("{}.damaged", damaged.file_name().unwrap_or_default().display()));
    if before.contains_key(damaged) || is_directory(damaged) || is_directory(&aside) {
        return Ok(());
    }
    Err(format!("the directory {} was removed", damaged.display()))
}

/// Whether a file was put aside from this path.
fn is_aside_of(aside: &Path, path: &Path) -> bool {
    let name = format!("{}.damaged", path.file_name().unwrap_or_default().to_string_lossy());
    aside.parent() == path.parent() && aside.file_name().is_some_and(|other| *other == *name)
}

/// Checks that the program says what is wrong with a damaged recording when it is asked to replay or to describe it, unless the damage has no effect. A
/// recording that is cut is like one of a program that was killed earlier.
fn check_recording(whole: &Path, damaged: &Path) -> Result<(), String> {
    let said = |command: &str, path: &Path| {
        let output = run(&[command, text(path)]);
        [output.stdout, output.stderr].map(|said| String::from_utf8_lossy(&said).into_owned()).concat()
    };
    let replayed = said("replay", damaged);
    if replayed.contains("panicked") {
        return Err(format!("replaying it panics: {replayed}"));
    }
    let is_named = replayed.contains(&damaged.display().to_string());
    if is_named || replayed == said("replay", whole) || said("info", damaged).contains("cut off or damaged") {
        return Ok(());
    }
    Err(format!("replaying it does not name it: {replayed}"))
}
