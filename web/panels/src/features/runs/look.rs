//! How states of runs and tasks look: colour, sign and word. Colour is never the only sign.

use super::texts;
use crate::icon;
use crate::theme::Tokens;
use client_model::{Model, StoredAttempt};
use egui::Color32;
use site_model::{
    MissionId, RouteActionPlace, RunState, Site, TaskId, TaskPlace, TaskState, TaskStatus, describe_action,
};
use uuid::Uuid;

/// Colour and sign of a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StateStyle {
    pub(super) colour: Color32,
    pub(super) sign: &'static str,
    /// Whether the row has the colour as its ground; else only its edge has.
    pub(super) is_filled: bool,
}

/// The look of a task: done is green, on the way light blue, failed red.
pub(super) fn of_task(tokens: &Tokens, state: TaskState) -> StateStyle {
    let (colour, sign, is_filled) = match state {
        TaskState::Waiting => (tokens.line, icon::CLOCK, false),
        TaskState::Navigating => (tokens.accent, icon::ARROW_RIGHT, true),
        TaskState::Running => (tokens.accent, icon::PLAY, true),
        TaskState::Paused => (tokens.accent, icon::PAUSE, true),
        TaskState::Retriable => (tokens.warn, icon::ARROW_COUNTER_CLOCKWISE, true),
        TaskState::Succeeded => (tokens.good, icon::CHECK, true),
        TaskState::Failed => (tokens.bad, icon::X, true),
        TaskState::Skipped => (tokens.warn, icon::SKIP_FORWARD, false),
        TaskState::Cancelled => (tokens.dim, icon::X, false),
    };
    StateStyle { colour, sign, is_filled }
}

/// The look of a run.
pub(super) fn of_run(tokens: &Tokens, state: RunState) -> StateStyle {
    let (colour, sign) = match state {
        RunState::Queued => (tokens.dim, icon::CLOCK),
        RunState::Running | RunState::Ending => (tokens.accent, icon::PLAY),
        RunState::Paused | RunState::Suspended => (tokens.warn, icon::PAUSE),
        RunState::Restarted => (tokens.warn, icon::ARROW_COUNTER_CLOCKWISE),
        RunState::Succeeded => (tokens.good, icon::CHECK_CIRCLE),
        RunState::PartiallySucceeded => (tokens.warn, icon::CHECK_CIRCLE),
        RunState::Failed => (tokens.bad, icon::X_CIRCLE),
        RunState::Cancelled | RunState::Interrupted => (tokens.dim, icon::X_CIRCLE),
    };
    StateStyle { colour, sign, is_filled: false }
}

/// Name of a mission.
pub(super) fn mission_name(model: &Model, mission: MissionId) -> String {
    let site = model.site.site();
    let name = site.and_then(|site| Some(site.mission(mission)?.name.clone()));
    name.unwrap_or_else(|| texts::DELETED_MISSION.to_owned())
}

/// Name of the place of a task: of its inspection point, or else of its node.
pub(super) fn task_name(site: &Site, mission: MissionId, task: &TaskStatus) -> String {
    let listed =
        site.mission(mission).and_then(|mission| mission.tasks.iter().find(|listed| listed.id == task.task));
    let point = match listed.map(|listed| &listed.place) {
        Some(TaskPlace::InspectionPoint(point)) => site.inspection_point(*point),
        _ => None,
    };
    let node = || task.node.and_then(|node| site.node(node)).map(|node| node.name.clone());
    let of_action = |action: &str| describe_action(action).filter(|known| known.moves_robot);
    if task.node.is_none() && task.action.as_deref().and_then(of_action).is_some() {
        return action_name(task);
    }
    point.map(|point| point.name.clone()).or_else(node).unwrap_or_else(|| texts::DELETED_PLACE.to_owned())
}

/// Name of what an attempt belongs to: the place of a task, or the edge or zone of an action on the way.
pub(super) fn attempt_name(site: &Site, mission: MissionId, attempt: &StoredAttempt) -> String {
    match attempt.details.place {
        None => task_name(site, mission, &status_of(attempt)),
        Some(place) => route_place_name(site, place),
    }
}

/// Name of what an action on the way belongs to.
pub(super) fn route_place_name(site: &Site, place: RouteActionPlace) -> String {
    let node = |node| site.node(node).map(|node| node.name.as_str());
    match place {
        RouteActionPlace::Edge { edge, stage, .. } => {
            let ends = site.edge(edge).and_then(|edge| node(edge.from).zip(node(edge.to)));
            ends.map_or_else(|| texts::DELETED_EDGE.to_owned(), |ends| missions::place_on_edge(ends, stage))
        }
        RouteActionPlace::Zone(zone) => {
            let zone = site.zones().find(|known| known.id == zone);
            zone.map_or_else(|| texts::DELETED_ZONE.to_owned(), |zone| zone.name.clone())
        }
    }
}

/// What is done in a task.
pub(super) fn action_name(task: &TaskStatus) -> String {
    match &task.action {
        None => texts::VISIT.to_owned(),
        Some(action) => describe_action(action).map_or_else(|| action.clone(), |it| it.title.to_owned()),
    }
}

/// An attempt as the status of its task.
pub(super) fn status_of(attempt: &StoredAttempt) -> TaskStatus {
    TaskStatus {
        task: attempt.details.task.unwrap_or(TaskId(Uuid::nil())),
        node: attempt.details.node,
        action: attempt.details.action.clone(),
        state: attempt.state,
        attempt: attempt.attempt,
        failure: None,
    }
}
