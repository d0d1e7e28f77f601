//! Texts of the mission editor, by key.

use crate::format;
use site_model::MissionEnd;

pub(super) const BACK: &str = "All missions";
pub(super) const NAME: &str = "Mission name";
pub(super) const UNDO: &str = "Undo edit";
pub(super) const REDO: &str = "Redo edit";
pub(super) const TIME: &str = "Expected time";
pub(super) const CHARGE: &str = "Expected charge";
pub(super) const ROUTE: &str = "Way";
pub(super) const EMPTY: &str = "Drag places and actions here.";
pub(super) const DROP_HERE: &str = "Drop here";
pub(super) const ADD: &str = "Add tasks";
pub(super) const USE_ORDER: &str = "Use this order";
pub(super) const KEEP_ORDER: &str = "Keep my order";
pub(super) const ORDER_HEAD: &str = "Order";
pub(super) const AS_LISTED: &str = "As listed";
pub(super) const SHORTEST: &str = "Shortest";
pub(super) const SHORTEST_HINT: &str =
    "Each run takes the shortest way from where the robot is. The numbers show it from the start above.";
pub(super) const KEEP_FIRST: &str = "Keep the first";
pub(super) const KEEP_LAST: &str = "Keep the last";
pub(super) const END_HEAD: &str = "Afterwards";
pub(super) const END_NODE: &str = "Go to node";
pub(super) const NO_START: &str = "The site has no node to start from.";
pub(super) const OTHER_MAP: &str = "The way is drawn in the site's map, which is not on the screen.";
pub(super) const VIEW_ITS_MAP: &str = "View its map";
pub(super) const RUN_NOW: &str = "Run now";
pub(super) const QUEUE: &str = "Queue";
pub(super) const NOT_CONNECTED: &str = "Not connected.";
pub(super) const NO_TASKS: &str = "Add a task first.";
pub(super) const UNCONFIRMED: &str = "Waiting until the robot has the last edit.";

/// Where the robot goes afterwards: the choices, without the node.
pub(super) const ENDS: [(&str, MissionEnd); 2] =
    [("Nearest dock", MissionEnd::NearestDock), ("Stay there", MissionEnd::Stay)];

pub(super) const NODE_CHOICE: &str = "A node";

pub(super) fn task(number: usize, title: &str) -> String {
    format!("Task {number} {title}")
}

pub(super) fn move_task(number: usize, title: &str) -> String {
    format!("Move task {number} {title}")
}

pub(super) fn problem_of(number: usize) -> String {
    format!("Problem of task {number}")
}

pub(super) fn of_action(action: &str, sentence: &str) -> String {
    format!("{action}: {sentence}")
}

/// An action, and the numbers of the tasks that come before it: `Photo · after 1, 3`.
pub(super) fn noted(action: &str, before: &[usize]) -> String {
    if before.is_empty() {
        return action.to_owned();
    }
    let numbers: Vec<String> = before.iter().map(usize::to_string).collect();
    format!("{action} · after {}", numbers.join(", "))
}

pub(super) fn selected(count: usize) -> String {
    format!("{count} tasks selected")
}

/// A time with its seconds: `42 s`, `11 min 20 s`, `1 h 02 min`.
pub(super) fn time(seconds: f64) -> String {
    let whole = seconds.max(0.0).round() as u64;
    match (whole / 3600, whole / 60 % 60, whole % 60) {
        (0, 0, seconds) => format!("{seconds} s"),
        (0, minutes, 0) => format!("{minutes} min"),
        (0, minutes, seconds) => format!("{minutes} min {seconds} s"),
        (hours, minutes, _) => format!("{hours} h {minutes:02} min"),
    }
}

/// Charge that a mission takes: `12 %`.
pub(super) fn charge(used: f64) -> String {
    format!("{:.0} %", (100.0 * used).ceil())
}

pub(super) fn route(length_m: f64) -> String {
    if length_m < 1000.0 { format!("{length_m:.0} m") } else { format::distance(length_m) }
}

/// What a drag adds: `+0:38, +12 m`.
pub(super) fn drag_cost(time_s: f64, length_m: f64) -> String {
    let sign = |value: f64| if value < 0.0 { "−" } else { "+" };
    let time_s = time_s.round();
    let length_m = length_m.round();
    format!("{}{}, {}{:.0} m", sign(time_s), format::elapsed(time_s.abs()), sign(length_m), length_m.abs())
}

pub(super) fn optimise(saved_s: f64) -> String {
    format!("Optimise: −{}", time(saved_s))
}

/// What the shortest order gains.
pub(super) fn gain(saved_s: f64, saved_m: f64, is_shortest: bool) -> String {
    let order = if is_shortest { "The shortest order" } else { "A shorter order" };
    if saved_m < 0.5 {
        format!("{order} saves {}. The list and the map show it.", time(saved_s))
    } else {
        format!(
            "{order} saves {} and {} of walking. The list and the map show it.",
            time(saved_s),
            route(saved_m)
        )
    }
}

/// What always taking the shortest order gains.
pub(super) fn always_gains(saved_s: f64) -> String {
    format!("Saves {} against the order of the list.", time(saved_s))
}

pub(super) fn from_dock(name: &str) -> String {
    format!("From {name}")
}

pub(super) fn from_robot(node: &str) -> String {
    format!("From where the robot is, near {node}")
}

pub(super) fn from_task(node: &str) -> String {
    format!("From the first task, at {node}")
}

pub(super) fn back_to(place: &str) -> String {
    format!("Then to {place}")
}

pub(super) const STAYS: &str = "Then the robot stays there";

/// How a task is moved by keys.
pub(super) const MOVING: &str = "Moving tasks: ↑ and ↓ move them, Enter drops them, Esc puts them back.";

pub(super) fn running(count: usize) -> String {
    match count {
        1 => "One run of this mission is under way or waits.".to_owned(),
        count => format!("{count} runs of this mission are under way or wait."),
    }
}

pub(super) fn cannot_be_done(count: usize) -> String {
    match count {
        1 => "One task cannot be done. The robot will leave it out as its policy says.".to_owned(),
        count => {
            format!("{count} tasks cannot be done. The robot will leave them out as their policies say.")
        }
    }
}
