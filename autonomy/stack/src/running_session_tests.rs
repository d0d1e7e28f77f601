//! A session of a standing robot: its first keyframe, its graph as it is published, and loops that are left open.

use super::*;
use crate::testing::{lidar_only, located_scans};
use uuid::Uuid;

const SESSION: SessionId = SessionId(Uuid::from_u128(1));

/// A session with the scans of a standing robot, and its updates.
fn session(record: &BootRecord) -> (RunningSession, Vec<MapUpdate>) {
    let scans = located_scans();
    let first = scans.first().unwrap_or_else(|| panic!("no scan"));
    let config = RunningSessionConfig::new(record);
    let mut session = RunningSession::begin(SESSION, None, first, &config, [0.0; 3]);
    assert!(session.is_empty() && session.whole_graph().is_none(), "nothing was published yet");
    let mut updates = Vec::new();
    for located in &scans {
        session.add(located);
        updates.extend(session.process_waypoint(None));
        assert!(session.process_waypoint(None).is_none(), "a waypoint is added once");
    }
    (session, updates)
}

#[test]
fn the_first_scan_is_a_keyframe_and_the_graph_is_published_whole_once() {
    let (mut session, updates) = session(&lidar_only());
    let [MapUpdate::Keyframe { keyframe, graph, .. }] = updates.as_slice() else {
        panic!("{} updates", updates.len())
    };
    assert_eq!((keyframe.session, keyframe.id), (SESSION, KeyframeId(0)));
    assert!(!keyframe.cloud.xyz.is_empty() && keyframe.cloud.xyz.len() == keyframe.cloud.intensity.len());
    let scan = &located_scans()[0].cloud;
    assert!(keyframe.cloud.xyz.len() < scan.xyz.len(), "it is thinned");
    assert!(matches!(graph, Some(Publication::Graph { session: SESSION, .. })));
    assert!(session.graph_changes().is_none(), "nothing has changed since");
    assert!(matches!(session.whole_graph(), Some(Publication::Graph { .. })), "asked for anew");
    let MappingState::Mapping { extends, keyframes, .. } = session.state() else {
        panic!("{:?}", session.state())
    };
    assert_eq!((extends, keyframes), (None, 1));
    let map = session.finished_map(MapId(Uuid::from_u128(3)), "Hall".to_owned(), Stamp::from_parts(20, 0));
    assert_eq!((map.session, map.graph.nodes.len(), map.extends), (SESSION, 1, None));
    assert!(!map.trajectory.is_empty());
}

#[test]
fn without_loops_nothing_is_compared_and_commands_about_loops_are_refused() {
    let record = BootRecord { leave_loops_open: true, ..lidar_only() };
    let (mut session, updates) = session(&record);
    assert_eq!(updates.len(), 1);
    let (mut jobs, mut effects) = (0, Vec::new());
    session.start_jobs(&mut jobs, &mut effects);
    assert!(effects.is_empty() && !session.is_comparing() && !session.finish_loops());
    assert!(session.start_quality(Stamp::from_parts(100, 0), 0).is_none());
    let reject = CommandKind::RejectLoop { from: KeyframeId(0), to: KeyframeId(1) };
    assert_eq!(session.handle_loop_command(&reject).err(), Some(texts::NO_MAPPING_WITH_LOOPS.to_owned()));
}

#[test]
fn a_guess_that_is_no_pose_and_keyframes_that_are_not_there_are_refused() {
    let (mut session, _) = session(&lidar_only());
    let (from, to) = (KeyframeId(0), KeyframeId(9));
    let mut guess = Pose::IDENTITY;
    let missing = CommandKind::ProposeLoop { from, to, guess };
    assert!(session.handle_loop_command(&missing).is_err());
    guess.position.x = f64::NAN;
    let not_finite = CommandKind::ProposeLoop { from, to, guess };
    let refused = session.handle_loop_command(&not_finite).err();
    assert_eq!(refused, Some(texts::LOOP_GUESS_NOT_FINITE.to_owned()));
}
