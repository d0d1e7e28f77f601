//! The state table of the executive, as data.

use messages::{CancelCause, ExecutiveEvent, ExecutiveState, GoalFailure};
use std::fmt::Write;

/// One row of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transition {
    /// State in which the event is expected.
    pub from: ExecutiveState,
    /// The event.
    pub event: ExecutiveEvent,
    /// Additional condition.
    pub guard: Guard,
    /// State afterwards.
    pub to: ExecutiveState,
    /// Actions in order of execution.
    pub actions: &'static [Action],
}

/// A condition of a transition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Guard {
    /// No condition.
    Always,
    /// Motion was stopped before the program started, and nobody has allowed it since.
    StopIsKept,
    /// A saved map is in use, and the running goal needs the pose in it.
    GoalNeedsPose,
    /// A saved map is in use, and the running goal is to find the pose in it.
    GoalFindsPose,
    /// A saved map is in use.
    InSavedMap,
    /// No saved map is in use.
    NotInSavedMap,
}

/// An action of a transition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Refuse the command because motion is stopped.
    Refuse,
    /// Command the robot to stop immediately.
    StopRobot,
    /// Stand still from now on.
    StandBehaviour,
    /// Move with the commanded velocity.
    Drive,
    /// Accept the goal and begin its behaviour.
    BeginGoal,
    /// End the running goal as cancelled.
    CancelGoal(CancelReason),
    /// End the running goal as succeeded.
    SucceedGoal,
    /// End the running goal as failed, with the behaviour's reason.
    FailGoal,
    /// End the running goal as failed, with this reason.
    FailGoalBecause(GoalFailure),
    /// Suspend the running goal and search for the pose.
    SuspendGoal,
    /// Resume the suspended goal.
    ResumeGoal,
    /// Restart the search for the pose.
    RestartSearch,
}

/// Cause of a cancellation by a transition. [`CancelCause`] also names the goal that replaces the cancelled one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CancelReason {
    /// [`CancelCause::Requested`].
    Requested,
    /// [`CancelCause::MotionStopped`].
    MotionStopped,
    /// [`CancelCause::DrivenByHand`].
    DrivenByHand,
    /// [`CancelCause::Replaced`].
    Replaced,
}

impl CancelReason {
    /// The cause to publish. `by` is the goal that replaces the cancelled one.
    pub(crate) fn cause(self, by: Option<vocab::GoalId>) -> CancelCause {
        match (self, by) {
            (Self::Replaced, Some(goal)) => CancelCause::Replaced(goal),
            (Self::Requested | Self::Replaced, _) => CancelCause::Requested,
            (Self::MotionStopped, _) => CancelCause::MotionStopped,
            (Self::DrivenByHand, _) => CancelCause::DrivenByHand,
        }
    }
}

use Action::{
    BeginGoal, CancelGoal, Drive, FailGoal, FailGoalBecause, Refuse, RestartSearch, ResumeGoal,
    StandBehaviour, StopRobot, SucceedGoal, SuspendGoal,
};
use CancelReason::{DrivenByHand, MotionStopped, Replaced, Requested};
use ExecutiveEvent as On;
use ExecutiveState::{Executing, Idle, ManualDriving, Recovering, Stopped};
use GoalFailure::MapReplaced;
use Guard::{Always, GoalFindsPose, GoalNeedsPose, InSavedMap, NotInSavedMap, StopIsKept};

