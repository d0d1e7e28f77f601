//! What is known of runs, schedules and monitors: all of it is rebuilt from events.

use site_model::{
    ActionRequest, AskDefault, DockId, EndPlace, FailurePolicy, FailureStep, LocalDateTime, MissionEvent,
    MissionEventKind, MissionId, MonitorId, PlannedTask, Revision, RouteActionEnd, RouteActionPlace,
    RouteActionStep, RunCause, RunId, RunPlan, RunState, ScheduleId, TaskFailure, TaskId, TaskState,
    TaskStep, Utc,
};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use vocab::{ActionCallId, CommandId, GoalId};

/// How much [`Records`] remember. It is the same wherever events are applied, because a restart has to find what the robot knew.
pub(super) struct RecordsConfig {
    /// Commands that are remembered, so that one that is repeated does nothing. Chosen: a client repeats a command within seconds, and people give fewer than one a second.
    pub(super) max_commands: usize,
    /// Runs that are remembered after their end. Chosen: two days with a run in every hour, and more.
    pub(super) max_ended: usize,
    /// Slots before the newest one by this time are not remembered one by one, days: they count as decided. More than any change of a time zone, which is a day at most.
    /// Chosen: three days, room for such changes.
    pub(super) slot_memory_days: i64,
    /// Events of slots that were due before the newest one of their schedule by this time are not read again at a restart, days. It has to be more than
    /// [`Self::slot_memory_days`] and a day, because that one counts local days: else a restart would forget slots that the robot knew. Chosen: a week and a day.
    pub(super) slots_kept_days: i64,
}

pub(super) const CONFIG: RecordsConfig =
    RecordsConfig { max_commands: 1_024, max_ended: 64, slot_memory_days: 3, slots_kept_days: 8 };

/// All records.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Records {
    /// Runs that have not ended.
    pub runs: BTreeMap<RunId, Run>,
    /// Runs that have ended lately, the newest last.
    pub ended: VecDeque<(RunId, MissionId, RunState)>,
    /// Schedules that are followed, with the revision and the instant since when.
    pub adopted: BTreeMap<ScheduleId, (Revision, Utc)>,
    /// Slots that were decided.
    pub decided: BTreeMap<ScheduleId, DecidedSlots>,
    /// Monitors whose condition holds.
    pub monitors: BTreeSet<MonitorId>,
    /// Number of the next docking for a monitor.
    pub dockings: u64,
    commands: VecDeque<CommandId>,
    queued_count: u64,
}

/// Decided slots of a schedule.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DecidedSlots {
    /// When the newest was due.
    pub newest_due: Option<Utc>,
    slots: BTreeSet<LocalDateTime>,
}

/// A run that has not ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Its id.
    pub id: RunId,
    /// Its mission.
    pub mission: MissionId,
    /// What led to it.
    pub cause: RunCause,
    /// Runs of greater priority begin first.
    pub priority: i32,
    /// Its state.
    pub state: RunState,
    /// When it began, by the calendar clock; none while it is queued, or if the time was not known.
    pub began: Option<Utc>,
    /// Its plan. None while it is queued.
    pub plan: Option<RunPlan>,
    /// Its tasks in the order of the plan.
    pub tasks: Vec<TaskRecord>,
    /// Actions on its way, in the order in which they began.
    pub route_actions: Vec<RouteActionRecord>,
    /// Its outcome, once that is decided, and where the robot goes first.
    pub ending: Option<(RunState, EndPlace)>,
    /// The task about which a person is asked.
    pub question: Option<usize>,
    /// Docks to which the robot has set out at the end.
    pub docks_tried: BTreeSet<DockId>,
    /// Number of events so far. Ids of goals and calls are made from it.
    pub steps: u64,
    /// Place among the runs in the order of their requests.
    pub number: u64,
}

