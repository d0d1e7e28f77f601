//! The life of a session: from the first scan to the saved map, and what is refused on the way.

use super::*;
use crate::testing::{lidar_only, located_scans};
use uuid::Uuid;

const SESSION: SessionId = SessionId(Uuid::from_u128(1));
const OTHER: SessionId = SessionId(Uuid::from_u128(2));
const MAP: MapId = MapId(Uuid::from_u128(3));

fn failure() -> JobFailure {
    JobFailure { reason: "the disk is full".to_owned() }
}

/// A session of a standing robot, which has one keyframe.
fn mapping() -> MappingPhase {
    let mut phase = MappingPhase::new(&lidar_only());
    assert_eq!(phase.start(SESSION), Ok(()));
    for located in located_scans() {
        phase.add(&located);
        let _ = phase.process_waypoint();
    }
    assert!(matches!(phase.changed(), Some(MappingState::Mapping { session: SESSION, keyframes: 1, .. })));
    phase
}

/// The job that saves the map of a session that ends.
fn saving_job(phase: &mut MappingPhase) -> u64 {
    let (mut jobs, mut effects) = (10, Vec::new());
    phase.close(Stamp::from_parts(20, 0), &mut jobs, &mut effects);
    let is_relinearised =
        matches!(effects.as_slice(), [StackEffect::StartJob { work: Job::Relinearise(SESSION), .. }]);
    if is_relinearised {
        // It was not done: the poses stay as they were, and the map is saved all the same.
        let warning = phase.finish_relinearisation(10, &Err(failure()), &mut effects);
        assert!(warning.is_some_and(|text| text.contains("the disk is full")));
    }
    match effects.last() {
        Some(StackEffect::StartJob { job, work: Job::SaveMap(map) }) => {
            assert_eq!((map.map, map.name.as_str(), map.graph.nodes.len()), (MAP, "Hall", 1));
            job.number
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn there_is_one_session_at_a_time() {
    let mut phase = MappingPhase::new(&lidar_only());
    assert_eq!(phase.discard(), Err(texts::NO_MAPPING.to_owned()));
    assert_eq!(phase.start(SESSION), Ok(()));
    assert_eq!(phase.start(SESSION), Ok(()), "the same one, asked for twice");
    assert_eq!(phase.start(OTHER), Err(texts::MAPPING_RUNS.to_owned()));
    assert_eq!(phase.extend(OTHER, MAP), Err(texts::MAPPING_RUNS.to_owned()));
    assert!(phase.is_starting());
    assert_eq!(phase.discard(), Ok(()));
    assert!(phase.is_idle());
}

#[test]
fn a_finished_map_is_saved_and_a_save_that_fails_lets_the_session_go_on() {
    let mut phase = mapping();
    let at = Stamp::from_parts(11, 0);
    assert_eq!(phase.finish(at, MAP, " "), Err(texts::MAP_NEEDS_NAME.to_owned()));
    assert_eq!(phase.finish(at, MAP, "Hall"), Ok(()));
    assert!(matches!(phase.changed(), Some(MappingState::Saving { session: SESSION, map: MAP })));
    let job = saving_job(&mut phase);
    assert_eq!(phase.discard(), Err(texts::MAP_SAVING_CANNOT_DISCARD.to_owned()));
    assert_eq!(phase.start(OTHER), Err(texts::MAP_STILL_SAVING.to_owned()));
    assert!(!phase.finish_saving(job + 1, &Ok(MAP)), "another job");
    assert!(phase.finish_saving(job, &Err(failure())));
    assert!(matches!(phase.changed(), Some(MappingState::Mapping { .. })));

    assert_eq!(phase.finish(at, MAP, "Hall"), Ok(()));
    let job = saving_job(&mut phase);
    assert!(phase.finish_saving(job, &Ok(MAP)));
    assert!(phase.is_idle());
    let last = located_scans().pop().unwrap_or_else(|| panic!("no scan"));
    assert!(
        phase.map_from_odom_of(MAP, &last).is_some(),
        "the robot knows its pose in what it has just made"
    );
    assert!(phase.map_from_odom_of(MapId(Uuid::from_u128(4)), &last).is_none());
}

#[test]
fn an_empty_map_is_not_saved() {
    let mut phase = MappingPhase::new(&lidar_only());
    let at = Stamp::from_parts(11, 0);
    assert_eq!(phase.finish(at, MAP, "Hall"), Err(texts::NO_MAPPING.to_owned()));
    assert_eq!(phase.start(SESSION), Ok(()));
    assert_eq!(phase.finish(at, MAP, "Hall"), Err(texts::NO_MAPPING.to_owned()));
}

#[test]
fn a_map_that_cannot_be_read_is_not_extended() {
    let mut phase = MappingPhase::new(&lidar_only());
    assert_eq!(phase.extend(SESSION, MAP), Ok(()));
    assert!(matches!(phase.changed(), Some(MappingState::Loading { session: SESSION, map: MAP })));
    let (mut jobs, mut effects) = (4, Vec::new());
    phase.start_jobs(&mut jobs, &mut effects);
    phase.start_jobs(&mut jobs, &mut effects);
    assert_eq!((jobs, effects.len()), (5, 1), "one job reads it");
    assert_eq!(phase.finish_loading(9, &Err(failure()), None), Ok(()), "another job");
    assert!(
        phase.finish_loading(4, &Err(failure()), None).is_err_and(|text| text.contains("the disk is full"))
    );
    assert!(phase.is_idle());

    let mut phase = MappingPhase::new(&BootRecord { leave_loops_open: true, ..lidar_only() });
    assert_eq!(phase.extend(SESSION, MAP), Err(texts::EXTENDING_NEEDS_LOOPS.to_owned()));
}

#[test]
fn results_that_nobody_waits_for_change_nothing() {
    let mut phase = MappingPhase::new(&lidar_only());
    let mut effects = Vec::new();
    assert!(!phase.finish_comparison(1, &Err(failure())).is_graph_changed);
    assert!(!phase.finish_search(1, &Err(failure())).is_localised);
    assert_eq!(phase.finish_relinearisation(1, &Err(failure()), &mut effects), None);
    assert!(!phase.finish_saving(1, &Ok(MAP)) && effects.is_empty() && phase.is_idle());
    let accept = CommandKind::AcceptLoop { from: vocab::KeyframeId(0), to: vocab::KeyframeId(1) };
    assert_eq!(phase.handle_loop_command(&accept).err(), Some(texts::NO_MAPPING_WITH_LOOPS.to_owned()));
}
