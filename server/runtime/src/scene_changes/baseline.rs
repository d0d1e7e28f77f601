//! What a run is compared with: what was last seen of each of its places on earlier runs, of whatever mission, or else the map.
//!
//! The newest run that was at a place tells of it, and older ones tell of the places where no newer one was. What the newer ones found to have changed is taken from the older clouds, so that all
//! clouds together show what was last known. Nothing of it is stored: it follows from the clouds of the runs and from what each of them found.

use serde::{Deserialize, Serialize};
use site_model::{EarlierVisit, LocalisationQuality, RunId};
use std::fs;
use std::path::Path;
use store::{ChangedSince, RunCloudEntry, Store, StoreError};
use vocab::{MapId, Vec3};

/// Name of the file in the folder of a run's clouds that says that the run was compared.
pub(super) const MARKER: &str = "compared.json";

/// Parameters of [`find_baseline`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaselineConfig {
    /// A cloud of another run within this distance was seen at the same place, metres: half more than the distance between two clouds. Chosen: runs do not
    /// keep their clouds at the same places.
    pub same_place_m: f64,
    /// Clouds farther than this from all clouds of the run do not count, metres. Chosen: half of the range to which points of a view are compared; what is farther away sees little of what the run
    /// sees, and takes memory.
    pub reach_m: f64,
    /// Share of the clouds of a run at whose places earlier runs have one. Chosen: with fewer, the map knows more of the places.
    pub min_share: f64,
    /// Runs that are looked at, the newest first. Chosen: a hundred runs are two weeks and more, and the search reads their indices.
    pub max_runs: usize,
}

impl Default for BaselineConfig {
    fn default() -> Self {
        Self { same_place_m: 3.0, reach_m: 10.0, min_share: 0.8, max_runs: 100 }
    }
}

/// A run, and what it is compared with.
#[derive(Clone, Debug, PartialEq)]
pub struct Baseline {
    /// The map of both.
    pub map: MapId,
    /// The earlier visit.
    pub before: EarlierVisit,
    /// The clouds of the earlier runs, those of the newest run first; none of the map.
    pub clouds: Vec<(RunId, RunCloudEntry)>,
    /// What the newer of these runs have found to have changed.
    pub changes: Vec<ChangedSince>,
    /// When the first cloud of the run was seen, nanoseconds since 1970, UTC.
    pub began_utc_ns: i64,
    /// When the last one was.
    pub ended_utc_ns: i64,
}

/// That a run was compared, and with what. It is not compared again.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Compared {
    pub format_version: u32,
    pub before: Option<EarlierVisit>,
    /// Objects that were found.
    pub found: usize,
    /// Why there was no comparison.
    pub problem: Option<String>,
    /// The map in which they are; none of runs of earlier programs.
    #[serde(default)]
    pub map: Option<MapId>,
    /// Where they were and are.
    #[serde(default)]
    pub changes: Vec<ChangedSince>,
}

/// What the clouds of a run are compared with; none if it has none that were seen while the robot was localised well. Grows with the clouds of the earlier runs times those of the run.
///
/// # Errors
/// When the disk fails.
pub fn find_baseline(
    store: &Store,
    run: RunId,
    config: &BaselineConfig,
) -> Result<Option<Baseline>, StoreError> {
    let entries = store.run_clouds(run)?;
    let Some((map, last)) = entries.iter().rev().find_map(|entry| Some((map_of(entry)?, entry))) else {
        return Ok(None);
    };
    let places = places_in(map, &entries);
    let began = entries.iter().map(|entry| entry.utc_ns).min().unwrap_or(last.utc_ns);
    let (mut clouds, mut changes) = (Vec::<(RunId, RunCloudEntry)>::new(), Vec::new());
    for other in store.other_runs_with_clouds(run)?.into_iter().take(config.max_runs) {
        let others = store.run_clouds(other)?;
        if others.iter().any(|entry| entry.utc_ns >= began) {
            continue;
        }
        let newer: Vec<Vec3> = clouds.iter().map(|(_, entry)| position(entry)).collect();
        let is_wanted = |entry: &RunCloudEntry| {
            map_of(entry) == Some(map)
                && is_near(&position(entry), &places, config.reach_m)
                && !is_near(&position(entry), &newer, config.same_place_m)
        };
        clouds.extend(others.into_iter().filter(is_wanted).map(|entry| (other, entry)));
        let known: Vec<Vec3> = clouds.iter().map(|(_, entry)| position(entry)).collect();
        if covered_share(&known, &places, config) >= 1.0 {
            break;
        }
        changes.extend(changes_found_by(&store.dir().clouds_of_run(other), map));
    }
    let known: Vec<Vec3> = clouds.iter().map(|(_, entry)| position(entry)).collect();
    let newest = clouds.first().map(|(newest, _)| *newest);
    let before = match newest.filter(|_| covered_share(&known, &places, config) >= config.min_share) {
        Some(newest) => EarlierVisit::Run(newest),
        None => {
            (clouds, changes) = (Vec::new(), Vec::new());
            EarlierVisit::Map(map)
        }
    };
    Ok(Some(Baseline { map, before, clouds, changes, began_utc_ns: began, ended_utc_ns: last.utc_ns }))
}