/// Every transition. The first row that fits is taken. An event without a row changes nothing.
pub const TABLE: &[Transition] = &[
    row(Idle, On::Started, StopIsKept, Stopped, &[StandBehaviour]),
    row(Stopped, On::StopRequested, Always, Stopped, &[StandBehaviour, StopRobot]),
    row(ManualDriving, On::StopRequested, Always, Stopped, &[StandBehaviour, StopRobot]),
    row(
        Recovering,
        On::StopRequested,
        Always,
        Stopped,
        &[CancelGoal(MotionStopped), StandBehaviour, StopRobot],
    ),
    row(
        Executing,
        On::StopRequested,
        Always,
        Stopped,
        &[CancelGoal(MotionStopped), StandBehaviour, StopRobot],
    ),
    row(Idle, On::StopRequested, Always, Stopped, &[StandBehaviour, StopRobot]),
    row(Stopped, On::MotionAllowed, Always, Idle, &[]),
    row(Stopped, On::VelocityCommanded, Always, Stopped, &[Refuse]),
    row(ManualDriving, On::VelocityCommanded, Always, ManualDriving, &[Drive]),
    row(Recovering, On::VelocityCommanded, Always, ManualDriving, &[CancelGoal(DrivenByHand), Drive]),
    row(Executing, On::VelocityCommanded, Always, ManualDriving, &[CancelGoal(DrivenByHand), Drive]),
    row(Idle, On::VelocityCommanded, Always, ManualDriving, &[Drive]),
    row(ManualDriving, On::VelocityTimedOut, Always, Idle, &[StopRobot]),
    row(ManualDriving, On::LeaseLost, Always, Idle, &[StopRobot]),
    row(Stopped, On::GoalRequested, Always, Stopped, &[Refuse]),
    row(ManualDriving, On::GoalRequested, Always, Executing, &[BeginGoal]),
    row(Recovering, On::GoalRequested, Always, Executing, &[CancelGoal(Replaced), BeginGoal]),
    row(Executing, On::GoalRequested, Always, Executing, &[CancelGoal(Replaced), BeginGoal]),
    row(Idle, On::GoalRequested, Always, Executing, &[BeginGoal]),
    row(Recovering, On::CancelRequested, Always, Idle, &[CancelGoal(Requested), StopRobot]),
    row(Executing, On::CancelRequested, Always, Idle, &[CancelGoal(Requested), StopRobot]),
    row(Executing, On::BehaviourSucceeded, Always, Idle, &[SucceedGoal, StopRobot]),
    row(Executing, On::BehaviourFailed, Always, Idle, &[FailGoal, StopRobot]),
    row(Recovering, On::BehaviourSucceeded, Always, Idle, &[SucceedGoal, StopRobot]),
    row(Recovering, On::BehaviourFailed, Always, Idle, &[FailGoal, StopRobot]),
    row(Executing, On::PoseLost, GoalNeedsPose, Recovering, &[SuspendGoal, StopRobot]),
    row(Recovering, On::PoseFound, Always, Executing, &[ResumeGoal]),
    row(Executing, On::OdometryRestarted, GoalNeedsPose, Recovering, &[SuspendGoal, StopRobot]),
    row(Executing, On::OdometryRestarted, GoalFindsPose, Executing, &[RestartSearch, StopRobot]),
    row(Recovering, On::OdometryRestarted, InSavedMap, Recovering, &[RestartSearch, StopRobot]),
    row(Executing, On::OdometryRestarted, NotInSavedMap, Idle, &[FailGoalBecause(MapReplaced), StopRobot]),
    row(Recovering, On::OdometryRestarted, NotInSavedMap, Idle, &[FailGoalBecause(MapReplaced), StopRobot]),
    row(Executing, On::MapReplaced, Always, Idle, &[FailGoalBecause(MapReplaced), StopRobot]),
    row(Recovering, On::MapReplaced, Always, Idle, &[FailGoalBecause(MapReplaced), StopRobot]),
];

const fn row(
    from: ExecutiveState,
    event: ExecutiveEvent,
    guard: Guard,
    to: ExecutiveState,
    actions: &'static [Action],
) -> Transition {
    Transition { from, event, guard, to, actions }
}

/// States with descriptions, in order of precedence.
const STATES: [(ExecutiveState, &str); 5] = [
    (Stopped, "A person has stopped motion. The robot stands until a person allows motion again."),
    (
        ManualDriving,
        "A person drives the robot by hand. Each velocity is valid until the next one, or until the watchdog time has passed.",
    ),
    (
        Recovering,
        "The pose in the saved map was lost during a goal. The goal waits while the robot searches for its pose.",
    ),
    (
        Executing,
        "The robot executes a goal. For a goal on the topological map it also stands and waits between two legs.",
    ),
    (Idle, "The robot stands and is free to move."),
];

