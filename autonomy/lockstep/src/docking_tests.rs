//! Docking on the simulated site, by what the scans show of the dock. Current flows within 3 cm and 3 degrees only, by the truth, which the stack never sees.

use crate::day::{Day, first};
use crate::mission_tests::{DOCK, MISSION, RUN, heading, localised, node, site, until_ended};
use crate::replay;
use geometry::{Vector3, isometry_from_pose};
use messages::{CommandKind, GoalFailure, GoalKind, GoalStatus};
use sim::{SimConfig, SiteName, Start};
use site_model::{
    Dock, DockId, Edge, EdgeId, EditId, MissionCommandKind, Node, NodeKind, Object, RunState, Site,
    StartMode, Traversal,
};
use stack::Stack;
use uuid::Uuid;
use vocab::{Pose, Vec3};

const OTHER_DOCK: DockId = DockId(Uuid::from_u128(73));
/// The other dock: where a robot stands in it, and its heading. The simulator and the topological map agree on it.
const OTHER_PLACE: [f64; 2] = [27.6, 20.0];
const NORTH: f64 = std::f64::consts::FRAC_PI_2;

/// The site of the simulator.
fn hall() -> sim::SimulatedSite {
    sim::SimulatedSite::new(SiteName::B1)
}

/// A robot that stands beside the approach node of the dock, on a site that may differ from the map. `contact_failures`: attempts in a row in which no current
/// flows, before one works.
fn day(site: sim::SimulatedSite, seed: u64, contact_failures: u32) -> Day {
    let start = Start { position: Vec3::new(18.9, 23.1, 0.0), yaw: 0.4 };
    let config = SimConfig {
        lidar_columns: 200,
        people: 0,
        start: Some(start),
        dock_contact_failure_share: 1.0,
        max_dock_contact_failures: contact_failures,
        ..SimConfig::new(site, seed)
    };
    Day::of(config, None)
}

/// Position (m) and heading (rad) of the robot from a docked pose, by the truth.
fn error(day: &mut Day, dock: &sim::SimulatedDock) -> (f64, f64) {
    let truth = day.lockstep.simulator().truth().site_from_base;
    let ahead = isometry_from_pose(&truth).map_or_else(Vector3::zeros, |pose| pose.rotation * Vector3::x());
    let turned = ahead.y.atan2(ahead.x) - dock.yaw;
    let off_m = (truth.position.x - dock.position.x).hypot(truth.position.y - dock.position.y);
    (off_m, turned.sin().atan2(turned.cos()).abs())
}

/// Goes to a dock. Returns the outcome.
fn go_to_dock(day: &mut Day, dock: DockId) -> GoalStatus {
    day.outcomes.clear();
    day.start_goal(GoalKind::GoToDock(dock));
    for _ in 0..240 {
        day.run(0.5);
        if let Some(outcome) = day.outcomes.first() {
            return outcome.clone();
        }
    }
    panic!("no outcome: {:?} {:?} {:?}", day.route, day.motion, day.refusals)
}

#[track_caller]
fn assert_docked(day: &mut Day, dock: &sim::SimulatedDock) {
    let outcome = go_to_dock(day, DOCK);
    let (off_m, off_rad) = error(day, dock);
    assert!(matches!(outcome, GoalStatus::Succeeded(_)), "{outcome:?}, {off_m} m, {off_rad} rad");
    assert!(off_m <= 0.03 && off_rad <= 0.0524, "{off_m} m, {off_rad} rad");
    assert_eq!(day.route.docked, Some(DOCK));
}

#[test]
fn the_robot_docks_although_the_map_is_a_little_wrong() {
    let (_, _, origin) = first();
    let mut wrong = site(origin);
    let Some(dock) = wrong.node(node(1)).cloned() else { panic!("no node") };
    let position = Vec3::new(dock.map_from_node.position.x + 0.05, dock.map_from_node.position.y - 0.06, 0.0);
    put(&mut wrong, Object::Node(Node { map_from_node: Pose { position, ..dock.map_from_node }, ..dock }));
    let hall = hall();
    let dock = hall.docks()[0];
    let mut day = localised(day(hall, 61, 0), wrong);
    assert_docked(&mut day, &dock);
    let again = replay(day.lockstep.log().iter().cloned(), &mut Stack::new());
    assert_eq!(again.hex(), day.lockstep.digest().hex());
}

#[test]
fn a_dock_that_was_moved_is_found_and_people_are_told() {
    let (_, _, origin) = first();
    let moved = hall().with_moved_dock(0, 0.06, 0.137, 8.0_f64.to_radians());
    let dock = moved.docks()[0];
    let mut day = localised(day(moved, 62, 0), site(origin));
    assert_docked(&mut day, &dock);
    assert!(day.notices.iter().any(|text| text.contains("from its place on the map")), "{:?}", day.notices);
}

