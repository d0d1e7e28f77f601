//! Which map is in use, and which job reads it. How the pose is found in it is tested in `localisation`.

use super::*;
use uuid::Uuid;

const MAP: MapId = MapId(Uuid::from_u128(1));

fn failure() -> Result<Arc<PriorMap>, JobFailure> {
    Err(JobFailure { reason: "it was deleted".to_owned() })
}

/// The phase while its map is read, and the job that reads it.
fn loading() -> (LocalisationPhase, u64) {
    let mut phase = LocalisationPhase::default();
    phase.start(MAP, None);
    let (mut jobs, mut effects) = (7, Vec::new());
    phase.start_jobs(&mut jobs, &mut effects);
    phase.start_jobs(&mut jobs, &mut effects);
    let [StackEffect::StartJob { job, work: Job::ReadMap(MAP) }] = effects.as_slice() else {
        panic!("{effects:?}")
    };
    let number = job.number;
    (phase, number)
}

#[test]
fn while_the_map_is_read_the_pose_is_wanted_and_not_known() {
    let mut phase = LocalisationPhase::default();
    assert!(phase.is_idle() && !phase.is_unconfirmed());
    assert_eq!(phase.take_changed_state(), Some(LocalisationState::Idle));
    assert_eq!(phase.take_changed_state(), None, "it has not changed");
    let (mut phase, _) = loading();
    assert!(!phase.is_idle() && phase.is_unconfirmed() && !phase.is_localised());
    assert_eq!(phase.take_changed_state(), Some(LocalisationState::Loading { map: MAP }));
    assert!(phase.map_from_odom().is_none() && phase.localised_map().is_none());
    assert!(phase.take_compute_job(7).is_none());
}

#[test]
fn a_map_that_cannot_be_read_leaves_the_robot_in_none() {
    let (mut phase, job) = loading();
    assert_eq!(phase.finish_loading(job + 1, &failure(), None), Ok(()), "another job");
    assert!(!phase.is_idle());
    let refused = phase.finish_loading(job, &failure(), None);
    assert!(refused.is_err_and(|text| text.contains("it was deleted")));
    assert!(phase.is_idle());
}

#[test]
fn a_map_that_is_not_wanted_any_more_is_ignored() {
    let (mut phase, job) = loading();
    phase.stop();
    assert_eq!(phase.finish_loading(job, &failure(), None), Ok(()));
    assert_eq!(phase.take_changed_state(), Some(LocalisationState::Idle));
    let no_answer = Err(JobFailure { reason: "it took too long".to_owned() });
    assert!(phase.finish_relocalisation(job, &no_answer).is_none());
    // Another map is read by a job of its own.
    phase.start(MapId(Uuid::from_u128(2)), None);
    let (mut jobs, mut effects) = (job + 1, Vec::new());
    phase.start_jobs(&mut jobs, &mut effects);
    assert_eq!((jobs, effects.len()), (job + 2, 1));
}

#[test]
fn docks_are_the_same_after_they_were_registered() {
    let docks = [PoseInMap { map: MAP, map_from_base: vocab::Pose::IDENTITY }];
    assert_eq!(plain_docks(&dock_registry(&docks)).as_ref(), docks);
}
