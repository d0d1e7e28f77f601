//! The words of transcripts: missions, monitors and schedules in one line.

use super::testing::*;
use crate::testing::node_id;
use site_model::*;
use uuid::Uuid;
use vocab::Span;

pub(super) fn parse_local(text: &str) -> LocalDateTime {
    let (date, time) = text.split_once('T').expect("a time");
    let mut parts = date.split('-').chain(time.split(':')).map(|part| part.parse::<u16>().expect("digits"));
    let mut next = || parts.next().expect("a part");
    let date = LocalDate { year: next() as i16, month: next() as u8, day: next() as u8 };
    LocalDateTime { date, time: LocalTime { hour: next() as u8, minute: next() as u8 } }
}

/// `mission 1 photo@3 spectrum@4,r0,act=ask visit@5,reach=later dock@92,until=80 dock@nearest undock@here end=dock`. A task has no retries unless `r` says otherwise.
pub(super) fn parse_mission(words: &[&str]) -> Mission {
    let number: u128 = words[1].parse().expect("a number");
    let mut end = MissionEnd::Stay;
    let mut tasks = Vec::new();
    for word in &words[2..] {
        if let Some(place) = word.strip_prefix("end=") {
            end = match place {
                "dock" => MissionEnd::NearestDock,
                "here" => MissionEnd::Stay,
                node => MissionEnd::Node(node_id(node.parse().expect("a node"))),
            };
            continue;
        }
        let mut parts = word.split(',');
        let (action, place) = parts.next().and_then(|task| task.split_once('@')).expect("action@node");
        let (mut retries, mut reach, mut act) = (0, FailureStep::Skip, FailureStep::Skip);
        let mut parameters = Parameters::new();
        for option in parts {
            match option.split_once('=') {
                Some(("reach", then)) => reach = parse_step(then),
                Some(("act", then)) => act = parse_step(then),
                Some(("until", percent)) => {
                    let percent = Parameter::Integer(percent.parse().expect("a number"));
                    parameters.insert(CHARGE_PARAMETER.to_owned(), percent);
                }
                _ => retries = option.trim_start_matches('r').parse().expect("retries"),
            }
        }
        let action = Some(action).filter(|action| *action != "visit");
        let policies = [policy(retries, reach), policy(retries, act)];
        let index = tasks.len() as u128 + 1;
        tasks.push(match action {
            Some("dock" | "undock") => {
                if let Ok(dock) = place.parse() {
                    let id = Parameter::Text(dock_id(dock).to_string());
                    parameters.insert(DOCK_PARAMETER.to_owned(), id);
                }
                let request = ActionRequest { action: action.unwrap_or_default().to_owned(), parameters };
                let place = TaskPlace::ByAction { request };
                Task { place, ..task(number, index, 0, None, policies) }
            }
            action => task(number, index, place.parse().expect("a node"), action, policies),
        });
    }
    mission(number, tasks, end)
}

fn parse_step(text: &str) -> FailureStep {
    let time_limit = Span::from_millis(60_000);
    match text {
        "later" => FailureStep::TryLater,
        "dock" => FailureStep::EndAtDock,
        "here" => FailureStep::EndHere,
        "ask" => FailureStep::Ask { time_limit, default: AskDefault::Skip },
        "ask-dock" => FailureStep::Ask { time_limit, default: AskDefault::EndAtDock },
        "ask-here" => FailureStep::Ask { time_limit, default: AskDefault::EndHere },
        _ => FailureStep::Skip,
    }
}

/// `monitor 70 temperature 60 50 dock-drop`: above 60 until below 50.
pub(super) fn parse_monitor(words: &[&str]) -> Monitor {
    let number = |index: usize| words[index].parse::<f64>().expect("a number");
    let response = match words[5] {
        "dock" => MonitorResponse::GoToDock { afterwards: Resumption::Resume },
        "dock-drop" => MonitorResponse::GoToDock { afterwards: Resumption::Drop },
        "pause" => MonitorResponse::Pause,
        "block" => MonitorResponse::BlockMissions,
        "notify" => MonitorResponse::Notify,
        mission => MonitorResponse::Interrupt {
            mission: mission_id(mission.parse().expect("a mission")),
            afterwards: Resumption::Resume,
        },
    };
    Monitor {
        id: MonitorId(Uuid::from_u128(number(1) as u128)),
        name: words[2].to_owned(),
        signal: words[2].to_owned(),
        condition: MonitorCondition::Above { threshold: number(3), release: number(4) },
        hold: Span::ZERO,
        response,
        is_enabled: true,
    }
}

/// `schedule 80 1 11:00 queue`, with further words `paused`, `skipped=2026-11-24T11:00`, `runall`, `skipmissed`, `priority=3`, `rule=FREQ=…`; daily from 2026.
pub(super) fn parse_schedule(words: &[&str]) -> Schedule {
    let number = |index: usize| words[index].parse::<u128>().expect("a number");
    let first = parse_local(&format!("2026-01-01T{}", words[3]));
    let mut schedule = Schedule {
        id: ScheduleId(Uuid::from_u128(number(1))),
        name: format!("Schedule {}", number(1)),
        mission: mission_id(number(2)),
        recurrence: Recurrence::Every { first, interval: Span::from_millis(86_400_000) },
        is_paused: false,
        skipped: Vec::new(),
        grace: Span::from_millis(15 * 60_000),
        missed: MissedSlots::RunOnce,
        overlap: OverlapPolicy::Queue,
        priority: 0,
    };
    for word in &words[4..] {
        match word.split_once('=') {
            Some(("skipped", slot)) => schedule.skipped.push(parse_local(slot)),
            Some(("priority", priority)) => schedule.priority = priority.parse().expect("a number"),
            Some(("rule", rule)) => schedule.recurrence = Recurrence::Rule { first, rule: rule.to_owned() },
            Some(("every", minutes)) => {
                let minutes: i64 = minutes.parse().expect("a number");
                schedule.recurrence =
                    Recurrence::Every { first, interval: Span::from_millis(minutes * 60_000) };
            }
            _ => match *word {
                "skip" => schedule.overlap = OverlapPolicy::Skip,
                "replace" => schedule.overlap = OverlapPolicy::Replace,
                "paused" => schedule.is_paused = true,
                "runall" => schedule.missed = MissedSlots::RunAll,
                "skipmissed" => schedule.missed = MissedSlots::Skip,
                "queue" => {}
                other => panic!("no such word: {other}"),
            },
        }
    }
    schedule
}
