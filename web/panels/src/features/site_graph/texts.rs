//! Texts of the topological map, by key.

use super::moment::EdgeActionTime;
use crate::feature_panel::DragObstruction;
use crate::format;
use crate::name_field::NameFieldTexts;
use api::TopomapSummary;
use site_model::{
    EdgeBlock, EdgeCost, EdgeFailStep, MutexHold, NodeKind, ProblemSeverity, SiteProblem, TravelDirection,
    Traversal,
};

pub(super) const TAB: &str = "Topological map";
pub(super) const HEAD: &str = "Topological map";
pub(super) const NODES: &str = "Nodes";
pub(super) const EDGES: &str = "Edges";
pub(super) const UNCONFIRMED: &str = "Not confirmed";
pub(super) const ADD_NODES: &str = "Add nodes";
pub(super) const CONNECT: &str = "Connect nodes";
pub(super) const ADD_HINT: &str =
    "Click the floor to add a node. It is joined to the selected one. Escape ends it.";
pub(super) const CONNECT_HINT: &str = "Click two nodes to join them both ways. Escape ends it.";
pub(super) const EMPTY: &str = "There are no nodes yet. Make them from the map, or press \"Add nodes\" and click the floor along the way that the robot shall walk.";
pub(super) const LOADING: &str = "The site has not arrived from the robot yet.";
pub(super) const NO_MAP: &str =
    "Nodes are placed in a saved map. View one on the Map screen, or let the robot use one.";
pub(super) const OTHER_MAP: &str = "The topological map belongs to another map than the one on the screen.";
pub(super) const VIEW_ITS_MAP: &str = "View its map";
pub(super) const NODE_HEAD: &str = "Node";
pub(super) const NAME_FIELD: NameFieldTexts =
    NameFieldTexts { field: "Node name", rename: "Rename node", rename_short: "Rename" };
pub(super) const COORDINATES: [&str; 3] = ["x (m)", "y (m)", "Height (m)"];
pub(super) const HEADING: &str = "Heading (°)";
pub(super) const FLOOR: &str = "Floor";
pub(super) const TOLERANCE_HEAD: &str = "Counts as reached";
/// How far from a node counts as reached: ahead and behind, to the sides, and in heading.
pub(super) const TOLERANCES: [&str; 3] = ["Ahead (m)", "Sideways (m)", "Turned (°)"];
pub(super) const TOLERANCE_REMARK: &str =
    "The robot stands as near to the node as this before a task begins there.";
/// Numbers of floors that people may enter.
pub(super) const FLOORS: [f64; 2] = [-99.0, 999.0];
pub(super) const ALL_FLOORS: &str = "All floors";
pub(super) const SELECT_SEVERAL: &str = "Select several";
pub(super) const SELECT_HINT: &str =
    "Drag a box round nodes, or click them one by one. Drag one of them to move all. Escape ends it.";
pub(super) const GROUP_HEAD: &str = "Several nodes";
pub(super) const SELECTED: &str = "Selected";
pub(super) const MIDDLE: [&str; 2] = ["Middle, x (m)", "Middle, y (m)"];
pub(super) const SEVERAL: &str = "Different";
pub(super) const JOIN: &str = "Join them";
pub(super) const JOIN_HINT: &str = "Adds the shortest edges by which all of them are joined.";
pub(super) const EDGES_ENABLED: &str = "Routes may use their edges";
pub(super) const TRAVERSAL: &str = "Traversal";
pub(super) const SPEED: &str = "Speed (m/s)";
pub(super) const SPEED_OF_ROBOT: &str = "Robot's";
pub(super) const ROOM_LEFT: &str = "Room left (m)";
pub(super) const ROOM_RIGHT: &str = "Room right (m)";
pub(super) const MAKE_DOCK: &str = "Make it a dock";
pub(super) const MAKE_DOCK_HINT: &str =
    "The robot stands on it with the heading of the node, and leaves it ahead. A node before it is added.";
