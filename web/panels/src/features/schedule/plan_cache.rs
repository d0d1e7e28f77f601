//! What the screen shows of the plan, computed once for each change of the site, the week or the minute.

use client_model::{Occurrence, SchedulePlan, conflicts_of, expected_durations, plan_schedules, week_of};
use missions::{SiteZone, date_of, day_number};
use site_model::{LocalDate, LocalDateTime, LocalTime, MissionId, ScheduleId, Site, Utc};
use std::collections::BTreeMap;
use vocab::Span;

/// Nanoseconds of a minute.
pub(super) const MINUTE_NS: i64 = Span::MINUTE.nanos();

/// Parameters of the plan of a schedule.
struct PlanCacheConfig {
    /// Days that are looked ahead. Chosen: a month, which has a run of each schedule that is usual.
    outlook_days: i64,
}

const CONFIG: PlanCacheConfig = PlanCacheConfig { outlook_days: 30 };

/// Time zone of a site that nobody has told one.
pub(super) const UTC: &str = "UTC";

/// What decides on a plan.
#[derive(Clone, Debug, PartialEq, Eq)]
struct PlanKey {
    site_revision: u64,
    week: Option<LocalDate>,
    minute: i64,
    your_zone: String,
}

/// The plan of the week that is shown and of the next 30 days.
#[derive(Debug)]
pub(super) struct CachedPlan {
    key: PlanKey,
    /// Name of the site's time zone.
    pub(super) zone_name: String,
    /// The site's time zone; UTC if there is none of its name.
    pub(super) zone: SiteZone,
    /// Whether there is a zone of that name.
    pub(super) is_zone_known: bool,
    /// The time zone of the operator's machine, if its times differ from those of the site in this week.
    pub(super) your_zone: Option<SiteZone>,
    /// Its name.
    pub(super) your_zone_name: String,
    /// Now.
    pub(super) now: Utc,
    /// Monday of the week that is shown.
    pub(super) week: LocalDate,
    /// Its occurrences, with those of the day before it, which may reach into it.
    pub(super) of_week: SchedulePlan,
    /// Those from now on.
    pub(super) outlook: SchedulePlan,
    /// Pairs of those that overlap.
    pub(super) conflicts: Vec<(usize, usize)>,
    /// How long missions are expected to run.
    pub(super) durations: BTreeMap<MissionId, Span>,
}

impl CachedPlan {
    /// Brings `kept` up to date.
    pub(super) fn update(
        kept: &mut Option<Self>,
        site: &Site,
        site_revision: u64,
        clock: &crate::PageClock,
        week: Option<LocalDate>,
    ) {
        let now = clock.utc;
        let key = PlanKey {
            site_revision,
            week,
            minute: now.0.div_euclid(MINUTE_NS),
            your_zone: clock.zone.clone(),
        };
        if kept.as_ref().is_none_or(|plan| plan.key != key) {
            *kept = Some(Self::new(site, key, now, clock));
        }
    }

    fn new(site: &Site, key: PlanKey, now: Utc, clock: &crate::PageClock) -> Self {
        let zone_name = site.settings().map_or(UTC, |settings| settings.time_zone.as_str()).to_owned();
        let known = SiteZone::new(&zone_name);
        let is_zone_known = known.is_ok();
        let zone = known.unwrap_or_else(|_| SiteZone::utc());
        let week = week_of(key.week.unwrap_or_else(|| zone.to_local(now).date));
        let your_zone = SiteZone::new(&clock.zone).ok().filter(|yours| {
            // Zones that agree now may differ on another day of the week.
            (0..=7).any(|day| {
                let at = midnight(&zone, week, day);
                yours.offset_minutes(at) != zone.offset_minutes(at)
            })
        });
        let of_week = plan_schedules(site, &zone, midnight(&zone, week, -1), midnight(&zone, week, 7));
        let until = Utc(now.0 + CONFIG.outlook_days * 24 * 60 * MINUTE_NS);
        let outlook = plan_schedules(site, &zone, Utc(now.0 + 1), until);
        let durations = expected_durations(site);
        let duration = |mission| durations.get(&mission).copied().unwrap_or(Span::ZERO);
        let conflicts = conflicts_of(&outlook.occurrences, duration);
        Self {
            key,
            zone_name,
            zone,
            is_zone_known,
            your_zone,
            your_zone_name: clock.zone.clone(),
            now,
            week,
            of_week,
            outlook,
            conflicts,
            durations,
        }
    }

    /// A day of the week that is shown, 0 is Monday.
    pub(super) fn day(&self, day: usize) -> LocalDate {
        date_of(day_number(self.week) + day as i64)
    }

    /// How long a mission is expected to run; 0 if nothing is known.
    pub(super) fn duration(&self, mission: MissionId) -> Span {
        self.durations.get(&mission).copied().unwrap_or(Span::ZERO)
    }

    /// When an occurrence is due, as clocks at the site show it.
    pub(super) fn local(&self, occurrence: &Occurrence) -> LocalDateTime {
        self.zone.to_local(occurrence.due)
    }

    /// The first quarter of an hour at which an occurrence is expected to have ended.
    pub(super) fn free_after(&self, occurrence: &Occurrence) -> Option<LocalDateTime> {
        const QUARTER_NS: i64 = 15 * MINUTE_NS;
        let length_ns = self.duration(occurrence.mission).nanos().max(QUARTER_NS);
        let end = occurrence.due.0.checked_add(length_ns)?;
        Some(self.zone.to_local(Utc(end.checked_add(QUARTER_NS - 1)?.div_euclid(QUARTER_NS) * QUARTER_NS)))
    }

    /// Whether an instant has passed.
    pub(super) fn is_past(&self, at: Utc) -> bool {
        at <= self.now
    }

    /// Whether a local time has passed.
    pub(super) fn is_local_past(&self, at: LocalDateTime) -> bool {
        self.zone.to_utc(at).is_some_and(|(at, _)| self.is_past(at))
    }

    /// The next slot of a schedule that runs.
    pub(super) fn next_of(&self, schedule: ScheduleId) -> Option<&Occurrence> {
        self.outlook.occurrences.iter().find(|it| it.schedule == schedule && it.is_planned())
    }
}

/// Midnight, local time, of the day that is the given number of days after `day`.
fn midnight(zone: &SiteZone, day: LocalDate, days: i64) -> Utc {
    let date = date_of(day_number(day) + days);
    let at = LocalDateTime { date, time: LocalTime { hour: 0, minute: 0 } };
    zone.to_utc(at).map_or(Utc(0), |(utc, _)| utc)
}
