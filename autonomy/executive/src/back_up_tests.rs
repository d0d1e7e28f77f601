//! The last steps into a pose, and paths, beside which something was seen that has gone, or that stands there.

use crate::BackUpConfig;
use crate::back_up::back_up_point;
use crate::tests::{Rig, post, room, shifted};
use geometry::{Vector3, pose_from_isometry};
use messages::{Approach, GoalKind, GoalStatus, PoseGoal, Publication, StackEffect};
use navigation::{ElevationMap, RobotShape};
use site_model::PoseTolerance;

/// Where the robot is to stand, and where a person stands for a moment when it comes, metres.
const GOAL: [f64; 2] = [2.0, 0.0];
const PERSON: [f64; 2] = [2.3, 0.0];

/// The robot sees nothing nearer than this: neither the ground beside it nor what stands there, metres.
const BLIND_M: f64 = 1.3;

/// From beside the person's place, no ray passes within this angle of it, radians: rays there are too high.
const HIDDEN_RAD: f64 = 1.0;

/// Begins a walk into a pose at a point, metres.
fn start_walk(rig: &mut Rig, [x, y]: [f64; 2]) {
    let goal = PoseGoal {
        map_from_goal: pose_from_isometry(&shifted(x, y)),
        tolerance: Some(PoseTolerance::default()),
        max_speed_m_s: None,
        approach: Approach::Path,
    };
    rig.start(GoalKind::WalkToPose(goal)).unwrap();
}

/// The outcome of the goal in the last step, if it came.
fn outcome(rig: &Rig) -> Option<GoalStatus> {
    rig.effects.iter().find_map(|effect| match effect {
        StackEffect::Publish(Publication::Goal(update)) if update.status.is_outcome() => {
            Some(update.status.clone())
        }
        _ => None,
    })
}

/// Lets the robot walk to the goal. Whether the person stays. Returns the goal's outcome, and the greatest distance from the goal after the robot was beside it, metres.
fn walk(stays: bool) -> (GoalStatus, f64) {
    let mut rig = Rig::in_room(shifted(0.0, 0.0));
    start_walk(&mut rig, GOAL);
    let person = Vector3::new(PERSON[0], PERSON[1], 0.0);
    let mut seen_beside = 0_u32;
    let mut farthest_m = 0.0_f64;
    for _ in 0..2_000 {
        let here = rig.position();
        let distance_m = (here.x - GOAL[0]).hypot(here.y - GOAL[1]);
        // The person is seen for half a second from half a metre.
        let is_seen = distance_m < 0.5 && seen_beside < 10;
        seen_beside += u32::from(is_seen);
        if seen_beside == 10 {
            farthest_m = farthest_m.max(distance_m);
        }
        let is_beside = (person - here).xy().norm() < BLIND_M;
        let is_in_view = |point: &[f32; 3]| {
            let offset = [f64::from(point[0]) - here.x, f64::from(point[1]) - here.y];
            let bearing_rad = offset[1].atan2(offset[0]);
            let is_behind_person = is_beside && bearing_rad.abs() < HIDDEN_RAD;
            offset[0].hypot(offset[1]) > BLIND_M && !is_behind_person
        };
        rig.points = room().into_iter().filter(is_in_view).collect();
        if is_seen || (stays && !is_beside) {
            rig.points.extend(post(&person));
        }
        rig.effects.clear();
        rig.step(&|_| true);
        if let Some(outcome) = outcome(&rig) {
            return (outcome, farthest_m);
        }
    }
    panic!("the goal has no outcome within 100 s");
}

#[test]
fn a_robot_steps_back_from_what_has_gone_and_reaches_its_pose() {
    let (status, farthest_m) = walk(false);
    assert!(matches!(status, GoalStatus::Succeeded { .. }), "{status:?}");
    assert!(farthest_m > 1.5, "it was at most {farthest_m} m from the pose");
}

