//! What the top bar shows of the next run that schedules begin. The panel of schedules computes it.

/// Texts of the next run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct NextRunTexts {
    /// `15:00`, or `Thu 11:00`.
    pub(crate) at: String,
    /// Name of the schedule.
    pub(crate) schedule: String,
}
