//! Transcripts: every file in `transcripts/` holds what happens (lines that begin with `>`) and what the runner makes of it. After an intended change,
//! `UPDATE_EXPECT=1 cargo test -p missions` rewrites them and `docs/missions.md`.
//!
//! The robot stands in dock 91 of a corridor: nodes 1 (dock) to 7 (dock 92), 7 m apart. `photo` can be repeated without harm, `spectrum` cannot. Commits are durable
//! at once, unless they are held. Goals are numbered `g1`, `g2` and calls `c1`, `c2` as they first occur.

use super::interface::{ActionResult, GoalRequest, MissionEffect, MissionInput, RouteGoalResult};
use super::table::{RUN_TABLE, TASK_TABLE, TaskGuard};
use super::table_text::to_markdown;
use super::testing::*;
use super::transcript_words::{parse_local, parse_mission, parse_monitor, parse_schedule};
use crate::calendar::SiteZone;
use crate::testing::edge_id;
use expect_test::{ExpectFile, expect_file};
use site_model::*;
use std::fmt::Write;
use uuid::Uuid;

fn scenarios() -> Vec<(&'static str, ExpectFile)> {
    macro_rules! files {
        ($($name:literal),* $(,)?) => {
            vec![$((include_str!(concat!("transcripts/", $name, ".txt")), expect_file![concat!("transcripts/", $name, ".txt")])),*]
        };
    }
    files![
        "to_the_end",
        "place_not_reached",
        "action_fails",
        "questions",
        "pause_and_resume",
        "skip_and_redo",
        "cancel_and_abort",
        "queue",
        "motion_is_taken",
        "battery",
        "other_monitors",
        "restart",
        "route_actions",
        "intent_before_act",
        "docks_fail",
        "dock_tasks",
        "schedules",
        "schedule_replaces",
        "missed_slots",
        "clocks_change",
    ]
}

#[test]
fn transcripts_equal_their_files_and_take_every_row_of_both_tables() {
    let mut taken = std::collections::BTreeSet::new();
    for (text, file) in scenarios() {
        let mut player = Player::new();
        let mut played = String::new();
        for line in text.lines() {
            if line.starts_with('#') {
                let _ = writeln!(played, "{line}");
            } else if let Some(command) = line.strip_prefix("> ") {
                let _ = writeln!(played, "{line}");
                played.push_str(&player.play(command));
            }
        }
        file.assert_eq(&played);
        taken.extend(player.rig.taken);
        taken.extend(player.rig.runner.taken);
    }
    let runs = (0..RUN_TABLE.len()).filter(|row| !taken.contains(&('r', *row)));
    let runs: Vec<_> = runs.map(|row| RUN_TABLE[row]).collect();
    let tasks = (0..TASK_TABLE.len()).filter(|row| !taken.contains(&('t', *row)));
    let tasks: Vec<_> = tasks.map(|row| TASK_TABLE[row]).collect();
    assert!(runs.is_empty() && tasks.is_empty(), "rows that no transcript takes: {runs:#?} {tasks:#?}");
}

#[test]
fn the_committed_page_equals_the_tables() {
    expect_file!["../../../../docs/missions.md"].assert_eq(&to_markdown());
}

#[test]
fn no_row_hides_a_later_one_and_outcomes_are_final() {
    for (number, row) in RUN_TABLE.iter().enumerate() {
        assert!(!row.from.is_outcome(), "{row:?}");
        let earlier = &RUN_TABLE[..number];
        assert!(
            !earlier.iter().any(|other| other.from == row.from && other.trigger == row.trigger),
            "{row:?}"
        );
    }
    for (number, row) in TASK_TABLE.iter().enumerate() {
        let mut earlier = TASK_TABLE[..number]
            .iter()
            .filter(|other| other.from == row.from && other.trigger == row.trigger);
        assert!(
            earlier.all(|other| other.guard != TaskGuard::Always && other.guard != row.guard),
            "an earlier row hides {row:?}"
        );
    }
    for state in RunState::ALL.into_iter().filter(|state| !state.is_outcome()) {
        assert!(RUN_TABLE.iter().any(|row| row.from == state), "{state:?} is a dead end");
    }
}

struct Player {
    rig: Rig,
    goals: Vec<vocab::GoalId>,
    calls: Vec<vocab::ActionCallId>,
}

impl Player {
    fn new() -> Self {
        let mut rig = Rig::new();
        rig.seen.clear();
        Self { rig, goals: Vec::new(), calls: Vec::new() }
    }