/// A task of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct TaskRecord {
    /// What is done.
    pub planned: PlannedTask,
    /// The present or last attempt; 0 before the first.
    pub attempt: u32,
    /// The next attempt.
    pub next_attempt: u32,
    /// Its state.
    pub state: TaskState,
    /// Attempts that did not reach the place, since the beginning or the last redo.
    pub reach_failures: u32,
    /// Attempts whose action failed.
    pub action_failures: u32,
    /// Whether it was put behind the others.
    pub is_later: bool,
    /// Goal of the present attempt.
    pub goal: Option<GoalId>,
    /// Call of the present attempt.
    pub call: Option<ActionCallId>,
    /// All steps that say how an attempt ended, with its number. The last outcome is the result of record.
    pub results: Vec<(u32, TaskStep)>,
}

/// An action on the way of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct RouteActionRecord {
    /// The call.
    pub call: ActionCallId,
    /// What it belongs to.
    pub place: RouteActionPlace,
    /// What was called.
    pub request: ActionRequest,
    /// Whether it can be repeated without harm.
    pub is_idempotent: bool,
    /// The task to which the robot was on its way; none: to where the run ends.
    pub task: Option<TaskId>,
    /// How it ended; none: it has not.
    pub end: Option<RouteActionEnd>,
    /// Whether a person has permitted to do it again, although it is not known how it ended.
    pub may_repeat: bool,
}

impl RouteActionRecord {
    /// Whether it may have been done, must not be repeated without harm, and nobody has permitted that.
    pub(super) fn is_unknown(&self) -> bool {
        self.end == Some(RouteActionEnd::OutcomeUnknown) && !self.is_idempotent && !self.may_repeat
    }
}

impl TaskRecord {
    fn new(planned: PlannedTask) -> Self {
        Self {
            planned,
            attempt: 0,
            next_attempt: 1,
            state: TaskState::Waiting,
            reach_failures: 0,
            action_failures: 0,
            is_later: false,
            goal: None,
            call: None,
            results: Vec::new(),
        }
    }

    /// The result of record: how the task ended, with the attempt.
    pub fn result(&self) -> Option<&(u32, TaskStep)> {
        self.results.last().filter(|(_, step)| step.state().is_outcome() && self.state.is_outcome())
    }

    /// The policy for a failure, and the number of failures of its kind before it.
    pub(super) fn policy_for(&self, failure: &TaskFailure) -> (FailurePolicy, u32) {
        match failure {
            TaskFailure::NotReached(_) | TaskFailure::RouteActionUnknown(_) => {
                (self.planned.on_unreachable, self.reach_failures)
            }
            _ => (self.planned.on_action_failure, self.action_failures),
        }
    }

    /// What happens when nobody answers the question about it, and after which time.
    pub(super) fn question(&self, default_time_limit: vocab::Span) -> (vocab::Span, AskDefault) {
        let failure = self.results.last().and_then(|(_, step)| match step {
            TaskStep::Asks(failure) => Some(failure),
            _ => None,
        });
        match failure.map(|failure| self.policy_for(failure).0.then) {
            Some(FailureStep::Ask { time_limit, default })
                if !matches!(
                    failure,
                    Some(TaskFailure::OutcomeUnknown | TaskFailure::RouteActionUnknown(_))
                ) =>
            {
                (time_limit, default)
            }
            _ => (default_time_limit, AskDefault::Skip),
        }
    }

    /// Whether a person lets this task be tried again, after it was asked about because of an action on the way.
    fn permits_route_actions(&self, attempt: u32, step: &TaskStep) -> bool {
        let was_asked = self
            .results
            .iter()
            .any(|(_, step)| matches!(step, TaskStep::Asks(TaskFailure::RouteActionUnknown(_))));
        matches!(step, TaskStep::Waits) && attempt > self.attempt && was_asked
    }

