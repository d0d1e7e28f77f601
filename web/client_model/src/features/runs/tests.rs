//! Runs as the robot reports them, and what is asked of them.

use super::*;
use crate::testing::TestClient;
use api::Event;
use site_model::{EndedRun, LocalDate, LocalTime, MissionId, RouteProgress, TaskId, TaskState, TaskStatus};
use uuid::Uuid;
use vocab::GoalId;

const MISSION: MissionId = MissionId(Uuid::from_u128(1));
const RUN: RunId = RunId(Uuid::from_u128(2));
const SCHEDULE: ScheduleId = ScheduleId(Uuid::from_u128(3));

fn slot() -> LocalDateTime {
    LocalDateTime {
        date: LocalDate { year: 2026, month: 11, day: 24 },
        time: LocalTime { hour: 11, minute: 0 },
    }
}

fn task(number: u128, state: TaskState) -> TaskStatus {
    let task = TaskId(Uuid::from_u128(number));
    TaskStatus { task, node: None, action: None, state, attempt: 1, failure: None }
}

fn run(state: RunState) -> RunStatus {
    RunStatus {
        run: RUN,
        mission: MISSION,
        cause: RunCause::Schedule { schedule: SCHEDULE, slot: slot() },
        state,
        outcome: None,
        began: None,
        tasks: vec![
            task(1, TaskState::Succeeded),
            task(2, TaskState::Navigating),
            task(3, TaskState::Waiting),
        ],
        question: None,
    }
}

#[test]
fn a_run_is_followed_from_the_queue_to_its_outcome() {
    let mut client = TestClient::connected();
    assert!(client.model.runs.status().is_none());
    let queued = MissionStatus { runs: vec![run(RunState::Queued)], ..MissionStatus::default() };
    client.event(Event::Missions(queued));
    assert_eq!((client.model.runs.current(), client.model.runs.queue().count()), (None, 1));
    let running = MissionStatus { runs: vec![run(RunState::Running)], ..MissionStatus::default() };
    client.event(Event::Missions(running));
    assert_eq!(client.model.runs.current().map(|run| run.run), Some(RUN));
    assert_eq!(client.model.runs.slot(SCHEDULE, slot()), Some(RunState::Running));
    let ended = EndedRun { run: RUN, mission: MISSION, outcome: RunState::PartiallySucceeded };
    client.event(Event::Missions(MissionStatus { ended: vec![ended], ..MissionStatus::default() }));
    let past: Vec<_> = client.model.runs.past().collect();
    assert_eq!(past[0].report.map(|report| report.tasks.len()), Some(3), "its tasks are kept");
    assert_eq!(client.model.runs.slot(SCHEDULE, slot()), Some(RunState::PartiallySucceeded));
    client.lose_connection();
    client.wait(10.0);
    client.connect();
    assert!(client.model.runs.status().is_none(), "another snapshot comes");
}

#[test]
fn what_the_operator_asks_is_sent_with_ids_of_its_own() {
    let mut client = TestClient::connected();
    client.command(ClientCommand::StartMission { mission: MISSION, is_queued: false });
    client.command(ClientCommand::StartMission { mission: MISSION, is_queued: true });
    client.command(ClientCommand::Run(MissionCommandKind::Pause(RUN)));
    let commands = client.take_commands();
    let starts: Vec<_> = commands
        .iter()
        .filter_map(|command| match command {
            Command::Mission(MissionCommandKind::Start { run, mode, .. }) => Some((*run, *mode)),
            _ => None,
        })
        .collect();
    assert_eq!(starts.iter().map(|start| start.1).collect::<Vec<_>>(), [StartMode::Now, StartMode::Queue]);
    assert_ne!(starts[0].0, starts[1].0);
    assert!(commands.contains(&Command::Mission(MissionCommandKind::Pause(RUN))));
}

#[test]
fn the_remaining_time_counts_what_is_left() {
    let ids: Vec<TaskId> = (1..4).map(|number| TaskId(Uuid::from_u128(number))).collect();
    let estimate = RunEstimate {
        tasks_s: ids.iter().map(|id| (*id, 60.0)).collect(),
        actions_s: ids.iter().map(|id| (*id, 10.0)).collect(),
        end_s: 30.0,
    };
    let mut route = RouteStatus::default();
    assert_eq!(estimate.remaining_s(&run(RunState::Running), &route), 60.0 + 60.0 + 30.0);
    route.route = Some(RouteProgress {
        goal: GoalId(Uuid::nil()),
        target: site_model::NodeId(Uuid::nil()),
        edges: Vec::new(),
        remaining_s: 20.0,
        remaining_m: 15.0,
    });
    assert_eq!(estimate.remaining_s(&run(RunState::Running), &route), 20.0 + 10.0 + 60.0 + 30.0);
}
