//! Missions: planning on the topological map, the order of tasks, schedules, monitors, and the runs themselves.
//!
//! Everything here is a pure function of its input: no clock, no file, no random number, no thread. Calendar time is an input, and so are the answers of whoever
//! walks and acts. [`MissionRunner`] is the one state machine. Its transitions are data ([`RUN_TABLE`], [`TASK_TABLE`]), and `docs/missions.md` is printed from them.
//! What it decides is committed as events before anything acts on it, and a runner is rebuilt from these events after a restart.
//!
//! The crate is small and knows neither robots nor the stack, so that a browser can plan, order and preview with the same code.

mod action_time;
mod calendar;
mod graph;
mod ids;
mod order;
mod poses;
mod routes;
mod runs;
#[cfg(test)]
mod testing;
mod texts;

pub use action_time::ActionTimeConfig;
pub use calendar::{
    ClockChange, MINUTES_A_DAY, RecurrenceRule, RuleError, SiteZone, Slot, Slots, ZoneError, date_of,
    day_number, local_of, minute_number, weekday_of,
};
pub use graph::{
    Closure, DockConfig, DockOffset, EdgeBlockConfig, GraphLocaliser, GraphLocaliserConfig, GraphPlace,
    LearnedTime, LearnedTimes, NoRoute, Route, RouteConditions, RouteConfig, RouteGraph, RouteTree,
    docked_at, is_blocked, next_block,
};
pub use ids::turn_leg_id;
pub use order::{
    OrderPreview, RouteCost, Tour, TourConfig, TourError, TourProblem, node_of, order_tasks,
    solve as solve_tour,
};
pub use poses::turned;
pub use routes::{
    LegKind, LegResult, LegWalk, RouteAttempt, RouteEffect, RouteExecutor, RouteExecutorConfig,
    RouteRemaining, RouteView,
};
pub use runs::{
    ActionInfo, ActionResult, BatteryConfig, CHARGE_SIGNAL, DockTaskConfig, DueSlot, GoalRequest,
    MissionEffect, MissionInput, MissionNotice, MissionRunner, MissionSituation, MonitorBank, RUN_TABLE,
    Records, RouteActionRecord, RouteGoalResult, Run, RunAction, RunTransition, RunTrigger, RunnerConfig,
    Scheduler, SchedulerConfig, TASK_TABLE, TaskAction, TaskGuard, TaskRecord, TaskTransition, TaskTrigger,
    battery_monitors, events_for_restart, time_to_dock_p95_s, to_markdown,
};
pub use texts::{notice, place_on_edge, reach_failure, skip_reason, task_failure};
