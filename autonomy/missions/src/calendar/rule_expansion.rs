//! Expands recurrence rules to local times (RFC 5545, section 3.3.10). A period is a year, month, week, day, hour or minute. Its days are those that meet all parts
//! of the rule, and each has the rule's times of the day.

use super::civil::{MINUTES_A_DAY, date_of, day_number, first_of_month, local_of, minute_number, weekday_of};
use super::recurrence_rule::{Frequency, RecurrenceRule};
use site_model::LocalDateTime;
use std::collections::VecDeque;

/// Periods without a slot after which a rule counts as never due: rules such as 30 February would be searched for ever. RFC 5545 repeats itself after 400 years
/// at most, and rules of inspections far sooner.
const MAX_EMPTY_YEARS: i64 = 30;

/// Periods that are searched for one slot at most, so that a rule by the minute that never fits ends within milliseconds.
const MAX_EMPTY_PERIODS: u32 = 100_000;

/// The slots of a rule in order of local time, each once.
#[derive(Clone, Debug)]
pub(super) struct RuleSlots<'a> {
    rule: &'a RecurrenceRule,
    /// Number of the next period.
    period: i64,
    /// Minute numbers of the present period that were not returned yet.
    found: VecDeque<i64>,
    returned: u64,
    last: i64,
    /// Day at which the search ends if nothing is found before.
    gives_up_on: i64,
}

impl RecurrenceRule {
    /// The slots after a minute number. Periods before it are skipped, unless the rule counts its slots.
    pub(super) fn slots_after(&self, after: i64) -> RuleSlots<'_> {
        let first = minute_number(self.first);
        let period = if self.count.is_some() { 0 } else { self.period_before(after) };
        let begin_day = if self.count.is_some() { first } else { after.max(first) }.div_euclid(MINUTES_A_DAY);
        let slots = RuleSlots {
            rule: self,
            period,
            found: VecDeque::new(),
            returned: 0,
            last: i64::MIN,
            gives_up_on: begin_day + MAX_EMPTY_YEARS * 366,
        };
        slots.skip_until(after)
    }

    /// A period that ends before a minute.
    fn period_before(&self, minute: i64) -> i64 {
        let first = minute_number(self.first);
        if minute <= first {
            return 0;
        }
        let length = match self.frequency {
            Frequency::Minutely => 1,
            Frequency::Hourly => 60,
            Frequency::Daily => MINUTES_A_DAY,
            Frequency::Weekly => 7 * MINUTES_A_DAY,
            Frequency::Monthly => 31 * MINUTES_A_DAY,
            Frequency::Yearly => 366 * MINUTES_A_DAY,
        };
        ((minute - first) / (length * self.interval) - 2).max(0)
    }

    /// First day and day after the last of a period of days.
    fn days_of_period(&self, period: i64) -> (i64, i64) {
        let date = self.first.date;
        let step = period * self.interval;
        match self.frequency {
            Frequency::Yearly => {
                let year = i64::from(date.year) + step;
                (first_of_month(year, 1), first_of_month(year + 1, 1))
            }
            Frequency::Monthly => {
                let (year, month) = (i64::from(date.year), i64::from(date.month) + step);
                (first_of_month(year, month), first_of_month(year, month + 1))
            }
            Frequency::Weekly => {
                let day = day_number(date);
                let into_week = (i64::from(weekday_of(day)) - i64::from(self.week_start)).rem_euclid(7);
                let begin = day - into_week + 7 * step;
                (begin, begin + 7)
            }
            Frequency::Daily => {
                let day = day_number(date) + step;
                (day, day + 1)
            }
            Frequency::Hourly | Frequency::Minutely => {
                let day = self.minute_of_period(period).div_euclid(MINUTES_A_DAY);
                (day, day + 1)
            }
        }
    }

    /// The minute at which a period of hours or minutes begins.
    fn minute_of_period(&self, period: i64) -> i64 {
        let first = minute_number(self.first);
        match self.frequency {
            Frequency::Hourly => first.div_euclid(60) * 60 + period * self.interval * 60,
            _ => first + period * self.interval,
        }
    }

    /// Slots of a period, in order.
    fn slots_of_period(&self, period: i64) -> Vec<i64> {
        let (begin, end) = self.days_of_period(period);
        let days = (begin..end).filter(|&day| self.has_day(day));
        let mut slots: Vec<i64> = match self.frequency {
            Frequency::Hourly | Frequency::Minutely => {
                let minute = self.minute_of_period(period);
                let hour_is_right = |minute: &i64| {
                    self.hours.is_empty() || self.hours.contains(&(minute.rem_euclid(MINUTES_A_DAY) / 60))
                };
                let minutes: Vec<i64> = match self.frequency {
                    Frequency::Hourly => self.minutes.iter().map(|of_hour| minute + of_hour).collect(),
                    _ if self.minutes.is_empty() || self.minutes.contains(&minute.rem_euclid(60)) => {
                        vec![minute]
                    }
                    _ => Vec::new(),
                };
                days.flat_map(|_| minutes.iter().copied().filter(hour_is_right)).collect()
            }
            _ => {
                let times = || {
                    self.hours
                        .iter()
                        .flat_map(|hour| self.minutes.iter().map(move |minute| hour * 60 + minute))
                };
                days.flat_map(|day| times().map(move |time| day * MINUTES_A_DAY + time)).collect()
            }
        };
        if !self.positions.is_empty() {
            let count = slots.len() as i64;
            let index = |position: &i64| if *position > 0 { position - 1 } else { count + position };
            let mut chosen: Vec<i64> = self
                .positions
                .iter()
                .filter_map(|position| slots.get(usize::try_from(index(position)).ok()?).copied())
                .collect();
            chosen.sort_unstable();
            chosen.dedup();
            slots = chosen;
        }
        slots
    }

    /// Whether a day meets all parts of the rule.
    fn has_day(&self, day: i64) -> bool {
        let date = date_of(day);
        let (year, month) = (i64::from(date.year), i64::from(date.month));
        let (month_begin, month_end) = (first_of_month(year, month), first_of_month(year, month + 1));
        let (year_begin, year_end) = (first_of_month(year, 1), first_of_month(year + 1, 1));
        // Numbers from the beginning and from the end, as in the rule.
        let is_in = |list: &[i64], begin: i64, end: i64| {
            list.is_empty() || list.contains(&(day - begin + 1)) || list.contains(&(day - end))
        };
        (self.months.is_empty() || self.months.contains(&month))
            && is_in(&self.month_days, month_begin, month_end)
            && is_in(&self.year_days, year_begin, year_end)
            && (self.week_numbers.is_empty() || self.has_week(day, year))
            && self.has_week_day(day, (month_begin, month_end), (year_begin, year_end))
    }

    fn has_week_day(&self, day: i64, month: (i64, i64), year: (i64, i64)) -> bool {
        // Numbers count within the year, unless the rule is monthly or names months.
        let is_by_year = self.frequency == Frequency::Yearly && self.months.is_empty();
        let (begin, end) = if is_by_year { year } else { month };
        self.week_days.is_empty()
            || self.week_days.iter().any(|&(weekday, number)| {
                let is_number = |number: i64| match number {
                    1.. => (day - begin) / 7 + 1 == number,
                    _ => (end - 1 - day) / 7 + 1 == -number,
                };
                weekday_of(day) == weekday && number.is_none_or(is_number)
            })
    }

    /// Whether the week of a day has one of the rule's numbers, within the period of `year`. Week 1 is the first with four days in the year.
    fn has_week(&self, day: i64, year: i64) -> bool {
        let week_begin = |year: i64| {
            let fourth = first_of_month(year, 1) + 3;
            fourth - (i64::from(weekday_of(fourth)) - i64::from(self.week_start)).rem_euclid(7)
        };
        let [begin, next] = [year, year + 1].map(week_begin);
        let (begin, next) = match day {
            _ if day < begin => (week_begin(year - 1), begin),
            _ if day >= next => (next, week_begin(year + 2)),
            _ => (begin, next),
        };
        let (number, count) = ((day - begin) / 7 + 1, (next - begin) / 7);
        self.week_numbers
            .iter()
            .any(|&wanted| if wanted > 0 { wanted == number } else { count + 1 + wanted == number })
    }

    /// For rules of hours and minutes: the first period on the next day that can have slots, so that days without any are not searched minute by minute.
    fn period_after_empty_day(&self, period: i64) -> i64 {
        let length = if self.frequency == Frequency::Hourly { 60 } else { 1 } * self.interval;
        let begin = self.minute_of_period(period);
        let midnight = (begin.div_euclid(MINUTES_A_DAY) + 1) * MINUTES_A_DAY;
        period + ((midnight - begin + length - 1) / length).max(1)
    }
}

