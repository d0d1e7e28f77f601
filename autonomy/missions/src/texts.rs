//! Sentences for people, by key.

use crate::runs::{BatteryConfig, MissionNotice, RunAction, TaskAction, TaskGuard, battery_monitors};
use site_model::{EdgeStage, MissionId, ReachFailure, RunState, Site, SkipReason, TaskFailure, TaskState};

pub(crate) const RUN_UNKNOWN: &str = "There is no such run any more. Reload the page.";
pub(crate) const RUN_EXISTS: &str = "A run with this id exists already. Make another id.";
pub(crate) const MISSION_UNKNOWN: &str = "There is no such mission. It may have been deleted.";
pub(crate) const MISSION_EMPTY: &str = "The mission has no tasks. Add one first.";
pub(crate) const TASK_UNKNOWN: &str = "The run has no such task. Reload the page.";
pub(crate) const ALREADY_QUEUED: &str = "This mission is in the queue already.";
pub(crate) const QUEUE_FULL: &str = "The queue is full. Remove a run from it first.";
pub(crate) const OTHER_RUN: &str = "Another run is under way. Queue this one, or end the other first.";
pub(crate) const BLOCKED: &str = "A monitor blocks missions, such as for a low battery. Queue the mission: it begins when the monitor permits.";
pub(crate) const CANNOT_MOVE: &str = "Motion is stopped, or somebody drives. Press \"Allow motion\" first.";
pub(crate) const NOT_POSSIBLE_NOW: &str = "The run is in another state now, in which this is not possible.";
pub(crate) const NO_QUESTION: &str = "This question was answered already.";
pub(crate) const CANCELLED_BY_PROGRAM: &str = "The program that offers the action has cancelled it.";
pub(crate) const RESUME_WHEN_FREE: &str =
    "Motion is stopped, or somebody drives. Allow motion first, then resume.";

/// Why an action on the way is not called.
pub(crate) const ROUTE_ACTION_UNKNOWN: &str =
    "It was begun before the restart, and it is not known how it ended. Nobody has permitted to do it again.";

/// Why an action on the way has failed.
pub(crate) const ACTION_NOT_OFFERED: &str = "No program offers this action now.";

/// Why charging in a dock has failed.
pub(crate) const NOT_CHARGED_ANY_MORE: &str =
    "The robot was not charged any more. Check that it stands in the dock, and that the dock has power.";

pub(crate) const PATH_BLOCKED: &str = "The way was blocked.";

/// An action of an edge that was cancelled because it did not end.
pub(crate) const ACTION_SILENT: &str = "It did not end in its time.";

/// An action on entering an edge has failed for `reason`, a sentence.
pub(crate) fn edge_action_failed(action: &str, reason: &str) -> String {
    format!("The action {action} at the beginning of the edge failed: {reason}")
}

/// Where the robot stood when the way stayed blocked.
pub(crate) fn path_blocked(at: vocab::Vec3) -> String {
    format!("The way stayed blocked when the robot stood at x {:.1} m, y {:.1} m.", at.x, at.y)
}

/// What a notice says. Names are those of the site; what the site lacks by now is told without its name.
pub fn notice(notice: MissionNotice, site: &Site) -> String {
    match notice {
        MissionNotice::RunEnded { mission, outcome, succeeded, tasks } => {
            run_ended(&mission_name(site, mission), outcome, succeeded, tasks)
        }
        MissionNotice::Question(..) => {
            "A run asks what becomes of a task. Answer it, or the default is taken after its time.".to_owned()
        }
        MissionNotice::NoDockReached => {
            "The robot did not reach any dock. It tries again by itself; drive it to a dock by hand if it cannot.".to_owned()
        }
        MissionNotice::ClockNotSynchronised => {
            "The clock follows no time server, so schedules wait. Check the network, or the time server's settings.".to_owned()
        }
        MissionNotice::ScheduleUnusable(schedule) => {
            let name = site.schedule(schedule).map_or("A schedule", |schedule| &schedule.name);
            format!("{name} cannot be used: check the rule of this schedule, and the site's time zone.")
        }
        MissionNotice::MonitorHolds(monitor) => {
            let built_in = battery_monitors(&BatteryConfig::default());
            let known = site.monitors().chain(&built_in).find(|known| known.id == monitor);
            format!("The condition of {} holds.", known.map_or("a monitor", |monitor| &monitor.name))
        }
        MissionNotice::PlanKept(_) => {
            "The site has changed and lacks something that the run needs. The run goes on with its own plan.".to_owned()
        }
        MissionNotice::ActionSilent(_) => {
            "An action did not end after it was cancelled. Check the program that offers it.".to_owned()
        }
    }
}