/// Notes that a run was compared, and what it found to have changed.
///
/// # Errors
/// When the disk fails.
pub fn note_comparison(
    store: &Store,
    run: RunId,
    baseline: Option<&Baseline>,
    changes: Vec<ChangedSince>,
    problem: Option<String>,
) -> Result<(), StoreError> {
    let compared = Compared {
        format_version: 1,
        before: baseline.map(|baseline| baseline.before),
        found: changes.len(),
        problem,
        map: baseline.map(|baseline| baseline.map),
        changes,
    };
    store::write_json(&store.dir().clouds_of_run(run).join(MARKER), &compared)
}

/// What the run of these clouds found in a map; nothing if it was not compared, or the file cannot be read: then older clouds show what was before, which is found again.
fn changes_found_by(folder: &Path, map: MapId) -> Vec<ChangedSince> {
    let compared = fs::read(folder.join(MARKER)).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok());
    let of_map = compared.filter(|compared: &Compared| compared.map == Some(map));
    of_map.map(|compared| compared.changes).unwrap_or_default()
}

/// The map in which the robot was localised well when it saw a cloud.
fn map_of(entry: &RunCloudEntry) -> Option<MapId> {
    entry.place.map.filter(|_| entry.place.quality == LocalisationQuality::Good)
}

fn places_in(map: MapId, entries: &[RunCloudEntry]) -> Vec<Vec3> {
    entries.iter().filter(|entry| map_of(entry) == Some(map)).map(position).collect()
}

fn position(entry: &RunCloudEntry) -> Vec3 {
    entry.place.map_from_base.position
}

fn is_near(place: &Vec3, others: &[Vec3], within_m: f64) -> bool {
    let distance_m = |other: &Vec3| (other.x - place.x).hypot(other.y - place.y).hypot(other.z - place.z);
    others.iter().any(|other| distance_m(other) <= within_m)
}

