//! Runs of missions: their states, what they have planned, and the commands of people. Plain data, for robot, ledger and browser.

use crate::{
    ActionRequest, FailurePolicy, LocalDateTime, MissionEnd, MissionId, MonitorId, NodeId, ObjectId,
    Revision, RunId, ScheduleId, TaskId,
};
use serde::{Deserialize, Serialize};
use vocab::CommandId;

/// State of a run. The last five are outcomes: nothing comes after them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RunState {
    /// It waits for its turn.
    Queued,
    /// Its tasks are done.
    Running,
    /// A person, a stop of motion or a monitor has paused it. A person resumes it.
    Paused,
    /// A monitor has interrupted it. It goes on by itself.
    Suspended,
    /// The program was restarted. It goes on by itself once the robot's place is known.
    Restarted,
    /// Its outcome is decided. The robot finishes its action and goes where the run ends.
    Ending,
    /// All tasks succeeded.
    Succeeded,
    /// Some tasks succeeded.
    PartiallySucceeded,
    /// No task succeeded.
    Failed,
    /// A person ended it.
    Cancelled,
    /// A monitor or a schedule ended it.
    Interrupted,
}

impl RunState {
    /// All states.
    pub const ALL: [Self; 11] = [
        Self::Queued,
        Self::Running,
        Self::Paused,
        Self::Suspended,
        Self::Restarted,
        Self::Ending,
        Self::Succeeded,
        Self::PartiallySucceeded,
        Self::Failed,
        Self::Cancelled,
        Self::Interrupted,
    ];

    /// Whether the run has ended.
    pub fn is_outcome(self) -> bool {
        self >= Self::Succeeded
    }
}

/// State of a task in a run. The last four are outcomes; only a redo comes after them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TaskState {
    /// It has not begun.
    Waiting,
    /// The robot goes to its place.
    Navigating,
    /// Its action is performed.
    Running,
    /// The robot was on its way when the run was paused.
    Paused,
    /// An attempt has failed. It is tried again, or a person is asked.
    Retriable,
    /// It was done.
    Succeeded,
    /// It could not be done.
    Failed,
    /// A person, or an answer that nobody gave in time, left it out.
    Skipped,
    /// The run ended before it was done.
    Cancelled,
}

impl TaskState {
    /// All states.
    pub const ALL: [Self; 9] = [
        Self::Waiting,
        Self::Navigating,
        Self::Running,
        Self::Paused,
        Self::Retriable,
        Self::Succeeded,
        Self::Failed,
        Self::Skipped,
        Self::Cancelled,
    ];

    /// Whether the task has ended.
    pub fn is_outcome(self) -> bool {
        self >= Self::Succeeded
    }
}

/// What led to a run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RunCause {
    /// A person or program asked for it, of whom no account is known: nobody has to sign in there, or an earlier program did not keep it.
    Command(CommandId),
    /// A schedule was due.
    Schedule {
        /// Which.
        schedule: ScheduleId,
        /// Its slot.
        slot: LocalDateTime,
    },
    /// A monitor interrupts with it.
    Monitor(MonitorId),
    /// A person or program asked for it that has signed in.
    Account {
        /// The command.
        command: CommandId,
        /// Name of the account.
        account: String,
    },
}

impl RunCause {
    /// Of a run that a command asks for.
    pub fn of_command(command: &MissionCommand) -> Self {
        let id = command.id;
        match command.account.clone() {
            Some(account) => Self::Account { command: id, account },
            None => Self::Command(id),
        }
    }
}

/// What a run does. It is made when the run begins, and later edits of the site do not change it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunPlan {
    /// In the order in which they are done.
    pub tasks: Vec<PlannedTask>,
    /// The objects that it was made from, with their revisions.
    pub revisions: Vec<(ObjectId, Revision)>,
    /// Where the robot goes afterwards.
    pub end: MissionEnd,
}

/// A task with all that it needs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlannedTask {
    /// The task of the mission.
    pub task: TaskId,
    /// Where it is done; none if the site has no such place.
    pub node: Option<NodeId>,
    /// What is done there; none: it is only visited.
    pub request: Option<ActionRequest>,
    /// Whether the action can be repeated without harm.
    pub is_idempotent: bool,
    /// What happens if the place cannot be reached.
    pub on_unreachable: FailurePolicy,
    /// What happens if the action fails.
    pub on_action_failure: FailurePolicy,
}

/// Where the robot goes before a run ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EndPlace {
    /// It stays where it is.
    Here,
    /// To the nearest dock.
    NearestDock,
    /// To this node.
    Node(NodeId),
}

/// A command of a person or program. Repeating an id does nothing.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MissionCommand {
    /// Made by the client.
    pub id: CommandId,
    /// Account of who gives it; none: nobody has to sign in there.
    pub account: Option<String>,
    /// What is asked.
    pub kind: MissionCommandKind,
}

/// What can be asked of missions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MissionCommandKind {
    /// Run a mission.
    Start {
        /// Made by the client.
        run: RunId,
        /// Which mission.
        mission: MissionId,
        /// When.
        mode: StartMode,
    },
    /// Pause a run: the robot stands. An action that was begun is finished.
    Pause(RunId),
    /// Go on with a paused run.
    Resume(RunId),
    /// Leave a task out. Its action is cancelled.
    SkipTask(RunId, TaskId),
    /// Do a task again. Its earlier results are kept.
    RedoTask(RunId, TaskId),
    /// End a run: the current action is finished, and the robot stays where it is.
    Cancel(RunId),
    /// End a run at once: the current action is cancelled.
    Abort(RunId),
    /// Answer the open question of a run.
    Answer(RunId, TaskId, QuestionAnswer),
}

/// When a run that was asked for begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StartMode {
    /// Now, or not at all.
    Now,
    /// When those before it have ended, and nothing blocks it.
    Queue,
}

/// Answers to the question what becomes of a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum QuestionAnswer {
    /// It is tried again.
    TryAgain,
    /// It is skipped.
    Skip,
    /// The run ends, and the robot goes to a dock.
    EndAtDock,
    /// The run ends where the robot is.
    EndHere,
}