pub(super) const UNMAKE_DOCK: &str = "It is no dock";
pub(super) const DOCKS_HEAD: &str = "Docks";
pub(super) const DOCK_HEAD: &str = "Dock";
pub(super) const DOCK_NAME_FIELD: NameFieldTexts =
    NameFieldTexts { field: "Dock name", rename: "Rename dock", rename_short: "Rename" };
pub(super) const APPROACH: &str = "Approached from";
pub(super) const APPROACH_REMARK: &str =
    "There the robot looks for the dock and aligns itself. Nodes with an edge onto the dock can be chosen.";
pub(super) const INFLUENCE_HEAD: &str = "Counts as at the node";
/// Whether an area counts.
pub(super) const INFLUENCES: [(&str, bool); 2] = [("Near it", false), ("In an area too", true)];
pub(super) const WAYS_HEAD: &str = "Edges of it";
pub(super) const BLOCKS_HEAD: &str = "Blocked now";
pub(super) const HOLDS_HEAD: &str = "Held groups";
pub(super) const UNBLOCK_SHORT: &str = "Unblock now";
pub(super) const RELEASE_SHORT: &str = "Release";
pub(super) const EDGE_HEAD: &str = "Edge";
pub(super) const ENABLED: &str = "Routes may use it";
pub(super) const BOTH_DIRECTIONS: &str = "Both ways";
pub(super) const SPLIT: &str = "Split edge";
pub(super) const DELETE_EDGE: &str = "Delete edge";
pub(super) const DELETE_SHORT: &str = "Delete";
pub(super) const PROBLEMS_HEAD: &str = "Problems";
pub(super) const UNNAMED: &str = "A node without a name";

pub(super) const GENERATE: &str = "Make from the map";
pub(super) const REPLACE: &str = "Replace them";
pub(super) const KEEP: &str = "Keep them";
pub(super) const PROGRESS: &str = "Making the topological map";
pub(super) const READING: &str = "Reading the map…";
pub(super) const GENERATING: &str = "Looking for ways, and checking that each is free…";
pub(super) const STORING: &str = "Putting the nodes into the site…";
pub(super) const RESULT: &str = "Result";
pub(super) const DISMISS_RESULT: &str = "Dismiss the result";
pub(super) const DISMISS_SHORT: &str = "Dismiss";
pub(super) const BLOCKED: &str = "The robot has walked here, but the map shows an obstacle, so there is no edge. Look whether it still stands there:";

/// What making the topological map anew takes away.
pub(super) fn replaces(nodes: usize, edges: usize) -> String {
    format!(
        "This replaces the {nodes} nodes and {edges} edges of the site. Nodes that inspection points or missions need stay. It can be undone."
    )
}

/// What was made from the map.
pub(super) fn made(summary: &TopomapSummary) -> String {
    let nodes = counted(summary.nodes, "node", "nodes");
    let edges = counted(summary.edges, "edge", "edges");
    let docks = counted(summary.docks, "dock", "docks");
    let floors = counted(summary.floors, "floor", "floors");
    format!("Made {nodes}, {edges} and {docks} on {floors}: {} of ways.", format::distance(summary.length_m))
}

fn counted(number: u32, one: &str, many: &str) -> String {
    format!("{number} {}", if number == 1 { one } else { many })
}

pub(super) fn pieces(pieces: u32) -> String {
    format!("The ways are {pieces} pieces that are not joined. Join them where the robot can pass.")
}

pub(super) fn kept(nodes: u32) -> String {
    format!(
        "{} of before stayed, because inspection points or missions need them.",
        counted(nodes, "node", "nodes")
    )
}

pub(super) fn blocked_segment(number: u32, length_m: f64) -> String {
    format!("Blocked stretch {number} · {}", format::distance(length_m))
}

/// The kinds that people choose; docks and portals come with what makes them.
pub(super) const KINDS: [(&str, NodeKind); 4] = [
    ("Waypoint", NodeKind::Waypoint),
    ("Inspection", NodeKind::Inspection),
    ("Hold", NodeKind::Hold),
    ("Safe", NodeKind::Safe),
];