/// Whether the robot was in the dock or out of it, one after the other, until the goal had its outcome.
fn visits(day: &mut Day, dock: &sim::SimulatedDock) -> Vec<bool> {
    day.start_goal(GoalKind::GoToDock(DOCK));
    let mut visits = Vec::new();
    for _ in 0..480 {
        day.run(0.5);
        let (off_m, _) = error(day, dock);
        let place = if off_m < 0.03 { Some(true) } else { (off_m > 0.8).then_some(false) };
        if place.is_some() && place != visits.last().copied() {
            visits.extend(place);
        }
        if !day.outcomes.is_empty() {
            break;
        }
    }
    visits
}

#[test]
fn contacts_that_fail_once_or_twice_work_at_the_next_attempt() {
    let (_, _, origin) = first();
    for contact_failures in [1, 2] {
        let hall = hall();
        let dock = hall.docks()[0];
        let mut day = localised(day(hall, 63, contact_failures), site(origin));
        let visits = visits(&mut day, &dock);
        assert!(matches!(day.outcomes.as_slice(), [GoalStatus::Succeeded(_)]), "{:?}", day.outcomes);
        assert_eq!(visits, [false, true].repeat(1 + contact_failures as usize));
        assert_eq!(day.route.docked, Some(DOCK));
    }
}

#[test]
fn after_three_attempts_without_current_the_goal_fails_and_people_are_told() {
    let (_, _, origin) = first();
    let hall = hall();
    let dock = hall.docks()[0];
    let mut day = localised(day(hall, 65, 3), site(origin));
    let visits = visits(&mut day, &dock);
    let outcomes = day.outcomes.as_slice();
    assert!(matches!(outcomes, [GoalStatus::Failed { reason: GoalFailure::NotDocked, .. }]), "{outcomes:?}");
    assert_eq!(visits.iter().filter(|is_inside| **is_inside).count(), 3, "{visits:?}");
    assert_eq!(day.route.docked, None);
    let notices =
        day.notices.iter().filter(|text| text.contains("was not charged in the dock after all attempts"));
    assert_eq!(notices.count(), 1, "{:?}", day.notices);
}

#[test]
fn without_its_dock_the_robot_says_so_and_a_mission_ends_in_the_other_one() {
    let (_, _, origin) = first();
    let other = sim::SimulatedDock { position: Vec3::new(OTHER_PLACE[0], OTHER_PLACE[1], 0.0), yaw: NORTH };
    let hall = hall().without_dock(0).with_dock(other);
    let mut day = localised(day(hall, 64, 0), with_other_dock(origin));
    let outcome = go_to_dock(&mut day, DOCK);
    assert!(matches!(outcome, GoalStatus::Failed { reason: GoalFailure::DockNotSeen, .. }), "{outcome:?}");
    let notices = day.notices.iter().filter(|text| text.contains("saw no dock"));
    assert_eq!(notices.count(), 1, "{:?}", day.notices);

    let start = MissionCommandKind::Start { run: RUN, mission: MISSION, mode: StartMode::Now };
    day.command(CommandKind::Mission(start));
    assert_eq!(until_ended(&mut day, 400), Some(RunState::Succeeded), "{:?} {:?}", day.missions, day.notices);
    let place = day.true_position();
    assert_eq!(day.route.docked, Some(OTHER_DOCK), "{place} {:?} {:?}", day.notices, day.outcomes);
    let (off_m, off_rad) = error(&mut day, &other);
    assert!(off_m <= 0.03 && off_rad <= 0.0524, "{off_m} m, {off_rad} rad");
}

fn put(site: &mut Site, object: Object) {
    let id = EditId(Uuid::nil());
    let edit = site.put(id, object);
    assert!(site.apply(&edit, id).is_ok());
}

/// The site with a second dock, which looks south, and the node in front of it.
fn with_other_dock(origin: &Vector3) -> Site {
    let mut site = site(origin);
    let [x, y] = OTHER_PLACE;
    for (number, y, kind) in [(8, y, NodeKind::Dock), (9, y + 1.2, NodeKind::DockApproach)] {
        let position = Vec3::new(x - origin.x, y - origin.y, 0.0);
        let Some(like) = site.node(node(1)).cloned() else { panic!("no node") };
        let map_from_node = Pose { position, orientation: heading(NORTH) };
        let (id, name) = (node(number), format!("N{number}"));
        put(&mut site, Object::Node(Node { id, name, kind, map_from_node, ..like }));
    }
    for (from, to) in [(3, 9), (9, 3), (8, 9), (9, 8)] {
        let walk = Edge::walk(EdgeId(Uuid::from_u128(from * 100 + to)), node(from), node(to));
        let traversal = if from + to == 17 { Traversal::Dock } else { walk.traversal };
        put(&mut site, Object::Edge(Edge { traversal, ..walk }));
    }
    put(
        &mut site,
        Object::Dock(Dock { id: OTHER_DOCK, name: "Other".to_owned(), node: node(8), approach: node(9) }),
    );
    site
}