#[test]
fn a_robot_does_not_step_back_onto_stairs() {
    let shape = RobotShape { radius_m: 0.36, standing_height_m: 0.5, clearance_m: 0.95, step_m: 0.22 };
    let look = |height_m: f32| {
        let mut map = ElevationMap::new(0.1, shape);
        let ground = (-40..=40_i8).flat_map(|x| (-40..=40_i8).map(move |y| (x, y)));
        // In the middle of each cell.
        let middle = |cell: i8| 0.1 * f32::from(cell) + 0.05;
        let height = |x: i8| if x < -7 { height_m - 0.5 } else { -0.5 };
        let points: Vec<[f32; 3]> = ground.map(|(x, y)| [middle(x), middle(y), height(x)]).collect();
        map.insert_scan(&shifted(0.0, 0.0), [0.0; 3], &points, 10.0);
        back_up_point(&BackUpConfig::default(), &map, &Vector3::zeros(), &Vector3::new(0.3, 0.0, 0.0))
    };
    let level = look(0.0).expect("room behind the robot");
    assert!(level.x < -2.3, "straight back over level ground, not to {level}");
    let beside = look(0.17).expect("room beside the robot");
    assert!(beside.x > -0.8, "not over the step, but to {beside}");
}

#[test]
fn a_pose_beside_something_that_stays_is_not_reached() {
    let (status, farthest_m) = walk(true);
    assert!(matches!(status, GoalStatus::Failed { .. }), "{status:?}");
    assert!(farthest_m > 1.5, "it was at most {farthest_m} m from the pose");
}

/// Where people stand side by side across a corridor when the robot is about to walk through it, metres.
const ROW_X: f64 = 0.9;
/// The same where the robot sees them all the time.
const FAR_ROW_X: f64 = 2.7;
const ROW_Y: [f64; 5] = [-0.8, -0.4, 0.0, 0.4, 0.8];

/// Lets the robot walk through the corridor past people at `row_x`, metres. Whether they stay. Returns the goal's outcome, and how far the robot went back, metres.
fn walk_through_corridor(row_x: f64, stays: bool) -> (GoalStatus, f64) {
    let walls: Vec<[f32; 3]> = (-40..=40_i8)
        .flat_map(|x| [-1.2, 1.2].map(|y| (0.1 * f32::from(x), y)))
        .flat_map(|(x, y)| [-0.2, 0.0, 0.2].map(|z| [x, y, z]))
        .collect();
    let row = ROW_Y.map(|y| post(&Vector3::new(row_x, y, 0.0)).collect::<Vec<_>>()).concat();
    let mut rig = Rig::new();
    rig.points.extend(&walls);
    // In the middle of each cell.
    let middle = |cell: i8| 0.1 * f32::from(cell) + 0.05;
    rig.points.extend((-40..40_i8).flat_map(|x| (-12..12_i8).map(move |y| [middle(x), middle(y), -0.5])));
    rig.run(1.0, &|_| true);
    start_walk(&mut rig, [3.4, 0.0]);
    let mut back_m = 0.0_f64;
    for step in 0..2_000 {
        let here = rig.position();
        back_m = back_m.max(-here.x);
        let is_beside = (row_x - here.x).abs() < BLIND_M;
        let is_in_view = |point: &[f32; 3]| {
            let offset = [f64::from(point[0]) - here.x, f64::from(point[1]) - here.y];
            let is_behind_row = is_beside && offset[1].atan2(offset[0]).abs() < HIDDEN_RAD;
            offset[0].hypot(offset[1]) > BLIND_M && !is_behind_row
        };
        rig.points = room().into_iter().filter(is_in_view).chain(walls.iter().copied()).collect();
        if step < 10 || (stays && !is_beside) {
            rig.points.extend(&row);
        }
        rig.effects.clear();
        rig.step(&|_| true);
        if let Some(outcome) = outcome(&rig) {
            return (outcome, back_m);
        }
    }
    panic!("the goal has no outcome within 100 s");
}

#[test]
fn a_robot_steps_back_from_people_who_have_gone_and_walks_on() {
    let (status, back_m) = walk_through_corridor(ROW_X, false);
    assert!(matches!(status, GoalStatus::Succeeded { .. }), "{status:?}");
    assert!(back_m > 0.7, "it went {back_m} m back");
}

#[test]
fn a_path_that_stays_closed_is_not_walked_after_stepping_back() {
    let (status, back_m) = walk_through_corridor(ROW_X, true);
    assert!(matches!(status, GoalStatus::Failed { .. }), "{status:?}");
    assert!(back_m > 0.7, "it went {back_m} m back");
}

#[test]
fn a_robot_does_not_step_back_from_what_it_sees() {
    let (status, back_m) = walk_through_corridor(FAR_ROW_X, true);
    assert!(matches!(status, GoalStatus::Failed { .. }), "{status:?}");
    assert!(back_m < 0.1, "it went {back_m} m back");
}
