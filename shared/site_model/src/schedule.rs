//! Schedules: when missions run. All times are local times of the site's time zone.

use crate::{MissionId, ScheduleId};
use serde::{Deserialize, Serialize};
use vocab::Span;

/// A rule that says when a mission runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Schedule {
    /// Its id.
    pub id: ScheduleId,
    /// Shown to people.
    pub name: String,
    /// What runs.
    pub mission: MissionId,
    /// When.
    pub recurrence: Recurrence,
    /// Whether it is held.
    #[serde(default)]
    pub is_paused: bool,
    /// Slots that do not run.
    #[serde(default)]
    pub skipped: Vec<LocalDateTime>,
    /// How late a slot may still begin.
    #[serde(default = "default_grace")]
    pub grace: Span,
    /// What becomes of slots that were missed, as while the robot was switched off.
    #[serde(default)]
    pub missed: MissedSlots,
    /// What happens if another mission runs.
    #[serde(default)]
    pub overlap: OverlapPolicy,
    /// Of two slots at the same time, that of greater priority runs first.
    #[serde(default)]
    pub priority: i32,
}

impl Schedule {
    /// A schedule that is held, with the usual policies.
    pub fn new(id: ScheduleId, name: String, mission: MissionId, recurrence: Recurrence) -> Self {
        Self {
            id,
            name,
            mission,
            recurrence,
            is_paused: false,
            skipped: Vec::new(),
            grace: default_grace(),
            missed: MissedSlots::default(),
            overlap: OverlapPolicy::default(),
            priority: 0,
        }
    }
}

/// 15 minutes.
fn default_grace() -> Span {
    Span::from_millis(15 * 60 * 1000)
}

/// When a schedule has its slots.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Recurrence {
    /// Once.
    Once(LocalDateTime),
    /// Every week.
    Weekly {
        /// On these days.
        days: Weekdays,
        /// At these times.
        times: Vec<LocalTime>,
        /// From this day on.
        first_day: LocalDate,
        /// Until this day, inclusive; none: without an end.
        #[serde(default)]
        last_day: Option<LocalDate>,
    },
    /// In equal intervals.
    Every {
        /// The first slot.
        first: LocalDateTime,
        /// Time between two slots.
        interval: Span,
    },
    /// A recurrence rule of RFC 5545.
    Rule {
        /// The first slot (DTSTART).
        first: LocalDateTime,
        /// The rule (RRULE), such as `FREQ=DAILY;INTERVAL=2`.
        rule: String,
    },
}

/// What becomes of missed slots.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MissedSlots {
    /// They do not run.
    Skip,
    /// The last one runs, if its grace has not passed.
    #[default]
    RunOnce,
    /// All run whose grace has not passed.
    RunAll,
}

/// What happens to a slot while another mission runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OverlapPolicy {
    /// It does not run.
    Skip,
    /// It runs afterwards; one at most waits.
    #[default]
    Queue,
    /// It ends the other one.
    Replace,
}

/// A day of the week.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs, reason = "the days need no description")]
pub enum Weekday {
    Monday,
    Tuesday,
    Wednesday,
    Thursday,
    Friday,
    Saturday,
    Sunday,
}

/// Days of the week.
pub type Weekdays = std::collections::BTreeSet<Weekday>;

/// A day of the Gregorian calendar.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct LocalDate {
    /// Year.
    pub year: i16,
    /// Month, from 1.
    pub month: u8,
    /// Day of the month, from 1.
    pub day: u8,
}

impl LocalDate {
    /// Whether the calendar has this day.
    pub fn is_valid(self) -> bool {
        let is_leap = self.year % 4 == 0 && (self.year % 100 != 0 || self.year % 400 == 0);
        let days = match self.month {
            1 | 3 | 5 | 7 | 8 | 10 | 12 => 31,
            4 | 6 | 9 | 11 => 30,
            2 if is_leap => 29,
            2 => 28,
            _ => 0,
        };
        (1..=days).contains(&self.day)
    }
}

/// A time of day.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct LocalTime {
    /// Hour, 0 to 23.
    pub hour: u8,
    /// Minute, 0 to 59.
    pub minute: u8,
}

impl LocalTime {
    /// Whether the clock shows this time.
    pub fn is_valid(self) -> bool {
        self.hour < 24 && self.minute < 60
    }
}

/// A time of a day.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct LocalDateTime {
    /// Day.
    pub date: LocalDate,
    /// Time.
    pub time: LocalTime,
}

impl LocalDateTime {
    /// Whether calendar and clock have both.
    pub fn is_valid(self) -> bool {
        self.date.is_valid() && self.time.is_valid()
    }
}
