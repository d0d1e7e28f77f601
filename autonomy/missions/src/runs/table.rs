//! The states of runs and tasks and all their transitions, as data. `docs/missions.md` is printed from it, and [`super::MissionRunner`] applies it.

use site_model::{RunState, TaskState};

/// A row of [`RUN_TABLE`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RunTransition {
    /// State in which the event is expected.
    pub from: RunState,
    /// The event.
    pub trigger: RunTrigger,
    /// State afterwards. None: the outcome of the run.
    pub to: Option<RunState>,
    /// Actions in order of execution.
    pub actions: &'static [RunAction],
}

/// An event of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum RunTrigger {
    /// Its turn has come.
    Begin,
    /// Its turn has come, and the site lacks its mission.
    MissionMissing,
    /// A person or a monitor pauses it.
    PauseRequested,
    /// A person resumes it.
    ResumeRequested,
    /// Motion was stopped, or the robot was driven by hand or sent elsewhere.
    MotionTaken,
    /// A monitor interrupts it.
    InterruptBegan,
    /// A monitor interrupts it and drops it.
    InterruptDrops,
    /// No monitor interrupts any more.
    InterruptEnded,
    /// A person cancels it.
    CancelRequested,
    /// A person aborts it.
    AbortRequested,
    /// A schedule replaces it.
    Replaced,
    /// No task is left.
    TasksDone,
    /// A task ends it, and the robot goes to a dock.
    TaskEndsAtDock,
    /// A task ends it where the robot is.
    TaskEndsHere,
    /// The robot has finished its action and is where the run ends, or does not get there.
    EndReached,
    /// The program was restarted.
    ProgramRestarted,
    /// The robot's place is known.
    PlaceKnown,
}

/// An action of a run's transition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RunAction {
    /// Stop walking to the task. An action that was begun is finished.
    PauseTask,
    /// Stop walking, and cancel the action.
    InterruptTask,
    /// Stop walking, and cancel the action. The task ends.
    StopTask,
    /// Stop walking. The task ends, except that an action that was begun is finished.
    FinishTask,
    /// The outcome is that of the tasks; the robot goes where the mission ends.
    GoToEnd,
    /// The outcome is that of the tasks; the robot goes to a dock.
    GoToDock,
    /// The outcome is that of the tasks; the robot stays.
    Stay,
    /// The outcome is "cancelled", unless it was decided before; the robot stays.
    EndCancelled,
    /// The outcome is "interrupted", unless it was decided before; the robot stays.
    EndInterrupted,
    /// All tasks that have not ended are cancelled.
    CancelTasks,
}

/// A row of [`TASK_TABLE`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TaskTransition {
    /// State in which the event is expected.
    pub from: TaskState,
    /// The event.
    pub trigger: TaskTrigger,
    /// Additional condition.
    pub guard: TaskGuard,
    /// State afterwards.
    pub to: TaskState,
    /// Actions in order of execution.
    pub actions: &'static [TaskAction],
}

/// An event of a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum TaskTrigger {
    /// It is its turn.
    SetOut,
    /// The robot has left its dock.
    Undocked,
    /// The place was reached.
    Reached,
    /// The place was not reached.
    ReachFailed,
    /// The action was done.
    ActionSucceeded,
    /// The action failed.
    ActionFailed,
    /// The action was cancelled.
    ActionCancelled,
    /// It is not known how the goal or the action ended.
    OutcomeUnknown,
    /// It is not known how an action on the way ended, which cannot be repeated without harm.
    RouteActionUnknown,
    /// The run is paused.
    RunPaused,
    /// The run is interrupted.
    RunInterrupted,
    /// The run ends, and waits for an action that was begun.
    RunFinishes,
    /// The run ends at once.
    RunStops,
    /// A person leaves it out.
    SkipRequested,
    /// A person wants it done again.
    RedoRequested,
    /// The answer is to try again.
    AnsweredTryAgain,
    /// The answer is to leave it out.
    AnsweredSkip,
    /// The answer is to end the run.
    AnsweredEnd,
}

/// A condition of a task's transition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TaskGuard {
    /// No condition.
    Always,
    /// Something is done at the place.
    WithAction,
    /// The place is only visited.
    WithoutAction,
    /// The policy has attempts left.
    RetriesLeft,
    /// The policy tries it later, which has not happened yet.
    TriesLater,
    /// The policy asks a person.
    Asks,
    /// The policy goes on without it.
    GoesOn,
    /// The policy ends the run at a dock.
    EndsAtDock,
    /// The policy ends the run here.
    EndsHere,
    /// The action can be repeated without harm.
    Idempotent,
    /// It cannot.
    NotIdempotent,
    /// It was cancelled because a person leaves the task out.
    ForSkip,
    /// It was cancelled because the run ends.
    ForEnd,
    /// It was cancelled because the run is interrupted.
    ForInterrupt,
}

