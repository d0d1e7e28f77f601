//! What tasks that dock need: their parameters, and what is remembered while one of them is under way.

use site_model::{DockId, RunId, TaskId};
use std::collections::BTreeSet;
use vocab::{Span, Stamp};

/// Parameters of docking as a task.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DockTaskConfig {
    /// The charge counts as reached this much below what is asked for. Chosen: half a percent, so that a battery that never reports 100 % is full.
    pub charge_tolerance: f64,
    /// Time without charging current, or without a known place in a dock, after which charging has failed. Chosen: longer than a search for the pose.
    pub max_gap: Span,
}

impl Default for DockTaskConfig {
    fn default() -> Self {
        Self { charge_tolerance: 0.005, max_gap: Span::from_millis(30_000) }
    }
}

/// What is remembered while a task docks. It may be lost in a restart: the nearest dock is tried first then.
#[derive(Clone, Debug, Default)]
pub(super) struct TaskDocking {
    /// The task that the rest belongs to.
    pub of: Option<(RunId, TaskId)>,
    /// The dock to which the robot goes.
    pub dock: Option<DockId>,
    /// Docks that it did not reach.
    pub failed: BTreeSet<DockId>,
    /// Since when it is not charged, while it should be.
    pub gap_began: Option<Stamp>,
}
