//! Parameters of the mission runner.

use super::battery::BatteryConfig;
use super::scheduler::SchedulerConfig;
use crate::action_time::ActionTimeConfig;
use crate::graph::{EdgeBlockConfig, RouteConfig};
use crate::order::TourConfig;
use vocab::Span;

/// Parameters of [`super::MissionRunner`].
#[derive(Clone, Debug, PartialEq)]
pub struct RunnerConfig {
    /// Of route planning.
    pub routes: RouteConfig,
    /// Of edges that could not be walked.
    pub blocks: EdgeBlockConfig,
    /// Of the order of tasks.
    pub tour: TourConfig,
    /// Of schedules.
    pub scheduler: SchedulerConfig,
    /// Of the built-in battery monitors.
    pub battery: BatteryConfig,
    /// Greatest number of queued runs. Chosen: more than a day of missions of an hour; a longer queue is a mistake of a program.
    pub max_queue: usize,
    /// How long the action of a task may take.
    pub action_time: ActionTimeConfig,
    /// Time within which a cancelled action has to end. Chosen: longer than a picture or a reading takes to end.
    pub cancel_time_limit: Span,
    /// Time for an answer where no policy says one: after a restart that found an action begun. Chosen: five minutes, in which a person at the site sees the question.
    pub question_time_limit: Span,
    /// Time until docks are tried again, after none was reached for a monitor. It doubles up to `max_dock_retry`. Chosen: a person or vehicle in front of a dock goes in
    /// that time.
    pub dock_retry: Span,
    /// The longest such time. Chosen: a robot with low charge tries six times in an hour.
    pub max_dock_retry: Span,
}

impl Default for RunnerConfig {
    fn default() -> Self {
        Self {
            routes: RouteConfig::default(),
            blocks: EdgeBlockConfig::default(),
            tour: TourConfig::default(),
            scheduler: SchedulerConfig::default(),
            battery: BatteryConfig::default(),
            max_queue: 32,
            action_time: ActionTimeConfig::default(),
            cancel_time_limit: Span::from_millis(10_000),
            question_time_limit: Span::from_millis(300_000),
            dock_retry: Span::from_millis(30_000),
            max_dock_retry: Span::from_millis(600_000),
        }
    }
}
