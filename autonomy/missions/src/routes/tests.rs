//! The executor with a world around it, in which walks end as each test says.

use super::{
    LegKind, LegResult, LegWalk, RouteAttempt, RouteEffect, RouteExecutor, RouteExecutorConfig,
    RouteRemaining, RouteView,
};
use crate::graph::{GraphPlace, RouteConditions, RouteConfig, RouteGraph};
use crate::runs::{GoalRequest, RouteGoalResult};
use crate::testing::{SiteBuilder, edge_id, node_id};
use site_model::{
    ActionRequest, DockId, EdgeBlock, EdgeFailStep, EdgeId, EdgeStage, EditId, MutexHold, MutexHoldId,
    NodeId, Object, ObjectId, Parameters, ReachFailure, RouteActionPlace, RouteWait, Traversal, ZoneEffect,
};
use std::collections::VecDeque;
use uuid::Uuid;
use vocab::{ActionCallId, GoalId, LegId, Pose, Span, Stamp, Vec3};

const GOAL: GoalId = GoalId(Uuid::from_u128(500));
const DOCK: DockId = DockId(Uuid::from_u128(91));

/// A robot that is where its last walk ended.
struct World {
    builder: SiteBuilder,
    executor: RouteExecutor,
    at: Stamp,
    pose: Pose,
    place: GraphPlace,
    docked: Option<DockId>,
    /// Walks that are active.
    walks: VecDeque<(LegId, LegWalk)>,
    cancelled: usize,
    blocks: Vec<EdgeBlock>,
    unblocked: Vec<EdgeId>,
    traversed: Vec<EdgeId>,
    ended: Vec<RouteGoalResult>,
    tried: Vec<RouteAttempt>,
    /// Calls of actions that are active, and the names of all that were called.
    calls: Vec<(ActionCallId, String)>,
    called: Vec<String>,
    /// What those belong to.
    places: Vec<RouteActionPlace>,
    /// Actions that were cancelled or have failed without an effect on the route.
    dropped: Vec<String>,
}

impl World {
    /// Nodes 1 to 4 along x, 10 m apart, and a detour by node 5; dock 91 at node 1 with node 2 in front of it.
    fn new() -> Self {
        let mut builder = SiteBuilder::new();
        for number in 1..=4 {
            builder.node(number, 10.0 * number as f64, 0.0);
        }
        builder.node(5, 30.0, 30.0);
        builder.pair(1, 2).pair(2, 3).pair(3, 4).pair(2, 5).pair(5, 4).dock(91, 1, 2);
        let mut world = Self {
            builder,
            // Edges in one part, but for the test of parts.
            executor: RouteExecutor::new(RouteExecutorConfig {
                max_part_length_m: 100.0,
                ..RouteExecutorConfig::default()
            }),
            at: Stamp::from_nanos(0),
            pose: Pose::IDENTITY,
            place: GraphPlace::default(),
            docked: None,
            walks: VecDeque::new(),
            cancelled: 0,
            blocks: Vec::new(),
            unblocked: Vec::new(),
            traversed: Vec::new(),
            ended: Vec::new(),
            tried: Vec::new(),
            calls: Vec::new(),
            called: Vec::new(),
            places: Vec::new(),
            dropped: Vec::new(),
        };
        world.stand_at(2);
        world
    }

    fn stand_at(&mut self, number: u128) {
        let id = node_id(number);
        self.pose = self.builder.site().node(id).expect("a node").map_from_node;
        self.place = GraphPlace { at: Some(id), nearest: Some(id), on: None };
    }

    /// Between the nodes of an edge.
    fn stand_on(&mut self, from: u128, to: u128) {
        let site = self.builder.site();
        let x = |number| site.node(node_id(number)).expect("a node").map_from_node.position.x;
        self.pose.position = Vec3::new((x(from) + x(to)) / 2.0, 0.0, 0.0);
        self.place = GraphPlace { at: None, nearest: Some(node_id(from)), on: Some(edge_id(from, to)) };
    }