    fn play(&mut self, command: &str) -> String {
        let words: Vec<&str> = command.split(' ').collect();
        let number =
            |index: usize| words.get(index).and_then(|word| word.parse::<u128>().ok()).unwrap_or_default();
        let value =
            |index: usize| words.get(index).and_then(|word| word.parse::<f64>().ok()).unwrap_or_default();
        let run = run_id(number(1));
        let mission_of = |rig: &Rig, run: RunId| {
            rig.runner.records().runs.get(&run).map_or(1, |run| run.mission.0.as_u128())
        };
        let task = task_id(mission_of(&self.rig, run), number(2));
        let start = |mode| MissionCommandKind::Start { run, mission: mission_id(number(2)), mode };
        let rig = &mut self.rig;
        match words[0] {
            "mission" => {
                let mission = parse_mission(&words);
                rig.put(Object::Mission(mission));
            }
            "delete-mission" => {
                let id = EditId(Uuid::nil());
                let removal = rig.site.site().removal(id, ObjectId::Mission(mission_id(number(1))));
                rig.site.apply(&removal);
                rig.input(MissionInput::Site(std::sync::Arc::new(rig.site.site())));
            }
            "start" => rig.command(start(StartMode::Now)),
            "queue" => rig.command(start(StartMode::Queue)),
            "again" => {
                rig.commands -= 1;
                rig.command(start(StartMode::Now));
            }
            "pause" => rig.command(MissionCommandKind::Pause(run)),
            "resume" => rig.command(MissionCommandKind::Resume(run)),
            "cancel" => rig.command(MissionCommandKind::Cancel(run)),
            "abort" => rig.command(MissionCommandKind::Abort(run)),
            "skip" => rig.command(MissionCommandKind::SkipTask(run, task)),
            "redo" => rig.command(MissionCommandKind::RedoTask(run, task)),
            "answer" => {
                let answer = match words[3] {
                    "again" => QuestionAnswer::TryAgain,
                    "skip" => QuestionAnswer::Skip,
                    "dock" => QuestionAnswer::EndAtDock,
                    _ => QuestionAnswer::EndHere,
                };
                rig.command(MissionCommandKind::Answer(run, task, answer));
            }
            "reached" => rig.end_goal(RouteGoalResult::Reached),
            "blocked" => rig.end_goal(RouteGoalResult::Failed(ReachFailure::PathBlocked)),
            "not-docked" => rig.end_goal(RouteGoalResult::Failed(ReachFailure::NotDocked)),
            "stop" => {
                rig.set_situation(|situation| situation.can_move = false);
                rig.end_goal(RouteGoalResult::MotionTaken);
            }
            "allow" => rig.set_situation(|situation| situation.can_move = true),
            "taken-out" => rig.set_situation(|situation| situation.docked = None),
            "put-back" => rig.set_situation(|situation| situation.docked = Some(dock_id(number(1)))),
            "lost" => rig.set_situation(|situation| situation.is_localised = false),
            "found" => rig.set_situation(|situation| situation.is_localised = true),
            "done" => rig.end_action(ActionResult::Succeeded(Some("{}".to_owned()))),
            "fails" => rig.end_action(ActionResult::Failed("The lens is dirty.".to_owned())),
            "gone" => rig.end_action(ActionResult::Unavailable),
            "cancelled" => rig.end_action(ActionResult::Cancelled),
            "no-actions" => {
                rig.actions.clear();
                rig.input(MissionInput::Actions(rig.actions.clone()));
            }
            "route-action" => rig.want_route_action(number(1), (number(2), number(3)), words[4]),
            "route-action-cancel" => {
                let call = vocab::ActionCallId(Uuid::from_u128(20_000 + number(1)));
                rig.input(MissionInput::RouteActionCancelled(call));
            }
            "route-action-done" => rig.end_route_action(ActionResult::Succeeded(Some("{}".to_owned()))),
            "route-action-fails" => {
                rig.end_route_action(ActionResult::Failed("The door is locked.".to_owned()))
            }
            "wait" => rig.wait(number(1) as u32),
            "charge" => {
                rig.input(MissionInput::Signal { name: "battery.charge".to_owned(), value: value(1) })
            }
            "signal" => rig.input(MissionInput::Signal { name: words[1].to_owned(), value: value(2) }),
            "monitor" => rig.put(Object::Monitor(parse_monitor(&words))),
            "disable" => {
                rig.site.change_edge(number(1), number(2), |edge| edge.is_enabled = false);
                rig.input(MissionInput::Site(std::sync::Arc::new(rig.site.site())));
            }
            "hold-commits" => rig.holds_commits = true,
            "commit" => {
                rig.holds_commits = false;
                rig.commit();
            }
            "restart" => {
                rig.situation.is_localised = false;
                rig.restart();
            }
            "schedule" => rig.put(Object::Schedule(parse_schedule(&words))),
            "clock" => {
                let utc = SiteZone::utc().to_utc(parse_local(words[1])).expect("a time").0;
                rig.clock(utc, words.get(2) != Some(&"unsynchronised"));
            }
            other => panic!("no such command: {other}"),
        }
        self.print()
    }