/// The ways to traverse an edge that people choose; others come with what makes them.
pub(super) const TRAVERSALS: [(&str, Traversal); 4] = [
    ("Walk", Traversal::Walk),
    ("Walk slowly", Traversal::Slow),
    ("Door", Traversal::Door),
    ("Stairs", Traversal::Stairs),
];

pub(super) fn traversal(traversal: &Traversal) -> &str {
    match traversal {
        Traversal::Walk => "Walk",
        Traversal::Slow => "Walk slowly",
        Traversal::Door => "Door",
        Traversal::Stairs => "Stairs",
        Traversal::Dock => "Onto a dock",
        Traversal::Action { name, .. } => name,
    }
}

pub(super) const NOT_OFFERED: &str =
    "The robot does not offer this action now, so the edge cannot be traversed.";

pub(super) const COST_HEAD: &str = "What it costs";
/// What the cost is, in the order of the list: by length, learned, fixed.
pub(super) const COSTS: [&str; 3] = ["Length", "Learned", "Fixed"];
pub(super) const COST_TIME: &str = "Cost (s)";
pub(super) const MUTEX_GROUP: &str = "One robot at a time";
pub(super) const NO_GROUP: &str = "No group";
pub(super) const MUTEX_REMARK: &str = "Name a group. Of all edges of a group, one robot uses one at a time.";

/// What a cost means for routes.
pub(super) fn cost_remark(cost: EdgeCost) -> &'static str {
    match cost {
        EdgeCost::Length => "The time that its length takes at the robot's usual speed.",
        EdgeCost::Learned => "The time that earlier walks took; before the first, that of its length.",
        EdgeCost::Fixed(_) => "Routes count this time, whatever its length.",
    }
}

pub(super) const SHAPE_HEAD: &str = "Change its shape";
pub(super) const ACTIONS_HEAD: &str = "Actions along it";
pub(super) const ADD_ACTION: &str = "Add an action";
pub(super) const NO_PARAMETERS: &str = "It needs nothing to be said.";
pub(super) const POLICY_HEAD: &str = "If it cannot be walked";
pub(super) const NO_POLICY: &str = "The robot takes another way at once.";
pub(super) const ADD_STEP: &str = "Add a step";

/// When actions are performed, in the order in which it comes.
pub(super) const MOMENTS: [(EdgeActionTime, &str); 3] = [
    (EdgeActionTime::Enter, "Before setting out"),
    (EdgeActionTime::During, "While walking"),
    (EdgeActionTime::Leave, "After arriving"),
];

pub(super) fn add_action(moment: &str) -> String {
    format!("{moment}: add an action")
}

/// Accessible name of the row of an action.
pub(super) fn action_row(moment: &str, number: usize, title: &str) -> String {
    format!("{moment} {number}: {title}")
}

pub(super) fn remove_row(row: &str) -> String {
    format!("Remove {row}")
}

/// What can be tried, in the order of the list.
pub(super) const FAIL_STEPS: [&str; 4] = ["Try again", "Wait, then try again", "Take another way", "Give up"];

pub(super) fn fail_step(step: EdgeFailStep) -> &'static str {
    match step {
        EdgeFailStep::Retry(_) => FAIL_STEPS[0],
        EdgeFailStep::Wait(_) => FAIL_STEPS[1],
        EdgeFailStep::Replan => FAIL_STEPS[2],
        EdgeFailStep::Fail => FAIL_STEPS[3],
    }
}

pub(super) fn step_caption(number: usize) -> String {
    format!("Step {number}")
}

pub(super) fn step_number(number: usize, is_wait: bool) -> String {
    if is_wait { format!("Wait {number} (s)") } else { format!("Tries {number}") }
}

/// Which way the robot faces.
pub(super) const DIRECTIONS: [(&str, TravelDirection); 3] = [
    ("Forwards", TravelDirection::Forward),
    ("Backwards", TravelDirection::Backward),
    ("Any way", TravelDirection::Any),
];

