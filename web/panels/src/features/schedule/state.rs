//! What the panel keeps between frames: the plan, what is dragged, and the question that is open.

use super::fields::TypedFields;
use super::next_run::NextRun;
use super::plan_cache::CachedPlan;
use missions::{MINUTES_A_DAY, day_number, local_of, minute_number};
use site_model::{LocalDateTime, MissionId, ScheduleId};

/// How occurrences are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum PlanView {
    #[default]
    Week,
    Agenda,
}

/// What the panel keeps between frames.
#[derive(Debug, Default)]
pub(crate) struct SchedulePanel {
    pub(super) view: PlanView,
    pub(super) plan: Option<CachedPlan>,
    pub(super) drag: Option<Drag>,
    pub(super) question: Option<Question>,
    pub(super) typed: TypedFields,
    pub(super) next_run: NextRun,
    /// Whether the grid was scrolled to the morning.
    pub(super) is_scrolled: bool,
}

/// Times that a drag can end at are multiples of this, minutes.
pub(super) const SNAP_MIN: i64 = 15;

/// What is dragged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Dragged {
    /// A mission, which gets a schedule.
    Mission(MissionId),
    /// A slot of a schedule.
    Slot(ScheduleId, LocalDateTime),
}

/// A drag that has not ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Drag {
    pub(super) dragged: Dragged,
    /// Whether keys move it; else the pointer does.
    pub(super) by_keys: bool,
    /// Minutes between the beginning of what is dragged and the point where the pointer holds it.
    pub(super) grip_min: f32,
    /// Where it would be dropped; none outside the week.
    pub(super) target: Option<LocalDateTime>,
}

impl Drag {
    /// The pointer is over a day of the week. Its height is a time of day, minutes after midnight, which is rounded to 15 minutes.
    pub(super) fn point_at(&mut self, plan: &CachedPlan, day: usize, minute: f32) {
        let snapped = ((minute - self.grip_min) / SNAP_MIN as f32).round() as i64 * SNAP_MIN;
        let minute = snapped.clamp(0, MINUTES_A_DAY - SNAP_MIN);
        self.target = Some(local_of(day_number(plan.day(day)) * MINUTES_A_DAY + minute));
    }

    /// A key moves it by a number of days and of steps of 15 minutes, within the week that is shown.
    pub(super) fn step(&mut self, plan: &CachedPlan, days: i64, steps: i64) {
        let Some(target) = self.target else { return };
        let first = day_number(plan.week) * MINUTES_A_DAY;
        let moved = minute_number(target) + days * MINUTES_A_DAY + steps * SNAP_MIN;
        if (first..first + 7 * MINUTES_A_DAY).contains(&moved) {
            self.target = Some(local_of(moved));
        }
    }
}

/// An open question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Question {
    /// Which occurrences move.
    Move { schedule: ScheduleId, from: LocalDateTime, to: LocalDateTime },
    /// Which occurrences go.
    Remove { schedule: ScheduleId, slot: LocalDateTime },
}

impl Question {
    pub(super) fn schedule(self) -> ScheduleId {
        match self {
            Self::Move { schedule, .. } | Self::Remove { schedule, .. } => schedule,
        }
    }
}