/// An action of a task's transition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TaskAction {
    /// Request the goal, once this is durable.
    RequestGoal,
    /// Call the action, once this is durable.
    CallAction,
    /// Cancel the goal.
    CancelGoal,
    /// Cancel the action; the task changes when that has ended.
    CancelAction,
    /// Ask a person.
    Ask,
    /// End the run at a dock.
    EndRunAtDock,
    /// End the run here.
    EndRunHere,
}

use RunAction::{
    CancelTasks, EndCancelled, EndInterrupted, FinishTask, GoToDock, GoToEnd, InterruptTask, PauseTask, Stay,
    StopTask,
};
use RunState as Run;
use RunTrigger as On;
use TaskAction::{Ask, CallAction, CancelAction, CancelGoal, EndRunAtDock, EndRunHere, RequestGoal};
use TaskGuard::{
    Always, Asks, EndsAtDock, EndsHere, ForEnd, ForInterrupt, ForSkip, GoesOn, Idempotent, NotIdempotent,
    RetriesLeft, TriesLater, WithAction, WithoutAction,
};
use TaskState as Task;
use TaskTrigger as At;

/// Every transition of a run. An event without a row changes nothing.
pub const RUN_TABLE: &[RunTransition] = &[
    run(Run::Queued, On::Begin, Some(Run::Running), &[]),
    run(Run::Queued, On::MissionMissing, Some(Run::Failed), &[]),
    run(Run::Queued, On::CancelRequested, Some(Run::Cancelled), &[]),
    run(Run::Queued, On::AbortRequested, Some(Run::Cancelled), &[]),
    run(Run::Running, On::PauseRequested, Some(Run::Paused), &[PauseTask]),
    run(Run::Running, On::MotionTaken, Some(Run::Paused), &[PauseTask]),
    run(Run::Running, On::InterruptBegan, Some(Run::Suspended), &[InterruptTask]),
    run(Run::Running, On::InterruptDrops, Some(Run::Ending), &[EndInterrupted, StopTask]),
    run(Run::Running, On::CancelRequested, Some(Run::Ending), &[EndCancelled, FinishTask]),
    run(Run::Running, On::AbortRequested, Some(Run::Ending), &[EndCancelled, StopTask]),
    run(Run::Running, On::Replaced, Some(Run::Ending), &[EndInterrupted, FinishTask]),
    run(Run::Running, On::TasksDone, Some(Run::Ending), &[GoToEnd]),
    run(Run::Running, On::TaskEndsAtDock, Some(Run::Ending), &[GoToDock]),
    run(Run::Running, On::TaskEndsHere, Some(Run::Ending), &[Stay]),
    run(Run::Running, On::ProgramRestarted, Some(Run::Restarted), &[]),
    run(Run::Paused, On::ResumeRequested, Some(Run::Running), &[]),
    run(Run::Paused, On::TaskEndsAtDock, Some(Run::Ending), &[GoToDock]),
    run(Run::Paused, On::TaskEndsHere, Some(Run::Ending), &[Stay]),
    run(Run::Paused, On::CancelRequested, Some(Run::Ending), &[EndCancelled, FinishTask]),
    run(Run::Paused, On::AbortRequested, Some(Run::Ending), &[EndCancelled, StopTask]),
    run(Run::Paused, On::Replaced, Some(Run::Ending), &[EndInterrupted, FinishTask]),
    run(Run::Suspended, On::InterruptEnded, Some(Run::Running), &[]),
    run(Run::Suspended, On::TaskEndsAtDock, Some(Run::Ending), &[GoToDock]),
    run(Run::Suspended, On::TaskEndsHere, Some(Run::Ending), &[Stay]),
    run(Run::Suspended, On::PauseRequested, Some(Run::Paused), &[]),
    run(Run::Suspended, On::CancelRequested, Some(Run::Ending), &[EndCancelled, FinishTask]),
    run(Run::Suspended, On::AbortRequested, Some(Run::Ending), &[EndCancelled, StopTask]),
    run(Run::Suspended, On::Replaced, Some(Run::Ending), &[EndInterrupted, FinishTask]),
    run(Run::Restarted, On::PlaceKnown, Some(Run::Running), &[]),
    run(Run::Restarted, On::PauseRequested, Some(Run::Paused), &[]),
    run(Run::Restarted, On::CancelRequested, Some(Run::Ending), &[EndCancelled, FinishTask]),
    run(Run::Restarted, On::AbortRequested, Some(Run::Ending), &[EndCancelled, StopTask]),
    run(Run::Restarted, On::Replaced, Some(Run::Ending), &[EndInterrupted, FinishTask]),
    run(Run::Ending, On::InterruptBegan, Some(Run::Ending), &[GoToDock]),
    run(Run::Ending, On::CancelRequested, Some(Run::Ending), &[EndCancelled, FinishTask]),
    run(Run::Ending, On::AbortRequested, Some(Run::Ending), &[EndCancelled, StopTask]),
    run(Run::Ending, On::EndReached, None, &[CancelTasks]),
    run(Run::Ending, On::MotionTaken, None, &[CancelTasks]),
];

