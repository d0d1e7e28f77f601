//! The tables of states and transitions as a page for people.

use super::table::{RUN_TABLE, RunTransition, TASK_TABLE, TaskTransition};
use site_model::{RunState, TaskState};
use std::fmt::Write as _;

/// The text of `docs/missions.md`.
pub fn to_markdown() -> String {
    let mut text = String::from(
        "# The states of runs and tasks\n\nPrinted from `autonomy/missions/src/runs/table.rs` by its test; do not edit. The first row that fits is taken. An event \
         without a row changes nothing. What\nstands in a row is durable before the robot acts on it.\n\n## States of runs\n\n| state | meaning |\n| --- | --- |\n",
    );
    for state in RunState::ALL {
        let _ = writeln!(text, "| {state:?} | {} |", crate::texts::run_state(state));
    }
    text.push_str("\n## Transitions of runs\n\n| from | event | to | actions |\n| --- | --- | --- | --- |\n");
    for RunTransition { from, trigger, to, actions } in RUN_TABLE {
        let to = to.map_or("its outcome".to_owned(), |to| format!("{to:?}"));
        let actions: Vec<_> = actions.iter().map(|action| crate::texts::run_action(*action)).collect();
        let _ = writeln!(text, "| {from:?} | {trigger:?} | {to} | {} |", actions.join("; "));
    }
    text.push_str("\n## States of tasks\n\n| state | meaning |\n| --- | --- |\n");
    for state in TaskState::ALL {
        let _ = writeln!(text, "| {state:?} | {} |", crate::texts::task_state(state));
    }
    text.push_str(
        "\n## Transitions of tasks\n\n| from | event | condition | to | actions |\n| --- | --- | --- | --- | --- |\n",
    );
    for TaskTransition { from, trigger, guard, to, actions } in TASK_TABLE {
        let actions: Vec<_> = actions.iter().map(|action| crate::texts::task_action(*action)).collect();
        let (guard, actions) = (crate::texts::task_guard(*guard), actions.join("; "));
        let _ = writeln!(text, "| {from:?} | {trigger:?} | {guard} | {to:?} | {actions} |");
    }
    text
}
