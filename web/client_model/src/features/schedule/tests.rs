//! Occurrences, their layout in a week, and edits of schedules.

use super::*;
use crate::testing::TestClient;
use crate::*;
use api::{Event, SiteParts, SiteState};
use missions::{ClockChange, SiteZone, day_number, local_of, minute_number};
use site_model::{
    EditId, LocalDateTime, LocalTime, Mission, MissionId, Object, PlanFile, Recurrence, Schedule, ScheduleId,
    Site, Utc, Weekday,
};
use std::sync::Arc;
use uuid::Uuid;
use vocab::Span;

const MISSION: MissionId = MissionId(Uuid::from_u128(1));
const SCHEDULE: ScheduleId = ScheduleId(Uuid::from_u128(2));

fn date(year: i16, month: u8, day: u8) -> LocalDate {
    LocalDate { year, month, day }
}

fn at(day: u8, hour: u8, minute: u8) -> LocalDateTime {
    LocalDateTime { date: date(2026, 11, day), time: LocalTime { hour, minute } }
}

/// Weekdays at 11:00 and 15:00, from Monday 2026-11-23 on.
fn weekdays() -> Recurrence {
    Recurrence::Weekly {
        days: [Weekday::Monday, Weekday::Tuesday, Weekday::Wednesday, Weekday::Thursday, Weekday::Friday]
            .into(),
        times: vec![LocalTime { hour: 11, minute: 0 }, LocalTime { hour: 15, minute: 0 }],
        first_day: date(2026, 11, 23),
        last_day: None,
    }
}

fn mission() -> Mission {
    Mission {
        id: MISSION,
        name: "Round A".into(),
        tasks: Vec::new(),
        order: Default::default(),
        order_constraints: Vec::new(),
        end: Default::default(),
    }
}

fn client(recurrence: Recurrence) -> TestClient {
    let mut site = Site::default();
    let schedule = Schedule::new(SCHEDULE, "Round A".into(), MISSION, recurrence);
    for (number, object) in [Object::Mission(mission()), Object::Schedule(schedule)].into_iter().enumerate() {
        let id = EditId(Uuid::from_u128(number as u128));
        let edit = site.put(id, object);
        site.apply(&edit, id).unwrap();
    }
    let mut client = TestClient::connected();
    let state = SiteState { site, ..SiteState::default() };
    client.event(Event::SitePart(SiteParts::new(Arc::new(state)).next_part()));
    client
}

/// Local times of all slots in UTC that are planned in the given number of days from Monday 2026-11-23 on.
fn planned(client: &TestClient, days: i64) -> Vec<LocalDateTime> {
    let site = client.model.site.site().unwrap();
    let begin = Utc(day_number(date(2026, 11, 23)) * 86_400_000_000_000);
    let plan = plan_schedules(site, &SiteZone::utc(), begin, Utc(begin.0 + days * 86_400_000_000_000));
    let mut slots: Vec<_> = plan.occurrences.iter().filter(|it| it.is_planned()).map(|it| it.slot).collect();
    slots.sort_unstable();
    slots
}

fn edit(client: &mut TestClient, edit: SiteEdit) {
    client.command(ClientCommand::EditSite(edit));
}

#[test]
fn one_slot_moves_alone_and_the_others_stay_and_one_undo_takes_it_back() {
    let mut client = client(weekdays());
    let before = planned(&client, 14);
    let moved = client.model.site.moving_slot(SCHEDULE, at(25, 15, 0), at(26, 9, 15), ChangeScope::This);
    let (id, wanted) = moved.unwrap();
    edit(&mut client, wanted);
    let mut expected = before.clone();
    expected.retain(|slot| *slot != at(25, 15, 0));
    expected.push(at(26, 9, 15));
    expected.sort_unstable();
    assert_eq!(planned(&client, 14), expected);
    let site = client.model.site.site().unwrap();
    assert_eq!(site.schedule(id).unwrap().name, "Round A, instead of 25 Nov");
    client.command(ClientCommand::Undo);
    assert_eq!(planned(&client, 14), before);
    assert_eq!(client.model.site.site().unwrap().schedules().count(), 1);
}

#[test]
fn following_slots_move_and_earlier_ones_stay() {
    let mut client = client(weekdays());
    let moved =
        client.model.site.moving_slot(SCHEDULE, at(25, 15, 0), at(25, 15, 30), ChangeScope::Following);
    edit(&mut client, moved.unwrap().1);
    let slots = planned(&client, 5);
    let expected = [
        at(23, 11, 0),
        at(23, 15, 0),
        at(24, 11, 0),
        at(24, 15, 0),
        at(25, 11, 0),
        at(25, 15, 30),
        at(26, 11, 0),
        at(26, 15, 30),
        at(27, 11, 0),
        at(27, 15, 30),
    ];
    assert_eq!(slots, expected);
}

