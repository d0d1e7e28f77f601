//! Schedules: which one the operator works on, the occurrences that they have, and edits of them. The schedules themselves are objects of the site, which slice
//! `site` holds.

mod durations;
mod edits;
mod occurrences;
mod recurrence;
mod selection;
mod week_layout;

pub use durations::expected_durations;
pub use edits::ChangeScope;
pub use occurrences::{Occurrence, OccurrenceState, SchedulePlan, conflicts_of, plan_schedules};
pub use recurrence::first_slot;
pub use selection::ScheduleSelection;
pub use week_layout::{DaySegment, ShownSpan, lay_out_week, week_of};

use super::Feature;
use crate::ClientCommand;
use crate::shared::Context;
use site_model::LocalDate;

/// What the operator looks at.
#[derive(Clone, Debug, Default)]
pub struct ScheduleFeature {
    selection: Option<ScheduleSelection>,
    week: Option<LocalDate>,
}

impl ScheduleFeature {
    /// What is selected.
    pub fn selection(&self) -> Option<ScheduleSelection> {
        self.selection
    }

    /// A day of the week that is shown; none: the current week.
    pub fn week(&self) -> Option<LocalDate> {
        self.week
    }
}

impl Feature for ScheduleFeature {
    fn on_command(&mut self, command: &ClientCommand, _cx: &mut Context<'_>) {
        match command {
            ClientCommand::SelectSchedule(selection) => self.selection = *selection,
            ClientCommand::ShowWeek(week) => self.week = *week,
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests;
