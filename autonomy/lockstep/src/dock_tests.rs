//! Docks: their pose is learnt when the robot charges while it is localised. They resolve the pose where the LiDAR alone cannot.

use crate::day::{Day, FIRST, first};
use crate::replay;
use geometry::{Vector3, vec_from_plain};
use messages::{
    BatteryState, BootRecord, CommandKind, GoalKind, Input, LocalisationState, MotionState, PoseInMap,
    PriorMap, Sensor,
};
use sim::{SiteName, Start};
use stack::Stack;
use std::sync::{Arc, OnceLock};
use vocab::{Pose, SessionId, Vec3};

const LOCALISED: LocalisationState = LocalisationState::Localised { map: FIRST, degradation: None };

fn at([x, y]: [f64; 2], yaw: f64) -> Start {
    Start { position: Vec3::new(x, y, 0.0), yaw }
}

/// Runs for this number of tenths of a second, in contact with a dock that the site does not have.
fn charged(day: &mut Day, tenths: u32) {
    for _ in 0..tenths {
        let stamp = day.lockstep.now();
        let battery = BatteryState { stamp, charging: true, ..BatteryState::default() };
        day.lockstep.give(Input::Sensor(Sensor::Battery(battery)));
        day.run(0.1);
    }
}

/// The map of both rooms and the corridor between them, and its origin in the site.
fn twins() -> &'static (Arc<PriorMap>, Vector3) {
    static TWINS: OnceLock<(Arc<PriorMap>, Vector3)> = OnceLock::new();
    TWINS.get_or_init(|| {
        // The robot starts along x, so that the map has the site's heading.
        let start = at([13.0, 3.5], 0.0);
        let mut day = Day::on(SiteName::Twins, 0, start, 41, Some(SessionId(uuid::Uuid::from_u128(1))));
        day.run(1.0);
        let origin = day.true_position();
        let about = [[11.3, 2.4], [11.3, 8.9], [3.0, 8.9], [3.0, 2.4]];
        let room = |west: f64| about.map(|[x, y]| [west + x, y]);
        let corridor = [[9.0, -1.5], [43.0, -1.5], [43.0, 2.4]];
        day.drive(start, &[&room(6.0)[..], &corridor, &room(40.0)].concat());
        day.finish(FIRST);
        let Some(prior_map) = day.lockstep.map(FIRST).cloned() else { panic!("the map was not kept") };
        (prior_map, origin)
    })
}

#[test]
fn in_one_of_two_equal_rooms_the_robot_leaves_by_itself_and_finds_its_pose() {
    let (prior_map, origin) = twins();
    let mut day = Day::on(SiteName::Twins, 0, at([47.0, 8.0], 0.0), 44, None);
    day.lockstep.keep_map(Arc::clone(prior_map));
    day.command(CommandKind::Localise { map: FIRST, at: None });
    day.start_goal(GoalKind::Relocalise);
    let mut tenths = 0;
    while day.localisation != LOCALISED && tenths < 350 {
        day.run(0.1);
        tenths += 1;
    }
    // The robot had to leave by the door, 10 m away, on the shortest path: the whole search takes at most 35 s.
    assert_eq!(day.localisation, LOCALISED);
    assert!(day.error(origin) < 0.5, "{} m", day.error(origin));
    let position = day.true_position();
    assert!(position.y < 0.0 && (position.x - 43.0).abs() < 4.0, "{position}");
    assert!(
        day.localisations
            .iter()
            .any(|state| matches!(state, LocalisationState::Relocalising { hypotheses: 2.., .. }))
    );
    let again = replay(day.lockstep.log().iter().cloned(), &mut Stack::new());
    assert_eq!(again.hex(), day.lockstep.digest().hex());
}

#[test]
fn charging_at_a_known_dock_decides_between_two_equal_rooms() {
    let (prior_map, origin) = twins();
    let another_day = |docks: Arc<[PoseInMap]>| {
        let mut day = Day::on(SiteName::Twins, 0, at([47.0, 3.5], 0.0), 42, None);
        day.lockstep.keep_map(Arc::clone(prior_map));
        let boot = BootRecord { docks, ..day.lockstep.simulator().boot() };
        day.lockstep.give(Input::Boot(Box::new(boot)));
        day
    };

    let mut day = another_day(Arc::default());
    day.command(CommandKind::Localise { map: FIRST, at: None });
    charged(&mut day, 60);
    let LocalisationState::Relocalising { hypotheses: 2.., .. } = day.localisation else {
        panic!("no dock is stored: {:?}", day.localisation)
    };
    // The dock's stored pose is about 0.2 m wrong, as if somebody had pushed the dock.
    let position = Vec3::new(47.2 - origin.x, 3.4 - origin.y, 0.0);
    let dock = PoseInMap { map: FIRST, map_from_base: Pose { position, ..Pose::IDENTITY } };
    let mut day = another_day(Arc::from([dock]));
    day.command(CommandKind::Localise { map: FIRST, at: None });
    day.run(3.0);
    assert!(matches!(day.localisation, LocalisationState::Relocalising { .. }), "not charged yet");
    day.start_goal(GoalKind::Relocalise);
    charged(&mut day, 30);
    assert_eq!(day.motion, MotionState::Idle, "the search must end once the pose is known");
    assert_eq!(day.localisation, LOCALISED);
    // The map itself is wrong by a third of a metre here, because it was made along a bare corridor. The other room is 34 m away.
    assert!(day.error(origin) < 0.5, "{} m", day.error(origin));
}

#[test]
fn a_localised_robot_learns_the_dock_at_which_it_charges() {
    let (prior_map, _, origin) = first();
    let dock = Vec3::new(16.4, 23.5, 0.0);
    let mut day = Day::begin(Start { position: dock, yaw: 0.0 }, 43, None);
    day.lockstep.keep_map(Arc::clone(prior_map));
    day.run(6.0);
    assert!(day.docks.is_empty(), "no dock must be learnt without a map");
    day.command(CommandKind::Localise { map: FIRST, at: None });
    day.run(8.0);
    assert_eq!(day.localisation, LOCALISED);
    let [learnt] = day.docks[..] else { panic!("{:?}", day.docks) };
    assert_eq!(learnt.map, FIRST);
    let off = vec_from_plain(learnt.map_from_base.position) + origin - vec_from_plain(dock);
    assert!(off.xy().norm() < 0.1, "{off}");
}