fn mission_name(site: &Site, mission: MissionId) -> String {
    site.mission(mission).map_or_else(|| "A deleted mission".to_owned(), |mission| mission.name.clone())
}

/// That a run of this mission has ended, and what it has done.
fn run_ended(mission: &str, outcome: RunState, succeeded: usize, tasks: usize) -> String {
    match outcome {
        RunState::Cancelled if tasks == 0 => format!("{mission} was taken from the queue."),
        RunState::Cancelled => {
            format!("{mission} was ended by a person. {succeeded} of {tasks} tasks are done.")
        }
        RunState::Interrupted => {
            format!("{mission} was ended by a monitor or a schedule. {succeeded} of {tasks} tasks are done.")
        }
        RunState::Succeeded if tasks == 1 => format!("{mission} has ended: its task is done."),
        RunState::Succeeded => format!("{mission} has ended: all {tasks} tasks are done."),
        RunState::Failed if tasks == 1 => format!("{mission} has failed: its task is not done."),
        RunState::Failed => format!("{mission} has failed: none of {tasks} tasks is done."),
        _ => format!("{mission} has ended in part: {succeeded} of {tasks} tasks are done."),
    }
}

/// Where on an edge something is done: `Hall to Lift, at its beginning`.
pub fn place_on_edge((from, to): (&str, &str), stage: EdgeStage) -> String {
    let at = match stage {
        EdgeStage::Enter => "at its beginning",
        EdgeStage::During => "on it",
        EdgeStage::Leave => "at its end",
    };
    format!("{from} to {to}, {at}")
}

/// Why a task failed.
pub fn task_failure(failure: &TaskFailure) -> String {
    let text = match failure {
        TaskFailure::RouteActionUnknown(action) => {
            return format!(
                "On the way, the action {action} was begun before the restart, and it is not known how it ended. Look, then try again, or leave the task out."
            );
        }
        TaskFailure::NotReached(reason) => return reach_failure(reason),
        TaskFailure::ActionFailed(reason) => return reason.clone(),
        TaskFailure::ActionUnavailable => "No program offers this action now. Start it, then redo the task.",
        TaskFailure::ActionTimedOut => "The action did not end in its time.",
        TaskFailure::OutcomeUnknown => {
            "The action was begun before the restart, and it is not known how it ended. Look, then skip or redo the task."
        }
    };
    text.to_owned()
}

/// Why a place was not reached.
pub fn reach_failure(failure: &ReachFailure) -> String {
    let text = match failure {
        ReachFailure::NoRoute { closed } if !closed.is_empty() => {
            return format!("No route leads to the place: {} edges of the way are closed.", closed.len());
        }
        ReachFailure::NoSuchPlace => "The place does not exist any more. Choose another for the task.",
        ReachFailure::NoRoute { .. } => "No edges lead to the place. Connect it in the topological map.",
        ReachFailure::PathBlocked => "The path stayed blocked.",
        ReachFailure::PoseNotFound => "The robot searched for its pose in the map and did not find it.",
        ReachFailure::MapReplaced => "The map was replaced.",
        ReachFailure::NotUndocked => "The robot could not leave its dock.",
        ReachFailure::NotDocked => "The robot was not charged in the dock after all attempts.",
        ReachFailure::DockNotSeen => "The robot saw no dock where the map has it.",
    };
    text.to_owned()
}

/// Why a slot did not run.
pub fn skip_reason(reason: SkipReason) -> &'static str {
    match reason {
        SkipReason::Requested => "left out by a person",
        SkipReason::SchedulePaused => "the schedule was paused",
        SkipReason::Missed => "noticed too late, as after the robot was switched off",
        SkipReason::LaterSlotRuns => "a later slot runs instead",
        SkipReason::OtherRun(_) => "another run was under way",
        SkipReason::AlreadyQueued(_) => "a run of this schedule waits already",
        SkipReason::QueueFull => "the queue was full",
        SkipReason::Blocked(_) => "a monitor blocked missions for too long",
        SkipReason::NoMission => "the mission does not exist or has no tasks",
        SkipReason::SameInstant => "due at the same instant as another slot, because clocks go forward",
    }
}

