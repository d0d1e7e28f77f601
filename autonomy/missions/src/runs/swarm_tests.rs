//! Seeded swarms: random commands, outcomes, batteries, stops and restarts, with invariants checked after each step.

use super::interface::{ActionResult, MissionEffect, MissionInput, RouteGoalResult};
use super::records::Records;
use super::testing::*;
use site_model::*;
use std::collections::{BTreeMap, BTreeSet};
use uuid::Uuid;
use vocab::{ActionCallId, GoalId, Span};

/// SplitMix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut hash = self.0;
        hash = (hash ^ (hash >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        hash = (hash ^ (hash >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        hash ^ (hash >> 31)
    }

    fn below(&mut self, count: u64) -> u64 {
        self.next() % count
    }

    fn chance(&mut self, percent: u64) -> bool {
        self.below(100) < percent
    }
}

/// What must hold whatever happens.
#[derive(Default)]
struct Invariants {
    checked: usize,
    goals: BTreeSet<GoalId>,
    intended: BTreeSet<ActionCallId>,
    ended: BTreeMap<RunId, RunState>,
    slots: BTreeSet<(ScheduleId, LocalDateTime)>,
    /// Tasks whose action was called, and that cannot be repeated; with whether its outcome is known or a person wants it again.
    calls: BTreeMap<(RunId, TaskId), bool>,
    outcomes: usize,
    repeats: usize,
}

impl Invariants {
    /// Checks what was durable and what was done since the last call.
    fn check(&mut self, rig: &mut Rig) {
        for event in &rig.durable[self.checked..] {
            self.check_event(event);
        }
        self.checked = rig.durable.len();
        for effect in std::mem::take(&mut rig.seen) {
            match effect {
                MissionEffect::RequestGoal { goal, .. } => {
                    assert!(self.goals.contains(&goal), "{goal} was requested before that was durable");
                }
                MissionEffect::CallAction { call, run, task, request } => {
                    assert!(self.intended.contains(&call), "{call} was called before that was durable");
                    if request.action == "spectrum" {
                        let before = self.calls.insert((run, task), false);
                        assert_ne!(
                            before,
                            Some(false),
                            "{task} of {run} was repeated without a person's word"
                        );
                        self.repeats += usize::from(before.is_some());
                    }
                }
                _ => {}
            }
        }
        let records = rig.runner.records();
        let active =
            records.runs.values().filter(|run| !matches!(run.state, RunState::Queued | RunState::Suspended));
        assert!(active.count() <= 1, "two runs at once");
        for run in records.runs.values() {
            assert!(!run.state.is_outcome(), "{run:?}");
            let busy = run
                .tasks
                .iter()
                .filter(|task| matches!(task.state, TaskState::Navigating | TaskState::Running));
            assert!(busy.count() <= 1, "two tasks at once: {run:?}");
        }
        // An action that does not end after it was cancelled is given up.
        let is_acting = rig.call.as_ref().is_some_and(|(.., is_cancelled)| !is_cancelled);
        assert!(rig.goal.is_none() || !is_acting, "a goal and an action at once");
        if rig.waiting.is_empty() {
            let again = Records::from_events(&super::events_for_restart(&rig.durable));
            // The numbers of queued runs count fewer runs, but have the same order.
            assert_eq!(again.runs.keys().collect::<Vec<_>>(), records.runs.keys().collect::<Vec<_>>());
            for (run, other) in again.runs.values().zip(records.runs.values()) {
                assert_eq!(
                    (run.state, &run.tasks, run.ending, run.steps),
                    (other.state, &other.tasks, other.ending, other.steps)
                );
            }
            assert_eq!(again.queue(), records.queue());
            assert_eq!(again.monitors, records.monitors);
            assert_eq!(again.ended, records.ended);
            assert_eq!(again.decided.keys().collect::<Vec<_>>(), records.decided.keys().collect::<Vec<_>>());
        }
    }

    fn check_event(&mut self, event: &MissionEvent) {
        let run = match &event.kind {
            MissionEventKind::Task { run, task, step, .. } => {
                match step {
                    TaskStep::SetsOut { goal } => {
                        assert!(self.goals.insert(*goal), "a goal twice");
                    }
                    TaskStep::Acts { call } => {
                        assert!(self.intended.insert(*call), "a call twice");
                    }
                    // Its outcome is known: the program that offers it has said so.
                    TaskStep::TriesAgain(failure)
                    | TaskStep::TriesLater(failure)
                    | TaskStep::Asks(failure)
                        if *failure != TaskFailure::OutcomeUnknown =>
                    {
                        self.calls.entry((*run, *task)).and_modify(|is_known| *is_known = true);
                    }
                    // It was cancelled for an interruption, or a person wants it again.
                    TaskStep::Waits => {
                        self.calls.entry((*run, *task)).and_modify(|is_known| *is_known = true);
                    }
                    step if step.state().is_outcome() => self.outcomes += 1,
                    _ => {}
                }
                *run
            }
            MissionEventKind::RunSetOutToEnd { run, goal, .. } => {
                assert!(self.goals.insert(*goal));
                *run
            }
            MissionEventKind::DockingBegan { goal, .. } => {
                assert!(self.goals.insert(*goal));
                return;
            }
            MissionEventKind::RunEnded { run, outcome } => {
                assert!(outcome.is_outcome());
                assert_eq!(self.ended.insert(*run, *outcome), None, "a run ended twice");
                return;
            }
            MissionEventKind::SlotDecided { schedule, slot, .. } => {
                assert!(self.slots.insert((*schedule, *slot)), "a slot was decided twice: {slot:?}");
                return;
            }
            MissionEventKind::RunQueued { run, .. }
            | MissionEventKind::RunBegan { run, .. }
            | MissionEventKind::RunChanged { run, .. }
            | MissionEventKind::RunEnding { run, .. }
            | MissionEventKind::QuestionAnswered { run, .. } => *run,
            _ => return,
        };
        assert!(!self.ended.contains_key(&run), "an event after the end of its run: {event:?}");
    }
}

fn random_policy(random: &mut Random) -> FailurePolicy {
    let time_limit = Span::from_millis(30_000);
    let then = match random.below(7) {
        0 | 1 => FailureStep::Skip,
        2 => FailureStep::TryLater,
        3 => FailureStep::EndAtDock,
        4 => FailureStep::EndHere,
        5 => FailureStep::Ask { time_limit, default: AskDefault::Skip },
        _ => FailureStep::Ask { time_limit, default: AskDefault::EndAtDock },
    };
    policy(random.below(3) as u8, then)
}

fn random_mission(number: u128, random: &mut Random) -> Mission {
    let count = 1 + random.below(5) as u128;
    let tasks = (1..=count).map(|index| {
        let action = [Some("photo"), Some("spectrum"), None][random.below(3) as usize];
        let node = 2 + u128::from(random.below(5));
        task(number, index, node, action, [random_policy(random), random_policy(random)])
    });
    let tasks = tasks.collect();
    let end = [MissionEnd::NearestDock, MissionEnd::Stay, MissionEnd::Node(crate::testing::node_id(4))];
    mission(number, tasks, end[random.below(3) as usize])
}

fn random_schedule(number: u128, random: &mut Random) -> Schedule {
    let overlaps = [OverlapPolicy::Skip, OverlapPolicy::Queue, OverlapPolicy::Replace];
    let missed = [MissedSlots::Skip, MissedSlots::RunOnce, MissedSlots::RunAll];
    let date = LocalDate { year: 2026, month: 3, day: 28 };
    Schedule {
        id: ScheduleId(Uuid::from_u128(80 + number)),
        name: format!("Schedule {number}"),
        mission: mission_id(number),
        recurrence: Recurrence::Every {
            first: LocalDateTime { date, time: LocalTime { hour: 0, minute: 0 } },
            interval: Span::from_millis(60_000 * (7 + random.below(30) as i64)),
        },
        is_paused: false,
        skipped: Vec::new(),
        grace: Span::from_millis(900_000),
        missed: missed[random.below(3) as usize],
        overlap: overlaps[random.below(3) as usize],
        priority: random.below(3) as i32,
    }
}

/// 2026-03-28 22:00 UTC: three hours before clocks go forward in London.
const BEGIN_NS: i64 = 1_774_735_200_000_000_000;

fn step(rig: &mut Rig, random: &mut Random, seconds: &mut i64) {
    let run = run_id(1 + u128::from(random.below(12)));
    let known: Vec<(RunId, Vec<TaskId>)> = {
        let runs = rig.runner.records().runs.values();
        runs.map(|run| (run.id, run.tasks.iter().map(|task| task.planned.task).collect())).collect()
    };
    let (known_run, tasks) =
        known.get(random.below(known.len().max(1) as u64) as usize).cloned().unwrap_or((run, Vec::new()));
    let task = tasks.get(random.below(tasks.len().max(1) as u64) as usize).copied().unwrap_or(task_id(1, 1));
    match random.below(100) {
        0..4 => {
            let mission = mission_id(1 + u128::from(random.below(3)));
            let mode = if random.chance(50) { StartMode::Now } else { StartMode::Queue };
            let run = run_id(rig.commands + 100);
            rig.command(MissionCommandKind::Start { run, mission, mode });
        }
        4 => rig.command(MissionCommandKind::Pause(known_run)),
        5..8 => rig.command(MissionCommandKind::Resume(known_run)),
        8 => rig.command(MissionCommandKind::Cancel(known_run)),
        9 => rig.command(MissionCommandKind::Abort(known_run)),
        10 => rig.command(MissionCommandKind::SkipTask(known_run, task)),
        11 => rig.command(MissionCommandKind::RedoTask(known_run, task)),
        12..15 => {
            let answers = [
                QuestionAnswer::TryAgain,
                QuestionAnswer::Skip,
                QuestionAnswer::EndAtDock,
                QuestionAnswer::EndHere,
            ];
            rig.command(MissionCommandKind::Answer(known_run, task, answers[random.below(4) as usize]));
        }
        15..40 => {
            let result = match random.below(10) {
                0..6 => RouteGoalResult::Reached,
                6..9 => RouteGoalResult::Failed(ReachFailure::PathBlocked),
                _ => RouteGoalResult::MotionTaken,
            };
            rig.end_goal(result);
        }
        40..60 => {
            let is_cancelled = rig.call.as_ref().is_some_and(|(.., is_cancelled)| *is_cancelled);
            let result = match random.below(10) {
                _ if is_cancelled && random.chance(70) => ActionResult::Cancelled,
                0..6 => ActionResult::Succeeded(None),
                6..9 => ActionResult::Failed("The lens is dirty.".to_owned()),
                _ => ActionResult::Unavailable,
            };
            rig.end_action(result);
        }
        60..64 => rig.set_situation(|situation| situation.can_move = !situation.can_move),
        64..67 => rig.set_situation(|situation| situation.is_localised = !situation.is_localised),
        67..71 => {
            let value = [0.1, 0.15, 0.5, 0.9, 0.95][random.below(5) as usize];
            rig.input(MissionInput::Signal { name: "battery.charge".to_owned(), value });
        }
        71..74 => rig.holds_commits = !rig.holds_commits,
        74 => rig.commit(),
        75..78 => {
            // Some of what was not durable becomes so in the last moment.
            if random.chance(50) && !rig.waiting.is_empty() {
                let (_, events) = rig.waiting.remove(0);
                rig.durable.extend(events);
            }
            rig.restart();
        }
        78 => {
            let mission = random_mission(1 + u128::from(random.below(3)), random);
            rig.put(Object::Mission(mission));
        }
        79 => {
            let schedule = random_schedule(1 + u128::from(random.below(3)), random);
            rig.put(Object::Schedule(schedule));
        }
        _ => {
            let longest = if random.chance(5) { 4_000 } else { 20 };
            let passed = 1 + random.below(longest) as i64;
            *seconds += passed;
            rig.now += Span::from_millis(1_000 * passed);
            // The clock is set back now and then.
            let step_back = if random.chance(5) { 600 } else { 0 };
            rig.clock(Utc(BEGIN_NS + (*seconds - step_back) * 1_000_000_000), random.chance(95));
        }
    }
}

#[test]
fn whatever_happens_the_invariants_hold_and_every_run_ends() {
    let (mut ended, mut slots, mut outcomes, mut repeats) = (BTreeMap::new(), 0, 0, 0);
    for seed in 0..150 {
        let mut random = Random(seed);
        let (mut rig, mut invariants, mut seconds) = (Rig::new(), Invariants::default(), 0);
        for number in 1..=3 {
            let (mission, schedule) =
                (random_mission(number, &mut random), random_schedule(number, &mut random));
            rig.put(Object::Mission(mission));
            rig.put(Object::Schedule(schedule));
        }
        for _ in 0..600 {
            step(&mut rig, &mut random, &mut seconds);
            invariants.check(&mut rig);
        }
        // Then everything goes well, and nothing new is asked for.
        rig.holds_commits = false;
        rig.commit();
        rig.set_situation(|situation| (situation.can_move, situation.is_localised) = (true, true));
        rig.input(MissionInput::Signal { name: "battery.charge".to_owned(), value: 0.95 });
        rig.wait(20);
        for _ in 0..2_000 {
            if rig.runner.records().runs.is_empty() {
                break;
            }
            let paused = rig
                .runner
                .records()
                .runs
                .values()
                .find(|run| run.state == RunState::Paused)
                .map(|run| run.id);
            if let Some(run) = paused {
                rig.command(MissionCommandKind::Resume(run));
            }
            rig.end_goal(RouteGoalResult::Reached);
            let is_cancelled = rig.call.as_ref().is_some_and(|(.., is_cancelled)| *is_cancelled);
            rig.end_action(if is_cancelled {
                ActionResult::Cancelled
            } else {
                ActionResult::Succeeded(None)
            });
            rig.wait(5);
            invariants.check(&mut rig);
        }
        assert!(rig.runner.records().runs.is_empty(), "seed {seed}: {:#?}", rig.runner.records().runs);
        for state in invariants.ended.values() {
            *ended.entry(*state).or_insert(0) += 1;
        }
        slots += invariants.slots.len();
        outcomes += invariants.outcomes;
        repeats += invariants.repeats;
    }
    println!("{ended:?}, {slots} slots, {outcomes} outcomes of tasks, {repeats} repeated on a person's word");
    assert_eq!(ended.len(), 5, "every outcome occurs: {ended:?}");
    assert!(slots > 2_000 && outcomes > 2_000 && repeats > 5);
}
