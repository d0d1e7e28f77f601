//! Recurrence rules of RFC 5545 (section 3.3.10): parsed from their text. Slots have whole minutes, so rules by the second are refused.

use super::civil::{day_number, minute_number, weekday_of};
use site_model::{LocalDate, LocalDateTime, LocalTime};

/// How often a rule begins anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Frequency {
    Minutely,
    Hourly,
    Daily,
    Weekly,
    Monthly,
    Yearly,
}

/// A rule, with what the first slot says where the rule itself says nothing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecurrenceRule {
    pub(super) first: LocalDateTime,
    pub(super) frequency: Frequency,
    pub(super) interval: i64,
    pub(super) count: Option<u64>,
    /// Minute of the last possible slot.
    pub(super) until: Option<i64>,
    pub(super) months: Vec<i64>,
    pub(super) week_numbers: Vec<i64>,
    pub(super) year_days: Vec<i64>,
    pub(super) month_days: Vec<i64>,
    /// Days of the week, 0 is Monday, each with its number within the month or year if it has one.
    pub(super) week_days: Vec<(u8, Option<i64>)>,
    /// Empty: any hour.
    pub(super) hours: Vec<i64>,
    /// Empty: any minute.
    pub(super) minutes: Vec<i64>,
    pub(super) positions: Vec<i64>,
    /// Day of the week on which weeks begin, 0 is Monday.
    pub(super) week_start: u8,
}

/// Why a rule cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RuleError {
    /// A part is not `NAME=VALUE`.
    #[error("\"{0}\" is not a part of a recurrence rule; a rule is such as FREQ=WEEKLY;BYDAY=MO,FR")]
    NotAPart(String),
    /// A part is not known.
    #[error("recurrence rules have no part {0}")]
    UnknownPart(String),
    /// A part occurs twice.
    #[error("the part {0} occurs twice")]
    Repeated(String),
    /// A value is wrong.
    #[error("{part} cannot be \"{value}\"")]
    BadValue {
        /// Name of the part.
        part: &'static str,
        /// Its value.
        value: String,
    },
    /// Something is missing.
    #[error("the rule has no FREQ")]
    NoFrequency,
    /// Parts that exclude each other.
    #[error("{0} and {1} exclude each other")]
    Excluded(&'static str, &'static str),
    /// Rules by the second.
    #[error("slots have whole minutes; {0} cannot be used")]
    Seconds(&'static str),
}

const WEEK_DAYS: [&str; 7] = ["MO", "TU", "WE", "TH", "FR", "SA", "SU"];

impl RecurrenceRule {
    /// Parses a rule, with or without `RRULE:` before it. `first` is the first slot (DTSTART).
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn parse(first: LocalDateTime, text: &str) -> Result<Self, RuleError> {
        let text = text.trim().to_ascii_uppercase();
        let mut parts = Parts::new(text.strip_prefix("RRULE:").unwrap_or(&text))?;
        let frequency = parts.frequency()?;
        let mut rule = Self {
            first,
            frequency,
            interval: parts.number("INTERVAL", 1..=10_000)?.unwrap_or(1),
            count: parts.number("COUNT", 1..=1_000_000)?.map(i64::unsigned_abs),
            until: parts.until()?,
            months: parts.list("BYMONTH", 1, 12, false)?,
            week_numbers: parts.list("BYWEEKNO", 1, 53, true)?,
            year_days: parts.list("BYYEARDAY", 1, 366, true)?,
            month_days: parts.list("BYMONTHDAY", 1, 31, true)?,
            week_days: parts.week_days()?,
            hours: parts.list("BYHOUR", 0, 23, false)?,
            minutes: parts.list("BYMINUTE", 0, 59, false)?,
            positions: parts.list("BYSETPOS", 1, 366, true)?,
            week_start: parts.week_start()?,
        };
        if parts.list("BYSECOND", 0, 59, false)?.iter().any(|second| *second != 0) {
            return Err(RuleError::Seconds("BYSECOND"));
        }
        parts.check_all_used()?;
        rule.check()?;
        rule.fill_in();
        Ok(rule)
    }

