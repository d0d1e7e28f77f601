//! The time zone of a site.

use super::civil::minute_number;
use jiff::civil::DateTime;
use jiff::tz::{AmbiguousOffset, TimeZone};
use jiff::{Timestamp, civil};
use site_model::{LocalDate, LocalDateTime, LocalTime, Utc};
use vocab::Span;

/// A time zone of the IANA database, as it is compiled into the program. It is right from 2015 on (crate `time_zones`). So the same input has the same slots on every machine, and a new rule of a country comes with an update.
#[derive(Clone, Debug)]
pub struct SiteZone {
    zone: TimeZone,
}

/// Why there is no such zone.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no time zone \"{0}\"; choose a name such as Europe/London")]
pub struct ZoneError(pub String);

/// How a local time meets a change of the clocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClockChange {
    /// It occurs once.
    None,
    /// It does not occur, because clocks go forward over it. It counts with the offset before the change, so it is later by the length of the gap.
    Skipped,
    /// It occurs twice, because clocks go back. The first counts.
    Repeated,
}

impl SiteZone {
    /// The zone of this name.
    ///
    /// # Errors
    /// When there is none.
    pub fn new(name: &str) -> Result<Self, ZoneError> {
        let unknown = || ZoneError(name.to_owned());
        let (name, data) = time_zones::get(name).ok_or_else(unknown)?;
        Ok(Self { zone: TimeZone::tzif(name, data).map_err(|_| unknown())? })
    }

    /// The names of all zones, in alphabetical order.
    pub fn names() -> impl Iterator<Item = &'static str> {
        time_zones::names()
    }

    /// Coordinated universal time.
    pub fn utc() -> Self {
        Self { zone: TimeZone::UTC }
    }

    /// The instant of a local time, as RFC 5545 has it: a time that is skipped counts with the offset before the change, and of a time that is repeated the first.
    /// None outside the years -9998 to 9998, and for days that do not exist.
    pub fn to_utc(&self, at: LocalDateTime) -> Option<(Utc, ClockChange)> {
        let ambiguous = self.zone.to_ambiguous_timestamp(date_time(at)?);
        let change = match ambiguous.offset() {
            AmbiguousOffset::Unambiguous { .. } => ClockChange::None,
            AmbiguousOffset::Gap { .. } => ClockChange::Skipped,
            AmbiguousOffset::Fold { .. } => ClockChange::Repeated,
        };
        let instant = ambiguous.compatible().ok()?;
        Some((Utc(i64::try_from(instant.as_nanosecond()).ok()?), change))
    }

    /// The local time of an instant, rounded down to the minute.
    pub fn to_local(&self, utc: Utc) -> LocalDateTime {
        let local = match Timestamp::from_nanosecond(i128::from(utc.0)) {
            Ok(instant) => self.zone.to_datetime(instant),
            Err(_) => DateTime::MIN,
        };
        let (date, time) = (local.date(), local.time());
        LocalDateTime {
            date: LocalDate { year: date.year(), month: date.month() as u8, day: date.day() as u8 },
            time: LocalTime { hour: time.hour() as u8, minute: time.minute() as u8 },
        }
    }

    /// Difference between local time and UTC at an instant, minutes.
    pub fn offset_minutes(&self, utc: Utc) -> i64 {
        minute_number(self.to_local(utc)) - utc.0.div_euclid(Span::MINUTE.nanos())
    }
}

fn date_time(at: LocalDateTime) -> Option<DateTime> {
    let LocalDateTime { date, time } = at;
    let date =
        civil::Date::new(date.year, i8::try_from(date.month).ok()?, i8::try_from(date.day).ok()?).ok()?;
    let time = civil::Time::new(i8::try_from(time.hour).ok()?, i8::try_from(time.minute).ok()?, 0, 0).ok()?;
    Some(date.to_datetime(time))
}
