//! Extending a saved map: from its end, and from anywhere in it on another day.

use crate::day::{Day, FIRST, first};
use crate::replay;
use geometry::vec_from_plain;
use messages::{CommandKind, MappingState};
use sim::{SimulatedSite, SiteName, Start};
use stack::Stack;
use std::sync::Arc;
use uuid::Uuid;
use vocab::{MapId, SessionId, Vec3};

const LARGER: MapId = MapId(Uuid::from_u128(6));

#[test]
fn on_another_day_the_robot_localises_in_the_map_and_adds_only_new_ground() {
    let (prior_map, finished, origin) = first();
    let old = finished.graph.nodes.len();
    assert_eq!(prior_map.keyframes.len(), old);
    let start = Start { position: Vec3::new(29.0, 21.5, 0.0), yaw: -1.5 };
    let mut day = Day::begin(start, 4, None);
    day.lockstep.keep_map(Arc::clone(prior_map));
    day.command(CommandKind::ExtendMap { session: SessionId(Uuid::from_u128(2)), map: FIRST });
    day.run(3.0);
    assert!(matches!(day.mapping, MappingState::Finding { map: FIRST, .. }), "{:?}", day.mapping);
    assert!(day.states.iter().any(|state| matches!(state, MappingState::Loading { map: FIRST, .. })));
    day.command(CommandKind::FinishMapping { map: LARGER, name: "Early".to_owned() });
    day.run(0.2);
    assert_eq!(day.refusals.len(), 1, "finishing must be refused before localisation");
    assert!(day.refusals.drain(..).all(|reason| reason.contains("not localised in that map")));

    // Through mapped ground, then into the corridor, which is not mapped.
    let known_part = [[29.0, 17.2], [21.0, 17.2], [21.0, 23.0], [18.2, 23.5]];
    day.drive(start, &known_part);
    assert!(matches!(day.mapping, MappingState::Mapping { extends: Some(FIRST), .. }), "{:?}", day.mapping);
    assert!(day.error(origin) < 0.08, "{} m", day.error(origin));
    let before = day.graph.nodes.len();
    assert!(before <= old + 6, "{before} keyframes, {old} of them old");
    let at = |[x, y]: [f64; 2]| Start { position: Vec3::new(x, y, 0.0), yaw: 0.0 };
    day.drive(at(known_part[3]), &[[15.4, 21.6], [15.4, 20.0], [12.5, 20.0], [12.5, 30.0]]);
    assert!(day.error(origin) < 0.1, "{} m", day.error(origin));
    let larger = day.finish(LARGER);
    assert!(larger.graph.nodes.len() >= before + 10, "{} keyframes", larger.graph.nodes.len());
    assert_eq!(larger.extends, Some(FIRST));
    for (old, now) in finished.graph.nodes.iter().zip(&larger.graph.nodes) {
        let [a, b] = [old, now].map(|node| vec_from_plain(node.map_from_keyframe.position));
        assert!((a - b).norm() < 0.03, "{:?} has moved by {} m", old.id, (a - b).norm());
        assert_eq!((old.id, old.stamp), (now.id, now.stamp));
    }
    // The trajectory holds the walk of that day only, in the map's frame.
    let (_, began) = larger.trajectory[0];
    let error = (vec_from_plain(began.position) + origin - vec_from_plain(start.position)).xy().norm();
    assert!(error < 0.3, "the trajectory begins {error} m from the true start");
    let again = replay(day.lockstep.log().iter().cloned(), &mut Stack::new());
    assert_eq!(again.hex(), day.lockstep.digest().hex());
}

#[test]
fn a_map_that_was_just_saved_is_extended_without_relocalisation() {
    let Some(route) = SimulatedSite::new(SiteName::B1).route("short").cloned() else {
        panic!("no such route")
    };
    let mut day = Day::begin(route.start, 5, Some(SessionId(Uuid::from_u128(1))));
    day.drive(route.start, &route.waypoints[..1]);
    let keyframes = day.finish(FIRST).graph.nodes.len();
    let position = day.estimate.position;
    day.command(CommandKind::ExtendMap { session: SessionId(Uuid::from_u128(2)), map: FIRST });
    day.run(1.5);
    assert!(matches!(day.mapping, MappingState::Mapping { extends: Some(FIRST), .. }), "{:?}", day.mapping);
    assert!((vec_from_plain(day.estimate.position) - vec_from_plain(position)).norm() < 0.03);
    let at = |[x, y]: [f64; 2]| Start { position: Vec3::new(x, y, 0.0), yaw: 0.0 };
    day.drive(at(route.waypoints[0]), &[[26.0, 23.2]]);
    assert!(day.finish(LARGER).graph.nodes.len() >= keyframes + 5);
}

#[test]
fn a_map_that_cannot_be_read_starts_no_session() {
    let start = Start { position: Vec3::new(29.0, 21.5, 0.0), yaw: -1.5 };
    let mut day = Day::begin(start, 4, None);
    let mut broken = first().0.as_ref().clone();
    broken.keyframes.pop();
    day.lockstep.keep_map(Arc::new(broken));
    for map in [FIRST, LARGER] {
        day.command(CommandKind::ExtendMap { session: SessionId(Uuid::from_u128(2)), map });
        day.run(1.0);
        assert_eq!(day.mapping, MappingState::Idle);
    }
    let loading = day.states.iter().filter(|state| matches!(state, MappingState::Loading { .. })).count();
    assert_eq!((loading, day.refusals.len()), (2, 0));
}