    fn with<T>(&mut self, call: impl FnOnce(&mut RouteExecutor, Stamp, &RouteView<'_>) -> T) -> T {
        let site = self.builder.site();
        let conditions = RouteConditions { now: self.at, time_of_day: None, learned: None };
        let graph = RouteGraph::new(&site, &conditions, &RouteConfig::default());
        let view = RouteView {
            site: &site,
            newest: &site,
            time_of_day: None,
            graph: &graph,
            map_from_base: Some(self.pose),
            place: self.place,
            docked: self.docked,
        };
        call(&mut self.executor, self.at, &view)
    }

    fn handle_effects(&mut self, effects: Vec<RouteEffect>) {
        for effect in effects {
            match effect {
                RouteEffect::Walk(walk, leg) => self.walks.push_back((walk, leg)),
                RouteEffect::CancelWalk(walk) => {
                    self.cancelled += 1;
                    self.walks.retain(|(known, _)| *known != walk);
                }
                RouteEffect::Tried(attempt) => self.tried.push(attempt),
                RouteEffect::Ended(GOAL, result) => self.ended.push(result),
                RouteEffect::Ended(goal, _) => panic!("another goal: {goal:?}"),
                RouteEffect::Block(block) => self.blocks.push(block),
                RouteEffect::Unblock(edge) => self.unblocked.push(edge),
                RouteEffect::Traversed(edge, _) => self.traversed.push(edge),
                RouteEffect::CallAction(call, place, request) => {
                    self.places.push(place);
                    self.called.push(request.action.clone());
                    self.calls.push((call, request.action));
                }
                RouteEffect::CancelAction(call) => {
                    let index = self.calls.iter().position(|(known, _)| *known == call).expect("a call");
                    let (_, action) = self.calls.remove(index);
                    self.dropped.push(format!("{action} cancelled"));
                }
                RouteEffect::ActionFailed(action, _) => self.dropped.push(format!("{action} failed")),
            }
        }
    }

    /// An edge with these actions on entering, during and on leaving.
    fn give_actions(&mut self, (from, to): (u128, u128), names: [&[&str]; 3]) {
        let request =
            |name: &&str| ActionRequest { action: (*name).to_owned(), parameters: Parameters::new() };
        let [on_enter, during, on_leave] = names.map(|names| names.iter().map(request).collect());
        self.builder.change_edge(from, to, |edge| {
            (edge.on_enter, edge.during, edge.on_leave) = (on_enter, during, on_leave);
        });
    }

    /// The action of this name ends.
    fn end_action(&mut self, name: &str, result: Result<(), &str>) {
        let index = self.calls.iter().position(|(_, action)| action == name).expect("it is under way");
        let (call, _) = self.calls.remove(index);
        assert!(self.executor.is_calling(call));
        let result = result.map_err(str::to_owned);
        let effects = self.with(|executor, at, view| executor.end_action(at, call, result, view));
        self.handle_effects(effects);
    }

    fn remaining(&mut self) -> RouteRemaining {
        self.with(|executor, _, view| executor.remaining(view))
    }

    /// What the robot waits for, as it is published.
    fn waits_for(&mut self) -> Option<RouteWait> {
        self.with(|executor, _, view| executor.progress(view)).and_then(|route| route.waits_for)
    }

    fn begin(&mut self, request: GoalRequest) {
        let effects = self.with(|executor, at, view| executor.begin(at, GOAL, request, view));
        self.handle_effects(effects);
    }

    fn wait(&mut self, seconds: i64) {
        self.at += Span::from_millis(seconds * 1_000);
        let effects = self.with(|executor, at, view| executor.tick(at, view));
        self.handle_effects(effects);
    }

    /// The active walk ends after 5 s. Returns where it led.
    fn end_walk(&mut self, result: LegResult) -> Vec3 {
        let (walk, leg) = self.walks.pop_front().expect("a walk");
        assert!(self.walks.is_empty(), "one walk at a time");
        self.at += Span::from_millis(5_000);
        if result == LegResult::Reached {
            self.pose = leg.map_from_goal;
            let site = self.builder.site();
            let node = site.nodes().find(|node| node.map_from_node.position == self.pose.position);
            let id: Option<NodeId> = node.map(|node| node.id);
            self.place = GraphPlace { at: id, nearest: id, on: None };
        }
        let effects = self.with(|executor, at, view| executor.end_leg(at, walk, result, view));
        self.handle_effects(effects);
        leg.map_from_goal.position
    }

    /// All walks are reached until the goal has ended.
    fn walk_to_the_end(&mut self) -> Vec<f64> {
        let mut ends = Vec::new();
        while self.ended.is_empty() && !self.walks.is_empty() {
            ends.push(self.end_walk(LegResult::Reached).x);
        }
        ends
    }
}

fn blocked() -> LegResult {
    LegResult::Failed(ReachFailure::PathBlocked)
}

#[test]
fn a_route_passes_its_nodes_and_stands_in_the_last() {
    let mut world = World::new();
    world.builder.change_node(4, |node| node.tolerance.yaw_rad = 3.0);
    world.begin(GoalRequest::Route(node_id(4)));
    assert!(world.walks[0].1.tolerance.is_none(), "node 3 is passed");
    let progress = world.with(|executor, _, view| executor.progress(view)).expect("a route");
    assert_eq!(progress.edges, [edge_id(2, 3), edge_id(3, 4)]);
    assert!((progress.remaining_m - 20.0).abs() < 1e-9);
    world.end_walk(LegResult::Reached);
    let tolerance = world.walks[0].1.tolerance.expect("node 4 is the end");
    assert!(tolerance.yaw_rad < 0.06, "however wide that of the node is");
    world.walk_to_the_end();
    assert_eq!(world.ended, [RouteGoalResult::Reached]);
    assert_eq!(world.traversed, [edge_id(2, 3), edge_id(3, 4)]);
}

#[test]
fn a_goal_waits_for_the_robots_place_and_fails_when_that_is_not_found() {
    let mut world = World::new();
    world.place = GraphPlace::default();
    world.begin(GoalRequest::Route(node_id(4)));
    world.wait(3);
    assert!(world.walks.is_empty() && world.ended.is_empty());
    assert_eq!(world.waits_for(), Some(RouteWait::Place));
    world.stand_at(2);
    world.wait(1);
    assert_eq!(world.walks.len(), 1, "it sets out");

    let mut world = World::new();
    world.place = GraphPlace::default();
    world.begin(GoalRequest::Route(node_id(4)));
    for _ in 0..25 {
        world.wait(1);
    }
    assert_eq!(world.ended, [RouteGoalResult::Failed(ReachFailure::PoseNotFound)]);
}

#[test]
fn a_long_edge_is_walked_in_parts() {
    let mut world = World::new();
    world.executor = RouteExecutor::new(RouteExecutorConfig::default());
    world.begin(GoalRequest::Route(node_id(3)));
    assert!(world.walks[0].1.tolerance.is_none(), "the middle is passed");
    assert_eq!(world.walk_to_the_end(), [25.0, 30.0]);
    assert_eq!(world.ended, [RouteGoalResult::Reached]);
    assert_eq!(world.traversed, [edge_id(2, 3)]);
}

#[test]
fn a_blocked_edge_is_left_out_in_both_directions_and_the_route_goes_round() {
    let mut world = World::new();
    world.begin(GoalRequest::Route(node_id(4)));
    world.end_walk(LegResult::Reached);
    world.stand_on(3, 4);
    world.end_walk(blocked());
    let edges: Vec<EdgeId> = world.blocks.iter().map(|block| block.edge).collect();
    assert_eq!(edges, [edge_id(3, 4), edge_id(4, 3)]);
    assert!(world.blocks[0].reason.contains("35.0 m"), "{}", world.blocks[0].reason);
    // Back to node 3, and by node 5, although the site does not show the block yet.
    assert_eq!(world.walk_to_the_end(), [30.0, 20.0, 30.0, 40.0]);
    assert_eq!(world.ended, [RouteGoalResult::Reached]);
}

#[test]
fn where_there_is_no_other_route_the_robot_waits_for_the_end_of_short_blocks() {
    let mut world = World::new();
    // Without the detour.
    for (from, to) in [(2, 5), (5, 4)] {
        world.builder.change_edge(from, to, |edge| edge.is_enabled = false);
    }
    world.stand_at(3);
    world.begin(GoalRequest::Route(node_id(4)));
    let mut times = Vec::new();
    for _ in 0..2 {
        world.end_walk(blocked());
        assert!(world.walks.is_empty() && world.ended.is_empty(), "it waits");
        assert!(matches!(world.waits_for(), Some(RouteWait::Block { .. })));
        let block = world.blocks.iter().rev().find(|block| block.edge == edge_id(3, 4)).expect("a block");
        let time_s = (block.until - world.at).secs_f64();
        world.wait(time_s as i64 - 1);
        assert!(world.walks.is_empty());
        world.wait(1);
        times.push(time_s);
    }
    // The time of a block doubles with each failure; the third is too long to wait for.
    assert_eq!(times, [60.0, 120.0]);
    world.end_walk(blocked());
    let closed = vec![edge_id(3, 4)];
    assert_eq!(world.ended, [RouteGoalResult::Failed(ReachFailure::NoRoute { closed })]);

    // A walk over the edge ends its record.
    world.at = world.blocks.last().expect("a block").until;
    world.ended.clear();
    world.begin(GoalRequest::Route(node_id(4)));
    world.walk_to_the_end();
    assert_eq!(world.ended, [RouteGoalResult::Reached]);
    assert_eq!(world.unblocked, [edge_id(3, 4)]);
}

#[test]
fn a_block_that_a_person_lifts_ends_the_wait_at_once() {
    let mut world = World::new();
    for (from, to) in [(2, 5), (5, 4)] {
        world.builder.change_edge(from, to, |edge| edge.is_enabled = false);
    }
    world.stand_at(3);
    world.begin(GoalRequest::Route(node_id(4)));
    world.end_walk(blocked());
    world.wait(1);
    assert!(world.walks.is_empty(), "the site does not show the block yet");
    for block in world.blocks.clone() {
        world.builder.put(Object::EdgeBlock(block));
    }
    world.wait(1);
    assert!(world.walks.is_empty(), "it waits");
    for edge in [edge_id(3, 4), edge_id(4, 3)] {
        let edit = world.builder.site().removal(EditId(Uuid::nil()), ObjectId::EdgeBlock(edge));
        world.builder.apply(&edit);
    }
    world.wait(1);
    assert_eq!(world.walks.len(), 1, "it tries the edge again");
    world.walk_to_the_end();
    assert_eq!(world.ended, [RouteGoalResult::Reached]);
}

#[test]
fn the_fail_policy_of_an_edge_is_followed_in_turn() {
    let mut world = World::new();
    world.builder.change_edge(2, 3, |edge| {
        edge.fail_policy =
            vec![EdgeFailStep::Retry(1), EdgeFailStep::Wait(Span::from_millis(30_000)), EdgeFailStep::Fail];
    });
    world.begin(GoalRequest::Route(node_id(3)));
    world.end_walk(blocked());
    assert_eq!(world.walks.len(), 1, "tried again at once");
    world.end_walk(blocked());
    assert!(world.walks.is_empty(), "it waits");
    world.wait(29);
    assert!(world.walks.is_empty());
    world.wait(1);
    world.end_walk(blocked());
    assert_eq!(world.ended, [RouteGoalResult::Failed(ReachFailure::PathBlocked)]);
    assert!(world.blocks.is_empty());
}

#[test]
fn an_edge_that_is_closed_meanwhile_is_not_walked_to_its_end() {
    let mut world = World::new();
    world.begin(GoalRequest::Route(node_id(4)));
    world.end_walk(LegResult::Reached);
    world.stand_on(3, 4);
    world.builder.change_edge(3, 4, |edge| edge.is_enabled = false);
    world.wait(1);
    assert_eq!(world.cancelled, 1);
    assert_eq!(world.walk_to_the_end(), [30.0, 20.0, 30.0, 40.0]);
    assert_eq!(world.ended, [RouteGoalResult::Reached]);
}

#[test]
fn only_the_charging_current_proves_that_the_robot_has_docked() {
    let mut world = World::new();
    world.begin(GoalRequest::Dock(DOCK));
    // Into the pose in front of the dock, then onto it, three times. Between them it backs off.
    for attempt in 1..=3 {
        if attempt == 1 {
            assert_eq!(world.end_walk(LegResult::Reached).x, 20.0);
        }
        // Node 2 looks along x, and the dock is behind it.
        assert_eq!(world.walks[0].1.kind, LegKind::OntoDock { is_facing: false });
        assert_eq!(world.end_walk(LegResult::Reached).x, 10.0);
        world.wait(3);
        assert!(world.walks.is_empty() && world.ended.is_empty(), "it waits for the current");
        world.wait(1);
        assert_eq!(world.end_walk(LegResult::Reached).x, 20.0);
    }
    assert_eq!(world.ended, [RouteGoalResult::Failed(ReachFailure::NotDocked)]);

    let mut world = World::new();
    world.begin(GoalRequest::Dock(DOCK));
    world.end_walk(LegResult::Reached);
    world.docked = Some(DOCK);
    world.wait(1);
    assert_eq!((world.ended.as_slice(), world.cancelled), ([RouteGoalResult::Reached].as_slice(), 1));
}

#[test]
fn a_dock_that_is_not_seen_is_looked_for_three_times() {
    let mut world = World::new();
    world.begin(GoalRequest::Dock(DOCK));
    world.end_walk(LegResult::Reached);
    for _ in 0..3 {
        assert!(world.ended.is_empty());
        world.end_walk(LegResult::Failed(ReachFailure::DockNotSeen));
        assert_eq!(world.end_walk(LegResult::Reached).x, 20.0);
    }
    assert_eq!(world.ended, [RouteGoalResult::Failed(ReachFailure::DockNotSeen)]);
    assert_eq!(world.tried, [RouteAttempt::Docking; 3]);
}

#[test]
fn a_docked_robot_leaves_its_dock_first() {
    let mut world = World::new();
    world.stand_at(1);
    world.docked = Some(DOCK);
    world.begin(GoalRequest::Route(node_id(3)));
    assert_eq!(world.walks[0].1.kind, LegKind::Straight);
    world.docked = None;
    assert_eq!(world.walk_to_the_end(), [20.0, 30.0]);
    assert_eq!(world.ended, [RouteGoalResult::Reached]);

    let mut world = World::new();
    world.stand_at(1);
    world.docked = Some(DOCK);
    world.begin(GoalRequest::Undock);
    world.end_walk(blocked());
    assert_eq!(world.ended, [RouteGoalResult::Failed(ReachFailure::NotUndocked)]);
}

#[test]
fn what_takes_the_robot_ends_the_goal_and_a_late_result_changes_nothing() {
    let mut world = World::new();
    world.begin(GoalRequest::Route(node_id(4)));
    let (walk, _) = world.walks[0];
    let effects = world.with(|executor, _, _| executor.cancel(GOAL));
    world.handle_effects(effects);
    assert_eq!((world.ended.as_slice(), world.walks.len()), ([RouteGoalResult::Cancelled].as_slice(), 0));
    let late = world.with(|executor, at, view| executor.end_leg(at, walk, LegResult::Reached, view));
    assert!(late.is_empty());

    let mut world = World::new();
    world.begin(GoalRequest::Route(node_id(99)));
    assert_eq!(world.ended, [RouteGoalResult::Failed(ReachFailure::NoSuchPlace)]);
    assert!(world.builder.site().get(ObjectId::Node(node_id(99))).is_none());
}

#[test]
fn actions_of_an_edge_are_performed_before_during_and_after_it() {
    let mut world = World::new();
    world.give_actions((2, 3), [&["open", "look"], &["listen", "film"], &["close"]]);
    world.begin(GoalRequest::Route(node_id(4)));
    assert_eq!((world.called.join(" "), world.walks.len()), ("open".to_owned(), 0), "one after the other");
    world.end_action("open", Ok(()));
    world.end_action("look", Ok(()));
    assert_eq!(world.called.join(" "), "open look listen film");
    assert_eq!(world.walks.len(), 1, "it walks meanwhile");
    world.end_action("listen", Err("Nothing was heard."));
    world.end_walk(LegResult::Reached);
    assert_eq!(world.dropped, ["listen failed", "film cancelled"], "what is during the edge ends with it");
    assert_eq!((world.called.last().map(String::as_str), world.walks.len()), (Some("close"), 0));
    world.end_action("close", Err("It is stuck."));
    assert_eq!(world.dropped.last().map(String::as_str), Some("close failed"));
    assert_eq!(world.traversed, [edge_id(2, 3)]);
    world.end_walk(LegResult::Reached);
    assert_eq!(world.traversed, [edge_id(2, 3), edge_id(3, 4)], "people are told, and the robot goes on");
    assert!(world.blocks.is_empty() && world.calls.is_empty());
}

#[test]
fn an_edge_whose_first_action_fails_follows_its_fail_policy() {
    let mut world = World::new();
    world.give_actions((2, 3), [&["open"], &[], &[]]);
    world.builder.change_edge(2, 3, |edge| edge.fail_policy = vec![EdgeFailStep::Retry(1)]);
    world.begin(GoalRequest::Route(node_id(4)));
    world.end_action("open", Err("The door is locked."));
    assert_eq!(world.called.len(), 2, "once more");
    world.end_action("open", Err("The door is locked."));
    assert!(world.blocks[0].reason.contains("The door is locked."), "{:?}", world.blocks);
    assert_eq!((world.called.len(), world.walks.len()), (2, 1), "the detour by node 5");
    assert!(world.ended.is_empty());
}

#[test]
fn an_action_of_an_edge_that_does_not_end_is_cancelled_and_one_of_a_cancelled_goal_too() {
    let mut world = World::new();
    world.give_actions((2, 3), [&["open"], &[], &[]]);
    world.begin(GoalRequest::Route(node_id(4)));
    world.wait(119);
    assert_eq!(world.dropped.len(), 0);
    world.wait(2);
    assert_eq!((world.dropped.join(""), world.blocks.len()), ("open cancelled".to_owned(), 2));
    let mut world = World::new();
    world.give_actions((2, 3), [&["open"], &[], &[]]);
    world.begin(GoalRequest::Route(node_id(4)));
    let effects = world.with(|executor, _, _| executor.cancel(GOAL));
    world.handle_effects(effects);
    assert_eq!((world.dropped.join(""), world.ended.len()), ("open cancelled".to_owned(), 1));
}

#[test]
fn an_edge_with_a_traversal_of_the_robots_own_calls_that_action_last() {
    let mut world = World::new();
    world.give_actions((2, 3), [&["open"], &[], &[]]);
    world.builder.change_edge(2, 3, |edge| {
        edge.traversal = Traversal::Action { name: "crawl".to_owned(), parameters: Parameters::new() };
    });
    world.begin(GoalRequest::Route(node_id(4)));
    world.end_action("open", Ok(()));
    assert_eq!((world.called.join(" "), world.walks.len()), ("open crawl".to_owned(), 0));
    world.end_action("crawl", Ok(()));
    world.end_walk(LegResult::Reached);
    assert_eq!(world.traversed, [edge_id(2, 3)]);
}

#[test]
fn the_robot_stands_in_line_with_stairs_before_it_walks_onto_them_and_after() {
    let mut world = World::new();
    // From node 5 at (30, 30) the stairs lead to node 4 at (40, 0).
    world.builder.change_edge(5, 4, |edge| edge.traversal = Traversal::Stairs);
    world.builder.change_edge(2, 3, |edge| edge.is_enabled = false);
    world.begin(GoalRequest::Route(node_id(3)));
    let config = RouteExecutorConfig::default();
    for (node, is_aligned) in [(5, true), (4, true), (3, false)] {
        let walk = world.walks[0].1;
        let site = world.builder.site();
        assert_eq!(
            walk.map_from_goal.position,
            site.node(node_id(node)).expect("a node").map_from_node.position
        );
        assert_eq!(walk.tolerance == Some(config.stairs_tolerance), is_aligned, "at node {node}");
        if is_aligned {
            let (w, z) = (walk.map_from_goal.orientation.w, walk.map_from_goal.orientation.z);
            assert!((2.0 * z.atan2(w) - (-30.0_f64).atan2(10.0)).abs() < 1e-9);
        }
        world.end_walk(LegResult::Reached);
    }
    assert_eq!(world.ended, [RouteGoalResult::Reached]);
}

#[test]
fn what_remains_is_that_of_the_whole_route_at_each_leg() {
    let mut world = World::new();
    world.executor = RouteExecutor::new(RouteExecutorConfig::default());
    assert_eq!(world.remaining(), RouteRemaining::default());
    world.begin(GoalRequest::Route(node_id(4)));
    // Two edges of 10 m, each in two parts. What is left of the leg itself is for whoever walks it to say.
    let mut beyond_m = Vec::new();
    while world.ended.is_empty() {
        let remaining = world.remaining();
        assert_eq!(remaining.waits_for, None);
        beyond_m.push(remaining.beyond_leg_m.expect("a route"));
        world.end_walk(LegResult::Reached);
    }
    assert_eq!(beyond_m, [15.0, 10.0, 5.0, 0.0]);
    assert_eq!(world.remaining(), RouteRemaining::default());

    // From beside the graph, and into a dock, which is 10 m behind its approach node.
    let mut world = World::new();
    world.stand_on(3, 4);
    world.begin(GoalRequest::Dock(DOCK));
    assert_eq!(world.remaining().beyond_leg_m, Some(20.0), "node 3 first: {:?}", world.walks);
    world.end_walk(LegResult::Reached);
    assert_eq!(world.remaining().beyond_leg_m, Some(10.0));
    world.end_walk(LegResult::Reached);
    assert_eq!(world.remaining().beyond_leg_m, Some(0.0), "on the way into it: {:?}", world.walks);
    world.end_walk(LegResult::Reached);
    assert_eq!(
        world.remaining(),
        RouteRemaining { beyond_leg_m: Some(0.0), waits_for: Some(RouteWait::Charge) }
    );
}

#[test]
fn waits_are_told_with_their_reason_and_are_among_what_was_tried() {
    let mut world = World::new();
    world.give_actions((2, 3), [&["open"], &[], &["close"]]);
    world.builder.change_edge(2, 3, |edge| {
        edge.fail_policy = vec![EdgeFailStep::Wait(Span::from_millis(30_000)), EdgeFailStep::Replan];
    });
    world.begin(GoalRequest::Route(node_id(4)));
    let waits = |beyond_leg_m, wait| RouteRemaining { beyond_leg_m, waits_for: Some(wait) };
    let edge = edge_id(2, 3);
    let action = |stage| RouteWait::Action(RouteActionPlace::Edge { edge, stage, index: 0 });
    assert_eq!(world.remaining(), waits(Some(20.0), action(EdgeStage::Enter)));
    world.end_action("open", Ok(()));
    world.end_walk(blocked());
    let until = world.at + Span::from_millis(30_000);
    assert_eq!(world.remaining(), waits(Some(20.0), RouteWait::Retry { edge, until }));
    world.wait(30);
    assert_eq!(world.tried, [RouteAttempt::WaitedForEdge(Span::from_millis(30_000))]);
    world.end_walk(LegResult::Reached);
    assert_eq!(world.remaining(), waits(Some(10.0), action(EdgeStage::Leave)), "the edge is behind it");

    let mut world = World::new();
    world.builder.change_edge(2, 5, |edge| edge.is_enabled = false);
    world.builder.change_edge(5, 4, |edge| edge.is_enabled = false);
    world.stand_at(3);
    world.begin(GoalRequest::Route(node_id(4)));
    world.end_walk(blocked());
    let until = world.blocks[0].until;
    assert_eq!(world.remaining(), waits(None, RouteWait::Block { until }));
    world.wait(61);
    assert_eq!(world.tried, [RouteAttempt::WaitedForEdge(Span::from_millis(61_000))]);

    let mut world = World::new();
    world.place = GraphPlace::default();
    world.begin(GoalRequest::Route(node_id(4)));
    assert_eq!(world.remaining(), waits(None, RouteWait::Place));
    world.wait(1);
    assert_eq!(world.tried, [RouteAttempt::WaitedForPlace(Span::from_millis(1_000))]);
}

#[test]
fn an_edge_of_a_group_that_somebody_holds_is_waited_for() {
    let mut world = World::new();
    let group = "Lift".to_owned();
    world.builder.change_edge(3, 4, |edge| edge.mutex_group = Some(group.clone()));
    let id = MutexHoldId(Uuid::from_u128(700));
    let hold = MutexHold { id, group: group.clone(), holder: "Forklift".to_owned() };
    world.builder.put(Object::MutexHold(hold));
    world.begin(GoalRequest::Route(node_id(4)));
    assert_eq!(world.waits_for(), None, "the first edge is of no group");
    world.end_walk(LegResult::Reached);
    world.wait(600);
    assert!(world.walks.is_empty() && world.ended.is_empty());
    let (edge, holder) = (edge_id(3, 4), "Forklift".to_owned());
    assert_eq!(world.waits_for(), Some(RouteWait::Hold { edge, group, holder }));
    let removal = world.builder.site().removal(EditId(Uuid::nil()), ObjectId::MutexHold(id));
    world.builder.apply(&removal);
    world.wait(1);
    assert_eq!(world.waits_for(), None);
    world.walk_to_the_end();
    assert_eq!(world.ended, [RouteGoalResult::Reached]);

    // A robot that waits takes another route once the edge is closed.
    world.ended.clear();
    world.builder.put(Object::MutexHold(MutexHold {
        id,
        group: "Lift".to_owned(),
        holder: "Forklift".to_owned(),
    }));
    world.stand_at(3);
    world.begin(GoalRequest::Route(node_id(4)));
    world.builder.change_edge(3, 4, |edge| edge.is_enabled = false);
    world.wait(1);
    assert_eq!(world.walk_to_the_end(), [20.0, 30.0, 40.0]);
}

#[test]
fn the_action_of_a_zone_is_called_once_when_the_robot_comes_into_it() {
    let mut world = World::new();
    let request = ActionRequest { action: "horn".to_owned(), parameters: Parameters::new() };
    let corners = [[22.0, -1.0], [28.0, -1.0], [28.0, 1.0], [22.0, 1.0]];
    world.builder.zone(41, corners, ZoneEffect::Action(request), None);
    world.begin(GoalRequest::Route(node_id(3)));
    world.wait(1);
    assert!(world.called.is_empty(), "it is not there yet");
    let move_to = |world: &mut World, x| {
        world.pose.position.x = x;
        world.wait(1);
        world.called.len()
    };
    assert_eq!(move_to(&mut world, 22.1), 1);
    assert_eq!(world.walks.len(), 1, "it walks on");
    // Along the border it does not enter again and again.
    assert_eq!([21.9, 22.1, 27.0].map(|x| move_to(&mut world, x)), [1, 1, 1]);
    assert_eq!([28.4, 27.5].map(|x| move_to(&mut world, x)), [1, 2]);
    assert_eq!(world.places, [RouteActionPlace::Zone(site_model::ZoneId(Uuid::from_u128(41))); 2]);
    // Those that are active go on when the goal is reached.
    world.walk_to_the_end();
    assert_eq!((world.ended.len(), world.calls.len()), (1, 2));

    // A goal that begins inside has not entered.
    world.ended.clear();
    world.pose.position.x = 25.0;
    world.wait(1);
    world.begin(GoalRequest::Route(node_id(2)));
    world.wait(1);
    assert_eq!(world.called.len(), 2);
}

#[test]
fn calls_say_what_they_belong_to() {
    let mut world = World::new();
    world.give_actions((2, 3), [&["open", "look"], &["listen"], &["close"]]);
    world.begin(GoalRequest::Route(node_id(3)));
    assert!(matches!(world.waits_for(), Some(RouteWait::Action(RouteActionPlace::Edge { .. }))));
    world.end_action("open", Ok(()));
    world.end_action("look", Ok(()));
    world.end_walk(LegResult::Reached);
    world.end_action("close", Ok(()));
    let edge = edge_id(2, 3);
    let of = |stage, index| RouteActionPlace::Edge { edge, stage, index };
    let expected =
        [of(EdgeStage::Enter, 0), of(EdgeStage::Enter, 1), of(EdgeStage::During, 0), of(EdgeStage::Leave, 0)];
    assert_eq!(world.places, expected);
}