    fn print(&mut self) -> String {
        let mut out = String::new();
        for effect in std::mem::take(&mut self.rig.seen) {
            match effect {
                MissionEffect::Commit { events, .. } => {
                    for event in events {
                        let _ = writeln!(out, "  {}", self.event(&event.kind));
                    }
                }
                MissionEffect::RequestGoal { goal, request } => {
                    let request = match request {
                        GoalRequest::Route(node) => format!("go to {}", node.0.as_u128()),
                        GoalRequest::Dock(dock) => format!("dock in {}", dock.0.as_u128()),
                        GoalRequest::Undock => "undock".to_owned(),
                    };
                    let _ = writeln!(out, "  => {}: {request}", self.goal(goal));
                }
                MissionEffect::CancelGoal(goal) => {
                    let _ = writeln!(out, "  => cancel {}", self.goal(goal));
                }
                MissionEffect::CallAction { call, request, .. } => {
                    let _ = writeln!(out, "  => {}: {}", self.call(call), request.action);
                }
                MissionEffect::CancelAction(call) => {
                    let _ = writeln!(out, "  => cancel {}", self.call(call));
                }
                MissionEffect::CallRouteAction { call, request } => {
                    let _ = writeln!(out, "  => {}: {}, on the way", self.call(call), request.action);
                }
                MissionEffect::RefuseRouteAction { call, reason } => {
                    let _ = writeln!(out, "  => {} refused: {reason}", self.call(call));
                }
                MissionEffect::Answer { refused, .. } => {
                    let _ = writeln!(out, "  => {}", refused.unwrap_or_else(|| "accepted".to_owned()));
                }
                MissionEffect::Notice(notice) => {
                    let _ =
                        writeln!(out, "  => notice: {}", crate::texts::notice(notice, &self.rig.site.site()));
                }
            }
        }
        out
    }

    fn goal(&mut self, goal: vocab::GoalId) -> String {
        format!("g{}", number_of(&mut self.goals, goal))
    }

    fn call(&mut self, call: vocab::ActionCallId) -> String {
        format!("c{}", number_of(&mut self.calls, call))
    }

