//! Texts of tasks, by key: what they are, what is wrong with them, and their form.

use crate::features::action_form::{parameter_problem, shown_unit};
use crate::format;
use client_model::{EndProblem, ParameterField, StopProblem};
use missions::{Closure, NoRoute};
use site_model::{AskDefault, FailureStep, NodeId, Site};

pub(super) const VISIT: &str = "Visit";
pub(super) const NO_ACTION: &str = "None, only visit";
pub(super) const MISSING_POINT: &str = "Deleted inspection point";
pub(super) const MISSING_NODE: &str = "Deleted node";
pub(super) const PRESENT_DOCK: &str = "Out of its dock";
pub(super) const PLACE: &str = "Place";
pub(super) const ACTION: &str = "Action";
pub(super) const ACTION_OF_POINT: &str =
    "The inspection point says what is done here. Change it on the Site screen.";
pub(super) const UNKNOWN_ACTION: &str =
    "The fields of this action are not known. Its parameters are kept as they are.";
pub(super) const UNREACHABLE_HEAD: &str = "If the place cannot be reached";
pub(super) const FAILURE_HEAD: &str = "If the action fails";
pub(super) const FURTHER_TRIES: &str = "Further tries";
pub(super) const THEN: &str = "Then";
pub(super) const ASK_TIME: &str = "Wait for an answer";
pub(super) const ASK_DEFAULT: &str = "Without an answer";
pub(super) const MOVE_UP: &str = "Move up";
pub(super) const MOVE_DOWN: &str = "Move down";
pub(super) const DUPLICATE: &str = "Duplicate task";
pub(super) const DELETE: &str = "Delete task";

/// Numbers of further tries that can be chosen.
pub(super) const RETRIES: [u8; 6] = [0, 1, 2, 3, 5, 10];
/// Times to wait for an answer that can be chosen, minutes.
pub(super) const ASK_MINUTES: [i64; 5] = [1, 5, 15, 60, 240];

/// Steps after the last try, in the order of the list. The last one is asking a person.
pub(super) const STEPS: [&str; 5] =
    ["Skip it", "Try again later", "End at a dock", "End here", "Ask a person"];
/// Without an answer, in the order of the list.
pub(super) const ASK_DEFAULTS: [(&str, AskDefault); 3] = [
    ("Skip it", AskDefault::Skip),
    ("End at a dock", AskDefault::EndAtDock),
    ("End here", AskDefault::EndHere),
];

/// The place of a step in [`STEPS`].
pub(super) fn step_index(step: FailureStep) -> usize {
    match step {
        FailureStep::Skip => 0,
        FailureStep::TryLater => 1,
        FailureStep::EndAtDock => 2,
        FailureStep::EndHere => 3,
        FailureStep::Ask { .. } => 4,
    }
}

pub(super) fn retries(count: u8) -> String {
    match count {
        0 => "None".to_owned(),
        count => count.to_string(),
    }
}

pub(super) fn minutes(minutes: i64) -> String {
    format::duration(60.0 * minutes as f64)
}

/// An accessible name of a control of one of two policies. `head` is that of the policy.
pub(super) fn of_policy(head: &str, caption: &str) -> String {
    format!("{head}: {caption}")
}

pub(super) fn node_option(name: &str) -> String {
    format!("Node {name}")
}

pub(super) fn point_option(name: &str) -> String {
    format!("Point {name}")
}

/// Head of the order constraints of a task.
pub(super) const ORDER_HEAD: &str = "Order, also where the shortest way is taken";
pub(super) const ADD_AFTER: &str = "Comes after";
pub(super) const ADD_BEFORE: &str = "Comes before";
pub(super) const CHOOSE_TASK: &str = "A task";
pub(super) const MISSING_TASK: &str = "a deleted task";
/// Accessible name of what is wrong with the order constraints.
pub(super) const ORDER_PROBLEM: &str = "Problem of the order";
pub(super) const MEND_LIST: &str = "Put the list in this order";

/// A constraint as a task has it.
pub(super) fn order_row(is_after: bool, other: &str) -> String {
    if is_after { format!("After {other}") } else { format!("Before {other}") }
}

pub(super) fn before_row(first: &str, second: &str) -> String {
    format!("{first} before {second}")
}

pub(super) fn remove_order(row: &str) -> String {
    format!("Remove: {row}")
}

/// Tasks that wait for each other.
pub(super) fn circle(titles: &[String]) -> String {
    match titles {
        [one] => format!("{one} would have to come before itself. Remove this."),
        _ => {
            let first = titles.first().map_or("", String::as_str);
            format!("No order is possible: {} → {first}. Remove one of these.", titles.join(" → "))
        }
    }
}

/// A list that has two tasks the wrong way round.
pub(super) fn against_list([first, second]: &[String; 2]) -> String {
    format!("{first} has to come before {second}, but the list has them the other way round.")
}

/// Why a task cannot be done: a sentence.
pub(super) fn stop_problem(site: &Site, problem: &StopProblem) -> String {
    match problem {
        StopProblem::NoPlace => "Its place was deleted. Choose another one, or delete the task.".to_owned(),
        StopProblem::NoDock => {
            "The site has no dock. Add one on the Site screen, or delete the task.".to_owned()
        }
        StopProblem::NoRoute(from, reason) => no_route(site, *from, reason),
        StopProblem::Parameter(field, problem) => {
            let ParameterField { title, .. } = &**field;
            let (unit, scale) = shown_unit(field);
            parameter_problem(title, unit, scale, *problem)
        }
    }
}

/// Why a mission cannot end where it should: a sentence.
pub(super) fn end_problem(site: &Site, problem: &EndProblem) -> String {
    match problem {
        EndProblem::NoDock => "The site has no dock: the robot stays where the last task is.".to_owned(),
        EndProblem::NoRoute(from, reason) => no_route(site, *from, reason),
    }
}

/// Why there is no route from a node: a sentence.
fn no_route(site: &Site, from: NodeId, reason: &NoRoute) -> String {
    let name = |node: NodeId| site.node(node).map_or("?", |node| node.name.as_str());
    match reason {
        NoRoute::NoSuchNode(_) => "Its node was deleted.".to_owned(),
        NoRoute::NotConnected => format!("No way from {}: no edges lead there.", name(from)),
        NoRoute::Closed { edges } => {
            let Some((edge, closure)) = edges.first() else { return format!("No way from {}.", name(from)) };
            let ends = site
                .edge(*edge)
                .map_or_else(String::new, |edge| format!("{} → {}", name(edge.from), name(edge.to)));
            let why = match closure {
                Closure::Disabled => format!("routes may not use {ends}"),
                Closure::Blocked(block) if block.reason.is_empty() => format!("{ends} is blocked"),
                Closure::Blocked(block) => {
                    format!("{ends} is blocked ({})", block.reason.trim_end_matches('.'))
                }
                Closure::KeepOut(_) => format!("{ends} crosses a keep-out zone"),
            };
            format!("No way from {}: {why}.", name(from))
        }
    }
}
