//! The plan of a long deployment, faster than time.

use super::interface::{ActionResult, MissionInput, RouteGoalResult};
use super::testing::*;
use crate::calendar::SiteZone;
use site_model::*;
use std::collections::BTreeMap;
use uuid::Uuid;
use vocab::Span;

/// Time between two values of the clock.
const STEP_S: i64 = 5;

#[test]
fn seven_weeks_of_two_missions_on_each_weekday() {
    let mut rig = Rig::new();
    let nodes = [3, 4, 5, 6, 5, 4, 3, 2, 3];
    let again = policy(1, FailureStep::Skip);
    let tasks = nodes
        .iter()
        .enumerate()
        .map(|(index, node)| task(1, index as u128 + 1, *node, Some("photo"), [again, again]));
    rig.put(Object::Mission(mission(1, tasks.collect(), MissionEnd::NearestDock)));
    let first_day = LocalDate { year: 2026, month: 3, day: 2 };
    let days = [Weekday::Monday, Weekday::Tuesday, Weekday::Wednesday, Weekday::Thursday, Weekday::Friday];
    let time = |hour| LocalTime { hour, minute: 0 };
    rig.put(Object::Schedule(Schedule {
        id: ScheduleId(Uuid::from_u128(80)),
        name: "Weekdays".to_owned(),
        mission: mission_id(1),
        recurrence: Recurrence::Weekly {
            days: days.into(),
            times: vec![time(11), time(15)],
            first_day,
            last_day: None,
        },
        is_paused: false,
        skipped: Vec::new(),
        grace: Span::from_millis(900_000),
        missed: MissedSlots::RunOnce,
        overlap: OverlapPolicy::Queue,
        priority: 0,
    }));
    let london = SiteZone::new("Europe/London").expect("a zone");
    let (begin, _) = london.to_utc(LocalDateTime { date: first_day, time: time(0) }).expect("a time");
    // A week of three days without power: from Tuesday of the third week, 10:00, until Thursday, 12:00.
    let off = (15 * 86_400 + 10 * 3_600)..(17 * 86_400 + 12 * 3_600);
    let (mut charge, mut busy_s, mut is_off) = (1.0_f64, 0, false);
    for step in 0..49 * 86_400 / STEP_S {
        let seconds = step * STEP_S;
        if off.contains(&seconds) {
            is_off = true;
            continue;
        }
        if std::mem::take(&mut is_off) {
            rig.restart();
        }
        rig.now += Span::from_millis(STEP_S * 1_000);
        rig.clock(Utc(begin.0 + seconds * 1_000_000_000), true);
        charge = (charge + if rig.situation.docked.is_some() { 2e-4 } else { -2e-4 } * STEP_S as f64)
            .clamp(0.0, 1.0);
        if seconds % 30 == 0 {
            rig.input(MissionInput::Signal { name: "battery.charge".to_owned(), value: charge });
        }
        // A leg and an action take 20 s each.
        busy_s = if rig.goal.is_some() || rig.call.is_some() { busy_s + STEP_S } else { 0 };
        if busy_s >= 20 {
            busy_s = 0;
            rig.end_goal(RouteGoalResult::Reached);
            rig.end_action(ActionResult::Succeeded(None));
        }
        rig.seen.clear();
    }
    let mut ended: BTreeMap<RunState, usize> = BTreeMap::new();
    let mut began = Vec::new();
    let mut skipped = Vec::new();
    for event in &rig.durable {
        match &event.kind {
            MissionEventKind::RunEnded { outcome, .. } => *ended.entry(*outcome).or_default() += 1,
            MissionEventKind::RunBegan { .. } => {
                began.push(london.to_local(event.utc.expect("a clock")).time)
            }
            MissionEventKind::SlotDecided { slot, decision: SlotDecision::Skipped(reason), .. } => {
                skipped.push((slot.date.day, slot.time.hour, *reason));
            }
            _ => {}
        }
    }
    // 35 weekdays of two slots each, of which five fell into the time without power.
    assert_eq!(ended, [(RunState::Succeeded, 65)].into(), "{ended:?}");
    assert!(
        began.iter().all(|at| [time(11), time(15)].contains(at)),
        "also after clocks went forward: {began:?}"
    );
    let missed = |day, hour| (day, hour, SkipReason::Missed);
    assert_eq!(skipped, [missed(17, 11), missed(17, 15), missed(18, 11), missed(18, 15), missed(19, 11)]);
    let distinct: std::collections::BTreeSet<_> =
        rig.calls.iter().map(|(run, task, _)| (*run, *task)).collect();
    assert_eq!((rig.calls.len(), distinct.len()), (65 * 9, 65 * 9), "each photo once");
}
