//! The clock of the operator's machine, which the page reads for every frame.

use site_model::Utc;

/// Calendar time and time zone of the operator's machine.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PageClock {
    /// The calendar time.
    pub utc: Utc,
    /// Offset of local time from UTC, seconds.
    pub utc_offset_s: i64,
    /// Name of the time zone in the IANA database; empty if the browser does not tell it.
    pub zone: String,
}
