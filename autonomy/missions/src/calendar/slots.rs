//! The slots of a schedule: when it is due.

use super::civil::{MINUTES_A_DAY, date_of, day_number, local_of, minute_number, weekday_of};
use super::recurrence_rule::{RecurrenceRule, RuleError};
use super::site_zone::{ClockChange, SiteZone};
use site_model::{LocalDateTime, LocalTime, Recurrence, Utc, Weekday};
use std::collections::VecDeque;
use vocab::Span;

/// A local time that is skipped counts later than those after it. So slots are looked for from this long before an instant: a day, as on Samoa in 2011, and an hour.
const MAX_SHIFT_MINUTES: i64 = 25 * 60;

/// A slot of a schedule. The local time is its identity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slot {
    /// Local time in the site's zone.
    pub slot: LocalDateTime,
    /// The instant at which it is due.
    pub due: Utc,
    /// How it meets a change of the clocks.
    pub change: ClockChange,
    /// Another slot of the schedule is due at the same instant, and runs.
    pub is_same_instant: bool,
}

/// The slots of a recurrence in a zone.
#[derive(Clone, Debug)]
pub struct Slots {
    zone: SiteZone,
    kind: Kind,
}

#[derive(Clone, Debug)]
enum Kind {
    Once(LocalDateTime),
    Weekly {
        days: [bool; 7],
        times: Vec<LocalTime>,
        first_day: i64,
        last_day: i64,
    },
    /// At times of day in local time, a fixed number of days apart.
    EveryDays {
        first: i64,
        minutes: i64,
    },
    /// By elapsed time.
    EveryMinutes {
        first: LocalDateTime,
        minutes: i64,
    },
    Rule(RecurrenceRule),
}

impl Slots {
    /// The slots of a recurrence.
    ///
    /// # Errors
    /// What is wrong with its rule.
    pub fn new(recurrence: &Recurrence, zone: &SiteZone) -> Result<Self, RuleError> {
        let kind = match recurrence {
            Recurrence::Once(at) => Kind::Once(*at),
            Recurrence::Weekly { days, times, first_day, last_day } => {
                let mut times = times.clone();
                times.sort_unstable();
                times.dedup();
                Kind::Weekly {
                    days: WEEK.map(|day| days.contains(&day)),
                    times,
                    first_day: day_number(*first_day),
                    last_day: last_day.map_or(i64::MAX, day_number),
                }
            }
            Recurrence::Every { first, interval } => {
                let minutes = (interval.nanos() / Span::MINUTE.nanos()).max(1);
                match minutes % MINUTES_A_DAY {
                    0 => Kind::EveryDays { first: minute_number(*first), minutes },
                    _ => Kind::EveryMinutes { first: *first, minutes },
                }
            }
            Recurrence::Rule { first, rule } => Kind::Rule(RecurrenceRule::parse(*first, rule)?),
        };
        Ok(Self { zone: zone.clone(), kind })
    }

    /// The slots that are due after an instant, in the order in which they are due.
    pub fn after(&self, after: Utc) -> impl Iterator<Item = Slot> + '_ {
        let local = self.local_after(after);
        let slots = InOrder { zone: &self.zone, local, next: None, ready: VecDeque::new() };
        slots.filter(move |slot| slot.due > after)
    }

    /// Local times from somewhat before an instant on, in their order.
    fn local_after(&self, after: Utc) -> Box<dyn Iterator<Item = LocalDateTime> + '_> {
        let from = minute_number(self.zone.to_local(after)) - MAX_SHIFT_MINUTES;
        match &self.kind {
            Kind::Once(at) => Box::new(std::iter::once(*at)),
            Kind::Weekly { days, times, first_day, last_day } => {
                if times.is_empty() || !days.contains(&true) {
                    return Box::new(std::iter::empty());
                }
                let begin = from.div_euclid(MINUTES_A_DAY).max(*first_day);
                let days = (begin..).take_while(move |day| day <= last_day);
                let days = days.filter(move |&day| days_contain(&self.kind, day));
                Box::new(days.flat_map(move |day| {
                    times.iter().map(move |&time| LocalDateTime { date: date_of(day), time })
                }))
            }
            Kind::EveryDays { first, minutes } => {
                let begin = ((from - first).div_euclid(*minutes)).max(0);
                Box::new((begin..).map(move |step| local_of(first + step * minutes)))
            }
            Kind::EveryMinutes { first, minutes } => Box::new(self.every(*first, *minutes, after)),
            Kind::Rule(rule) => Box::new(rule.slots_after(from)),
        }
    }

    /// Local times in equal intervals of elapsed time. A local time that is repeated occurs once.
    fn every(
        &self,
        first: LocalDateTime,
        minutes: i64,
        after: Utc,
    ) -> impl Iterator<Item = LocalDateTime> + '_ {
        let begin = self.zone.to_utc(first).map(|(begin, _)| begin.0);
        let interval = minutes.saturating_mul(Span::MINUTE.nanos());
        begin.into_iter().flat_map(move |begin| {
            let step = (after.0.saturating_sub(begin)).div_euclid(interval).max(0);
            let instants = (step..).map_while(move |step| begin.checked_add(step.checked_mul(interval)?));
            instants.filter_map(move |instant| {
                let local = self.zone.to_local(Utc(instant));
                // The second of two equal local times is due at another instant than the first.
                let (due, _) = self.zone.to_utc(local)?;
                (instant - due.0 < Span::MINUTE.nanos()).then_some(local)
            })
        })
    }
}

const WEEK: [Weekday; 7] = [
    Weekday::Monday,
    Weekday::Tuesday,
    Weekday::Wednesday,
    Weekday::Thursday,
    Weekday::Friday,
    Weekday::Saturday,
    Weekday::Sunday,
];

fn days_contain(kind: &Kind, day: i64) -> bool {
    matches!(kind, Kind::Weekly { days, .. } if days[usize::from(weekday_of(day))])
}

/// Puts slots whose local time is skipped where they are due.
struct InOrder<'a> {
    zone: &'a SiteZone,
    /// In the order of local times.
    local: Box<dyn Iterator<Item = LocalDateTime> + 'a>,
    /// Taken from `local`, but due after all that are ready.
    next: Option<Slot>,
    ready: VecDeque<Slot>,
}

impl InOrder<'_> {
    fn take_local(&mut self) -> Option<Slot> {
        self.next.take().or_else(|| {
            let slot = self.local.next()?;
            // The calendar of the library ends with the year 9999.
            let (due, change) = self.zone.to_utc(slot)?;
            Some(Slot { slot, due, change, is_same_instant: false })
        })
    }
}

impl Iterator for InOrder<'_> {
    type Item = Slot;

    fn next(&mut self) -> Option<Slot> {
        if let Some(slot) = self.ready.pop_front() {
            return Some(slot);
        }
        let slot = self.take_local()?;
        if slot.change != ClockChange::Skipped {
            return Some(slot);
        }
        // Everything that is due until this slot, in order. Of several at one instant, the one whose local time exists runs.
        let mut group = vec![slot];
        let mut latest = slot.due;
        while let Some(other) = self.take_local() {
            if other.change != ClockChange::Skipped && other.due > latest {
                self.next = Some(other);
                break;
            }
            latest = latest.max(other.due);
            group.push(other);
        }
        group.sort_by_key(|slot| (slot.due, slot.change == ClockChange::Skipped));
        for index in 1..group.len() {
            group[index].is_same_instant = group[index].due == group[index - 1].due;
        }
        self.ready = group.into();
        self.ready.pop_front()
    }
}
