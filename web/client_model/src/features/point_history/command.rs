//! What operators ask of the history of an inspection point.

use site_model::{InspectionPointId, Utc};

/// The part of a history that is shown. Hours and days count back from the newest result.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum HistorySpan {
    /// 24 hours.
    Day,
    /// 7 days.
    Week,
    /// 31 days.
    #[default]
    Month,
    /// Everything.
    All,
    /// Between two instants, the earlier one first.
    Between([Utc; 2]),
}

impl HistorySpan {
    /// Its length, nanoseconds; none if it has no fixed one.
    pub(super) fn length_ns(self) -> Option<i64> {
        const HOUR_NS: i64 = 3_600_000_000_000;
        match self {
            Self::Day => Some(24 * HOUR_NS),
            Self::Week => Some(7 * 24 * HOUR_NS),
            Self::Month => Some(31 * 24 * HOUR_NS),
            Self::All | Self::Between(_) => None,
        }
    }
}

/// What the operator asks of the history.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointHistoryCommand {
    /// Show the history of this inspection point.
    Open(InspectionPointId),
    /// Show this part of it.
    ShowSpan(HistorySpan),
    /// Compare this result, by its number, with the one before it, or with the one that is kept.
    Choose(u64),
    /// Choose the result that is this number of results later, or earlier if it is negative.
    Step(i64),
    /// Compare with this result, by its number, whichever is chosen; none: with the one before.
    Keep(Option<u64>),
    /// Ask the robot how the two photos that are compared are aligned, unless that is known. One pair is asked for at a time.
    Align,
    /// Fetch again what could not be fetched.
    Retry,
    /// Save all results as a table. Older ones are fetched first.
    Export,
    /// Do not save them after all.
    CancelExport,
}