/// Every transition of a task. The first row that fits is taken. An event without a row changes nothing.
pub const TASK_TABLE: &[TaskTransition] = &[
    task(Task::Waiting, At::SetOut, Always, Task::Navigating, &[RequestGoal]),
    task(Task::Paused, At::SetOut, Always, Task::Navigating, &[RequestGoal]),
    task(Task::Retriable, At::SetOut, Always, Task::Navigating, &[RequestGoal]),
    task(Task::Navigating, At::Undocked, Always, Task::Navigating, &[RequestGoal]),
    task(Task::Navigating, At::Reached, WithAction, Task::Running, &[CallAction]),
    task(Task::Navigating, At::Reached, WithoutAction, Task::Succeeded, &[]),
    task(Task::Navigating, At::ReachFailed, RetriesLeft, Task::Retriable, &[]),
    task(Task::Navigating, At::ReachFailed, TriesLater, Task::Retriable, &[]),
    task(Task::Navigating, At::ReachFailed, Asks, Task::Retriable, &[Ask]),
    task(Task::Navigating, At::ReachFailed, GoesOn, Task::Failed, &[]),
    task(Task::Navigating, At::ReachFailed, EndsAtDock, Task::Failed, &[EndRunAtDock]),
    task(Task::Navigating, At::ReachFailed, EndsHere, Task::Failed, &[EndRunHere]),
    task(Task::Navigating, At::OutcomeUnknown, Always, Task::Waiting, &[]),
    task(Task::Navigating, At::RouteActionUnknown, Always, Task::Retriable, &[Ask]),
    task(Task::Navigating, At::RunPaused, Always, Task::Paused, &[CancelGoal]),
    task(Task::Navigating, At::RunInterrupted, Always, Task::Waiting, &[CancelGoal]),
    task(Task::Navigating, At::RunFinishes, Always, Task::Cancelled, &[CancelGoal]),
    task(Task::Navigating, At::RunStops, Always, Task::Cancelled, &[CancelGoal]),
    task(Task::Navigating, At::SkipRequested, Always, Task::Skipped, &[CancelGoal]),
    task(Task::Running, At::ActionSucceeded, Always, Task::Succeeded, &[]),
    task(Task::Running, At::ActionFailed, RetriesLeft, Task::Retriable, &[]),
    task(Task::Running, At::ActionFailed, TriesLater, Task::Retriable, &[]),
    task(Task::Running, At::ActionFailed, Asks, Task::Retriable, &[Ask]),
    task(Task::Running, At::ActionFailed, GoesOn, Task::Failed, &[]),
    task(Task::Running, At::ActionFailed, EndsAtDock, Task::Failed, &[EndRunAtDock]),
    task(Task::Running, At::ActionFailed, EndsHere, Task::Failed, &[EndRunHere]),
    task(Task::Running, At::ActionCancelled, ForSkip, Task::Skipped, &[]),
    task(Task::Running, At::ActionCancelled, ForEnd, Task::Cancelled, &[]),
    task(Task::Running, At::ActionCancelled, ForInterrupt, Task::Waiting, &[]),
    task(Task::Running, At::OutcomeUnknown, Idempotent, Task::Waiting, &[]),
    task(Task::Running, At::OutcomeUnknown, NotIdempotent, Task::Retriable, &[Ask]),
    task(Task::Running, At::RunInterrupted, Always, Task::Running, &[CancelAction]),
    task(Task::Running, At::RunStops, Always, Task::Running, &[CancelAction]),
    task(Task::Running, At::SkipRequested, Always, Task::Running, &[CancelAction]),
    task(Task::Waiting, At::SkipRequested, Always, Task::Skipped, &[]),
    task(Task::Paused, At::SkipRequested, Always, Task::Skipped, &[]),
    task(Task::Retriable, At::SkipRequested, Always, Task::Skipped, &[]),
    task(Task::Retriable, At::AnsweredTryAgain, Always, Task::Waiting, &[]),
    task(Task::Retriable, At::AnsweredSkip, Always, Task::Skipped, &[]),
    task(Task::Retriable, At::AnsweredEnd, Always, Task::Failed, &[]),
    task(Task::Waiting, At::RunStops, Always, Task::Cancelled, &[]),
    task(Task::Paused, At::RunStops, Always, Task::Cancelled, &[]),
    task(Task::Retriable, At::RunStops, Always, Task::Cancelled, &[]),
    task(Task::Succeeded, At::RedoRequested, Always, Task::Waiting, &[]),
    task(Task::Failed, At::RedoRequested, Always, Task::Waiting, &[]),
    task(Task::Skipped, At::RedoRequested, Always, Task::Waiting, &[]),
];

const fn run(
    from: RunState,
    trigger: RunTrigger,
    to: Option<RunState>,
    actions: &'static [RunAction],
) -> RunTransition {
    RunTransition { from, trigger, to, actions }
}

const fn task(
    from: TaskState,
    trigger: TaskTrigger,
    guard: TaskGuard,
    to: TaskState,
    actions: &'static [TaskAction],
) -> TaskTransition {
    TaskTransition { from, trigger, guard, to, actions }
}