/// Share of places at which a visit was.
fn covered_share(visit: &[Vec3], places: &[Vec3], config: &BaselineConfig) -> f64 {
    let covered = places.iter().filter(|place| is_near(place, visit, config.same_place_m)).count();
    covered as f64 / places.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use site_model::{MissionId, OrientedBox, ReportPlace};
    use store::{RunCloudCause, RunCloudsConfig};
    use uuid::Uuid;
    use vocab::{BlobHash, Covariance6, Pose, Stamp};

    const MAP: MapId = MapId(Uuid::from_u128(1));
    const OTHER_MAP: MapId = MapId(Uuid::from_u128(2));

    fn run(number: u128) -> RunId {
        RunId(Uuid::from_u128(number))
    }

    /// A run along x with a cloud every 2 m.
    fn walk(store: &Store, of: RunId, map: MapId, from_s: i64, [from_m, to_m]: [i64; 2]) {
        for step in from_m / 2..=to_m / 2 {
            let position = Vec3::new(2.0 * step as f64, 0.0, 0.5);
            let entry = RunCloudEntry {
                cloud: BlobHash([0; 32]),
                bytes: 0,
                robot_time: Stamp::from_parts(from_s + step, 0),
                utc_ns: from_s + step,
                cause: RunCloudCause::Distance,
                mission: Some(MissionId(Uuid::from_u128(3))),
                step: None,
                place: ReportPlace {
                    map: Some(map),
                    map_from_base: Pose { position, ..Pose::IDENTITY },
                    covariance: Covariance6::default(),
                    quality: LocalisationQuality::Good,
                },
                base_from_sensor_m: [0.0, 0.0, 0.25],
                points: 1,
            };
            let config = RunCloudsConfig { min_free_bytes: 0, ..RunCloudsConfig::default() };
            store.put_run_cloud(of, entry, &[[1.0, 2.0, 3.0]], &[], &config).expect("written");
        }
    }

    /// The run after which the visit before a run is named, and the runs of its clouds with their number.
    fn before(store: &Store, of: RunId) -> Option<(EarlierVisit, Vec<(RunId, usize)>)> {
        let found = find_baseline(store, of, &BaselineConfig::default()).expect("read")?;
        let mut counts: Vec<(RunId, usize)> = Vec::new();
        for (run, _) in &found.clouds {
            match counts.last_mut().filter(|(last, _)| last == run) {
                Some((_, count)) => *count += 1,
                None => counts.push((*run, 1)),
            }
        }
        Some((found.before, counts))
    }

    #[test]
    fn a_run_is_compared_with_what_was_last_seen_of_its_places_and_else_with_the_map() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let store = Store::open(dir.path()).expect("opens");
        assert_eq!(before(&store, run(10)), None, "no clouds");
        walk(&store, run(10), MAP, 1_000, [0, 20]);
        assert_eq!(before(&store, run(10)), Some((EarlierVisit::Map(MAP), Vec::new())));
        // In another map, and one that was cancelled on the way.
        walk(&store, run(11), OTHER_MAP, 2_000, [0, 20]);
        walk(&store, run(13), MAP, 4_000, [0, 6]);
        assert_eq!(before(&store, run(13)), Some((EarlierVisit::Run(run(10)), vec![(run(10), 9)])));
        walk(&store, run(14), MAP, 5_000, [0, 20]);
        let of_both = vec![(run(13), 4), (run(10), 6)];
        assert_eq!(before(&store, run(14)), Some((EarlierVisit::Run(run(13)), of_both)));
        assert_eq!(
            before(&store, run(10)),
            Some((EarlierVisit::Map(MAP), Vec::new())),
            "later ones do not count"
        );
        // Half of its places were never seen, and what is far away does not count.
        walk(&store, run(15), MAP, 6_000, [16, 40]);
        assert_eq!(before(&store, run(15)), Some((EarlierVisit::Map(MAP), Vec::new())));
        walk(&store, run(16), MAP, 7_000, [-60, -40]);
        walk(&store, run(17), MAP, 8_000, [0, 20]);
        let of_two = vec![(run(15), 8), (run(14), 7)];
        assert_eq!(before(&store, run(17)), Some((EarlierVisit::Run(run(15)), of_two)));
    }

    #[test]
    fn what_newer_runs_found_is_told_of_older_clouds() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let store = Store::open(dir.path()).expect("opens");
        for (number, extent) in [(10, [0, 20]), (11, [0, 6]), (12, [0, 20])] {
            walk(&store, run(number), MAP, 1_000 * number as i64, extent);
        }
        let place = OrientedBox { centre_m: Vec3::new(4.0, 0.0, 0.5), size_m: [0.6, 0.4, 1.0], yaw_rad: 0.2 };
        let change = ChangedSince { utc_ns: 11_000, was: None, is: Some(place) };
        let mark = |of: RunId, map: MapId| {
            let compared = Compared {
                format_version: 1,
                before: None,
                found: 1,
                problem: None,
                map: Some(map),
                changes: vec![change],
            };
            store::write_json(&store.dir().clouds_of_run(of).join(MARKER), &compared).expect("written");
        };
        let changes = || {
            let found = find_baseline(&store, run(12), &BaselineConfig::default()).expect("read");
            found.expect("it has clouds").changes
        };
        assert_eq!(changes(), []);
        mark(run(11), OTHER_MAP);
        assert_eq!(changes(), [], "in another map");
        mark(run(11), MAP);
        assert_eq!(changes(), [change]);
        // One of an earlier program says only that it was compared.
        let old = r#"{"format_version": 1, "before": null, "found": 1, "problem": null}"#;
        fs::write(store.dir().clouds_of_run(run(11)).join(MARKER), old).expect("written");
        assert_eq!(changes(), []);
    }
}