/// Events with descriptions.
const EVENTS: [(ExecutiveEvent, &str); 14] = [
    (On::Started, "The program has started. The robot stands and is in the state Idle until then."),
    (On::StopRequested, "A person stops motion. This needs no lease."),
    (On::MotionAllowed, "A person allows motion again."),
    (On::VelocityCommanded, "A velocity has arrived from the person who drives by hand."),
    (On::VelocityTimedOut, "No velocity has arrived for the watchdog time of the robot profile."),
    (On::LeaseLost, "The control lease has passed to another person, or was returned. Goals continue."),
    (
        On::GoalRequested,
        "A person or a mission requests a goal, and its behaviour can begin. A goal that cannot begin is refused.",
    ),
    (On::CancelRequested, "A person or a mission cancels the running goal."),
    (
        On::BehaviourSucceeded,
        "The goal is reached: its behaviour says so, or whoever decides the legs of a goal on the topological map.",
    ),
    (
        On::BehaviourFailed,
        "The goal is given up: its behaviour says so, or whoever decides the legs of a goal on the topological map.",
    ),
    (On::PoseLost, "Localisation has lost the pose in the saved map."),
    (On::PoseFound, "Localisation has found the pose in the saved map and has no reason to doubt it."),
    (
        On::OdometryRestarted,
        "Odometry has restarted. Its new frame has no known relation to the previous one.",
    ),
    (On::MapReplaced, "Another map is in use, or no map is in use, or the map's frame has moved."),
];

/// The text of `docs/executive.md`.
pub fn to_markdown() -> String {
    let mut text = String::from(
        "# The executive's state table\n\nPrinted from `autonomy/executive/src/table.rs` by its test; do not edit. The first row that fits is taken. An event \
         without a row changes nothing.\n\n## States, the first in precedence first\n\n| state | meaning |\n| --- | --- |\n",
    );
    for (state, meaning) in STATES {
        let _ = writeln!(text, "| {state:?} | {meaning} |");
    }
    text.push_str("\n## Events\n\n| event | meaning |\n| --- | --- |\n");
    for (event, meaning) in EVENTS {
        let _ = writeln!(text, "| {event:?} | {meaning} |");
    }
    text.push_str(
        "\n## Transitions\n\n| from | event | condition | to | actions |\n| --- | --- | --- | --- | --- |\n",
    );
    for Transition { from, event, guard, to, actions } in TABLE {
        let guard = guard.text();
        let actions: Vec<_> = actions.iter().map(|action| action.text()).collect();
        let _ = writeln!(text, "| {from:?} | {event:?} | {guard} | {to:?} | {} |", actions.join("; "));
    }
    text
}

impl Guard {
    fn text(self) -> &'static str {
        match self {
            Always => "",
            StopIsKept => "motion was stopped before and not allowed since",
            GoalNeedsPose => "in a saved map, goal needs the pose",
            GoalFindsPose => "in a saved map, goal is to find the pose",
            InSavedMap => "in a saved map",
            NotInSavedMap => "not in a saved map",
        }
    }
}

impl Action {
    fn text(self) -> &'static str {
        match self {
            Refuse => "refuse the command",
            StopRobot => "stop the robot immediately",
            StandBehaviour => "stand still",
            Drive => "drive",
            BeginGoal => "begin the goal",
            CancelGoal(Requested) => "cancel the goal (requested)",
            CancelGoal(MotionStopped) => "cancel the goal (motion stopped)",
            CancelGoal(DrivenByHand) => "cancel the goal (driven by hand)",
            CancelGoal(Replaced) => "cancel the goal (replaced)",
            SucceedGoal => "end the goal (succeeded)",
            FailGoal => "end the goal (failed)",
            FailGoalBecause(MapReplaced) => "end the goal (failed: map replaced)",
            FailGoalBecause(_) => "end the goal (failed)",
            SuspendGoal => "suspend the goal; search for the pose",
            ResumeGoal => "resume the goal",
            RestartSearch => "restart the search for the pose",
        }
    }
}