    fn event(&mut self, event: &MissionEventKind) -> String {
        let run_name = run_name;
        match event {
            MissionEventKind::RunQueued { run, mission, priority, .. } => {
                format!("{} of mission {} queued, priority {priority}", run_name(*run), mission.0.as_u128())
            }
            MissionEventKind::RunBegan { run, plan } => {
                let tasks: Vec<_> =
                    plan.tasks.iter().map(|task| task_number(task.task).to_string()).collect();
                format!("{} began, tasks {}", run_name(*run), tasks.join(" "))
            }
            MissionEventKind::RunChanged { run, state, reason } => {
                let reason = match reason {
                    RunChangeReason::MonitorHolds(monitor) => format!("monitor {}", monitor_number(*monitor)),
                    other => format!("{other:?}"),
                };
                format!("{} {state:?} ({reason})", run_name(*run))
            }
            MissionEventKind::RunEnding { run, outcome, place } => {
                let place = match place {
                    EndPlace::Node(node) => format!("at {}", node.0.as_u128()),
                    other => format!("{other:?}"),
                };
                format!("{} Ending: {outcome:?}, {place}", run_name(*run))
            }
            MissionEventKind::RunSetOutToEnd { run, goal, .. } => {
                format!("{} sets out to its end, {}", run_name(*run), self.goal(*goal))
            }
            MissionEventKind::RunEnded { run, outcome } => format!("{} ended: {outcome:?}", run_name(*run)),
            MissionEventKind::Task { run, task, attempt, step } => {
                let step_text = match step {
                    TaskStep::SetsOut { goal } => format!("sets out, {}", self.goal(*goal)),
                    TaskStep::Acts { call } => format!("acts, {}", self.call(*call)),
                    TaskStep::TriesAgain(failure) => format!("tries again: {}", failure_text(failure)),
                    TaskStep::TriesLater(failure) => format!("tries later: {}", failure_text(failure)),
                    TaskStep::Asks(failure) => format!("asks: {}", failure_text(failure)),
                    TaskStep::Failed(failure) => format!("failed: {}", failure_text(failure)),
                    TaskStep::Succeeded { .. } => "succeeded".to_owned(),
                    other => format!("{other:?}").to_lowercase(),
                };
                let state = step.state();
                format!("{} task {}.{attempt} {state:?}: {step_text}", run_name(*run), task_number(*task))
            }
            MissionEventKind::RouteAction { run, call, step } => {
                let step = match step {
                    RouteActionStep::Began { place, request, task, .. } => {
                        let place = match place {
                            RouteActionPlace::Edge { edge, stage, .. } => {
                                let edge = edge.0.as_u128();
                                format!("{stage:?} of edge {}-{}", edge / 1_000, edge % 1_000)
                            }
                            RouteActionPlace::Zone(zone) => format!("zone {}", zone.0.as_u128()),
                        };
                        let task =
                            task.map_or("its end".to_owned(), |task| format!("task {}", task_number(task)));
                        format!("{}, {place}, on the way to {task}", request.action)
                    }
                    RouteActionStep::Ended(RouteActionEnd::Succeeded { .. }) => "succeeded".to_owned(),
                    RouteActionStep::Ended(RouteActionEnd::Failed(reason)) => format!("failed: {reason}"),
                    RouteActionStep::Ended(other) => format!("{other:?}").to_lowercase(),
                };
                format!("{} {}: {step}", run_name(*run), self.call(*call))
            }
            MissionEventKind::QuestionAnswered { run, task, answer, is_default } => {
                let by = if *is_default { "by default" } else { "by a person" };
                format!("{} task {} answered {by}: {answer:?}", run_name(*run), task_number(*task))
            }
            MissionEventKind::ScheduleAdopted { schedule, .. } => {
                format!("schedule {} adopted", schedule.0.as_u128())
            }
            MissionEventKind::SlotDecided { schedule, slot, due, decision } => {
                let decision = match decision {
                    SlotDecision::Run(run) => format!("runs as {}", run_name(*run)),
                    SlotDecision::Skipped(reason) => {
                        format!("skipped: {}", crate::texts::skip_reason(*reason))
                    }
                };
                let due = local_text(SiteZone::utc().to_local(*due));
                format!(
                    "schedule {} slot {} (due {due} UTC) {decision}",
                    schedule.0.as_u128(),
                    local_text(*slot)
                )
            }
            MissionEventKind::SlotsMissed { schedule, first, last, count, .. } => {
                let (first, last) = (local_text(*first), local_text(*last));
                format!("schedule {} missed {count} slots from {first} to {last}", schedule.0.as_u128())
            }
            MissionEventKind::MonitorChanged { monitor, holds } => {
                format!("monitor {} {}", monitor_number(*monitor), if *holds { "holds" } else { "ended" })
            }
            MissionEventKind::DockingBegan { dock, goal, .. } => {
                format!("a monitor sends the robot to dock {}, {}", dock.0.as_u128(), self.goal(*goal))
            }
        }
    }
}

fn number_of<T: PartialEq>(known: &mut Vec<T>, id: T) -> usize {
    known.iter().position(|other| *other == id).unwrap_or_else(|| {
        known.push(id);
        known.len() - 1
    }) + 1
}

/// Runs of people have small numbers; those of schedules and monitors do not.
fn run_name(run: RunId) -> String {
    match run.0.as_u128() {
        small @ 0..1_000 => format!("run {small}"),
        _ => "run of its own".to_owned(),
    }
}

fn monitor_number(monitor: MonitorId) -> String {
    match monitor {
        super::battery::LOW_CHARGE => "battery low".to_owned(),
        super::battery::RESERVE => "battery reserve".to_owned(),
        other => other.0.as_u128().to_string(),
    }
}

fn task_number(task: TaskId) -> u128 {
    task.0.as_u128() % 100
}

fn failure_text(failure: &TaskFailure) -> String {
    match failure {
        TaskFailure::NotReached(ReachFailure::NoRoute { closed }) => {
            let edges: Vec<_> = closed
                .iter()
                .map(|edge| edge.0.as_u128())
                .map(|edge| format!("{}-{}", edge / 1_000, edge % 1_000))
                .collect();
            assert!(
                closed
                    .iter()
                    .all(|edge| *edge == edge_id(edge.0.as_u128() / 1_000, edge.0.as_u128() % 1_000))
            );
            format!("no route, closed: {}", edges.join(" "))
        }
        TaskFailure::NotReached(reason) => format!("{reason:?}"),
        other => format!("{other:?}"),
    }
}

fn local_text(at: LocalDateTime) -> String {
    let LocalDateTime { date, time } = at;
    format!("{}-{:02}-{:02}T{:02}:{:02}", date.year, date.month, date.day, time.hour, time.minute)
}