pub(crate) fn run_state(state: RunState) -> &'static str {
    match state {
        RunState::Queued => "It waits for its turn.",
        RunState::Running => "Its tasks are done.",
        RunState::Paused => "A person, a stop of motion or a monitor has paused it. A person resumes it.",
        RunState::Suspended => "A monitor has interrupted it. It goes on by itself.",
        RunState::Restarted => {
            "The program was restarted. It goes on by itself once the robot's place is known."
        }
        RunState::Ending => {
            "Its outcome is decided. The robot finishes its action and goes where the run ends."
        }
        RunState::Succeeded => "All tasks succeeded.",
        RunState::PartiallySucceeded => "Some tasks succeeded.",
        RunState::Failed => "No task succeeded.",
        RunState::Cancelled => "A person ended it.",
        RunState::Interrupted => "A monitor or a schedule ended it.",
    }
}

pub(crate) fn task_state(state: TaskState) -> &'static str {
    match state {
        TaskState::Waiting => "It has not begun.",
        TaskState::Navigating => "The robot goes to its place.",
        TaskState::Running => "Its action is performed.",
        TaskState::Paused => "The robot was on its way when the run was paused.",
        TaskState::Retriable => "An attempt has failed. It is tried again, or a person is asked.",
        TaskState::Succeeded => "It was done.",
        TaskState::Failed => "It could not be done.",
        TaskState::Skipped => "A person, or an answer that nobody gave in time, left it out.",
        TaskState::Cancelled => "The run ended before it was done.",
    }
}

pub(crate) fn run_action(action: RunAction) -> &'static str {
    match action {
        RunAction::PauseTask => "stop walking; an action that was begun is finished",
        RunAction::InterruptTask => "stop walking; cancel the action",
        RunAction::StopTask => "stop walking; cancel the action; end the task",
        RunAction::FinishTask => "stop walking; an action that was begun is finished; end the task",
        RunAction::GoToEnd => "outcome of the tasks; go where the mission ends",
        RunAction::GoToDock => "outcome of the tasks; go to a dock",
        RunAction::Stay => "outcome of the tasks; stay",
        RunAction::EndCancelled => "outcome \"cancelled\"; stay",
        RunAction::EndInterrupted => "outcome \"interrupted\"; stay",
        RunAction::CancelTasks => "cancel all tasks that have not ended",
    }
}

pub(crate) fn task_guard(guard: TaskGuard) -> &'static str {
    match guard {
        TaskGuard::Always => "",
        TaskGuard::WithAction => "something is done there",
        TaskGuard::WithoutAction => "only visited",
        TaskGuard::RetriesLeft => "attempts are left",
        TaskGuard::TriesLater => "policy: try later, the first time",
        TaskGuard::Asks => "policy: ask",
        TaskGuard::GoesOn => "policy: go on",
        TaskGuard::EndsAtDock => "policy: end at a dock",
        TaskGuard::EndsHere => "policy: end here",
        TaskGuard::Idempotent => "can be repeated without harm",
        TaskGuard::NotIdempotent => "cannot be repeated without harm",
        TaskGuard::ForSkip => "for a skip",
        TaskGuard::ForEnd => "for the end of the run",
        TaskGuard::ForInterrupt => "for an interruption",
    }
}

pub(crate) fn task_action(action: TaskAction) -> &'static str {
    match action {
        TaskAction::RequestGoal => "request the goal once this is durable",
        TaskAction::CallAction => "call the action once this is durable",
        TaskAction::CancelGoal => "cancel the goal",
        TaskAction::CancelAction => "cancel the action; the task changes when that has ended",
        TaskAction::Ask => "ask a person",
        TaskAction::EndRunAtDock => "end the run at a dock",
        TaskAction::EndRunHere => "end the run here",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_notice_of_an_ended_run_names_its_mission_and_its_outcome() {
        let text = |outcome, succeeded, tasks| run_ended("Round A", outcome, succeeded, tasks);
        assert_eq!(text(RunState::Succeeded, 9, 9), "Round A has ended: all 9 tasks are done.");
        assert_eq!(text(RunState::Failed, 0, 9), "Round A has failed: none of 9 tasks is done.");
        let part = "Round A has ended in part: 7 of 9 tasks are done.";
        assert_eq!(text(RunState::PartiallySucceeded, 7, 9), part);
        assert_eq!(text(RunState::Cancelled, 0, 0), "Round A was taken from the queue.");
        let ended = "Round A was ended by a person. 2 of 9 tasks are done.";
        assert_eq!(text(RunState::Cancelled, 2, 9), ended);
    }
}