#[test]
fn following_slots_that_move_to_an_earlier_day_double_none() {
    let mut client = client(weekdays());
    let moved = client.model.site.moving_slot(SCHEDULE, at(26, 11, 0), at(24, 12, 0), ChangeScope::Following);
    edit(&mut client, moved.unwrap().1);
    let slots = planned(&client, 12);
    let of_week = |slots: &[LocalDateTime], from: u8, to: u8| {
        slots.iter().filter(|slot| (from..=to).contains(&slot.date.day)).copied().collect::<Vec<_>>()
    };
    let first = [
        at(23, 11, 0),
        at(23, 15, 0),
        at(24, 11, 0),
        at(24, 12, 0),
        at(24, 15, 0),
        at(25, 11, 0),
        at(25, 15, 0),
    ];
    assert_eq!(of_week(&slots, 23, 26), first, "Thursday is taken from the days");
    assert_eq!(of_week(&slots, 27, 27), [at(27, 12, 0), at(27, 15, 0)]);
}

#[test]
fn all_slots_of_that_time_move_with_what_is_skipped_of_them() {
    let mut client = client(weekdays());
    let skip = client.model.site.skipping_slot(SCHEDULE, at(27, 15, 0), true);
    edit(&mut client, skip);
    let moved = client.model.site.moving_slot(SCHEDULE, at(25, 15, 0), at(25, 16, 0), ChangeScope::All);
    edit(&mut client, moved.unwrap().1);
    let slots = planned(&client, 5);
    assert_eq!(slots.len(), 9, "the skipped one stays skipped");
    assert!(slots.contains(&at(23, 16, 0)) && !slots.contains(&at(27, 16, 0)));
    let unskip = client.model.site.skipping_slot(SCHEDULE, at(27, 16, 0), false);
    edit(&mut client, unskip);
    assert_eq!(planned(&client, 5).len(), 10);
}

#[test]
fn a_schedule_ends_before_a_slot_or_goes_as_a_whole() {
    let mut client = client(weekdays());
    let ended = client.model.site.removing_slots(SCHEDULE, at(25, 15, 0), ChangeScope::Following);
    edit(&mut client, ended.unwrap());
    assert_eq!(planned(&client, 14).last(), Some(&at(25, 11, 0)));
    client.command(ClientCommand::Undo);
    assert!(
        client.model.site.removing_slots(SCHEDULE, at(23, 11, 0), ChangeScope::Following).is_none(),
        "nothing is before the first slot"
    );
    let all = client.model.site.removing_slots(SCHEDULE, at(25, 15, 0), ChangeScope::All);
    edit(&mut client, all.unwrap());
    assert!(planned(&client, 14).is_empty());
}

#[test]
fn a_rule_is_cut_in_two_and_keeps_its_slots() {
    let rules = [
        Recurrence::Every { first: at(23, 6, 0), interval: Span::from_secs_f64(2.0 * 86_400.0) },
        Recurrence::Rule { first: at(23, 6, 0), rule: "FREQ=WEEKLY;BYDAY=MO,WE,FR".into() },
        weekdays(),
    ];
    for recurrence in rules {
        let mut client = client(recurrence.clone());
        let before = planned(&client, 20);
        for slot in before[1..].iter().copied() {
            let (new, wanted) = client.model.site.splitting_schedule(SCHEDULE, slot).unwrap();
            edit(&mut client, wanted);
            assert_eq!(planned(&client, 20), before, "{recurrence:?} cut at {slot:?}");
            let site = client.model.site.site().unwrap();
            assert_eq!(
                first_slot(&site.schedule(new).unwrap().recurrence).map(|at| at.date),
                Some(slot.date)
            );
            client.command(ClientCommand::Undo);
        }
    }
    let mut hourly =
        client(Recurrence::Every { first: at(23, 6, 0), interval: Span::from_secs_f64(3_600.0) });
    assert!(hourly.model.site.splitting_schedule(SCHEDULE, at(23, 8, 0)).is_none());
    hourly.take_effects();
}

#[test]
fn a_mission_that_is_dropped_makes_a_weekly_schedule() {
    let mut client = client(Recurrence::Once(at(1, 0, 0)));
    let (id, wanted) = client.model.site.adding_schedule(MISSION, at(24, 9, 45)).unwrap();
    edit(&mut client, wanted);
    assert_eq!(
        planned(&client, 14),
        [at(24, 9, 45), LocalDateTime { date: date(2026, 12, 1), ..at(24, 9, 45) }]
    );
    assert_eq!(client.model.site.site().unwrap().schedule(id).unwrap().name, "Round A");
}