    fn check(&self) -> Result<(), RuleError> {
        if self.count.is_some() && self.until.is_some() {
            return Err(RuleError::Excluded("COUNT", "UNTIL"));
        }
        let has_numbers = self.week_days.iter().any(|(_, number)| number.is_some());
        if has_numbers && !matches!(self.frequency, Frequency::Monthly | Frequency::Yearly) {
            return Err(RuleError::Excluded("FREQ", "numbers in BYDAY"));
        }
        if has_numbers && !self.week_numbers.is_empty() {
            return Err(RuleError::Excluded("BYWEEKNO", "numbers in BYDAY"));
        }
        if !self.week_numbers.is_empty() && self.frequency != Frequency::Yearly {
            return Err(RuleError::Excluded("FREQ", "BYWEEKNO"));
        }
        if !self.year_days.is_empty()
            && matches!(self.frequency, Frequency::Daily | Frequency::Weekly | Frequency::Monthly)
        {
            return Err(RuleError::Excluded("FREQ", "BYYEARDAY"));
        }
        if !self.month_days.is_empty() && self.frequency == Frequency::Weekly {
            return Err(RuleError::Excluded("FREQ", "BYMONTHDAY"));
        }
        let has_others =
            [&self.months, &self.week_numbers, &self.year_days, &self.month_days, &self.hours, &self.minutes]
                .iter()
                .any(|list| !list.is_empty())
                || !self.week_days.is_empty();
        if !self.positions.is_empty() && !has_others {
            return Err(RuleError::Excluded("BYSETPOS", "a rule without other BY parts"));
        }
        Ok(())
    }

    /// What the rule leaves open is as in the first slot.
    fn fill_in(&mut self) {
        let LocalDateTime { date, time } = self.first;
        let chooses_days = !self.week_numbers.is_empty()
            || !self.year_days.is_empty()
            || !self.month_days.is_empty()
            || !self.week_days.is_empty();
        if !chooses_days {
            match self.frequency {
                Frequency::Yearly => {
                    if self.months.is_empty() {
                        self.months.push(i64::from(date.month));
                    }
                    self.month_days.push(i64::from(date.day));
                }
                Frequency::Monthly => self.month_days.push(i64::from(date.day)),
                Frequency::Weekly => self.week_days.push((weekday_of(day_number(date)), None)),
                Frequency::Daily | Frequency::Hourly | Frequency::Minutely => {}
            }
        }
        if self.hours.is_empty() && self.frequency > Frequency::Hourly {
            self.hours.push(i64::from(time.hour));
        }
        if self.minutes.is_empty() && self.frequency > Frequency::Minutely {
            self.minutes.push(i64::from(time.minute));
        }
    }
}

/// The parts of a rule that were not read yet.
struct Parts<'a>(Vec<(&'a str, &'a str)>);

impl<'a> Parts<'a> {
    fn new(text: &'a str) -> Result<Self, RuleError> {
        let mut parts: Vec<(&str, &str)> = Vec::new();
        for part in text.split(';').filter(|part| !part.is_empty()) {
            let (name, value) = part.split_once('=').ok_or_else(|| RuleError::NotAPart(part.to_owned()))?;
            if parts.iter().any(|(other, _)| *other == name) {
                return Err(RuleError::Repeated(name.to_owned()));
            }
            parts.push((name, value));
        }
        Ok(Self(parts))
    }

