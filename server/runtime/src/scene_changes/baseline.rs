//! What a run is compared with: the newest earlier run of its mission that went where it went, or else the map.

use site_model::{EarlierVisit, LocalisationQuality, MissionId, RunId};
use store::{RunCloudEntry, Store, StoreError};
use vocab::{MapId, Vec3};

/// Parameters of [`find_baseline`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaselineConfig {
    /// A cloud of another run within this distance was seen at the same place, metres: half more than the distance between two clouds. Chosen: runs do not
    /// keep their clouds at the same places.
    pub same_place_m: f64,
    /// Share of the clouds of a run at whose places the other run has one. Chosen, so that a run that was cancelled on the way is not what the next one is compared with.
    pub min_share: f64,
    /// Runs that are looked at, the newest first. Chosen: a hundred runs of one mission are a month and more, and the search reads their indices.
    pub max_runs: usize,
}

impl Default for BaselineConfig {
    fn default() -> Self {
        Self { same_place_m: 3.0, min_share: 0.8, max_runs: 100 }
    }
}

/// A run, and what it is compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Baseline {
    /// The map of both.
    pub map: MapId,
    /// The earlier visit.
    pub before: EarlierVisit,
    /// When the last cloud of the run was seen, nanoseconds since 1970, UTC.
    pub ended_utc_ns: i64,
}

/// What the clouds of a run are compared with; none if it has none that were seen while the robot was localised well.
///
/// # Errors
/// When the disk fails.
pub fn find_baseline(
    store: &Store,
    run: RunId,
    mission: MissionId,
    config: &BaselineConfig,
) -> Result<Option<Baseline>, StoreError> {
    let entries = store.run_clouds(run)?;
    let Some((map, last)) = entries.iter().rev().find_map(|entry| Some((map_of(entry)?, entry))) else {
        return Ok(None);
    };
    let places = places_in(map, &entries);
    let begun = entries.iter().map(|entry| entry.utc_ns).min().unwrap_or(last.utc_ns);
    let mut before = EarlierVisit::Map(map);
    for other in store.other_runs_with_clouds(run)?.into_iter().take(config.max_runs) {
        let others = store.run_clouds(other)?;
        let is_earlier = others.iter().all(|entry| entry.mission == Some(mission) && entry.utc_ns < begun);
        if is_earlier && covers(&places_in(map, &others), &places, config) {
            before = EarlierVisit::Run(other);
            break;
        }
    }
    Ok(Some(Baseline { map, before, ended_utc_ns: last.utc_ns }))
}

/// The map in which the robot was localised well when it saw a cloud.
fn map_of(entry: &RunCloudEntry) -> Option<MapId> {
    entry.place.map.filter(|_| entry.place.quality == LocalisationQuality::Good)
}

fn places_in(map: MapId, entries: &[RunCloudEntry]) -> Vec<Vec3> {
    let of_map = entries.iter().filter(|entry| map_of(entry) == Some(map));
    of_map.map(|entry| entry.place.map_from_base.position).collect()
}

/// Whether a visit was at most places of another one.
fn covers(visit: &[Vec3], places: &[Vec3], config: &BaselineConfig) -> bool {
    let distance_m = |a: &Vec3, b: &Vec3| (a.x - b.x).hypot(a.y - b.y).hypot(a.z - b.z);
    let is_covered = |place: &&Vec3| visit.iter().any(|at| distance_m(at, place) <= config.same_place_m);
    let covered = places.iter().filter(is_covered).count();
    covered as f64 >= config.min_share * places.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use site_model::ReportPlace;
    use store::{RunCloudCause, RunCloudsConfig};
    use uuid::Uuid;
    use vocab::{BlobHash, Covariance6, Pose, Stamp};

    const MAP: MapId = MapId(Uuid::from_u128(1));
    const OTHER_MAP: MapId = MapId(Uuid::from_u128(2));
    const MISSION: MissionId = MissionId(Uuid::from_u128(3));

    fn run(number: u128) -> RunId {
        RunId(Uuid::from_u128(number))
    }

    /// A run along x with a cloud every 2 m.
    fn walk(store: &Store, of: RunId, map: MapId, mission: MissionId, from_s: i64, length_m: i64) {
        for step in 0..=length_m / 2 {
            let position = Vec3::new(2.0 * step as f64, 0.0, 0.5);
            let entry = RunCloudEntry {
                cloud: BlobHash([0; 32]),
                bytes: 0,
                robot_time: Stamp::from_parts(from_s + step, 0),
                utc_ns: from_s + step,
                cause: RunCloudCause::Distance,
                mission: Some(mission),
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

    #[test]
    fn a_run_is_compared_with_the_newest_earlier_one_that_went_there_and_else_with_the_map() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let store = Store::open(dir.path()).expect("opens");
        let before = |of| {
            let found = find_baseline(&store, of, MISSION, &BaselineConfig::default()).expect("read");
            found.map(|baseline| baseline.before)
        };
        assert_eq!(before(run(10)), None, "no clouds");
        walk(&store, run(10), MAP, MISSION, 1_000, 20);
        assert_eq!(before(run(10)), Some(EarlierVisit::Map(MAP)));
        // Another map, another mission, and one that was cancelled on the way.
        walk(&store, run(11), OTHER_MAP, MISSION, 2_000, 20);
        walk(&store, run(12), MAP, MissionId(Uuid::from_u128(4)), 3_000, 20);
        walk(&store, run(13), MAP, MISSION, 4_000, 6);
        assert_eq!(before(run(13)), Some(EarlierVisit::Run(run(10))));
        walk(&store, run(14), MAP, MISSION, 5_000, 20);
        assert_eq!(before(run(14)), Some(EarlierVisit::Run(run(10))));
        assert_eq!(before(run(10)), Some(EarlierVisit::Map(MAP)), "later ones do not count");
    }
}
