//! Runs of missions: one state machine that decides what the robot does next, and the records from which it is rebuilt after a restart.

mod advance;
mod battery;
mod battery_texts;
mod commands;
mod dock_tasks;
mod durable;
mod interface;
mod monitors;
#[cfg(test)]
mod plan_tests;
mod records;
mod restart;
#[cfg(test)]
mod restart_tests;
mod route_actions;
mod run_steps;
mod runner;
mod runner_config;
mod schedule_slots;
mod scheduler;
#[cfg(test)]
mod swarm_tests;
mod table;
mod table_text;
mod task_docking;
mod task_steps;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod transcript_tests;
#[cfg(test)]
mod transcript_words;

pub use battery::{BatteryConfig, CHARGE_SIGNAL, battery_monitors, time_to_dock_p95_s};
pub use durable::events_for_restart;
pub use interface::{
    ActionInfo, ActionResult, GoalRequest, MissionEffect, MissionInput, MissionNotice, MissionSituation,
    RouteGoalResult,
};
pub use monitors::MonitorBank;
pub use records::{Records, RouteActionRecord, Run, TaskRecord};
pub use runner::MissionRunner;
pub use runner_config::RunnerConfig;
pub use scheduler::{DueSlot, Scheduler, SchedulerConfig};
pub use table::{
    RUN_TABLE, RunAction, RunTransition, RunTrigger, TASK_TABLE, TaskAction, TaskGuard, TaskTransition,
    TaskTrigger,
};
pub use table_text::to_markdown;
pub use task_docking::DockTaskConfig;
