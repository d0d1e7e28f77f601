//! The schedule that the operator works on.

use site_model::{LocalDateTime, ScheduleId};

/// A schedule that is selected, and one of its slots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ScheduleSelection {
    /// The schedule.
    pub schedule: ScheduleId,
    /// The slot; none: the schedule as a whole.
    pub slot: Option<LocalDateTime>,
}