    fn take(&mut self, name: &str) -> Option<&'a str> {
        let index = self.0.iter().position(|(other, _)| *other == name)?;
        Some(self.0.remove(index).1)
    }

    fn check_all_used(&self) -> Result<(), RuleError> {
        self.0.first().map_or(Ok(()), |(name, _)| Err(RuleError::UnknownPart((*name).to_owned())))
    }

    fn frequency(&mut self) -> Result<Frequency, RuleError> {
        let value = self.take("FREQ").ok_or(RuleError::NoFrequency)?;
        match value {
            "MINUTELY" => Ok(Frequency::Minutely),
            "HOURLY" => Ok(Frequency::Hourly),
            "DAILY" => Ok(Frequency::Daily),
            "WEEKLY" => Ok(Frequency::Weekly),
            "MONTHLY" => Ok(Frequency::Monthly),
            "YEARLY" => Ok(Frequency::Yearly),
            "SECONDLY" => Err(RuleError::Seconds("FREQ=SECONDLY")),
            _ => Err(bad("FREQ", value)),
        }
    }

    fn number(
        &mut self,
        name: &'static str,
        range: std::ops::RangeInclusive<i64>,
    ) -> Result<Option<i64>, RuleError> {
        let Some(value) = self.take(name) else { return Ok(None) };
        let number = value.parse().ok().filter(|number| range.contains(number));
        number.map(Some).ok_or_else(|| bad(name, value))
    }

    /// A list of numbers from `min` to `max`, or with `or_negative` from `-max` to `-min`. Sorted, each once.
    fn list(
        &mut self,
        name: &'static str,
        min: i64,
        max: i64,
        or_negative: bool,
    ) -> Result<Vec<i64>, RuleError> {
        let Some(value) = self.take(name) else { return Ok(Vec::new()) };
        let number = |text: &str| {
            let number: i64 = text.parse().ok()?;
            let is_valid = (min..=max).contains(&number) || (or_negative && (-max..=-min).contains(&number));
            is_valid.then_some(number)
        };
        let mut list = Vec::new();
        for text in value.split(',') {
            list.push(number(text).ok_or_else(|| bad(name, value))?);
        }
        list.sort_unstable();
        list.dedup();
        Ok(list)
    }

    fn week_days(&mut self) -> Result<Vec<(u8, Option<i64>)>, RuleError> {
        let Some(value) = self.take("BYDAY") else { return Ok(Vec::new()) };
        let day = |text: &str| {
            let split = text.len().checked_sub(2)?;
            let (number, name) = (text.get(..split)?, text.get(split..)?);
            let day = WEEK_DAYS.iter().position(|day| *day == name)? as u8;
            if number.is_empty() {
                return Some((day, None));
            }
            let number: i64 = number.parse().ok()?;
            (number != 0 && number.abs() <= 53).then_some((day, Some(number)))
        };
        value.split(',').map(|text| day(text).ok_or_else(|| bad("BYDAY", value))).collect()
    }

    fn week_start(&mut self) -> Result<u8, RuleError> {
        let Some(value) = self.take("WKST") else { return Ok(0) };
        let day = WEEK_DAYS.iter().position(|day| *day == value);
        day.map(|day| day as u8).ok_or_else(|| bad("WKST", value))
    }

    /// `20261231`, `20261231T110000`, or the same with a `Z`, which is ignored: slots are local times.
    fn until(&mut self) -> Result<Option<i64>, RuleError> {
        let Some(value) = self.take("UNTIL") else { return Ok(None) };
        parse_until(value).map(Some).ok_or_else(|| bad("UNTIL", value))
    }
}

fn parse_until(value: &str) -> Option<i64> {
    let (date, time) = value.trim_end_matches('Z').split_once('T').unwrap_or((value, "235900"));
    let digits = |text: &str, range: std::ops::Range<usize>| {
        let digits = text.get(range)?;
        digits.bytes().all(|byte| byte.is_ascii_digit()).then(|| digits.parse::<i16>().ok())?
    };
    let part = |text: &str, range| digits(text, range).and_then(|number| u8::try_from(number).ok());
    if date.len() != 8 || time.len() != 6 {
        return None;
    }
    let date = LocalDate { year: digits(date, 0..4)?, month: part(date, 4..6)?, day: part(date, 6..8)? };
    let time = LocalTime { hour: part(time, 0..2)?, minute: part(time, 2..4)? };
    let at = LocalDateTime { date, time };
    at.is_valid().then(|| minute_number(at))
}

fn bad(part: &'static str, value: &str) -> RuleError {
    RuleError::BadValue { part, value: value.to_owned() }
}