    fn apply(&mut self, attempt: u32, step: &TaskStep) {
        if matches!(step, TaskStep::Waits) && attempt > self.attempt {
            // A redo.
            (self.reach_failures, self.action_failures, self.is_later) = (0, 0, false);
        }
        self.attempt = attempt;
        self.next_attempt = attempt;
        self.state = step.state();
        match step {
            TaskStep::Waits | TaskStep::Paused => (self.goal, self.call) = (None, None),
            TaskStep::SetsOut { goal } => (self.goal, self.call) = (Some(*goal), None),
            TaskStep::Acts { call } => (self.goal, self.call) = (None, Some(*call)),
            _ => {
                (self.goal, self.call) = (None, None);
                self.next_attempt = attempt + 1;
                self.results.push((attempt, step.clone()));
            }
        }
        if let TaskStep::TriesAgain(failure) | TaskStep::TriesLater(failure) | TaskStep::Asks(failure) = step
        {
            match failure {
                TaskFailure::NotReached(_) | TaskFailure::RouteActionUnknown(_) => self.reach_failures += 1,
                _ => self.action_failures += 1,
            }
        }
        self.is_later |= matches!(step, TaskStep::TriesLater(_));
    }
}

impl Run {
    /// Index of a task.
    pub fn index_of(&self, task: TaskId) -> Option<usize> {
        self.tasks.iter().position(|record| record.planned.task == task)
    }

    /// The task that is done next. Tasks that were put off come after all others.
    pub fn next_task(&self) -> Option<usize> {
        let open = |is_later: bool| {
            self.tasks.iter().position(|task| !task.state.is_outcome() && task.is_later == is_later)
        };
        open(false).or_else(|| open(true))
    }

    /// The outcome that follows from its tasks.
    pub fn outcome(&self) -> RunState {
        let succeeded = self.tasks.iter().filter(|task| task.state == TaskState::Succeeded).count();
        match succeeded {
            _ if succeeded == self.tasks.len() => RunState::Succeeded,
            0 => RunState::Failed,
            _ => RunState::PartiallySucceeded,
        }
    }
}

impl DecidedSlots {
    /// Whether a slot was decided.
    pub fn contains(&self, slot: LocalDateTime) -> bool {
        let is_forgotten = self.slots.last().is_some_and(|newest| {
            let day = |at: &LocalDateTime| crate::calendar::day_number(at.date);
            day(newest) - day(&slot) > CONFIG.slot_memory_days
        });
        is_forgotten || self.slots.contains(&slot)
    }

    fn insert(&mut self, slot: LocalDateTime, due: Utc) {
        self.slots.insert(slot);
        self.newest_due = self.newest_due.max(Some(due));
        let newest = self.slots.last().map_or(0, |newest| crate::calendar::day_number(newest.date));
        self.slots.retain(|slot| newest - crate::calendar::day_number(slot.date) <= CONFIG.slot_memory_days);
    }
}