#[test]
fn where_clocks_change_the_plan_says_so() {
    let recurrence = Recurrence::Weekly {
        days: [Weekday::Sunday].into(),
        times: vec![LocalTime { hour: 1, minute: 30 }],
        first_day: date(2026, 1, 1),
        last_day: None,
    };
    let client = client(recurrence);
    let zone = SiteZone::new("Europe/London").unwrap();
    let begin = Utc(day_number(date(2026, 3, 23)) * 86_400_000_000_000);
    let plan = plan_schedules(
        client.model.site.site().unwrap(),
        &zone,
        begin,
        Utc(begin.0 + 7 * 86_400_000_000_000),
    );
    let [only] = plan.occurrences.as_slice() else { panic!("{plan:?}") };
    assert_eq!(only.change, ClockChange::Skipped);
    assert_eq!(zone.to_local(only.due).time, LocalTime { hour: 2, minute: 30 });
}

#[test]
fn occurrences_that_meet_are_found_also_behind_one_that_is_skipped() {
    let occurrence = |minute: i64, state| Occurrence {
        schedule: SCHEDULE,
        mission: MISSION,
        slot: local_of(minute),
        due: Utc(minute * 60_000_000_000),
        change: ClockChange::None,
        state,
    };
    let planned = OccurrenceState::Planned;
    let list = [
        occurrence(0, planned),
        occurrence(5, OccurrenceState::Skipped),
        occurrence(10, planned),
        occurrence(40, planned),
    ];
    let minutes = |number: f64| move |_| Span::from_secs_f64(60.0 * number);
    assert_eq!(conflicts_of(&list, minutes(15.0)), [(0, 2)]);
    assert_eq!(conflicts_of(&list, minutes(31.0)), [(0, 2), (2, 3)]);
    assert_eq!(conflicts_of(&list, minutes(10.0)), []);
}

#[test]
fn a_week_begins_on_monday() {
    assert_eq!(week_of(date(2026, 11, 24)), date(2026, 11, 23));
    assert_eq!(week_of(date(2026, 11, 23)), date(2026, 11, 23));
    assert_eq!(week_of(date(2027, 1, 1)), date(2026, 12, 28));
    assert_eq!(minute_number(at(24, 1, 30)) - minute_number(at(23, 0, 0)), 25 * 60 + 30);
}

#[test]
fn what_crosses_midnight_is_cut_and_what_overlaps_is_side_by_side() {
    let span = |start_min, length_min| ShownSpan { start_min, length_min };
    // Tuesday 23:30 to Wednesday 00:30, and two in that Wednesday.
    let segments =
        lay_out_week(&[span(2 * 1_440 - 30, 60), span(2 * 1_440 + 15, 30), span(2 * 1_440 + 30, 30)]);
    let of = |segment: &DaySegment| (segment.span, segment.day, segment.from_min, segment.to_min);
    assert_eq!(
        segments.iter().map(of).collect::<Vec<_>>(),
        [(0, 1, 1_410, 1_440), (0, 2, 0, 30), (1, 2, 15, 45), (2, 2, 30, 60)]
    );
    assert_eq!(
        segments.iter().map(|it| (it.lane, it.lanes)).collect::<Vec<_>>(),
        [(0, 1), (0, 2), (1, 2), (0, 2)],
        "the third begins where the first has ended"
    );
    assert!(segments[0].continues && !segments[0].is_continued);
    assert!(segments[1].is_continued && !segments[1].continues);
    let over = lay_out_week(&[span(-20, 30), span(7 * 1_440 - 10, 30), span(-50, 20)]);
    assert_eq!(over.iter().map(of).collect::<Vec<_>>(), [(0, 0, 0, 10), (1, 6, 1_430, 1_440)]);
}

#[test]
fn missions_and_schedules_are_saved_to_a_file_and_loaded_as_one_step() {
    let mut first = client(weekdays());
    first.take_effects();
    first.command(ClientCommand::SavePlanFile);
    let effects = first.take_effects();
    let [ClientEffect::SavePlanFile(file)] = effects.as_slice() else { panic!("{effects:?}") };
    let load = |client: &mut TestClient, result: Result<PlanFile, String>| {
        client.apply(ClientEvent::PlanFileRead { name: "plan.json".into(), result });
    };
    load(&mut first, Ok(file.clone()));
    assert_eq!(first.model.notices().visible().len(), 1, "it has all of it already");

    let mut second = TestClient::connected();
    second.event(Event::SitePart(SiteParts::new(Arc::new(SiteState::default())).next_part()));
    load(&mut second, Ok(file.clone()));
    assert_eq!(planned(&second, 14), planned(&first, 14));
    second.command(ClientCommand::Undo);
    assert!(planned(&second, 14).is_empty());
    load(&mut second, Ok(PlanFile { format_version: 99, ..file.clone() }));
    load(&mut second, Err("It is no plan.".into()));
    assert_eq!(second.model.notices().visible().len(), 2);
}