impl RuleSlots<'_> {
    /// Leaves out the slots up to a minute.
    fn skip_until(mut self, after: i64) -> Self {
        while let Some(minute) = self.peek() {
            if minute > after {
                break;
            }
            self.found.pop_front();
            self.returned += 1;
            self.last = minute;
        }
        self
    }

    /// Minute number of the next slot.
    fn peek(&mut self) -> Option<i64> {
        if self.rule.count.is_some_and(|count| self.returned >= count) {
            return None;
        }
        let first = minute_number(self.rule.first);
        for _ in 0..MAX_EMPTY_PERIODS {
            while let Some(&minute) = self.found.front() {
                if self.rule.until.is_some_and(|until| minute > until) {
                    return None;
                }
                if minute >= first && minute > self.last {
                    return Some(minute);
                }
                self.found.pop_front();
            }
            let (day, _) = self.rule.days_of_period(self.period);
            let is_over = self.rule.until.is_some_and(|until| day * MINUTES_A_DAY > until);
            if is_over || day > self.gives_up_on {
                return None;
            }
            let is_short = self.rule.frequency <= Frequency::Hourly;
            if is_short && !self.rule.has_day(day) {
                self.period = self.rule.period_after_empty_day(self.period);
                continue;
            }
            self.found.extend(self.rule.slots_of_period(self.period));
            self.period += 1;
        }
        None
    }
}

impl Iterator for RuleSlots<'_> {
    type Item = LocalDateTime;

    fn next(&mut self) -> Option<LocalDateTime> {
        let minute = self.peek()?;
        self.found.pop_front();
        self.returned += 1;
        self.last = minute;
        self.gives_up_on = minute.div_euclid(MINUTES_A_DAY) + MAX_EMPTY_YEARS * 366;
        Some(local_of(minute))
    }
}