impl Records {
    /// The records that follow from these events.
    pub fn from_events<'a>(events: impl IntoIterator<Item = &'a MissionEvent>) -> Self {
        let mut records = Self::default();
        for event in events {
            records.apply(event);
        }
        records
    }

    /// Whether a command was executed before.
    pub fn knows(&self, command: CommandId) -> bool {
        self.commands.contains(&command)
    }

    /// Queued runs in the order in which they begin.
    pub fn queue(&self) -> Vec<RunId> {
        let mut queued: Vec<&Run> = self.runs.values().filter(|run| run.state == RunState::Queued).collect();
        queued.sort_by_key(|run| (std::cmp::Reverse(run.priority), run.number));
        queued.into_iter().map(|run| run.id).collect()
    }

    /// The run that is under way: neither queued nor suspended for another one.
    pub fn active(&self) -> Option<&Run> {
        let is_active = |run: &&Run| !matches!(run.state, RunState::Queued | RunState::Suspended);
        self.runs.values().find(is_active)
    }

    /// The suspended run that goes on first: the one that was asked for last, because it interrupted the others.
    pub fn suspended(&self) -> Option<&Run> {
        let suspended = self.runs.values().filter(|run| run.state == RunState::Suspended);
        suspended.max_by_key(|run| run.number)
    }

    /// Applies an event. Events of unknown runs change nothing.
    pub fn apply(&mut self, event: &MissionEvent) {
        if let Some(command) = event.command.filter(|command| !self.knows(*command)) {
            self.commands.push_back(command);
            if self.commands.len() > CONFIG.max_commands {
                self.commands.pop_front();
            }
        }
        match &event.kind {
            MissionEventKind::RunQueued { run, mission, cause, priority } => {
                self.queued_count += 1;
                let queued = Run {
                    id: *run,
                    mission: *mission,
                    cause: cause.clone(),
                    priority: *priority,
                    state: RunState::Queued,
                    began: None,
                    plan: None,
                    tasks: Vec::new(),
                    route_actions: Vec::new(),
                    ending: None,
                    question: None,
                    docks_tried: BTreeSet::new(),
                    steps: 0,
                    number: self.queued_count,
                };
                self.runs.insert(*run, queued);
            }
            MissionEventKind::ScheduleAdopted { schedule, revision, since } => {
                self.adopted.insert(*schedule, (*revision, *since));
            }
            MissionEventKind::SlotDecided { schedule, slot, due, .. } => {
                self.decided.entry(*schedule).or_default().insert(*slot, *due);
            }
            MissionEventKind::SlotsMissed { schedule, last, last_due, .. } => {
                self.decided.entry(*schedule).or_default().insert(*last, *last_due);
            }
            MissionEventKind::MonitorChanged { monitor, holds: true } => {
                self.monitors.insert(*monitor);
            }
            MissionEventKind::MonitorChanged { monitor, holds: false } => {
                self.monitors.remove(monitor);
            }
            MissionEventKind::DockingBegan { number, .. } => self.dockings = number + 1,
            MissionEventKind::RunBegan { run, .. }
            | MissionEventKind::RunChanged { run, .. }
            | MissionEventKind::RunEnding { run, .. }
            | MissionEventKind::RunSetOutToEnd { run, .. }
            | MissionEventKind::RunEnded { run, .. }
            | MissionEventKind::Task { run, .. }
            | MissionEventKind::QuestionAnswered { run, .. }
            | MissionEventKind::RouteAction { run, .. } => self.apply_to_run(*run, event),
        }
    }

    fn apply_to_run(&mut self, id: RunId, event: &MissionEvent) {
        let Some(run) = self.runs.get_mut(&id) else { return };
        run.steps += 1;
        match &event.kind {
            MissionEventKind::RunBegan { plan, .. } => {
                run.began = event.utc;
                run.state = RunState::Running;
                run.tasks = plan.tasks.iter().cloned().map(TaskRecord::new).collect();
                run.plan = Some(plan.clone());
            }
            MissionEventKind::RunChanged { state, .. } => run.state = *state,
            MissionEventKind::RunEnding { outcome, place, .. } => {
                run.state = RunState::Ending;
                run.ending = Some((*outcome, *place));
                run.question = None;
            }
            MissionEventKind::RunSetOutToEnd { dock, .. } => run.docks_tried.extend(dock),
            MissionEventKind::Task { task, attempt, step, .. } => {
                let Some(index) = run.index_of(*task) else { return };
                if run.tasks[index].permits_route_actions(*attempt, step) {
                    run.route_actions.iter_mut().for_each(|action| action.may_repeat = true);
                }
                run.tasks[index].apply(*attempt, step);
                if matches!(step, TaskStep::Asks(_)) {
                    run.question = Some(index);
                } else if run.question == Some(index) {
                    run.question = None;
                }
            }
            MissionEventKind::QuestionAnswered { .. } => run.question = None,
            MissionEventKind::RouteAction { call, step, .. } => match step {
                RouteActionStep::Began { place, request, is_idempotent, task } => {
                    run.route_actions.push(RouteActionRecord {
                        call: *call,
                        place: *place,
                        request: request.clone(),
                        is_idempotent: *is_idempotent,
                        task: *task,
                        end: None,
                        may_repeat: false,
                    });
                }
                RouteActionStep::Ended(end) => {
                    if let Some(action) = run.route_actions.iter_mut().find(|known| known.call == *call) {
                        action.end = Some(end.clone());
                    }
                }
            },
            MissionEventKind::RunEnded { outcome, .. } => {
                let mission = run.mission;
                self.runs.remove(&id);
                self.ended.push_back((id, mission, *outcome));
                if self.ended.len() > CONFIG.max_ended {
                    self.ended.pop_front();
                }
            }
            _ => {}
        }
    }
}
