//! Slots of schedules over changes of the clocks, and over years of days in many zones.

use super::civil::{MINUTES_A_DAY, date_of, day_number, local_of, minute_number, weekday_of};
use super::*;
use proptest::prelude::*;
use site_model::{LocalDate, LocalDateTime, LocalTime, Recurrence, Utc, Weekday};
use vocab::Span;

const MINUTE: i64 = 60_000_000_000;

fn at(year: i16, month: u8, day: u8, hour: u8, minute: u8) -> LocalDateTime {
    LocalDateTime { date: LocalDate { year, month, day }, time: LocalTime { hour, minute } }
}

fn zone(name: &str) -> SiteZone {
    SiteZone::new(name).expect("a zone")
}

fn utc(at: LocalDateTime) -> Utc {
    SiteZone::utc().to_utc(at).expect("a time").0
}

fn daily(hour: u8, minute: u8) -> Recurrence {
    Recurrence::Weekly {
        days: WEEK.into(),
        times: vec![LocalTime { hour, minute }],
        first_day: LocalDate { year: 2020, month: 1, day: 1 },
        last_day: None,
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

/// Slots of a recurrence that are due after an instant and before another, as local time of the slot and UTC of its due.
fn slots(
    recurrence: &Recurrence,
    name: &str,
    from: LocalDateTime,
    until: LocalDateTime,
) -> Vec<(LocalDateTime, LocalDateTime)> {
    let slots = Slots::new(recurrence, &zone(name)).expect("a rule");
    let until = utc(until);
    let found = slots.after(utc(from)).take_while(|slot| slot.due < until);
    found.map(|slot| (slot.slot, SiteZone::utc().to_local(slot.due))).collect()
}

#[test]
fn a_time_in_the_spring_gap_runs_after_it_and_a_time_that_is_repeated_runs_once() {
    // London: 29 March 2026, 01:00 to 02:00 does not exist. 25 October 2026, 01:00 to 02:00 occurs twice.
    let spring = slots(&daily(1, 30), "Europe/London", at(2026, 3, 28, 12, 0), at(2026, 3, 30, 12, 0));
    assert_eq!(
        spring,
        [
            (at(2026, 3, 29, 1, 30), at(2026, 3, 29, 1, 30)), // 02:30 on the wall
            (at(2026, 3, 30, 1, 30), at(2026, 3, 30, 0, 30)),
        ]
    );
    // As in DOMAIN.md, where the gap is from 02:00: 02:30 runs at 03:30.
    let berlin = slots(&daily(2, 30), "Europe/Berlin", at(2026, 3, 28, 12, 0), at(2026, 3, 29, 12, 0));
    assert_eq!(berlin.len(), 1);
    assert_eq!(zone("Europe/Berlin").to_local(utc(berlin[0].1)), at(2026, 3, 29, 3, 30));
    let autumn = slots(&daily(1, 30), "Europe/London", at(2026, 10, 24, 12, 0), at(2026, 10, 26, 12, 0));
    assert_eq!(
        autumn,
        [
            (at(2026, 10, 25, 1, 30), at(2026, 10, 25, 0, 30)),
            (at(2026, 10, 26, 1, 30), at(2026, 10, 26, 1, 30))
        ]
    );
    let change = |at| zone("Europe/London").to_utc(at).expect("a time").1;
    assert_eq!(change(at(2026, 3, 29, 1, 30)), ClockChange::Skipped);
    assert_eq!(change(at(2026, 10, 25, 1, 30)), ClockChange::Repeated);
    assert_eq!(change(at(2026, 10, 25, 2, 30)), ClockChange::None);
}

#[test]
fn slots_around_the_gap_come_in_the_order_in_which_they_are_due() {
    let rule =
        Recurrence::Rule { first: at(2026, 3, 29, 0, 0), rule: "FREQ=MINUTELY;INTERVAL=30".to_owned() };
    let slots = Slots::new(&rule, &zone("Europe/London")).expect("a rule");
    let found: Vec<_> = slots.after(utc(at(2026, 3, 28, 23, 59))).take(9).collect();
    let due: Vec<_> = found.iter().map(|slot| slot.due).collect();
    assert!(due.is_sorted(), "{found:?}");
    // 01:00 and 01:30 do not exist, and are due with 02:00 and 02:30, which run.
    let same: Vec<_> = found.iter().filter(|slot| slot.is_same_instant).map(|slot| slot.slot).collect();
    assert_eq!(same, [at(2026, 3, 29, 1, 0), at(2026, 3, 29, 1, 30)]);
    // By elapsed time there is nothing to leave out, and in autumn no local time occurs twice.
    for (day, count) in [(at(2026, 3, 29, 0, 0), 46), (at(2026, 10, 25, 0, 0), 48)] {
        let every = Recurrence::Every { first: day, interval: Span::from_millis(30 * 60_000) };
        let slots = Slots::new(&every, &zone("Europe/London")).expect("a rule");
        let found: Vec<_> =
            slots.after(Utc(i64::MIN)).take_while(|slot| slot.slot.date == day.date).collect();
        assert_eq!(found.len(), count, "{day:?}");
        let mut local: Vec<_> = found.iter().map(|slot| slot.slot).collect();
        local.dedup();
        assert_eq!(local.len(), count);
        assert!(found.iter().all(|slot| !slot.is_same_instant));
    }
}

#[test]
fn every_kind_of_recurrence_has_its_slots() {
    let from = at(2026, 11, 23, 0, 0);
    let weekly = Recurrence::Weekly {
        days: [Weekday::Monday, Weekday::Friday].into(),
        times: vec![LocalTime { hour: 15, minute: 0 }, LocalTime { hour: 11, minute: 0 }],
        first_day: LocalDate { year: 2026, month: 11, day: 24 },
        last_day: Some(LocalDate { year: 2026, month: 11, day: 30 }),
    };
    let local = |recurrence: &Recurrence| -> Vec<LocalDateTime> {
        slots(recurrence, "Europe/London", from, at(2027, 1, 1, 0, 0))
            .into_iter()
            .map(|slot| slot.0)
            .collect()
    };
    assert_eq!(
        local(&weekly),
        [at(2026, 11, 27, 11, 0), at(2026, 11, 27, 15, 0), at(2026, 11, 30, 11, 0), at(2026, 11, 30, 15, 0)]
    );
    assert_eq!(local(&Recurrence::Once(at(2026, 12, 24, 18, 0))), [at(2026, 12, 24, 18, 0)]);
    assert_eq!(local(&Recurrence::Once(at(2026, 11, 22, 18, 0))), []);
    let days =
        Recurrence::Every { first: at(2026, 11, 1, 6, 0), interval: Span::from_millis(10 * 86_400_000) };
    assert_eq!(local(&days), [1, 11, 21, 31].map(|day| at(2026, 12, day, 6, 0)));
    let rule = Recurrence::Rule { first: at(2026, 11, 1, 6, 0), rule: "FREQ=MONTHLY;BYDAY=-1FR".to_owned() };
    assert_eq!(local(&rule), [at(2026, 11, 27, 6, 0), at(2026, 12, 25, 6, 0)]);
    let wrong = Recurrence::Rule { first: at(2026, 11, 1, 6, 0), rule: "daily".to_owned() };
    assert!(Slots::new(&wrong, &SiteZone::utc()).is_err());
    assert_eq!(SiteZone::new("Mars/Olympus").map(|_| ()), Err(ZoneError("Mars/Olympus".to_owned())));
}

/// Zones with northern and southern summer, half-hour and half-hour-change offsets, changes at midnight, and none.
const ZONES: [&str; 12] = [
    "Europe/London",
    "Europe/Berlin",
    "America/New_York",
    "America/St_Johns",
    "America/Santiago",
    "Australia/Lord_Howe",
    "Pacific/Apia",
    "Africa/Cairo",
    "Asia/Tehran",
    "America/Havana",
    "Asia/Kolkata",
    "UTC",
];

#[test]
fn over_years_of_days_and_many_zones_each_day_has_its_slot_once_and_in_order() {
    let mut changes = [0; 2];
    for name in ZONES {
        let zone = zone(name);
        for minute in (0..24 * 60).step_by(30) {
            let (hour, minute) = ((minute / 60) as u8, (minute % 60) as u8);
            let slots = Slots::new(&daily(hour, minute), &zone).expect("a rule");
            let first = day_number(LocalDate { year: 2024, month: 1, day: 1 });
            let begin = local_of(first * MINUTES_A_DAY);
            let (begin, _) = zone.to_utc(begin).expect("a time");
            let found: Vec<_> = slots.after(Utc(begin.0 - 1)).take(4 * 366).collect();
            for (index, slot) in found.iter().enumerate() {
                assert_eq!(slot.slot.date, date_of(first + index as i64), "{name}");
                // What stands on the wall when it is due is the slot, unless the slot does not exist: then it is later by the gap.
                let wall = zone.to_local(slot.due);
                let late = minute_number(wall) - minute_number(slot.slot);
                match slot.change {
                    ClockChange::Skipped => {
                        changes[0] += 1;
                        assert!((1..=60).contains(&late), "{name} {slot:?} {late}");
                    }
                    ClockChange::Repeated => {
                        changes[1] += 1;
                        assert_eq!(late, 0);
                        // It is the first of both: half an hour or an hour later the wall shows the same.
                        let again = [30, 60].map(|minutes| zone.to_local(Utc(slot.due.0 + minutes * MINUTE)));
                        assert!(again.contains(&wall), "{name} {slot:?}");
                    }
                    ClockChange::None => assert_eq!(late, 0, "{name} {slot:?}"),
                }
                if let Some(next) = found.get(index + 1) {
                    let hours = (next.due.0 - slot.due.0) / MINUTE / 60;
                    assert!((22..=26).contains(&hours), "{name} {slot:?} {next:?}");
                }
            }
        }
    }
    assert!(changes.iter().all(|count| *count > 40), "{changes:?}");
}

proptest! {
    #[test]
    fn the_slots_after_an_instant_do_not_depend_on_where_one_looks_from(
        zone_index in 0_usize..12,
        interval_minutes in prop_oneof![Just(15_i64), Just(45), Just(60), Just(1440), Just(2880)],
        by_rule in any::<bool>(),
        days in -3_i64..3,
        spring in any::<bool>(),
    ) {
        let name = ZONES[zone_index];
        let zone = zone(name);
        let first = at(2025, 1, 1, 0, 30);
        let recurrence = match by_rule {
            true => Recurrence::Rule { first, rule: format!("FREQ=MINUTELY;INTERVAL={interval_minutes}") },
            false => Recurrence::Every { first, interval: Span::from_millis(interval_minutes * 60_000) },
        };
        let slots = Slots::new(&recurrence, &zone).expect("a rule");
        // Around changes of the clocks in many of the zones.
        let begin = utc(if spring { at(2026, 3, 29, 0, 0) } else { at(2026, 10, 25, 0, 0) }).0 + days * 1440 * MINUTE;
        let all: Vec<_> = slots.after(Utc(begin)).take(40).collect();
        prop_assert!(all.windows(2).all(|pair| pair[0].due <= pair[1].due));
        for (index, slot) in all.iter().enumerate().take(39) {
            let rest: Vec<_> = all[index + 1..].iter().filter(|other| other.due > slot.due).collect();
            let found: Vec<_> = slots.after(slot.due).take(rest.len()).collect();
            prop_assert_eq!(found.iter().collect::<Vec<_>>(), rest);
        }
        // Each local time once.
        let mut local: Vec<_> = all.iter().map(|slot| slot.slot).collect();
        local.sort_unstable();
        let count = local.len();
        local.dedup();
        prop_assert_eq!(local.len(), count);
    }

    #[test]
    fn a_local_time_that_exists_is_an_instant_and_back(zone_index in 0_usize..12, minute in 28_000_000_i64..31_000_000) {
        let zone = zone(ZONES[zone_index]);
        let local = local_of(minute);
        let (instant, change) = zone.to_utc(local).expect("a time");
        let is_same = zone.to_local(instant) == local;
        prop_assert_eq!(is_same, change != ClockChange::Skipped);
        prop_assert_eq!(weekday_of(0), 3, "1970 began on a Thursday");
    }
}