/// What stands in an edge while a node is dragged.
pub(super) fn obstructed(found: &DragObstruction) -> String {
    let DragObstruction { from, to, along_m, others } = found;
    let more = match others {
        0 => String::new(),
        1 => " One more edge is not free.".to_owned(),
        others => format!(" {others} more edges are not free."),
    };
    format!("Something stands between {from} and {to}, {} from {from}.{more}", format::distance(*along_m))
}

/// Which dock a node belongs to.
pub(super) fn of_dock(dock: &str, is_on_it: bool) -> String {
    if is_on_it {
        format!("The robot charges here: {dock}.")
    } else {
        format!("From here the robot looks for {dock} and aligns itself.")
    }
}

/// `Dock 1 · N3`.
pub(super) fn dock_row(dock: &str, node: &str) -> String {
    format!("{dock} · {node}")
}

pub(super) fn dock(name: &str) -> String {
    format!("Dock {name}")
}

/// What decides whether the robot is at a node.
pub(super) fn influence_remark(has_area: bool) -> &'static str {
    if has_area {
        "The robot is at the node also while its middle is in this area. Metres from the node: x ahead, y to the left."
    } else {
        "The robot is at the node while it is as near as it has to come, and a little farther."
    }
}

/// What blocks an edge, until when, and how often it was tried. `left`: the time until it is tried again, if the robot's clock is known.
pub(super) fn blocked(ends: &str, left: Option<&str>, block: &EdgeBlock) -> String {
    let EdgeBlock { failures, reason, .. } = block;
    let until = left.map_or_else(String::new, |left| format!(" for {left} more"));
    let tries = match failures {
        0 | 1 => String::new(),
        failures => format!(" It was tried {failures} times in a row."),
    };
    let reason =
        if reason.is_empty() { String::new() } else { format!(" {}.", reason.trim_end_matches('.')) };
    format!("{ends} is not used{until}.{reason}{tries}")
}

/// Accessible name of a block.
pub(super) fn block_of(ends: &str) -> String {
    format!("Block of {ends}")
}

pub(super) fn show_edge(ends: &str) -> String {
    format!("Show {ends}")
}

pub(super) fn unblock(ends: &str) -> String {
    format!("Unblock {ends} now")
}

/// Who holds a group, and what of.
pub(super) fn held(hold: &MutexHold, edges: usize) -> String {
    let of = counted(edges as u32, "edge", "edges");
    let them = if edges == 1 { "it" } else { "them" };
    format!("{} holds {} ({of}). The robot waits before {them}.", hold.holder, hold.group)
}

pub(super) fn hold_group(group: &str) -> String {
    format!("Hold {group}")
}

pub(super) fn release_group(group: &str) -> String {
    format!("Release {group}")
}

pub(super) fn floor(floor: i32) -> String {
    format!("Floor {floor}")
}

pub(super) fn delete_nodes(count: usize) -> String {
    format!("Delete {count} nodes")
}

pub(super) fn delete_node(name: &str) -> String {
    format!("Delete node {name}")
}

pub(super) fn edge(from: &str, to: &str) -> String {
    format!("Edge {from} to {to}")
}

pub(super) fn ends(from: &str, to: &str) -> String {
    format!("{from} → {to}")
}

pub(super) fn edge_row(from: &str, to: &str, length_m: f64) -> String {
    format!("{from} → {to} · {}", format::distance(length_m))
}

/// What deleting a node breaks.
pub(super) fn needed_by(missions: &[&str]) -> String {
    format!("Needed by: {}. Their tasks here will have to be changed.", missions.join(", "))
}

/// A sentence on a problem. `name`: of its object.
pub(super) fn problem(problem: &SiteProblem, name: &str) -> String {
    let weight = match problem.kind.severity() {
        ProblemSeverity::Error => "Error",
        ProblemSeverity::Warning => "Warning",
    };
    format!("{weight} · {name}: {}", problem.kind)
}
