//! Schedules in the panel.

use super::texts;
use crate::test_support::{TestClient, click, value};
use crate::{PageClock, screens};
use api::{Event, SiteParts, SiteState};
use client_model::{ChangeScope, ClientCommand, ClientEvent, ClientTime, ScheduleSelection};
use egui::{Key, Modifiers, PointerButton, Pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use missions::day_number;
use site_model::{
    EditId, EndedRun, LocalDate, LocalDateTime, LocalTime, Mission, MissionId, MissionStatus, Object,
    Recurrence, RunCause, RunId, RunState, RunStatus, Schedule, ScheduleId, Site, SiteSettings, Utc, Weekday,
};
use std::sync::Arc;
use uuid::Uuid;

pub(crate) const MISSION: MissionId = MissionId(Uuid::from_u128(11));
pub(crate) const SCHEDULE: ScheduleId = ScheduleId(Uuid::from_u128(21));

fn at(day: u8, hour: u8, minute: u8) -> LocalDateTime {
    LocalDateTime { date: LocalDate { year: 2026, month: 11, day }, time: LocalTime { hour, minute } }
}

fn mission(number: u128, name: &str) -> Object {
    Object::Mission(Mission {
        id: MissionId(Uuid::from_u128(number)),
        name: name.into(),
        tasks: Vec::new(),
        order: Default::default(),
        order_constraints: Vec::new(),
        end: Default::default(),
    })
}

/// Weekdays at 11:00 and 15:00.
fn weekdays() -> Recurrence {
    Recurrence::Weekly {
        days: [Weekday::Monday, Weekday::Tuesday, Weekday::Wednesday, Weekday::Thursday, Weekday::Friday]
            .into(),
        times: vec![LocalTime { hour: 11, minute: 0 }, LocalTime { hour: 15, minute: 0 }],
        first_day: at(1, 0, 0).date,
        last_day: None,
    }
}

fn settings(zone: &str) -> Object {
    Object::Settings(SiteSettings { name: "B1 hall".into(), time_zone: zone.into(), map: None })
}

/// A client on the Schedule screen, Tuesday 2026-11-24 at 13:25 UTC, whose operator is in `zone`.
pub(crate) fn client(objects: Vec<Object>, zone: &str) -> TestClient {
    let mut site = Site::default();
    for (number, object) in objects.into_iter().enumerate() {
        let id = EditId(Uuid::from_u128(number as u128));
        let edit = site.put(id, object);
        site.apply(&edit, id).unwrap();
    }
    let state = SiteState { site, ..SiteState::default() };
    let mut client = TestClient::connected()
        .event(Event::SitePart(SiteParts::new(Arc::new(state)).next_part()))
        .on(screens::SCHEDULE);
    let minutes = day_number(at(24, 0, 0).date) * 1_440 + 13 * 60 + 25;
    client.panels.clock =
        PageClock { utc: Utc(minutes * 60_000_000_000), utc_offset_s: 0, zone: zone.into() };
    client
}

fn usual() -> TestClient {
    let schedule = Schedule::new(SCHEDULE, "Round A, weekdays".into(), MISSION, weekdays());
    let objects = vec![
        settings("Europe/London"),
        mission(11, "Round A"),
        mission(12, "Gamma survey"),
        Object::Schedule(schedule),
    ];
    client(objects, "Europe/London")
}

type Shown<'a> = Harness<'a, TestClient>;

/// Carries out what the panels emitted.
fn carry_out(harness: &mut Shown<'_>) {
    let client = harness.state_mut();
    for command in std::mem::take(&mut client.commands) {
        client.model.handle_event(ClientTime(1.0), ClientEvent::Command(command), &mut Vec::new());
    }
    harness.run_steps(2);
}

fn press(harness: &mut Shown<'_>, name: &str) {
    click(harness, name);
    carry_out(harness);
}

fn pointer(harness: &mut Shown<'_>, position: Pos2, pressed: Option<bool>) {
    harness.event(egui::Event::PointerMoved(position));
    if let Some(pressed) = pressed {
        let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
        harness.event(egui::Event::PointerButton { pos: position, button, pressed, modifiers });
    }
    harness.run_steps(1);
}

/// Drags from one position to another, without letting go.
fn drag(harness: &mut Shown<'_>, from: Pos2, to: Pos2) {
    pointer(harness, from, None);
    pointer(harness, from, Some(true));
    for share in [0.3, 0.7, 1.0] {
        pointer(harness, from + share * (to - from), None);
    }
}

fn slots(harness: &Shown<'_>) -> Vec<Recurrence> {
    let site = harness.state().model.site.site().unwrap();
    site.schedules().map(|schedule| schedule.recurrence.clone()).collect()
}

fn position(harness: &Shown<'_>, name: &str) -> Pos2 {
    harness.get_by_label(name).rect().center()
}

/// Height of a quarter of an hour in the grid, points.
const QUARTER: f32 = 12.0;
const WEDNESDAY: &str = "Round A, weekdays, Wed 25 Nov, 15:00, planned";

#[test]
fn the_week_shows_each_occurrence_with_its_state() {
    let harness = usual().shown(1440.0, 900.0);
    for name in [
        WEDNESDAY,
        "Round A, weekdays, Mon 23 Nov, 11:00, past",
        "Round A, weekdays, Fri 27 Nov, 11:00, planned",
    ] {
        assert!(harness.query_by_label(name).is_some(), "{name}");
    }
    assert!(harness.query_by_label_contains("Sat 28 Nov").is_none());
    assert_eq!(value(&harness, "Site time"), "13:25, Europe/London");
    assert!(harness.query_by_label("Your time").is_none(), "the same zone");
    let (early, late) =
        (position(&harness, "Round A, weekdays, Wed 25 Nov, 11:00, planned"), position(&harness, WEDNESDAY));
    assert!((late.y - early.y - 16.0 * QUARTER).abs() < 1.0, "four hours");
}

#[test]
fn another_time_zone_is_told_apart() {
    let mut client = usual();
    client.panels.clock.zone = "Asia/Kolkata".into();
    let harness = client.shown(1440.0, 900.0);
    assert_eq!(value(&harness, "Your time"), "18:55, Asia/Kolkata");
    assert!(harness.query_by_label(WEDNESDAY).is_some(), "the grid has the time of the site");
}

#[test]
fn a_drag_asks_which_occurrences_are_meant_and_is_one_step_of_undo() {
    let mut harness = usual().shown(1440.0, 900.0);
    let from = position(&harness, WEDNESDAY);
    drag(&mut harness, from, from + egui::vec2(0.0, 2.3 * QUARTER));
    let to = from + egui::vec2(0.0, 2.3 * QUARTER);
    pointer(&mut harness, to, Some(false));
    harness.run_steps(1);
    assert!(harness.query_by_label("All").is_some());
    let before = slots(&harness);
    press(&mut harness, "This one");
    assert!(harness.query_by_label("This one").is_none());
    let moved = Recurrence::Once(at(25, 15, 30));
    assert!(slots(&harness).contains(&moved), "{:?}", slots(&harness));
    harness.state_mut().commands.push(ClientCommand::Undo);
    carry_out(&mut harness);
    assert_eq!(slots(&harness), before);
}

#[test]
fn escape_cancels_a_drag_and_does_not_stop_the_robot() {
    let mut harness = usual().shown(1440.0, 900.0);
    let from = position(&harness, WEDNESDAY);
    drag(&mut harness, from, from + egui::vec2(120.0, 40.0));
    harness.key_press(Key::Escape);
    harness.run_steps(2);
    pointer(&mut harness, from + egui::vec2(120.0, 40.0), Some(false));
    carry_out(&mut harness);
    assert!(harness.query_by_label("This one").is_none());
    assert_eq!(slots(&harness), [weekdays()]);
    assert!(!harness.state().emitted(&ClientCommand::StopMotion));
}

#[test]
fn arrow_keys_move_an_occurrence_and_enter_drops_it() {
    let mut harness = usual().shown(1440.0, 900.0);
    press(&mut harness, WEDNESDAY);
    let selected = ScheduleSelection { schedule: SCHEDULE, slot: Some(at(25, 15, 0)) };
    assert_eq!(harness.state().model.schedule.selection(), Some(selected));
    for key in [Key::ArrowRight, Key::ArrowDown, Key::ArrowDown, Key::Enter] {
        harness.key_press(key);
        harness.run_steps(2);
    }
    press(&mut harness, "All");
    let [Recurrence::Weekly { days, times, .. }] = &slots(&harness)[..] else { panic!() };
    assert!(!days.contains(&Weekday::Wednesday) && days.contains(&Weekday::Thursday));
    assert_eq!(times[1], LocalTime { hour: 15, minute: 30 });
}

#[test]
fn a_mission_is_dragged_into_the_week_or_pressed() {
    let mut harness = usual().shown(1440.0, 900.0);
    let row = position(&harness, "Schedule mission Gamma survey");
    let wednesday = position(&harness, "Round A, weekdays, Wed 25 Nov, 11:00, planned");
    // Two hours earlier, where the pointer is at the beginning of the block.
    let to = wednesday - egui::vec2(0.0, 9.0 * QUARTER);
    drag(&mut harness, row, to);
    pointer(&mut harness, to, Some(false));
    carry_out(&mut harness);
    let made = slots(&harness);
    let expected = Recurrence::Weekly {
        days: [Weekday::Wednesday].into(),
        times: vec![LocalTime { hour: 9, minute: 0 }],
        first_day: at(25, 0, 0).date,
        last_day: None,
    };
    assert!(made.contains(&expected), "{made:?}");
    assert!(harness.query_by_label("Gamma survey, Wed 25 Nov, 09:00, planned").is_some());
    press(&mut harness, "All schedules");
    press(&mut harness, "Schedule mission Round A");
    assert_eq!(slots(&harness).len(), 3, "pressed: at the next whole hour");
}

#[test]
fn an_occurrence_is_skipped_and_a_schedule_paused_ended_and_deleted() {
    let mut harness = usual().shown(1440.0, 900.0);
    press(&mut harness, WEDNESDAY);
    press(&mut harness, "Skip this one");
    assert!(harness.query_by_label("Round A, weekdays, Wed 25 Nov, 15:00, skipped").is_some());
    press(&mut harness, "Run it after all");
    press(&mut harness, "Skip next");
    assert!(harness.query_by_label("Round A, weekdays, Tue 24 Nov, 15:00, skipped").is_some());
    press(&mut harness, "Pause schedule");
    assert!(harness.query_by_label("Round A, weekdays, Wed 25 Nov, 15:00, paused").is_some());
    press(&mut harness, "Resume schedule");
    press(&mut harness, "Delete schedule");
    press(&mut harness, "This and following");
    let [Recurrence::Weekly { last_day, .. }] = &slots(&harness)[..] else { panic!() };
    assert_eq!(*last_day, Some(at(25, 0, 0).date), "that at 11:00 stays");
    press(&mut harness, "Open schedule Round A, weekdays");
    press(&mut harness, "Delete schedule");
    assert!(slots(&harness).is_empty());
}

#[test]
fn days_times_and_policies_are_chosen() {
    let mut harness = usual().shown(1440.0, 2_000.0);
    press(&mut harness, "Open schedule Round A, weekdays");
    press(&mut harness, "Sat");
    press(&mut harness, "Mon");
    press(&mut harness, "Time 1: later");
    press(&mut harness, "Remove 15:00");
    press(&mut harness, "Add a time");
    let [Recurrence::Weekly { days, times, .. }] = &slots(&harness)[..] else { panic!() };
    assert!(days.contains(&Weekday::Saturday) && !days.contains(&Weekday::Monday));
    assert_eq!(times[..], [LocalTime { hour: 11, minute: 15 }, LocalTime { hour: 15, minute: 15 }]);
    press(&mut harness, "Replace");
    press(&mut harness, "Run all");
    press(&mut harness, "1 h");
    let site = harness.state().model.site.site().unwrap();
    let schedule = site.schedule(SCHEDULE).unwrap();
    assert_eq!(schedule.overlap, site_model::OverlapPolicy::Replace);
    assert_eq!(schedule.missed, site_model::MissedSlots::RunAll);
    assert_eq!(schedule.grace.secs_f64(), 3_600.0);
    press(&mut harness, "Once");
    assert!(matches!(slots(&harness)[..], [Recurrence::Once(_)]));
    press(&mut harness, "Interval");
    press(&mut harness, "Interval: later");
    assert!(matches!(slots(&harness)[..], [Recurrence::Every { .. }]));
}

#[test]
fn the_agenda_lists_what_is_due_and_files_are_saved_and_loaded() {
    let mut harness = usual().shown(1440.0, 1_400.0);
    press(&mut harness, "Agenda");
    assert!(harness.query_by_label("Round A, weekdays, Fri 4 Dec, 11:00, planned").is_some());
    assert!(harness.query_by_label_contains("23 Nov").is_none(), "nothing that has passed");
    click(&mut harness, "Save to a file");
    assert!(harness.state().emitted(&ClientCommand::SavePlanFile));
    click(&mut harness, "Load from a file");
    assert!(harness.state().emitted(&ClientCommand::LoadPlanFile));
}

#[test]
fn a_slot_that_ran_shows_how_its_run_ended() {
    let run = RunId(Uuid::from_u128(31));
    let report = RunStatus {
        run,
        mission: MISSION,
        cause: RunCause::Schedule { schedule: SCHEDULE, slot: at(24, 11, 0) },
        state: RunState::Running,
        outcome: None,
        began: None,
        tasks: Vec::new(),
        question: None,
    };
    let running = MissionStatus { runs: vec![report], ..MissionStatus::default() };
    let ended = EndedRun { run, mission: MISSION, outcome: RunState::Failed };
    let mut client = usual().event(Event::Missions(running));
    client = client.event(Event::Missions(MissionStatus { ended: vec![ended], ..MissionStatus::default() }));
    let harness = client.shown(1440.0, 900.0);
    assert!(harness.query_by_label("Round A, weekdays, Tue 24 Nov, 11:00, failed").is_some());
    assert!(harness.query_by_label("Round A, weekdays, Mon 23 Nov, 11:00, past").is_some(), "nobody saw it");
}

#[test]
fn occurrences_that_meet_are_told_with_a_way_out() {
    let other = Recurrence::Once(at(25, 15, 0));
    let objects = vec![
        mission(11, "Round A"),
        mission(12, "Gamma survey"),
        Object::Schedule(Schedule::new(SCHEDULE, "Round A".into(), MISSION, weekdays())),
        Object::Schedule(Schedule::new(
            ScheduleId(Uuid::from_u128(22)),
            "Gamma survey".into(),
            MissionId(Uuid::from_u128(12)),
            other,
        )),
    ];
    let mut harness = client(objects, "UTC").shown(1440.0, 1_200.0);
    let sentence = "Wed 25 Nov, 15:00: Round A is due at the same time. Gamma survey waits.";
    assert!(harness.query_by_label(sentence).is_some());
    press(&mut harness, "Move Gamma survey to 15:15");
    assert!(slots(&harness).contains(&Recurrence::Once(at(25, 15, 15))));
    assert!(harness.query_by_label(sentence).is_none());
}

#[test]
fn a_narrow_window_lists_what_is_due() {
    let mut harness = usual().shown(390.0, 844.0);
    assert!(harness.query_by_label("Round A, weekdays, Tue 24 Nov, 15:00, planned").is_some());
    assert!(harness.query_by_label("Week").is_some(), "the card's name");
    click(&mut harness, "Schedule");
    assert!(harness.query_by_label("Open schedule Round A, weekdays").is_some());
}

#[test]
fn an_empty_site_says_what_to_do_first() {
    let harness = client(Vec::new(), "UTC").shown(1440.0, 900.0);
    assert!(harness.query_by_label(texts::NO_MISSIONS).is_some());
    let harness = client(vec![settings("Atlantis")], "UTC").shown(1440.0, 900.0);
    assert!(harness.query_by_label_contains("There is no time zone \"Atlantis\"").is_some());
}

#[test]
fn the_grid_and_the_drawer_fit_a_tablet() {
    let mut harness = usual().shown(1024.0, 768.0);
    assert!(harness.query_by_label(WEDNESDAY).is_some());
    click(&mut harness, "Open panel");
    assert!(harness.query_by_label("Open schedule Round A, weekdays").is_some());
}

#[test]
fn sentences_of_recurrences_read_as_people_say_them() {
    let weekly = |days: &[Weekday], times: &[u8]| Recurrence::Weekly {
        days: days.iter().copied().collect(),
        times: times.iter().map(|hour| LocalTime { hour: *hour, minute: 0 }).collect(),
        first_day: at(1, 0, 0).date,
        last_day: None,
    };
    assert_eq!(texts::recurrence(&weekdays()), "Mon to Fri at 11:00 and 15:00");
    let all: Vec<Weekday> = texts::DAYS.iter().map(|(_, day)| *day).collect();
    assert_eq!(texts::recurrence(&weekly(&all, &[6, 12, 18])), "Every day at 06:00, 12:00 and 18:00");
    let two = [Weekday::Monday, Weekday::Thursday];
    assert_eq!(texts::recurrence(&weekly(&two, &[9])), "Mon and Thu at 09:00");
    assert_eq!(texts::recurrence(&Recurrence::Once(at(25, 9, 0))), "Once, Wed 25 Nov 2026 at 09:00");
    assert_eq!(texts::scope(ChangeScope::This), "This one");
}
