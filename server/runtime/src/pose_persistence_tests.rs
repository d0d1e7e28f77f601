//! What is on disk after each change of localisation.

use super::*;
use messages::DegradationReason;
use uuid::Uuid;
use vocab::{Pose, Vec3};

fn at(x: f64) -> Estimate {
    let map_from_base = Pose { position: Vec3::new(x, 0.0, 0.5), ..Pose::IDENTITY };
    Estimate { map_from_base, ..Estimate::default() }
}

#[test]
fn the_last_certain_pose_is_on_disk_while_its_map_exists() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = Arc::new(Store::open(dir.path()).expect("store"));
    let (map, now) = (MapId(Uuid::from_u128(3)), Instant::now());
    let later = |seconds| now + Duration::from_secs(seconds);
    let mut persistence = PosePersistence::new(PosePersistenceConfig::default(), Arc::clone(&store));
    persistence.update(now, &at(1.0));
    assert!(!store.dir().last_pose().exists(), "the robot was not localised");
    persistence.set_localisation(&LocalisationState::Localised { map, degradation: None });
    persistence.update(now, &at(2.0));
    assert_eq!(store.last_pose(), None, "there is no such map");
    let summary = store.dir().map_summary(map);
    std::fs::create_dir_all(store.dir().map(map)).expect("made");
    std::fs::write(summary, "{}").expect("written");
    let saved_x = || store.last_pose().map(|pose| pose.map_from_base.position.x);
    assert_eq!(saved_x(), Some(2.0));
    persistence.update(later(1), &at(2.4));
    assert_eq!(saved_x(), Some(2.0), "the period has not passed");
    persistence.update(now + Duration::from_millis(50), &at(2.6));
    assert_eq!(saved_x(), Some(2.0), "the disk was just written");
    persistence.update(now + Duration::from_millis(150), &at(2.6));
    assert_eq!(saved_x(), Some(2.6), "the robot walks");
    let mut turned = at(2.6);
    turned.map_from_base.orientation = vocab::Quat { w: 0.995, x: 0.0, y: 0.0, z: 0.0998 };
    persistence.update(now + Duration::from_millis(300), &turned);
    assert_eq!(store.last_pose().map(|pose| pose.map_from_base), Some(turned.map_from_base));
    persistence.update(later(3), &at(3.0));
    let unconfirmed = Some(DegradationReason::Unconfirmed);
    persistence.set_localisation(&LocalisationState::Localised { map, degradation: unconfirmed });
    persistence.update(later(5), &at(4.0));
    persistence.set_localisation(&LocalisationState::Localised {
        map,
        degradation: Some(DegradationReason::LidarBlind),
    });
    persistence.update(later(9), &at(5.0));
    persistence.set_localisation(&LocalisationState::Relocalising { map, hypotheses: 0 });
    persistence.update(later(19), &at(6.0));
    assert_eq!(saved_x(), Some(4.0), "the last pose with nothing against it but that it is not confirmed");
    std::fs::write(store.dir().last_pose(), "nonsense").expect("written");
    assert_eq!(saved_x(), None);
    persistence.set_localisation(&LocalisationState::Idle);
    assert!(!store.dir().last_pose().exists());
}

#[test]
fn the_last_pose_stays_when_its_map_cannot_be_read() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = Arc::new(Store::open(dir.path()).expect("store"));
    let map = MapId(Uuid::from_u128(3));
    std::fs::create_dir_all(store.dir().map(map)).expect("made");
    let pose = PoseInMap { map, map_from_base: Pose::IDENTITY };
    store.save_last_pose(Some(&pose)).expect("saved");
    let mut persistence = PosePersistence::new(PosePersistenceConfig::default(), Arc::clone(&store));
    persistence.set_localisation(&LocalisationState::Loading { map });
    persistence.set_localisation(&LocalisationState::Idle);
    assert_eq!(store.last_pose(), Some(pose));
    persistence.set_localisation(&LocalisationState::Relocalising { map, hypotheses: 0 });
    persistence.set_localisation(&LocalisationState::Idle);
    assert_eq!(store.last_pose(), None);
}

#[test]
fn docks_of_deleted_maps_are_left_out() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = Arc::new(Store::open(dir.path()).expect("store"));
    let persistence = PosePersistence::new(PosePersistenceConfig::default(), Arc::clone(&store));
    let map = MapId(Uuid::from_u128(3));
    std::fs::create_dir_all(store.dir().map(map)).expect("made");
    std::fs::write(store.dir().map_summary(map), "{}").expect("written");
    assert_eq!(store.docks(), []);
    let dock = PoseInMap { map, map_from_base: Pose::IDENTITY };
    let deleted = PoseInMap { map: MapId(Uuid::from_u128(4)), ..dock };
    persistence.save_docks(&[dock, deleted]);
    assert_eq!(store.docks(), [dock]);
    std::fs::write(store.dir().docks(), "nonsense").expect("written");
    assert_eq!(store.docks(), []);
}
