//! Writes the robot's place in the map in use and the docks to disk. When the robot is switched on again, it is localised there.

use messages::{Estimate, LocalisationState, PoseInMap};
use std::sync::Arc;
use std::time::{Duration, Instant};
use store::Store;
use vocab::MapId;

/// Time between writes. A robot walks two metres in it.
const EVERY: Duration = Duration::from_secs(2);

/// Follows what is published, and writes.
pub struct PlaceKeeper {
    store: Arc<Store>,
    /// The map in which the robot knows its place now.
    known: Option<MapId>,
    kept: Option<(Instant, PoseInMap)>,
}

impl PlaceKeeper {
    /// Writes to that store.
    pub fn new(store: Arc<Store>) -> Self {
        Self { store, known: None, kept: None }
    }

    /// A robot that has lost its place is found where it was last; one that has left its map is in none.
    pub fn follow(&mut self, state: &LocalisationState) {
        self.known = match state {
            LocalisationState::Localised { map, degradation: None } => Some(*map),
            _ => None,
        };
        if *state == LocalisationState::Idle {
            self.kept = None;
            self.write(None);
        }
    }

    /// Takes down where the robot is, if it knows.
    pub fn note(&mut self, now: Instant, estimate: &Estimate) {
        let Some(map) = self.known else { return };
        let place = PoseInMap { map, map_from_base: estimate.map_from_base };
        if self.kept.is_none_or(|(at, kept)| now >= at + EVERY && kept != place) {
            self.kept = Some((now, place));
            self.write(Some(&place));
        }
    }

    /// Keeps where docks are.
    pub fn save_docks(&self, docks: &[PoseInMap]) {
        if let Err(error) = self.store.save_docks(docks) {
            tracing::warn!("where docks are cannot be kept: {error}");
        }
    }

    fn write(&self, place: Option<&PoseInMap>) {
        if let Err(error) = self.store.save_last_pose(place) {
            tracing::warn!("where the robot is cannot be kept: {error}");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::DegradationReason;
    use uuid::Uuid;
    use vocab::{Pose, Vec3};

    fn at(x: f64) -> Estimate {
        let map_from_base = Pose { position: Vec3::new(x, 0.0, 0.5), ..Pose::IDENTITY };
        Estimate { map_from_base, ..Estimate::default() }
    }

    #[test]
    fn the_last_place_that_was_known_is_found_again_while_its_map_exists() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let store = Arc::new(Store::open(dir.path()).expect("store"));
        let (map, now) = (MapId(Uuid::from_u128(3)), Instant::now());
        let later = |seconds| now + Duration::from_secs(seconds);
        let mut keeper = PlaceKeeper::new(Arc::clone(&store));
        keeper.note(now, &at(1.0));
        assert!(!store.dir().last_pose().exists(), "nobody knew");
        keeper.follow(&LocalisationState::Localised { map, degradation: None });
        keeper.note(now, &at(2.0));
        assert_eq!(store.last_pose(), None, "there is no such map");
        let summary = store.dir().map_summary(map);
        std::fs::create_dir_all(store.dir().map(map)).expect("made");
        std::fs::write(summary, "{}").expect("written");
        let kept = || store.last_pose().map(|place| place.map_from_base.position.x);
        assert_eq!(kept(), Some(2.0));
        keeper.note(later(1), &at(3.0));
        assert_eq!(kept(), Some(2.0), "not so often");
        keeper.note(later(2), &at(4.0));
        keeper
            .follow(&LocalisationState::Localised { map, degradation: Some(DegradationReason::LidarBlind) });
        keeper.note(later(9), &at(5.0));
        keeper.follow(&LocalisationState::Relocalising { map, hypotheses: 0 });
        keeper.note(later(19), &at(6.0));
        assert_eq!(kept(), Some(4.0), "where it was last sure");
        std::fs::write(store.dir().last_pose(), "nonsense").expect("written");
        assert_eq!(kept(), None);
        keeper.follow(&LocalisationState::Idle);
        assert!(!store.dir().last_pose().exists());
        assert_eq!(store.docks(), []);
        let dock = PoseInMap { map, map_from_base: Pose::IDENTITY };
        let gone = PoseInMap { map: MapId(Uuid::from_u128(4)), ..dock };
        keeper.save_docks(&[dock, gone]);
        assert_eq!(store.docks(), [dock], "of maps that are there");
        std::fs::write(store.dir().docks(), "nonsense").expect("written");
        assert_eq!(store.docks(), []);
    }
}
